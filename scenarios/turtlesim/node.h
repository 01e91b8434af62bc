#pragma once
// The node `turtlesim`: names, topics, services and the action of ROS 2's turtlesim, on a world of turtles.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "cx/bus/transforms.h"
#include "cx/node/log.h"
#include "cx/node/parameters.h"
#include "cx/run/parts.h"
#include "scenarios/scene.h"
#include "scenarios/turtlesim/config.h"
#include "sim/box2d/turtle_world.h"

namespace cxlab::turtlesim {

/// The story of a turtle so far; killed turtles are included.
struct TurtleStory {
  std::string name;
  bool alive = true;
  double x = 0, y = 0, theta = 0;  ///< last seen, m, m, rad
  double driven_m = 0;             ///< way without jumps
  int walls = 0;                   ///< how often it came to a wall
  int touches = 0;                 ///< how often it began to touch another
  int teleports = 0;
};

inline bus::SharedMessage shared(bus::Message message) {
  return std::make_shared<const bus::Message>(std::move(message));
}

class TurtlesimNode final : public Server {
 public:
  /// Joins the bus now, or at the start that the configuration names. `log` may be none. All must outlive the node.
  static Expected<std::unique_ptr<TurtlesimNode>> create(const Config& config, sim::TurtleWorld& world, bus::Bus& bus,
                                                         RecordSink& sink, cx::LogSink* log);
  ~TurtlesimNode() override;

  /// After each step: pose and colour of each turtle, walls, feedback of rotations.
  Status sense(SimTime now) override;
  /// Commands, services, goals.
  Status act(SimTime now) override;
  SimTime next_due() const override;

  const sim::TurtleWorld& world() const { return world_; }
  const std::vector<TurtleStory>& stories() const { return stories_; }
  /// The canvas and the turtles on it.
  void list(SceneList& list) const;

 private:
  /// Message types and the fields that are written each step.
  struct Types {
    const bus::MessageType *pose = nullptr, *colour = nullptr, *twist = nullptr;
    const bus::ActionType* rotate = nullptr;
    const bus::Field *x = nullptr, *y = nullptr, *theta = nullptr, *linear_velocity = nullptr,
                     *angular_velocity = nullptr;
    const bus::Field *r = nullptr, *g = nullptr, *b = nullptr;
    const bus::Field *linear = nullptr, *angular = nullptr, *vector_x = nullptr, *vector_y = nullptr,
                     *vector_z = nullptr;

    Status find(bus::Registry& registry);
  };

  /// A goal of rotate_absolute that is being carried out.
  struct Rotation {
    bus::GoalId goal{};
    double theta = 0, from = 0;  ///< rad
    bool arrived = false;
  };

  struct Turtle {
    sim::TurtleId id{};
    std::string name;
    std::size_t story = 0;  // index
    bus::EndpointId pose{}, colour{}, rotate{};
    std::vector<bus::EndpointId> endpoints;  // all
    std::optional<Rotation> rotation;
    std::array<double, 3> commanded{};  // vx, vy, omega of the last message
  };
  using Handler = void (TurtlesimNode::*)(const bus::Delivery&);
  using TurtleHandler = void (TurtlesimNode::*)(Turtle&, const bus::Delivery&);

  TurtlesimNode(const Config& config, sim::TurtleWorld& world, bus::Bus& bus, RecordSink& sink, cx::LogSink* log);
  Status start();
  Status serve(std::string_view service, const std::string& type, Handler handler);
  Status serve(Turtle& turtle, std::string_view service, const std::string& type, TurtleHandler handler);

  // Turtles
  Status spawn(const std::string& name, double x, double y, double theta);
  void kill(Turtle& turtle);
  Status open(Turtle& turtle);
  Turtle* find(const std::string& name);
  Turtle* find(sim::TurtleId id);
  std::string free_name();

  // What comes in
  void on_spawn(const bus::Delivery& request);
  void on_kill(const bus::Delivery& request);
  void on_clear(const bus::Delivery& request);
  void on_reset(const bus::Delivery& request);
  void on_command(Turtle& turtle, const bus::Delivery& message);
  void on_teleport(Turtle& turtle, const bus::Delivery& request);
  void on_teleport_relative(Turtle& turtle, const bus::Delivery& request);
  bool may_go(const Turtle& turtle, std::initializer_list<double> place);
  void count_teleport(const Turtle& turtle);
  void on_pen(Turtle& turtle, const bus::Delivery& request);
  void on_rotate(Turtle& turtle, const bus::Delivery& goal);
  void on_cancel(Turtle& turtle, const bus::Delivery& cancel);

  Status serve_parameters();
  void apply_parameters();

  // What goes out
  void publish(Turtle& turtle);
  void report_events();
  void report_rotation(Turtle& turtle);
  void end_rotation(Turtle& turtle, bus::GoalStatus status);
  void answer(const bus::Delivery& request);
  void say(cx::LogLevel level, const std::string& text);
  void note(RecordKind kind, const char* what, const std::string& turtle,
            std::initializer_list<std::pair<const char*, double>> values, const bus::Delivery* because);

  Config config_;
  sim::TurtleWorld& world_;
  bus::Bus& bus_;
  RecordSink& sink_;
  cx::LogSink* log_;
  cx::Parameters parameters_;
  RecordData data_;
  std::string logger_ = "turtlesim";
  std::optional<bus::ParticipantId> self_;  // since the start
  Types types_;
  std::vector<std::unique_ptr<Turtle>> turtles_;
  std::vector<TurtleStory> stories_;
  std::optional<bus::TransformBroadcaster> transforms_;  // where they are wanted
  int names_given_ = 0;
  std::int64_t published_step_ = -1;
};

}  // namespace cxlab::turtlesim
