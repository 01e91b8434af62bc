#include "lab/export/table_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::Pair;
using Kind = TableColumn::Kind;

Table table_with(std::vector<std::vector<TableCell>> rows) {
  return {"orders",
          "",
          {{"order", "order", Column::Kind::kNumber},
           {"state", "state"},
           {"window_s", "window", Column::Kind::kStretch},
           {"begun_s", "begun", Column::Kind::kTime},
           {"share", "share", Column::Kind::kShare}},
          std::move(rows)};
}

std::vector<std::pair<std::string, Kind>> columns_of(const PlainTable& table) {
  std::vector<std::pair<std::string, Kind>> out;
  for (const TableColumn& column : table.columns) out.emplace_back(column.key, column.kind);
  return out;
}

TEST(PlainTable, HasTheSameColumnsWhateverItsRowsAre) {
  const std::vector<TableCell> whole{1, "OPEN", TableCell::Stretch(2, 3.5), 4, 1}, none(5);
  for (const auto& rows : {std::vector<std::vector<TableCell>>(), {whole}, {none}, {whole, none}})
    EXPECT_THAT(
        columns_of(plain_table(table_with(rows))),
        ElementsAre(Pair("order", Kind::kWhole), Pair("state", Kind::kText), Pair("window_s_begin", Kind::kReal),
                    Pair("window_s_end", Kind::kReal), Pair("begun_s", Kind::kReal), Pair("share", Kind::kReal)));
}

TEST(PlainTable, CellsAreOfTheKindOfTheirColumn) {
  const PlainTable table = plain_table(table_with({{1, 7, TableCell::Stretch(2, 3.5), 4, 0.5}, {2, {}, {}, {}, {}}}));
  std::vector<std::size_t> kinds;
  for (const TableCell& cell : table.rows[0]) kinds.push_back(cell.value.index());
  EXPECT_THAT(kinds, ElementsAre(2, 1, 3, 3, 3, 3)) << "a whole number, a text, and real numbers";
  EXPECT_EQ(std::get<std::string>(table.rows[0][1].value), "7");
  EXPECT_EQ(std::get<double>(table.rows[0][2].value), 2);
  EXPECT_EQ(std::get<double>(table.rows[0][3].value), 3.5);
  EXPECT_EQ(std::get<double>(table.rows[0][4].value), 4);
  for (std::size_t i = 1; i < table.columns.size(); ++i) EXPECT_TRUE(table.rows[1][i].empty()) << i;
}

TEST(PlainTable, ColumnWithCellsOfAnotherKindIsText) {
  const PlainTable table = plain_table(
      table_with({{"none", {}, "soon", TableCell::Stretch(2, 3.5), {}}, {1, {}, TableCell::Stretch(1, 2), 4.5, {}}}));
  EXPECT_THAT(columns_of(table),
              ElementsAre(Pair("order", Kind::kText), Pair("state", Kind::kText), Pair("window_s", Kind::kText),
                          Pair("begun_s", Kind::kText), Pair("share", Kind::kReal)));
  EXPECT_EQ(std::get<std::string>(table.rows[1][0].value), "1");
  EXPECT_EQ(std::get<std::string>(table.rows[1][2].value), "1-2");
  EXPECT_EQ(std::get<std::string>(table.rows[0][3].value), "2-3.5");
  EXPECT_EQ(std::get<std::string>(table.rows[1][3].value), "4.5");
}

TEST(PlainTable, RealNumberMakesAColumnOfNumbersReal) {
  const PlainTable table = plain_table(table_with({{1, {}, {}, {}, {}}, {1.5, {}, {}, {}, {}}}));
  EXPECT_EQ(table.columns[0].kind, Kind::kReal);
  EXPECT_EQ(std::get<double>(table.rows[0][0].value), 1);
}

}  // namespace
}  // namespace cxlab::lab
