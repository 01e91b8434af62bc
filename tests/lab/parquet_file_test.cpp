// The footer of a Parquet file, read by what the format says (Thrift's compact protocol), for tables of any width.

#include "lab/export/parquet_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <memory>

#include "tests/support/files.h"

namespace cxlab::lab {
namespace {

/// A value of Thrift: a number, a text, a list or a struct. Reading throws at the end of the bytes.
struct ThriftValue {
  std::int64_t number = 0;
  std::string text;
  std::vector<ThriftValue> list;
  std::map<int, ThriftValue> fields;
};

class CompactReader {
 public:
  explicit CompactReader(std::string bytes) : bytes_(std::move(bytes)) {}
  ThriftValue structure() {
    ThriftValue out;
    for (int field = 0, head = byte(); head != 0; head = byte()) {
      field += head >> 4;
      EXPECT_NE(head >> 4, 0) << "fields come in order, each within 15 of the one before";
      out.fields[field] = value(head & 15);
    }
    return out;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  int byte() { return static_cast<unsigned char>(bytes_.at(at_++)); }
  std::uint64_t varint() {
    std::uint64_t out = 0;
    for (int shift = 0;; shift += 7) {
      const int next = byte();
      out |= static_cast<std::uint64_t>(next & 127) << shift;
      if (next < 128) return out;
    }
  }
  ThriftValue value(int type) {
    ThriftValue out;
    if (type == 5 || type == 6) {  // i32, i64
      const std::uint64_t zigzag = varint();
      out.number = static_cast<std::int64_t>(zigzag >> 1) ^ -static_cast<std::int64_t>(zigzag & 1);
    } else if (type == 8) {  // binary
      for (std::uint64_t left = varint(); left > 0; --left) out.text += static_cast<char>(byte());
    } else if (type == 9) {  // list
      const int head = byte();
      const std::uint64_t size = head >> 4 == 15 ? varint() : static_cast<std::uint64_t>(head >> 4);
      for (std::uint64_t i = 0; i < size; ++i) out.list.push_back(value(head & 15));
    } else if (type == 12) {
      out = structure();
    } else {
      ADD_FAILURE() << "type " << type;
    }
    return out;
  }

  std::string bytes_;
  std::size_t at_ = 0;
};

TEST(ParquetFile, ItsFooterDescribesEachColumnWhateverTheirNumber) {
  const TempFolder folder;
  for (const std::size_t width : {1U, 2U, 13U, 14U, 15U, 16U, 40U}) {
    const std::filesystem::path path = folder.path() / (std::to_string(width) + ".parquet");
    std::vector<TableColumn> columns;
    for (std::size_t i = 0; i < width; ++i)
      columns.push_back({"c" + std::to_string(i), static_cast<TableColumn::Kind>(i % 3)});
    auto file = create_parquet(path, columns);
    ASSERT_TRUE(file) << file.error().text();
    ASSERT_TRUE((*file)->row(std::vector<TableCell>(width)));
    ASSERT_TRUE((*file)->close());
    std::ifstream in(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    ASSERT_GE(bytes.size(), 12u);
    std::size_t size = 0;
    for (const std::size_t i : {5U, 6U, 7U, 8U}) size = size << 8 | static_cast<unsigned char>(bytes[bytes.size() - i]);
    CompactReader reader(bytes.substr(bytes.size() - 8 - size, size));
    ThriftValue footer = reader.structure();
    EXPECT_TRUE(reader.at_end()) << width;
    const auto& schema = footer.fields[2].list;
    ASSERT_EQ(schema.size(), width + 1) << "the table and its columns";
    EXPECT_EQ(footer.fields[3].number, 1) << "rows";
    ASSERT_EQ(footer.fields[4].list.size(), 1u) << "groups of rows";
    auto& chunks = footer.fields[4].list[0].fields[1].list;
    ASSERT_EQ(chunks.size(), width);
    for (std::size_t i = 0; i < width; ++i) {
      const std::int64_t types[]{2, 5, 6};  // INT64, DOUBLE, BYTE_ARRAY
      auto element = schema[i + 1].fields;
      EXPECT_EQ(element[4].text, columns[i].key);
      EXPECT_EQ(element[1].number, types[i % 3]);
      EXPECT_EQ(element.contains(6), columns[i].kind == TableColumn::Kind::kText) << "UTF8";
      auto& about = chunks[i].fields[3].fields;
      EXPECT_EQ(about[1].number, types[i % 3]);
      ASSERT_EQ(about[2].list.size(), 2u) << "encodings: of values and of what is there";
      EXPECT_EQ(about[2].list[0].number, 0) << "PLAIN";
      EXPECT_EQ(about[2].list[1].number, 3) << "RLE";
      ASSERT_EQ(about[3].list.size(), 1u);
      EXPECT_EQ(about[3].list[0].text, columns[i].key);
      EXPECT_EQ(about[4].number, 6) << "ZSTD";
      EXPECT_EQ(about[5].number, 1) << "cells";
    }
  }
}

}  // namespace
}  // namespace cxlab::lab
