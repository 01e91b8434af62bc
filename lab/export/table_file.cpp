#include "lab/export/table_file.h"

#include <algorithm>

#include "cx/base/append_file.h"
#include "cx/base/number_text.h"
#include "lab/table_text.h"

namespace cxlab::lab {

namespace {

class CsvFile final : public TableFile {
 public:
  CsvFile(AppendFile file, const std::vector<TableColumn>& columns) : file_(std::move(file)) {
    for (const TableColumn& column : columns) {
      if (&column != &columns.front()) line_ += ',';
      line_ += csv_text(column.key);
    }
    end_line();
  }
  Status close() override { return file_.close(); }

 private:
  Status put(std::span<const TableCell> cells) override {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i > 0) line_ += ',';
      line_ += csv_text(cells[i]);
    }
    end_line();
    return file_.status();
  }
  void end_line() {
    line_ += '\n';
    static_cast<void>(file_.append(line_));  // its error stays
    line_.clear();
  }

  AppendFile file_;
  std::string line_;
};

}  // namespace

Expected<std::unique_ptr<TableFile>> create_csv(const std::filesystem::path& path, std::vector<TableColumn> columns) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<TableFile>(new CsvFile(*std::move(file), columns));
}

namespace {

bool fits(const TableCell& cell, Column::Kind kind) {
  if (cell.empty() || kind == Column::Kind::kText) return true;
  const bool is_stretch = std::holds_alternative<TableCell::Stretch>(cell.value);
  return is_stretch == (kind == Column::Kind::kStretch) && !std::holds_alternative<std::string>(cell.value);
}

/// The kind of a column of the file: that of its world, so that it does not depend on the rows.
TableColumn::Kind kind_of(const Table& table, std::size_t column) {
  using Kind = TableColumn::Kind;
  const auto any = [&](auto holds) {
    return std::ranges::any_of(table.rows, [&](const auto& row) { return holds(row[column]); });
  };
  const Column::Kind kind = table.columns[column].kind;
  if (kind == Column::Kind::kText || any([kind](const TableCell& cell) { return !fits(cell, kind); }))
    return Kind::kText;
  if (kind != Column::Kind::kNumber) return Kind::kReal;
  return any([](const TableCell& cell) { return std::holds_alternative<double>(cell.value); }) ? Kind::kReal
                                                                                               : Kind::kWhole;
}

TableCell to_kind(const TableCell& cell, TableColumn::Kind kind) {
  using Kind = TableColumn::Kind;
  const auto* whole = std::get_if<std::int64_t>(&cell.value);
  if (kind == Kind::kReal && whole) return static_cast<double>(*whole);
  if (kind != Kind::kText) return cell;
  if (whole) return std::to_string(*whole);
  if (const auto* real = std::get_if<double>(&cell.value)) return shortest_text(*real);
  if (const auto* both = std::get_if<TableCell::Stretch>(&cell.value))
    return shortest_text(both->first) + '-' + shortest_text(both->second);
  return cell;
}

}  // namespace

PlainTable plain_table(const Table& table) {
  PlainTable out;
  out.rows.resize(table.rows.size());
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string& key = table.columns[i].key;
    const TableColumn::Kind kind = kind_of(table, i);
    const bool is_stretch = table.columns[i].kind == Column::Kind::kStretch && kind != TableColumn::Kind::kText;
    if (is_stretch) out.columns.push_back({key + "_begin", kind});
    out.columns.push_back({is_stretch ? key + "_end" : key, kind});
    for (std::size_t k = 0; k < table.rows.size(); ++k) {
      const TableCell& cell = table.rows[k][i];
      const auto* both = is_stretch ? std::get_if<TableCell::Stretch>(&cell.value) : nullptr;
      if (is_stretch) out.rows[k].push_back(both ? TableCell(both->first) : TableCell());
      out.rows[k].push_back(both ? TableCell(both->second) : to_kind(cell, kind));
    }
  }
  return out;
}

}  // namespace cxlab::lab
