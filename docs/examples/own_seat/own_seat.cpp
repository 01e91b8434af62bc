// An agent that is a program: it drives turtle1 beside the rules of a scenario. Each second the program prints how far
// the turtle is.
//
//   own_seat SCENARIO.yaml FOLDER

#include <lab/session.h>
#include <scenarios/seat.h>
#include <scenarios/shipped/catalogue.h>

#include <chrono>
#include <cmath>
#include <cstdio>

using namespace std::chrono_literals;

namespace {

int fail(const cxlab::Error& error) {
  std::fprintf(stderr, "error: %s\n", error.text().c_str());
  return static_cast<int>(error.kind);
}

/// Drives from the middle of the canvas to its right side, again whenever somebody has brought the turtle home.
class Pilot final : public cxlab::Agent {
 public:
  explicit Pilot(cxlab::SeatBus& bus) : bus_(bus) {
    reads_ = bus_.read("/turtle1/pose", "turtlesim/msg/Pose", [this](const auto& pose) { x_ = pose.real("x"); });
  }
  cxlab::Status perceive() override { return reads_; }
  cxlab::Status decide(cxlab::SimTime now) override {
    if (now < due_) return {};
    due_ = now + 500ms;
    const char* ahead = x_ < 6 ? "{linear: {x: 3}}" : "{linear: {x: 1}}";
    return bus_.publish("/turtle1/cmd_vel", "geometry_msgs/msg/Twist", ahead);
  }
  cxlab::Status act() override { return {}; }
  cxlab::SimTime next_due() const override { return due_; }

 private:
  cxlab::SeatBus& bus_;
  cxlab::Status reads_;
  cxlab::SimTime due_ = 1s;
  double x_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return fail(cxlab::usage_error("own_seat SCENARIO.yaml FOLDER"));
  auto scenario = cxlab::Scenario::load(argv[1], cxlab::shipped());
  if (!scenario) return fail(scenario.error());

  cxlab::lab::PlayOptions options;
  options.out = argv[2];
  options.seats = {cxlab::seat_of<Pilot>("pilot")};
  auto session = cxlab::lab::Session::load(options, *std::move(scenario));
  if (!session) return fail(session.error());

  for (cxlab::SimTime t = 1s;; t += 1s) {
    const auto step = (*session)->step(t);
    if (!step || step->over) break;
    const cxlab::Result so_far = (*session)->episode().result();
    std::printf("%4.1f s: %s m driven, %s times home\n", cxlab::to_seconds(step->now),
                so_far.at("turtles[0].driven_m").c_str(), so_far.at("turtles[0].teleports").c_str());
  }
  const cxlab::lab::Played played = (*session)->close();
  std::printf("journal %s\n", played.result.journal_hash.c_str());
  return played.failure ? fail(*played.failure) : 0;
}
