#pragma once
// The endpoints that rules of one environment have opened through one plugin: publishers, subscriptions, clients,
// services and action clients. It holds their messages too, and defines the functions and facts for all of these. The
// generic plugin and the bindings of interfaces share this class. The names of their functions differ. A binding has
// one type, while each call of the generic plugin names its type.

#include <array>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/executive/plugin.h"
#include "cx/plugins/ros_msgs/fields.h"
#include "cx/plugins/ros_msgs/message_store.h"

namespace cxlab::cx {

/// UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED.
const char* status_word(bus::GoalStatus status);

/// Endpoints and messages that rules did not close or destroy, in all environments of a plugin instance.
struct Leftovers {
  std::vector<std::string> open;                             ///< "Environment E has open NAME publishers"
  std::vector<std::pair<std::string, std::size_t>> handles;  ///< "message(s)" and how many, none too

  void add(std::string_view what, std::size_t count);
  /// A line for each of them, as CX warns when the plugin is finalized.
  std::vector<std::string> lines() const;
};

class BusConnection {
 public:
  /// `logger` is the plugin instance, which owns functions and messages. Names of functions and templates begin with
  /// `prefix`-. `bound`: to one interface.
  BusConnection(Environment& environment, std::string logger, std::string prefix, bool bound);
  virtual ~BusConnection() = default;
  BusConnection(const BusConnection&) = delete;
  BusConnection& operator=(const BusConnection&) = delete;

  /// Adds all templates and functions.
  Status install();
  /// Closes what the rules have left open, adds it to `left`, and takes the templates away.
  virtual void close(Leftovers& left);

  /// When a server that a goal or request waits for is reported as missing.
  SimTime next_warning() const;
  void warn_of_missing_servers();

 protected:
  /// What waits for a server.
  struct Waiting {
    SimTime since = kNever;
    bool warned = false;
  };
  struct Topic {
    bus::EndpointId endpoint{};
    const bus::MessageType* type = nullptr;
  };
  struct Service {
    bus::EndpointId endpoint{};
    const bus::ServiceType* type = nullptr;
    Waiting waiting;                           ///< clients: a request
    std::optional<SimTime> said_missing = {};  ///< clients: when the log last said so
  };
  struct ActionClient {
    bus::EndpointId endpoint{};
    const bus::ActionType* type = nullptr;
    Waiting waiting;                      ///< a goal
    std::map<bus::GoalId, Handle> goals;  ///< that were accepted and have not ended
  };
  /// A goal of an action client.
  struct Goal {
    bus::EndpointId client{};
    bus::GoalId id{};
    SimTime stamp{};
  };
  template <class Open>
  using ByName = std::map<std::string, Open, std::less<>>;

  // --- What `install` consists of. After an error the rest is left out.
  virtual void add_all() = 0;
  /// PREFIX-suffix; it takes as many arguments as `arg_types` names.
  void add(std::string_view suffix, const char* returns, const char* arg_types, FunctionKind kind, const char* doc,
           Function function);
  /// The deftemplate PREFIX-suffix, which goes with the plugin.
  void define(std::string_view suffix, const std::string& slots);
  // Functions and facts for endpoints of that type; null: of the type that a call names.
  void add_topics(const bus::MessageType* type);
  void add_services(const bus::ServiceType* type);
  void add_action_clients(const bus::ActionType* type);

  /// A cancel was answered.
  virtual void on_cancel_response(const std::string&, const bus::Delivery&) {}

  // --- For functions. Each fails the call if there is no such thing.
  const bus::MessageType* message_type(Call& call, const ValueRef& name);
  template <class Type>
  const Type* known(Call& call, const Expected<const Type*>& type) {
    if (type) return *type;
    call.fail(type.error().text());
    return nullptr;
  }
  ActionClient* action_client(Call& call, std::string_view server);
  /// The goal whose handle is the first argument. A binding does not fail the call, see `unknown_handle`.
  const Goal* goal_of(Call& call);
  /// As CX for an unknown handle: an ERROR line, and the rule continues.
  void unknown_handle(Call& call, const std::string& what);
  /// The handle of a goal that was accepted and has not ended; none otherwise.
  Handle handle_of(const std::string& server, const bus::GoalId& id) const;

  // --- Facts and log
  /// PREFIX-suffix.
  std::string named(std::string_view suffix) const { return prefix_ + '-' + std::string(suffix); }
  void put(const std::string& deftemplate, std::span<const RuleEngine::Slot> slots);
  void put(const std::string& deftemplate, std::initializer_list<RuleEngine::Slot> slots) {
    put(deftemplate, std::span(slots.begin(), slots.size()));
  }
  /// Retracts the facts of PREFIX-suffix whose slot has that value.
  void take_back(std::string_view suffix, std::string_view slot, std::string_view value);
  void log(LogLevel level, const std::string& text) { environment_.log(level, logger_, text); }
  template <class Open>
  void close_all(ByName<Open>& open, const std::string& what, Leftovers& left) {
    for (const auto& [name, entry] : open) {
      left.open.push_back("Environment " + environment_.name() + " has open " + name + ' ' + what);
      bus_.remove(entry.endpoint);
    }
    open.clear();
  }

  Environment& environment_;
  RuleEngine& engine_;
  bus::Bus& bus_;
  std::string logger_, prefix_;
  bool bound_;
  bool numbers_requests_;  ///< sends give the request's number, and do not wait for a server
  MessageStore& store_;
  MessageStore::Owner owner_;
  Fields fields_;
  /// What messages of a type are called that are left: "goal(s)"; others are messages.
  std::vector<std::pair<const bus::MessageType*, std::string>> words_;
  /// The service or action server whose callback runs: destroyed there, it answers all the same.
  std::optional<bus::EndpointId> answering_;

 private:
  /// Opens what the first argument names, and asserts the fact that it is open. Null if it was open before, with the
  /// warning `already`, and if the bus refuses, which fails the call.
  template <class Open, class Make>
  Open* open(Call& call, ByName<Open>& all, const char* fact, const char* slot, const char* already, Make make) {
    const std::string name(call.text(0));
    if (all.contains(name)) {
      log(LogLevel::kWarn, already + name);
      return nullptr;
    }
    const Expected<bus::EndpointId> endpoint = make(name);
    if (!endpoint) {
      call.fail(endpoint.error().text());
      return nullptr;
    }
    Open& opened = all[name];
    opened.endpoint = *endpoint;
    std::vector<RuleEngine::Slot> slots{{slot, Value::string(name)}};
    if (!bound_) slots.push_back({"type", Value::string(std::string(call.text(1)))});
    put(named(fact), slots);
    return &opened;
  }
  /// Closes it; `kind` begins the warning where it is not open: "Client".
  template <class Open>
  bool close_one(ByName<Open>& open, const std::string& name, const std::string& kind) {
    const auto found = open.find(name);
    if (found == open.end()) {
      log(LogLevel::kWarn, kind + ' ' + name + " not found in environment " + environment_.name());
      return false;
    }
    bus_.remove(found->second.endpoint);
    open.erase(found);
    return true;
  }
  /// The slots of the fact of what is open.
  std::string opened_slots(const std::string& slot) const {
    return "(slot " + slot + " (type STRING))" + (bound_ ? "" : " (slot type (type STRING))");
  }
  /// The fault of a call that sends a message of another type.
  static std::string wrong_type(const bus::MessageView& found, const std::string& of, const bus::MessageType& expected);

  void wait(Waiting& waiting);
  void reached(Waiting& waiting, const std::string& server);
  void publish(Call& call);
  void request(Call& call);
  bool close_service(const std::string& service);
  void answer(const std::string& service, const bus::Delivery& request);
  void send_goal(Call& call);
  void cancel_goal(Call& call);
  void take_goal_response(const std::string& server, const bus::Delivery& delivery);
  void take_feedback(const std::string& server, const bus::Delivery& delivery);
  void take_result(const std::string& server, const bus::Delivery& delivery);

  Status installed_;
  std::vector<std::string> templates_;
  ByName<Topic> publishers_, subscriptions_;
  ByName<Service> clients_, services_;
  ByName<ActionClient> action_clients_;
  int waiting_ = 0;  ///< clients whose server is missing, and not yet reported as such
  std::map<Handle, Goal> goals_;

  /// The last meaning of the name of a message type, by its atom: looked up once for each call site.
  struct KnownType {
    const void* atom = nullptr;
    const bus::MessageType* type = nullptr;
  };
  std::array<KnownType, 16> known_types_{};
};

/// A plugin with a connection in each of its environments.
class ConnectionPlugin : public Plugin {
 public:
  using Plugin::Plugin;
  Status clips_env_init(EnvironmentGuard environment) override;
  void clips_env_destroyed(EnvironmentGuard environment) override;
  void finalize() override;
  SimTime next_due(const Environment& environment) const override;
  Status on_due(EnvironmentGuard environment) override;

 private:
  virtual std::unique_ptr<BusConnection> connect(Environment& environment) = 0;
  PerEnvironment<std::unique_ptr<BusConnection>> connections_;
  Leftovers left_;
};

}  // namespace cxlab::cx
