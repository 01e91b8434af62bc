#include "cx/protobuf/types.h"

#include <google/protobuf/compiler/importer.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <list>
#include <set>

namespace cxlab::pb {

namespace proto = google::protobuf;

namespace {

std::string name_of(MessageKey key) {
  return std::to_string(key.component_id) + ':' + std::to_string(key.message_type);
}

void add_names(const proto::Descriptor& type, std::vector<std::string>& out) {
  out.push_back(type.full_name());
  for (int i = 0; i < type.nested_type_count(); ++i)
    if (!type.nested_type(i)->options().map_entry()) add_names(*type.nested_type(i), out);
}

}  // namespace

/// The pool of types, which asks for files and keeps the first error.
struct Types::Reader final : proto::compiler::SourceTree, proto::compiler::MultiFileErrorCollector {
  explicit Reader(Types::Open open) : ask(std::move(open)), importer(this, this), factory(importer.pool()) {}

  proto::io::ZeroCopyInputStream* Open(const std::string& file) override {
    auto source = ask(file);
    if (!source) {
      if (!failure) failure = source.error();
      return nullptr;
    }
    if (!*source) {
      // The files that every file may import are part of the library.
      const proto::FileDescriptor* known = proto::DescriptorPool::generated_pool()->FindFileByName(file);
      if (!known || !file.starts_with("google/protobuf/")) return nullptr;
      source = std::optional(Types::Source{known->DebugString(), file});
    }
    paths[file] = (*source)->path;
    texts.push_back(std::move((*source)->text));
    return new proto::io::ArrayInputStream(texts.back().data(), static_cast<int>(texts.back().size()));
  }
  std::string GetLastErrorMessage() override { return "there is no such file among the .proto files"; }

  void AddError(const std::string& file, int line, int, const std::string& message) override {
    // The first, but where a file is missing that one which imports it.
    if (failure && !(missing && line >= 0)) return;
    missing = line < 0;
    const auto path = paths.find(file);
    failure = input_error(message, path == paths.end() ? file : path->second, line + 1);
  }

  Types::Open ask;
  std::map<std::string, std::string> paths;
  std::list<std::string> texts;
  std::optional<Error> failure;
  bool missing = false;
  proto::compiler::Importer importer;
  proto::DynamicMessageFactory factory;
  std::set<const proto::FileDescriptor*> files;
  std::vector<std::string> names;
};

Types::Types(Open open) : reader_(std::make_unique<Reader>(std::move(open))) {}
Types::~Types() = default;

Status Types::add_file(const std::string& file) {
  Reader& reader = *reader_;
  reader.failure.reset();
  reader.missing = false;
  const proto::FileDescriptor* read = reader.importer.Import(file);
  if (reader.failure) return *reader.failure;
  if (!read) return input_error("the file cannot be read", file);
  std::vector<const proto::FileDescriptor*> open{read};
  std::vector<std::string> added;
  while (!open.empty()) {
    const proto::FileDescriptor* next = open.back();
    open.pop_back();
    if (!reader.files.insert(next).second) continue;
    for (int i = 0; i < next->dependency_count(); ++i) open.push_back(next->dependency(i));
    for (int i = 0; i < next->message_type_count(); ++i) add_names(*next->message_type(i), added);
  }
  for (const std::string& name : added) {
    const proto::Descriptor* type = find(name);
    if (const auto key = key_of(*type)) keys_.emplace(*key, type);
  }
  reader.names.insert(reader.names.end(), added.begin(), added.end());
  return {};
}

const proto::Descriptor* Types::find(std::string_view full_name) const {
  return reader_->importer.pool()->FindMessageTypeByName(std::string(full_name));
}

const proto::Descriptor* Types::find(MessageKey key) const {
  const auto found = keys_.find(key);
  return found == keys_.end() ? nullptr : found->second;
}

std::optional<MessageKey> Types::key_of(const proto::Descriptor& type) {
  const proto::EnumDescriptor* numbers = type.FindEnumTypeByName("CompType");
  if (!numbers) return std::nullopt;
  const proto::EnumValueDescriptor* component = numbers->FindValueByName("COMP_ID");
  const proto::EnumValueDescriptor* message = numbers->FindValueByName("MSG_TYPE");
  if (!component || !message) return std::nullopt;
  const auto fits = [](int number) { return number >= 0 && number <= UINT16_MAX; };
  if (!fits(component->number()) || !fits(message->number())) return std::nullopt;
  return MessageKey{static_cast<std::uint16_t>(component->number()), static_cast<std::uint16_t>(message->number())};
}

Status Types::register_type(std::string_view full_name) {
  const proto::Descriptor* type = find(full_name);
  if (!type) {
    const std::string name(full_name);
    return input_error("there is no message type '" + name + "'" + did_you_mean(name, names()));
  }
  const auto key = key_of(*type);
  if (!key) return input_error("it has no enum CompType with COMP_ID and MSG_TYPE");
  const auto [known, is_new] = keys_.emplace(*key, type);
  if (known->second != type)
    return input_error("message type " + name_of(*key) + " is " + known->second->full_name() + " already");
  return {};
}

std::vector<std::string> Types::names() const {
  std::vector<std::string> out = reader_->names;
  std::ranges::sort(out);
  return out;
}

MessagePtr Types::make(const proto::Descriptor& type) const {
  return MessagePtr(reader_->factory.GetPrototype(&type)->New());
}

MessagePtr Types::make(std::string_view full_name) const {
  const proto::Descriptor* type = find(full_name);
  return type ? make(*type) : nullptr;
}

Expected<MessagePtr> Types::read(const Frame& frame) const {
  const proto::Descriptor* type = find(frame.key);
  if (!type) return input_error("Message type " + name_of(frame.key) + " not registered");
  MessagePtr message = make(*type);
  const proto::LogSilencer quiet;  // it writes of texts that are no UTF-8 to stderr
  if (!message->ParsePartialFromString(frame.content)) return input_error("the bytes are no " + type->full_name());
  if (!message->IsInitialized())
    return input_error(type->full_name() + " lacks required fields: " + message->InitializationErrorString());
  return message;
}

Expected<std::string> Types::write(const proto::Message& message, Crypto* crypto) {
  const proto::Descriptor& type = *message.GetDescriptor();
  const auto key = key_of(type);
  if (!key) return input_error(type.full_name() + " has no enum CompType with COMP_ID and MSG_TYPE");
  if (!message.IsInitialized())
    return input_error(type.full_name() + " lacks required fields: " + message.InitializationErrorString());
  const proto::LogSilencer quiet;
  std::string content;
  message.SerializePartialToString(&content);
  return write_frame(*key, content, crypto);
}

}  // namespace cxlab::pb
