#pragma once
// Tables as streams of record batches in memory, by the C data interface of Apache Arrow
// (https://arrow.apache.org/docs/format/CDataInterface.html), which pyarrow, polars and DuckDB read without a copy.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "lab/export/table_file.h"

extern "C" {
#ifndef ARROW_C_DATA_INTERFACE
#define ARROW_C_DATA_INTERFACE
struct ArrowSchema {
  const char* format;
  const char* name;
  const char* metadata;
  int64_t flags;
  int64_t n_children;
  struct ArrowSchema** children;
  struct ArrowSchema* dictionary;
  void (*release)(struct ArrowSchema*);
  void* private_data;
};
struct ArrowArray {
  int64_t length;
  int64_t null_count;
  int64_t offset;
  int64_t n_buffers;
  int64_t n_children;
  const void** buffers;
  struct ArrowArray** children;
  struct ArrowArray* dictionary;
  void (*release)(struct ArrowArray*);
  void* private_data;
};
#endif
#ifndef ARROW_C_STREAM_INTERFACE
#define ARROW_C_STREAM_INTERFACE
struct ArrowArrayStream {
  int (*get_schema)(struct ArrowArrayStream*, struct ArrowSchema* out);
  int (*get_next)(struct ArrowArrayStream*, struct ArrowArray* out);
  const char* (*get_last_error)(struct ArrowArrayStream*);
  void (*release)(struct ArrowArrayStream*);
  void* private_data;
};
#endif
}

namespace cxlab::lab {

/// Cells of one column on their way into a batch: int64, double or UTF-8, each may be empty.
class ArrowColumn {
 public:
  explicit ArrowColumn(TableColumn::Kind kind) : kind_(kind) {}

  void put_empty();
  void put(std::int64_t whole);
  void put(double real);
  void put(std::string_view utf8);
  /// An empty cell, or one of the column's kind; bytes of a text that are no UTF-8 become U+FFFD.
  void put(const TableCell& cell);
  std::size_t size() const { return size_; }
  /// Of all cells.
  std::size_t bytes() const { return values_.size(); }
  /// Gives the cells away; the column is empty then.
  void move_to(ArrowArray& out);

 private:
  void mark(bool there);

  TableColumn::Kind kind_;
  std::size_t size_ = 0, empty_ = 0;
  std::string values_;
  std::vector<std::int64_t> ends_{0};  // of texts
  std::vector<std::uint8_t> there_;    // a bit a cell
};

/// Adds rows, some MB at most: the same number of cells to each column. No rows are the end.
using NextBatch = std::function<Status(std::vector<ArrowColumn>&)>;
/// Who takes the stream over releases it. `failed` is told why `next` failed; may be empty.
void make_arrow_stream(ArrowArrayStream& out, std::vector<TableColumn> columns, NextBatch next,
                       std::function<void(const Error&)> failed = {});

}  // namespace cxlab::lab
