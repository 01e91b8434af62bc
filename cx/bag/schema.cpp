#include "cx/bag/schema.h"

#include <map>
#include <set>
#include <span>
#include <vector>

#include "cx/bus/cdr.h"
#include "cx/bus/definition.h"

namespace cxlab::bag {

namespace {

using bus::Field;
using bus::FieldSpec;
using bus::MessageType;

/// "geometry_msgs/Pose" of "geometry_msgs/msg/Pose": the first and the last part.
std::string short_name(std::string_view name) {
  const std::size_t first = name.find('/'), last = name.rfind('/');
  return first == last ? std::string(name) : std::string(name.substr(0, first)) + std::string(name.substr(last));
}

std::string package_in(std::string_view name) { return std::string(name.substr(0, name.find('/'))); }

/// By short name: the text of a type, or of a service or an action.
std::map<std::string, std::string_view> blocks_of(std::string_view text) {
  std::map<std::string, std::string_view> blocks;
  std::string name;  // of the topic's own type: none
  std::size_t begin = 0, at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    if (line.size() < 3 || line.find_first_not_of("=\r") != line.npos) {
      at = end + 1;
      continue;
    }
    blocks.emplace(name, text.substr(begin, at - begin));
    const std::size_t head_end = std::min(text.find('\n', std::min(end + 1, text.size())), text.size());
    std::string_view head = text.substr(std::min(end + 1, text.size()), head_end - std::min(end + 1, text.size()));
    if (head.ends_with('\r')) head.remove_suffix(1);
    const std::size_t blank = head.find(' ');
    name = short_name(blank == head.npos ? head : head.substr(blank + 1));
    begin = at = std::min(head_end + 1, text.size());
  }
  blocks.emplace(name, text.substr(begin));
  return blocks;
}

class Comparison {
 public:
  explicit Comparison(std::map<std::string, std::string_view> blocks) : blocks_(std::move(blocks)) {}

  /// Section `number` of a text that has so many.
  std::string compare(std::string_view text, std::size_t sections, std::size_t number, const MessageType& type) {
    const auto parsed = bus::parse_definition(text, "", sections);
    return parsed ? compare((*parsed)[number].fields, type) : std::string();
  }

  std::string compare_part(const MessageType& type) {
    const std::string name = short_name(type.name());
    if (const auto own = blocks_.find(name); own != blocks_.end()) return compare(own->second, 1, 0, type);
    const std::size_t underscore = name.rfind('_');
    const auto whole = blocks_.find(name.substr(0, underscore));
    if (whole == blocks_.end()) return {};
    const std::string_view part = std::string_view(name).substr(underscore + 1);
    const bool service = type.name().find("/srv/") != std::string::npos;
    const std::size_t number = part == "Request" || part == "Goal" ? 0 : part == "Feedback" ? 2 : 1;
    return compare(whole->second, service ? 2 : 3, number, type);
  }

 private:
  /// Fields of one size that only differ in name: octets.
  static bool is_octet(bus::FieldType type) {
    return type == bus::FieldType::kByte || type == bus::FieldType::kChar || type == bus::FieldType::kUint8;
  }

  /// How the field would be written, with the name of a nested type in full.
  static std::string written(const FieldSpec& spec, const std::string& nested) {
    std::string type = spec.field.type_text();
    if (spec.field.is_message()) type = nested + type.substr(type.find_last_not_of("[]<=0123456789") + 1);
    return type + ' ' + spec.field.name;
  }
  static std::string written(const Field& field) {
    std::string type = field.type_text();
    if (field.nested) type.replace(0, field.nested->name().size(), short_name(field.nested->name()));
    return type + ' ' + field.name;
  }

  static bool same(const FieldSpec& spec, const std::string& nested, const Field& field) {
    const Field& other = spec.field;
    const bool type = other.type == field.type || (is_octet(other.type) && is_octet(field.type));
    return type && other.name == field.name && other.array == field.array && other.size_limit == field.size_limit &&
           other.string_limit == field.string_limit && (!field.nested || nested == short_name(field.nested->name()));
  }

  std::string compare(std::span<const FieldSpec> specs, const MessageType& type) {
    const bool dummy = specs.size() == 1 && specs[0].field.name == "structure_needs_at_least_one_member";
    if (dummy && type.fields().empty()) return {};
    const std::string in = " of " + short_name(type.name());
    for (std::size_t i = 0; i < std::max(specs.size(), type.fields().size()); ++i) {
      const std::string which = "field " + std::to_string(i + 1) + in;
      if (i >= specs.size())
        return which + " is '" + written(type.fields()[i]) + "' in the workspace, and is not there in the bag";
      std::string nested;
      if (specs[i].field.is_message()) {
        nested = short_name(specs[i].nested_name);
        if (nested == "Header") nested = "std_msgs/Header";
        if (nested.find('/') == nested.npos) nested = package_in(type.name()) + '/' + nested;
      }
      if (i >= type.fields().size())
        return which + " is '" + written(specs[i], nested) + "' in the bag, and is not there in the workspace";
      const Field& field = type.fields()[i];
      if (!same(specs[i], nested, field))
        return which + " is '" + written(specs[i], nested) + "' in the bag and '" + written(field) +
               "' in the workspace";
      if (!field.nested || !compared_.insert(field.nested).second) continue;
      const auto block = blocks_.find(nested);
      if (block == blocks_.end()) continue;
      if (std::string found = compare(block->second, 1, 0, *field.nested); !found.empty()) return found;
    }
    return {};
  }

  std::map<std::string, std::string_view> blocks_;
  std::set<const MessageType*> compared_;
};

}  // namespace

std::string Schema::difference(const MessageType& type) const {
  auto blocks = blocks_of(text_);
  const std::string_view own = blocks[""];
  if (own.empty()) return Comparison(std::move(blocks)).compare_part(type);
  return Comparison(std::move(blocks)).compare(own, 1, 0, type);
}

std::string Schema::difference_of_part(const MessageType& type) const {
  return Comparison(blocks_of(text_)).compare_part(type);
}

}  // namespace cxlab::bag
