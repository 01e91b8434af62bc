#pragma once
// runs.sqlite: the rows of a sweep as an SQLite database, for pandas, DuckDB and Datasette. The schema is documented in
// docs/reference/sweeps.md. Each time it is rebuilt from the rows and replaced as a whole. So no SQLite journal ever
// lies beside it, which a reader without the right to write could not roll back after a kill.

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

/// A row of the index, and the command that plays its game again on the machine that wrote the index.
struct IndexedRow {
  Row row;              ///< without overrides and files
  std::string command;  ///< of a shell
  std::string file;     ///< its name in the folder of the sweep: "rows/game-fast-1-0a1b2c3d.json"
};
/// The rows by cell. kInput if the file is no index of this version.
Expected<std::vector<IndexedRow>> read_index(const std::filesystem::path& file);

}  // namespace cxlab::lab
