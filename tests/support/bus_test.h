#pragma once
// Participants on a bus that write down what they take.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/test_bus.h"

namespace cxlab::bus {

/// A folder of packages.
class TempPackages {
 public:
  /// `name` as in "pkg/msg/T". Returns the file.
  std::filesystem::path write(const std::string& name, const std::string& text) {
    const std::string kind = name.substr(name.find('/') + 1, name.rfind('/') - name.find('/') - 1);
    return folder_.write(name + '.' + kind, text);
  }
  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  TempFolder folder_;
};

class BusTest : public ::testing::Test, protected TestBus {
 protected:
  void SetUp() override {
    string_ = *registry_.message("std_msgs/msg/String");
    number_ = *registry_.message("std_msgs/msg/Int32");
    set_bool_ = *registry_.service("std_srvs/srv/SetBool");
    fibonacci_ = *registry_.action("example_interfaces/action/Fibonacci");
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
  /// The deliveries that were taken since the last call.
  std::vector<std::string> taken() { return std::exchange(log_, {}); }
  std::vector<std::string> deliver(ParticipantId p) {
    bus_.deliver(p);
    return taken();
  }

  SimTime now_{};
  const MessageType* string_ = nullptr;
  const MessageType* number_ = nullptr;
  const ServiceType* set_bool_ = nullptr;
  const ActionType* fibonacci_ = nullptr;
  std::vector<std::string> log_;
};

}  // namespace cxlab::bus
