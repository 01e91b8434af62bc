#pragma once
// The folder of a sweep, and which of its rows count:
//
//   rows/*.json   one an episode: the truth, from which all else is made
//   rows/*.log    what the episode's process printed, if it did
//   rows.csv      all of them
//   runs.sqlite   the same as a database (index.h)
//   suite.txt     the path of the suite whose tables these are

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/servant.h"
#include "lab/host.h"
#include "lab/sweep/row.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

/// Whether rows count for cells of a suite: what it has read once of scenarios and files it reads no more.
class RowMatcher {
 public:
  RowMatcher(const Catalogue& catalogue, std::string program, const Limits& limits)
      : catalogue_(catalogue), program_(std::move(program)), allowance_(limits) {}

  bool is_current(const Row& row, const Cell& cell);
  bool tells_of(const Row& row, const Cell& cell);
  /// How the files of a cell are called.
  const FileNames& names_of(const Cell& cell) { return place_of(cell).names; }
  /// Checked out where its agent lies; empty: no git repository.
  const std::string& agent_commit_of(const Cell& cell) { return place_of(cell).agent_commit; }
  const std::string& program() const { return program_; }
  /// What rules may take now.
  const Allowance& allowance() const { return allowance_; }
  std::string hash(const std::filesystem::path& file);
  /// A file that has another content than when the row was played, by its name; empty: all are the same.
  std::string changed_file(const Row& row, const Cell& cell);

 private:
  struct Place {
    FileNames names;
    std::string agent_commit;
  };
  const Place& place_of(const Cell& cell);

  const Catalogue& catalogue_;
  std::string program_;
  Allowance allowance_;
  std::map<std::pair<std::string, std::string>, Place> places_;  // by scenario and strategy
  std::map<std::filesystem::path, std::string> hashes_;
};

/// Names the suite whose tables are in the folder, by its path.
inline constexpr const char* kSuiteFile = "suite.txt";

/// The name of this machine.
std::string host_name();

/// Who works in the folder: a sweep alone, or any number of those that play single cells and collect.
enum class FolderUse { kAlone, kTogether };

class RowFolder {
 public:
  /// Makes the folder. kResource if it cannot be written, or is used in another way.
  static Expected<RowFolder> open(const std::filesystem::path& folder, FolderUse use);

  std::filesystem::path file_of(const Cell& cell) const { return rows_ / (row_name(cell) + ".json"); }
  std::filesystem::path log_of(const Cell& cell) const { return rows_ / (row_name(cell) + ".log"); }
  /// Where a process writes a row that then becomes `file`; no other process has the same one.
  std::filesystem::path unfinished(const std::filesystem::path& file) const;

  /// The row of this cell, if it is there and current; also one under another name, which then gets this one.
  std::optional<Row> find(const Cell& cell, RowMatcher& matcher);
  /// Replaces the row of its cell.
  Status write(const Row& row) const;
  /// Takes away what processes have left that were killed; for those who are alone.
  void remove_unfinished() const;
  /// Writes rows.csv, runs.sqlite and suite.txt.
  Status write_tables(const std::vector<Row>& rows, const Suite& suite) const;
  /// Rows of the tables that new tables would lose: they are not of these cells. A row that only gets another name is
  /// not lost: one of `rows` has its Row::key and a name that is new.
  std::vector<Row> lost_rows(const std::vector<Cell>& cells, const std::vector<Row>& rows, const Suite& suite) const;
  /// Fails if new tables of `suite` would lose these rows and another suite, which is still there, wrote them; else a
  /// note tells the host.
  Status take_tables_over(const std::vector<Row>& lost, const Suite& suite, const Host& host) const;

 private:
  RowFolder(std::filesystem::path folder, Descriptor lock);
  using Known = std::multimap<std::string, std::filesystem::path>;  // by identity

  std::filesystem::path folder_, rows_;
  Descriptor lock_;
  std::unique_ptr<Known> known_;  // read when it is first needed
};

/// What identifies a game without the content of its files: game, seed and overrides.
std::string identity_of(const Cell& cell);
/// The row of a file; none if it is no row.
std::optional<Row> read_row(const std::filesystem::path& file);
/// The files of rows in a folder of a sweep, in order of names.
std::vector<std::filesystem::path> row_files(const std::filesystem::path& folder);

}  // namespace cxlab::lab
