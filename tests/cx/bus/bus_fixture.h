#pragma once
// A bus with participants that write down what they take.

#include "fixture.h"

namespace cxlab::bus {

class BusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    add_interfaces(registry_);
    string_ = *registry_.message("std_msgs/msg/String");
    number_ = *registry_.message("std_msgs/msg/Int32");
    set_bool_ = *registry_.service("std_srvs/srv/SetBool");
    fibonacci_ = *registry_.action("example_interfaces/action/Fibonacci");
  }

  ParticipantId join(ParticipantKind kind, const std::string& name, NodeName node = {}) {
    if (node.name.empty()) node.name = name;
    return bus_.join(kind, node, sink_.open_stream(name));
  }
  ParticipantId environment(const std::string& name) { return join(ParticipantKind::kEnvironment, name); }
  ParticipantId node(const std::string& name) { return join(ParticipantKind::kNode, name); }

  void tick() { bus_.begin_tick(now_ += SimTime{20'000'000}); }

  SharedMessage text(const std::string& value) const {
    Message message(*string_);
    message->set("data", value);
    return std::make_shared<Message>(std::move(message));
  }
  SharedMessage blank(const MessageType& type) const { return std::make_shared<Message>(type); }

  EndpointId advertise(ParticipantId p, const std::string& topic) { return *bus_.advertise(p, topic, *string_); }
  EndpointId subscribe(ParticipantId p, const std::string& topic, Handler also = nullptr) {
    return *bus_.subscribe(p, topic, *string_, [this, also](const Delivery& d) {
      log_.push_back(d.message->view().text("data"));
      if (also) also(d);
    });
  }
  /// What was taken since the last call.
  std::vector<std::string> taken() { return std::exchange(log_, {}); }
  std::vector<std::string> deliver(ParticipantId p) {
    bus_.deliver(p);
    return taken();
  }

  Registry registry_;
  MemorySink sink_;
  Bus bus_{registry_, sink_};
  SimTime now_{};
  const MessageType* string_ = nullptr;
  const MessageType* number_ = nullptr;
  const ServiceType* set_bool_ = nullptr;
  const ActionType* fibonacci_ = nullptr;
  std::vector<std::string> log_;
};

}  // namespace cxlab::bus
