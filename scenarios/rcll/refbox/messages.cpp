#include "scenarios/rcll/refbox/messages.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "cx/base/file.h"
#include "scenarios/share.h"

namespace cxlab::rcll {

namespace proto = google::protobuf;
using Descriptor = proto::FieldDescriptor;

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kNanoseconds = 1'000'000'000;

const Descriptor* find(const proto::Message& message, std::string_view field) {
  return message.GetDescriptor()->FindFieldByName(std::string(field));
}

const Descriptor& get(const proto::Message& message, std::string_view field) {
  const Descriptor* found = find(message, field);
  assert(found && "a message of the league has no such field");
  return *found;
}

bool is_time(const Descriptor& field) {
  return field.cpp_type() == Descriptor::CPPTYPE_MESSAGE && field.message_type()->name() == "Time";
}

struct Number {
  double real = 0;
  std::int64_t integer = 0;
};
/// The integer is the number without its fraction; 0 for one that has no integer.
Number number_of(double real) {
  constexpr double kLimit = 9.2e18;
  return {real, std::abs(real) < kLimit ? static_cast<std::int64_t>(real) : 0};
}

/// Sets a field, or appends to a list; a number that the field cannot hold is left out.
void put_number(proto::Message& message, const Descriptor& field, const Number& number) {
  const auto& [real, integer] = number;
  const proto::Reflection& reflect = *message.GetReflection();
  const auto put = [&](auto value, auto set, auto add) {
    if (field.is_repeated())
      (reflect.*add)(&message, &field, value);
    else
      (reflect.*set)(&message, &field, value);
  };
  using R = proto::Reflection;
  switch (field.cpp_type()) {
    case Descriptor::CPPTYPE_INT32: return put(static_cast<std::int32_t>(integer), &R::SetInt32, &R::AddInt32);
    case Descriptor::CPPTYPE_INT64: return put(integer, &R::SetInt64, &R::AddInt64);
    case Descriptor::CPPTYPE_UINT32:
      if (integer < 0 || integer > std::numeric_limits<std::uint32_t>::max()) return;
      return put(static_cast<std::uint32_t>(integer), &R::SetUInt32, &R::AddUInt32);
    case Descriptor::CPPTYPE_UINT64:
      if (integer < 0) return;
      return put(static_cast<std::uint64_t>(integer), &R::SetUInt64, &R::AddUInt64);
    case Descriptor::CPPTYPE_DOUBLE: return put(real, &R::SetDouble, &R::AddDouble);
    case Descriptor::CPPTYPE_FLOAT: return put(static_cast<float>(real), &R::SetFloat, &R::AddFloat);
    case Descriptor::CPPTYPE_BOOL: return put(integer != 0, &R::SetBool, &R::AddBool);
    default: assert(false && "the field is no number");
  }
}

void put_text(proto::Message& message, const Descriptor& field, std::string_view text) {
  const proto::Reflection& reflect = *message.GetReflection();
  if (field.cpp_type() == Descriptor::CPPTYPE_ENUM) {
    const proto::EnumValueDescriptor* value = field.enum_type()->FindValueByName(std::string(text));
    if (!value) return;
    if (field.is_repeated())
      reflect.AddEnum(&message, &field, value);
    else
      reflect.SetEnum(&message, &field, value);
    return;
  }
  assert(field.cpp_type() == Descriptor::CPPTYPE_STRING);
  if (field.is_repeated())
    reflect.AddString(&message, &field, std::string(text));
  else
    reflect.SetString(&message, &field, std::string(text));
}

/// The number in a field, or in an element of a list.
Number number_of(const proto::Message& message, const Descriptor& field, int index) {
  const proto::Reflection& reflect = *message.GetReflection();
  const auto read = [&](auto one, auto of_list) {
    return field.is_repeated() ? (reflect.*of_list)(message, &field, index) : (reflect.*one)(message, &field);
  };
  const auto whole = [](auto value) { return Number{static_cast<double>(value), static_cast<std::int64_t>(value)}; };
  using R = proto::Reflection;
  switch (field.cpp_type()) {
    case Descriptor::CPPTYPE_INT32: return whole(read(&R::GetInt32, &R::GetRepeatedInt32));
    case Descriptor::CPPTYPE_INT64: return whole(read(&R::GetInt64, &R::GetRepeatedInt64));
    case Descriptor::CPPTYPE_UINT32: return whole(read(&R::GetUInt32, &R::GetRepeatedUInt32));
    case Descriptor::CPPTYPE_UINT64: return whole(read(&R::GetUInt64, &R::GetRepeatedUInt64));
    case Descriptor::CPPTYPE_DOUBLE: return number_of(read(&R::GetDouble, &R::GetRepeatedDouble));
    case Descriptor::CPPTYPE_FLOAT: return number_of(static_cast<double>(read(&R::GetFloat, &R::GetRepeatedFloat)));
    case Descriptor::CPPTYPE_BOOL: return whole(read(&R::GetBool, &R::GetRepeatedBool));
    case Descriptor::CPPTYPE_ENUM: return whole(read(&R::GetEnum, &R::GetRepeatedEnum)->number());
    default: return {};
  }
}

std::string text_of(const proto::Message& message, const Descriptor& field, int index) {
  const proto::Reflection& reflect = *message.GetReflection();
  if (field.cpp_type() == Descriptor::CPPTYPE_ENUM)
    return (field.is_repeated() ? reflect.GetRepeatedEnum(message, &field, index) : reflect.GetEnum(message, &field))
        ->name();
  assert(field.cpp_type() == Descriptor::CPPTYPE_STRING);
  return field.is_repeated() ? reflect.GetRepeatedString(message, &field, index) : reflect.GetString(message, &field);
}

}  // namespace

Expected<std::unique_ptr<pb::Types>> load_types(
    const std::function<Status(const std::string&, const fs::path&)>& keep) {
  const fs::path folder = find_share().packages / "rcll_protobuf_msgs" / "rcll-protobuf-msgs";
  auto types = std::make_unique<pb::Types>(
      [folder, keep](const std::string& file) -> Expected<std::optional<pb::Types::Source>> {
        const fs::path path = folder / file;
        if (keep)
          if (Status s = keep("rcll_protobuf_msgs/" + file, path); !s) return s.error();
        auto text = read_file(path);
        if (!text) return text.error();
        return std::optional(pb::Types::Source{*std::move(text), path.string()});
      });
  // All that the referee box and robots say and hear; what these import is read with them.
  for (const char* file : {"AgentTask", "AttentionMessage", "BeaconSignal", "GameInfo", "GameState", "MachineCommands",
                           "MachineInfo", "MachineInstructions", "MachineReport", "OrderInfo", "RingInfo", "RobotInfo",
                           "SimTimeSync", "VersionInfo", "Workpiece"})
    if (Status s = types->add_file(std::string(file) + ".proto"); !s) return s.error();
  return types;
}

Moment Moment::of(double epoch, SimTime now) {
  const auto whole = static_cast<std::int64_t>(std::floor(epoch));
  const std::int64_t nsec = now.count() + from_seconds(epoch - static_cast<double>(whole)).count();
  return {whole + nsec / kNanoseconds, nsec % kNanoseconds};
}

// --- By name

bool Fields::has(std::string_view field) const {
  const Descriptor* found = find(*message_, field);
  return found && (found->is_repeated() ? message_->GetReflection()->FieldSize(*message_, found) > 0
                                        : message_->GetReflection()->HasField(*message_, found));
}

std::int64_t Fields::integer(std::string_view field) const {
  return number_of(*message_, get(*message_, field), 0).integer;
}
double Fields::real(std::string_view field) const { return number_of(*message_, get(*message_, field), 0).real; }
std::string Fields::text(std::string_view field) const { return text_of(*message_, get(*message_, field), 0); }

int Fields::size(std::string_view field) const {
  return message_->GetReflection()->FieldSize(*message_, &get(*message_, field));
}

Fields Fields::item(std::string_view list, int index) const {
  return Fields(*message_->GetReflection()->MutableRepeatedMessage(message_, &get(*message_, list), index));
}

Fields Fields::part(std::string_view field) const {
  return Fields(*message_->GetReflection()->MutableMessage(message_, &get(*message_, field)));
}

Fields& Fields::set(std::string_view field, std::int64_t value) {
  put_number(*message_, get(*message_, field), {static_cast<double>(value), value});
  return *this;
}

Fields& Fields::set(std::string_view field, double value) {
  put_number(*message_, get(*message_, field), number_of(value));
  return *this;
}

Fields& Fields::set(std::string_view field, std::string_view value) {
  put_text(*message_, get(*message_, field), value);
  return *this;
}

Fields& Fields::set(std::string_view field, const Moment& moment) {
  part(field).set("sec", moment.sec).set("nsec", moment.nsec);
  return *this;
}

Fields& Fields::clear(std::string_view field) {
  message_->GetReflection()->ClearField(message_, &get(*message_, field));
  return *this;
}

void Fields::erase(std::string_view list, int index) {
  const google::protobuf::Reflection& reflection = *message_->GetReflection();
  for (const int last = size(list) - 1; index < last; ++index)
    reflection.SwapElements(message_, &get(*message_, list), index, index + 1);
  reflection.RemoveLast(message_, &get(*message_, list));
}

Fields Fields::append(std::string_view list) {
  return Fields(*message_->GetReflection()->AddMessage(message_, &get(*message_, list)));
}

// --- From the bus and to it

namespace {

void fill_part(proto::Message& to, const Descriptor& field, const bus::MessageView& from, const Moment& now) {
  const proto::Reflection& reflect = *to.GetReflection();
  proto::Message* part = field.is_repeated() ? reflect.AddMessage(&to, &field) : reflect.MutableMessage(&to, &field);
  if (field.message_type()->name() != "Pose2D") return fill(*part, from, now);
  Fields(*part).set("timestamp", now).set("x", from.real("x")).set("y", from.real("y")).set("ori", from.real("theta"));
}

}  // namespace

void fill(proto::Message& to, const bus::MessageView& from, const Moment& now) {
  for (const bus::Field& field : from.type().fields()) {
    const Descriptor* target = find(to, field.name);
    if (!target) continue;
    const std::size_t count = from.size(field);
    for (std::size_t i = 0; i < count; ++i) {
      if (field.is_message()) {
        fill_part(to, *target, from.nested(field, i), now);
      } else if (field.is_text()) {
        const std::string& text = from.text(field, i);
        if (!text.empty() || target->is_required()) put_text(to, *target, text);
      } else if (is_time(*target)) {
        Fields(to).set(target->name(), Moment::of(0, from_seconds(from.real(field, i))));
      } else if (field.is_real()) {
        put_number(to, *target, number_of(from.real(field, i)));
      } else {
        put_number(to, *target, {static_cast<double>(from.integer(field, i)), from.integer(field, i)});
      }
    }
  }
}

void fill(const bus::MessageView& to, proto::Message& from) {
  const proto::Reflection& reflect = *from.GetReflection();
  for (const bus::Field& field : to.type().fields()) {
    const Descriptor* source = find(from, field.name);
    if (!source || source->is_repeated() != field.is_sequence() || !Fields(from).has(field.name)) continue;
    const int count = source->is_repeated() ? reflect.FieldSize(from, source) : 1;
    if (field.is_sequence() && !to.resize(field, static_cast<std::size_t>(count))) continue;
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const auto part = [&] {
        return source->is_repeated() ? Fields(from).item(field.name, i) : Fields(from).part(field.name);
      };
      Status fits;
      if (field.is_message()) {
        if (source->message_type()->name() == "Pose2D")
          to.nested(field, at).set("x", part().real("x")).set("y", part().real("y")).set("theta", part().real("ori"));
        else
          fill(to.nested(field, at), part().message());
      } else if (field.is_text()) {
        fits = to.set_text(field, text_of(from, *source, i), at);
      } else if (field.is_real()) {
        to.set_real(field,
                    is_time(*source) ? static_cast<double>(part().integer("sec")) +
                                           static_cast<double>(part().integer("nsec")) / kNanoseconds
                                     : number_of(from, *source, i).real,
                    at);
      } else {
        fits = to.set_integer(field, number_of(from, *source, i).integer, at);
      }
      (void)fits;  // what does not fit keeps its default
    }
  }
}

}  // namespace cxlab::rcll
