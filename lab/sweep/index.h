#pragma once
// runs.sqlite: the rows of a sweep as an SQLite database, for pandas, DuckDB and Datasette. The schema is documented in
// docs/bench.md. It is made from the rows anew each time, and replaced whole.

#include <filesystem>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/row.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

/// The version of the schema, `PRAGMA user_version`.
inline constexpr int kIndexSchema = 1;

/// Rows whose cells are those of the suite. kResource if it cannot be written; the old file then stays.
Status write_index(const std::vector<Row>& rows, const Suite& suite, const std::filesystem::path& file);

}  // namespace cxlab::lab
