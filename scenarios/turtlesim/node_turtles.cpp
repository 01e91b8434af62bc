// TurtlesimNode: spawning and killing turtles, and the services, topics and action of each turtle.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "cx/bus/needed.h"

#include "scenarios/turtlesim/node.h"

namespace cxlab::turtlesim {

namespace {

bool all_finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace

// --- Spawn and kill

Status TurtlesimNode::serve(Turtle& turtle, std::string_view service, const std::string& type, TurtleHandler handler) {
  auto found = bus_.registry().service(type);
  if (!found) return found.error();
  if (!bus::can_offer(bus_.registry(), "service " + bus_.name_of(*self_).expand(service), type)) return {};
  auto made = bus_.serve(*self_, service, **found,
                         [this, &turtle, handler](const bus::Delivery& request) { (this->*handler)(turtle, request); });
  if (!made) return made.error();
  turtle.endpoints.push_back(*made);
  return {};
}

Status TurtlesimNode::open(Turtle& turtle) {
  const std::string below = turtle.name + '/';
  const auto keep = [&turtle](Expected<bus::EndpointId> made, bus::EndpointId* place) {
    if (!made) return Status(made.error());
    turtle.endpoints.push_back(*made);
    if (place) *place = *made;
    return Status();
  };
  if (Status s = keep(bus_.advertise(*self_, below + "pose", *types_.pose), &turtle.pose); !s) return s;
  if (Status s = keep(bus_.advertise(*self_, below + "color_sensor", *types_.colour), &turtle.colour); !s) return s;
  const auto command = [this, &turtle](const bus::Delivery& message) { on_command(turtle, message); };
  if (Status s = keep(bus_.subscribe(*self_, below + "cmd_vel", *types_.twist, command), nullptr); !s) return s;
  if (Status s = serve(turtle, below + "set_pen", "turtlesim/srv/SetPen", &TurtlesimNode::on_pen); !s) return s;
  if (Status s =
          serve(turtle, below + "teleport_absolute", "turtlesim/srv/TeleportAbsolute", &TurtlesimNode::on_teleport);
      !s)
    return s;
  if (Status s = serve(turtle, below + "teleport_relative", "turtlesim/srv/TeleportRelative",
                       &TurtlesimNode::on_teleport_relative);
      !s)
    return s;
  bus::Bus::ActionServerHandlers handlers;
  handlers.goal = [this, &turtle](const bus::Delivery& goal) { on_rotate(turtle, goal); };
  handlers.cancel = [this, &turtle](const bus::Delivery& cancel) { on_cancel(turtle, cancel); };
  return keep(bus_.serve_action(*self_, below + "rotate_absolute", *types_.rotate, std::move(handlers)),
              &turtle.rotate);
}

Status TurtlesimNode::spawn(const std::string& name, double x, double y, double theta) {
  auto turtle = std::make_unique<Turtle>();
  turtle->name = name;
  if (Status s = open(*turtle); !s) {
    for (const bus::EndpointId endpoint : turtle->endpoints) bus_.remove(endpoint);
    return s;
  }
  turtle->id = world_.spawn(x, y, theta);
  turtle->story = stories_.size();
  const sim::Turtle& seen = *world_.find(turtle->id);
  stories_.push_back({name, true, seen.x, seen.y, seen.theta, 0, 0, 0, 0});
  char line[512];
  std::snprintf(line, sizeof line, "Spawning turtle [%s] at x=[%f], y=[%f], theta=[%f]", name.c_str(), x, y, theta);
  say(cx::LogLevel::kInfo, line);
  note(RecordKind::kControl, "spawn", name, {{"x", x}, {"y", y}, {"theta", theta}}, nullptr);
  turtles_.push_back(std::move(turtle));
  return {};
}

/// Takes the turtle away; `turtle` is gone afterwards.
void TurtlesimNode::kill(Turtle& turtle) {
  note(RecordKind::kControl, "kill", turtle.name, {}, nullptr);
  if (turtle.rotation && !turtle.rotation->arrived) end_rotation(turtle, bus::GoalStatus::kAborted);
  for (const bus::EndpointId endpoint : turtle.endpoints) bus_.remove(endpoint);
  world_.kill(turtle.id);
  stories_[turtle.story].alive = false;
  std::erase_if(turtles_, [&turtle](const auto& item) { return item.get() == &turtle; });
}

TurtlesimNode::Turtle* TurtlesimNode::find(const std::string& name) {
  for (const auto& turtle : turtles_)
    if (turtle->name == name) return turtle.get();
  return nullptr;
}

TurtlesimNode::Turtle* TurtlesimNode::find(sim::TurtleId id) {
  for (const auto& turtle : turtles_)
    if (turtle->id == id) return turtle.get();
  return nullptr;
}

std::string TurtlesimNode::free_name() {
  std::string name;
  do {
    name = "turtle" + std::to_string(++names_given_);
  } while (find(name));
  return name;
}

void TurtlesimNode::on_spawn(const bus::Delivery& request) {
  const bus::MessageView view = request.message->view();
  const double x = view.real("x"), y = view.real("y"), theta = view.real("theta");
  std::string name = view.text("name");
  if (name.empty()) name = free_name();
  std::string problem;
  if (find(name))
    problem = "A turtle named [" + name + "] already exists";
  else if (!is_turtle_name(name))
    problem = "A turtle cannot be named [" + name + "]: expected letters, digits and '_'";
  else if (!all_finite({x, y, theta}))
    problem = "Turtle [" + name + "] cannot be spawned at a place that is no number";
  if (problem.empty())
    if (Status s = spawn(name, x, y, theta); !s) problem = s.error().text();
  if (!problem.empty()) {
    say(cx::LogLevel::kError, problem);
    name.clear();
  }
  auto service = bus::needed_service(bus_.registry(), "turtlesim/srv/Spawn");
  bus::Message response(*(*service)->response);
  response.view().set("name", name);
  bus_.respond(request.endpoint, request, shared(std::move(response)));
}

void TurtlesimNode::on_kill(const bus::Delivery& request) {
  const std::string& name = request.message->view().text("name");
  if (Turtle* turtle = find(name))
    kill(*turtle);
  else
    say(cx::LogLevel::kError, "Tried to kill turtle [" + name + "], which does not exist");
  answer(request);
}

void TurtlesimNode::on_clear(const bus::Delivery& request) {
  say(cx::LogLevel::kInfo, "Clearing turtlesim.");
  note(RecordKind::kControl, "clear", "", {}, &request);
  world_.clear();
  answer(request);
}

void TurtlesimNode::on_reset(const bus::Delivery& request) {
  say(cx::LogLevel::kInfo, "Resetting turtlesim.");
  note(RecordKind::kControl, "reset", "", {}, &request);
  while (!turtles_.empty()) kill(*turtles_.back());
  names_given_ = 0;
  world_.clear();
  const StartTurtle first;
  if (Status s = spawn(free_name(), first.x, first.y, first.theta); !s) say(cx::LogLevel::kError, s.error().text());
  answer(request);
}

// --- Commands to a turtle

void TurtlesimNode::on_command(Turtle& turtle, const bus::Delivery& message) {
  const bus::MessageView twist = message.message->view();
  const bus::MessageView linear = twist.nested(*types_.linear), angular = twist.nested(*types_.angular);
  const std::array<double, 3> wanted{linear.real(*types_.vector_x), linear.real(*types_.vector_y),
                                     angular.real(*types_.vector_z)};
  if (!all_finite({wanted[0], wanted[1], wanted[2]})) {
    say(cx::LogLevel::kError, "Turtle [" + turtle.name + "] cannot move with a velocity that is no number");
    return;
  }
  if (turtle.rotation) {
    if (!turtle.rotation->arrived) {
      say(cx::LogLevel::kWarn, "Velocity command received during rotation goal. Aborting goal");
      end_rotation(turtle, bus::GoalStatus::kAborted);
    }
    turtle.rotation.reset();
  }
  if (wanted != turtle.commanded)
    note(RecordKind::kControl, "cmd_vel", turtle.name, {{"vx", wanted[0]}, {"vy", wanted[1]}, {"omega", wanted[2]}},
         &message);
  turtle.commanded = wanted;
  world_.drive(turtle.id, wanted[0], wanted[1], wanted[2]);
}

bool TurtlesimNode::may_go(const Turtle& turtle, std::initializer_list<double> place) {
  if (all_finite(place)) return true;
  say(cx::LogLevel::kError, "Turtle [" + turtle.name + "] cannot go to a place that is no number");
  return false;
}

void TurtlesimNode::count_teleport(const Turtle& turtle) {
  TurtleStory& story = stories_[turtle.story];
  ++story.teleports;
  story.x = world_.find(turtle.id)->x;
  story.y = world_.find(turtle.id)->y;
}

void TurtlesimNode::on_teleport(Turtle& turtle, const bus::Delivery& request) {
  const bus::MessageView view = request.message->view();
  const double x = view.real("x"), y = view.real("y"), theta = view.real("theta");
  if (may_go(turtle, {x, y, theta})) {
    world_.teleport(turtle.id, x, y, theta);
    count_teleport(turtle);
    note(RecordKind::kControl, "teleport", turtle.name, {{"x", x}, {"y", y}, {"theta", theta}}, &request);
  }
  answer(request);
}

void TurtlesimNode::on_teleport_relative(Turtle& turtle, const bus::Delivery& request) {
  const bus::MessageView view = request.message->view();
  const double linear = view.real("linear"), angular = view.real("angular");
  if (may_go(turtle, {linear, angular})) {
    world_.teleport_relative(turtle.id, linear, angular);
    count_teleport(turtle);
    note(RecordKind::kControl, "teleport_relative", turtle.name, {{"linear", linear}, {"angular", angular}}, &request);
  }
  answer(request);
}

void TurtlesimNode::on_pen(Turtle& turtle, const bus::Delivery& request) {
  const bus::MessageView view = request.message->view();
  const auto byte = [&](const char* field) { return static_cast<std::uint8_t>(view.integer(field)); };
  const sim::Pen pen{{byte("r"), byte("g"), byte("b")}, byte("width"), byte("off") != 0};
  world_.set_pen(turtle.id, pen);
  note(RecordKind::kControl, "set_pen", turtle.name,
       {{"r", pen.colour.r}, {"g", pen.colour.g}, {"b", pen.colour.b}, {"width", pen.width}, {"off", pen.off}},
       &request);
  answer(request);
}

void TurtlesimNode::on_rotate(Turtle& turtle, const bus::Delivery& goal) {
  const double theta = goal.message->view().real("theta");
  if (!std::isfinite(theta)) {
    bus_.answer_goal(goal.endpoint, goal.goal, bus::GoalAnswer::kReject);
    say(cx::LogLevel::kError, "Turtle [" + turtle.name + "] cannot turn to an angle that is no number");
    return;
  }
  if (turtle.rotation && !turtle.rotation->arrived) {
    say(cx::LogLevel::kWarn, "Rotation goal received before a previous goal finished. Aborting previous goal");
    end_rotation(turtle, bus::GoalStatus::kAborted);
  }
  bus_.answer_goal(goal.endpoint, goal.goal, bus::GoalAnswer::kAccept);
  turtle.rotation = Rotation{goal.goal, theta, world_.find(turtle.id)->theta, false};
  turtle.commanded = {};
  note(RecordKind::kControl, "rotate_absolute", turtle.name, {{"theta", theta}}, &goal);
}

void TurtlesimNode::on_cancel(Turtle& turtle, const bus::Delivery& cancel) {
  const bool running = turtle.rotation && turtle.rotation->goal == cancel.goal && !turtle.rotation->arrived;
  bus_.answer_cancel(cancel.endpoint, cancel, running);
  if (!running) return;
  end_rotation(turtle, bus::GoalStatus::kCanceled);
  turtle.rotation.reset();
  world_.drive(turtle.id, 0, 0, 0);
}

}  // namespace cxlab::turtlesim
