#include <algorithm>
#include <array>
#include <set>

#include "cx/plugins/bindings/names.h"
#include "cx/plugins/builtin.h"
#include "cx/plugins/protobuf/fields.h"
#include "cx/plugins/protobuf/peers.h"

namespace cxlab::cx {

namespace {

namespace proto = google::protobuf;

constexpr const char* kRules = R"((deftemplate protobuf-msg
  "A message that has come. It is destroyed and retracted at the end of the run in which rules see it."
  (slot type (type STRING))
  (slot comp-id (type INTEGER))
  (slot msg-type (type INTEGER))
  (slot rcvd-via (type SYMBOL) (allowed-values STREAM BROADCAST))
  (multislot rcvd-from (cardinality 2 2))
  (slot rcvd-at (type FLOAT))
  (slot client-type (type SYMBOL) (allowed-values SERVER CLIENT PEER))
  (slot client-id (type INTEGER))
  (slot ptr (type EXTERNAL-ADDRESS)))
(deftemplate protobuf-receive-failed
  "Something came to a peer or a client that could not be read."
  (slot comp-id (type INTEGER))
  (slot msg-type (type INTEGER))
  (slot rcvd-via (type SYMBOL) (allowed-values STREAM BROADCAST))
  (multislot rcvd-from (cardinality 2 2))
  (slot client-id (type INTEGER))
  (slot message (type STRING)))
(deftemplate protobuf-server-receive-failed
  "Something came to the server that could not be read."
  (slot comp-id (type INTEGER))
  (slot msg-type (type INTEGER))
  (slot rcvd-via (type SYMBOL) (allowed-values STREAM BROADCAST))
  (multislot rcvd-from (cardinality 2 2))
  (slot client-id (type INTEGER))
  (slot message (type STRING)))
(defglobal ?*PRIORITY-PROTOBUF-RETRACT* = -10000)
(defrule protobuf-cleanup-receive-failed
  "It has been seen: say so, and forget it."
  (declare (salience ?*PRIORITY-PROTOBUF-RETRACT*))
  ?failed <- (protobuf-receive-failed (comp-id ?component) (msg-type ?type) (rcvd-via ?via) (rcvd-from ?host ?port)
    (client-id ?id) (message ?message))
  =>
  (retract ?failed)
  (printout t "Receiving from " ?host ":" ?port " failed (id " ?id ", " ?via ", type " ?component ":" ?type "): "
    ?message crlf))
(defrule protobuf-cleanup-server-receive-failed
  "It has been seen: say so, and forget it."
  (declare (salience ?*PRIORITY-PROTOBUF-RETRACT*))
  ?failed <- (protobuf-server-receive-failed (comp-id ?component) (msg-type ?type) (rcvd-via ?via)
    (rcvd-from ?host ?port) (client-id ?id) (message ?message))
  =>
  (retract ?failed)
  (printout t "Server: receiving from " ?host ":" ?port " failed (id " ?id ", " ?via ", type " ?component ":" ?type
    "): " ?message crlf))
(defrule protobuf-cleanup-message
  "A message lives until the end of the run that has seen it."
  (declare (salience ?*PRIORITY-PROTOBUF-RETRACT*))
  ?received <- (protobuf-msg (ptr ?message))
  =>
  (pb-destroy ?message)
  (retract ?received))
)";

constexpr const char* kClass = "cx::ProtobufPlugin";
constexpr std::string_view kPrefix = "cx::", kSuffix = "ProtobufPlugin", kExtension = ".proto";

/// All of one environment.
struct Connection {
  Connection(Environment& environment, const RunSettings& run, const pb::Types& types, ProtobufPeers::Log to_log)
      : messages(environment.engine()),
        peers(environment, *run.network, types, messages, to_log, run.next),
        log(std::move(to_log)) {}

  ProtobufMessages messages;
  ProtobufPeers peers;
  ProtobufPeers::Log log;
};

/// Talks to other programs in messages of .proto files.
class ProtobufPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status initialize() override {
    std::vector<std::string> paths, packages;
    if (Status s = parameter("proto_paths", paths); !s) return s;
    if (Status s = parameter("pkg_share_dirs", packages); !s) return s;
    types_ = std::make_unique<pb::Types>([this](const std::string& file) { return open(file); });
    if (type() != kClass && paths.empty()) return read_linked();
    for (const std::string& path : paths) {
      auto files = context().files.list(path, packages, kExtension, set_by_rules());
      if (!files) return context().parameters.error_at(name() + ".proto_paths", files.error().message);
      files_.merge(*files);
    }
    for (const auto& [file, found] : files_)
      if (file.find('/') == file.npos)  // those in folders below are there to be imported
        if (Status s = types_->add_file(file); !s) return s;
    return {};
  }

  Status clips_env_init(EnvironmentGuard environment) override {
    Environment& e = *environment;
    auto& connection = connections_.add(e, e, context().run, *types_,
                                        [this, &e](LogLevel level, std::string_view text) { log(e, level, text); });
    added_ = {};
    add_types_and_messages(e.engine(), connection);
    add_fields(e.engine(), connection);
    add_network(e.engine(), connection);
    if (added_ && !e.engine().has("deftemplate", "protobuf-msg"))
      added_ = e.engine().load_text(kRules, "cx_protobuf_plugin/protobuf.clp", LoadMode::kBatch).status();
    if (!added_)
      connections_.remove(e);
    else
      log(e, LogLevel::kInfo, "Initialised context!");
    return added_;
  }

  SimTime next_due(const Environment& environment) const override {
    const Connection* connection = connections_.find(environment);
    return connection && connection->peers.is_connecting() ? SimTime::zero() : kNever;
  }

  Status perceive(EnvironmentGuard environment) override {
    if (Connection* connection = connections_.find(*environment)) connection->peers.connect_now();
    return {};
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    if (const Connection* connection = connections_.find(*environment); connection && context().run.strict)
      report_leaks(*environment, *connection);
    if (connections_.find(*environment)) log(*environment, LogLevel::kInfo, "Destroying clips context!");
    connections_.remove(*environment);
  }

 private:
  using F = FunctionKind;

  /// Messages that rules have made or copied. One that has come, and no run has seen, is not theirs to destroy.
  void report_leaks(Environment& environment, const Connection& connection) {
    std::set<Handle> unseen;
    for (const FactCopy& fact : environment.engine().facts())
      if (fact.template_name == "protobuf-msg") unseen.insert(fact.slot("ptr")->as_handle());
    std::map<std::string, int> left;
    for (const auto& [handle, message] : connection.messages.all())
      if (!unseen.contains(handle)) ++left[message->GetDescriptor()->full_name()];
    for (const auto& [type, count] : left)
      context().note_load_error(input_error("strict-cx: leak: " + name() + ": environment " + environment.name() +
                                            " has not destroyed " + std::to_string(count) + " message(s) of type " +
                                            type));
  }

  // --- .proto files

  /// What `import` names.
  Expected<std::optional<pb::Types::Source>> open(const std::string& file) {
    const auto found = files_.find(file);
    if (found == files_.end()) return std::optional<pb::Types::Source>();
    const auto source = set_by_rules() ? for_rules(found->second) : Expected<FoundFile>(found->second);
    if (!source) return source.error();
    auto text = context().files.read(*source);
    if (!text) return text.error();
    return std::optional(pb::Types::Source{*std::move(text), source->path.string()});
  }

  /// What rules may have set names files that rules may read.
  bool set_by_rules() const {
    return std::ranges::any_of(std::array{".plugin", ".proto_paths", ".pkg_share_dirs"}, [this](const char* key) {
      const Parameter* parameter = context().parameters.find(name() + key);
      return parameter && parameter->at_run_time;
    });
  }
  Expected<FoundFile> for_rules(const FoundFile& file) const {
    const std::size_t slash = file.logical_name.find('/');
    const auto share = context().files.share_directory(file.logical_name.substr(0, slash));
    return context().files.find_for_rules(share && slash != std::string::npos ? *share + file.logical_name.substr(slash)
                                                                              : file.path.string());
  }

  /// The class of a package that was linked with its messages: here they are read from their files.
  Status read_linked() {
    const std::string stem = type().substr(kPrefix.size(), type().size() - kPrefix.size() - kSuffix.size());
    const std::vector<std::string> all = context().files.packages();
    std::vector<std::string> own;
    for (const std::string& package : all)
      if (camel_case(package).ends_with(stem)) own.push_back(package);
    for (const auto& packages : {own, all}) {
      for (const std::string& package : packages)
        if (Status s = add_files_of(package); !s) return s;
      if (!files_.empty()) break;
    }
    if (files_.empty())
      return context().parameters.error_at(
          name() + ".plugin", "plugin '" + name() + "' (" + type() +
                                  "): no package of the run has .proto files; name the one that has by --package "
                                  "NAME=DIR, or their folder by the parameter 'proto_paths'");
    for (const auto& [file, found] : files_)
      if (Status s = types_->add_file(file); !s) return s;
    return {};
  }

  /// Names in `import` are counted from the folder proto/, else from the topmost folders that have such files.
  Status add_files_of(const std::string& package) {
    auto in_proto = context().files.list("proto", {package}, kExtension);
    if (!in_proto && in_proto.error().code == cx::kRefused) return in_proto.error();
    if (in_proto && !in_proto->empty()) {
      files_.merge(*in_proto);
      return {};
    }
    auto files = context().files.list(".", {package}, kExtension);
    if (!files) return {};
    std::vector<std::string> roots;
    std::vector<std::string> names;
    for (const auto& [file, found] : *files) names.push_back(file);
    const auto depth = [](const std::string& file) { return std::ranges::count(file, '/'); };
    std::ranges::stable_sort(names, {}, depth);
    for (const std::string& file : names) {
      auto root = std::ranges::find_if(roots, [&](const std::string& r) { return file.starts_with(r); });
      if (root == roots.end()) root = roots.insert(roots.end(), file.substr(0, file.rfind('/') + 1));
      files_.emplace(file.substr(root->size()), files->at(file));
    }
    return {};
  }

  // --- Functions

  void add(RuleEngine& engine, const char* function, const char* returns, const char* arg_types, FunctionKind kind,
           const char* doc, Function body) {
    if (!added_) return;
    const std::string_view types(arg_types);
    const auto size = static_cast<std::uint16_t>(std::ranges::count(types, ';'));
    added_ = engine.add_function({function, returns, size, size, arg_types, kind, name(), doc}, std::move(body));
  }

  void add_types_and_messages(RuleEngine& engine, Connection& c) {
    add(engine, "pb-register-type", "b", ";sy", F::kActing, "Makes messages of that type known when they come.",
        [this, &c](Call& call) {
          const std::string type(call.text(0));
          const Status known = types_->register_type(type);
          if (!known)
            c.log(LogLevel::kError, "CLIPS-Protobuf: Registering type " + type + " failed: " + known.error().message);
          call.give_boolean(known.ok());
        });
    add(engine, "pb-create", "e", ";sy", F::kActing, "A new message; destroy it with pb-destroy.",
        [this, &c](Call& call) {
          auto message = types_->make(call.text(0));
          if (!message)
            c.log(LogLevel::kWarn, "CLIPS-Protobuf: Creating a message of type " + std::string(call.text(0)) +
                                       " failed: there is no such type" +
                                       did_you_mean(std::string(call.text(0)), types_->names()));
          call.give_handle(message ? c.messages.add(std::move(message)) : Handle::kNone);
        });
    add(engine, "pb-destroy", "v", ";e", F::kActing, "Destroys a message.",
        [&c](Call& call) { c.messages.destroy(call.handle(0)); });
    add(engine, "pb-tostring", "sy", ";e", F::kPure, "A message as text on one line.", [&c](Call& call) {
      const proto::Message* message = c.messages.find(call.handle(0));
      std::string text = message ? message->DebugString() : std::string();
      std::ranges::replace(text, '\n', ' ');
      call.give_string(text);
    });
  }

  using Field = proto::FieldDescriptor;
  /// A function of a message and one of its fields, which is null if there is none. Without a message it gives FALSE.
  using FieldFunction = std::function<void(Call&, proto::Message&, const Field*)>;

  void add_field(RuleEngine& engine, Connection& c, const char* function, const char* returns, const char* doc,
                 FieldFunction body) {
    add(engine, function, returns, ";e;sy", F::kPure, doc, [&c, body = std::move(body)](Call& call) {
      proto::Message* message = c.messages.find(call.handle(0));
      if (!message) return call.give_boolean(false);
      body(call, *message, message->GetDescriptor()->FindFieldByName(std::string(call.text(1))));
    });
  }

  static std::string no_field(const Call& call, const proto::Message& message) {
    return "Could not find field " + std::string(call.text(1)) + " of " + message.GetDescriptor()->full_name();
  }

  void add_fields(RuleEngine& engine, Connection& c) {
    add(engine, "pb-field-names", "mb", ";e", F::kPure, "Names of the fields of a message.", [&c](Call& call) {
      const proto::Message* message = c.messages.find(call.handle(0));
      if (!message) return call.give_boolean(false);
      std::vector<Value> names;
      for (int i = 0; i < message->GetDescriptor()->field_count(); ++i)
        names.push_back(Value::symbol(message->GetDescriptor()->field(i)->name()));
      call.give_list(names);
    });
    add_field(engine, c, "pb-field-type", "y", "DOUBLE, STRING, MESSAGE, ..., or DOES-NOT-EXIST.",
              [](Call& call, proto::Message&, const Field* field) {
                call.give_symbol(field ? type_word(*field) : "DOES-NOT-EXIST");
              });
    add_field(engine, c, "pb-field-label", "y", "OPTIONAL, REQUIRED, REPEATED, or DOES-NOT-EXIST.",
              [](Call& call, proto::Message&, const Field* field) {
                call.give_symbol(field ? label_word(*field) : "DOES-NOT-EXIST");
              });
    add_field(engine, c, "pb-has-field", "b", "Whether a field is set, or a list has elements.",
              [](Call& call, proto::Message& message, const Field* field) {
                const proto::Reflection& reflect = *message.GetReflection();
                call.give_boolean(field && (field->is_repeated() ? reflect.FieldSize(message, field) > 0
                                                                 : reflect.HasField(message, field)));
              });
    add_field(
        engine, c, "pb-field-is-list", "b", "Whether a field is a list.",
        [](Call& call, proto::Message&, const Field* field) { call.give_boolean(field && field->is_repeated()); });
    add_field(engine, c, "pb-field-value", "*", "The value of a field; a message is copied: destroy the copy.",
              [&c](Call& call, proto::Message& message, const Field* field) {
                if (!field) {
                  c.log(LogLevel::kWarn, no_field(call, message));
                  return call.give_symbol("DOES-NOT-EXIST");
                }
                if (field->is_repeated()) return call.fail(field->full_name() + " is a list, use pb-field-list");
                if (field->cpp_type() != Field::CPPTYPE_MESSAGE && field->has_presence() &&
                    !message.GetReflection()->HasField(message, field)) {
                  c.log(LogLevel::kWarn,
                        "Field " + field->name() + " of " + message.GetDescriptor()->full_name() + " is not set");
                  return call.give_symbol("NOT-SET");
                }
                call.give(field_value(message, *field, c.messages));
              });
    add_field(engine, c, "pb-field-list", "ym", "The elements of a list; messages are copied: destroy the copies.",
              [&c](Call& call, proto::Message& message, const Field* field) {
                if (!field) {
                  c.log(LogLevel::kWarn, no_field(call, message));
                  return call.give_symbol("DOES-NOT-EXIST");
                }
                std::vector<Value> items;
                if (!field->is_repeated()) {
                  items.push_back(field_value(message, *field, c.messages));
                } else {
                  for (int i = 0; i < message.GetReflection()->FieldSize(message, field); ++i)
                    items.push_back(field_value(message, *field, c.messages, i));
                }
                call.give_list(items);
              });
    add(engine, "pb-set-field", "v", ";e;sy;*", F::kActing, "Sets a field; a message is copied into it.",
        [this, &c](Call& call) { set(c, call, false); });
    add(engine, "pb-add-list", "v", ";e;sy;*", F::kActing, "Appends an element to a list; a message is copied.",
        [this, &c](Call& call) { set(c, call, true); });
  }

  void set(Connection& c, Call& call, bool list) {
    proto::Message* message = c.messages.find(call.handle(0));
    if (!message) return c.log(LogLevel::kWarn, call.spec().name + ": invalid message pointer");
    const Field* field = message->GetDescriptor()->FindFieldByName(std::string(call.text(1)));
    if (!field) return c.log(LogLevel::kWarn, no_field(call, *message));
    if (field->is_repeated() != list)
      return call.fail(field->full_name() + (list ? " is no list, use pb-set-field" : " is a list, use pb-add-list"));
    const auto problem = set_field(*message, *field, call.arg(2), c.messages, context().run.strict);
    if (!problem) return;
    if (problem->only_warn) return c.log(LogLevel::kWarn, problem->text);
    call.fail(field->full_name() + ": " + problem->text);
  }

  template <class T>
  static const T* value_of(Call& call, const Expected<T>& made) {
    if (made) return &*made;
    call.fail(made.error().message);
    return nullptr;
  }
  static void give_id(Call& call, const Expected<std::int64_t>& id) {
    if (const std::int64_t* given = value_of(call, id)) call.give_integer(*given);
  }

  /// A peer whose key and cipher are the last two arguments.
  static void give_crypto_peer(Connection& c, Call& call, const Expected<std::int64_t>& id) {
    const std::int64_t* given = value_of(call, id);
    if (!given) return;
    const std::size_t last = call.size() - 1;
    if (const Status s = c.peers.set_crypto(*given, std::string(call.text(last - 1)), call.text(last)); !s) {
      c.peers.destroy_peer(*given);
      return call.fail(s.error().message);
    }
    call.give_integer(*given);
  }

  void add_network(RuleEngine& engine, Connection& c) {
    add(engine, "pb-send", "v", ";l;e", F::kActing, "Sends a message to the client, server or peer of that id.",
        [&c](Call& call) {
          if (const proto::Message* message = c.messages.find(call.handle(1))) c.peers.send(call.integer(0), *message);
        });
    add(engine, "pb-server-enable", "v", ";l", F::kActing, "Opens a server for streams on that port.",
        [&c](Call& call) {
          if (const Status s = c.peers.enable_server(call.integer(0)); !s) call.fail(s.error().text());
        });
    add(engine, "pb-server-disable", "v", "", F::kActing, "Closes the server and its streams.",
        [&c](Call&) { c.peers.disable_server(); });
    add(engine, "pb-connect", "l", ";sy;l", F::kActing, "Connects to a server: an id, before it is connected.",
        [&c](Call& call) { give_id(call, c.peers.connect(std::string(call.text(0)), call.integer(1))); });
    add(engine, "pb-disconnect", "v", ";l", F::kActing, "Closes the stream of that id.", [&c](Call& call) {
      c.log(LogLevel::kInfo, "CLIPS-Protobuf: Disconnecting client " + std::to_string(call.integer(0)));
      c.peers.disconnect(call.integer(0));
    });
    add(engine, "pb-peer-create", "l", ";s;l", F::kActing, "A peer that broadcasts, and receives on the same port.",
        [&c](Call& call) { give_id(call, c.peers.create_peer(call.integer(1), 0)); });
    add(engine, "pb-peer-create-local", "l", ";sy;l;l", F::kActing,
        "A peer that sends to one port and receives on another.",
        [&c](Call& call) { give_id(call, c.peers.create_peer(call.integer(1), call.integer(2))); });
    add(engine, "pb-peer-create-crypto", "l", ";sy;l;sy;sy", F::kActing,
        "A peer that broadcasts encrypted: port, key, cipher.",
        [&c](Call& call) { give_crypto_peer(c, call, c.peers.create_peer(call.integer(1), 0)); });
    add(engine, "pb-peer-create-local-crypto", "l", ";sy;l;l;sy;sy", F::kActing,
        "A peer that sends to one port and receives on another, encrypted: key, cipher.",
        [&c](Call& call) { give_crypto_peer(c, call, c.peers.create_peer(call.integer(1), call.integer(2))); });
    add(engine, "pb-peer-destroy", "v", ";l", F::kActing, "Closes a peer.",
        [&c](Call& call) { c.peers.destroy_peer(call.integer(0)); });
    add(engine, "pb-peer-setup-crypto", "v", ";l;sy;sy", F::kActing,
        "From now on the peer is encrypted: key, cipher; \"\" ends that.", [&c](Call& call) {
          if (const Status s = c.peers.set_crypto(call.integer(0), std::string(call.text(1)), call.text(2)); !s)
            call.fail(s.error().message);
        });
    add(engine, "pb-broadcast", "v", ";l;e", F::kActing, "Sends a message to all that receive on the peer's port.",
        [&c](Call& call) {
          if (const proto::Message* message = c.messages.find(call.handle(1)))
            c.peers.broadcast(call.integer(0), *message);
        });
  }

  std::map<std::string, FoundFile> files_;  // by the names that `import` has
  std::unique_ptr<pb::Types> types_;
  PerEnvironment<Connection> connections_;
  Status added_;
};

std::unique_ptr<Plugin> make(PluginContext context) { return std::make_unique<ProtobufPlugin>(std::move(context)); }

}  // namespace

PluginType protobuf_plugin() { return {kClass, {"proto_paths", "pkg_share_dirs"}, make}; }

PluginType linked_protobuf_plugin() {
  PluginType family = protobuf_plugin();
  family.name = "cx::<Name>ProtobufPlugin";
  family.has = [](const std::string& type, bus::Registry&) {
    return type.starts_with(kPrefix) && type.ends_with(kSuffix) && type != kClass;
  };
  return family;
}

}  // namespace cxlab::cx
