#pragma once
// The functions, facts and templates of cx::RosMsgsPlugin in one environment: docs/plugins/ros_msgs.md.

#include <array>
#include <string>
#include <vector>

#include "cx/plugins/ros_msgs/connection.h"

namespace cxlab::cx {

class RosInterface final : public BusConnection {
 public:
  using BusConnection::BusConnection;
  Status install() override;
  void close(Leftovers& left) override;

 private:
  struct Entry {
    FunctionSpec spec;
    void (RosInterface::*function)(Call&);
  };
  static std::vector<Entry> functions(const std::string& owner);
  static std::vector<Entry> action_functions(const std::string& owner);

  void create_message(Call& call);
  void destroy_message(Call& call);
  void get_field(Call& call);
  void set_field(Call& call);

  void create_publisher(Call& call);
  void destroy_publisher(Call& call);
  void create_subscription(Call& call);
  void destroy_subscription(Call& call);
  void publish(Call& call);
  void on_message(const std::string& topic, Handle message) override;

  void create_client(Call& call);
  void destroy_client(Call& call);
  void create_request(Call& call);
  void send_request(Call& call);
  void create_service(Call& call);
  void destroy_service(Call& call);
  void on_response(const std::string& service, std::uint64_t request, Handle response) override;
  std::string callback_of(const std::string& service) const override { return service + "-service-callback"; }

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
  void on_goal_response(const std::string& server, Handle goal) override;
  void on_feedback(const std::string& server, Handle goal, Handle feedback) override;
  void on_result(const std::string& server, const bus::Delivery& end, Handle result) override;
  void on_cancel_response(const std::string& server, const bus::Delivery& response) override;
  /// The goal behind a handle; else the call has failed.
  const Goal* goal_of(Call& call);

  /// The message type of that name; else the call has failed.
  const bus::MessageType* message_type(Call& call, const ValueRef& name);

  /// The last meaning of a name, by its atom: looked up once for each call site.
  struct Known {
    const void* atom = nullptr;
    const bus::MessageType* type = nullptr;
  };
  std::array<Known, 16> known_{};
};

}  // namespace cxlab::cx
