#include "lab/export/arrow_stream.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "cx/base/json.h"

namespace cxlab::lab {

namespace {

// Texts have offsets of 64 bit, so that no batch is too large for them.
const char* arrow_format(TableColumn::Kind kind) {
  return kind == TableColumn::Kind::kWhole ? "l" : kind == TableColumn::Kind::kReal ? "g" : "U";
}

bool is_ascii(std::string_view text) {
  return std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) >= 0x80; });
}

// Each array and schema owns its part, because a reader may keep a column longer than its table.
struct ArrowCells {
  std::string values;
  std::vector<std::int64_t> ends;
  std::vector<std::uint8_t> there;
  const void* buffers[3] = {};
};

void release_cells(ArrowArray* array) {
  delete static_cast<ArrowCells*>(array->private_data);
  array->release = nullptr;
}

struct ArrowRows {
  std::vector<ArrowArray> columns;
  std::vector<ArrowArray*> pointers;
  const void* no_buffer = nullptr;  // all rows are there
};

void release_rows(ArrowArray* array) {
  auto* rows = static_cast<ArrowRows*>(array->private_data);
  for (ArrowArray& column : rows->columns)
    if (column.release) column.release(&column);  // who took a column over cleared this
  delete rows;
  array->release = nullptr;
}

struct ArrowColumns {
  std::vector<ArrowSchema> columns;
  std::vector<ArrowSchema*> pointers;
};

void release_name(ArrowSchema* schema) {
  delete static_cast<std::string*>(schema->private_data);
  schema->release = nullptr;
}

void release_columns(ArrowSchema* schema) {
  auto* columns = static_cast<ArrowColumns*>(schema->private_data);
  for (ArrowSchema& column : columns->columns)
    if (column.release) column.release(&column);
  delete columns;
  schema->release = nullptr;
}

void write_schema(const std::vector<TableColumn>& columns, ArrowSchema& out) {
  constexpr std::int64_t kNullable = 2;
  auto all = std::make_unique<ArrowColumns>();
  for (const TableColumn& column : columns) {
    auto name = std::make_unique<std::string>(column.key);
    all->columns.push_back({.format = arrow_format(column.kind),
                            .name = name->c_str(),
                            .metadata = nullptr,
                            .flags = kNullable,
                            .n_children = 0,
                            .children = nullptr,
                            .dictionary = nullptr,
                            .release = release_name,
                            .private_data = nullptr});
    all->columns.back().private_data = name.release();
  }
  for (ArrowSchema& column : all->columns) all->pointers.push_back(&column);
  out = {.format = "+s",
         .name = "",
         .metadata = nullptr,
         .flags = 0,
         .n_children = static_cast<std::int64_t>(columns.size()),
         .children = all->pointers.data(),
         .dictionary = nullptr,
         .release = release_columns,
         .private_data = nullptr};
  out.private_data = all.release();
}

struct ArrowStreamState {
  std::vector<TableColumn> columns;
  NextBatch next;
  std::function<void(const Error&)> failed;
  std::string error;
  bool over = false;

  Status batch(ArrowArray& out) {
    std::memset(&out, 0, sizeof out);  // released: the end
    if (over) return {};
    auto rows = std::make_unique<ArrowRows>();
    std::vector<ArrowColumn> cells;
    for (const TableColumn& column : columns) cells.emplace_back(column.kind);
    if (Status s = next(cells); !s) return s;
    const std::size_t size = cells.empty() ? 0 : cells.front().size();
    over = size == 0;
    if (over) return {};
    rows->columns.resize(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) cells[i].move_to(rows->columns[i]);
    for (ArrowArray& column : rows->columns) rows->pointers.push_back(&column);
    out.length = static_cast<std::int64_t>(size);
    out.n_buffers = 1;
    out.buffers = &rows->no_buffer;
    out.n_children = static_cast<std::int64_t>(rows->columns.size());
    out.children = rows->pointers.data();
    out.release = release_rows;
    out.private_data = rows.release();
    return {};
  }
};

int stream_schema(ArrowArrayStream* stream, ArrowSchema* out) {
  write_schema(static_cast<ArrowStreamState*>(stream->private_data)->columns, *out);
  return 0;
}

int stream_next(ArrowArrayStream* stream, ArrowArray* out) {
  auto& state = *static_cast<ArrowStreamState*>(stream->private_data);
  try {
    Status given = state.batch(*out);
    if (given) return 0;
    state.error = given.error().text();
    if (state.failed) state.failed(given.error());
    return given.error().kind == ErrorKind::kInput ? EINVAL : EIO;
  } catch (const std::bad_alloc&) {
    state.error = "out of memory";
    return ENOMEM;
  }
}

const char* stream_error(ArrowArrayStream* stream) {
  return static_cast<ArrowStreamState*>(stream->private_data)->error.c_str();
}

void release_stream(ArrowArrayStream* stream) {
  delete static_cast<ArrowStreamState*>(stream->private_data);
  stream->release = nullptr;
}

}  // namespace

void ArrowColumn::mark(bool there) {
  if (size_ % 8 == 0) there_.push_back(0);
  if (there)
    there_.back() = static_cast<std::uint8_t>(there_.back() | 1U << size_ % 8);
  else
    ++empty_;
  ++size_;
  if (kind_ == TableColumn::Kind::kText) ends_.push_back(static_cast<std::int64_t>(values_.size()));
}

void ArrowColumn::put_empty() {
  if (kind_ != TableColumn::Kind::kText) values_.append(8, '\0');
  mark(false);
}

void ArrowColumn::put(std::int64_t whole) {
  values_.append(reinterpret_cast<const char*>(&whole), sizeof whole);
  mark(true);
}

void ArrowColumn::put(double real) {
  values_.append(reinterpret_cast<const char*>(&real), sizeof real);
  mark(true);
}

void ArrowColumn::put(std::string_view utf8) {
  values_ += utf8;
  mark(true);
}

void ArrowColumn::put(const TableCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell.value))
    put(std::string_view(is_ascii(*text) ? *text : parse_json(json_text(Json(*text))).get<std::string>()));
  else if (const auto* whole = std::get_if<std::int64_t>(&cell.value))
    put(*whole);
  else if (const auto* real = std::get_if<double>(&cell.value))
    put(*real);
  else
    put_empty();
}

void ArrowColumn::move_to(ArrowArray& out) {
  auto cells = std::make_unique<ArrowCells>();
  cells->values = std::exchange(values_, {});
  cells->ends = std::exchange(ends_, {0});
  cells->there = std::exchange(there_, {});
  const bool text = kind_ == TableColumn::Kind::kText;
  cells->buffers[0] = empty_ > 0 ? cells->there.data() : nullptr;
  cells->buffers[1] = text ? static_cast<const void*>(cells->ends.data()) : cells->values.data();
  cells->buffers[2] = cells->values.data();
  out = {.length = static_cast<std::int64_t>(std::exchange(size_, 0)),
         .null_count = static_cast<std::int64_t>(std::exchange(empty_, 0)),
         .offset = 0,
         .n_buffers = text ? 3 : 2,
         .n_children = 0,
         .buffers = cells->buffers,
         .children = nullptr,
         .dictionary = nullptr,
         .release = release_cells,
         .private_data = nullptr};
  out.private_data = cells.release();
}

void make_arrow_stream(ArrowArrayStream& out, std::vector<TableColumn> columns, NextBatch next,
                       std::function<void(const Error&)> failed) {
  out = {.get_schema = stream_schema,
         .get_next = stream_next,
         .get_last_error = stream_error,
         .release = release_stream,
         .private_data = new ArrowStreamState{std::move(columns), std::move(next), std::move(failed), {}, false}};
}

}  // namespace cxlab::lab
