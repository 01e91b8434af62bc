#include "lab/sweep/row.h"

#include <gmock/gmock.h>

#include "folder.h"

namespace cxlab::lab {
namespace {

class RowTest : public FolderTest {
 protected:
  Row row() const {
    Row out;
    out.cell = {"game", "fast", 7, "game.yaml", {"world.robots=2", "seed=7"}};
    out.program = "1234";
    out.files = {{path("rules.clp").string(), hash_of(path("rules.clp"))}};
    out.status = "completed";
    out.errors = {"something \"quoted\"\nand more"};
    out.figures = {237, 5, 0.25, 151.5};
    out.journal_hash = "abcd";
    return out;
  }
};

TEST_F(RowTest, IsTheSameAfterWritingAndReading) {
  const auto again = Row::parse(row().to_json());
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->to_json(), row().to_json());
}

TEST_F(RowTest, IsAnErrorIfTheTextIsNoRow) {
  for (const char* text : {"", "{", "[]", "{}", "{\"schema\": 1}", "{\"schema\": 99}", "{\"schema\": \"one\"}"})
    EXPECT_FALSE(Row::parse(text)) << text;
  std::string cut = row().to_json();
  for (; cut.size() > 1; cut.resize(cut.size() - 1 - cut.size() / 50))
    EXPECT_FALSE(Row::parse(cut.substr(0, cut.size() - 2)));
}

TEST_F(RowTest, IsCurrentWhileProgramOverridesAndFilesAreTheSame) {
  write("rules.clp", "(defrule a =>)");
  const Row then = row();
  EXPECT_TRUE(then.is_current(then.cell, "1234"));
  EXPECT_FALSE(then.is_current(then.cell, "another program"));
  Cell other = then.cell;
  other.overrides = {"world.robots=3", "seed=7"};
  EXPECT_FALSE(then.is_current(other, "1234"));
  write("rules.clp", "(defrule b =>)");
  EXPECT_FALSE(then.is_current(then.cell, "1234"));
  write("rules.clp", "(defrule a =>)");
  EXPECT_TRUE(then.is_current(then.cell, "1234"));
  std::filesystem::remove(path("rules.clp"));
  EXPECT_FALSE(then.is_current(then.cell, "1234"));
}

TEST_F(RowTest, NamesOfCellsDiffer) {
  const Cell cell{"game", "a-1", 1, "x/game.yaml", {}};
  Cell other = cell;
  other.strategy = "a_1";
  EXPECT_NE(row_name(cell), row_name(other));
  other = {"game-a", "1", 1, "x/game.yaml", {}};
  EXPECT_NE(row_name(cell), row_name(other));
  other = cell;
  other.file = "y/game.yaml";
  EXPECT_NE(row_name(cell), row_name(other));
  EXPECT_EQ(row_name(cell), row_name(cell));
  other.strategy = "../../etc/" + std::string(300, 'x');
  EXPECT_EQ(row_name(other).find('/'), std::string::npos);
  EXPECT_LT(row_name(other).size(), 200u);
}

TEST_F(RowTest, CsvQuotesWhatNeedsIt) {
  Row odd = row();
  odd.cell.strategy = "two, \"three\"";
  Row of_game = row();
  of_game.cell.game = "g1";
  const std::string csv = to_csv({of_game, odd});
  EXPECT_EQ(csv,
            "scenario,strategy,game,seed,status,exit,points,deliveries,busy,real_time_factor,journal_hash\n"
            "game,fast,g1,7,completed,0,237.0,5.0,0.25,151.5,abcd\n"
            "game,\"two, \"\"three\"\"\",,7,completed,0,237.0,5.0,0.25,151.5,abcd\n");
}

TEST_F(RowTest, CsvHasNoFiguresOfAnEpisodeWithoutResult) {
  Row crashed;
  crashed.cell = row().cell;
  crashed.status = "crashed";
  crashed.exit_code = 139;
  EXPECT_THAT(to_csv({crashed}), testing::HasSubstr("game,fast,,7,crashed,139,,,,,\n"));
}

TEST(FiguresOf, AddsUpTeamsDeliveriesAndRobots) {
  const Figures f = figures_of(R"({"teams": {"CYAN": {"points": 30}, "MAGENTA": {"points": 12}},
    "deliveries": [{"correct": true}, {"correct": false}, {"correct": true}],
    "robots": [{"busy_s": 50}, {"busy_s": 100}], "sim_time_s": 100, "real_time_factor": 8})");
  EXPECT_EQ(f.points, 42);
  EXPECT_EQ(f.deliveries, 2);
  EXPECT_EQ(f.busy, 0.75);
  EXPECT_EQ(f.real_time_factor, 8);
}

}  // namespace
}  // namespace cxlab::lab
