#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The error that starting this configuration gives.
Error error_of(const std::string& parameters, bool strict = false) {
  Lab lab;
  lab.config(parameters);
  lab.options.strict = strict;
  const Status s = lab.start();
  EXPECT_FALSE(s.ok());
  if (s.ok()) return {};
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_EQ(s.error().file, (lab.folder / "config.yaml").string());
  return s.error();
}

TEST(Configuration, AMissingFileIsNamed) {
  Lab lab;
  lab.options.config = lab.folder / "nothing.yaml";
  const Status s = lab.create();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_EQ(s.error().file, (lab.folder / "nothing.yaml").string());
}

TEST(Configuration, BrokenYamlHasItsLine) {
  const Error e = error_of("environments: [\"main\"\nmain: {");
  EXPECT_THAT(e.message, HasSubstr("not YAML"));
  EXPECT_GE(e.line, 3);
}

TEST(Configuration, ATabInTheIndentationIsReportedWithItsLine) {
  Lab lab;
  lab.options.config = lab.write("config.yaml", "/**:\n  ros__parameters:\n\tenvironments: [main]\n");
  const Status s = lab.create();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().text(), lab.options.config.string() + ":3: found a tab in the indentation, expected spaces");
}

TEST(Configuration, ParametersOfAnotherNodeOnlyAreAnError) {
  Lab lab;
  lab.options.config = lab.write("config.yaml", "clips_mangaer:\n  ros__parameters:\n    environments: []\n");
  const Status s = lab.create();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().message, HasSubstr("found 'clips_mangaer'"));
  EXPECT_EQ(s.error().line, 2);
}

TEST(Configuration, TheNodesOwnSectionWinsOverTheGeneralOne) {
  Lab lab;
  lab.options.config = lab.write("config.yaml",
                                 "clips_manager: {ros__parameters: {environments: [\"own\"]}}\n/**: {ros__parameters: "
                                 "{environments: [\"all\"]}}\n");
  lab.run_up();
  ASSERT_EQ(lab.manager->size(), 1u);
  EXPECT_EQ(lab.manager->environment(0).name(), "own");
}

TEST(Configuration, AppliesInItsNamespace) {
  Lab lab;
  lab.options.name_space = "/team";
  lab.options.config = lab.write("config.yaml",
                                 "team:\n  clips_manager: {ros__parameters: {environments: [\"a\"]}}\nother:\n  "
                                 "clips_manager: {ros__parameters: {environments: [\"b\"]}}\n");
  lab.run_up();
  ASSERT_EQ(lab.manager->size(), 1u);
  EXPECT_EQ(lab.manager->environment(0).name(), "a");
}

TEST(Configuration, DottedNamesAndOverridesAreTheSameParameters) {
  Lab lab;
  lab.config("environments: [\"main\"]\nmain.plugins: [\"exec\"]\nexec.plugin: \"cx::ExecutivePlugin\"");
  lab.options.params = {{"clips_manager.exec.refresh_rate", "50"}};
  lab.run_up();
  lab.ticks(1);
  EXPECT_EQ(lab.manager->next_due(), SimTime{20'000'000});
}

TEST(Configuration, AGivenParameterOfNoNodeIsAnError) {
  for (const auto& [given, meant] : {std::pair{"exec.refresh_rate", "clips_manager.exec.refresh_rate"},
                                     {"clips_manger.exec.refresh_rate", "clips_manager.exec.refresh_rate"},
                                     {"clips_manager", "clips_manager.clips_manager"}}) {
    Lab lab;
    lab.config("environments: [\"main\"]");
    lab.options.params = {{given, "50", {"game.yaml", 7}}};
    const Status made = lab.create();
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().text(), std::string("game.yaml:7: found the parameter '") + given +
                                       "', expected NODE.NAME with the node clips_manager, did you mean '" + meant +
                                       "'?");
  }
}

TEST(Configuration, AGivenParameterForWhichNobodyAsksIsTold) {
  Lab lab;
  lab.config("environments: [\"main\"]\nmain.plugins: [\"params\"]\nparams.plugin: \"cx::RosParamPlugin\"");
  lab.options.params = {{"clips_manager.gain", "2", {"game.yaml", 7}}, {"clips_manager.gian", "3", {"game.yaml", 8}}};
  lab.run_up();
  ASSERT_TRUE(lab.engine().eval("(ros-param-get-value gain 1)"));
  ASSERT_TRUE(lab.manager->deactivate());
  ASSERT_EQ(lab.manager->warnings().size(), 1u);
  EXPECT_EQ(lab.manager->warnings()[0].text(),
            "game.yaml:8: parameter 'gian' was set, but nothing reads it, did you mean 'gain'?");
  EXPECT_THAT(lab.log.with("'gian' was set"), ::testing::SizeIs(1));
}

TEST(Configuration, TwoMisspeltParametersAreNotTheRemedyOfEachOther) {
  Lab lab;
  lab.config("environments: [\"main\"]\nmain.plugins: [\"params\"]\nparams.plugin: \"cx::RosParamPlugin\"");
  lab.options.params = {{"clips_manager.gani", "1", {"game.yaml", 7}}, {"clips_manager.gain", "2", {"game.yaml", 8}}};
  lab.run_up();
  ASSERT_TRUE(lab.manager->deactivate());
  ASSERT_EQ(lab.manager->warnings().size(), 2u);
  for (const Error& warning : lab.manager->warnings())
    EXPECT_THAT(warning.text(), ::testing::EndsWith("was set, but nothing reads it"));
}

TEST(Configuration, AGivenParameterThatAPluginDoesNotHaveIsToldAtTheEnd) {
  Lab lab;
  lab.config("environments: [\"main\"]\nmain.plugins: [\"exec\"]\nexec.plugin: \"cx::ExecutivePlugin\"");
  lab.options.params = {{"clips_manager.exec.refresh_rat", "2", {"game.yaml", 7}}};
  lab.run_up();
  ASSERT_TRUE(lab.manager->deactivate());
  ASSERT_EQ(lab.manager->warnings().size(), 1u);
  EXPECT_THAT(lab.manager->warnings()[0].text(),
              ::testing::StartsWith("game.yaml:7: parameter 'exec.refresh_rat' was set, but nothing reads it"));
}

TEST(Configuration, WhatRulesPrintAsErrorIsAWarningOnce) {
  Lab lab;
  lab.config("environments: [\"a\", \"b\"]");
  lab.run_up();
  for (const char* text : {"(printout error \"wrong \" 1 crlf)", "(printout logerror \"wrong 1\" crlf)",
                           "(printout stderr \"clips\" crlf)", "(printout warn \"odd\" crlf)"})
    ASSERT_TRUE(lab.manager->find("a")->engine().eval(text)) << text;
  ASSERT_TRUE(lab.manager->find("b")->engine().eval("(printout error \"wrong 1\" crlf)"));
  lab.manager->find("b")->log(LogLevel::kError, "plugin", "not of rules");
  ASSERT_TRUE(lab.manager->destroy_environment("b"));
  ASSERT_TRUE(lab.manager->deactivate());
  std::vector<std::string> texts;
  for (const Error& warning : lab.manager->warnings()) texts.push_back(warning.text());
  EXPECT_THAT(texts,
              ElementsAre("environment 'a' printed as error: wrong 1", "environment 'b' printed as error: wrong 1"));
}

TEST(Configuration, OfManyErrorsThatRulesPrintTheFirstAreWarnings) {
  Lab lab;
  lab.config("environments: [\"main\"]");
  lab.run_up();
  ASSERT_TRUE(lab.engine().eval("(loop-for-count (?i 1 15) (printout error \"wrong \" ?i crlf))"));
  ASSERT_TRUE(lab.engine().eval("(printout error \"wrong 1\" crlf)"));
  const std::vector<Error> warnings = lab.manager->warnings();
  ASSERT_EQ(warnings.size(), PrintedErrors::kMost + 1);
  EXPECT_EQ(warnings[9].text(), "environment 'main' printed as error: wrong 10");
  EXPECT_EQ(warnings[10].text(), "5 more lines were printed as error, in the log");
}

TEST(Configuration, ALongLineThatRulesPrintAsErrorIsCutBetweenCharacters) {
  Lab lab;
  lab.config("environments: [\"main\"]");
  lab.run_up();
  std::string line = "x";  // so that the limit is amid a character
  for (int i = 0; i < 300; ++i) line += "ü";
  ASSERT_TRUE(lab.engine().eval("(printout error \"" + line + "\" crlf)"));
  ASSERT_EQ(lab.manager->warnings().size(), 1u);
  EXPECT_EQ(lab.manager->warnings()[0].text(), "environment 'main' printed as error: " + line.substr(0, 499) + " ...");
}

TEST(Configuration, EnvironmentsComeInTheirOrder) {
  Lab lab;
  lab.config("environments: [\"b\", \"c\", \"a\"]");
  lab.run_up();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < lab.manager->size(); ++i) names.push_back(lab.manager->environment(i).name());
  EXPECT_THAT(names, ElementsAre("b", "c", "a"));
}

TEST(Configuration, AWrongTypeHasItsLine) {
  const Error e = error_of(
      "environments: [\"main\"]\nmain: {plugins: [\"x\"]}\nx:\n  plugin: \"cx::ExecutivePlugin\"\n  refresh_rate: "
      "10.5");
  EXPECT_EQ(e.line, 7);
  EXPECT_EQ(e.message, "parameter 'x.refresh_rate': found '10.5' (a double), expected an integer");
}

TEST(Configuration, WordsThatYamlTakesForSomethingElseNeedQuotes) {
  EXPECT_EQ(error_of("environments: [n]").message,
            "parameter 'environments': found 'false' (a bool), expected a list of strings: in quotes it is a string");
}

TEST(Configuration, NumbersAreReadAsRosReadsThem) {
  Lab lab;
  lab.config("environments: []\nhex: 0x10\noctal: 010\nplain: -7\nno_octal: 08\nfar: -.inf\nquoted: '010'");
  ASSERT_TRUE(lab.create().ok());
  auto read = Parameters::load(lab.options.config, "clips_manager", "/");
  ASSERT_TRUE(read.ok());
  std::int64_t integer = 0;
  double number = 0;
  std::string text;
  for (const auto& [name, value] : {std::pair{"hex", 16}, {"octal", 8}, {"plain", -7}}) {
    ASSERT_TRUE(read->read(name, integer).ok()) << name;
    EXPECT_EQ(integer, value) << name;
  }
  EXPECT_FALSE(read->read("no_octal", integer).ok());
  ASSERT_TRUE(read->read("no_octal", number).ok());
  EXPECT_EQ(number, 8);
  ASSERT_TRUE(read->read("far", number).ok());
  EXPECT_LT(number, -1e300);
  ASSERT_TRUE(read->read("quoted", text).ok());
  EXPECT_EQ(text, "010");
}

TEST(Configuration, APluginListedTwiceIsLoadedOnceAndToldOf) {
  Lab lab;
  lab.config("environments: [\"main\"]\nmain: {plugins: [\"x\", \"x\"]}\nx: {plugin: \"cx::ExamplePlugin\"}");
  lab.run_up();
  EXPECT_EQ(lab.log.with("Initializing plugin").size(), 1u);
  const auto warned = lab.log.with("warn clips_manager: ");
  ASSERT_EQ(warned.size(), 1u);
  EXPECT_THAT(warned[0], HasSubstr("config.yaml:4: plugin 'x' is listed twice in 'main.plugins': it is loaded once"));
}

TEST(Configuration, TwoPluginsWithTheSameFunctionsAreToldWithTheirPlace) {
  Lab lab;
  lab.config(
      "environments: [\"main\"]\nmain: {plugins: [\"x\", \"y\"]}\nx: {plugin: \"cx::RosParamPlugin\"}\ny: {plugin: "
      "\"cx::RosParamPlugin\"}");
  const Status s = lab.start();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().text(),
              HasSubstr("config.yaml:6: function 'ros-param-get-value' of plugin 'y' exists already, from plugin 'x'"));
}

TEST(Configuration, ARateMustBePositive) {
  const Error e = error_of(
      "environments: [\"main\"]\nmain: {plugins: [\"x\"]}\nx: {plugin: \"cx::ExecutivePlugin\", refresh_rate: 0}");
  EXPECT_EQ(e.line, 5);
}

TEST(Configuration, AnUnknownPluginTypeNamesTheNearest) {
  const Error e = error_of("environments: [\"main\"]\nmain: {plugins: [\"x\"]}\nx: {plugin: \"cx::FileLoaderPlugin\"}");
  EXPECT_EQ(e.line, 5);
  EXPECT_EQ(e.message, "unknown plugin type 'cx::FileLoaderPlugin', did you mean 'cx::FileLoadPlugin'?");
}

TEST(Configuration, APluginWithoutTypeNamesTheNearestInstance) {
  const Error e =
      error_of("environments: [\"main\"]\nmain: {plugins: [\"fles\"]}\nfiles: {plugin: \"cx::FileLoadPlugin\"}");
  EXPECT_EQ(e.line, 4);
  EXPECT_THAT(e.message, HasSubstr("did you mean 'files'?"));
}

TEST(Configuration, APluginWhoseTypeIsMisspeltNamesTheKey) {
  EXPECT_THAT(error_of("environments: [\"main\"]\nmain: {plugins: [\"files\"]}\nfiles: {plugn: \"cx::FileLoadPlugin\"}")
                  .message,
              HasSubstr("no parameter 'files.plugin' says what it is, did you mean it by 'files.plugn'?"));
}

TEST(Configuration, AnUnknownWatchItemIsAnError) {
  EXPECT_EQ(error_of("environments: [\"main\"]\nmain: {watch: [\"fcts\"]}").message, "Unknown watch item: fcts");
}

TEST(Configuration, TakesEveryWatchItemOfCx) {
  Lab lab;
  lab.config(
      "environments: [\"main\"]\nmain: {watch: [\"all\", \"FACTS\", \"instances\", \"slots\", \"rules\", "
      "\"activations\", \"messages\", "
      "\"message_handlers\", \"generic_functions\", \"methods\", \"deffunctions\", \"compilations\", \"statistics\", "
      "\"globals\", \"focus\"]}");
  lab.run_up();
}

TEST(Configuration, AnEnvironmentListedTwiceIsAnError) {
  EXPECT_THAT(error_of("environments: [\"main\", \"main\"]").message, HasSubstr("listed twice"));
}

TEST(Configuration, AnUnknownParameterIsOneInfoLineWithTheNearestName) {
  Lab lab;
  lab.config(
      "environments: [\"main\"]\nmain: {plugins: [\"x\"]}\nx:\n  plugin: \"cx::ExecutivePlugin\"\n  refresh_rat: 5\n  "
      "mine: 1");
  lab.run_up();
  const auto lines = lab.log.with("unknown parameter");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_THAT(lines[1], HasSubstr("config.yaml:7: unknown parameter 'x.refresh_rat' of plugin 'x' "
                                  "(cx::ExecutivePlugin), did you mean 'refresh_rate'?"));
  EXPECT_THAT(lines[1], ::testing::StartsWith("info clips_manager: "));
}

TEST(Configuration, StrictMakesAnUnknownParameterAnError) {
  const Error e = error_of(
      "environments: [\"main\"]\nmain: {plugins: [\"x\"]}\nx:\n  plugin: \"cx::ExecutivePlugin\"\n  refresh_rat: 5",
      true);
  EXPECT_EQ(e.line, 7);
}

TEST(Configuration, AMisspeltListOfEnvironmentsIsAWarningWithItsPlace) {
  const std::string misspelt = "enviroments: [\"main\"]\nmain: {plugins: []}";
  Lab lab;
  lab.config(misspelt);
  ASSERT_TRUE(lab.start().ok());
  const auto lines = lab.log.with("warn clips_manager: ");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0],
              HasSubstr("config.yaml:3: unknown parameter 'enviroments' of the manager, did you mean 'environments'?"));
  EXPECT_EQ(error_of(misspelt, true).line, 3);
}

TEST(Configuration, AManagerWithoutEnvironmentsIsOneInfoLine) {
  Lab lab;
  lab.options.strict = true;
  lab.config("environment: {plugins: []}\nuse_sim_time: true");
  ASSERT_TRUE(lab.start().ok());
  EXPECT_EQ(lab.log.with("warn ").size(), 0u) << "an environment to come may have any name";
  EXPECT_EQ(lab.log.with("info clips_manager: ").size(), 1u) << "its life is told at debug level";
}

TEST(Configuration, AMisspeltListOfPluginsProposesNoOtherEnvironment) {
  Lab lab;
  lab.config(
      "environments: [\"right\"]\nright: {plugin: [\"x\"]}\nthird: {plugins: [\"x\"]}\nx: {plugin: "
      "\"cx::ExecutivePlugin\"}");
  lab.run_up();
  EXPECT_EQ(
      lab.log.with("config.yaml:4: unknown parameter 'right.plugin' of environment 'right', did you mean 'plugins'?")
          .size(),
      1u);
  EXPECT_EQ(lab.log.with("no parameter 'right.plugins'").size(), 1u);
  EXPECT_EQ(lab.log.with("third").size(), 0u);
}

TEST(Configuration, AnEnvironmentWithoutParametersHasTheNearestGroupThatHasPlugins) {
  const auto line = [](const std::string& parameters) {
    Lab lab;
    lab.config(parameters + "\nx: {plugin: \"cx::ExecutivePlugin\"}");
    lab.run_up();
    const auto lines = lab.log.with("nothing is loaded into it");
    EXPECT_EQ(lines.size(), 1u);
    return lines.empty() ? std::string() : lines[0].substr(lines[0].find("environment '"));
  };
  const std::string none = "environment 'mian': no parameter 'mian.plugins', nothing is loaded into it";
  EXPECT_EQ(line("environments: [\"mian\"]\nmain: {plugins: [\"x\"]}"), none + ", did you mean 'main'?");
  EXPECT_EQ(line("environments: [\"mian\"]"), none);
  EXPECT_EQ(line("environments: [\"mian\", \"main\"]\nmain: {plugins: [\"x\"]}"), none) << "it is listed itself";
}

TEST(Configuration, EveryParameterOfTheManagerHasItsType) {
  for (const char* wrong :
       {"use_sim_time: 5", "autostart_node: 5", "bond_heartbeat_period: soon", "environments: 5", "main: {plugins: 5}",
        "main: {watch: 5}", "main: {log_clips_to_file: 5}", "main: {redirect_stdout_to_debug: 5}"}) {
    const bool list = std::string_view(wrong).starts_with("environments");
    EXPECT_EQ(error_of((list ? "" : "environments: [\"main\"]\n") + std::string(wrong)).line, list ? 3 : 4) << wrong;
  }
}

TEST(Configuration, APluginOfTwoEnvironmentsIsCheckedOnce) {
  Lab lab;
  lab.config(
      "environments: [\"a\", \"b\"]\na: {plugins: [\"x\"]}\nb: {plugins: [\"x\"]}\nx: {plugin: "
      "\"cx::ExecutivePlugin\", rate: 5}");
  lab.run_up();
  EXPECT_EQ(lab.log.with("unknown parameter 'x.rate'").size(), 1u);
}

TEST(Configuration, TheNodeMayBeRenamed) {
  Lab lab;
  lab.options.remaps = {{"__node", "other"}, {"__ns", "/team"}};
  lab.options.config = lab.write("config.yaml", "team: {other: {ros__parameters: {environments: [\"a\"]}}}\n");
  lab.run_up();
  ASSERT_EQ(lab.manager->size(), 1u);
  EXPECT_EQ(lab.bus.name_of(lab.manager->environment(0).participant()).full_name(), "/team/other");
}

TEST(Configuration, WhoJoinsTheBusIsReported) {
  Lab lab;
  std::vector<std::string> streams;
  lab.options.on_join = [&](bus::ParticipantId p) {
    streams.push_back(lab.records.names()[static_cast<std::size_t>(lab.bus.stream_of(p))]);
  };
  lab.config("environments: [\"a\", \"b\"]");
  lab.run_up();
  EXPECT_THAT(streams, ElementsAre("node/clips_manager", "env/a", "env/b"));
}

TEST(Configuration, RulesAreTrustedWhereTheRunSaysSo) {
  for (const bool trusted : {false, true}) {
    Lab lab;
    lab.options.trust_rules = trusted;
    lab.config("environments: [\"main\"]");
    lab.run_up();
    EXPECT_EQ(lab.engine().eval("(system \"exit 0\")").ok(), trusted);
  }
}

TEST(Configuration, ARunInAFileStopsAfterTheFiringsOfTheRun) {
  for (const auto& [most, stops] : {std::pair{9, true}, std::pair{11, false}}) {
    Lab lab;
    lab.options.max_firings = most;
    lab.config(R"(environments: ["main"]
main: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], batch: ["run.clp"]})");
    lab.write("agent/run.clp",
              "(defrule count ?f <- (n ?x&:(< ?x 10)) => (retract ?f) (assert (n (+ ?x 1))))\n(assert (n 0))\n(run)\n");
    const Status started = lab.start();
    EXPECT_EQ(started.ok(), !stops) << most;
    if (!started) {
      EXPECT_THAT(started.error().text(), HasSubstr("run.clp:3: (run ...): rules still fire after 9 firings"));
    }
  }
}

TEST(Configuration, NotesOfALoadAreWarnings) {
  Lab lab;
  lab.options.keep_going = true;
  lab.agent("(deffunction make (?x) (assert (made ?x)))\n(defrule bad (a ?x&:(make ?x)) =>)");
  lab.run_up();
  const auto lines = lab.log.with("'make' on its left-hand side");
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], ::testing::StartsWith("warn "));
  EXPECT_THAT(lines[0], HasSubstr("rules.clp:2: rule 'bad'"));
}

TEST(Configuration, WhenItKeepsGoingPluginsThatFailAreLeftOut) {
  Lab lab;
  lab.options.keep_going = true;
  lab.config("environments: [\"main\"]\nmain: {plugins: [\"nope\", \"x\"]}\nx: {plugin: \"cx::ExecutivePlugin\"}");
  lab.run_up();
  ASSERT_EQ(lab.manager->load_errors().size(), 1u);
  EXPECT_TRUE(lab.engine().callable("now")) << "the plugin after it was loaded";
}

}  // namespace
}  // namespace cxlab::cx
