#include "cx/bus/needed.h"

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>

namespace cxlab::bus {

namespace {

struct Own {
  std::mutex mutex;
  std::filesystem::path folder;
  std::unique_ptr<Registry> types;
};

Own& own() {
  static Own all;
  return all;
}

/// What the sections of a definition are called, by the kind in its name: ".../srv/T" has two.
std::span<const std::string_view> sections_of(std::string_view name) {
  static constexpr std::array<std::string_view, 1> kMessage{""};
  static constexpr std::array<std::string_view, 2> kService{"_Request", "_Response"};
  static constexpr std::array<std::string_view, 3> kAction{"_Goal", "_Result", "_Feedback"};
  if (name.find("/srv/") != name.npos) return kService;
  if (name.find("/action/") != name.npos) return kAction;
  return kMessage;
}

/// What `used` lacks of the fields of `own`, in words; empty if nothing.
std::string lacking(const MessageType& own, const MessageType& used, const std::string& path) {
  for (const Field& field : own.fields()) {
    const std::string name = path + field.name;
    const Field* other = used.find(field.name);
    if (!other && !field.default_text.empty()) continue;
    if (!other) return "has no field '" + name + "' (" + field.type_text() + ')';
    const bool alike = other->type == field.type && other->array == field.array &&
                       other->size_limit == field.size_limit && other->string_limit == field.string_limit &&
                       (!field.is_message() || other->nested->name() == field.nested->name());
    if (!alike) return "has the field '" + name + "' as " + other->type_text() + " instead of " + field.type_text();
    if (!field.is_message()) continue;
    if (std::string nested = lacking(*field.nested, *other->nested, name + '.'); !nested.empty()) return nested;
  }
  return {};
}

/// The file that the registry has read for "pkg/srv/T", for people.
std::string file_of(const Registry& registry, const std::string& name) {
  const std::filesystem::path type(name);
  const std::string package = type.parent_path().parent_path().string(), kind = type.parent_path().filename().string();
  std::string found;
  for (const std::filesystem::path& file : registry.files_read()) {
    const std::filesystem::path folder = file.parent_path();
    if (file.filename() != type.filename().string() + '.' + kind || folder.filename() != kind) continue;
    if (found.empty() || folder.parent_path().filename() == package) found = file.string();
  }
  return found;
}

template <class Type>
Expected<Type> unless_refused(Registry& registry, const std::string& name, Expected<Type> found) {
  if (!found) return found;
  const Status fits = check_needed(registry, name);
  return fits ? found : Expected<Type>(fits.error());
}

}  // namespace

void Registry::note_not_offered(const std::string& text) {
  if (std::ranges::find(not_offered_, text) == not_offered_.end()) not_offered_.push_back(text);
}

void set_own_definitions(const std::filesystem::path& folder) {
  const std::scoped_lock lock(own().mutex);
  if (own().folder == folder) return;
  own().folder = folder;
  own().types = std::make_unique<Registry>();
  if (!own().types->add_packages_in(folder)) own().types.reset();
}

Status check_needed(Registry& registry, const std::string& name) {
  const std::scoped_lock lock(own().mutex);
  if (!own().types) return {};
  for (const std::string_view section : sections_of(name)) {
    const std::string part = name + std::string(section);
    const auto needed = own().types->message(part);
    if (!needed) return {};  // not one of cxlab's
    const auto used = registry.message(part);
    if (!used) return used.error();
    if (const std::string lacks = lacking(**needed, **used, ""); !lacks.empty())
      return input_error("'" + part + "' " + lacks + ", which cxlab needs (cxlab doc " + name + " shows its own)",
                         file_of(registry, name));
  }
  return {};
}

bool can_offer(Registry& registry, const std::string& what, const std::string& type) {
  const Status fits = check_needed(registry, type);
  if (fits) return true;
  registry.note_not_offered(what + " is not offered: " + fits.error().text());
  return false;
}

Expected<const MessageType*> needed_message(Registry& registry, const std::string& name) {
  return unless_refused(registry, name, registry.message(name));
}
Expected<const ServiceType*> needed_service(Registry& registry, const std::string& name) {
  return unless_refused(registry, name, registry.service(name));
}
Expected<const ActionType*> needed_action(Registry& registry, const std::string& name) {
  return unless_refused(registry, name, registry.action(name));
}

}  // namespace cxlab::bus
