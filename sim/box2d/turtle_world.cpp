#include "sim/box2d/turtle_world.h"

#include <box2d/box2d.h>
#include <xxhash.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace cxlab::sim {

namespace {

constexpr double kLargest = 1e6;
constexpr double kRadius = 0.45;  // m
const float kSideF = static_cast<float>(TurtleWorld::kSide);
constexpr int kVelocityIterations = 8, kPositionIterations = 3;  // what Box2D's manual suggests

double limited(double value) {
  assert(std::isfinite(value));
  return std::clamp(value, -kLargest, kLargest);
}

/// (-pi, pi]
double wrapped(double angle) {
  const double turn = 2 * std::numbers::pi;
  const double out = angle - turn * std::ceil((angle - std::numbers::pi) / turn);
  return out <= -std::numbers::pi ? std::numbers::pi : out;
}

}  // namespace

struct TurtleWorld::Body {
  b2Body* body = nullptr;
  SimTime commanded{};
  bool driven = false;  // a command holds
  bool at_wall = false;
};

/// Box2D's world, and which turtles began to touch in the last step.
struct TurtleWorld::Physics final : b2ContactListener {
  Physics() : world(b2Vec2(0, 0)) {
    world.SetAllowSleeping(false);
    world.SetContactListener(this);
  }
  void BeginContact(b2Contact* contact) override {
    touches.push_back({id_of(contact->GetFixtureA()), id_of(contact->GetFixtureB())});
  }
  static TurtleId id_of(b2Fixture* fixture) {
    return TurtleId{static_cast<std::int32_t>(fixture->GetUserData().pointer)};
  }

  b2World world;
  std::vector<Body> bodies;  // in the order of TurtleWorld::turtles_
  std::vector<std::pair<TurtleId, TurtleId>> touches;
};

TurtleWorld::TurtleWorld(const TurtleWorldOptions& options, TurtleLog* log)
    : options_(options), log_(log), physics_(std::make_unique<Physics>()) {
  assert(options.step > SimTime::zero());
}

TurtleWorld::~TurtleWorld() = default;

// --- Time

Status TurtleWorld::advance(SimTime duration) {
  now_ += duration;
  events_.clear();
  while (next_event() <= now_) step();
  return {};
}

SimTime TurtleWorld::next_event() const { return options_.start + (steps_ + 1) * options_.step; }

void TurtleWorld::step() {
  const SimTime end = next_event();
  const double dt = to_seconds(options_.step);
  for (std::size_t i = 0; i < turtles_.size(); ++i) {
    Turtle& turtle = turtles_[i];
    Body& body = physics_->bodies[i];
    if (body.driven && end - body.commanded > kHold) {
      body.driven = false;
      turtle.vx = turtle.vy = turtle.omega = 0;
    }
    // Turned first, then moved along the new heading, as turtlesim does.
    const double heading = body.body->GetAngle() + turtle.omega * dt;
    body.body->SetLinearVelocity(
        b2Vec2(static_cast<float>(std::cos(heading) * turtle.vx - std::sin(heading) * turtle.vy),
               static_cast<float>(std::sin(heading) * turtle.vx + std::cos(heading) * turtle.vy)));
    body.body->SetAngularVelocity(static_cast<float>(turtle.omega));
  }
  physics_->touches.clear();
  physics_->world.Step(static_cast<float>(dt), kVelocityIterations, kPositionIterations);
  ++steps_;
  for (const auto& [a, b] : physics_->touches) {
    const Turtle* turtle = find(a);
    events_.push_back({TurtleEvent::Kind::kTouch, a, b, turtle->x, turtle->y, true});
  }
  for (std::size_t i = 0; i < turtles_.size(); ++i) settle(physics_->bodies[i], turtles_[i]);
}

/// Takes over where Box2D has put the body, keeps it on the canvas, and lets the pen draw.
void TurtleWorld::settle(Body& body, Turtle& turtle) {
  const b2Vec2 at = body.body->GetPosition();
  const double angle = body.body->GetAngle(), theta = wrapped(angle);
  const b2Vec2 inside(std::clamp(at.x, 0.0f, kSideF), std::clamp(at.y, 0.0f, kSideF));
  const bool outside = inside.x != at.x || inside.y != at.y;
  if (outside) events_.push_back({TurtleEvent::Kind::kHitWall, turtle.id, {}, at.x, at.y, !body.at_wall});
  body.at_wall = outside;
  if (outside || theta != angle) body.body->SetTransform(inside, static_cast<float>(theta));
  const double from_x = turtle.x, from_y = turtle.y;
  turtle.x = inside.x;
  turtle.y = inside.y;
  turtle.theta = wrapped(body.body->GetAngle());
  if (turtle.x != from_x || turtle.y != from_y) draw(turtle, from_x, from_y);
}

void TurtleWorld::draw(const Turtle& turtle, double from_x, double from_y) {
  if (turtle.pen.off) return;
  const auto row = [](double y) { return Canvas::kSize - 1 - y * kPixelsPerMetre; };
  canvas_.line(from_x * kPixelsPerMetre, row(from_y), turtle.x * kPixelsPerMetre, row(turtle.y), turtle.pen);
}

// --- Verbs

void TurtleWorld::note(TurtleVerb verb, TurtleId id, const std::array<double, 5>& values) {
  if (log_) log_->record({steps_, verb, id, values});
}

TurtleWorld::Body* TurtleWorld::body(TurtleId id) {
  for (std::size_t i = 0; i < turtles_.size(); ++i)
    if (turtles_[i].id == id) return &physics_->bodies[i];
  return nullptr;
}

Turtle& TurtleWorld::turtle(const Body& body) {
  return turtles_[static_cast<std::size_t>(&body - physics_->bodies.data())];
}

const Turtle* TurtleWorld::find(TurtleId id) const {
  for (const Turtle& turtle : turtles_)
    if (turtle.id == id) return &turtle;
  return nullptr;
}

TurtleId TurtleWorld::spawn(double x, double y, double theta) {
  const TurtleId id{++last_id_};
  x = limited(x), y = limited(y), theta = limited(theta);
  note(TurtleVerb::kSpawn, id, {x, y, theta});
  b2BodyDef definition;
  definition.type = b2_dynamicBody;
  definition.position.Set(static_cast<float>(x), static_cast<float>(y));
  definition.angle = static_cast<float>(wrapped(theta));
  b2Body* made = physics_->world.CreateBody(&definition);
  if (options_.collisions) {
    b2CircleShape shell;
    shell.m_radius = static_cast<float>(kRadius);
    b2FixtureDef fixture;
    fixture.shape = &shell;
    fixture.density = 1;
    fixture.friction = 0;
    fixture.userData.pointer = static_cast<std::uintptr_t>(id);
    made->CreateFixture(&fixture);
  }
  Turtle turtle;
  turtle.id = id;
  turtle.x = made->GetPosition().x;
  turtle.y = made->GetPosition().y;
  turtle.theta = wrapped(made->GetAngle());
  turtles_.push_back(turtle);
  physics_->bodies.push_back({made, {}, false, false});
  return id;
}

void TurtleWorld::kill(TurtleId id) {
  Body* gone = body(id);
  if (!gone) return;
  note(TurtleVerb::kKill, id);
  physics_->world.DestroyBody(gone->body);
  const auto index = gone - physics_->bodies.data();
  physics_->bodies.erase(physics_->bodies.begin() + index);
  turtles_.erase(turtles_.begin() + index);
}

void TurtleWorld::drive(TurtleId id, double vx, double vy, double omega) {
  Body* driven = body(id);
  if (!driven) return;
  Turtle& t = turtle(*driven);
  t.vx = limited(vx);
  t.vy = limited(vy);
  t.omega = limited(omega);
  note(TurtleVerb::kDrive, id, {t.vx, t.vy, t.omega});
  driven->driven = true;
  driven->commanded = options_.start + steps_ * options_.step;
}

void TurtleWorld::teleport(TurtleId id, double x, double y, double theta) {
  if (Body* moved = body(id)) move(*moved, x, y, theta);
}

void TurtleWorld::teleport_relative(TurtleId id, double distance, double angle) {
  Body* moved = body(id);
  if (!moved) return;
  const Turtle& t = turtle(*moved);
  const double heading = t.theta + limited(angle), ahead = limited(distance);
  move(*moved, t.x + std::cos(heading) * ahead, t.y + std::sin(heading) * ahead, heading);
}

void TurtleWorld::move(Body& moved, double x, double y, double theta) {
  Turtle& t = turtle(moved);
  x = limited(x), y = limited(y), theta = limited(theta);
  note(TurtleVerb::kTeleport, t.id, {x, y, theta});
  moved.body->SetTransform(b2Vec2(static_cast<float>(x), static_cast<float>(y)), static_cast<float>(wrapped(theta)));
  const double from_x = t.x, from_y = t.y;
  t.x = moved.body->GetPosition().x;
  t.y = moved.body->GetPosition().y;
  t.theta = wrapped(moved.body->GetAngle());
  draw(t, from_x, from_y);
}

void TurtleWorld::set_pen(TurtleId id, const Pen& pen) {
  Body* owner = body(id);
  if (!owner) return;
  note(TurtleVerb::kPen, id,
       {double(pen.colour.r), double(pen.colour.g), double(pen.colour.b), double(pen.width), double(pen.off)});
  turtle(*owner).pen = pen;
}

void TurtleWorld::clear() {
  note(TurtleVerb::kClear, {});
  canvas_.clear();
}

void TurtleWorld::set_background(const Colour& colour) {
  note(TurtleVerb::kBackground, {}, {double(colour.r), double(colour.g), double(colour.b)});
  options_.background = colour;
}

Status TurtleWorld::apply(const TurtleWrite& write) {
  const auto& v = write.values;
  const bool about_one =
      write.verb != TurtleVerb::kSpawn && write.verb != TurtleVerb::kClear && write.verb != TurtleVerb::kBackground;
  const auto byte = [](double value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)); };
  if (about_one && !find(write.turtle))
    return input_error("the log of the turtles speaks of turtle " + std::to_string(static_cast<int>(write.turtle)) +
                       ", which is not there");
  switch (write.verb) {
    case TurtleVerb::kSpawn:
      if (spawn(v[0], v[1], v[2]) != write.turtle)
        return input_error("the log of the turtles numbers them differently");
      break;
    case TurtleVerb::kKill: kill(write.turtle); break;
    case TurtleVerb::kDrive: drive(write.turtle, v[0], v[1], v[2]); break;
    case TurtleVerb::kTeleport: teleport(write.turtle, v[0], v[1], v[2]); break;
    case TurtleVerb::kPen: set_pen(write.turtle, {{byte(v[0]), byte(v[1]), byte(v[2])}, byte(v[3]), v[4] != 0}); break;
    case TurtleVerb::kBackground: set_background({byte(v[0]), byte(v[1]), byte(v[2])}); break;
    case TurtleVerb::kClear: clear(); break;
  }
  return {};
}

// --- Queries

Colour TurtleWorld::colour_under(const Turtle& turtle) const {
  const auto pixel = [](double metres) {
    return static_cast<int>(std::lround(std::clamp(metres, 0.0, kSide) * kPixelsPerMetre));
  };
  return canvas_.ink(pixel(turtle.x), Canvas::kSize - 1 - pixel(turtle.y)).value_or(options_.background);
}

std::uint64_t TurtleWorld::hash() const {
  std::vector<double> state{static_cast<double>(steps_), static_cast<double>(last_id_), double(options_.background.r),
                            double(options_.background.g), double(options_.background.b)};
  for (std::size_t i = 0; i < turtles_.size(); ++i) {
    const Turtle& t = turtles_[i];
    const Body& body = physics_->bodies[i];
    const b2Vec2 velocity = body.body->GetLinearVelocity();
    state.insert(state.end(), {static_cast<double>(t.id), t.x, t.y, t.theta, t.vx, t.vy, t.omega, velocity.x,
                               velocity.y, body.driven ? to_seconds(body.commanded) : -1.0, double(t.pen.colour.r),
                               double(t.pen.colour.g), double(t.pen.colour.b), double(t.pen.width), double(t.pen.off)});
  }
  const std::uint64_t turtles = XXH64(state.data(), state.size() * sizeof(double), 0);
  return XXH64(canvas_.pixels().data(), canvas_.pixels().size() * sizeof(std::uint32_t), turtles);
}

// --- Replay

Status TurtleReplay::advance_to(SimTime t) {
  for (;;) {
    if (!next_ && !ended_) {
      auto read = reader_.next();
      if (!read) return read.error();
      next_ = *read;
      ended_ = !next_;  // the end: nothing more is read
    }
    if (!next_ || next_->step > world_.steps()) {
      if (world_.next_event() > t) break;
      if (Status s = world_.advance(world_.next_event() - world_.now()); !s) return s;
      continue;
    }
    if (Status s = world_.apply(*next_); !s) return s;
    next_.reset();
  }
  return world_.advance(t - world_.now());
}

}  // namespace cxlab::sim
