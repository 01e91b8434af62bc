#pragma once
// Tables (scenarios/question.h) as text for people, and as JSON.

#include <string>
#include "cx/base/json.h"

#include "cx/base/expected.h"
#include "scenarios/question.h"

namespace cxlab::app {

/// Lines, as wide as the terminal; "none" where there are no rows.
std::string table_text(const Table& table);
/// A list with an object for each row.
Json table_json(const Table& table);
/// Orders the rows by the column of that key: numbers from the greatest, texts from the first letter.
Status sort_table(Table& table, const std::string& key);

}  // namespace cxlab::app
