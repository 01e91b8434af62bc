#pragma once
// The messages of the bus, as topics of a bag: publications under their names, feedback and status of actions, and
// calls of services and actions. Calls become the events that service introspection of ROS 2 publishes
// (`NAME/_service_event`).

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cx/bus/interface.h"
#include "lab/export/ros_bag.h"
#include "lab/export/run_pass.h"

namespace cxlab::lab {

class BusChannels final : public PassListener {
 public:
  /// `types`: the definitions that the run used.
  BusChannels(RosBag& bag, bus::Registry types, const Stretch& stretch)
      : bag_(bag), types_(std::move(types)), stretch_(stretch) {}

  bool wants(RecordKind kind) const override { return kind == RecordKind::kBus; }
  Status hear(const JournalRecord& record) override;

 private:
  enum class EventType : std::uint8_t { kRequestSent = 0, kResponseSent = 2 };
  /// Who asks: the stream of the client, and the number of its request.
  struct Caller {
    std::string stream;
    std::int64_t number = 0;
  };
  struct Goal {
    Caller caller;
    std::string type;  ///< as its client declared it
    SimTime accepted{};
    std::int64_t status = 0;
  };
  /// A part of a service that is composed of a text of fields, and of messages that it names.
  struct Part {
    std::string name, text;
    std::vector<const bus::MessageType*> uses;
    std::function<void(bus::CdrWriter&)> write;  ///< none: this event does not have it
  };

  Status take(const JournalRecord& record, const std::string& op, const std::string& name);
  /// The message in the first of these types that has its fields.
  Expected<bus::Message> published(const std::vector<std::string>& types, const RecordValue& data);
  Expected<bus::Message> message_of(const bus::MessageType& type, const RecordValue& data, std::string_view key) const;
  void put_event(const std::string& service, const std::string& type, SimTime t, EventType event, const Caller& caller,
                 Part request, Part response);
  void put_service(const std::string& service, const bus::ServiceType& type, SimTime t, EventType event,
                   const Caller& caller, const bus::Message& message);
  Status take_action(const JournalRecord& record, const std::string& op, const std::string& name);
  Status take_cancel(const JournalRecord& record, const std::string& op, const std::string& name);
  void put_status(const std::string& action, SimTime t);

  RosBag& bag_;
  bus::Registry types_;
  Stretch stretch_;
  /// By stream and name: types that the stream declared. A server may offer one service in several types.
  using Declared = std::map<std::pair<std::string, std::string>, std::vector<std::string>>;
  Declared topics_, services_, actions_;
  std::map<std::string, std::map<std::string, Goal>> goals_;  ///< by action and goal id
};

}  // namespace cxlab::lab
