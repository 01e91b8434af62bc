#include "scenarios/question.h"

#include <algorithm>
#include <cmath>

#include "cx/base/number_text.h"

namespace cxlab {

std::string time_text(double seconds) {
  const long long tenths = std::llround(std::max(0.0, seconds) * 10);
  const long long rest = tenths % 600;
  return std::to_string(tenths / 600) + ':' + (rest < 100 ? "0" : "") + std::to_string(rest / 10) + '.' +
         std::to_string(rest % 10);
}

std::string length_text(double seconds) { return fixed_text(seconds, 1) + " s"; }

void drop_column(Table& table, std::string_view key) {
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    if (table.columns[i].key != key) continue;
    const auto at = static_cast<std::ptrdiff_t>(i);
    table.columns.erase(table.columns.begin() + at);
    for (auto& row : table.rows) row.erase(row.begin() + at);
    return;
  }
}

}  // namespace cxlab
