#include "lab/sweep/sweep.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <unistd.h>

#include <set>
#include <thread>

#include "cx/base/process.h"
#include "folder.h"
#include "lab/sweep/judged_sweep.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

struct Notes final : ProgressSink {
  std::vector<std::string> notes;
  std::atomic<bool> stop = false;
  std::size_t stop_after = 1000;

  void progress(double, double) override {}
  void note(std::string_view text) override {
    notes.emplace_back(text);
    if (notes.size() >= stop_after) stop = true;
  }
  Host host() { return {.progress = this, .stop = &stop}; }
};

class SweepTest : public FolderTest {
 protected:
  Suite suite(const std::string& seeds = "[1, 2, 3]") const {
    return *Suite::load(write(
        "suite.yaml", "scenarios: [game.yaml]\nseeds: " + seeds + "\nstrategies: {short: [duration_s=1], long: []}\n"));
  }
  Expected<std::vector<Row>> play(const Suite& suite, const Host& host = {}) const {
    return sweep(suite, {path("out"), 2}, host);
  }
  /// What of the rows does not depend on the machine.
  static std::vector<std::string> games(const std::vector<Row>& rows) {
    std::vector<std::string> out;
    for (const Row& row : rows)
      out.push_back(row.cell.strategy + ' ' + std::to_string(row.cell.seed) + ' ' + row.status + ' ' +
                    row.journal_hash);
    return out;
  }

  const std::string kRules = "(defrule draw (time ?) => (assert (drawn (random))))\n";
};

TEST_F(SweepTest, HasARowForEachCell) {
  scenario("game", kRules);
  const auto rows = play(suite());
  ASSERT_TRUE(rows) << rows.error().text();
  ASSERT_EQ(rows->size(), 6u);
  std::set<std::string> hashes;
  for (const Row& row : *rows) {
    EXPECT_TRUE(row.counts()) << row.to_json();
    hashes.insert(row.journal_hash);
  }
  EXPECT_EQ(hashes.size(), 6u);
  EXPECT_THAT(read("out/rows.csv"), HasSubstr("game,long,,3,completed,0,"));
}

TEST_F(SweepTest, ARowNamesTheFilesThatItsGameReadAndNoneOfTheProgram) {
  scenario("game", kRules);
  const auto rows = play(suite("[1]"));
  ASSERT_TRUE(rows);
  for (const Row& played : *rows) {
    const auto row = Row::parse(read("out/rows/" + row_name(played.cell) + ".json"));
    ASSERT_TRUE(row);
    std::vector<std::string> names;  // without definitions of interfaces
    for (const auto& [name, hash] : row->files) {
      EXPECT_FALSE(hash.empty()) << name;
      const std::filesystem::path file = name;
      if (file.extension() != ".msg" && file.extension() != ".srv" && file.extension() != ".action")
        names.push_back(file.filename().string());
    }
    EXPECT_THAT(names, testing::UnorderedElementsAre("agent.yaml", "game.yaml", "rules.clp"));
  }
}

TEST_F(SweepTest, PlaysAWorldOfTheCallersCatalogue) {
  static constexpr WorldKind kOwn{
      .name = "own", .what = "nothing", .make_stage = [](const StageSetup&) -> Expected<std::unique_ptr<Stage>> {
        return std::make_unique<Stage>();
      }};
  Catalogue catalogue = shipped();
  catalogue.worlds.push_back(&kOwn);
  scenario("game", kRules);
  write("game.yaml", read("game.yaml") + "world: {kind: own}\n");
  Suite suite = this->suite("[1]");
  EXPECT_THAT(suite.check().error().message, HasSubstr("found 'own', expected one of: none, rcll, turtlesim"));
  suite.catalogue = &catalogue;
  EXPECT_TRUE(suite.check());
  const auto rows = play(suite);
  for (const Row& row : *rows) EXPECT_TRUE(row.counts()) << row.to_json();
}

TEST_F(SweepTest, PlaysOnlyWhatIsNotThere) {
  scenario("game", kRules);
  const auto first = play(suite("[1]"));
  Notes notes;
  const auto more = play(suite("[1, 2]"), notes.host());
  ASSERT_TRUE(more);
  EXPECT_EQ(more->size(), 4u);
  ASSERT_EQ(notes.notes.size(), 3u);
  EXPECT_EQ(notes.notes[0], "2 rows are current and kept");
  EXPECT_THAT(notes.notes[1], StartsWith("[3/4] game "));
  Notes again;
  EXPECT_EQ(games(*play(suite("[1, 2]"), again.host())), games(*more));
  EXPECT_THAT(again.notes, ElementsAre("4 rows are current and kept"));
}

TEST_F(SweepTest, PlaysAgainAfterAChangeOfRulesConfigurationOrScenario) {
  scenario("game", kRules);
  const auto before = play(suite("[1]"));
  const auto played = [&] {
    Notes notes;
    const auto rows = play(suite("[1]"), notes.host());
    EXPECT_TRUE(rows);
    return notes.notes.size();
  };
  EXPECT_EQ(played(), 1u) << "one line: all are kept";
  write("rules/rules.clp", kRules + "(defrule more (time ?) => (assert (more (random))))\n");
  EXPECT_EQ(played(), 2u);
  EXPECT_EQ(played(), 1u);
  write("agent.yaml", read("agent.yaml") + "    # changed\n");
  EXPECT_EQ(played(), 2u);
  write("game.yaml", read("game.yaml") + "epoch: 7\n");
  EXPECT_EQ(played(), 2u);
  EXPECT_EQ(played(), 1u);
}

TEST_F(SweepTest, ARowOfAnotherProgramIsPlayedAgain) {
  scenario("game", kRules);
  const auto rows = play(suite("[1]"));
  ASSERT_TRUE(rows);
  Row old = rows->front();
  old.program = "another";
  for (Figure& figure : old.figures) figure.value = 1000;
  const std::string file = "out/rows/" + row_name(old.cell) + ".json";
  ASSERT_TRUE(std::filesystem::exists(path(file)));
  write(file, old.to_json());
  EXPECT_EQ(play(suite("[1]"))->front().figure("sim_time_s"), 1);
}

TEST_F(SweepTest, RowsOfAnotherFolderCountWhereTheFilesAreTheSame) {
  scenario("game", kRules);
  const auto make = [this](const std::string& folder) {
    for (const char* file : {"game.yaml", "agent.yaml", "rules/rules.clp"}) write(folder + '/' + file, read(file));
    return *Suite::load(write(folder + "/suite.yaml", "scenarios: [game.yaml]\nseeds: [1, 2]\nstrategies: {a: []}\n"));
  };
  const Suite here = make("here"), there = make("there");
  const auto rows = play(here);
  ASSERT_TRUE(rows);
  Notes notes;
  EXPECT_EQ(games(*play(there, notes.host())), games(*rows));
  EXPECT_THAT(notes.notes, ElementsAre("2 rows are current and kept"));
  write("there/rules/rules.clp", kRules + "(defrule more (time ?) => (assert (more (random))))\n");
  Notes again;
  EXPECT_NE(games(*play(there, again.host())), games(*rows));
  EXPECT_EQ(again.notes.size(), 2u);
}

TEST_F(SweepTest, AnEpisodeThatCouldNotBeginIsPlayedAgain) {
  scenario("game", kRules);
  const std::string rules = read("agent.yaml");
  std::filesystem::remove(path("agent.yaml"));
  EXPECT_EQ(play(suite("[1]"))->front().exit_code, 3);
  write("agent.yaml", rules);
  EXPECT_TRUE(play(suite("[1]"))->front().counts());
}

TEST_F(SweepTest, ABrokenRowIsPlayedAgain) {
  scenario("game", kRules);
  const auto rows = play(suite("[1]"));
  const std::string file = "out/rows/" + row_name(rows->front().cell) + ".json";
  write(file, read(file).substr(0, 100));
  EXPECT_EQ(games(*play(suite("[1]"))), games(*rows));
}

TEST_F(SweepTest, AFailedEpisodeHasARowWithItsError) {
  scenario("game", "(defrule wrong (time ?) => (+ 1 (nth$ 1 (create$ one))))\n");
  const auto rows = play(suite("[1]"));
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->front().status, "failed");
  EXPECT_EQ(rows->front().exit_code, 4);
  EXPECT_FALSE(rows->front().counts());
  ASSERT_FALSE(rows->front().errors.empty());
  EXPECT_THAT(rows->front().errors.front(), HasSubstr("wrong"));
}

TEST_F(SweepTest, ARowReportsUnusedParameters) {
  scenario("game", kRules);
  const auto rows = play(*Suite::load(write(
      "suite.yaml",
      "scenarios: [game.yaml]\nseeds: [1]\nstrategies: {wrong: ['agents[0].params={clips_manager.gian: 1}']}\n")));
  ASSERT_TRUE(rows);
  EXPECT_TRUE(rows->front().counts());
  ASSERT_EQ(rows->front().warnings.size(), 1u);
  EXPECT_THAT(rows->front().warnings.front(), HasSubstr("parameter 'gian' was set, but nothing reads it"));
}

TEST_F(SweepTest, AWarningIsNewOnceInEachStrategy) {
  struct Ended final : ProgressSink {
    std::vector<std::string> tells, others;
    void progress(double, double) override {}
    void game_ended(std::string_view line, const GamesProgress&, bool tell) override {
      (tell ? tells : others).emplace_back(line.substr(line.find("game ") + 5, 1));
    }
    void note(std::string_view) override {}
  };
  scenario("game", kRules);
  Ended ended;
  const std::string unused = "['agents[0].params={clips_manager.gian: 1}']";
  ASSERT_TRUE(play(*Suite::load(write("suite.yaml", "scenarios: [game.yaml]\nseeds: [1, 2, 3]\nstrategies: {a: " +
                                                        unused + ", b: " + unused + ", c: []}\n")),
                   {.progress = &ended}));
  EXPECT_THAT(ended.tells, testing::UnorderedElementsAre("a", "b"));
  EXPECT_EQ(ended.others.size(), 7u);
}

TEST_F(SweepTest, ARowTellsWhatRulesPrintAsErrorAlsoWhenItIsKept) {
  scenario("game", "(defrule told => (printout error \"found 'grops'\" crlf \"found 'x'\" crlf))\n");
  for (const char* where : {"[1/1] ", "kept: "}) {
    Notes notes;
    const auto rows = play(
        *Suite::load(write("suite.yaml", "scenarios: [game.yaml]\nseeds: [1]\nstrategies: {a: []}\n")), notes.host());
    ASSERT_TRUE(rows);
    EXPECT_TRUE(rows->front().counts());
    EXPECT_EQ(notes.notes.back(), std::string(where) +
                                      "game a seed 1: completed, exit 0; environment 'main' printed as "
                                      "error: found 'grops'; environment 'main' printed as error: found 'x'");
  }
}

TEST_F(SweepTest, ASecondSweepInTheFolderIsRefused) {
  scenario("game", kRules);
  std::filesystem::create_directories(path("out"));
  const int file = open(path("out/.lock").c_str(), O_CREAT | O_RDWR, 0644);
  ASSERT_EQ(flock(file, LOCK_EX), 0);
  const auto rows = play(suite("[1]"));
  ASSERT_FALSE(rows);
  EXPECT_THAT(rows.error().message, HasSubstr("another sweep works in this folder"));
  close(file);
  EXPECT_TRUE(play(suite("[1]")));
}

TEST_F(SweepTest, HasItsFolderForItselfUntilItEnds) {
  struct Stranger final : ProgressSink {
    explicit Stranger(std::filesystem::path lock) : lock_(std::move(lock)) {}
    bool gets_in() const {
      const int file = open(lock_.c_str(), O_RDWR);
      const bool in = flock(file, LOCK_SH | LOCK_NB) == 0;
      close(file);
      return in;
    }
    void progress(double, double) override {}
    void game_ended(std::string_view, const GamesProgress&, bool) override { got_in.push_back(gets_in()); }
    void note(std::string_view) override {}
    std::vector<bool> got_in;

   private:
    std::filesystem::path lock_;
  };
  scenario("game", kRules);
  Stranger stranger(path("out/.lock"));
  ASSERT_TRUE(sweep(suite("[1]"), {path("out"), 2}, {.progress = &stranger}));
  EXPECT_THAT(stranger.got_in, ElementsAre(false, false));
  EXPECT_TRUE(stranger.gets_in());
}

TEST_F(SweepTest, StagesHaveOneProgressAndKeepRowsOfLaterGames) {
  struct Totals final : ProgressSink {
    std::set<std::size_t> totals;
    std::vector<std::string> notes;
    void progress(double, double) override {}
    void sweep_progress(const GamesProgress& games) override {
      EXPECT_TRUE(games.may_end_early);
      totals.insert(games.total);
    }
    void game_ended(std::string_view, const GamesProgress&, bool) override {}
    void note(std::string_view text) override { notes.emplace_back(text); }
  };
  scenario("game", kRules);
  std::vector<std::pair<std::size_t, std::size_t>> asked;
  const auto play_stages = [&](Totals& said) {
    asked.clear();
    const SweepStages stages{{1, 2, 3}, [&](std::size_t games, const std::vector<Row>& rows) -> Expected<bool> {
                               asked.emplace_back(games, rows.size());
                               return games >= 2;
                             }};
    return sweep(suite(), {path("out"), 2}, {.progress = &said}, &stages);
  };
  Totals first;
  auto rows = play_stages(first);
  ASSERT_TRUE(rows) << rows.error().text();
  EXPECT_EQ(rows->size(), 4u);
  EXPECT_EQ(asked, (std::vector<std::pair<std::size_t, std::size_t>>{{1, 2}, {2, 4}}));
  EXPECT_EQ(first.totals, std::set<std::size_t>{6});
  EXPECT_THAT(first.notes, IsEmpty());
  ASSERT_EQ(play(suite())->size(), 6u);
  Totals again;
  rows = play_stages(again);
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->size(), 6u);
  EXPECT_EQ(asked.back(), (std::pair<std::size_t, std::size_t>{3, 6})) << "what is there counts";
  EXPECT_THAT(again.notes, ElementsAre("6 rows are current and kept"));
}

TEST_F(SweepTest, AStopKeepsTheRowsThatAreThere) {
  scenario("game", kRules);
  Notes notes;
  notes.stop_after = 1;
  const auto some = play(suite(), notes.host());
  ASSERT_TRUE(some);
  EXPECT_LT(some->size(), 6u);
  EXPECT_GE(some->size(), 1u);
  EXPECT_EQ(play(suite())->size(), 6u);
}

TEST_F(SweepTest, AStopBetweenTwoLooksAnswersNothing) {
  struct Stopper final : ProgressSink {
    explicit Stopper(std::size_t after) : after_(after) {}
    void progress(double, double) override {}
    void game_ended(std::string_view, const GamesProgress&, bool) override { stop = ++ended_ >= after_; }
    void note(std::string_view) override {}
    std::atomic<bool> stop = false;

   private:
    std::size_t after_, ended_ = 0;
  };
  scenario("game", kQuietRules);
  const auto games = Suite::load(
      write("suite.yaml",
            "scenarios: [game.yaml]\nseeds: 1..20\nstrategies: {one: [duration_s=0.1], two: [duration_s=0.1]}\n"
            "require: not worse than one in sim_time_s\n"));
  ASSERT_TRUE(games) << games.error().text();
  for (const auto& [after, answers] : {std::pair{30, 0u}, {1000, 1u}}) {  // the first look is after 12 of 20 games
    Stopper stopper(static_cast<std::size_t>(after));
    const auto judged = judged_sweep(*games, {path("out"), 2}, false, {.progress = &stopper, .stop = &stopper.stop});
    ASSERT_TRUE(judged) << judged.error().text();
    EXPECT_GE(judged->rows.size(), 30u);
    EXPECT_EQ(judged->answers.size(), answers);
  }
}

TEST_F(SweepTest, KillsAtAnyMomentLoseNothing) {
  scenario("game", kRules);
  const auto whole = sweep(suite(), {path("whole"), 2});
  ASSERT_TRUE(whole);
  const Suite games_of = suite();
  for (int i = 0; i < 8; ++i) {
    auto sweeper = Process::fork({}, [&] { return play(games_of) ? 0 : 1; });
    ASSERT_TRUE(sweeper);
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + 37 * i));
    ::kill(sweeper->pid(), SIGKILL);  // not its group: its children must end by themselves
    sweeper->wait();
  }
  Expected<std::vector<Row>> rows = play(games_of);
  for (int i = 0; i < 100 && !rows; ++i) {  // until the last child has given up the folder
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    rows = play(games_of);
  }
  ASSERT_TRUE(rows) << rows.error().text();
  EXPECT_EQ(games(*rows), games(*whole));
}

}  // namespace
}  // namespace cxlab::lab
