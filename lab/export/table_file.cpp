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

PlainTable plain_table(const Table& table) {
  PlainTable out;
  out.rows.resize(table.rows.size());
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const auto any = [&]<class T>(const T*) {
      return std::ranges::any_of(table.rows, [&](const auto& row) { return std::holds_alternative<T>(row[i].value); });
    };
    const bool stretch = any(static_cast<const TableCell::Stretch*>(nullptr)),
               text = any(static_cast<const std::string*>(nullptr));
    const bool real = stretch || any(static_cast<const double*>(nullptr)),
               whole = any(static_cast<const std::int64_t*>(nullptr));
    using Kind = TableColumn::Kind;
    // A column that is empty in all rows has the kind that its world gives it.
    const bool number = whole || (!text && !real && table.columns[i].kind == Column::Kind::kNumber);
    const Kind kind = text                                                                ? Kind::kText
                      : real || (!number && table.columns[i].kind != Column::Kind::kText) ? Kind::kReal
                      : number                                                            ? Kind::kWhole
                                                                                          : Kind::kText;
    const auto to_kind = [&](const TableCell& cell) -> TableCell {
      const auto* as_whole = std::get_if<std::int64_t>(&cell.value);
      const auto* as_real = std::get_if<double>(&cell.value);
      if (kind == Kind::kReal && as_whole) return static_cast<double>(*as_whole);
      if (kind == Kind::kText && as_whole) return std::to_string(*as_whole);
      if (kind == Kind::kText && as_real) return shortest_text(*as_real);
      return cell;
    };
    const std::string& key = table.columns[i].key;
    if (stretch && !text) {
      out.columns.push_back({key + "_begin", kind});
      out.columns.push_back({key + "_end", kind});
    } else {
      out.columns.push_back({key, kind});
    }
    for (std::size_t k = 0; k < table.rows.size(); ++k) {
      const TableCell& cell = table.rows[k][i];
      const auto* both = std::get_if<TableCell::Stretch>(&cell.value);
      if (!stretch || text) {
        out.rows[k].push_back(both ? TableCell(shortest_text(both->first) + '-' + shortest_text(both->second))
                                   : to_kind(cell));
      } else {
        out.rows[k].push_back(both ? TableCell(both->first) : to_kind(cell));
        out.rows[k].push_back(both ? TableCell(both->second) : TableCell());
      }
    }
  }
  return out;
}

}  // namespace cxlab::lab
