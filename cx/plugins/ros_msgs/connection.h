#pragma once
// The endpoints that rules of one environment have opened through one plugin: publishers, subscriptions, clients,
// services, action clients, and the messages that came from them. The generic plugin and the bindings of interfaces are
// two vocabularies over it: each has its functions, facts and templates.

#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/executive/environment.h"
#include "cx/plugins/ros_msgs/fields.h"
#include "cx/plugins/ros_msgs/message_store.h"

namespace cxlab::cx {

/// UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED.
const char* status_word(bus::GoalStatus status);
/// How a goal ended: SUCCEEDED, CANCELED, ABORTED, else UNKNOWN.
const char* result_word(bus::GoalStatus status);

/// Endpoints and messages that rules did not close or destroy, in all environments of a plugin instance.
struct Leftovers {
  std::size_t messages = 0, client_goals = 0, server_goals = 0;  ///< handles
  std::vector<std::string> open;                                 ///< "Environment E has open NAME publishers"

  /// A line for each of them, as CX warns when the plugin is finalized.
  std::vector<std::string> lines() const;
};

class BusConnection {
 public:
  /// `logger` is the plugin instance, which owns functions and messages.
  BusConnection(Environment& environment, std::string logger);
  virtual ~BusConnection();
  BusConnection(const BusConnection&) = delete;
  BusConnection& operator=(const BusConnection&) = delete;

  /// Adds all templates and functions.
  virtual Status install() = 0;
  /// Closes what the rules have left open, adds it to `left`, and takes the templates away.
  virtual void close(Leftovers& left);

  struct Template {
    std::string name;
    std::string slots;  ///< as in its deftemplate
  };

 protected:
  struct Topic {
    bus::EndpointId endpoint{};
    const bus::MessageType* type = nullptr;
  };
  struct Service {
    bus::EndpointId endpoint{};
    const bus::ServiceType* type = nullptr;
    bool waited = false;  ///< clients: a request was sent before there was a server
  };
  struct ActionClient {
    bus::EndpointId endpoint{};
    const bus::ActionType* type = nullptr;
    bool waited = false;                  ///< a goal was sent before there was a server
    std::map<bus::GoalId, Handle> goals;  ///< that were accepted and have not ended
  };
  /// A goal of an action client.
  struct Goal {
    bus::EndpointId client{};
    std::string server;
    bus::GoalId id{};
    SimTime stamp{};
  };
  template <class Open>
  using ByName = std::map<std::string, Open, std::less<>>;

  // --- What comes from the bus becomes facts: each vocabulary has its own. Handles are new.
  virtual void on_message(const std::string& topic, Handle message);
  virtual void on_response(const std::string& service, std::uint64_t request, Handle response);
  virtual void on_goal_response(const std::string& server, Handle goal);  ///< none when it was rejected
  virtual void on_feedback(const std::string& server, Handle goal, Handle feedback);
  virtual void on_result(const std::string& server, const bus::Delivery& end, Handle result);
  virtual void on_cancel_response(const std::string& server, const bus::Delivery& response);
  /// The deffunction that answers requests to a service, with (service request response).
  virtual std::string callback_of(const std::string& service) const;

  // --- Verbs of functions. Names are as the rules write them. Opening fails the call when the bus refuses; opening
  // what is open and closing what is not warns. True = done.
  bool open_publisher(Call& call, const std::string& topic, const bus::MessageType& type);
  bool close_publisher(const std::string& topic);
  void publish(Call& call, Handle message, std::string_view topic);
  bool open_subscription(Call& call, const std::string& topic, const bus::MessageType& type);
  bool close_subscription(const std::string& topic);

  bool open_client(Call& call, const std::string& service, const bus::ServiceType& type);
  bool close_client(const std::string& service);
  /// The request's number; none after a failure. `wait`: for a server, else none and a warning when there is none.
  std::optional<std::uint64_t> request(Call& call, Handle request, const std::string& service, bool wait);
  bool open_service(Call& call, const std::string& service, const bus::ServiceType& type);
  bool close_service(const std::string& service);

  bool open_action_client(Call& call, const std::string& server, const bus::ActionType& type);
  bool close_action_client(const std::string& server);
  void send_goal(Call& call, Handle goal, const std::string& server);
  /// Null if there is none; then the call has failed.
  ActionClient* action_client(Call& call, std::string_view server);
  void cancel_goal(Call& call, std::string_view server, Handle goal);
  const Goal* find_goal(Handle goal) const;
  /// The error for a handle that `find_goal` does not know.
  static std::string unknown_goal(Handle goal);
  /// Of a goal that was accepted and has not ended; none otherwise.
  Handle handle_of(const std::string& server, const bus::GoalId& id) const;
  void destroy_goal(Handle goal);

  // --- Templates, functions, facts, log
  Status add_templates(std::span<const Template> templates);
  void remove_templates(std::span<const Template> templates);
  void put(const std::string& deftemplate, std::initializer_list<RuleEngine::Slot> slots);
  /// Retracts the facts of the template whose slot has that value.
  void take_back(const std::string& deftemplate, std::string_view slot, std::string_view value);
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
  std::string logger_;
  MessageStore& store_;
  MessageStore::Owner owner_;
  Fields fields_;
  ByName<Topic> publishers_, subscriptions_;
  ByName<Service> clients_, services_;
  ByName<ActionClient> action_clients_;
  std::map<Handle, Goal> goals_;
  /// The service or action server whose callback runs: destroyed there, it answers all the same.
  std::optional<bus::EndpointId> answering_;

 private:
  /// Warns with `missing` and the name where it is not open.
  template <class Open>
  bool close_one(ByName<Open>& open, const std::string& name, const char* missing) {
    const auto found = open.find(name);
    if (found == open.end()) {
      log(LogLevel::kWarn, missing + name);
      return false;
    }
    bus_.remove(found->second.endpoint);
    open.erase(found);
    return true;
  }
  void answer(const std::string& service, const bus::Delivery& request);
  void take_goal_response(const std::string& server, const bus::Delivery& delivery);
};

}  // namespace cxlab::cx
