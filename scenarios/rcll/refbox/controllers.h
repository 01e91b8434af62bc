#pragma once
// Controllers of a game: programs of the jury, over TCP. They need no key, hear everything, and command the game.
//
//   are sent   what goes out on the public channel, RingInfo, MachineReportInfo; MachineInfo and RobotInfo with what
//              teams must not know; WorkpieceInfo, AttentionMessage
//   may say    SetGameState, SetGamePhase, SetTeamName, SetRobotMaintenance, SetMachineState, ConfirmDelivery

#include <map>
#include <set>
#include <string>
#include <string_view>

#include "cx/network/host.h"
#include "cx/protobuf/wire.h"
#include "scenarios/rcll/refbox/refbox_context.h"

namespace cxlab::rcll {

class Controllers {
 public:
  /// Both outlive it.
  Controllers(RefboxContext& context, net::Host& host) : context_(context), host_(host) {}

  /// An event of one of their streams.
  void take(const net::Event& event);
  /// Says what is due to them alone.
  void speak();
  SimTime next_due() const;
  void send(const google::protobuf::Message& message);
  void attention(const std::string& text, Team team);

 private:
  /// What speaks against what a controller says; empty if nothing does.
  std::string control(const Fields& message, std::string_view type);
  std::string set_machine(const std::string& machine, const std::string& state);
  /// Tells what people should look after, each once while it lasts.
  void look_after();
  pb::MessagePtr machines() const;
  pb::MessagePtr workpieces() const;

  RefboxContext& context_;
  net::Host& host_;
  std::map<net::LinkId, pb::StreamReader> streams_;
  Rate rate_, workpiece_rate_;        ///< while there are streams
  std::set<std::string> attentions_;  ///< that last
};

}  // namespace cxlab::rcll
