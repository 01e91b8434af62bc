#include "lab/sweep/row.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "folder.h"
#include "scenarios/catalogue.h"
#include "scenarios/share.h"

namespace cxlab::lab {
namespace {

class RowTest : public FolderTest {
 protected:
  Row row() const {
    Row out;
    out.cell = {"game", "fast", 7, "game.yaml", {"world.robots=2", "seed=7"}};
    out.cell.parameters = {{"robots", "2"}};
    out.program = "1234";
    out.file = "game.yaml";
    out.key = "5678";
    out.files = {{"rules.clp", hash_of(path("rules.clp"))}};
    out.status = "completed";
    out.errors = {"something \"quoted\"\nand more"};
    out.warnings = {"careful"};
    out.world = "rcll";
    out.compared = "points";
    out.figures = {{"points", 237.0}, {"busy", 0.25}, {"late_s", std::nullopt}, {"wall_time_s", 1.5, true}};
    out.circumstances = {2.25, 30.5, "here", "c0ffee"};
    out.journal_hash = "abcd";
    return out;
  }
};

TEST_F(RowTest, IsTheSameAfterWritingAndReading) {
  const auto again = Row::parse(row().to_json());
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->to_json(), row().to_json());
}

TEST_F(RowTest, SaysWhatItsRulesMayTake) {
  Row limited = row();
  EXPECT_EQ(limited.to_json().find("allowance"), std::string::npos) << "as without options";
  EXPECT_EQ(limited.command(), command_of(limited.cell));
  const std::string usual = limited.digest();
  limited.allowance.steps = 2000;
  EXPECT_NE(limited.digest(), usual);
  const auto again = Row::parse(limited.to_json());
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->allowance, limited.allowance);
  EXPECT_EQ(limited.command(), command_of(limited.cell) + " --steps 2000");
}

TEST_F(RowTest, IsPlayedAgainIfItsRulesMayTakeLessOrItFailedAndTheyMayTakeMore) {
  write("rules.clp", "(defrule a =>)");
  Row then = row();
  Cell now = then.cell;
  now.file = path("game.yaml");
  const auto kept = [&](const Allowance& allowed) {
    return then.is_current(now, "1234", FileNames(path("game.yaml")), {}, allowed);
  };
  then.allowance.steps = 2000;
  Allowance less = then.allowance, more = then.allowance, none = then.allowance;
  less.steps = 1999;
  more.steps = 2001;
  none.steps = 0;
  for (const auto& [status, with_more] : {std::pair("completed", true), {"failed", false}}) {
    then.status = status;
    EXPECT_TRUE(kept(then.allowance)) << status;
    EXPECT_FALSE(kept(less)) << status;
    EXPECT_EQ(kept(more), with_more) << status;
    EXPECT_EQ(kept(none), with_more) << status;
  }
  then.status = "completed";
  then.allowance.steps = 0;
  EXPECT_FALSE(kept(more));
  EXPECT_TRUE(kept(none));
  Allowance memory = none;
  --memory.memory;
  EXPECT_FALSE(kept(memory));
}

TEST_F(RowTest, IsAnErrorIfTheTextIsNoRow) {
  for (const char* text : {"", "{", "[]", "{}", "{\"schema\": 1}", "{\"schema\": 99}", "{\"schema\": \"one\"}"})
    EXPECT_FALSE(Row::parse(text)) << text;
  for (const char* text : {"", "{", "[]", "{}"})
    EXPECT_EQ(Row::parse(text).error().message,
              "is not a row of a sweep, or is cut short; cxlab bench with its suite plays the game again");
  std::string cut = row().to_json();
  for (; cut.size() > 1; cut.resize(cut.size() - 1 - cut.size() / 50))
    EXPECT_FALSE(Row::parse(cut.substr(0, cut.size() - 2)));
}

TEST_F(RowTest, IsCurrentWhileProgramOverridesAndFilesAreTheSame) {
  write("rules.clp", "(defrule a =>)");
  const Row then = row();
  const FileNames names(path("game.yaml"));
  Cell now = then.cell;
  now.file = path("game.yaml");
  EXPECT_TRUE(then.is_current(now, "1234", names));
  EXPECT_FALSE(then.is_current(now, "another program", names));
  Cell other = now;
  other.overrides = {"world.robots=3", "seed=7"};
  EXPECT_FALSE(then.is_current(other, "1234", names));
  other.overrides = {"world.robots=2"};
  EXPECT_FALSE(then.is_current(other, "1234", names));
  write("rules.clp", "(defrule b =>)");
  EXPECT_FALSE(then.is_current(now, "1234", names));
  write("rules.clp", "(defrule a =>)");
  EXPECT_TRUE(then.is_current(now, "1234", names));
  std::filesystem::remove(path("rules.clp"));
  EXPECT_FALSE(then.is_current(now, "1234", names));
}

TEST_F(RowTest, IsCurrentWhereTheSameFilesLieInAnotherFolder) {
  for (const char* folder : {"here", "there"}) write(std::string(folder) + "/rules.clp", "(defrule a =>)");
  Row then = row();
  then.cell.file = path("here/game.yaml");
  then.cell.game = "g1";
  then.cell.game_file = path("here/g1.yaml");
  then.cell.overrides = {"world.game='" + path("here/g1.yaml").string() + "'", "seed=7"};
  then.cell.game_override = then.cell.overrides[0];
  then.files = {{"rules.clp", hash_of(path("here/rules.clp"))}};
  Cell now = then.cell;
  now.file = path("there/game.yaml");
  now.game_file = path("there/g1.yaml");
  now.overrides[0] = now.game_override = "world.game='" + path("there/g1.yaml").string() + "'";
  const FileNames names(now.file);
  EXPECT_TRUE(then.is_current(now, "1234", names));
  now.game = "g2";
  EXPECT_FALSE(then.is_current(now, "1234", names));
  now.game = "g1";
  now.overrides[1] = "seed=8";
  EXPECT_FALSE(then.is_current(now, "1234", names));
  now.overrides[1] = "seed=7";
  write("there/rules.clp", "(defrule b =>)");
  EXPECT_FALSE(then.is_current(now, "1234", names));
}

TEST_F(RowTest, ARowTellsOfAnEpisodeThatDidNotComeToItsEnd) {
  write("rules.clp", "(defrule a =>)");
  Row then = row();
  then.journal_hash.clear();
  const FileNames names(path("game.yaml"));
  Cell now = then.cell;
  now.file = path("game.yaml");
  EXPECT_FALSE(then.is_current(now, "1234", names));
  EXPECT_TRUE(then.tells_of(now, "1234", names));
  Cell other = now;
  other.seed = 8;
  EXPECT_FALSE(then.tells_of(other, "1234", names));
  other = now;
  other.file = path("other.yaml");
  EXPECT_FALSE(then.tells_of(other, "1234", names));
  EXPECT_FALSE(then.tells_of(now, "another program", names));
}

TEST_F(RowTest, TheDigestIsThatOfContentAlone) {
  const Row then = row();
  Row other = then;
  other.cell.strategy = "called otherwise";
  other.cell.scenario = "too";
  other.cell.file = "/elsewhere/game.yaml";
  EXPECT_EQ(other.digest(), then.digest());
  other = then;
  other.program = "12345";
  EXPECT_NE(other.digest(), then.digest());
  other = then;
  other.cell.overrides[0] = "world.robots=3";
  EXPECT_NE(other.digest(), then.digest());
  other = then;
  other.files["rules.clp"] = "changed";
  EXPECT_NE(other.digest(), then.digest());
}

TEST_F(RowTest, OnlyTheLastKeyDiffersFromMachineToMachine) {
  const auto without_played = [](const Row& row) {
    auto json = nlohmann::ordered_json::parse(row.to_json());
    EXPECT_EQ(std::prev(json.end()).key(), "played");
    json.erase("played");
    return json.dump();
  };
  Row other = row();
  other.cell.file = "/elsewhere/game.yaml";
  other.figures.back().value = 99;
  other.circumstances = {7, 8, "there", "beef"};
  EXPECT_NE(other.to_json(), row().to_json());
  EXPECT_EQ(without_played(other), without_played(row()));
  EXPECT_EQ(to_csv({other}), to_csv({row()}));
}

TEST_F(RowTest, ARowWithoutFilesIsPlayedAgain) {
  Row then = row();
  then.files.clear();
  EXPECT_FALSE(then.is_current(then.cell, "1234", FileNames(path("game.yaml"))));
}

TEST_F(RowTest, FilesAreNamedFromTheirPackageOrTheScenario) {
  const auto names_in = [this](const std::string& folder) {
    FileNames names(path(folder + "/games/game.yaml"));
    Scenario scenario;
    scenario.file = path(folder + "/games/game.yaml");
    scenario.agents.emplace_back().packages["mine"] = {"../mine"};
    scenario.agents.back().packages["inner"] = {"../mine/inner"};
    names.use_packages(scenario);
    return names;
  };
  const FileNames here = names_in("here"), there = names_in("there");
  for (const auto& [file, name] : {std::pair("mine/clips/a.clp", "package://mine/clips/a.clp"),
                                   {"mine/inner/b.clp", "package://inner/b.clp"},
                                   {"mine2/c.clp", "../mine2/c.clp"},
                                   {"games/game.yaml", "game.yaml"}}) {
    EXPECT_EQ(here.name_of(path("here") / file), name);
    EXPECT_EQ(here.path_of(name), path("here") / file);
    EXPECT_EQ(there.path_of(name), path("there") / file);
  }
  EXPECT_EQ(here.name_of(find_share().models / "field.xml"), "cxlab://models/field.xml");
  EXPECT_EQ(here.path_of("cxlab://models/field.xml"), find_share().models / "field.xml");
  EXPECT_EQ(here.name_of("/usr/lib/x.so"), "/usr/lib/x.so");
  EXPECT_EQ(here.path_of("/usr/lib/x.so"), "/usr/lib/x.so");
  EXPECT_EQ(here.path_of("package://unknown/a.clp"), "");
  EXPECT_EQ(here.path_of("package://mine"), "");
}

TEST_F(RowTest, NamesOfCellsDiffer) {
  const Cell cell{"game", "a-1", 1, "x/game.yaml", {}};
  Cell other = cell;
  other.strategy = "a_1";
  EXPECT_NE(row_name(cell), row_name(other));
  other = {"game-a", "1", 1, "x/game.yaml", {}};
  EXPECT_NE(row_name(cell), row_name(other));
  other = cell;
  other.named = "../game.yaml";
  EXPECT_NE(row_name(cell), row_name(other));
  other = cell;
  other.overrides = {"seed=1"};
  EXPECT_NE(row_name(cell), row_name(other));
  EXPECT_EQ(row_name(cell), row_name(cell));
  other.strategy = "../../etc/" + std::string(300, 'x');
  EXPECT_EQ(row_name(other).find('/'), std::string::npos);
  EXPECT_LT(row_name(other).size(), 200u);
}

TEST_F(RowTest, NamesOfCellsAreTheSameInAnotherFolder) {
  Cell cell{"game", "a", 1, "/x/game.yaml", {"world.game='/x/g.yaml'", "seed=1"}, "g", "world.game='/x/g.yaml'"};
  cell.named = "../game.yaml";
  Cell other = cell;
  other.file = "/y/game.yaml";
  other.overrides[0] = other.game_override = "world.game='/y/g.yaml'";
  EXPECT_EQ(row_name(cell), row_name(other));
  other.game = "h";
  EXPECT_NE(row_name(cell), row_name(other));
}

TEST_F(RowTest, CsvQuotesWhatNeedsIt) {
  Row odd = row();
  odd.cell.strategy = "two, \"three\"";
  Row of_game = row();
  of_game.cell.game = "g1";
  const std::string csv = to_csv({of_game, odd});
  EXPECT_EQ(csv,
            "scenario,strategy,game,seed,status,exit,points,busy,late_s,journal_hash\n"
            "game,fast,g1,7,completed,0,237.0,0.25,,abcd\n"
            "game,\"two, \"\"three\"\"\",,7,completed,0,237.0,0.25,,abcd\n");
}

TEST_F(RowTest, CsvHasAColumnForEachMetricOfAnyWorld) {
  Row other = row();
  other.figures = {{"steps", 3.0}, {"busy", 1.0}};
  EXPECT_EQ(to_csv({row(), other}),
            "scenario,strategy,game,seed,status,exit,points,busy,late_s,steps,journal_hash\n"
            "game,fast,,7,completed,0,237.0,0.25,,,abcd\n"
            "game,fast,,7,completed,0,,1.0,,3.0,abcd\n");
}

TEST_F(RowTest, CsvHasNoFiguresOfAnEpisodeWithoutResult) {
  Row crashed;
  crashed.cell = row().cell;
  crashed.status = "crashed";
  crashed.exit_code = 139;
  EXPECT_THAT(to_csv({crashed, row()}), testing::HasSubstr("game,fast,,7,crashed,139,,,,\n"));
  Row unfinished = row();
  unfinished.journal_hash.clear();
  EXPECT_THAT(to_csv({unfinished}), testing::HasSubstr("completed,0,,,,\n"));
}

TEST_F(RowTest, MeasuresWhatTheWorldDeclares) {
  Row game;
  game.measure(*shipped().find_world("rcll"), R"({"teams": {"CYAN": {"points": 30, "by_kind": {"ring": 5}},
    "MAGENTA": {"points": 12, "by_kind": {"ring": 10}}},
    "deliveries": [{"correct": true, "late_s": 2}, {"correct": false, "late_s": 0.5}, {"correct": true, "late_s": 0}],
    "robots": [{"busy_s": 50, "wait_s": 3, "failures": 1}, {"busy_s": 100, "wait_s": 4, "failures": 2}],
    "sim_time_s": 100, "real_time_factor": 8})");
  EXPECT_EQ(game.world, "rcll");
  EXPECT_EQ(game.compared, "points");
  for (const auto& [metric, value] : {std::pair("points", 42.0),
                                      {"deliveries", 2},
                                      {"busy", 0.75},
                                      {"points_ring", 15},
                                      {"late_s", 2.5},
                                      {"wait_s", 7},
                                      {"failures", 3},
                                      {"real_time_factor", 8}})
    EXPECT_EQ(game.figure(metric), value) << metric;
  EXPECT_EQ(game.figure("points_cap"), std::nullopt) << "this result does not say";
  EXPECT_EQ(game.figure("nothing"), std::nullopt);
  const auto again = Row::parse(game.to_json());
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->figure("busy"), 0.75);
  EXPECT_EQ(again->figures.size(), game.figures.size());
  Row plain;
  plain.measure(kEmptyWorld, R"({"sim_time_s": 100, "real_time_factor": 8})");
  EXPECT_EQ(plain.compared, "");
  EXPECT_EQ(plain.figure("sim_time_s"), 100);
}

TEST(KeysOfRow, AreThoseThatARowWithoutFiguresHas) {
  const auto json = nlohmann::json::parse(Row().to_json());
  for (const auto& [key, value] : json.items()) EXPECT_TRUE(is_key_of_row(key)) << key;
  EXPECT_TRUE(is_key_of_row("Seed")) << "SQLite makes no difference";
  EXPECT_FALSE(is_key_of_row("points"));
}

}  // namespace
}  // namespace cxlab::lab
