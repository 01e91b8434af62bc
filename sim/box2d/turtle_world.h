#pragma once
// Turtles on a canvas, as ROS 2's turtlesim moves them, on Box2D: 45 pixels a metre, y up, a fixed step, one thread.
// Names, topics and services are the node's (scenarios/turtlesim).

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/run/parts.h"
#include "sim/box2d/canvas.h"
#include "sim/box2d/turtle_log.h"

namespace cxlab::sim {

struct TurtleWorldOptions {
  SimTime step = std::chrono::milliseconds(16);
  SimTime start{};  ///< of the first step's interval; nothing moves before
  Colour background{69, 86, 255};
  bool collisions = false;  ///< turtles are round, 0.9 m wide and push each other; else they pass through, as in ROS
};

/// A turtle as its pose message reports it.
struct Turtle {
  TurtleId id{};
  double x = 0, y = 0, theta = 0;  ///< m, m, rad (-pi, pi]
  double vx = 0, vy = 0;           ///< m/s ahead and to the left, as commanded, 0 when the command no longer holds
  double omega = 0;                ///< rad/s, likewise
  Pen pen;
};

/// Something that happened within an `advance`.
struct TurtleEvent {
  enum class Kind : std::uint8_t {
    kHitWall,  ///< clamped to the canvas; x, y are where it would have been
    kTouch,    ///< began to touch `other`
  };
  Kind kind{};
  TurtleId turtle{}, other{};
  double x = 0, y = 0;
  bool first = true;  ///< not at the wall in the step before
};

class TurtleWorld final : public Simulation {
 public:
  static constexpr double kPixelsPerMetre = 45;
  static constexpr double kSide = (Canvas::kSize - 1) / kPixelsPerMetre;  ///< m: x and y reach from 0 to this
  static constexpr SimTime kHold = std::chrono::seconds(1);               ///< how long a command of velocity holds

  /// `log`, if any, takes every write; it must outlive the world.
  explicit TurtleWorld(const TurtleWorldOptions& options, TurtleLog* log = nullptr);
  ~TurtleWorld() override;

  // --- Time
  /// Any duration: takes the steps whose time has come.
  Status advance(SimTime duration) override;
  SimTime next_event() const override;  ///< the time of the next step
  SimTime now() const { return now_; }
  std::int64_t steps() const { return steps_; }

  // --- What the node does, between steps. Numbers must be finite; those beyond 1e6 are taken as that. An unknown id
  // does nothing.
  TurtleId spawn(double x, double y, double theta);
  void kill(TurtleId turtle);
  /// Holds for kHold. Box2D moves nothing faster than 2 m and a quarter turn a step.
  void drive(TurtleId turtle, double vx, double vy, double omega);
  /// Draws a line there unless the pen is off.
  void teleport(TurtleId turtle, double x, double y, double theta);
  /// Turns by `angle`, then goes `distance` ahead.
  void teleport_relative(TurtleId turtle, double distance, double angle);
  void set_pen(TurtleId turtle, const Pen& pen);
  void clear();
  void set_background(const Colour& colour);

  // --- What can be seen
  std::span<const Turtle> turtles() const { return turtles_; }  ///< by id
  const Turtle* find(TurtleId id) const;
  const Canvas& canvas() const { return canvas_; }
  Colour background() const { return options_.background; }
  /// The canvas under the turtle: ink, else background.
  Colour colour_under(const Turtle& turtle) const;
  /// Events of the last `advance`, in order of time.
  std::span<const TurtleEvent> events() const { return events_; }
  /// Covers everything that later steps and pictures depend on.
  std::uint64_t hash() const;

  /// Carries out a write of a log, as the verbs do. kInput if it fits no turtle.
  Status apply(const TurtleWrite& write);

 private:
  struct Body;
  struct Physics;
  Body* body(TurtleId id);
  Turtle& turtle(const Body& body);
  void step();
  void settle(Body& body, Turtle& turtle);
  void move(Body& body, double x, double y, double theta);
  void draw(const Turtle& turtle, double from_x, double from_y);
  void note(TurtleVerb verb, TurtleId id, const std::array<double, 5>& values = {});

  TurtleWorldOptions options_;
  TurtleLog* log_;
  SimTime now_{};
  std::int64_t steps_ = 0;
  std::int32_t last_id_ = 0;
  std::unique_ptr<Physics> physics_;
  std::vector<Turtle> turtles_;
  Canvas canvas_;
  std::vector<TurtleEvent> events_;
};

/// Plays a world again from its log.
class TurtleReplay {
 public:
  /// `log` must outlive it.
  TurtleReplay(const TurtleWorldOptions& options, std::string_view log) : world_(options), reader_(log) {}
  Status advance_to(SimTime t);
  const TurtleWorld& world() const { return world_; }

 private:
  TurtleWorld world_;
  TurtleLogReader reader_;
  std::optional<TurtleWrite> next_;
  bool ended_ = false;
};

}  // namespace cxlab::sim
