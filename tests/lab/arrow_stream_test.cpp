#include "lab/export/arrow_stream.h"

#include <gtest/gtest.h>

#include <cstring>

namespace cxlab::lab {
namespace {

using Kind = TableColumn::Kind;

std::string text_at(const ArrowArray& column, std::int64_t row) {
  const auto* ends = static_cast<const std::int64_t*>(column.buffers[1]);
  return {static_cast<const char*>(column.buffers[2]) + ends[row], static_cast<std::size_t>(ends[row + 1] - ends[row])};
}
bool is_there(const ArrowArray& column, std::int64_t row) {
  const auto* bits = static_cast<const std::uint8_t*>(column.buffers[0]);
  return !bits || (bits[row / 8] >> row % 8 & 1) != 0;
}

/// A stream of ten rows: the number, half of it where it is even, and a text where it is no multiple of three.
ArrowArrayStream ten_rows() {
  ArrowArrayStream stream;
  make_arrow_stream(stream, {{"n", Kind::kWhole}, {"half", Kind::kReal}, {"name", Kind::kText}},
                    [n = 0](std::vector<ArrowColumn>& columns) mutable -> Status {
                      for (; n < 10; ++n) {
                        columns[0].put(std::int64_t{n});
                        columns[1].put(n % 2 == 0 ? TableCell(n / 2.0) : TableCell());
                        columns[2].put(n % 3 != 0 ? TableCell("t" + std::to_string(n)) : TableCell());
                      }
                      return {};
                    });
  return stream;
}

TEST(ArrowStream, CellsAreWhereTheInterfaceSays) {
  ArrowArrayStream stream = ten_rows();
  ArrowSchema schema;
  ASSERT_EQ(stream.get_schema(&stream, &schema), 0);
  EXPECT_STREQ(schema.format, "+s");
  ASSERT_EQ(schema.n_children, 3);
  EXPECT_STREQ(schema.children[0]->name, "n");
  EXPECT_STREQ(schema.children[0]->format, "l");
  EXPECT_STREQ(schema.children[1]->format, "g");
  EXPECT_STREQ(schema.children[2]->format, "U");
  schema.release(&schema);
  EXPECT_EQ(schema.release, nullptr);

  ArrowArray rows;
  ASSERT_EQ(stream.get_next(&stream, &rows), 0);
  ASSERT_EQ(rows.length, 10);
  const ArrowArray &n = *rows.children[0], &half = *rows.children[1], &name = *rows.children[2];
  EXPECT_EQ(n.null_count, 0);
  EXPECT_EQ(half.null_count, 5);
  EXPECT_EQ(name.null_count, 4);
  for (std::int64_t row = 0; row < 10; ++row) {
    EXPECT_EQ(static_cast<const std::int64_t*>(n.buffers[1])[row], row);
    EXPECT_EQ(is_there(half, row), row % 2 == 0);
    if (is_there(half, row)) {
      EXPECT_EQ(static_cast<const double*>(half.buffers[1])[row], static_cast<double>(row) / 2);
    }
    EXPECT_EQ(text_at(name, row), row % 3 != 0 ? "t" + std::to_string(row) : "");
  }
  ArrowArray end;
  ASSERT_EQ(stream.get_next(&stream, &end), 0);
  EXPECT_EQ(end.release, nullptr);
  rows.release(&rows);
  stream.release(&stream);
  EXPECT_EQ(stream.release, nullptr);
}

TEST(ArrowStream, ColumnOutlivesItsTable) {
  ArrowArrayStream stream = ten_rows();
  ArrowArray rows;
  ASSERT_EQ(stream.get_next(&stream, &rows), 0);
  ArrowArray kept = *rows.children[2];
  rows.children[2]->release = nullptr;  // taken over
  ArrowSchema schema;
  ASSERT_EQ(stream.get_schema(&stream, &schema), 0);
  ArrowSchema name = *schema.children[2];
  schema.children[2]->release = nullptr;
  schema.release(&schema);
  rows.release(&rows);
  stream.release(&stream);
  EXPECT_EQ(text_at(kept, 4), "t4");
  EXPECT_STREQ(name.name, "name");
  kept.release(&kept);
  name.release(&name);
}

TEST(ArrowStream, ErrorIsToldWithItsText) {
  ArrowArrayStream stream;
  std::string told;
  make_arrow_stream(
      stream, {{"n", Kind::kWhole}},
      [](std::vector<ArrowColumn>&) -> Status { return input_error("no record", "journal.jsonl", 7); },
      [&](const Error& error) { told = error.text(); });
  ArrowArray rows;
  EXPECT_NE(stream.get_next(&stream, &rows), 0);
  EXPECT_STREQ(stream.get_last_error(&stream), "journal.jsonl:7: no record");
  EXPECT_EQ(told, "journal.jsonl:7: no record");
  EXPECT_EQ(rows.release, nullptr);
  stream.release(&stream);
}

TEST(ArrowStream, BytesThatAreNoTextAreReplaced) {
  ArrowColumn column(Kind::kText);
  column.put(
      TableCell("a\xff"
                "b"));
  ArrowArray cells;
  column.move_to(cells);
  EXPECT_EQ(text_at(cells, 0),
            "a\xef\xbf\xbd"
            "b");
  cells.release(&cells);
  EXPECT_EQ(column.size(), 0U);
}

}  // namespace
}  // namespace cxlab::lab
