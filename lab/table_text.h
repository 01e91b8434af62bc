#pragma once
// Tables (scenarios/question.h) as text for people, JSON, Markdown, CSV and LaTeX.

#include <cstddef>
#include <string>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "scenarios/question.h"

namespace cxlab::lab {

/// Columns of a line where no terminal says how many it has.
inline constexpr std::size_t kTableWidth = 180;

/// "1 game", "12 games"
std::string count_text(std::size_t n, const std::string& noun);
/// What people read in a cell of a column of that kind.
std::string shown_text(const TableCell& cell, Column::Kind kind);
/// Lines of at most that width; "none" where there are no rows.
std::string table_text(const Table& table, std::size_t width = kTableWidth);
/// A list with an object for each row.
Json table_json(const Table& table);
/// As people read it in Markdown: a title, and a table whose numbers are on the right.
std::string table_markdown(const Table& table);
/// Comma-separated values (RFC 4180) with the keys as header and numbers in full. An interval, whose key ends in `_95`,
/// has two columns, KEY_low and KEY_high, also where no row has one.
std::string table_csv(const Table& table);
/// A field of a CSV (RFC 4180): in quotes where it has to be.
std::string csv_text(const std::string& text);
/// The fields of a cell: two of an interval.
std::string csv_text(const TableCell& cell);
/// An environment `tabular`, which needs no package.
std::string table_latex(const Table& table);
/// Orders the rows by the column of that key: numbers from the greatest, texts from the first letter.
Status sort_table(Table& table, const std::string& key);

}  // namespace cxlab::lab
