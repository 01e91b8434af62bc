#pragma once
// A table that is written row by row, in one of several formats.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/question.h"

namespace cxlab::lab {

struct TableColumn {
  enum class Kind : std::uint8_t { kWhole, kReal, kText };
  std::string key;
  Kind kind = Kind::kText;
};

/// A cell is empty, or of its column's kind.
class TableFile {
 public:
  virtual ~TableFile() = default;
  Status row(std::span<const TableCell> cells) {
    ++rows_;
    return put(cells);
  }
  virtual Status close() = 0;
  std::uint64_t rows() const { return rows_; }

 private:
  virtual Status put(std::span<const TableCell> cells) = 0;
  std::uint64_t rows_ = 0;
};

/// Comma-separated values (RFC 4180): a header, numbers in full, nothing in an empty cell.
Expected<std::unique_ptr<TableFile>> create_csv(const std::filesystem::path& path, std::vector<TableColumn> columns);

/// Columns and rows of a table of a world, with one kind a column: a stretch becomes two columns, KEY_begin and
/// KEY_end. The columns follow from those of the table, whatever its rows are; one with cells of another kind is text.
struct PlainTable {
  std::vector<TableColumn> columns;
  std::vector<std::vector<TableCell>> rows;
};
PlainTable plain_table(const Table& table);

}  // namespace cxlab::lab
