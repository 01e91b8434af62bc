// What a scenario is: read from text, built by code, written and read again; and which place an error names.

#include <algorithm>

#include "cx/journal/file_store.h"
#include "scenarios/floor/sections.h"
#include "scenarios/rcll/rules/config.h"
#include "scenarios/rcll/world.h"
#include "scenarios/turtlesim/config.h"
#include "scenarios/turtlesim/world.h"
#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

Scenario parsed(const std::string& text, const std::vector<Override>& overrides = {}) {
  auto scenario = Scenario::parse("schema: 1\n" + text, "s.yaml", shipped(), overrides);
  EXPECT_TRUE(scenario.ok()) << scenario.error().text();
  return scenario ? *scenario : Scenario();
}
std::string error_of(const std::string& text, const std::vector<Override>& overrides = {}) {
  const auto scenario = Scenario::parse("schema: 1\n" + text, "s.yaml", shipped(), overrides);
  return scenario ? std::string() : scenario.error().text();
}

const std::string kAll = R"(world:
  kind: rcll
  team: MAGENTA
  robots: 2
  orders:
    - {complexity: C1, ring_colors: [RING_BLUE], delivery_end: 300}
  setup_s: 30
  production_s: 90
tier: timed
timed: {pick_mean_s: 3.25}
seed: 18446744073709551615
epoch: 1.5
duration_s: 100
tick_s: 0.04
physics_step_s: 0.005
packages: {one: a/b, two: /c}
agents:
  - config: agent.yaml
    namespace: /blue
    remap: {a: b, __node: boss}
    packages: {mine: here}
    params: {clips_manager.main.watch: [facts, rules], clips_manager.x: "5"}
    activate: false
  - config: second.yaml
servers:
  - pddl_manager
  - {node: turtlesim, start_s: 2.5, remap: {x: y}, turtles: [{name: t, x: 1}]}
planner: {latency: {a: 0.5}, budget: 1000}
stimuli:
  - {at: 0.25, publish: /a, type: std_msgs/msg/String, data: {data: "yes"}}
  - {at: 1, call: /b, type: std_srvs/srv/SetBool, request: {data: true}}
  - {at: 1, serve: /c, type: std_srvs/srv/SetBool, response: {success: true}}
  - {at: 2, send_goal: /d, type: cxlab_skills/action/DriveTo, goal: {target: C-BS-INPUT}}
  - {at: 3, cancel_goal: /d}
  - {at: 4, set_param: clips_manager.limit, value: [1, 2]}
  - {at: 5, load_plugin: {env: main, plugin: files}, manager: /blue/clips_manager}
  - {at: 6, unload_plugin: {env: main, plugin: files}}
  - {at: 7, create_env: more}
  - {at: 8, destroy_env: more}
  - {at: 9, stop_node: /d}
bag: {file: floor, start_s: 2.5, offset_s: 1, rate: 0.5, topics: "^/a", exclude: b$, remap: {/x: /y}, own: true}
faults:
  - {kind: skill_fails, at: 60, robot: robot1, skill: pick, error: 206, after_s: 8}
  - {kind: skill_fails, probability: 0.05, skill: drive_to, after_s: 4, from: 3, times: 2}
  - {kind: skill_stalls, probability: 0.1, seconds: 10}
  - {kind: piece_dropped, mean_s: 300, robot: robot2}
  - {kind: robot_slow, at: 3, factor: 0.25, seconds: 9}
  - {kind: pose_noise, probability: 0.3, sigma_m: 0.05, sigma_deg: 4}
  - {kind: machine_breaks, at: 200, machine: C-CS1}
  - {kind: machine_down, mean_s: 400, machine: C-BS, seconds: 45, from: 100, until: 900}
on_rule_error: continue
max_firings_per_tick: 77
trust_rules: true
expect:
  - {path: teams.CYAN.points, min: 1.5, max: 1e+30}
  - {path: status, equals: completed}
)";

TEST(Scenario, IsWrittenAsItIsRead) {
  const Scenario scenario = parsed(kAll);
  const std::string text = scenario.to_yaml();
  const auto again = Scenario::parse(text, "again.yaml", shipped());
  ASSERT_TRUE(again.ok()) << again.error().text() << '\n' << text;
  EXPECT_EQ(again->to_yaml(), text);
  EXPECT_EQ(again->seed, 18446744073709551615u);
  EXPECT_EQ(again->agents[0].params[1].value, "\"5\"") << "a quoted scalar stays a string";
  EXPECT_EQ(again->agents[0].remaps, scenario.agents[0].remaps);
  EXPECT_FALSE(again->agents[0].activate);
  EXPECT_TRUE(again->agents[1].activate);
  EXPECT_EQ(again->world.get<rcll::WorldConfig>().orders[0].ring_colors, std::vector<std::string>{"RING_BLUE"});
  EXPECT_EQ(again->servers[1].get<turtlesim::Config>().turtles[0].x, 1);
  EXPECT_EQ(timed_of(*again).pick_mean_s, 3.25);
  EXPECT_THAT(text, AllOf(HasSubstr("planner:\n  latency:\n    a: 0.5\n"), HasSubstr("  budget: 1000\n")));
  EXPECT_FALSE(again->stop_on_rule_error);
  EXPECT_EQ(std::tie(again->bag.file, again->bag.start_s, again->bag.offset_s, again->bag.rate, again->bag.topics,
                     again->bag.exclude, again->bag.remap, again->bag.own),
            std::tuple("floor", 2.5, 1, 0.5, "^/a", "b$", scenario.bag.remap, true));
  EXPECT_THAT(scenario.bag.remap, ElementsAre(std::pair("/x", "/y")));
  ASSERT_THAT(again->stimuli, SizeIs(11));
  for (std::size_t i = 0; i < again->stimuli.size(); ++i) {
    const Stimulus &now = again->stimuli[i], &then = scenario.stimuli[i];
    EXPECT_EQ(std::tie(now.at, now.verb, now.target, now.type, now.content, now.plugin, now.manager),
              std::tie(then.at, then.verb, then.target, then.type, then.content, then.plugin, then.manager));
  }
  const std::vector<sim::Fault> faults_again = faults_of(*again), faults = faults_of(scenario);
  ASSERT_THAT(faults_again, SizeIs(8));
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const sim::Fault &now = faults_again[i], &then = faults[i];
    EXPECT_EQ(now.number, i);
    EXPECT_EQ(
        std::tie(now.kind, now.at, now.probability, now.mean, now.from, now.until, now.times, now.number),
        std::tie(then.kind, then.at, then.probability, then.mean, then.from, then.until, then.times, then.number));
    EXPECT_EQ(std::tie(now.robot, now.skill, now.machine, now.error, now.after, now.duration, now.factor, now.sigma_m,
                       now.sigma_deg),
              std::tie(then.robot, then.skill, then.machine, then.error, then.after, then.duration, then.factor,
                       then.sigma_m, then.sigma_deg));
  }
  ASSERT_THAT(again->expect, SizeIs(2));
  EXPECT_EQ(again->expect[0].max, 1e30);
  EXPECT_EQ(again->expect[1].equals, "completed");
}

TEST(Scenario, AnEmptyOneHasTheDefaults) {
  const Scenario read = parsed(""), built;
  EXPECT_EQ(read.to_yaml(), built.to_yaml());
  EXPECT_EQ(built.tier_name(), "none");
  EXPECT_EQ(built.tick, from_seconds(0.02));
  EXPECT_EQ(read.world.kind, &kEmptyWorld);
}

TEST(Scenario, AWorldSetsItsDefaults) {
  EXPECT_EQ(parsed("world: {kind: rcll, setup_s: 10, production_s: 90, overtime_s: 7}\n").duration, from_seconds(107));
  EXPECT_EQ(parsed("world: {kind: rcll, overtime_s: 0, post_game_s: 2.5}\n").duration, from_seconds(1202.5));
  EXPECT_EQ(parsed("world: {kind: rcll, rules: rulebook}\n").duration, from_seconds(1800)) << "with sudden death";
  EXPECT_EQ(parsed("world: {kind: rcll, setup_s: 10}\nduration_s: 7\n").duration, from_seconds(7));
  const Scenario turtles = parsed("world: {kind: turtlesim}\n");
  EXPECT_EQ(turtles.tick, from_seconds(0.016));
  EXPECT_EQ(turtles.physics_step, from_seconds(0.016));
  EXPECT_EQ(turtles.duration, from_seconds(60));
  EXPECT_EQ(turtles.tier_name(), "physics");
  Scenario built;
  rcll::WorldConfig config;
  config.production_s = 30;
  built.set_world({&rcll::kWorld, config});
  EXPECT_EQ(built.duration, from_seconds(330));
  EXPECT_EQ(built.world.get<rcll::WorldConfig>().production_s, 30);
  built.set_world({&turtlesim::kWorld});
  EXPECT_EQ(built.tick, from_seconds(0.016));
  EXPECT_THAT(built.world.get<turtlesim::Config>().turtles, SizeIs(1)) << "without settings: the defaults";
}

TEST(Scenario, StimuliComeInOrderOfTime) {
  const Scenario scenario = parsed(
      "stimuli:\n  - {at: 3, stop_node: a}\n  - {at: 1, stop_node: b}\n  - {at: 3, stop_node: c}\n  - {at: 1, "
      "stop_node: d}\n");
  std::vector<std::string> targets;
  for (const Stimulus& stimulus : scenario.stimuli) targets.push_back(stimulus.target);
  EXPECT_THAT(targets, ElementsAre("b", "d", "a", "c"));
  EXPECT_EQ(scenario.stimuli[0].origin, (Origin{"s.yaml", 4}));
}

TEST(Scenario, ErrorsNameTheLine) {
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"world: {kind: rcl}\n", "s.yaml:2: world.kind: found 'rcl', expected one of: none, rcll, turtlesim"},
           {"world: {kind: none, robots: 3}\n", "s.yaml:2: unknown key 'robots' in 'world'"},
           {"world: {kind: rcll}\ntier: fast\n", "s.yaml:3: tier: found 'fast', expected one of: physics, timed"},
           {"tick_s: 0.03\n\nphysics_step_s: 0.02\n",
            "s.yaml:4: physics_step_s: found tick_s 0.03 and physics_step_s 0.02, expected a tick of whole steps"},
           {"\ntick_s: 0.015\n",
            "s.yaml:3: tick_s: found tick_s 0.015 and physics_step_s 0.01, expected a tick of whole steps"},
           {"tick_s: 0\n", "s.yaml:2: tick_s: must be more than 0"},
           {"physics_step_s: 0\n", "s.yaml:2: physics_step_s: must be more than 0"},
           {"max_firings_per_tick: -1\n", "s.yaml:2: max_firings_per_tick: must be 0 (no limit) or more"},
           {"planner: {latency: {a: -1}}\n", "s.yaml:2: planner.latency: a and b must be 0 or more"},
           {"planner:\n  budget: 0\n", "s.yaml:3: planner.budget: found 0, expected work units above 0"},
           {"planner:\n  patience: 0\n", "s.yaml:3: planner.patience: found 0, expected work units above 0"},
           {"timed: {pick_failure: 2}\n", "s.yaml:2: timed.pick_failure: found 2"},
           {"world: {kind: turtlesim}\nfaults: []\n",
            "s.yaml:3: faults: this world has neither robots nor machines: expected world.kind rcll"},
           {"packages: {a: ''}\n", "s.yaml:2: packages.a: expected a folder"},
           {"agents:\n  - {config: a, namespace: a b}\n",
            "s.yaml:3: agents[0].namespace: the name 'a b' does not begin with '/'"},
           {"agents:\n  - config: a\n    remap:\n      a: b c\n", "s.yaml:5: agents[0].remap.a: the name 'b c'"},
           {"servers:\n  - {nod: turtlesim}\n", "s.yaml:3: servers[0]: key 'node' is missing"},
           {"servers:\n  - {node: turtlesim, bakground_r: 1}\n", "s.yaml:3: unknown key 'bakground_r' in 'servers[0]'"},
           {"servers:\n  - node: pddl_manager\n    command: x\n", "s.yaml:4: servers[0].command: found no {plan}"},
           {"servers:\n  - {node: pddl_manager, engine: e, command: '{plan}'}\n", "s.yaml:3: servers[0].engine: found"},
           {"servers:\n  - {node: pddl_manager, python: py}\n", "s.yaml:3: servers[0].python: says which"},
           {"world:\n  kind: rcll\n  orders:\n    - complexity: C1\n",
            "s.yaml:5: world.orders[0].ring_colors: found 0"},
           {"stimuli:\n  - {at: 1}\n", "s.yaml:3: stimuli[0]: found 0 verbs, expected exactly one of: publish, call"},
           {"stimuli:\n  - {at: 1, stop_node: a, create_env: b}\n", "s.yaml:3: stimuli[0]: found 2 verbs"},
           {"stimuli:\n  - {stop_node: a}\n", "s.yaml:3: stimuli[0]: key 'at' is missing"},
           {"stimuli:\n  - {at: 1, set_param: a.b}\n", "s.yaml:3: stimuli[0]: key 'value' is missing"},
           {"stimuli:\n  - {at: 1, publish: a}\n", "s.yaml:3: stimuli[0]: key 'type' is missing"},
           {"stimuli:\n  - {at: 1, stop_node: a, manager: m}\n", "s.yaml:3: unknown key 'manager' in 'stimuli[0]'"},
           {"expect:\n  - {path: status}\n", "s.yaml:3: expect[0]: expected min, max or equals"},
           {"expect:\n  - {min: 1}\n", "s.yaml:3: expect[0]: key 'path' is missing"}})
    EXPECT_THAT(error_of(text), StartsWith(message)) << text;
}

TEST(Scenario, ASectionIsAKeyWhereAKindOfTheCatalogueReadsIt) {
  EXPECT_EQ(error_of("timed: {pick_mean_s: 3}\nplanner: {budget: 5}\n"), "") << "without effect in this world";
  const std::string text = "schema: 1\nplanner: {budget: 5}\n";
  const Catalogue without{.worlds = {&rcll::kWorld}, .nodes = {}};
  const auto scenario = Scenario::parse(text, "s.yaml", without);
  ASSERT_FALSE(scenario);
  EXPECT_THAT(scenario.error().text(), StartsWith("s.yaml:2: unknown key 'planner'"));
  EXPECT_EQ(timed_of(parsed("timed: {pick_mean_s: 3}\n")).pick_mean_s, 3);
  EXPECT_EQ(timed_of(parsed("")).pick_mean_s, std::nullopt);
}

TEST(Scenario, ErrorsInAnOptionNameTheOption) {
  EXPECT_EQ(error_of("world: {kind: turtlesim}\n", {{"tier=timed", "--tier timed"}}),
            "--tier timed: tier: found 'timed', expected physics: turtlesim has no other tier");
  EXPECT_THAT(error_of("", {"physics_step_s=0.007"}),
              StartsWith("--set physics_step_s=0.007: physics_step_s: found tick_s 0.02"));
  EXPECT_THAT(error_of("world: {kind: rcll, robots: 2}\n", {"world.robots=7", "world.robots=8"}),
              StartsWith("--set world.robots=8: world.robots: found 8"));
  const Scenario scenario = parsed("expect:\n  - {path: ticks, min: 1}\nseed: 2\n", {"expect[0].min=5", "seed=3"});
  EXPECT_EQ(scenario.seed, 3u);
  EXPECT_THAT(scenario.overrides, ElementsAre("expect[0].min=5", "seed=3"));
  EXPECT_EQ(scenario.expect[0].min, 5);
}

TEST(Scenario, TheFileOfABagIsFoundFromItsFolderOrFromTheOption) {
  EXPECT_EQ(parsed("bag: {file: floor.mcap}\n").bag.file, "floor.mcap");
  EXPECT_EQ(parsed("bag: {file: floor.mcap}\n").bag.origin, (Origin{"s.yaml", 2}));
  EXPECT_EQ(parsed("", {"bag.file=floor.mcap"}).bag.file, (std::filesystem::current_path() / "floor.mcap").string());
  EXPECT_FALSE(parsed("").bag);
  EXPECT_FALSE(parsed("bag: {file: ''}\n").bag) << "no bag";
  EXPECT_FALSE(parsed("bag: {file: floor.mcap}\n", {"bag.file=''"}).bag);
  EXPECT_THAT(error_of("bag: {rate: 2}\n"), StartsWith("s.yaml:2: bag: key 'file' is missing"));
  EXPECT_EQ(error_of("bag: {file: a, rate: 0}\n"), "s.yaml:2: bag.rate: found 0, expected a number from 0.001 to 1000");
  EXPECT_THAT(error_of("bag: {file: a}\n", {{"bag.topics='('", "--bag-topics ("}}),
              StartsWith("--bag-topics (: bag.topics: found '(', expected a regular expression"));
}

TEST(Scenario, PathsOfPackagesAreRelativeToItsFolder) {
  Scenario scenario;
  scenario.file = "/some/where/s.yaml";
  scenario.packages["all"] = {"../all/."};
  AgentSpec agent;
  agent.packages["own"] = {"/own"};
  agent.packages["all"] = {"mine"};
  const auto shares = scenario.shares(agent);
  EXPECT_EQ(shares.at("own"), "/own");
  EXPECT_EQ(shares.at("all"), "/some/where/mine") << "an agent's package comes before the scenario's";
  EXPECT_EQ(scenario.shares({}).at("all"), "/some/all");
}

using BuiltByCode = EpisodeTest;

TEST_F(BuiltByCode, AnAgentPlaysInAWorldAndItsCopyOfTheScenarioReplays) {
  const auto file = scenario("reported", {{"a", "(defrule tick (time ?t) => (println \"tick\"))\n", 10}});
  const auto read_in = Scenario::load(file, shipped());
  ASSERT_TRUE(read_in.ok());

  Scenario built;
  built.name = "built";
  built.file = folder_ / "built.yaml";
  built.packages["words"] = {"words"};
  built.agents.push_back({.config = "reported_agent.yaml"});
  turtlesim::Config config;
  config.turtles = {{"pond/first", 2, 3, 0}};
  built.set_world({&turtlesim::kWorld, config});
  built.duration = from_seconds(1);
  built.stimuli.push_back({.at = from_seconds(0.5),
                           .verb = Stimulus::Verb::kPublish,
                           .target = "/pond/first/cmd_vel",
                           .type = "geometry_msgs/msg/Twist",
                           .content = "{linear: {x: 1.0}}"});
  auto episode = load(built, "run");
  ASSERT_NE(episode, nullptr);
  begin(*episode);
  play(*episode, 1e9);
  const Result result = episode->close(RunStatus::kCompleted);
  EXPECT_FALSE(result.reason);
  EXPECT_THAT(log_.with("a: tick"), SizeIs(11));
  EXPECT_EQ(result.at("turtles[0].name"), "\"pond/first\"");

  auto files = StoredFiles::open(folder_ / "run");
  ASSERT_TRUE(files.ok());
  const auto copy = Scenario::parse(*files->read("scenario.yaml"), built.file, shipped());
  ASSERT_TRUE(copy.ok()) << copy.error().text();
  EXPECT_EQ(copy->to_yaml(), built.to_yaml());
  auto again = load(*copy, "again");
  begin(*again);
  play(*again, 1e9);
  const Result second = again->close(RunStatus::kCompleted);
  EXPECT_EQ(second.stream_hashes, result.stream_hashes);
  EXPECT_EQ(second.physics_hash, result.physics_hash);
}

TEST_F(BuiltByCode, ErrorsNameNoPlace) {
  Scenario built;
  built.agents.push_back({.config = (folder_ / "nothing.yaml").string()});
  EpisodeOptions options;
  options.interfaces = source_dir() / "cx/interfaces";
  EXPECT_THAT(Episode::load(built, options).error().text(), HasSubstr("nothing.yaml"));
  built.agents.clear();
  built.packages["words"] = {"nowhere", {"--package words=nowhere"}};
  EXPECT_EQ(Episode::load(built, options).error().text(),
            "--package words=nowhere: package words: there is no folder nowhere");
  built.packages["words"] = {"nowhere"};
  EXPECT_EQ(Episode::load(built, options).error().text(), "package words: there is no folder nowhere");
}

}  // namespace
}  // namespace cxlab
