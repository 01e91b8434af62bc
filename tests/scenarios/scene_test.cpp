// Entities of worlds of every kind, live and from scene.bin.

#include <algorithm>
#include <numbers>
#include <random>
#include <set>

#include <Eigen/Geometry>

#include "scenarios/scene_log.h"
#include "sim/mujoco/mujoco_world.h"
#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using sim::Pose3;
using sim::Vec3;
using testing::HasSubstr;

constexpr double kRounding = 0.0011;  // m or rad: half a unit in each of three directions, and a little

double distance(const Pose3& a, const Pose3& b) { return (a.position - b.position).norm(); }
/// The angle of a turn from one to the other.
double angle(const Pose3& a, const Pose3& b) { return sim::relative_to(a, b).rotation.norm(); }

/// The same entities, whose poses differ by rounding at most.
void expect_same(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.entities.size(), b.entities.size()) << to_seconds(b.t);
  for (std::size_t i = 0; i < a.entities.size(); ++i) {
    Entity x = a.entities[i];
    const Entity& y = b.entities[i];
    EXPECT_LT(distance(x.pose, y.pose), 2 * kRounding) << y.name << " at " << to_seconds(b.t);
    EXPECT_LT(angle(x.pose, y.pose), 2 * kRounding) << y.name << " at " << to_seconds(b.t);
    x.pose = y.pose;
    EXPECT_TRUE(x == y) << x.name << " '" << x.state << "' " << x.place << " / " << y.name << " '" << y.state << "' "
                        << y.place << " at " << to_seconds(b.t);
  }
}

TEST(Pose3, ComposesAndTakesApart) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-3, 3);
  const auto any = [&](bool upright) {
    Pose3 pose{{number(random), number(random), number(random)}, {number(random), number(random), number(random)}};
    if (upright) pose.rotation = {0, 0, pose.rotation.z()};
    return pose;
  };
  for (int i = 0; i < 200; ++i) {
    const Pose3 frame = any(i % 2 == 0), local = any(i % 3 == 0);
    const Pose3 back = sim::relative_to(frame, sim::compose(frame, local));
    EXPECT_LT(distance(back, local), 1e-9);
    EXPECT_LT(angle(back, local), 1e-6);
  }
  const Pose3 turned = sim::compose({{1, 2, 0}, {0, 0, std::numbers::pi / 2}}, {{1, 0, 0.5}, {0, 0, 0.25}});
  EXPECT_LT(distance(turned, {{1, 3, 0.5}}), 1e-12);
  EXPECT_NEAR(turned.yaw(), std::numbers::pi / 2 + 0.25, 1e-12);
  EXPECT_NEAR((Pose3{Vec3::Zero(), {0, 0, 4}}).yaw(), 4 - 2 * std::numbers::pi, 1e-12);
  EXPECT_NEAR((Pose3{Vec3::Zero(), {std::numbers::pi, 0, 0}}).yaw(), 0, 1e-12) << "upside down it still looks ahead";
}

TEST(Look, ReadsBackAsWritten) {
  const std::vector<Solid> solids{{Solid::Shape::kBox, {0.35, 0.7, 0.86}, {0, 0, 0}, 0xccced4},
                                  {Solid::Shape::kCylinder, {0.06, 0.06, 0.04}, {-0.12, 0.3, 1.06}, 0x00000d, true}};
  const std::string look = look_of(solids);
  EXPECT_EQ(look, "box 0.35 0.7 0.86 0 0 0 #ccced4; cylinder 0.06 0.06 0.04 -0.12 0.3 1.06 #00000d blinks");
  const auto read = solids_of(look);
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(*read, solids);
  EXPECT_TRUE(solids_of("")->empty());
}

TEST(Look, SaysWhatIsWrong) {
  const auto error = [](const char* look) { return solids_of(look).error().text(); };
  EXPECT_THAT(error("ball 1 1 1 0 0 0 #ffffff"), HasSubstr("found 'ball', expected box or cylinder"));
  EXPECT_THAT(error("box 1 x 1 0 0 0 #ffffff"), HasSubstr("found 'x', expected a number in metres"));
  EXPECT_THAT(error("box 1 inf 1 0 0 0 #ffffff"), HasSubstr("found 'inf', expected a number in metres"));
  EXPECT_THAT(error("box 1 1 1 0 0 0"), HasSubstr("found '', expected a colour such as"));
  EXPECT_THAT(error("box 1 1 1 0 0 0 #fffffg"), HasSubstr("found '#fffffg', expected a colour"));
  EXPECT_THAT(error("box 1 1 1 0 0 0 #ffffff shines"), HasSubstr("found 'shines'"));
  EXPECT_THAT(error("box 1 1 1 0 0 0 #ffffff blinks now"), HasSubstr("found 'now'"));
  EXPECT_THAT(error("box 1 1 1 0 0 0 #ffffff; box"), HasSubstr("look ' box': found ''"));
}

// --- The file, of a world that the test makes up

/// Things come and go, move, change what they do and who carries them; some are on their way.
class Made {
 public:
  explicit Made(unsigned seed) : random_(seed) {}
  void step(SimTime now) {
    const auto chance = [&](int percent) { return static_cast<int>(random_() % 100) < percent; };
    if (things_.size() < 3 || chance(10)) {
      Thing& thing = things_.emplace_back();
      thing.number = ++last_;
      thing.name = "thing" + std::to_string(last_ % 5);
    }
    if (things_.size() > 3 && chance(8))
      things_.erase(things_.begin() + static_cast<std::ptrdiff_t>(random_() % things_.size()));
    for (Thing& thing : things_) {
      if (chance(20)) thing.pose.position += Vec3(number(), number(), chance(30) ? number() : 0);
      if (chance(10)) thing.pose.rotation = {chance(20) ? number() : 0, 0, number()};
      if (chance(5)) thing.state = chance(20) ? "" : "state " + std::to_string(random_() % 7);
      if (chance(5)) thing.look = "look " + std::to_string(random_() % 3);
      if (chance(5)) thing.carrier = chance(50) ? 0 : things_.front().number, thing.place = thing.carrier ? "hand" : "";
      if (!chance(4)) continue;
      thing.way_number = chance(40) ? 0 : ++ways_;
      thing.way.clear();
      SimTime t = now - std::chrono::milliseconds(random_() % 500);
      for (int i = 0; i < 5 && thing.way_number; ++i, t += std::chrono::milliseconds(1 + random_() % 3000))
        thing.way.push_back({t < SimTime{} ? SimTime{} : t, {{number(), number(), 0}, {0, 0, number()}}});
    }
  }
  void list(SceneList& list) const {
    for (const Thing& thing : things_)
      list.put({.number = thing.number,
                .kind = "thing",
                .name = thing.name,
                .state = thing.state,
                .look = thing.look,
                .carried_by = thing.carrier,
                .place = thing.place,
                .pose = thing.pose,
                .way_number = thing.way_number,
                .way = list.knows_way(thing.number, thing.way_number) ? std::span<const sim::WayPoint>() : thing.way});
  }

 private:
  struct Thing {
    EntityId number = 0;
    std::string name, state, look, place;
    EntityId carrier = 0;
    Pose3 pose;
    std::uint64_t way_number = 0;
    std::vector<sim::WayPoint> way;
  };
  double number() { return std::uniform_real_distribution<double>(-3, 3)(random_); }
  std::mt19937 random_;
  std::vector<Thing> things_;
  EntityId last_ = 0;
  std::uint64_t ways_ = 0;
};

class SceneFile : public testing::Test {
 protected:
  struct Frame {
    SimTime t{};
    SceneList list;  ///< asked for then
  };
  /// Writes ticks of 20 ms, some of which are skipped. Returns the scene of each.
  std::vector<Frame> write(const std::filesystem::path& path, unsigned seed, int ticks = 4000) {
    Made made(seed);
    std::mt19937 random(seed);
    const std::vector<SceneLister> listers{
        [&](SceneList& list) { made.list(list); },
        [](SceneList& list) { list.put({.number = 1, .kind = "node", .name = "beside", .fixed = true}); }};
    auto writer = SceneWriter::create(path);
    EXPECT_TRUE(writer.ok()) << writer.error().text();
    std::vector<Frame> frames;
    SimTime now{};
    for (int i = 0; i < ticks; ++i) {
      made.step(now);
      const auto skipped = random() % 10 == 0 ? random() % 60 : 0;
      const SimTime next = now + std::chrono::milliseconds(20) * (1 + static_cast<int>(skipped));
      frames.push_back({now, {}});
      frames.back().list.update(listers);
      writer->look(now, i + 1 < ticks ? next : kNever, listers);
      now = next;
    }
    EXPECT_TRUE(writer->close().ok());
    return frames;
  }
  /// The last of the frames that is not after `t`.
  static const Frame& frame_at(const std::vector<Frame>& frames, SimTime t) {
    return *(std::ranges::upper_bound(frames, t, {}, &Frame::t) - 1);
  }

  TempFolder temp_;
  const std::filesystem::path file_ = temp_.path() / "scene.bin";
};

TEST_F(SceneFile, ShowsAtAnyTimeWhatTheLiveListShowed) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const auto frames = write(file_, seed);
    auto reader = SceneReader::open(file_);
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    EXPECT_TRUE(reader->status().ok());
    EXPECT_EQ(reader->begin(), SimTime{});
    EXPECT_EQ(reader->end(), frames.back().t);
    std::mt19937 random(seed);
    for (int i = 0; i < 500; ++i) {
      const SimTime t = kScenePeriod * (static_cast<std::int64_t>(random()) % (frames.back().t / kScenePeriod));
      const auto scene = reader->at(t);
      ASSERT_TRUE(scene.ok()) << scene.error().text();
      expect_same(*scene, frame_at(frames, t).list.at(t));
    }
    expect_same(*reader->at(frames.back().t), frames.back().list.at(frames.back().t));
    expect_same(*reader->at(kNever), frames.back().list.at(kNever));
    EXPECT_TRUE(reader->at(SimTime{-1})->entities.empty());
  }
}

TEST_F(SceneFile, GoesThroughAllChangesInOrder) {
  const auto frames = write(file_, 4);
  auto reader = SceneReader::open(file_);
  ASSERT_TRUE(reader.ok());
  std::set<SimTime> seen;
  for (auto t = reader->next_change(SimTime{-1}); t.ok() && *t; t = reader->next_change(**t)) {
    EXPECT_TRUE(seen.insert(**t).second);
    expect_same(*reader->at(**t), frame_at(frames, **t).list.at(**t));
  }
  EXPECT_GT(seen.size(), frames.size() / 20);
  EXPECT_LE(seen.size(), static_cast<std::size_t>(frames.back().t / kScenePeriod + 2)) << "ten in a second at most";
}

TEST_F(SceneFile, IsTheSameBytesAgainAndHasAllEntitiesInEachChunk) {
  write(file_, 5);
  write(temp_.path() / "again.bin", 5);
  const std::string bytes = content_of(file_);
  EXPECT_EQ(bytes, content_of(temp_.path() / "again.bin"));
  write(temp_.path() / "other.bin", 6);
  EXPECT_NE(bytes, content_of(temp_.path() / "other.bin"));
}

/// Where the chunks of a file begin, and its end.
std::vector<std::size_t> chunks_of(const std::string& bytes) {
  std::vector<std::size_t> out{8};
  while (out.back() < bytes.size()) {
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + out.back(), sizeof length);
    out.push_back(out.back() + 12 + length);
  }
  return out;
}

TEST_F(SceneFile, IsReadUpToItsLastWholeChunkWhenItIsCutOff) {
  const auto frames = write(file_, 7);
  const std::string bytes = content_of(file_);
  const auto chunks = chunks_of(bytes);
  ASSERT_GT(chunks.size(), 5u);
  std::mt19937 random(7);
  for (int i = 0; i < 60; ++i) {
    const std::size_t cut = 8 + random() % (bytes.size() - 8);
    auto reader = SceneReader::from_bytes(bytes.substr(0, cut), "run/scene.bin");
    ASSERT_TRUE(reader.ok());
    const auto after = std::ranges::upper_bound(chunks, cut);
    const bool between = *(after - 1) == cut;
    EXPECT_EQ(reader->status().ok(), between) << cut;
    if (!between) {
      EXPECT_EQ(reader->status().error().text(), "run/scene.bin: broken at byte " + std::to_string(*(after - 1)) +
                                                     " of " + std::to_string(cut) +
                                                     ": the last chunk is cut off; what comes before is whole");
    }
    const SimTime end = reader->end();
    EXPECT_GE(end, std::chrono::seconds(20) * (after - chunks.begin() - 1));
    if (!reader->empty()) expect_same(*reader->at(end), frame_at(frames, end).list.at(end));
  }
  EXPECT_THAT(SceneReader::from_bytes("CXSCENE", "s.bin").error().text(), HasSubstr("s.bin: expected a scene"));
  EXPECT_TRUE(SceneReader::from_bytes("CXSCENE1", "s.bin")->empty());
  EXPECT_EQ(SceneReader::open(temp_.path() / "none").error().kind, ErrorKind::kInput);
}

TEST_F(SceneFile, NoticesEveryChangedByte) {
  const auto frames = write(file_, 8, 600);
  const std::string bytes = content_of(file_);
  for (std::size_t i = 8; i < bytes.size(); i += 7) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ (1 << i % 8));
    const auto reader = SceneReader::from_bytes(changed, "run/scene.bin");
    ASSERT_TRUE(reader.ok());
    ASSERT_FALSE(reader->status().ok()) << i;
    EXPECT_THAT(reader->status().error().text(), testing::StartsWith("run/scene.bin: broken at byte "));
  }
}

TEST(SceneList, CutsWhatIsTooMuchAndKeepsNumbersFinite) {
  const std::string longest(SceneList::kLongestText - 1, 'x');
  SceneList list;
  const double infinite = std::numeric_limits<double>::infinity();
  const std::vector<SceneLister> listers{[&](SceneList& to) {
    for (EntityId i = 0; i < 3000; ++i)
      to.put({.number = i,
              .kind = "k",
              .name = "n",
              .state = longest + "\xc3\xa4",
              .pose = {{infinite, -1e300, std::nan("")}, {infinite, 0, 0}}});
    to.put({.number = kMostEntityNumbers, .kind = "k", .name = "left out"});
  }};
  list.update(listers);
  const Scene scene = list.at({});
  ASSERT_EQ(scene.entities.size(), SceneList::kMostEntities);
  EXPECT_EQ(scene.find("left out"), nullptr);
  EXPECT_EQ(scene.find(EntityId{0}), nullptr) << "0 is no number";
  EXPECT_EQ(scene.entities.front().state, longest) << "no half of a character";
  EXPECT_TRUE(scene.entities.front().pose.position.allFinite());
}

// --- Worlds

class SceneOf : public EpisodeTest {
 protected:
  const std::filesystem::path game_ = source_dir() / "scenarios/rcll/game.yaml";
};

TEST_F(SceneOf, PhysicsIsWhereTheBodiesOfMujocoAre) {
  auto episode = load(game_, {"world.exploration=false", "world.down=false", "seed=3"});
  begin(*episode);
  const auto& world = dynamic_cast<const sim::MujocoWorld&>(*episode->stage().worlds.front());
  const sim::FactoryModel& factory = world.gate().factory();
  const mjData& data = world.gate().data();
  std::size_t pieces = 0, carried = 0, on_machines = 0;
  for (int second = 1; second <= 75; ++second) {
    play(*episode, second);
    const Scene scene = episode->scene();
    for (std::size_t i = 0; i < world.plan().robots.size(); ++i) {
      const Entity* robot = scene.find(world.plan().robots[i].name);
      ASSERT_TRUE(robot);
      const auto q = [&](sim::RobotAxis axis) { return data.qpos[factory.robots[i].qpos[axis]]; };
      EXPECT_LT(distance(robot->pose, {{q(sim::kAxisX), q(sim::kAxisY), 0}}), kRounding);
      EXPECT_NEAR(std::remainder(robot->pose.yaw() - q(sim::kAxisYaw), 2 * std::numbers::pi), 0, kRounding);
    }
    std::vector<Pose3> bodies;  // in play: those that wait lie below the floor
    for (const sim::PieceIds& ids : factory.pieces) {
      const mjtNum* q = data.qpos + ids.qpos;
      const Eigen::Quaterniond turn(q[3], q[4], q[5], q[6]);
      const Eigen::AngleAxisd rotation(turn);
      const Vec3 origin(q[0], q[1], q[2]);
      if (origin.z() < -0.1) continue;
      bodies.push_back(
          {origin - sim::kPieceOrigin * (turn * Vec3::UnitZ()), sim::wrap_angle(rotation.angle()) * rotation.axis()});
    }
    std::size_t listed = 0;
    for (const Entity& entity : scene.entities) {
      if (entity.kind != "piece") continue;
      ++listed;
      const Pose3 pose = scene.in_world(entity);
      const auto nearest = std::ranges::min(bodies, {}, [&](const Pose3& body) { return distance(body, pose); });
      EXPECT_LT(distance(nearest, pose), 3 * kRounding) << entity.name << " at " << second;
      EXPECT_LT(angle(nearest, pose), 3 * kRounding) << entity.name << " at " << second;
      const Entity* carrier = entity.carried_by ? scene.find(*entity.carried_by) : nullptr;
      carried += carrier && carrier->kind == "robot" && entity.place == "gripper";
      on_machines += carrier && carrier->kind == "machine";
      if (entity.place == "gripper") {
        EXPECT_NEAR(entity.pose.position.y(), 0, 0.04);
        EXPECT_GT(entity.pose.position.x(), 0.13);
        EXPECT_LT(entity.pose.position.x(), 0.39);
      }
    }
    EXPECT_EQ(listed, bodies.size());
    pieces = std::max(pieces, listed);
  }
  EXPECT_GT(pieces, 12u) << "those of the shelves, and what robots fetched";
  EXPECT_GT(carried, 20u);
  EXPECT_GT(on_machines, 500u);
}

TEST_F(SceneOf, ARobotAndWhatItCarriesGoTogether) {
  for (const char* tier : {"tier=timed", "tier=physics"}) {
    auto episode = load(game_, {tier, "world.exploration=false", "world.down=false", "seed=3"}, tier);
    begin(*episode);
    play(*episode, 75);
    (void)episode->close(RunStatus::kStopped);
    auto reader = SceneReader::open(folder_ / tier / "scene.bin");
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    int driven = 0;
    std::map<EntityId, Pose3> offsets, places;  // of pieces, of robots that carry one, 0.1 s before
    for (SimTime t{}; t <= reader->end(); t += kScenePeriod) {
      const Scene scene = *reader->at(t);
      std::map<EntityId, Pose3> now, there;
      for (const Entity& piece : scene.entities) {
        if (piece.place != "gripper") continue;
        const Entity* robot = scene.find(*piece.carried_by);
        ASSERT_TRUE(robot);
        if (robot->state.find(" drive ") == std::string::npos) continue;
        const Pose3 offset = sim::relative_to(robot->pose, scene.in_world(piece));
        now[piece.id] = offset;
        there[robot->id] = robot->pose;
        if (!offsets.contains(piece.id) || !places.contains(robot->id)) continue;
        EXPECT_LT(distance(offsets[piece.id], offset), 0.02) << tier << " at " << to_seconds(t);
        EXPECT_NEAR(offset.position.z(), sim::kRobot.carried_height, 0.06) << tier << " at " << to_seconds(t);
        driven += distance(places[robot->id], robot->pose) > 0.02;
      }
      offsets = now;
      places = there;
    }
    EXPECT_GT(driven, 50) << tier;
  }
}

TEST_F(SceneOf, RobotsOfTheTimedTierDriveSmoothly) {
  auto episode = load(game_, {"tier=timed", "seed=2"}, "run");
  begin(*episode);
  play(*episode, 400);
  (void)episode->close(RunStatus::kStopped);
  auto reader = SceneReader::open(folder_ / "run/scene.bin");
  ASSERT_TRUE(reader.ok()) << reader.error().text();
  std::map<std::string, Pose3> before;
  std::map<std::string, double> driven;
  for (SimTime t{}; t <= reader->end(); t += std::chrono::milliseconds(40)) {
    const Scene scene = *reader->at(t);
    for (const char* name : {"robot1", "robot2", "robot3"}) {
      const Pose3 pose = scene.find(name)->pose;
      if (before.contains(name)) {
        const double step = distance(before[name], pose);
        EXPECT_LT(step, 0.04) << name << " at " << to_seconds(t) << ": faster than 1 m/s";
        driven[name] += step;
      }
      before[name] = pose;
    }
  }
  for (const auto& [name, metres] : driven) EXPECT_GT(metres, 20) << name;
}

TEST_F(SceneOf, ARecordedGameShowsWhatTheLiveOneShowed) {
  const std::string faults =
      "faults=[{kind: piece_dropped, mean_s: 100}, {kind: robot_maintenance, mean_s: 200, seconds: 60}]";
  for (const auto& [name, settings] : std::map<std::string, std::vector<Override>>{
           {"timed", {"tier=timed", "world.pauses=[{at: 100, for: 15}]", faults.c_str()}},
           {"both", {"tier=timed", "seed=4"}}}) {
    auto episode = load(name == "both" ? source_dir() / "scenarios/rcll/two_teams.yaml" : game_, settings, name);
    begin(*episode);
    std::vector<std::pair<SimTime, SceneList>> live;
    while (episode->now() < from_seconds(500)) {
      ASSERT_TRUE(episode->tick().ok());
      SceneList list;
      list.update(episode->stage().scenes);
      live.emplace_back(episode->now(), std::move(list));
    }
    const SimTime end = episode->now();
    expect_same(episode->scene(), live.back().second.at(end));
    (void)episode->close(RunStatus::kStopped);
    auto reader = SceneReader::open(folder_ / name / "scene.bin");
    ASSERT_TRUE(reader.ok()) << reader.error().text();
    std::mt19937 random(1);
    for (int i = 0; i < 400; ++i) {
      const SimTime t = kScenePeriod * static_cast<int>(random() % 5000);
      const auto after = std::ranges::upper_bound(live, t, {}, [](const auto& one) { return one.first; });
      expect_same(*reader->at(t), (after - 1)->second.at(t));
    }
    expect_same(*reader->at(end), live.back().second.at(end));
  }
}

TEST_F(SceneOf, TheSameRunGivesTheSameBytesWhoeverLooksMeanwhile) {
  for (const char* run : {"first", "second"}) {
    auto episode = load(game_, {"tier=timed", "seed=5"}, run);
    begin(*episode);
    while (episode->now() < from_seconds(200)) {
      ASSERT_TRUE(episode->tick().ok());
      if (run == std::string("second")) (void)episode->scene();
    }
    (void)episode->close(RunStatus::kStopped);
  }
  EXPECT_EQ(read(folder_ / "first/scene.bin"), read(folder_ / "second/scene.bin"));
}

TEST_F(SceneOf, MachinesSayWhatTheyDoAndWhichLightsShine) {
  auto episode = load(game_, {"tier=timed", "world.exploration=false", "world.down=false", "seed=3"});
  begin(*episode);
  std::set<std::string> states, robots;
  while (episode->now() < from_seconds(200)) {
    ASSERT_TRUE(episode->tick().ok());
    for (const Entity& entity : episode->scene().entities) {
      if (entity.kind == "machine") states.insert(entity.state);
      if (entity.kind == "robot") robots.insert(entity.state.substr(0, entity.state.rfind(' ')));
      EXPECT_TRUE(solids_of(entity.look).ok()) << entity.look;
      EXPECT_FALSE(entity.look.empty()) << entity.name;
    }
  }
  for (const char* state :
       {"IDLE green", "PREPARED green-blink", "PROCESSING yellow green", "READY-AT-OUTPUT yellow green-blink"})
    EXPECT_TRUE(states.contains(state)) << state << " of " << testing::PrintToString(states);
  for (const char* state : {"idle", "transport drive", "transport handle"})
    EXPECT_TRUE(std::ranges::any_of(robots, [&](const std::string& one) { return one.starts_with(state); }))
        << state << " of " << testing::PrintToString(robots);
}

TEST_F(SceneOf, MachinesHaveABandInTheColourOfTheirTeam) {
  auto episode = load(source_dir() / "scenarios/rcll/two_teams.yaml", {"tier=timed"});
  begin(*episode);
  std::set<std::string> teams;
  for (const Entity& entity : episode->scene().entities) {
    if (entity.kind != "machine") continue;
    const std::string team = entity.name.substr(0, 1);
    const auto solids = solids_of(entity.look);
    ASSERT_TRUE(solids.ok()) << entity.look;
    std::set<std::uint32_t> colours;
    for (const Solid& solid : *solids) colours.insert(solid.colour);
    constexpr std::uint32_t kCyan = 0x00c7db, kMagenta = 0xe01a9e;
    EXPECT_EQ(colours.contains(kCyan), team == "C") << entity.name;
    EXPECT_EQ(colours.contains(kMagenta), team == "M") << entity.name;
    teams.insert(team);
  }
  EXPECT_EQ(teams, (std::set<std::string>{"C", "M"}));
}

TEST_F(SceneOf, NothingIsWrittenWithoutAJournalOrAWorld) {
  for (const auto& [file, level, there] :
       {std::tuple{game_, JournalLevel::kDecisions, true}, std::tuple{game_, JournalLevel::kNone, false},
        std::tuple{scenario("empty", {{"env", ""}}), JournalLevel::kDecisions, false}}) {
    EpisodeOptions options = this->options("run" + std::to_string(there) + std::to_string(static_cast<int>(level)));
    options.spec.journal = level;
    std::vector<Override> set;
    if (file == game_) set = {"tier=timed"};
    auto read_in = Scenario::load(file, shipped(), set);
    ASSERT_TRUE(read_in.ok()) << read_in.error().text();
    const auto episode = load(*read_in, options);
    begin(*episode);
    play(*episode, 1);
    (void)episode->close(RunStatus::kStopped);
    EXPECT_EQ(std::filesystem::exists(options.run_folder / "scene.bin"), there);
  }
}

TEST_F(SceneOf, TurtlesAreOnTheirCanvas) {
  auto episode = load(source_dir() / "scenarios/turtlesim/figures.yaml", {}, "run");
  begin(*episode);
  std::vector<std::pair<SimTime, Scene>> live;
  while (episode->now() < from_seconds(8)) {
    ASSERT_TRUE(episode->tick().ok());
    live.emplace_back(episode->now(), episode->scene());
  }
  Result result;
  episode->stage().report(result);
  const Scene last = episode->scene();
  ASSERT_TRUE(last.find("canvas"));
  const std::string quoted = result.at("turtles[1].name"), name = quoted.substr(1, quoted.size() - 2);
  const Entity* turtle = last.find(name);
  ASSERT_TRUE(turtle) << name;
  EXPECT_EQ(turtle->kind, "turtle");
  EXPECT_NEAR(turtle->pose.position.x(), std::stod(result.at("turtles[1].x")), kRounding);
  EXPECT_NEAR(turtle->pose.yaw(), std::stod(result.at("turtles[1].theta")), kRounding);
  EXPECT_THAT(turtle->state, testing::StartsWith("pen "));
  (void)episode->close(RunStatus::kStopped);
  auto reader = SceneReader::open(folder_ / "run/scene.bin");
  ASSERT_TRUE(reader.ok()) << reader.error().text();
  double moved = 0;
  std::optional<Pose3> first;
  for (SimTime t{}; t < from_seconds(8); t += kScenePeriod) {
    const auto after = std::ranges::upper_bound(live, t, {}, [](const auto& one) { return one.first; });
    expect_same(*reader->at(t), (after - 1)->second);
    const Scene scene = *reader->at(t);
    if (!scene.find(name)) continue;
    if (!first) first = scene.find(name)->pose;
    moved = std::max(moved, distance(scene.find(name)->pose, *first));
  }
  EXPECT_GT(moved, 1);
}

TEST_F(SceneOf, ANodeBesideAWorldListsItsEntitiesToo) {
  auto episode = load(game_, {"tier=timed", "servers=[{node: turtlesim}]"});
  begin(*episode);
  play(*episode, 1);
  const Scene scene = episode->scene();
  ASSERT_TRUE(scene.find("turtle1"));
  ASSERT_TRUE(scene.find("robot1"));
  EXPECT_GT(scene.find("turtle1")->id, kMostEntityNumbers);
  std::set<EntityId> ids;
  for (const Entity& entity : scene.entities) EXPECT_TRUE(ids.insert(entity.id).second);
}

}  // namespace
}  // namespace cxlab
