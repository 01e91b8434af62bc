#pragma once
// One episode of a sweep: what it was played from and how it went. Kept as a file, so that it is not played again.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

/// What of a result is compared.
struct Figures {
  double points = 0;      ///< of all teams
  double deliveries = 0;  ///< correct ones
  double busy = 0;        ///< share of time that robots are at work
  double real_time_factor = 0;
};

struct Row {
  Cell cell;
  // What it was played from
  std::string program;                       ///< digest of cxlab itself
  std::map<std::string, std::string> files;  ///< that the run read: path -> content hash
  // How it went
  std::string status;  ///< as in result.json; "crashed" if the process ended without a result
  int exit_code = 0;
  std::vector<std::string> errors;
  Figures figures;
  std::string journal_hash;

  /// Whether its figures count: the game was played to its end.
  bool counts() const { return status == "completed" && exit_code == 0; }
  /// Whether the same would be played now: by this program, with the same overrides and files.
  bool is_current(const Cell& now, const std::string& program_now) const;

  std::string to_json() const;
  static Expected<Row> parse(const std::string& text);
};

/// The hash of a file's content now; empty if it cannot be read.
std::string hash_of(const std::filesystem::path& file);
/// The figures of a result.json.
Figures figures_of(const std::string& result_json);
/// The name of a row's file without extension: readable, and different for different cells.
std::string row_name(const Cell& cell);
/// All rows as comma-separated values (RFC 4180).
std::string to_csv(const std::vector<Row>& rows);

}  // namespace cxlab::lab
