#pragma once
// One episode of a sweep: what it was played from and how it went. Kept as a file, so that it is not played again.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/limits.h"
#include "lab/file_names.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

/// This name, kept until the process ends: a sweep has few names of metrics, and each of its rows names all of them.
std::string_view shared_name(std::string_view metric);

/// The value of a metric; none where the result has nothing to compute it from.
struct Figure {
  std::string_view metric;  ///< `shared_name` of it: rows by the thousand keep one text
  std::optional<double> value;
  bool of_machine = false;  ///< as of its Metric
};

/// Figures that differ each time the same game is played. No comparison reads them.
struct Circumstances {
  double cpu_s = 0;  ///< of its process
  double peak_rss_mb = 0;
  std::string host;
  std::string agent_commit;  ///< checked out in the git repository of the agent; empty: there is none
};

/// What the rules of a game may take, as in `Limits`; 0 = no limit.
struct Allowance {
  std::int64_t memory = Limits{}.memory, disk = Limits{}.disk, steps = Limits{}.steps;

  Allowance() = default;
  explicit Allowance(const Limits& limits) : memory(limits.memory), disk(limits.disk), steps(limits.steps) {}
  bool operator==(const Allowance&) const = default;
  /// Whether it allows at least as much of everything.
  bool covers(const Allowance& other) const;
  /// As options of a command: " --steps 2000". Empty where all is as without options.
  std::string options() const;
};

struct Row {
  Cell cell;
  // What it was played from
  std::string program;                       ///< digest of cxlab itself
  std::string file;                          ///< the scenario by its name (FileNames)
  std::map<std::string, std::string> files;  ///< that the run read: name (FileNames) -> content hash
  Allowance allowance{};
  std::string key;  ///< digest of all that (`digest`)
  // How it went
  std::string status;  ///< as in result.json; "crashed" if the process ended without a result
  int exit_code = 0;
  std::vector<std::string> errors;  ///< why it was not completed
  std::vector<std::string> warnings;
  std::string world;            ///< kind of the world; empty: the scenario could not be read
  std::string compared;         ///< the metric that `bench` compares; empty: the world declares none
  std::vector<Figure> figures;  ///< of the metrics of the world, in their order
  std::string journal_hash;
  Circumstances circumstances{};

  /// Whether its figures count: the game was played to its end.
  bool counts() const { return status == "completed" && exit_code == 0; }
  std::optional<double> figure(std::string_view metric) const;
  /// Sets world, the compared metric and the figures.
  void measure(const WorldKind& kind, const std::string& result_json);
  /// The command that plays the game again.
  std::string command() const { return command_of(cell) + allowance.options(); }
  /// The digest of program, overrides, files and allowance. Rows with the same one are of the same game, wherever the
  /// files lie and whatever suite and strategy are called.
  std::string digest() const;

  using Hash = std::function<std::string(const std::filesystem::path&)>;
  /// Whether the game would go the same way now. Program and overrides are the same, all files have the same content,
  /// wherever they lie, and the rules may take as much as then; exactly as much if the game was not completed.
  bool is_current(const Cell& now, const std::string& program_now, const FileNames& names, const Hash& hash = {},
                  const Allowance& allowed = {}) const;
  /// The same of a game that was begun, and perhaps not played to its end: it crashed, or could not read a file.
  bool tells_of(const Cell& now, const std::string& program_now, const FileNames& names, const Hash& hash = {}) const;

  /// The same bytes wherever and whenever the game is played, but for the value of the last key, `played`.
  std::string to_json() const;
  /// Its cell has neither the folders of its files nor tags and number: these are of the suite.
  static Expected<Row> parse(const std::string& text);
};

/// The key of a row's JSON, or a column of the index: no metric may have its name, in capital letters or not.
bool is_key_of_row(std::string_view name);
/// The hash of a file's content now; empty if it cannot be read.
std::string hash_of(const std::filesystem::path& file);
/// The name of a row's file without extension: readable, and different for different cells of a suite.
std::string row_name(const Cell& cell);
/// All rows as comma-separated values (RFC 4180). Each metric of any row has a column, but for those of the machine:
/// the same games give the same bytes.
std::string to_csv(const std::vector<Row>& rows);

}  // namespace cxlab::lab
