// Rows of a sweep, read from a CSV file or from the files of a folder.

#include "lab/sweep/read_rows.h"

#include <gmock/gmock.h>

#include "folder.h"
#include "lab/sweep/row.h"

namespace cxlab::lab::read_rows_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// "scenario/strategy/game/seed status exit hash metric=value ..." of each row, or the error.
std::vector<std::string> read(const std::string& text) {
  const auto rows = rows_of_csv(text, "rows.csv", shipped());
  if (!rows) return {rows.error().text()};
  std::vector<std::string> out;
  for (const Row& row : *rows) {
    std::string line = row.cell.scenario + '/' + row.cell.strategy + '/' + row.cell.game + '/' +
                       std::to_string(row.cell.seed) + ' ' + row.status + ' ' + std::to_string(row.exit_code) + ' ' +
                       row.journal_hash;
    for (const Figure& figure : row.figures)
      line +=
          ' ' + std::string(figure.metric) + '=' + (figure.value ? std::to_string(*figure.value).substr(0, 4) : "-");
    out.push_back(line);
  }
  return out;
}

TEST(RowsOfCsv, HaveTheColumnsOfASweep) {
  EXPECT_THAT(
      read("scenario,strategy,game,seed,status,exit,points,rate,journal_hash\n"
           "game,a,,1,completed,0,20,0.5,abc\n"
           "game,b,g1,2,failed,3,,1.5,\n"),
      ElementsAre("game/a//1 completed 0 abc points=20.0 rate=0.50", "game/b/g1/2 failed 3  points=- rate=1.50"));
  EXPECT_THAT(read("seed,strategy,scenario,points\n7,a,game,3\n"), ElementsAre("game/a//7 completed 0  points=3.00"))
      << "made by hand, in any order";
}

TEST(RowsOfCsv, TakeAnyEndsOfLinesAndQuotes) {
  const std::vector<std::string> wanted{"a,b/say \"x\"//1 completed 0  points=2.00", "c/d//2 completed 0  points=3.00"};
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string text = "scenario,strategy,seed,points|\"a,b\",\"say \"\"x\"\"\",1,2||c,d,2,3";
    for (std::size_t at = 0; (at = text.find('|')) != text.npos;) text.replace(at, 1, end);
    EXPECT_EQ(read(text), wanted) << "without an end of the last line, and with an empty one";
    EXPECT_EQ(read(text + end), wanted);
  }
}

TEST(RowsOfCsv, ErrorsHaveTheirLine) {
  const std::string head = "scenario,strategy,seed,points\n";
  EXPECT_THAT(read(""), ElementsAre(HasSubstr("rows.csv: found an empty file")));
  EXPECT_THAT(read("\n\nscenario,strategy\n"),
              ElementsAre(HasSubstr("rows.csv:3: found the columns scenario, strategy")));
  EXPECT_THAT(read(head + "a,b,1,2\n\na,b,2\n"), ElementsAre(HasSubstr("rows.csv:4: found 3 fields")));
  EXPECT_THAT(read(head + "\"a\nb\",b,1,2\na,b,x,2\n"), ElementsAre(HasSubstr("rows.csv:4: found 'x' as seed")));
  EXPECT_THAT(read(head + "a,b,-1,2\n"), ElementsAre(HasSubstr("rows.csv:2: found '-1' as seed")));
  EXPECT_THAT(read(head + "a,b,1,inf\n"), ElementsAre(HasSubstr("rows.csv:2: found 'inf' as points")));
  EXPECT_THAT(read("scenario,strategy,seed,exit\na,b,1,half\n"),
              ElementsAre(HasSubstr("rows.csv:2: found 'half' as exit")));
  EXPECT_THAT(read(head + "a,b,1,\"2\n"), ElementsAre(HasSubstr("rows.csv:2: a quote without its end")));
  EXPECT_THAT(read(head + "\"a\n\"b,c,1,2\n"),
              ElementsAre(HasSubstr("rows.csv:3: found text after the end of a quote")));
}

class ReadRowsTest : public FolderTest {};

TEST_F(ReadRowsTest, OfAFolderAreInTheOrderOfTheirSeeds) {
  for (const std::uint64_t seed : {10u, 9u, 100u}) {
    Row row;
    row.cell.scenario = "game";
    row.cell.strategy = "a";
    row.cell.seed = seed;
    row.status = "completed";
    row.key = row.digest();
    write("out/rows/" + row_name(row.cell) + ".json", row.to_json());
  }
  const auto rows = read_rows(path("out"), shipped());
  ASSERT_TRUE(rows) << rows.error().text();
  std::vector<std::uint64_t> seeds;
  for (const Row& row : *rows) seeds.push_back(row.cell.seed);
  EXPECT_THAT(seeds, ElementsAre(9u, 10u, 100u));
}

TEST_F(ReadRowsTest, TheSameGameTwiceIsRefused) {
  const std::string head = "scenario,strategy,game,seed,points\na,b,g,1,2\n";
  const auto read_as = [&](const std::string& row) {
    const auto rows = read_rows(write("rows.csv", head + row), shipped());
    return rows ? std::to_string(rows->size()) + " rows" : rows.error().text();
  };
  EXPECT_THAT(read_as("a,b,g,1,3\n"), HasSubstr("found two rows of a, b, game g, seed 1"));
  for (const char* other : {"x,b,g,1,3\n", "a,x,g,1,3\n", "a,b,x,1,3\n", "a,b,g,2,3\n"})
    EXPECT_EQ(read_as(other), "2 rows");
  EXPECT_THAT(read_rows(write("none.csv", "scenario,strategy,seed\n"), shipped()).error().text(),
              HasSubstr("found no row"));
  EXPECT_THAT(read_rows(path("nothing"), shipped()).error().text(), HasSubstr("there is no such sweep"));
  std::filesystem::create_directories(path("empty"));
  EXPECT_THAT(read_rows(path("empty"), shipped()).error().text(), HasSubstr("found no rows.csv and no rows/*.json"));
}

TEST_F(ReadRowsTest, TheMetricIsTheOneThatIsNamedOrThatOfTheWorld) {
  const auto metric = [](const std::string& text, const std::string& name, const std::string& scenario = {}) {
    const auto rows = rows_of_csv(text, "rows.csv", shipped());
    EXPECT_TRUE(rows);
    const auto found = metric_of(*rows, name, shipped(), scenario.empty() ? nullptr : &scenario);
    return found ? found->name + (found->more_is_better ? ", more" : ", less") : found.error().text();
  };
  const std::string two = "scenario,strategy,seed,mine,yours\na,s,1,2,\nb,s,1,,3\n";
  EXPECT_THAT(metric(two, "mine"), testing::StartsWith("mine"));
  EXPECT_THAT(metric(two, ""), testing::StartsWith("mine"));
  EXPECT_THAT(metric(two, "", "b"), testing::StartsWith("yours"));
  EXPECT_THAT(metric(two, "min"), HasSubstr("no row has a metric 'min'"));
  EXPECT_THAT(metric("scenario,strategy,seed,mine\na,s,1,\n", ""), HasSubstr("no row has a figure"));
}

}  // namespace
}  // namespace cxlab::lab::read_rows_test
