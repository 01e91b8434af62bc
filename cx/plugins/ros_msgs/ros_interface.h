#pragma once
// What the rules of one environment have opened on the bus: publishers, subscriptions, clients, services, action clients,
// and the messages that came from them.

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/executive/environment.h"
#include "cx/plugins/ros_msgs/message_store.h"

namespace cxlab::cx {

class RosInterface {
 public:
  RosInterface(Environment& environment, std::string logger)
      : environment_(environment), engine_(environment.engine()), bus_(environment.bus()), logger_(std::move(logger)), store_(engine_) {}

  /// Adds all templates and functions.
  Status install();
  /// Warns of what the rules have left open, closes it, and takes the templates away.
  void close();

 private:
  struct Entry {
    FunctionSpec spec;
    void (RosInterface::*function)(Call&);
  };
  struct Topic {
    bus::EndpointId endpoint{};
    const bus::MessageType* type = nullptr;
  };
  struct Service {
    bus::EndpointId endpoint{};
    const bus::ServiceType* type = nullptr;
  };
  struct ActionClient {
    bus::EndpointId endpoint{};
    const bus::ActionType* type = nullptr;
    bool waited = false;                      ///< a goal was sent before there was a server
    std::map<bus::GoalId, Handle> goals;      ///< that were accepted
  };
  struct Goal {
    bus::EndpointId client{};
    std::string server;
    bus::GoalId id{};
    SimTime stamp{};
  };
  template <class Open>
  using ByName = std::map<std::string, Open, std::less<>>;

  static std::vector<Entry> message_functions(const std::string& owner);
  static std::vector<Entry> topic_functions(const std::string& owner);
  static std::vector<Entry> service_functions(const std::string& owner);
  static std::vector<Entry> action_functions(const std::string& owner);

  // Messages and topics (topics.cpp)
  void create_message(Call& call);
  void destroy_message(Call& call);
  void get_field(Call& call);
  void set_field(Call& call);
  void create_publisher(Call& call);
  void destroy_publisher(Call& call);
  void create_subscription(Call& call);
  void destroy_subscription(Call& call);
  void publish(Call& call);

  // Services (services.cpp)
  void create_client(Call& call);
  void destroy_client(Call& call);
  void create_request(Call& call);
  void send_request(Call& call);
  void create_service(Call& call);
  void destroy_service(Call& call);
  void answer(const std::string& service, const bus::Delivery& request);

  // Action clients (action_clients.cpp)
  void create_action_client(Call& call);
  void destroy_action_client(Call& call);
  void create_goal(Call& call);
  void send_goal(Call& call);
  void cancel_goal(Call& call);
  void destroy_goal_handle(Call& call);
  void goal_id(Call& call);
  void goal_stamp(Call& call);
  void goal_status(Call& call);
  void is_aware(Call& call);
  void uuid_to_string(Call& call);
  void take_goal_response(const std::string& server, const bus::Delivery& delivery);
  void take_feedback(const std::string& server, const bus::Delivery& delivery);
  void take_result(const std::string& server, const bus::Delivery& delivery);
  void take_cancel_response(const std::string& server, const bus::Delivery& delivery);
  /// The goal behind a handle; else the call has failed.
  const Goal* find_goal(Call& call, std::size_t arg);
  Handle handle_of(const std::string& server, const bus::GoalId& id) const;

  void put(const char* deftemplate, std::initializer_list<RuleEngine::Slot> slots);
  /// Retracts the facts of the template whose slot has that value.
  void take_back(const char* deftemplate, std::string_view slot, std::string_view value);
  void log(LogLevel level, const std::string& text) { environment_.log(level, logger_, text); }
  template <class Open>
  void close_all(ByName<Open>& open, const std::string& what);

  Environment& environment_;
  RuleEngine& engine_;
  bus::Bus& bus_;
  std::string logger_;
  MessageStore store_;
  ByName<Topic> publishers_, subscriptions_;
  ByName<Service> clients_, services_;
  ByName<ActionClient> action_clients_;
  std::map<Handle, Goal> goals_;
};

}  // namespace cxlab::cx
