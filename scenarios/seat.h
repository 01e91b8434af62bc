#pragma once
// A seat: an agent of an episode that is a program instead of rules. On the bus it is a node of its name.
//
//   class Pilot final : public Agent {
//    public:
//     explicit Pilot(SeatBus& bus) : bus_(bus) {}
//     Status decide(SimTime now) override {
//       return bus_.publish("/turtle1/cmd_vel", "geometry_msgs/msg/Twist", "{linear: {x: 1}}");
//     }
//     ...
//   };
//   options.seats = {seat_of<Pilot>("pilot")};
//
// All that a seat sends is an input from outside: it is in the input log, so the run replays without the program. What
// it sends goes out in the order of the calls when the turn of the seat to decide comes, after all environments; what
// it sends while it is made goes out before the run starts.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/message.h"
#include "cx/run/parts.h"

namespace cxlab {

/// A message, or a text of one as `ros2 topic pub` takes it: "{linear: {x: 1}}". Missing fields have their defaults.
using SeatContent = std::variant<std::string, bus::Message>;

/// A goal that a seat has sent: 0, 1, ... in order.
enum class SeatGoal : std::uint32_t {};

using SeatReader = std::function<void(const bus::MessageView&)>;

/// Called with what comes back of a goal; each may be none.
struct GoalReaders {
  std::function<void(bool accepted)> answer = {};
  SeatReader feedback = {};
  std::function<void(bool succeeded, const bus::MessageView& result)> result = {};
};

/// What a seat can do on the bus. Names are those of ROS: relative ones get the namespace "/", "~" is the seat. Types
/// are those of packages that the run knows: "turtlesim/msg/Pose". Errors say what is wrong with a name, type or
/// content; then nothing is sent.
class SeatBus {
 public:
  virtual ~SeatBus() = default;
  /// Simulated time of the tick.
  virtual SimTime now() const = 0;
  /// A message of a type with all defaults, to be filled and sent: of a service its request, of an action its goal.
  virtual Expected<bus::Message> make(const std::string& type) const = 0;

  /// From now on the reader gets each message of the topic, in `perceive` of the seat's turn.
  virtual Status read(const std::string& topic, const std::string& type, SeatReader reader) = 0;
  virtual Status publish(const std::string& topic, const std::string& type, const SeatContent& message) = 0;
  /// A call waits until somebody serves the service.
  virtual Status call(const std::string& service, const std::string& type, const SeatContent& request,
                      SeatReader on_response = {}) = 0;
  /// A goal waits until somebody serves the action.
  virtual Expected<SeatGoal> send_goal(const std::string& action, const std::string& type, const SeatContent& goal,
                                       GoalReaders readers = {}) = 0;
  virtual Status cancel(SeatGoal goal) = 0;
};

/// An agent that hears, and speaks between ticks: its turn does nothing.
class QuietAgent : public Agent {
 public:
  Status perceive() override { return {}; }
  Status decide(SimTime) override { return {}; }
  Status act() override { return {}; }
  SimTime next_due() const override { return kNever; }
};

/// `make` is called when the episode is loaded. The bus outlives the agent. In each tick the agent perceives, decides
/// and acts once, after the environments; before it perceives, its readers are called. What it returns as an error ends
/// the run.
struct Seat {
  std::string name;  ///< of its node; letters, digits and '_', no other node has it
  std::function<Expected<std::unique_ptr<Agent>>(SeatBus& bus)> make;
  /// The time of the tick before, for a seat that joined between two ticks; less than 0 before the first.
  std::optional<SimTime> joins_after = {};
};

/// A seat whose agent is made from the bus and copies of these: `seat_of<Pilot>("pilot", speed)`.
template <class A, class... Args>
Seat seat_of(std::string name, Args... args) {
  return {std::move(name),
          [args...](SeatBus& bus) -> Expected<std::unique_ptr<Agent>> {
            return std::unique_ptr<Agent>(std::make_unique<A>(bus, args...));
          },
          {}};
}

}  // namespace cxlab
