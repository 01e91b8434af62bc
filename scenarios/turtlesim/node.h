#pragma once
// The node `turtlesim`: names, topics, services and the action of ROS 2's turtlesim, on a world of turtles.

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
#include "scenarios/turtlesim/config.h"
#include "sim/box2d/turtle_world.h"

namespace cxlab::turtlesim {

/// How a turtle has fared so far; those that were killed, too.
struct TurtleStory {
  std::string name;
  bool alive = true;
  double x = 0, y = 0, theta = 0;  ///< last seen, m, m, rad
  double driven_m = 0;             ///< way without jumps
  int walls = 0;                   ///< how often it came to a wall
  int touches = 0;                 ///< how often it began to touch another
  int teleports = 0;
};

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

 private:
  struct Types;
  struct Rotation;
  struct Turtle;
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
  std::unique_ptr<Types> types_;
  std::vector<std::unique_ptr<Turtle>> turtles_;
  std::vector<TurtleStory> stories_;
  std::optional<bus::TransformBroadcaster> transforms_;  // where they are wanted
  int names_given_ = 0;
  std::int64_t published_step_ = -1;
};

}  // namespace cxlab::turtlesim
