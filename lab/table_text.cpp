#include "lab/table_text.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "cx/base/number_text.h"

namespace cxlab::lab {

using CellKind = Column::Kind;

std::string count_text(std::size_t n, const std::string& noun) {
  return std::to_string(n) + ' ' + noun + (n == 1 ? "" : "s");
}

std::string shown_text(const TableCell& cell, CellKind kind) {
  if (!cell.shown.empty()) return cell.shown;
  const auto number = [kind](double value) {
    switch (kind) {
      case CellKind::kTime:
      case CellKind::kStretch: return time_text(value);
      case CellKind::kSeconds: return length_text(value);
      case CellKind::kShare: return fixed_text(100 * value, 1) + " %";
      default: return shortest_text(value);
    }
  };
  if (const auto* text = std::get_if<std::string>(&cell.value)) return *text;
  if (const auto* whole = std::get_if<std::int64_t>(&cell.value)) return std::to_string(*whole);
  if (const auto* value = std::get_if<double>(&cell.value)) return number(*value);
  if (const auto* stretch = std::get_if<TableCell::Stretch>(&cell.value))
    return number(stretch->first) + '-' + number(stretch->second);
  return "-";
}

namespace {

Json json_of(const TableCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell.value)) return *text;
  if (const auto* whole = std::get_if<std::int64_t>(&cell.value)) return *whole;
  if (const auto* value = std::get_if<double>(&cell.value)) return *value;
  if (const auto* stretch = std::get_if<TableCell::Stretch>(&cell.value)) return {stretch->first, stretch->second};
  return nullptr;
}

/// How many columns a text takes on a terminal, of characters that take one each.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

/// Lines of at most so many characters, broken at blanks.
std::vector<std::string> broken_at(const std::string& text, std::size_t width) {
  std::vector<std::string> out;
  std::string line;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = std::min(text.find(' ', i), text.size());
    const std::string word = text.substr(i, end - i);
    if (!line.empty() && width_of(line) + 1 + width_of(word) > width) out.push_back(std::exchange(line, {}));
    line += (line.empty() ? "" : " ") + word;
    i = end + 1;
  }
  out.push_back(line);
  return out;
}

constexpr std::size_t kBetween = 2;  ///< blanks between columns

/// The width of each column: that of its longest text. The last column gets the rest of the line. If the rest is
/// shorter than a sentence, other texts are broken.
std::vector<std::size_t> widths_of(const Table& table, std::size_t room) {
  constexpr std::size_t kSentence = 72, kNarrowest = 36, kNarrowCell = 16;
  const std::size_t columns = table.columns.size();
  std::vector<std::size_t> widths, least;
  for (const Column& column : table.columns) {
    widths.push_back(width_of(column.title));
    least.push_back(std::max(width_of(column.title), kNarrowCell));
  }
  for (const auto& row : table.rows)
    for (std::size_t i = 0; i < columns; ++i) {
      const std::string text = shown_text(row[i], table.columns[i].kind);
      widths[i] = std::max(widths[i], width_of(text));
      for (const std::string& word : broken_at(text, 0)) least[i] = std::max(least[i], width_of(word));
    }
  if (table.columns.back().kind != CellKind::kText) return widths;
  const std::size_t wanted = std::min(widths.back(), kSentence);
  std::size_t before_last = 0;
  for (std::size_t i = 0; i + 1 < columns; ++i) before_last += widths[i] + kBetween;
  while (before_last + wanted > room) {
    std::size_t widest = columns;
    for (std::size_t i = 0; i + 1 < columns; ++i)
      if (table.columns[i].kind == CellKind::kText && widths[i] > least[i] &&
          (widest == columns || widths[i] > widths[widest]))
        widest = i;
    if (widest == columns) break;
    --widths[widest];
    --before_last;
  }
  widths.back() = before_last + kNarrowest < room ? room - before_last : kNarrowest;
  return widths;
}

}  // namespace

std::string table_text(const Table& table, std::size_t width) {
  const std::size_t columns = table.columns.size();
  const std::vector<std::size_t> widths = widths_of(table, width);
  std::string out;
  const auto add_row = [&](const auto& text_at) {
    std::vector<std::vector<std::string>> cells;
    std::size_t height = 1;
    for (std::size_t i = 0; i < columns; ++i) {
      cells.push_back(table.columns[i].kind == CellKind::kText ? broken_at(text_at(i), widths[i])
                                                               : std::vector<std::string>{text_at(i)});
      height = std::max(height, cells.back().size());
    }
    for (std::size_t k = 0; k < height; ++k) {
      for (std::size_t i = 0; i < columns; ++i) {
        const std::string text = k < cells[i].size() ? cells[i][k] : std::string();
        const std::string fill(widths[i] - std::min(widths[i], width_of(text)), ' ');
        out += table.columns[i].kind == CellKind::kText ? text + fill : fill + text;
        out += std::string(kBetween, ' ');
      }
      out.erase(out.find_last_not_of(' ') + 1);
      out += '\n';
    }
  };
  if (!table.title.empty()) out += table.title + ":\n";
  add_row([&](std::size_t i) { return table.columns[i].title; });
  for (const auto& row : table.rows) add_row([&](std::size_t i) { return shown_text(row[i], table.columns[i].kind); });
  if (table.rows.empty()) out += "none\n";
  return out;
}

Json table_json(const Table& table) {
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json one = Json::object();
    for (std::size_t i = 0; i < table.columns.size(); ++i) one[table.columns[i].key] = json_of(row[i]);
    rows.push_back(std::move(one));
  }
  return rows;
}

namespace {

std::string replaced(const std::string& text, const std::function<std::string(char)>& by) {
  std::string out;
  for (const char c : text) out += by(c);
  return out;
}

std::string markdown_text(const std::string& text) {
  return replaced(text, [](char c) {
    return c == '|' || c == '\\'    ? std::string("\\") + c
           : c == '\n' || c == '\r' ? std::string(" ")
                                    : std::string(1, c);
  });
}

std::string latex_text(const std::string& text) {
  return replaced(text, [](char c) -> std::string {
    switch (c) {
      case '&':
      case '%':
      case '$':
      case '#':
      case '_':
      case '{':
      case '}': return std::string("\\") + c;
      case '~': return "\\textasciitilde{}";
      case '^': return "\\textasciicircum{}";
      case '\\': return "\\textbackslash{}";
      case '<':
      case '>': return std::string("$") + c + '$';
      case '\n':
      case '\r': return " ";
      default: return std::string(1, c);
    }
  });
}

/// A number with signs of its own instead of hyphens.
std::string latex_number(const std::string& text) {
  std::string out;
  for (const char c : latex_text(text)) out += c == '-' ? std::string("$-$") : std::string(1, c);
  return text == "-" ? "--" : out;
}

}  // namespace

std::string csv_text(const TableCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell.value)) return csv_text(*text);
  if (const auto* whole = std::get_if<std::int64_t>(&cell.value)) return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&cell.value)) return shortest_text(*number);
  if (const auto* stretch = std::get_if<TableCell::Stretch>(&cell.value))
    return shortest_text(stretch->first) + ',' + shortest_text(stretch->second);
  return {};
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

std::string table_markdown(const Table& table) {
  std::string out = table.title.empty() ? "" : markdown_text(table.title) + ":\n\n", rule = "|";
  const auto add_row = [&](const auto& text_at) {
    out += '|';
    for (std::size_t i = 0; i < table.columns.size(); ++i) out += ' ' + markdown_text(text_at(i)) + " |";
    out += '\n';
  };
  add_row([&](std::size_t i) { return table.columns[i].title; });
  for (const Column& column : table.columns) rule += column.kind == CellKind::kText ? "---|" : "---:|";
  out += rule + '\n';
  for (const auto& row : table.rows) add_row([&](std::size_t i) { return shown_text(row[i], table.columns[i].kind); });
  return out;
}

std::string table_csv(const Table& table) {
  const auto is_interval = [&table](std::size_t i) { return table.columns[i].key.ends_with("_95"); };
  std::string out;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string& key = table.columns[i].key;
    out +=
        (i > 0 ? "," : "") + (is_interval(i) ? csv_text(key + "_low") + ',' + csv_text(key + "_high") : csv_text(key));
  }
  out += '\n';
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) out += ',';
      out += csv_text(row[i]);
      if (is_interval(i) && row[i].empty()) out += ',';
    }
    out += '\n';
  }
  return out;
}

std::string table_latex(const Table& table) {
  std::string columns;
  for (const Column& column : table.columns) columns += column.kind == CellKind::kText ? 'l' : 'r';
  std::string out = table.title.empty() ? "" : "% " + replaced(table.title, [](char c) {
                                                 return std::string(1, c == '\n' ? ' ' : c);
                                               }) + '\n';
  out += "\\begin{tabular}{" + columns + "}\n\\hline\n";
  const auto add_row = [&](const auto& text_at) {
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      const std::string text = text_at(i);
      // LaTeX reads a [ or * after the \\ of the row before as an option of it.
      out += i > 0 ? " & " : text.starts_with('[') || text.starts_with('*') ? "{}" : "";
      out += text;
    }
    out += " \\\\\n";
  };
  add_row([&](std::size_t i) { return latex_text(table.columns[i].title); });
  out += "\\hline\n";
  for (const auto& row : table.rows)
    add_row([&](std::size_t i) {
      const std::string text = shown_text(row[i], table.columns[i].kind);
      return table.columns[i].kind == CellKind::kText ? latex_text(text) : latex_number(text);
    });
  return out + "\\hline\n\\end{tabular}\n";
}

Status sort_table(Table& table, const std::string& key) {
  std::vector<std::string> keys;
  for (const Column& column : table.columns) keys.push_back(column.key);
  const auto found = std::ranges::find(keys, key);
  if (found == keys.end())
    return usage_error("--sort: there is no column '" + key + "'; there are " + some_of_and_nearest(key, keys));
  const auto at = static_cast<std::size_t>(found - keys.begin());
  const bool text = table.columns[at].kind == CellKind::kText;
  std::ranges::stable_sort(table.rows, [&](const auto& a, const auto& b) {
    return text ? a[at].value < b[at].value : b[at].value < a[at].value;
  });
  return {};
}

}  // namespace cxlab::lab
