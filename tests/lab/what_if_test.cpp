#include "lab/what_if.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "cx/journal/journal_reader.h"
#include "folder.h"
#include "lab/replay.h"
#include "lab/rerun.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// Orders stay new: the rule that finishes them waits for a fact that nobody asserts.
constexpr const char* kBroken = R"((deftemplate order (slot id (type INTEGER)) (slot state (default new)))
(defglobal ?*limit* = 3)
(deffacts start (order (id 1)) (order (id 2)))
(defrule draw (time ?t) => (assert (drawn ?t ?*limit* (random))))
(defrule count-order (order (id ?id) (state new)) => (assert (counted ?id (random))))
(defrule finish
  ?o <- (order (state new))
  (ready)
  =>
  (modify ?o (state done)))
(defrule ask (time ?t) => (assert (patience ?t (ros-param-get-value "patience" 1.5))))
)";
constexpr const char* kRepair = "; a repair\n(defrule finish ?o <- (order (state new)) => (modify ?o (state done)))\n";

class WhatIfTest : public FolderTest {
 protected:
  void SetUp() override {
    scenario("game", kBroken);
    write("agent.yaml", agent_text("rules", {"ros_param"}, {EnvText()}, "patience: 1.5\nunread: 5\n"));
    write("repair.clp", kRepair);
  }
  void play() const {
    PlayOptions options;
    options.spec.journal = JournalLevel::kFull;
    const Played played = FolderTest::play("game", options);
    ASSERT_FALSE(played.failure) << played.failure->text();
  }
  Expected<Rerun> try_out(const std::string& out, const WhatIf& what_if, const std::string& of = "out") const {
    return rerun(run(of), {.out = path(out).string(), .what_if = what_if});
  }
  Rerun what_if(const std::string& out, const WhatIf& what_if, const std::string& of = "out") const {
    auto again = try_out(out, what_if, of);
    EXPECT_TRUE(again) << (again ? "" : again.error().text());
    EXPECT_FALSE(again->played.failure) << again->played.failure->text();
    return *std::move(again);
  }
  WhatIf repair(double at) const { return {.at = at, .file = path("repair.clp").string()}; }
  /// The error of a change, in the middle of the run or before it.
  Error refused(const WhatIf& what_if) const {
    static int number = 0;
    auto again = try_out("refused" + std::to_string(number++), what_if);
    if (!again) return again.error();
    EXPECT_TRUE(again->played.failure);
    return again->played.failure ? *again->played.failure : Error{};
  }
  std::vector<std::string> changes(const Rerun& again) const {
    std::vector<std::string> out;
    for (const WhatIfAct& act : again.played.changed) out.push_back(act.what);
    return out;
  }
  /// Lines of the journal before that time, and those from then on.
  std::pair<std::string, std::string> journal(const std::string& folder, double at) const {
    std::ifstream in(path(folder + "/journal.jsonl"));
    std::pair<std::string, std::string> out;
    for (std::string line; std::getline(in, line);)
      (nlohmann::json::parse(line)["t"].get<double>() < at * 1e9 ? out.first : out.second) += line + '\n';
    return out;
  }
  void replays(const std::string& folder) const {
    const auto outcome = replay_rules(run(folder));
    ASSERT_TRUE(outcome) << outcome.error().text();
    EXPECT_TRUE(outcome->agrees()) << outcome->first_difference;
  }
};

TEST_F(WhatIfTest, WithoutAChangeItIsTheSameRun) {
  play();
  const Rerun again = what_if("again", {.at = 1});
  EXPECT_EQ(run("again").stream_hashes, run().stream_hashes);
  EXPECT_EQ(read("again/inputs.bin"), read("out/inputs.bin"));
  EXPECT_FALSE(again.before);
  EXPECT_THAT(again.after, IsEmpty());
  EXPECT_THAT(changes(again), IsEmpty());
}

TEST_F(WhatIfTest, ItIsTheRunOfThenUpToTheTimeAndAnotherOneFromThereOn) {
  play();
  const Rerun again = what_if("again", repair(1));
  EXPECT_FALSE(again.before) << again.before->text();
  const auto then = journal("out", 1), now = journal("again", 1);
  EXPECT_EQ(then.first, now.first);
  EXPECT_THAT(now.first, Not(HasSubstr("repair.clp")));
  EXPECT_THAT(then.second, Not(HasSubstr("\"done\"")));
  EXPECT_THAT(now.second, HasSubstr("\"done\""));
  EXPECT_THAT(changes(again),
              ElementsAre("repair.clp replaces defrule finish (" + path("rules/rules.clp").string() + ":6)"));
  EXPECT_EQ(again.played.changed.front().t, from_seconds(1));
  ASSERT_FALSE(again.after.empty());
  EXPECT_EQ(again.after.front().t, from_seconds(1));
  EXPECT_THAT(again.after.front().text(), HasSubstr("env/main at 1.000 s: then "));
  EXPECT_TRUE(again.played.result.deterministic);
}

TEST_F(WhatIfTest, ChanceGoesOnAsItWouldHave) {
  play();
  what_if("again", {.at = 1, .facts = {"(order (id 1) (state done))"}});
  const auto drawn = [&](const std::string& folder) {
    std::vector<std::string> out;
    const auto records = read_journal(path(folder + "/journal.jsonl"), {.kinds = {RecordKind::kAssert}});
    for (const JournalRecord& record : *records)
      if (record.data.text("template") == "drawn") out.push_back(to_json(*record.data.find("slots")));
    return out;
  };
  EXPECT_THAT(drawn("out"), testing::SizeIs(testing::Gt(15)));
  EXPECT_EQ(drawn("out"), drawn("again"));
}

TEST_F(WhatIfTest, ItReplaysAndIsPlayedAgain) {
  play();
  const WhatIf change{.at = 1,
                      .file = path("repair.clp").string(),
                      .set = {"?*limit*=7", "clips_manager.patience=3"},
                      .facts = {"(order (id 3))", "(ready)"}};
  const Rerun first = what_if("first", change);
  EXPECT_THAT(changes(first),
              ElementsAre("sets clips_manager.patience to 3", HasSubstr("repair.clp replaces defrule finish ("),
                          "sets ?*limit* to 7 (it was 3)", AllOf(HasSubstr("asserts f-"), HasSubstr("(order (id 3))")),
                          HasSubstr("(ready)")));
  replays("first");
  what_if("second", change);
  EXPECT_EQ(run("first").stream_hashes, run("second").stream_hashes);
  std::filesystem::remove(path("repair.clp"));
  const auto again = rerun(run("first"), {.out = path("again").string()});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_THAT(again->differ, IsEmpty());
  EXPECT_THAT(again->changed_files, IsEmpty());
}

TEST_F(WhatIfTest, ARunThatWentOnOtherwiseCanDoSoAgain) {
  play();
  what_if("first", repair(1.5));
  const Rerun second = what_if("second", {.at = 0.5, .set = {"?*limit*=7"}}, "first");
  EXPECT_FALSE(second.before);
  EXPECT_THAT(changes(second), ElementsAre("sets ?*limit* to 7 (it was 3)", HasSubstr("repair.clp replaces")));
  EXPECT_EQ(journal("first", 0.5).first, journal("second", 0.5).first);
  EXPECT_THAT(journal("second", 0.5).second, AllOf(HasSubstr("\"done\""), HasSubstr(",7,")));
  replays("second");
  const auto again = rerun(run("second"), {.out = path("again").string()});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_THAT(again->differ, IsEmpty());
}

TEST_F(WhatIfTest, ConstructsThatAreTheSameStayAsTheyAre) {
  play();
  std::string rules = kBroken;
  rules.replace(rules.find("(ready)"), 7, "");
  write("whole.clp", rules);
  const Rerun again = what_if("again", {.at = 1, .file = path("whole.clp").string(), .set = {"?*limit*=4"}});
  EXPECT_THAT(changes(again), ElementsAre(HasSubstr("replaces defrule finish"), "sets ?*limit* to 4 (it was 3)"));
  const std::string since = journal("again", 1).second;
  EXPECT_THAT(since, HasSubstr("\"done\""));
  EXPECT_THAT(since, Not(HasSubstr("\"rule\":\"count-order\""))) << "it had fired for these orders";
}

TEST_F(WhatIfTest, AParameterCountsFromThereOn) {
  play();
  what_if("again", {.at = 1, .set = {"/clips_manager.patience=3"}});
  EXPECT_THAT(journal("again", 1).first, Not(HasSubstr(",3.0]")));
  EXPECT_THAT(journal("again", 1).second, AllOf(HasSubstr("[1.0,3.0]"), Not(HasSubstr(",1.5]"))));
  replays("again");
}

TEST_F(WhatIfTest, AnUnusedParameterIsAWarning) {
  play();
  const Rerun again = what_if("again", {.at = 1, .set = {"clips_manager.unread=6"}});
  EXPECT_THAT(again.played.result.warnings,
              ElementsAre(HasSubstr("'unread' was set during the run, but nothing has read it since")));
  EXPECT_THAT(what_if("asked", {.at = 1, .set = {"clips_manager.patience=6.5"}}).played.result.warnings, IsEmpty());
}

TEST_F(WhatIfTest, CallsOfTheFileAreCarriedOut) {
  play();
  write("calls.clp",
        "(deftemplate more (slot x))\n(assert (more (x 5)))\n(do-for-fact ((?o order)) (= ?o:id 2) (modify ?o (state "
        "LATE)))\n(bind ?*limit* 9)\n");
  const Rerun again = what_if("again", {.at = 1, .file = path("calls.clp").string()});
  EXPECT_THAT(changes(again), ElementsAre("calls.clp adds deftemplate more"));
  EXPECT_THAT(journal("again", 1).second, AllOf(HasSubstr("LATE"), HasSubstr("\"more\""), HasSubstr(",9,")));
  replays("again");
}

TEST_F(WhatIfTest, AnotherFileOfThenIsFound) {
  play();
  std::string other = kBroken;
  other.replace(other.find("(id 1)"), 6, "(id 9)");
  write("rules/rules.clp", other);
  const Rerun again = what_if("again", repair(1));
  ASSERT_TRUE(again.before);
  EXPECT_EQ(again.before->stream, "env/main");
  EXPECT_LT(again.before->t, from_seconds(1));
  EXPECT_THAT(again.changed_files, ElementsAre(HasSubstr("rules.clp")));
}

TEST_F(WhatIfTest, TheEnvironmentsOfARunThatWasKilledAreNotKnownBefore) {
  play();
  lab::Run killed = run("out");
  const Scenario scenario = loaded("game");
  WhatIf change{.at = 1, .facts = {"(ready)"}, .environments = {"other"}};
  EXPECT_THAT(prepare(change, killed, scenario).error().text(), HasSubstr("the run has no environment 'other'"));
  killed.finished = false;
  killed.stream_hashes.clear();
  EXPECT_TRUE(prepare(change, killed, scenario));
  change.at = 100;
  EXPECT_THAT(prepare(change, killed, scenario).error().text(),
              AllOf(StartsWith("--at: the run ends at "), HasSubstr("where the log of the run is cut off")));
}

TEST_F(WhatIfTest, WhatIsWrongIsFoundBeforeAnythingIsPlayed) {
  play();
  const std::string broken = write("broken.clp", "(defrule a => )\n(defrule b =>\n").string();
  const std::string binary = path("binary.clp").string();
  std::ofstream(binary) << std::string("PNG\0\1\2", 6);
  const std::vector<std::tuple<WhatIf, ErrorKind, std::string>> rows{
      {{.at = 2.5}, ErrorKind::kUsage, "--at: the run ends at 2 s"},
      {{.at = 1, .file = path("missing.clp").string()}, ErrorKind::kInput, "missing.clp: there is no such file"},
      {{.at = 1, .file = path("rules").string()}, ErrorKind::kInput, "is no file"},
      {{.at = 1, .file = write("empty.clp", "; nothing\n").string()}, ErrorKind::kInput, "no rule and no call"},
      {{.at = 1, .file = write("words.clp", "hello world\n").string()}, ErrorKind::kInput, "no rule and no call"},
      {{.at = 1, .file = broken}, ErrorKind::kInput, "broken.clp:2: "},
      {{.at = 1, .file = binary}, ErrorKind::kInput, "binary.clp:1: "},
      {{.at = 1, .set = {"limit"}}, ErrorKind::kUsage, "expected NODE.NAME=VALUE or ?*GLOBAL*=VALUE"},
      {{.at = 1, .set = {"=3"}}, ErrorKind::kUsage, "expected NODE.NAME=VALUE or ?*GLOBAL*=VALUE"},
      {{.at = 1, .set = {"seed=3"}}, ErrorKind::kUsage, "seed is fixed when a run begins; cxlab run"},
      {{.at = 1, .set = {"sed=3"}}, ErrorKind::kUsage, "found 'sed', expected a parameter of an agent's node"},
      {{.at = 1, .set = {"clips_manger.x=3"}}, ErrorKind::kUsage, "did you mean 'clips_manager'?"},
      {{.at = 1, .set = {"?limit=3"}}, ErrorKind::kUsage, "expected a global of rules: ?*NAME*"},
      {{.at = 1, .set = {"?*limit*="}}, ErrorKind::kUsage, "the value is missing"},
      {{.at = 1, .set = {"?*limit*=(+ 1"}}, ErrorKind::kUsage, "--set ?*limit*=(+ 1: found no closing parenthesis"},
      {{.at = 1, .set = {"?*limit*=\"a"}},
       ErrorKind::kUsage,
       "--set ?*limit*=\"a: found a string that is never closed"},
      {{.at = 1, .set = {"?*limit*=3)"}}, ErrorKind::kUsage, "--set ?*limit*=3): found ')'"},
      {{.at = 1, .facts = {"order"}}, ErrorKind::kUsage, "--assert order: expected one fact"},
      {{.at = 1, .facts = {"(a) (b)"}}, ErrorKind::kUsage, "expected one fact"},
      {{.at = 1, .facts = {"(order (id 3)"}},
       ErrorKind::kUsage,
       "--assert (order (id 3): found no closing parenthesis"},
      {{.at = 1, .file = path("repair.clp").string(), .environments = {"mian"}},
       ErrorKind::kUsage,
       "did you mean 'main'?"},
  };
  for (const auto& [change, kind, text] : rows) {
    const auto again = try_out("wrong", change);
    ASSERT_FALSE(again) << text;
    EXPECT_EQ(again.error().kind, kind) << again.error().text();
    EXPECT_THAT(again.error().text(), HasSubstr(text));
    EXPECT_FALSE(std::filesystem::exists(path("wrong"))) << text;
  }
}

TEST_F(WhatIfTest, WhatTheRulesDoNotHaveEndsTheRunBeforeItGoesOn) {
  play();
  const auto file = [&](const std::string& rules) { return write("x.clp", rules).string(); };
  const std::vector<std::pair<WhatIf, std::string>> rows{
      {{.at = 1, .file = file("(defrule ok => )\n\n(defrule b (ordr (id 3)) =>)\n")}, "x.clp:3: "},
      {{.at = 1, .set = {"?*limti*=3"}}, "--set ?*limti*=3: there is no global '?*limti*', did you mean '?*limit*'?"},
      {{.at = 1, .set = {"?*limit*=(no-such-function)"}}, "no-such-function"},
      {{.at = 1, .set = {"clips_manager.patienc=3"}}, "has no parameter 'patienc', did you mean 'patience'?"},
      {{.at = 1, .set = {"clips_manager.patience=fast"}}, "Wrong parameter type"},
      {{.at = 1, .facts = {"(ordr (id 3))"}}, "there is no template 'ordr', did you mean 'order'?"},
      {{.at = 1, .facts = {"(ordr 3)"}}, "there is no template 'ordr', did you mean 'order'?"},
      {{.at = 1, .facts = {"(order (idd 3))"}}, "has no slot 'idd', did you mean 'id'?"},
      {{.at = 1, .facts = {"(order (id red))"}}, "--assert (order (id red)): "},
  };
  for (const auto& [change, text] : rows) {
    if (!change.file.empty()) write("x.clp", "(defrule ok => )\n\n(defrule b (order (idd 3)) =>)\n");
    const Error error = refused(change);
    EXPECT_EQ(error.kind, ErrorKind::kInput) << error.text();
    EXPECT_EQ(error.code, kWhatIfCode);
    EXPECT_THAT(error.text(), HasSubstr(text));
  }
}

TEST_F(WhatIfTest, ARunThatEndedWithAWrongChangeReplays) {
  play();
  const auto again = try_out("again", {.at = 1, .facts = {"(ready)", "(ordr 3)"}});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->played.result.status, RunStatus::kFailed);
  EXPECT_EQ(again->played.result.sim_time, from_seconds(1));
  replays("again");
}

class TwoEnvironments : public WhatIfTest {
 protected:
  void SetUp() override {
    WhatIfTest::SetUp();
    write("agent.yaml", agent_text("rules", {"ros_param"}, {{.name = "left"}, {.name = "right"}}));
    play();
  }
};

TEST_F(TwoEnvironments, EachGetsTheFileUnlessOneIsChosen) {
  EXPECT_THAT(what_if("both", repair(1)).played.changed, testing::SizeIs(2));
  WhatIf one = repair(1);
  one.environments = {"right"};
  const Rerun again = what_if("one", one);
  ASSERT_THAT(again.played.changed, testing::SizeIs(1));
  EXPECT_EQ(again.played.changed.front().environment, "right");
  EXPECT_EQ(run("one").stream_hashes["env/left"], run().stream_hashes["env/left"]);
  EXPECT_NE(run("one").stream_hashes["env/right"], run().stream_hashes["env/right"]);
  replays("both");
  replays("one");
}

TEST_F(TwoEnvironments, FactsAreForOne) {
  const auto again = try_out("again", {.at = 1, .facts = {"(ready)"}});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(again.error().text(), HasSubstr("there are 2 environments: left, right; --env says which one"));
  EXPECT_THAT(changes(what_if("left", {.at = 1, .facts = {"(ready)"}, .environments = {"left"}})),
              ElementsAre(HasSubstr("(ready)")));
}

TEST(CompareResults, NamesWhatIsWorthReading) {
  const auto rows = compare_results(
      *shipped().find_world("rcll"),
      R"({"status":"completed","sim_time_s":9.5,"reason":null,"teams":{"CYAN":{"points":5,"by_kind":{"ring":5,"cap":0}}},"deliveries":[{"correct":true}]})",
      R"({"status":"failed","sim_time_s":9.5,"reason":{"message":"x"},"teams":{"CYAN":{"points":7,"by_kind":{"ring":7,"cap":0}}},"deliveries":[{"correct":false}]})");
  std::vector<std::string> texts;
  for (const ResultChange& row : rows) texts.push_back(row.what + ' ' + row.then + ' ' + row.now);
  EXPECT_THAT(texts, ElementsAre("status completed failed", "reason - x", "sim_time_s 9.5 9.5", "CYAN.points 5 7",
                                 "deliveries 1 0", "CYAN.ring 5 7"));
}

}  // namespace
}  // namespace cxlab::lab
