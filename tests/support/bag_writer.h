#pragma once
// Writes bags as recorders do: topics, events of services, and the topics of actions.

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "cx/bus/cdr.h"
#include "cx/bus/interface.h"
#include "cx/mcap/mcap_writer.h"

namespace cxlab::bag {

/// When the bags of tests begin: a time of the real world.
inline constexpr SimTime kRecorded = std::chrono::seconds(1'700'000'000);
inline constexpr const char* kTransientLocal = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n";

/// Types of service events.
enum class Event : std::uint8_t { kRequestSent, kRequestReceived, kResponseSent, kResponseReceived };

class BagWriter {
 public:
  using Write = std::function<void(bus::CdrWriter&)>;

  BagWriter(const std::filesystem::path& path, bus::Registry& types)
      : file_(*mcap::Writer::create(path, "ros2", "test")), types_(types) {}
  void close() { EXPECT_TRUE(file_.close()); }

  /// A message of that topic, `s` after the begin of the recording, from YAML.
  void message(double s, const std::string& topic, const std::string& type, const std::string& yaml,
               const char* qos = "") {
    const bus::Message value = value_of(message_type(type), yaml);
    put(s, topic, type, bus::ros2msg_schema(message_type(type)), [&](bus::CdrWriter& out) { out.message(value); }, qos);
  }
  /// Any bytes, under any definition.
  void bytes(double s, const std::string& topic, const std::string& type, const std::string& definition,
             const std::string& bytes) {
    file_.message(channel(topic, type, definition, ""), kRecorded + from_seconds(s), bytes);
  }
  /// An event of a service; `yaml` is the request or the response.
  void service(double s, const std::string& name, const std::string& type, Event event, std::int64_t number,
               const std::string& yaml, const std::string& client = "a client, its id") {
    const bus::ServiceType& service = **types_.service(type);
    const bus::Message value = value_of(is_request(event) ? *service.request : *service.response, yaml);
    put_event(s, name + "/_service_event", type + "_Event", event, number, client,
              [&](bus::CdrWriter& out) { out.message(value); });
  }
  void feedback(double s, const std::string& action, const std::string& type, char id, const std::string& yaml) {
    const bus::Message value = value_of(*(**types_.action(type)).feedback, yaml);
    put(s, action + "/_action/feedback", type + "_FeedbackMessage", "",
        [&](bus::CdrWriter& out) { out.bytes(std::string(16, id)).message(value); });
  }
  /// All goals that the server knows: id, status; accepted `accepted_s` after the begin of the recording.
  void status(double s, const std::string& action, const std::map<char, int>& goals, double accepted_s = 0) {
    bus::Message array(message_type("action_msgs/msg/GoalStatusArray"));
    for (const auto& [id, status] : goals) {
      const bus::MessageView one = array->append("status_list"), info = one.nested("goal_info");
      one.set("status", status);
      const SimTime accepted = kRecorded + from_seconds(accepted_s);
      info.nested("stamp").set("sec", std::int64_t{accepted.count() / 1'000'000'000});
      const bus::MessageView uuid = info.nested("goal_id");
      for (std::size_t i = 0; i < 16; ++i) EXPECT_TRUE(uuid.set_integer(*uuid.type().find("uuid"), id, i));
    }
    put(s, action + "/_action/status", "action_msgs/msg/GoalStatusArray",
        bus::ros2msg_schema(message_type("action_msgs/msg/GoalStatusArray")),
        [&](bus::CdrWriter& out) { out.message(array); });
  }
  void goal(double s, const std::string& action, const std::string& type, std::int64_t number, char id,
            const std::string& yaml) {
    const bus::Message value = value_of(*(**types_.action(type)).goal, yaml);
    put_event(s, action + "/_action/send_goal/_service_event", type + "_SendGoal_Event", Event::kRequestReceived,
              number, "client", [&](bus::CdrWriter& out) { out.bytes(std::string(16, id)).message(value); });
  }
  void goal_answer(double s, const std::string& action, const std::string& type, std::int64_t number, bool accepted) {
    put_event(s, action + "/_action/send_goal/_service_event", type + "_SendGoal_Event", Event::kResponseSent, number,
              "client", [&](bus::CdrWriter& out) {
                out.number(static_cast<std::uint8_t>(accepted)).number(std::int32_t{0}).number(std::uint32_t{0});
              });
  }
  void result_asked(double s, const std::string& action, const std::string& type, std::int64_t number, char id) {
    put_event(s, action + "/_action/get_result/_service_event", type + "_GetResult_Event", Event::kRequestReceived,
              number, "client", [&](bus::CdrWriter& out) { out.bytes(std::string(16, id)); });
  }
  void result(double s, const std::string& action, const std::string& type, std::int64_t number, int status,
              const std::string& yaml) {
    const bus::Message value = value_of(*(**types_.action(type)).result, yaml);
    put_event(s, action + "/_action/get_result/_service_event", type + "_GetResult_Event", Event::kResponseSent, number,
              "client", [&](bus::CdrWriter& out) { out.number(static_cast<std::int8_t>(status)).message(value); });
  }
  void cancel(double s, const std::string& action, char id) {
    put_event(s, action + "/_action/cancel_goal/_service_event", "action_msgs/srv/CancelGoal_Event",
              Event::kRequestReceived, 1, "client", [&](bus::CdrWriter& out) {
                out.bytes(std::string(16, id)).number(std::int32_t{0}).number(std::uint32_t{0});
              });
  }
  /// An event of a service as introspection with `metadata` publishes it: without what was sent.
  void service_metadata(double s, const std::string& name, const std::string& type, Event event) {
    put_event(s, name + "/_service_event", type + "_Event", event, 1, "client", {});
  }

 private:
  static bool is_request(Event event) { return event <= Event::kRequestReceived; }
  const bus::MessageType& message_type(const std::string& type) { return **types_.message(type); }
  static bus::Message value_of(const bus::MessageType& type, const std::string& yaml) {
    auto message = bus::Message::from_yaml(type, yaml);
    EXPECT_TRUE(message) << message.error().text();
    return *std::move(message);
  }
  void put_event(double s, const std::string& topic, const std::string& type, Event event, std::int64_t number,
                 std::string client, const Write& content) {
    client.resize(16);
    put(s, topic, type, "", [&](bus::CdrWriter& out) {
      out.number(static_cast<std::uint8_t>(event)).number(std::int32_t{0}).number(std::uint32_t{0}).bytes(client);
      out.number(number);
      for (const bool request : {true, false}) {
        const bool there = content && request == is_request(event);
        out.size(there ? 1 : 0);
        if (there) content(out);
      }
    });
  }
  void put(double s, const std::string& topic, const std::string& type, const std::string& definition,
           const Write& write, const char* qos = "") {
    std::string bytes;
    bus::CdrWriter out(bytes);
    write(out);
    file_.message(channel(topic, type, definition, qos), kRecorded + from_seconds(s), bytes);
  }
  mcap::ChannelId channel(const std::string& topic, const std::string& type, const std::string& definition,
                          const char* qos) {
    const auto known = channels_.find({topic, type});
    if (known != channels_.end()) return known->second;
    const auto schema = file_.schema(type, definition);
    return channels_[{topic, type}] = file_.channel(topic, schema, {{"offered_qos_profiles", qos}});
  }

  mcap::Writer file_;
  bus::Registry& types_;
  std::map<std::pair<std::string, std::string>, mcap::ChannelId> channels_;
};

}  // namespace cxlab::bag
