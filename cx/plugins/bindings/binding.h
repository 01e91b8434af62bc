#pragma once
// The bindings of one message, service or action in one environment: docs/plugins/bindings.md. `P` in comments is the
// prefix of the interface, e.g. "std-msgs-string".

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cx/plugins/bindings/names.h"
#include "cx/plugins/ros_msgs/connection.h"

namespace cxlab::cx {

/// Base of the three kinds: names with the prefix, and the functions of one message type.
class Binding : public BusConnection {
 public:
  Binding(Environment& environment, std::string logger, std::string prefix)
      : BusConnection(environment, std::move(logger)), prefix_(std::move(prefix)) {}
  void close(Leftovers& left) override;

 protected:
  /// P-suffix.
  std::string named(std::string_view suffix) const;
  /// Adds P-suffix; it takes as many arguments as `arg_types` names.
  Status add(std::string_view suffix, const char* returns, const char* arg_types, FunctionKind kind, const char* doc,
             Function function);
  /// Adds P-`create`, P-`destroy`, P-`fields`get-field, P-`fields`set-field.
  Status add_fields(const std::string& create, const std::string& destroy, const std::string& fields,
                    const bus::MessageType& type);
  /// Adds P-suffix templates; they go with the plugin.
  Status add_all(std::vector<Template> suffixes);
  /// The message behind an argument must be of that type; else the call has failed.
  bool is_a(Call& call, Handle message, const bus::MessageType& type);
  /// As CX for an unknown handle: an ERROR line, and the rule continues.
  void unknown_handle(Call& call, const std::string& what);

  std::string prefix_;

 private:
  std::vector<Template> templates_;
};

class MessageBinding final : public Binding {
 public:
  MessageBinding(Environment& environment, std::string logger, std::string prefix, const bus::MessageType& type)
      : Binding(environment, std::move(logger), std::move(prefix)), type_(type) {}
  Status install() override;

 private:
  void on_message(const std::string& topic, Handle message) override;

  const bus::MessageType& type_;
};

class ServiceBinding final : public Binding {
 public:
  ServiceBinding(Environment& environment, std::string logger, std::string prefix, const bus::ServiceType& type)
      : Binding(environment, std::move(logger), std::move(prefix)), type_(type) {}
  Status install() override;

 private:
  void on_response(const std::string& service, std::uint64_t request, Handle response) override;
  std::string callback_of(const std::string&) const override { return named("service-callback"); }

  const bus::ServiceType& type_;
};

class ActionBinding final : public Binding {
 public:
  ActionBinding(Environment& environment, std::string logger, std::string prefix, const bus::ActionType& type)
      : Binding(environment, std::move(logger), std::move(prefix)), type_(type) {}
  Status install() override;
  void close(Leftovers& left) override;

 private:
  struct Server {
    bus::EndpointId endpoint{};
    std::map<bus::GoalId, Handle> goals;  ///< whose handles are there
  };
  /// A goal that a server of this binding has accepted.
  struct ServedGoal {
    std::string server;
    bus::EndpointId endpoint{};
    bus::GoalId id{};
    bus::SharedMessage message;
    Handle goal = Handle::kNone;  ///< the message's handle, which goes with that of the goal
  };

  Status install_server();
  Status install_client();

  // Server side (action_server.cpp)
  void create_server(Call& call);
  void destroy_server(Call& call);
  void take_goal(const std::string& server, const bus::Delivery& delivery);
  void take_cancel(const std::string& server, const bus::Delivery& delivery);
  /// The result of the callback: 1 .. `most`; `missing` without one, 1 (reject) after an error or another value.
  std::int64_t ask(const std::string& callback, std::initializer_list<Value> args, std::int64_t most,
                   std::int64_t missing);
  ServedGoal* served(Call& call);
  /// The handle of the goal's message; a new one if the rules have destroyed it.
  Handle goal_message(ServedGoal& goal);
  void end_goal(Call& call, bus::GoalStatus status);
  void destroy_served(Call& call);
  bool is_open(const std::string& server, bus::EndpointId endpoint) const;
  /// Nobody can end the goal any more; its client shall not wait for ever.
  void abort_unended(const ServedGoal& goal, LogLevel level, const char* why);

  // Client side (action_client.cpp)
  const Goal* sent(Call& call);
  void on_goal_response(const std::string& server, Handle goal) override;
  void on_feedback(const std::string& server, Handle goal, Handle feedback) override;
  void on_result(const std::string& server, const bus::Delivery& end, Handle result) override;
  void on_cancel_response(const std::string& server, const bus::Delivery& response) override;

  const bus::ActionType& type_;
  ByName<Server> servers_;
  std::map<Handle, ServedGoal> served_;
};

}  // namespace cxlab::cx
