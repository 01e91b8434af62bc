#pragma once
// Messages of the league's protocol (package llsf_msgs), by the names of their fields, and between them and messages of
// the bus: rcll_interfaces has the same names.
//
//   auto types = load_types();
//   auto message = (*types)->make("llsf_msgs.GameState");
//   fill(*message, bus_message, moment);                    // from the bus
//   Fields(*message).set("state", "RUNNING");

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/message.h"
#include "cx/protobuf/types.h"

namespace cxlab::rcll {

/// Reads the .proto files that come with cxlab; `keep` is called with the name and path of each, and may be empty.
Expected<std::unique_ptr<pb::Types>> load_types(
    const std::function<Status(const std::string& name, const std::filesystem::path& file)>& keep = {});

/// A moment as the protocol says it: since 1970.
struct Moment {
  std::int64_t sec = 0, nsec = 0;
  /// `now` of an episode that began `epoch` s after 1970.
  static Moment of(double epoch, SimTime now);
};

/// The fields of a message, by name. The name must exist (asserts), except for `has`.
class Fields {
 public:
  explicit Fields(google::protobuf::Message& message) : message_(&message) {}

  bool has(std::string_view field) const;
  std::int64_t integer(std::string_view field) const;  ///< numbers of enumerations, too
  double real(std::string_view field) const;
  std::string text(std::string_view field) const;  ///< names of enumerations, too
  int size(std::string_view field) const;
  Fields item(std::string_view list, int index) const;
  Fields part(std::string_view field) const;  ///< made if it is not there

  /// Numbers are converted to the field's type.
  Fields& set(std::string_view field, std::int64_t value);
  Fields& set(std::string_view field, int value) { return set(field, static_cast<std::int64_t>(value)); }
  Fields& set(std::string_view field, bool value) { return set(field, static_cast<std::int64_t>(value)); }
  Fields& set(std::string_view field, double value);
  /// An enumeration by the name of its value; nothing is set if it has no such value.
  Fields& set(std::string_view field, std::string_view value);
  Fields& set(std::string_view field, const char* value) { return set(field, std::string_view(value)); }
  Fields& set(std::string_view field, const Moment& moment);
  Fields& clear(std::string_view field);
  Fields append(std::string_view list);
  void erase(std::string_view list, int index);

  google::protobuf::Message& message() const { return *message_; }

 private:
  google::protobuf::Message* message_;
};

/// Fills the fields that have the same name on both sides: texts become enumerations, seconds a Time, poses a Pose2D
/// of this moment. Empty texts and negative numbers for fields without a sign mean "not known" and are left out.
void fill(google::protobuf::Message& to, const bus::MessageView& from, const Moment& now);
/// The other way round. Fields that are not set keep the default of the bus.
void fill(const bus::MessageView& to, google::protobuf::Message& from);

}  // namespace cxlab::rcll
