#pragma once
// What the makers of an MCAP export share: messages of ROS 2 go into one file, under topics.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/cdr.h"
#include "cx/bus/interface.h"
#include "cx/mcap/mcap_writer.h"

namespace cxlab::lab {

/// As builtin_interfaces/Time has it: a time before 0 is 0, one after 2038 the last.
struct RosTime {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
RosTime ros_time(SimTime t);
/// Sets a field of the type builtin_interfaces/Time.
void set_stamp(const bus::MessageView& stamp, SimTime t);
/// Writes a builtin_interfaces/Time.
void write_stamp(bus::CdrWriter& out, SimTime t);
/// The text as a part of the name of a topic: what is no letter, digit or underscore becomes an underscore.
std::string topic_part(std::string_view text);

class RosBag {
 public:
  /// The packages of `own` are those of cxlab itself.
  RosBag(mcap::Writer file, bus::Registry own) : file_(std::move(file)), own_(std::move(own)) {}

  mcap::Writer& file() { return file_; }
  /// A new message of a type that comes with cxlab.
  bus::Message make(const std::string& type);
  const bus::MessageType& own(const std::string& type);

  /// A message of that topic; the first one makes the channel.
  void put(const std::string& topic, SimTime t, const bus::MessageView& message);
  /// A composed value: the name of its type, the text of its definition, and what writes it.
  struct Composed {
    std::string type;
    std::function<std::string()> schema;
    std::function<void(bus::CdrWriter&)> write;
  };
  void put(const std::string& topic, SimTime t, const Composed& value);
  /// The topics that have messages, sorted.
  std::vector<std::string> topics() const;

 private:
  void send(const std::string& topic, const std::string& type, const std::function<std::string()>& schema, SimTime t);

  mcap::Writer file_;
  bus::Registry own_;
  std::map<std::pair<std::string, std::string>, mcap::ChannelId> channels_;  ///< by topic and type
  std::string bytes_;
};

}  // namespace cxlab::lab
