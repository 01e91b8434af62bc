#pragma once
// The bindings of one message, service or action in one environment: docs/reference/plugins/bindings.md. `P` in
// comments is the prefix of the interface, for example "std-msgs-string".

#include <map>
#include <string>

#include "cx/plugins/ros_msgs/connection.h"

namespace cxlab::cx {

/// Base of the three kinds, with the functions of one message type.
class Binding : public BusConnection {
 public:
  Binding(Environment& environment, std::string logger, std::string prefix)
      : BusConnection(environment, std::move(logger), std::move(prefix), /*bound=*/true) {}

 protected:
  /// Adds P-`create`, P-`destroy`, P-`fields`get-field, P-`fields`set-field. Messages that rules have not destroyed are
  /// counted as `what`(s).
  void add_fields(const std::string& what, const std::string& create, const std::string& destroy,
                  const std::string& fields, const bus::MessageType& type);
};

class MessageBinding final : public Binding {
 public:
  MessageBinding(Environment& environment, std::string logger, std::string prefix, const bus::MessageType& type)
      : Binding(environment, std::move(logger), std::move(prefix)), type_(type) {}

 private:
  void add_all() override;
  const bus::MessageType& type_;
};

class ServiceBinding final : public Binding {
 public:
  ServiceBinding(Environment& environment, std::string logger, std::string prefix, const bus::ServiceType& type)
      : Binding(environment, std::move(logger), std::move(prefix)), type_(type) {}

 private:
  void add_all() override;
  const bus::ServiceType& type_;
};

/// With a server, which the generic plugin does not have.
class ActionBinding final : public Binding {
 public:
  ActionBinding(Environment& environment, std::string logger, std::string prefix, const bus::ActionType& type)
      : Binding(environment, std::move(logger), std::move(prefix)), type_(type) {}
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

  void add_all() override;
  void add_server();
  void on_cancel_response(const std::string& server, const bus::Delivery& response) override;

  void create_server(Call& call);
  void destroy_server(Call& call);
  void take_goal(const std::string& server, const bus::Delivery& delivery);
  void take_cancel(const std::string& server, const bus::Delivery& delivery);
  /// The result of the callback: 1 .. `most`; 2 (accept) without one, 1 (reject) after an error or another value.
  std::int64_t ask(const std::string& callback, std::initializer_list<Value> args, std::int64_t most);
  ServedGoal* served(Call& call);
  /// The second argument must be a message of that type; else the call has failed.
  bool has_message(Call& call, const bus::MessageType& type);
  /// The handle of the goal's message; a new one if the rules have destroyed it.
  Handle goal_message(ServedGoal& goal);
  void end_goal(Call& call, bus::GoalStatus status);
  void destroy_served(Call& call);
  /// Fails a call for which the goal is in the wrong state.
  void fail_state(Call& call, const ServedGoal& goal, const char* expected);
  bool is_open(const std::string& server, bus::EndpointId endpoint) const;
  /// Aborts a goal that nobody can end any more, so that its client stops waiting.
  void abort_unended(const ServedGoal& goal, LogLevel level, const char* why);

  const bus::ActionType& type_;
  ByName<Server> servers_;
  std::map<Handle, ServedGoal> served_;
};

}  // namespace cxlab::cx
