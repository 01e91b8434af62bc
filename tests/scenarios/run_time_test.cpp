// What stimuli ask of nodes at run time, and that the rules replay alone with it.

#include "cx/journal/file_store.h"
#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

class RunTime : public EpisodeTest {
 protected:
  /// "main" with the executive; parameters of more plugins and environments; these stimuli.
  std::filesystem::path with(const std::string& stimuli) {
    write("agent.yaml", R"(/**:
  ros__parameters:
    environments: [main]
    main: {plugins: [executive]}
    second: {plugins: [executive, files]}
    executive: {plugin: "cx::ExecutivePlugin"}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: [words], load: [more.clp]}
    limit: 3
)");
    write("words/more.clp",
          "(defrule more (time ?t) => (println \"more \" (random 1 1000000)))\n(defrule hear ?f <- (heard ?) => "
          "(retract ?f))");
    return write(
        "run.yaml",
        "schema: 1\npackages: {words: words}\nduration_s: 3\nagents: [{config: agent.yaml}]\nstimuli:\n" + stimuli);
  }
  std::string log_of(const std::string& env, const std::string& run = "run") {
    return read(folder_ / run / ("logs/" + env + ".log"));
  }
  bool said(const std::string& text) { return !log_.with(text).empty(); }
};

TEST_F(RunTime, PluginsAndEnvironmentsComeAndGo) {
  whole(with(R"(  - {at: 0.5, load_plugin: {env: main, plugin: files}}
  - {at: 1, create_env: second}
  - {at: 1.5, unload_plugin: {env: main, plugin: ros_msgs}}
  - {at: 2, destroy_env: second, manager: /clips_manager}
)"),
        {}, "run");
  EXPECT_NE(log_of("main").find("[0.600] [main] [info] more "), std::string::npos);
  EXPECT_EQ(log_of("main").find("[0.500] [main] [info] more "), std::string::npos) << "loaded at the end of that tick";
  EXPECT_NE(log_of("second").find("more "), std::string::npos);
  EXPECT_EQ(log_of("second").find("[2.100]"), std::string::npos);
  EXPECT_TRUE(said("/clips_manager/unload_plugin: response {success: false, error: \"unknown plugin\"}"))
      << "what came back is reported";
  EXPECT_NE(read(folder_ / "run/journal.jsonl").find("unknown plugin"), std::string::npos) << "and journaled";
}

TEST_F(RunTime, ParametersAreSet) {
  whole(with("  - {at: 0.5, set_param: clips_manager.limit, value: 5}\n  - {at: 1, set_param: clips_manager.limit, "
             "value: five}\n"),
        {}, "run");
  EXPECT_TRUE(said("clips_manager/set_parameters: response {results: [{successful: true"));
  EXPECT_TRUE(said("is of type {integer}, setting it to {string} is not allowed"));
}

TEST_F(RunTime, AManagerIsStoppedThroughItsLife) {
  whole(with("  - {at: 1, stop_node: clips_manager}\n"), {}, "run");
  EXPECT_TRUE(said("/clips_manager/change_state: response {success: true}"));
  EXPECT_TRUE(said("[executive] Deactivated!"));
}

TEST_F(RunTime, AnUnknownNodeIsAnErrorThatNamesThoseThatAreThere) {
  const Result result = [&] {
    auto episode = load(with("  - {at: 1, stop_node: moon}\n"));
    begin(*episode);
    Status s;
    while (s && !episode->over()) s = episode->tick();
    return episode->close(RunStatus::kCompleted, s ? std::nullopt : std::optional<Error>(s.error()));
  }();
  ASSERT_TRUE(result.reason);
  EXPECT_EQ(result.reason->kind, ErrorKind::kInput);
  EXPECT_NE(result.reason->message.find("/clips_manager"), std::string::npos) << result.reason->message;
  EXPECT_GT(result.reason->line, 0);
}

TEST_F(RunTime, TheRulesReplayAloneWithAllOfIt) {
  const auto file = with(R"(  - {at: 0.5, load_plugin: {env: main, plugin: files}}
  - {at: 0.7, call: /clips_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {transition: {label: deactivate}}}
  - {at: 0.9, call: /clips_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {transition: {label: cleanup}}}
  - {at: 0.9, set_param: clips_manager.main.watch, value: [rules]}
  - {at: 1.1, call: /clips_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {transition: {label: configure}}}
  - {at: 1.2, call: /clips_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {transition: {label: activate}}}
  - {at: 1.5, create_env: second}
  - {at: 2, load_plugin: {env: main, plugin: files}}
  - {at: 2.2, destroy_env: second}
  - {at: 2.4, create_env: second}
)");
  const Result recorded = whole(file, {}, "run");
  ASSERT_FALSE(recorded.reason) << recorded.reason->text();
  const auto copies = folder_ / "copies";
  auto stored = StoredFiles::open(folder_ / "run");
  ASSERT_TRUE(stored.ok());
  ASSERT_TRUE(stored->materialise(copies).ok());
  auto scenario = Scenario::load(file, shipped());
  ASSERT_TRUE(scenario.ok());
  EpisodeOptions options = this->options("again");
  options.replay =
      ReplaySource{folder_ / "run/inputs.bin", copies, {scenario->shares(scenario->agents[0])}, folder_ / "run"};
  const auto episode = load(*scenario, options);
  begin(*episode);
  play(*episode, 1e9);
  const Result again = episode->close(RunStatus::kCompleted);
  EXPECT_FALSE(again.reason) << again.reason->text();
  const auto before = streams(recorded), after = streams(again);
  for (const char* env : {"env/main", "env/second"}) EXPECT_EQ(before.at(env), after.at(env)) << env;
}

TEST_F(RunTime, TheSameStimuliGiveTheSameBytes) {
  const auto file =
      with("  - {at: 0.5, create_env: second}\n  - {at: 1, destroy_env: second}\n  - {at: 1.5, create_env: second}\n");
  EXPECT_EQ(whole(file, {}, "one").journal_hash, whole(file, {}, "two").journal_hash);
  EXPECT_NE(log_of("second", "one").find("more "), std::string::npos);
}

TEST_F(RunTime, TwoAgentsWithTheSameNamesLiveOnOneBus) {
  with("  - {at: 0.5, create_env: second, manager: /a/clips_manager}\n");
  write("run.yaml",
        "schema: 1\npackages: {words: words}\nduration_s: 2\nagents:\n  - {config: agent.yaml, namespace: /a}\n  - "
        "{config: agent.yaml, namespace: /b}\n"
        "stimuli:\n  - {at: 0.5, create_env: second, manager: /a/clips_manager}\n");
  const auto all = streams(whole(folder_ / "run.yaml", {}, "run"));
  EXPECT_TRUE(all.contains("env/a/main"));
  EXPECT_TRUE(all.contains("env/b/main"));
  EXPECT_TRUE(all.contains("env/a/second"));
  EXPECT_FALSE(all.contains("env/b/second"));
}

TEST_F(RunTime, WithSeveralManagersAStimulusNamesOne) {
  with("  - {at: 0.5, create_env: second}\n");
  write("run.yaml",
        "schema: 1\npackages: {words: words}\nagents:\n  - {config: agent.yaml, namespace: /a}\n  - {config: "
        "agent.yaml, namespace: /b}\nstimuli:\n  - {at: 0.5, create_env: second}\n");
  auto scenario = Scenario::load(folder_ / "run.yaml", shipped());
  ASSERT_TRUE(scenario.ok());
  const auto episode = Episode::load(*scenario, options());
  ASSERT_FALSE(episode.ok());
  EXPECT_NE(episode.error().text().find("there are 2 environment managers: say which with 'manager: "),
            std::string::npos)
      << episode.error().text();
}

TEST_F(RunTime, AnAgentThatIsNotActivatedWaits) {
  with(
      "  - {at: 1, call: /clips_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {transition: "
      "{label: configure}}}\n");
  const std::string text = read(folder_ / "run.yaml");
  write("run.yaml", std::string(text).replace(text.find("agent.yaml}"), 11, "agent.yaml, activate: false}"));
  whole(folder_ / "run.yaml", {}, "run");
  EXPECT_TRUE(said("Initialized new CLIPS environment: main"));
  EXPECT_FALSE(said("Created plugin"));
}

}  // namespace
}  // namespace cxlab
