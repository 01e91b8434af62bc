#include "cx/bus/interface.h"

#include <algorithm>
#include <array>
#include <new>
#include <set>

#include "cx/base/file.h"
#include "cx/bus/definition.h"
#include "cx/bus/layout.h"
#include "cx/bus/literal.h"

namespace cxlab::bus {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 26;
constexpr std::size_t kMaxNesting = 64;
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 22;

/// The folders of a package, and what the sections of their files are called.
struct Form {
  std::string_view folder;
  std::array<std::string_view, 3> suffixes;
  std::size_t sections;
};
constexpr std::array<Form, 3> kForms{
    {{"msg", {""}, 1}, {"srv", {"_Request", "_Response"}, 2}, {"action", {"_Goal", "_Result", "_Feedback"}, 3}}};

bool is_identifier(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> parts;
  for (;;) {
    const auto slash = text.find('/');
    parts.emplace_back(text.substr(0, slash));
    if (slash == std::string_view::npos) return parts;
    text.remove_prefix(slash + 1);
  }
}

Expected<std::string> read_definition(const fs::path& path) {
  auto text = read_file(path);
  if (text && text->size() > kMaxFileBytes)
    return input_error(found_expected(std::to_string(text->size()) + " bytes",
                                      "a definition of at most " + std::to_string(kMaxFileBytes)),
                       path.string());
  return text;
}

std::vector<std::string> files_in(const fs::path& folder, const std::string& extension) {
  std::vector<std::string> names;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure))
    if (entry.path().extension() == extension) names.push_back(entry.path().stem().string());
  std::ranges::sort(names);
  return names;
}

/// Sets a field of the prototype to the default that the definition gives.
Status set_default(const MessageView& message, const Field& field) {
  std::vector<std::string> items{field.default_text};
  if (field.array != ArrayKind::kSingle) {
    auto list = parse_list(field.default_text);
    if (!list) return list.error();
    items = std::move(*list);
    if (field.array == ArrayKind::kFixed && items.size() != field.size_limit)
      return input_error(found_expected(std::to_string(items.size()) + " values", std::to_string(field.size_limit)));
    if (field.is_sequence())
      if (Status status = message.resize(field, items.size()); !status) return status;
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto text = field.is_text() ? parse_text(items[i]) : Expected<std::string>(items[i]);
    if (!text) return text.error();
    const Status status = field.is_text() ? message.set_text(field, *text, i) : set_from_text(message, field, *text, i);
    if (!status) return status;
  }
  return {};
}

}  // namespace

std::string_view to_string(FieldType type) {
  static constexpr std::array<std::string_view, 16> kWords{
      "bool",   "byte",  "char",   "int8",    "uint8",   "int16",  "uint16",  "int32",
      "uint32", "int64", "uint64", "float32", "float64", "string", "wstring", "message"};
  return kWords[static_cast<std::size_t>(type)];
}

std::string Field::type_text() const {
  std::string text(nested != nullptr ? std::string_view(nested->name()) : to_string(type));
  if (string_limit > 0) text += "<=" + std::to_string(string_limit);
  if (array == ArrayKind::kFixed) text += '[' + std::to_string(size_limit) + ']';
  if (array == ArrayKind::kBounded) text += "[<=" + std::to_string(size_limit) + ']';
  if (array == ArrayKind::kUnbounded) text += "[]";
  return text;
}

MessageType::~MessageType() {
  if (prototype_ == nullptr) return;
  destroy(*this, prototype_);
  release(prototype_);
}

const Field* MessageType::find(std::string_view field) const {
  for (const Field& candidate : fields_)
    if (candidate.name == field) return &candidate;
  return nullptr;
}

bool MessageType::has_fields_of(const MessageType& other) const {
  return this == &other || std::ranges::equal(fields_, other.fields_, [](const Field& a, const Field& b) {
           return a.name == b.name && a.type == b.type && a.array == b.array && a.size_limit == b.size_limit &&
                  a.string_limit == b.string_limit && (!a.is_message() || a.nested->has_fields_of(*b.nested));
         });
}

std::vector<std::string> MessageType::field_names() const {
  std::vector<std::string> names;
  for (const Field& field : fields_) names.push_back(field.name);
  return names;
}

struct Registry::State {
  struct Package {
    std::vector<fs::path> folders;  ///< those that are asked first in front
    bool read = false;
  };
  std::map<std::string, Package> packages;
  // In order of compilation: a type's nested ones come before it, and are destroyed after it.
  std::vector<std::unique_ptr<MessageType>> owned;
  std::map<std::string, const MessageType*, std::less<>> messages;
  std::map<std::string, ServiceType> services;
  std::map<std::string, ActionType> actions;
  std::set<fs::path> files;
  std::vector<std::string> reading;  ///< the definitions that are being read, outermost first

  /// The file in the first folder of the package that has it; empty if none has.
  fs::path file_of(const std::string& package, const std::string& kind, const std::string& name) const {
    const auto known = packages.find(package);
    if (known == packages.end()) return {};
    for (const fs::path& folder : known->second.folders)
      if (fs::path file = folder / kind / (name + '.' + kind); is_file(file)) return file;
    return {};
  }

  ~State() {
    while (!owned.empty()) owned.pop_back();
  }
};

Registry::Registry() : state_(std::make_unique<State>()) {}
Registry::~Registry() = default;
Registry::Registry(Registry&&) noexcept = default;
Registry& Registry::operator=(Registry&&) noexcept = default;

bool holds_definitions(const fs::path& package) {
  return std::ranges::any_of(kForms, [&](const Form& form) { return is_folder(package / form.folder); });
}

Status Registry::add_package(const std::string& package, const fs::path& folder) {
  if (!is_identifier(package))
    return input_error(found_expected("package name '" + package + "'", "letters, digits and underscores"));
  std::error_code failure;
  if (!fs::is_directory(folder, failure))
    return input_error("package '" + package + "': found no folder", folder.string());
  if (!holds_definitions(folder))
    return input_error("package '" + package + "': found none of the folders msg, srv, action", folder.string());
  State::Package& known = state_->packages[package];
  if (!known.folders.empty() && known.folders.front() == folder) return {};
  if (known.read)
    return input_error("package '" + package + "' was already read from " + known.folders.front().string(),
                       folder.string());
  known.folders.insert(known.folders.begin(), folder);
  return {};
}

Status Registry::add_packages_in(const fs::path& folder) {
  std::error_code failure;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(folder, failure))
    if (is_identifier(entry.path().filename().string()) && holds_definitions(entry.path()))
      folders.push_back(entry.path());
  if (failure) return input_error("cannot read the folder: " + failure.message(), folder.string());
  std::ranges::sort(folders);
  for (const fs::path& package : folders)
    if (Status status = add_package(package.filename().string(), package); !status) return status;
  return {};
}

std::vector<std::string> Registry::packages() const {
  std::vector<std::string> names;
  for (const auto& [name, package] : state_->packages) names.push_back(name);
  return names;
}

std::vector<std::string> Registry::interfaces(const std::string& package) const {
  std::vector<std::string> names;
  const auto known = state_->packages.find(package);
  if (known == state_->packages.end()) return names;
  for (const Form& form : kForms) {
    const std::string kind(form.folder);
    for (const fs::path& folder : known->second.folders)
      for (const std::string& name : files_in(folder / kind, "." + kind))
        names.push_back(package + '/' + kind + '/' + name);
  }
  std::ranges::sort(names);
  const auto twice = std::ranges::unique(names);
  names.erase(twice.begin(), twice.end());
  return names;
}

std::vector<fs::path> Registry::files_read() const { return {state_->files.begin(), state_->files.end()}; }

Status Registry::read(const std::string& package, const std::string& folder, const std::string& name) {
  const std::string full = package + '/' + folder + '/' + name;
  const auto known = state_->packages.find(package);
  if (known == state_->packages.end())
    return input_error("package '" + package + "' of '" + full + "' is not known" + nearest_is(package, packages()));
  const fs::path path = is_identifier(name) ? state_->file_of(package, folder, name) : fs::path();
  if (path.empty())
    return input_error("'" + full + "' is not defined in package '" + package + "'" +
                       nearest_is(full, interfaces(package)));

  auto& reading = state_->reading;
  if (const auto outer = std::ranges::find(reading, full); outer != reading.end()) {
    std::string cycle;
    for (auto i = outer; i != reading.end(); ++i) cycle += *i + " -> ";
    return input_error("'" + full + "' contains itself: " + cycle + full);
  }
  if (reading.size() == kMaxNesting)
    return input_error("'" + full + "' is nested in " + std::to_string(kMaxNesting) + " messages, which is the most");

  const auto text = read_definition(path);
  if (!text) return text.error();
  known->second.read = true;
  state_->files.insert(path);
  const Form& form = *std::ranges::find_if(kForms, [&](const Form& f) { return f.folder == folder; });
  const auto sections = parse_definition(*text, path.string(), form.sections);
  if (!sections) return sections.error();

  std::vector<std::unique_ptr<MessageType>> types;
  reading.push_back(full);
  Status status;
  for (std::size_t i = 0; i < form.sections && status; ++i) {
    types.push_back(std::make_unique<MessageType>());
    types.back()->name_ = full + std::string(form.suffixes[i]);
    status = compile(*types.back(), (*sections)[i], package, path.string());
  }
  reading.pop_back();
  if (!status) return status;

  const auto part = [&](std::size_t i) { return types[i].get(); };
  if (form.sections == 2) state_->services[full] = ServiceType{full, part(0), part(1)};
  if (form.sections == 3) state_->actions[full] = ActionType{full, part(0), part(1), part(2)};
  for (auto& type : types) {
    state_->messages[type->name_] = type.get();
    state_->owned.push_back(std::move(type));
  }
  return {};
}

Status Registry::compile(MessageType& type, const Section& section, const std::string& package,
                         const std::string& file) {
  type.constants_ = section.constants;
  std::size_t end = 0;
  std::size_t serialized = 0;
  for (const FieldSpec& spec : section.fields) {
    Field field = spec.field;
    if (field.is_message()) {
      const std::string& name = spec.nested_name;
      const bool qualified = name.find('/') != std::string::npos;
      const bool header = name == "Header" && state_->file_of(package, "msg", "Header").empty();
      const auto nested = message(qualified ? name : (header ? "std_msgs" : package) + "/msg/" + name);
      if (!nested) {
        Error error = nested.error();
        if (error.line == 0) {  // found here, not inside the nested file
          error.file = file;
          error.line = spec.line;
        }
        return error;
      }
      field.nested = *nested;
    }
    const ElementSize element = element_size(field);
    field.stride = element.size;
    const std::size_t count = field.array == ArrayKind::kFixed ? field.size_limit : 1;
    const std::size_t size = field.is_sequence() ? sizeof(Sequence) : element.size * count;
    const std::size_t alignment = field.is_sequence() ? alignof(Sequence) : element.alignment;
    field.offset = (end + alignment - 1) / alignment * alignment;
    end = field.offset + size;
    if (end > kMaxMessageBytes)
      return input_error(
          "field '" + field.name + "' makes the message larger than " + std::to_string(kMaxMessageBytes) + " bytes",
          file, spec.line);
    type.alignment_ = std::max(type.alignment_, alignment);
    const bool counted = field.is_sequence() || field.is_text();
    type.plain_ = type.plain_ && !counted && (!field.is_message() || field.nested->plain());
    serialized += field.is_sequence() ? 4
                                      : count * (field.is_text()      ? 4
                                                 : field.is_message() ? field.nested->serialized_min()
                                                                      : element.size);
    type.fields_.push_back(std::move(field));
  }
  type.byte_size_ = std::max<std::size_t>(1, (end + type.alignment_ - 1) / type.alignment_ * type.alignment_);
  type.serialized_min_ = std::max<std::size_t>(1, serialized);

  type.prototype_ = allocate(type.byte_size_);
  std::fill_n(type.prototype_, type.byte_size_, std::byte{0});
  for (const Field& field : type.fields_) {
    if (field.is_sequence())
      new (type.prototype_ + field.offset) Sequence{};
    else
      construct_default_elements(field, type.prototype_ + field.offset,
                                 field.array == ArrayKind::kFixed ? field.size_limit : 1);
  }
  for (std::size_t i = 0; i < type.fields_.size(); ++i) {
    const Field& field = type.fields_[i];
    if (field.default_text.empty()) continue;
    if (Status status = set_default(MessageView(&type, type.prototype_), field); !status)
      return input_error("default of field '" + field.name + "' (" + field.type_text() + "): " + status.error().message,
                         file, section.fields[i].line);
  }
  return {};
}

Expected<const MessageType*> Registry::message(const std::string& name) {
  if (const auto known = state_->messages.find(name); known != state_->messages.end()) return known->second;
  std::vector<std::string> parts = split(name);
  if (parts.size() == 2) return message(parts[0] + "/msg/" + parts[1]);
  if (parts.size() == 3) {
    for (const Form& form : kForms) {
      if (form.folder != parts[1]) continue;
      for (std::size_t i = 0; i < form.sections; ++i) {
        const std::string_view suffix = form.suffixes[i];
        const std::string& last = parts[2];
        if (last.size() <= suffix.size() || last.substr(last.size() - suffix.size()) != suffix) continue;
        if (Status status = read(parts[0], parts[1], last.substr(0, last.size() - suffix.size())); !status)
          return status.error();
        return state_->messages.at(name);
      }
      return input_error(
          found_text(name, parts[0] + '/' + parts[1] + "/Name" + std::string(form.suffixes[0]) + " or the like"));
    }
  }
  return input_error(found_text(name, "a message type: package/msg/Name"));
}

Expected<const ServiceType*> Registry::service(const std::string& name) {
  const auto parts = split(name);
  if (parts.size() != 3 || parts[1] != "srv") return input_error(found_text(name, "a service type: package/srv/Name"));
  if (!state_->services.count(name))
    if (Status status = read(parts[0], parts[1], parts[2]); !status) return status.error();
  return &state_->services.at(name);
}

Expected<const ActionType*> Registry::action(const std::string& name) {
  const auto parts = split(name);
  if (parts.size() != 3 || parts[1] != "action")
    return input_error(found_text(name, "an action type: package/action/Name"));
  if (!state_->actions.count(name))
    if (Status status = read(parts[0], parts[1], parts[2]); !status) return status.error();
  return &state_->actions.at(name);
}

}  // namespace cxlab::bus
