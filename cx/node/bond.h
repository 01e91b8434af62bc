#pragma once
// A bond of ROS: two nodes send each other heartbeats on a topic, and each notices when the other is lost.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"

namespace cxlab::cx {

/// One side of a bond. It has no timer: its node calls `act` each tick, and `next_due` says when it must.
class Bond {
 public:
  struct Options {
    std::string topic = "bond";                          ///< as the node writes it
    std::string id;                                      ///< of the bond: both sides have the same
    std::string instance;                                ///< of this side
    SimTime period{};                                    ///< between heartbeats, above 0
    SimTime timeout = std::chrono::seconds(4);           ///< without a heartbeat of the peer it is lost
    SimTime connect_timeout = std::chrono::seconds(10);  ///< without any; kNever = waits
  };
  enum class State : std::uint8_t { kWaiting, kFormed, kBroken };
  enum class Loss : std::uint8_t {
    kEnded,   ///< the peer said good-bye
    kSilent,  ///< its heartbeat did not come
    kNeverCame
  };
  /// `on_broken` is called once, when the peer is lost; not by `end`.
  static Expected<std::unique_ptr<Bond>> create(bus::Bus& bus, bus::ParticipantId node, Options options,
                                                std::function<void(Loss)> on_broken);
  ~Bond();
  Bond(const Bond&) = delete;
  Bond& operator=(const Bond&) = delete;

  State state() const { return state_; }
  /// Sends what is due, and notices a peer that was not heard in time.
  void act();
  SimTime next_due() const;
  /// Says good-bye.
  void end();

 private:
  Bond(bus::Bus& bus, Options options, std::function<void(Loss)> on_broken);
  void hear(const bus::MessageView& status);
  void send(bool active);
  void break_up(Loss loss);

  bus::Bus& bus_;
  Options options_;
  std::function<void(Loss)> on_broken_;
  const bus::MessageType* type_ = nullptr;
  bus::EndpointId out_{}, in_{};
  State state_ = State::kWaiting;
  SimTime start_{}, deadline_{};
  std::int64_t sent_ = 0;
};
/// "said good-bye", "is silent", "never came".
std::string_view to_string(Bond::Loss loss);

/// The peers of a node that serves others: cleans up after those that are lost.
class BondWatcher {
 public:
  /// `clean_up` is called once for each lost peer, with the bond's id.
  using CleanUp = std::function<void(const std::string& id, Bond::Loss loss)>;
  BondWatcher(bus::Bus& bus, bus::ParticipantId node, CleanUp clean_up)
      : bus_(bus), node_(node), clean_up_(std::move(clean_up)) {}

  /// Watches a peer from now on; `options.id` is unique here.
  Status watch(Bond::Options options);
  /// Ends the bond from this side.
  void forget(const std::string& id);
  std::vector<std::string> watched() const;
  void act();
  SimTime next_due() const;

 private:
  struct Watched {
    std::string id;
    std::unique_ptr<Bond> bond;
    bool lost = false;
  };
  bus::Bus& bus_;
  bus::ParticipantId node_;
  CleanUp clean_up_;
  std::vector<Watched> watched_;
};

}  // namespace cxlab::cx
