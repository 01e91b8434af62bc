#include "cx/bus/names.h"

#include "cx/bus/bus.h"

namespace cxlab::bus {

std::string NodeName::full_name() const { return (name_space == "/" ? "" : name_space) + '/' + name; }

namespace {

void substitute(std::string& text, std::string_view word, const std::string& value) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + value.size()))
    text.replace(at, word.size(), value);
}

/// Removes "NODE:" from the front, if there is one; "rostopic://" is none. False if it is of another node.
bool is_for(const std::string& node, std::string_view& from) {
  const std::size_t colon = from.find(':');
  if (colon == std::string_view::npos || from.substr(colon).starts_with("://")) return true;
  const bool ours = from.substr(0, colon) == node;
  from.remove_prefix(colon + 1);
  return ours;
}

/// Removes the kind's prefix from the front. False if it is of another kind.
bool is_for(NameKind kind, std::string_view& from) {
  for (const auto& [prefix, wanted] : {std::pair<std::string_view, NameKind>{"rostopic://", NameKind::kTopic},
                                       {"rosservice://", NameKind::kService}}) {
    if (!from.starts_with(prefix)) continue;
    from.remove_prefix(prefix.size());
    return kind == wanted;
  }
  return true;
}

}  // namespace

std::string NodeName::expand(std::string_view as_written) const {
  std::string written(as_written);
  if (written.find('{') != std::string::npos) {
    substitute(written, "{node}", name);
    for (const char* word : {"{ns}", "{namespace}"})
      substitute(written, word, name_space.substr(name_space.starts_with('/') ? 1 : 0));
  }
  if (!written.empty() && written.front() == '/') return written;
  if (!written.empty() && written.front() == '~') return full_name() + written.substr(1);
  return (name_space == "/" ? "" : name_space) + '/' + written;
}

std::string NodeName::resolve(std::string_view name_as_written, NameKind kind) const {
  const std::string expanded = expand(name_as_written);
  for (const auto& [written, to] : remaps) {
    std::string_view from = written;
    if (is_for(name, from) && is_for(kind, from) && expand(from) == expanded) {
      std::string_view target = to;
      (void)is_for(kind, target);
      return expand(target);
    }
  }
  return expanded;
}

void rename_node(NodeName& node) {
  const std::string old_name = node.name;
  std::erase_if(node.remaps, [&](const auto& remap) {
    std::string_view from = remap.first;
    const bool ours = is_for(old_name, from);
    if (from != "__node" && from != "__name" && from != "__ns") return false;
    if (ours) (from == "__ns" ? node.name_space : node.name) = remap.second;
    return true;
  });
}

std::string name_fault(std::string_view written) {
  if (written.empty()) return "is empty";
  std::string plain(written);
  for (const char* word : {"{node}", "{ns}", "{namespace}"}) substitute(plain, word, "x");
  std::string_view rest = plain;
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

std::string namespace_fault(std::string_view name_space) {
  if (name_space == "/") return {};
  if (!name_space.starts_with('/')) return "does not begin with '/'; expected an absolute name like /cyan";
  return name_fault(name_space);
}

std::string remap_fault(const std::pair<std::string, std::string>& remap) {
  std::string_view from = remap.first, to = remap.second;
  const std::size_t colon = from.find(':');
  if (colon != std::string_view::npos && !from.substr(colon).starts_with("://")) {
    const std::string_view node = from.substr(0, colon);
    if (const std::string fault = name_fault(node);
        !fault.empty() || node.find_first_of("/~{") != std::string_view::npos)
      return found_expected("'" + std::string(node) + "' before ':'", "the name of a node");
    from.remove_prefix(colon + 1);
  }
  const auto bad = [](std::string_view name, const std::string& fault) {
    return "the name '" + std::string(name) + "' " + fault;
  };
  if (from == "__ns") {
    const std::string fault = namespace_fault(to);
    return fault.empty() ? fault : bad(to, fault);
  }
  if (from == "__node" || from == "__name") {
    if (to.find_first_of("/~{") != std::string_view::npos)
      return bad(to, "has more than the letters, digits and '_' of a node's name");
    const std::string fault = name_fault(to);
    return fault.empty() ? fault : bad(to, fault);
  }
  for (std::string_view* name : {&from, &to}) {
    for (const std::string_view scheme : {"rostopic://", "rosservice://"})
      if (name->starts_with(scheme)) name->remove_prefix(scheme.size());
    if (const std::string fault = name_fault(*name); !fault.empty()) return bad(*name, fault);
  }
  return {};
}

std::string to_string(const GoalId& id) {
  static constexpr std::string_view kHex = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : id) text.append({kHex[byte >> 4], kHex[byte & 15]});
  return text;
}

Status check_node(const std::string& name_space, const std::vector<std::pair<std::string, std::string>>& remaps) {
  if (const std::string fault = namespace_fault(name_space); !fault.empty())
    return input_error("namespace: the name '" + name_space + "' " + fault);
  for (const auto& remap : remaps)
    if (const std::string fault = remap_fault(remap); !fault.empty())
      return input_error("remap." + remap.first + ": " + fault);
  return {};
}

}  // namespace cxlab::bus
