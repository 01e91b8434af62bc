#include "cx/plugins/bindings/names.h"

#include <cctype>

namespace cxlab::cx {

namespace {

constexpr std::string_view kBegin = "cx::CX", kEnd = "Plugin";

bool is_upper(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }
bool is_lower(char c) { return std::islower(static_cast<unsigned char>(c)) != 0; }
bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::string camel_case(std::string_view package) {
  std::string out;
  bool first = true;
  for (const char c : package) {
    if (c != '_') out += first ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    first = c == '_';
  }
  return out;
}

std::string kebab_case(std::string_view camel) {
  std::string out;
  for (std::size_t i = 0; i < camel.size(); ++i) {
    const char c = camel[i];
    const char before = i == 0 ? '\0' : camel[i - 1], after = i + 1 < camel.size() ? camel[i + 1] : '\0';
    if (is_upper(c) && (is_lower(before) || is_digit(before) || (is_upper(before) && is_lower(after)))) out += '-';
    out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

std::string binding_class_name(std::string_view interface) {
  const std::string_view package = interface.substr(0, interface.find('/'));
  std::string name(kBegin);
  return name.append(camel_case(package)).append(interface.substr(interface.rfind('/') + 1)).append(kEnd);
}

std::optional<BindingClass> find_binding(std::string_view class_name, const bus::Registry& interfaces) {
  if (!class_name.starts_with(kBegin) || !class_name.ends_with(kEnd) ||
      class_name.size() <= kBegin.size() + kEnd.size())
    return std::nullopt;
  const std::string_view body = class_name.substr(kBegin.size(), class_name.size() - kBegin.size() - kEnd.size());
  for (const std::string& package : interfaces.packages()) {
    const std::string camel = camel_case(package);
    if (!body.starts_with(camel) || body.size() == camel.size()) continue;
    const std::string name(body.substr(camel.size()));
    const std::vector<std::string> known = interfaces.interfaces(package);
    using Folder = std::pair<const char*, InterfaceKind>;
    for (const auto& [folder, kind] :
         {Folder{"/msg/", InterfaceKind::kMessage}, Folder{"/srv/", InterfaceKind::kService},
          Folder{"/action/", InterfaceKind::kAction}}) {
      const std::string interface = package + folder + name;
      for (const std::string& other : known)
        if (other == interface) return BindingClass{kind, interface, kebab_case(body)};
    }
  }
  return std::nullopt;
}

std::vector<std::string> binding_classes(const bus::Registry& interfaces) {
  std::vector<std::string> names;
  for (const std::string& package : interfaces.packages())
    for (const std::string& interface : interfaces.interfaces(package)) names.push_back(binding_class_name(interface));
  return names;
}

}  // namespace cxlab::cx
