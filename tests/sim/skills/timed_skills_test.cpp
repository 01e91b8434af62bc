// The skills of the timed tier: each phase with what is due next, each entry in the book, and how each skill ends.

#include "sim/skills/timed_skills.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sim/ledger/ledger_world.h"
#include "sim/skills/destination.h"

namespace cxlab::sim::timed_skills_test {
namespace {

constexpr SimTime kTick{20'000'000};
constexpr RobotId kRobot1{0}, kRobot2{1};
using Log = std::vector<std::string>;

FloorPlan small_floor() {
  FloorPlan plan;
  plan.stations = {{"C-BS", "BS", {1.5, 4, 0}, true}, {"C-RS1", "RS", {4.5, 4, 0}, true}};
  for (std::size_t i = 0; i < plan.stations.size(); ++i)
    for (Spot& spot : spots_of(plan.stations[i], static_cast<StationId>(i))) plan.spots.push_back(std::move(spot));
  plan.robots = {{"robot1", {-2, 4, 0}}, {"robot2", {-0.5, 2, 0}}};
  return plan;
}

std::string seconds(SimTime t) {
  if (t == kNever) return "never";
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", to_seconds(t));
  return text;
}

/// Passes entries on to the ledger and logs them.
class LoggedBook final : public RobotBook {
 public:
  LoggedBook(LedgerWorld& ledger, Log& log) : ledger_(ledger), log_(log) {}
  void move_along(RobotId robot, std::span<const Pose2> path, SimTime departure, SimTime arrival) override {
    char text[160];
    std::snprintf(text, sizeof text, "move %zu points (%.3f %.3f) to (%.3f %.3f %.2f), ", path.size(), path.front().x,
                  path.front().y, path.back().x, path.back().y, path.back().yaw);
    log_.push_back(text + seconds(departure) + " to " + seconds(arrival));
    ledger_.move_along(robot, path, departure, arrival);
  }
  void stop(RobotId robot) override {
    log_.push_back("stop");
    ledger_.stop(robot);
  }
  Status grasp(RobotId robot, SpotId from) override {
    log_.push_back("grasp " + ledger_.plan().spot(from).name);
    return ledger_.grasp(robot, from);
  }
  Status release(RobotId robot, SpotId to) override {
    log_.push_back("release " + ledger_.plan().spot(to).name);
    return ledger_.release(robot, to);
  }
  void drop(RobotId robot) override {
    log_.push_back("drop");
    ledger_.drop(robot);
  }

 private:
  LedgerWorld& ledger_;
  Log& log_;
};

/// robot1 with its skills; robot2 is known to the traffic only.
class Floor {
 public:
  explicit Floor(const TimedSkillsConfig& with = config())
      : traffic(world.plan()), book(world, calls), skills(kRobot1, world, book, traffic, with, 1) {}
  static TimedSkillsConfig config() {
    TimedSkillsConfig config;
    config.pick_mean_s = 3;
    config.discard_mean_s = 2.5;
    config.place_mean_s = 1;
    config.place_slide_mean_s = 2.25;
    config.pick_sigma_s = config.place_sigma_s = config.discard_sigma_s = 0;
    return config;
  }
  void start(SkillKind kind, const char* target) {
    const SpotId spot = *world.plan().find_spot(target);
    calls.push_back(std::string(to_string(kind)) + " " + target);
    skills.start({kind, target, spot, world.plan().spot(spot).align_in_world}, world.now());
  }
  void put(const char* at) {
    const Spot& spot = world.plan().spot(*world.plan().find_spot(at));
    (void)world.dispense(spot.station, spot.rest_in_station.x(), Stack{1, {}, 0});
  }
  void note() {
    for (const std::string& call : std::exchange(calls, {})) log.push_back(seconds(world.now()) + " " + call);
    const std::string state = std::string(to_string(skills.phase())) + ", due " + seconds(skills.next_due());
    if (std::exchange(last, state) != state) log.push_back(seconds(world.now()) + " " + state);
  }
  void tick(const std::function<void(double)>& act) {
    ASSERT_TRUE(world.advance(kTick));
    const SimTime now = world.now();
    traffic.settle(now);
    if (const auto result = skills.sense(now))
      calls.push_back("end " + std::to_string(static_cast<int>(result->code)) +
                      (result->cancelled ? " cancelled" : "") + (result->text.empty() ? "" : " " + result->text));
    note();
    act(to_seconds(now));
    traffic.plan(now);
    skills.act(now);
    note();
  }

  LedgerWorld world{small_floor()};
  Traffic traffic;
  Log calls, log;
  LoggedBook book;
  TimedSkills skills;
  std::string last;
};

TEST(TimedMeans, OfShelfAndSlideFollowThoseOfPickAndPlace) {
  TimedSkillsConfig config;
  config.pick_mean_s = 7;
  config.place_mean_s = 5;
  EXPECT_EQ(means_of(config).pick_shelf, 7);
  EXPECT_EQ(means_of(config).place_slide, 5);
  config.pick_shelf_mean_s = 9;
  config.place_slide_mean_s = 8;
  const HandlingMeans means = means_of(config);
  EXPECT_EQ((std::vector{means.pick, means.pick_shelf, means.place, means.place_slide}),
            (std::vector<double>{7, 9, 5, 8}));
}

TEST(TimedConfig, AValueOutOfItsRangeIsRefusedByItsName) {
  using Config = TimedSkillsConfig;
  const auto refused = [](auto key, double value) {
    Config config;
    config.*key = value;
    const Status valid = validate(config);
    return valid ? "" : valid.error().message.substr(0, valid.error().message.find(':'));
  };
  const std::pair<const char*, std::optional<double> Config::*> means[]{
      {"pick_mean_s", &Config::pick_mean_s},
      {"pick_shelf_mean_s", &Config::pick_shelf_mean_s},
      {"place_mean_s", &Config::place_mean_s},
      {"place_slide_mean_s", &Config::place_slide_mean_s},
      {"discard_mean_s", &Config::discard_mean_s}};
  for (const auto& [name, mean] : means) {
    for (const double wrong : {-0.01, 0.0}) EXPECT_EQ(refused(mean, wrong), name);
    EXPECT_EQ(refused(mean, 0.01), "") << name;
  }
  EXPECT_EQ(refused(&Config::shortest_s, 0), "shortest_s");
  const std::pair<const char*, double Config::*> sigmas[]{{"pick_sigma_s", &Config::pick_sigma_s},
                                                          {"place_sigma_s", &Config::place_sigma_s},
                                                          {"discard_sigma_s", &Config::discard_sigma_s}};
  for (const auto& [name, sigma] : sigmas) {
    EXPECT_EQ(refused(sigma, -0.01), name);
    EXPECT_EQ(refused(sigma, 0), "") << name;
  }
  const std::pair<const char*, double Config::*> shares[]{{"drive_sigma", &Config::drive_sigma},
                                                          {"drive_failure", &Config::drive_failure},
                                                          {"pick_failure", &Config::pick_failure},
                                                          {"place_failure", &Config::place_failure}};
  for (const auto& [name, share] : shares) {
    for (const double wrong : {-0.01, 1.01}) EXPECT_EQ(refused(share, wrong), name);
    for (const double right : {0.0, 1.0}) EXPECT_EQ(refused(share, right), "") << name;
  }
}

/// Where no wall stands, too.
TEST(Destination, ARobotTurnsFromTheBorderBeforeItLetsGoOfAPiece) {
  constexpr double kPi = std::numbers::pi;
  for (const Pose2& place :
       {Pose2{6.5, 2, 0}, Pose2{-6.5, 2, kPi}, Pose2{-2, 7.5, kPi / 2}, Pose2{-2, 0.5, -kPi / 2}}) {
    FloorPlan plan = small_floor();
    plan.robots[0].pose_in_world = place;
    const LedgerWorld world{plan};
    Traffic traffic{plan};
    const Pose2 stands = destination_of({SkillKind::kDiscard, "", std::nullopt, {}}, world, traffic, kRobot1).pose;
    EXPECT_EQ(stands.position(), place.position());
    const Vec3 lets_go = transform(stands, {kRobot.home_forward + kRobot.forward_stroke, 0, 0});
    EXPECT_GT(lets_go.x(), plan.min_x + 0.2);
    EXPECT_LT(lets_go.x(), plan.max_x - 0.2);
    EXPECT_GT(lets_go.y(), plan.min_y + 0.2);
    EXPECT_LT(lets_go.y(), plan.max_y - 0.2);
  }
}

/// How long a pick, a place, another pick and a discard take, s.
std::vector<double> handling_times(const TimedSkillsConfig& config) {
  Floor floor(config);
  std::vector<double> times;
  SkillPhase last{};
  for (int step = 0; step < 4; ++step) {
    if (step % 2 == 0) floor.put("C-BS-OUTPUT");
    step == 3
        ? floor.skills.start({SkillKind::kDiscard, "", std::nullopt, {}}, floor.world.now())
        : floor.start(step == 1 ? SkillKind::kPlace : SkillKind::kPick, step == 1 ? "C-RS1-INPUT" : "C-BS-OUTPUT");
    do
      floor.tick([&](double now) {
        const SkillPhase phase = floor.skills.phase();
        if (phase == SkillPhase::kHandle && last != phase) times.push_back(to_seconds(floor.skills.next_due()) - now);
        last = phase;
      });
    while (floor.skills.next_due() != kNever);
  }
  return times;
}

TEST(TimedMeans, EachKindOfSkillHasItsOwnSpread) {
  TimedSkillsConfig exact = Floor::config();
  exact.place_mean_s = 5;
  const std::vector<double> means = handling_times(exact);
  ASSERT_EQ(means.size(), 4U);
  const auto varied = [&](double TimedSkillsConfig::* spread) {
    TimedSkillsConfig config = exact;
    config.*spread = 0.2;
    const std::vector<double> times = handling_times(config);
    std::vector<bool> out;
    for (std::size_t i = 0; i < times.size(); ++i) out.push_back(std::abs(times[i] - means[i]) > 1e-6);
    return out;
  };
  EXPECT_EQ(varied(&TimedSkillsConfig::pick_sigma_s), (std::vector{true, false, true, false}));
  EXPECT_EQ(varied(&TimedSkillsConfig::place_sigma_s), (std::vector{false, true, false, false}));
  EXPECT_EQ(varied(&TimedSkillsConfig::discard_sigma_s), (std::vector{false, false, false, true}));
}

TEST(TimedTransport, LooksAheadForBothPartsAndChecksItsGripOnTheWay) {
  TimedSkillsConfig config = Floor::config();
  config.pick_mean_s = 20;
  config.place_mean_s = 15;
  Floor floor(config);
  floor.put("C-BS-OUTPUT");
  SkillGoal goal;
  goal.kind = SkillKind::kTransport;
  goal.spot = floor.world.plan().find_spot("C-BS-OUTPUT");
  goal.to = floor.world.plan().find_spot("C-RS1-INPUT");
  goal.pose = floor.world.plan().spot(*goal.spot).align_in_world;
  floor.skills.start(goal, floor.world.now());
  std::vector<double> handles;
  SkillPhase last{};
  for (int i = 0; i < 6000; ++i)
    floor.tick([&](double now) {
      const SkillPhase phase = floor.skills.phase();
      if (phase == SkillPhase::kHandle && last != phase) handles.push_back(to_seconds(floor.skills.next_due()) - now);
      last = phase;
    });
  ASSERT_EQ(handles.size(), 2U);
  EXPECT_NEAR(handles[0], 20 - 2.3 - 2, 1e-9);
  EXPECT_NEAR(handles[1], 15 - 2.3, 1e-9);
}

struct Case {
  const char* name;
  double until;
  std::function<void(Floor&, double)> act;  ///< at each tick
  const char* wanted;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

bool is(double now, double at) { return std::abs(now - at) < 1e-6; }

void discard(Floor& f) {
  f.calls.push_back("discard");
  f.skills.start({SkillKind::kDiscard, "", std::nullopt, {}}, f.world.now());
}

constexpr SkillKind kPick = SkillKind::kPick, kPlace = SkillKind::kPlace, kDriveTo = SkillKind::kDriveTo;

const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"Drive", 12,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.start(kDriveTo, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 0.10 drive_to C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), "
       "0.10 to 6.75; 0.10 drive, due 95.10; 6.76 end 0; 6.76 drive, due never; "},
      {"DriveThatIsCancelled", 6,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.start(kDriveTo, "C-BS-OUTPUT");
         if (is(now, 3)) f.skills.cancel(f.world.now());
       },
       "0.02 drive, due never; 0.10 drive_to C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), "
       "0.10 to 6.75; 0.10 drive, due 95.10; 3.00 move 3 points (-0.768 3.989) to (-0.774 3.989 0.00), 3.00 to 3.50; "
       "3.00 stop, due 3.00; 3.02 stop, due 3.50; 3.50 end 0 cancelled cancelled; 3.50 stop, due never; "},
      {"DriveThatIsReplaced", 14,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.start(kDriveTo, "C-BS-OUTPUT");
         if (is(now, 3)) f.skills.cancel(f.world.now());
         if (is(now, 5)) f.start(kDriveTo, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 0.10 drive_to C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), "
       "0.10 to 6.75; 0.10 drive, due 95.10; 3.00 move 3 points (-0.768 3.989) to (-0.774 3.989 0.00), 3.00 to 3.50; "
       "3.00 stop, due 3.00; 3.02 stop, due 3.50; 3.50 end 0 cancelled cancelled; 3.50 stop, due never; 5.00 drive_to "
       "C-BS-OUTPUT; 5.00 move 12 points (-0.774 3.989) to (0.825 3.975 0.00), 5.00 to 9.20; 5.00 drive, due 100.00; "
       "9.20 end 0; 9.20 drive, due never; "},
      {"DriveThatIsPlannedToBeginLater", 16,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.traffic.request(kRobot2, {-0.5, 7, 0}, {}, f.world.now());
         if (is(now, 1)) f.start(kDriveTo, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 1.00 drive_to C-BS-OUTPUT; 1.00 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), "
       "2.80 to 9.45; 1.00 wait, due 2.80; 2.80 drive, due 96.00; 9.46 end 0; 9.46 drive, due never; "},
      {"DriveAcrossAnother", 16,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.traffic.request(kRobot2, {-0.5, 7, 0}, {}, f.world.now());
         if (is(now, 0.1)) f.start(kDriveTo, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 0.10 drive_to C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), "
       "2.90 to 9.55; 0.10 wait, due 2.90; 2.90 drive, due 95.10; 9.56 end 0; 9.56 drive, due never; "},
      {"CancelOfNothing", 2,
       [](Floor& f, double now) {
         if (is(now, 1)) f.skills.cancel(f.world.now());
       },
       "0.02 drive, due never; "},
      {"PickAndPlace", 20,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 12)) f.start(kPlace, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 9.76 grasp C-BS-OUTPUT; 9.76 end 0; 9.76 handle, due "
       "never; 12.00 place C-BS-OUTPUT; 12.00 move 2 points (0.825 3.975) to (0.825 3.975 0.00), 12.00 to 12.05; 12.00 "
       "drive, due 107.00; 12.06 handle, due 14.06; 14.06 release C-BS-OUTPUT; 14.06 end 0; 14.06 handle, due never; "},
      {"PickThatIsCancelled", 14,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 8)) f.skills.cancel(f.world.now());
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 8.00 stop, due 8.00; 8.02 end 0 cancelled cancelled; "
       "8.02 stop, due never; "},
      {"PickThatFindsNothing", 10,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 end 202 no workpiece found; 6.76 drive, due never; "},
      {"PickOfAPieceThatGoes", 12,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 8)) f.world.retire(PieceId{1}, Holder::kFloor);
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 9.76 end 202 no workpiece found; 9.76 handle, due "
       "never; "},
      {"Payment", 24,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 12)) f.start(kPlace, "C-RS1-SLIDE");
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 9.76 grasp C-BS-OUTPUT; 9.76 end 0; 9.76 handle, due "
       "never; 12.00 place C-RS1-SLIDE; 12.00 move 30 points (0.825 3.975) to (5.175 4.250 3.14), 12.00 to 23.55; "
       "12.00 drive, due 107.00; 23.56 handle, due 25.81; "},
      {"PlaceOfNothing", 10,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.start(kPlace, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 0.10 place C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 end 208 no workpiece in gripper; 6.76 drive, due never; "},
      {"PickWithAFullGripperAndPlaceOntoAnother", 24,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 12)) {
           f.put("C-BS-OUTPUT");
           f.start(kPick, "C-BS-OUTPUT");
         }
         if (is(now, 13)) f.start(kPlace, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 9.76 grasp C-BS-OUTPUT; 9.76 end 0; 9.76 handle, due "
       "never; 12.00 pick C-BS-OUTPUT; 12.00 move 2 points (0.825 3.975) to (0.825 3.975 0.00), 12.00 to 12.05; 12.00 "
       "drive, due 107.00; 12.06 end 207 workpiece already in gripper; 12.06 drive, due never; 13.00 place "
       "C-BS-OUTPUT; 13.00 move 2 points (0.825 3.975) to (0.825 3.975 0.00), 13.00 to 13.00; 13.00 drive, due 108.00; "
       "13.02 end 209 machine point occupied; 13.02 drive, due never; "},
      {"DriveThatIsBlocked", 97,
       [](Floor& f, double now) {
         if (is(now, 0.02))
           f.traffic.request(kRobot2, f.world.plan().spots[1].align_in_world, f.world.plan().spots[1].footprint(),
                             f.world.now());
         if (is(now, 0.04)) f.start(kDriveTo, f.world.plan().spots[1].name.c_str());
       },
       "0.02 drive, due never; 0.04 drive_to C-BS-OUTPUT; 0.04 move 16 points (-2.000 4.000) to (0.300 3.500 0.00), "
       "0.04 to 5.74; 0.04 drive, due 95.04; 5.74 wait, due 95.04; 95.04 end 201 unable to move; 95.04 wait, due "
       "never; "},
      {"DriveInto", 3,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.skills.start({kDriveTo, "", std::nullopt, {1.5, 4, 0}}, f.world.now());
       },
       "0.02 drive, due never; 0.10 drive, due 95.10; 0.12 end 300 no path; 0.12 drive, due never; "},
      {"Drop", 12,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 11)) f.skills.drop(f.world.now());
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), 0.10 "
       "to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 9.76 grasp C-BS-OUTPUT; 9.76 end 0; 9.76 handle, due "
       "never; 11.00 drop; "},
      {"Discard", 18,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 11)) discard(f);
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 "
       "0.00), 0.10 to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 9.76 grasp C-BS-OUTPUT; 9.76 end "
       "0; 9.76 handle, due never; 11.00 discard; 11.00 move 6 points (0.825 3.975) to (0.825 3.975 -1.05), "
       "11.00 to 12.95; 11.00 drive, due 106.00; 12.96 handle, due 15.46; 15.46 drop; 15.46 end 0; 15.46 "
       "handle, due never; "},
      {"DiscardThatIsCancelled", 16,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.put("C-BS-OUTPUT");
         if (is(now, 0.1)) f.start(kPick, "C-BS-OUTPUT");
         if (is(now, 11)) discard(f);
         if (is(now, 14)) f.skills.cancel(f.world.now());
       },
       "0.02 drive, due never; 0.10 pick C-BS-OUTPUT; 0.10 move 18 points (-2.000 4.000) to (0.825 3.975 "
       "0.00), 0.10 to 6.75; 0.10 drive, due 95.10; 6.76 handle, due 9.76; 9.76 grasp C-BS-OUTPUT; 9.76 end "
       "0; 9.76 handle, due never; 11.00 discard; 11.00 move 6 points (0.825 3.975) to (0.825 3.975 -1.05), "
       "11.00 to 12.95; 11.00 drive, due 106.00; 12.96 handle, due 15.46; 14.00 stop, due 14.00; 14.02 end 0"
       " cancelled cancelled; 14.02 stop, due never; "},
      {"DiscardOfNothing", 2,
       [](Floor& f, double now) {
         if (is(now, 0.1)) discard(f);
       },
       "0.02 drive, due never; 0.10 discard; 0.10 move 2 points (-2.000 4.000) to (-2.000 4.000 0.00), 0.10 "
       "to 0.10; 0.10 drive, due 95.10; 0.12 end 208 no workpiece in gripper; 0.12 drive, due never; "},
      {"DriveHeadOn", 24,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.traffic.request(kRobot2, {-2, 4, 0}, {}, f.world.now());
         if (is(now, 1)) f.start(kDriveTo, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 1.00 drive_to C-BS-OUTPUT; 1.00 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), "
       "1.00 to 7.65; 1.00 drive, due 96.00; 7.66 end 0; 7.66 drive, due never; "},
      {"DriveCloseBehindAnother", 14,
       [](Floor& f, double now) {
         if (is(now, 0.1)) f.traffic.request(kRobot2, {-0.5, 5.5, 0}, {}, f.world.now());
         if (is(now, 2.5)) f.start(kDriveTo, "C-BS-OUTPUT");
       },
       "0.02 drive, due never; 2.50 drive_to C-BS-OUTPUT; 2.50 move 18 points (-2.000 4.000) to (0.825 3.975 0.00), "
       "2.90 to 9.55; 2.50 wait, due 2.90; 2.90 drive, due 97.50; 9.56 end 0; 9.56 drive, due never; "},
  };
  return all;
}

class TimedSkill : public testing::TestWithParam<Case> {};

TEST_P(TimedSkill, WritesTheBookAndEndsInTime) {
  Floor f;
  while (to_seconds(f.world.now()) < GetParam().until) f.tick([&](double now) { GetParam().act(f, now); });
  std::string log;
  for (const std::string& line : f.log) log += line + "; ";
  EXPECT_EQ(log, GetParam().wanted);
}

INSTANTIATE_TEST_SUITE_P(Table, TimedSkill, testing::ValuesIn(cases()),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(WaitingPick, EndsAtTheMomentToWhichItMayWait) {
  for (const double seconds : {0.0, 0.02, 0.2, 0.5, 3.0}) {
    Floor f;
    const SpotId spot = *f.world.plan().find_spot("C-BS-OUTPUT");
    SkillGoal goal{kPick, "C-BS-OUTPUT", spot, f.world.plan().spot(spot).align_in_world};
    goal.wait = from_seconds(seconds);
    f.skills.start(goal, f.world.now());
    std::optional<SimTime> arrived;
    while (f.skills.next_due() != kNever && to_seconds(f.world.now()) < 60) {
      f.tick([](double) {});
      if (f.skills.phase() == SkillPhase::kLook && !arrived) arrived = f.world.now();
    }
    ASSERT_EQ(arrived.has_value(), seconds > 0);
    const std::string& end = f.log.at(f.log.size() - 2);
    EXPECT_EQ(end.substr(end.find(' ') + 1, 7), "end 202") << end;
    EXPECT_EQ(to_seconds(f.world.now() - arrived.value_or(f.world.now())), seconds);
  }
}

/// The times of so many drives from one spot to another.
std::vector<double> drive_times(double sigma, int drives) {
  TimedSkillsConfig config = Floor::config();
  config.drive_sigma = sigma;
  Floor f(config);
  std::vector<double> times;
  for (int i = 0; i < drives; ++i) {
    for (const char* target : {"C-BS-OUTPUT", "C-RS1-INPUT"}) {
      f.start(kDriveTo, target);
      f.tick([](double) {});
      const auto& motion = *f.traffic.motion(kRobot1);
      if (i > 0 && target[2] == 'B') times.push_back(to_seconds(motion.duration()));
      while (f.skills.next_due() != kNever) f.tick([](double) {});
    }
  }
  return times;
}

TEST(DriveTimes, AreAsPlannedWithoutNoise) {
  const std::vector<double> times = drive_times(0, 5);
  EXPECT_EQ(std::ranges::min(times), std::ranges::max(times));
}

TEST(DriveTimes, SpreadByAShareOfWhatIsPlanned) {
  const double planned = drive_times(0, 2).front();
  const std::vector<double> times = drive_times(0.25, 151);
  double sum = 0, squares = 0;
  for (const double time : times) {
    sum += time / planned;
    squares += (time / planned - 1) * (time / planned - 1);
  }
  const auto n = static_cast<double>(times.size());
  EXPECT_NEAR(sum / n, 1, 0.06);
  EXPECT_NEAR(std::sqrt(squares / n), 0.25, 0.04);
}

TEST(DriveTimes, AreAtLeastTwoFifthsOfWhatIsPlanned) {
  const double planned = drive_times(0, 2).front();
  const std::vector<double> times = drive_times(1, 40);
  EXPECT_NEAR(std::ranges::min(times), 0.4 * planned, 0.1);
  EXPECT_GT(std::ranges::max(times), 2 * planned);
}

}  // namespace
}  // namespace cxlab::sim::timed_skills_test
