#include "cx/bus/names.h"

#include "cx/bus/bus.h"

namespace cxlab::bus {

std::string NodeName::full_name() const { return (name_space == "/" ? "" : name_space) + '/' + name; }

std::string NodeName::expand(std::string_view written) const {
  if (!written.empty() && written.front() == '/') return std::string(written);
  if (!written.empty() && written.front() == '~') return full_name() + std::string(written.substr(1));
  return (name_space == "/" ? "" : name_space) + '/' + std::string(written);
}

std::string NodeName::resolve(std::string_view name_as_written) const {
  const std::string expanded = expand(name_as_written);
  for (const auto& [from, to] : remaps)
    if (expand(from) == expanded) return expand(to);
  return expanded;
}

std::string name_fault(std::string_view written) {
  if (written.empty()) return "is empty";
  std::string_view rest = written;
  if (rest.front() == '~') {
    rest.remove_prefix(1);
    if (rest.empty()) return {};
    if (rest.front() != '/') return "has no '/' after '~'";
  }
  if (rest.front() == '/') rest.remove_prefix(1);
  char before = '/';
  for (const char c : rest) {
    const bool digit = c >= '0' && c <= '9';
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    if (!digit && !letter && c != '/')
      return "has a '" + std::string(1, c) + "'; expected letters, digits, '_' and '/'";
    if (before == '/' && c == '/') return "has an empty part";
    if (before == '/' && digit) return "has a part that begins with a digit";
    before = c;
  }
  if (before == '/') return "ends with '/'";
  return {};
}

std::string to_string(const GoalId& id) {
  static constexpr std::string_view kHex = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : id) text.append({kHex[byte >> 4], kHex[byte & 15]});
  return text;
}

}  // namespace cxlab::bus
