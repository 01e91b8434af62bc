#pragma once
// What code beside the rules does on the bus between steps: the seat "python" of an episode, which joins when it is
// first used. Its turn in a tick calls nothing of Python.

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bindings.h"
#include "scenarios/seat.h"

namespace cxlab::python {

class Outside {
 public:
  static constexpr const char* kName = "python";
  /// A seat whose agent tells this object what comes; the object outlives it.
  Seat seat();

  void publish(const std::string& topic, const std::string& type, const std::string& yaml) {
    check(bus_->publish(topic, type, yaml));
  }
  /// The messages that came since the last call, with their times (s). The first call begins to listen.
  nb::list read(const std::string& topic, const std::string& type);
  /// The number of the call.
  std::size_t call(const std::string& service, const std::string& type, const std::string& yaml);
  /// The response; None before it has come.
  nb::object response(std::size_t call) const;
  std::size_t send_goal(const std::string& action, const std::string& type, const std::string& yaml);
  void cancel(std::size_t goal) { check(bus_->cancel(static_cast<SeatGoal>(goal))); }
  /// The episode will be closed: its types of messages go, and so what has come becomes objects of Python.
  void finish();
  /// {"accepted": None or bool, "feedback": [dict...], "succeeded": None or bool, "result": None or dict}.
  nb::object goal(std::size_t goal) const;

 private:
  struct Goal {
    std::optional<bool> accepted, succeeded;
    std::vector<bus::Message> feedback;
    bus::Message result;

    nb::dict state() const;
  };
  using Messages = std::vector<std::pair<SimTime, bus::Message>>;

  SeatBus* bus_ = nullptr;
  std::map<std::string, Messages> read_;  // by topic
  std::deque<std::optional<bus::Message>> calls_;
  std::deque<Goal> goals_;
  std::vector<nb::object> responses_, states_;  // of calls and goals, when it is finished
  bool finished_ = false;
};

}  // namespace cxlab::python
