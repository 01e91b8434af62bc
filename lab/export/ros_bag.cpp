#include "lab/export/ros_bag.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace cxlab::lab {

namespace {

/// Who comes late gets the last message: what tf2 expects of static transforms.
constexpr const char* kLatched =
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n"
    "  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  avoid_ros_namespace_conventions: false\n";

}  // namespace

RosTime ros_time(SimTime t) {
  constexpr std::int64_t kSecond = 1'000'000'000, kLatest = std::numeric_limits<std::int32_t>::max();
  const std::int64_t ns = std::max<std::int64_t>(0, t.count());
  return {static_cast<std::int32_t>(std::min(ns / kSecond, kLatest)), static_cast<std::uint32_t>(ns % kSecond)};
}

void set_stamp(const bus::MessageView& stamp, SimTime t) {
  const RosTime time = ros_time(t);
  stamp.set("sec", std::int64_t{time.sec}).set("nanosec", std::int64_t{time.nanosec});
}

void write_stamp(bus::CdrWriter& out, SimTime t) {
  const RosTime time = ros_time(t);
  out.number(time.sec).number(time.nanosec);
}

std::string topic_part(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'))) c = '_';
  return out.empty() ? "_" : out;
}

const bus::MessageType& RosBag::own(const std::string& type) {
  const auto found = own_.message(type);
  assert(found && "comes with cxlab");
  return **found;
}

bus::Message RosBag::make(const std::string& type) { return bus::Message(own(type)); }

void RosBag::put(const std::string& topic, SimTime t, const bus::MessageView& message) {
  bus::CdrWriter(bytes_).message(message);
  send(topic, message.type().name(), [&] { return bus::ros2msg_schema(message.type()); }, t);
}

void RosBag::put(const std::string& topic, SimTime t, const Composed& value) {
  bus::CdrWriter out(bytes_);
  value.write(out);
  send(topic, value.type, value.schema, t);
}

std::vector<std::string> RosBag::topics() const {
  std::vector<std::string> out;
  for (const auto& [key, _] : channels_)
    if (out.empty() || out.back() != key.first) out.push_back(key.first);
  return out;
}

void RosBag::send(const std::string& topic, const std::string& type, const std::function<std::string()>& schema,
                  SimTime t) {
  auto known = channels_.find({topic, type});
  if (known == channels_.end()) {
    const mcap::Texts qos{{"offered_qos_profiles", topic == "/tf_static" ? kLatched : ""}};
    known = channels_.emplace(std::pair(topic, type), file_.channel(topic, file_.schema(type, schema()), qos)).first;
  }
  file_.message(known->second, t, bytes_);
}

}  // namespace cxlab::lab
