#pragma once
// One episode of a sweep: what it was played from and how it went. Kept as a file, so that it is not played again.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "lab/file_names.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

/// The value of a metric; none where the result has nothing to compute it from.
struct Figure {
  std::string metric;
  std::optional<double> value;
};

struct Row {
  Cell cell;
  // What it was played from
  std::string program;                       ///< digest of cxlab itself
  std::map<std::string, std::string> files;  ///< that the run read: name (FileNames) -> content hash
  // How it went
  std::string status;  ///< as in result.json; "crashed" if the process ended without a result
  int exit_code = 0;
  std::vector<std::string> errors;
  std::string world;            ///< kind of the world; empty: the scenario could not be read, or the process crashed
  std::string compared;         ///< the metric that `bench` compares; empty: the world declares none
  std::vector<Figure> figures;  ///< of the metrics of the world, in their order
  std::string journal_hash;

  /// Whether its figures count: the game was played to its end.
  bool counts() const { return status == "completed" && exit_code == 0; }
  std::optional<double> figure(std::string_view metric) const;
  /// Sets world, the compared metric and the figures.
  void measure(const WorldKind& kind, const std::string& result_json);
  /// Whether the same would be played now: by this program, with the same overrides and the same content of all files,
  /// wherever they lie.
  bool is_current(const Cell& now, const std::string& program_now, const FileNames& names) const;

  std::string to_json() const;
  static Expected<Row> parse(const std::string& text);
};

/// The key of a row's JSON: no metric may have its name.
bool is_key_of_row(std::string_view name);
/// The hash of a file's content now; empty if it cannot be read.
std::string hash_of(const std::filesystem::path& file);
/// The name of a row's file without extension: readable, and different for different cells of a suite.
std::string row_name(const Cell& cell);
/// All rows as comma-separated values (RFC 4180). Each metric of any row has a column.
std::string to_csv(const std::vector<Row>& rows);

}  // namespace cxlab::lab
