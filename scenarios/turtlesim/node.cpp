#include "scenarios/turtlesim/node.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "cx/bus/needed.h"
#include "cx/node/parameter_services.h"

namespace cxlab::turtlesim {

namespace {

constexpr std::array<const char*, 3> kBackground{"background_r", "background_g", "background_b"};

std::string formatted(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

Status TurtlesimNode::Types::find(bus::Registry& registry) {
  const auto message = [&](const char* name, const bus::MessageType*& type) {
    auto found = bus::needed_message(registry, name);
    if (found) type = *found;
    return found ? Status() : Status(found.error());
  };
  if (Status s = message("turtlesim/msg/Pose", pose); !s) return s;
  if (Status s = message("turtlesim/msg/Color", colour); !s) return s;
  if (Status s = message("geometry_msgs/msg/Twist", twist); !s) return s;
  auto action = bus::needed_action(registry, "turtlesim/action/RotateAbsolute");
  if (!action) return action.error();
  rotate = *action;
  const bus::MessageType* vector = nullptr;
  if (Status s = message("geometry_msgs/msg/Vector3", vector); !s) return s;
  Status complete;
  const auto field = [&](const bus::MessageType& type, const char* name) {
    const bus::Field* found = type.find(name);
    if (!found && complete)
      complete = input_error("interface " + type.name() + " has no field '" + name +
                             "', which turtlesim's node fills or reads");
    return found;
  };
  x = field(*pose, "x"), y = field(*pose, "y"), theta = field(*pose, "theta");
  linear_velocity = field(*pose, "linear_velocity"), angular_velocity = field(*pose, "angular_velocity");
  r = field(*colour, "r"), g = field(*colour, "g"), b = field(*colour, "b");
  linear = field(*twist, "linear"), angular = field(*twist, "angular");
  vector_x = field(*vector, "x"), vector_y = field(*vector, "y"), vector_z = field(*vector, "z");
  return complete;
}

TurtlesimNode::TurtlesimNode(const Config& config, sim::TurtleWorld& world, bus::Bus& bus, RecordSink& sink,
                             cx::LogSink* log)
    : config_(config), world_(world), bus_(bus), sink_(sink), log_(log) {}

TurtlesimNode::~TurtlesimNode() {
  if (self_) bus_.leave(*self_);
}

Expected<std::unique_ptr<TurtlesimNode>> TurtlesimNode::create(const Config& config, sim::TurtleWorld& world,
                                                               bus::Bus& bus, RecordSink& sink, cx::LogSink* log) {
  std::unique_ptr<TurtlesimNode> node(new TurtlesimNode(config, world, bus, sink, log));
  if (Status s = node->types_.find(bus.registry()); !s) return s.error();
  if (config.start <= SimTime::zero())
    if (Status s = node->start(); !s) return s.error();
  return node;
}

Status TurtlesimNode::start() {
  bus::NodeName name{"turtlesim", config_.name_space, config_.remaps};
  say(cx::LogLevel::kInfo, "Starting turtlesim with node name " + name.full_name());
  const std::string stream = name.full_name().substr(1);
  self_ = bus_.join(bus::ParticipantKind::kNode, std::move(name), sink_.open_stream("node/" + stream));
  if (Status s = serve("clear", "std_srvs/srv/Empty", &TurtlesimNode::on_clear); !s) return s;
  if (Status s = serve("reset", "std_srvs/srv/Empty", &TurtlesimNode::on_reset); !s) return s;
  if (Status s = serve("spawn", "turtlesim/srv/Spawn", &TurtlesimNode::on_spawn); !s) return s;
  if (Status s = serve("kill", "turtlesim/srv/Kill", &TurtlesimNode::on_kill); !s) return s;
  if (Status s = serve_parameters(); !s) return s;
  if (config_.transforms) {
    auto made = bus::TransformBroadcaster::create(bus_, *self_);
    if (!made) return made.error();
    transforms_ = *std::move(made);
  }
  for (const StartTurtle& turtle : config_.turtles)
    if (Status s = spawn(turtle.name, turtle.x, turtle.y, turtle.theta); !s) return s;
  return {};
}

Status TurtlesimNode::serve(std::string_view service, const std::string& type, Handler handler) {
  auto found = bus_.registry().service(type);
  if (!found) return found.error();
  if (!bus::can_offer(bus_.registry(), "service " + bus_.name_of(*self_).expand(service), type)) return {};
  auto made = bus_.serve(*self_, service, **found,
                         [this, handler](const bus::Delivery& request) { (this->*handler)(request); });
  return made ? Status() : Status(made.error());
}

// --- Parameters: the colour of the background

Status TurtlesimNode::serve_parameters() {
  const sim::Colour now = world_.background();
  std::array<std::int64_t, 3> values{now.r, now.g, now.b};
  for (std::size_t i = 0; i < kBackground.size(); ++i)
    if (Status s = parameters_.declare(kBackground[i], values[i]); !s) return s;
  const auto served = cx::serve_parameters(bus_, *self_, parameters_,
                                           [](const std::string& name, const cx::Parameter& value) -> Status {
                                             const long number = std::strtol(value.text.c_str(), nullptr, 10);
                                             if (number < 0 || number > 255)
                                               return input_error(name + ": " + found_expected(value.text, "0 to 255"));
                                             return {};
                                           });
  return served ? Status() : served.error();
}

/// Somebody may have set them.
void TurtlesimNode::apply_parameters() {
  std::array<std::int64_t, 3> values{};
  for (std::size_t i = 0; i < kBackground.size(); ++i) (void)parameters_.read(kBackground[i], values[i]);
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(values[i]); };
  const sim::Colour wanted{byte(0), byte(1), byte(2)};
  if (wanted == world_.background()) return;
  world_.set_background(wanted);
  note(RecordKind::kControl, "background", "", {{"r", wanted.r}, {"g", wanted.g}, {"b", wanted.b}}, nullptr);
}

// --- The tick

SimTime TurtlesimNode::next_due() const { return self_ ? kNever : config_.start; }

Status TurtlesimNode::sense(SimTime now) {
  if (!self_) {
    if (now < config_.start) return {};
    if (Status s = start(); !s) return s;
  }
  if (published_step_ == world_.steps() || !bus_.is_there(*self_)) return {};
  published_step_ = world_.steps();
  report_events();
  for (const auto& turtle : turtles_) {
    publish(*turtle);
    if (turtle->rotation) report_rotation(*turtle);
  }
  if (transforms_) transforms_->post();
  return {};
}

Status TurtlesimNode::act(SimTime) {
  if (!self_ || !bus_.is_there(*self_)) return {};
  if (bus_.deliver(*self_) > 0) apply_parameters();
  for (const auto& turtle : turtles_) {
    if (!turtle->rotation) continue;
    const Rotation& rotation = *turtle->rotation;
    const double remaining = std::remainder(rotation.theta - world_.find(turtle->id)->theta, 2 * std::numbers::pi);
    world_.drive(turtle->id, 0, 0, rotation.arrived ? 0 : remaining < 0 ? -1 : 1);
    if (rotation.arrived) turtle->rotation.reset();
  }
  return {};
}

void TurtlesimNode::publish(Turtle& turtle) {
  const sim::Turtle& seen = *world_.find(turtle.id);
  const Types& t = types_;
  bus::Message pose(*t.pose);
  const bus::MessageView p = pose.view();
  const double speed = std::hypot(seen.vx, seen.vy);
  p.set_real(*t.x, seen.x);
  p.set_real(*t.y, seen.y);
  p.set_real(*t.theta, seen.theta);
  p.set_real(*t.linear_velocity, speed);
  p.set_real(*t.angular_velocity, seen.omega);
  bus_.publish(turtle.pose, shared(std::move(pose)));

  const sim::Colour under = world_.colour_under(seen);
  bus::Message colour(*t.colour);
  const bus::MessageView c = colour.view();
  (void)c.set_integer(*t.r, under.r);
  (void)c.set_integer(*t.g, under.g);
  (void)c.set_integer(*t.b, under.b);
  bus_.publish(turtle.colour, shared(std::move(colour)));
  if (transforms_) transforms_->set("world", turtle.name, bus::planar(seen.x, seen.y, seen.theta));

  TurtleStory& story = stories_[turtle.story];
  story.driven_m += std::hypot(seen.x - story.x, seen.y - story.y);
  story.x = seen.x;
  story.y = seen.y;
  story.theta = seen.theta;
}

void TurtlesimNode::report_events() {
  for (const sim::TurtleEvent& event : world_.events()) {
    Turtle* turtle = find(event.turtle);
    if (!turtle) continue;
    TurtleStory& story = stories_[turtle->story];
    if (event.kind == sim::TurtleEvent::Kind::kHitWall) {
      say(cx::LogLevel::kWarn, formatted("Oh no! I hit the wall! (Clamping from [x=%f, y=%f])", event.x, event.y));
      if (!event.first) continue;
      ++story.walls;
      note(RecordKind::kReferee, "wall", turtle->name, {{"x", event.x}, {"y", event.y}}, nullptr);
    } else if (Turtle* other = find(event.other)) {
      ++story.touches;
      ++stories_[other->story].touches;
      say(cx::LogLevel::kInfo, "Turtle [" + turtle->name + "] bumps into [" + other->name + "]");
      note(RecordKind::kReferee, "touch", turtle->name + ' ' + other->name, {{"x", event.x}, {"y", event.y}}, nullptr);
    }
  }
}

void TurtlesimNode::report_rotation(Turtle& turtle) {
  constexpr double kClose = 0.02;  // rad: at 1 rad/s one step turns by 0.016
  Rotation& rotation = *turtle.rotation;
  const double remaining = std::remainder(rotation.theta - world_.find(turtle.id)->theta, 2 * std::numbers::pi);
  bus::Message feedback(*types_.rotate->feedback);
  feedback.view().set("remaining", remaining);
  bus_.publish_feedback(turtle.rotate, rotation.goal, shared(std::move(feedback)));
  if (std::abs(remaining) >= kClose) return;
  end_rotation(turtle, bus::GoalStatus::kSucceeded);
  rotation.arrived = true;
}

void TurtlesimNode::end_rotation(Turtle& turtle, bus::GoalStatus status) {
  const Rotation& rotation = *turtle.rotation;
  bus::Message result(*types_.rotate->result);
  result.view().set("delta", std::remainder(rotation.from - world_.find(turtle.id)->theta, 2 * std::numbers::pi));
  bus_.finish(turtle.rotate, rotation.goal, status, shared(std::move(result)));
}

void TurtlesimNode::list(SceneList& list) const {
  constexpr EntityId kCanvas = 1;  // turtles come after it
  const auto hex = [](const sim::Colour& c) { return c.r * 0x10000U + c.g * 0x100U + c.b; };
  const auto text_of = [&](const sim::Colour& c) { return formatted("#%06x", hex(c)); };
  const auto look = [&](const std::array<double, 3>& size, std::uint32_t colour) {
    const Solid solid{Solid::Shape::kBox, size, {}, colour};
    return look_of({&solid, 1});
  };
  constexpr double kSide = sim::TurtleWorld::kSide, kThickness = 0.01;
  list.put({.number = kCanvas,
            .kind = "canvas",
            .name = "canvas",
            .state = text_of(world_.background()),
            .look = look({kSide, kSide, kThickness}, hex(world_.background())),
            .pose = {{kSide / 2, kSide / 2, -kThickness}},
            .fixed = true});
  for (const auto& turtle : turtles_) {
    const sim::Turtle* there = world_.find(turtle->id);
    if (!there) continue;
    const sim::Pen& pen = there->pen;
    list.put({.number = kCanvas + static_cast<EntityId>(turtle->id),
              .kind = "turtle",
              .name = turtle->name,
              .state = pen.off ? "pen off" : formatted("pen #%06x %d", hex(pen.colour), pen.width),
              .look = look({0.5, 0.4, 0.15}, 0x4c9a4c),
              .pose = {{there->x, there->y, 0}, {0, 0, there->theta}}});
  }
}

// --- Log and journal

void TurtlesimNode::say(cx::LogLevel level, const std::string& text) {
  if (log_) log_->line({bus_.now(), level, logger_, text, {}});
}

void TurtlesimNode::note(RecordKind kind, const char* what, const std::string& turtle,
                         std::initializer_list<std::pair<const char*, double>> values, const bus::Delivery* because) {
  data_.begin().field("what", what).field("turtle", turtle);
  for (const auto& [name, value] : values) data_.field(name, value);
  sink_.write(bus_.stream_of(*self_), bus_.now(), kind, data_,
              because ? std::span(&because->cause, 1) : std::span<const RecordRef>());
}

void TurtlesimNode::answer(const bus::Delivery& request) {
  const std::string type = request.message->view().type().name();  // "turtlesim/srv/Kill_Request"
  auto service = bus_.registry().service(type.substr(0, type.rfind('_')));
  if (service) bus_.respond(request.endpoint, request, shared(bus::Message(*(*service)->response)));
}

}  // namespace cxlab::turtlesim
