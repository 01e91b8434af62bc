#pragma once
// What an episode ends with: `result.json` (docs/reference/contracts.md 4).

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "scenarios/scenario.h"

namespace cxlab {

enum class RunStatus : std::uint8_t { kCompleted, kStopped, kFailed, kInterrupted };

struct RuleErrorResult {
  std::string rule, file, side, message;
  int line = 0;
  std::int64_t tick = 0;
};

struct Result {
  /// A part of result.json that a world or a node adds: a key and its value as JSON.
  struct Section {
    std::string key, json;
  };

  std::string scenario;
  std::uint64_t seed = 0;
  std::string tier = "none";  ///< Scenario::tier_name
  RunStatus status = RunStatus::kFailed;
  std::optional<Error> reason;
  bool deterministic = true;
  SimTime sim_time{};
  double wall_time_s = 0, physics_wall_s = 0, real_time_factor = 0, peak_rss_mb = 0;  ///< measured by the caller
  std::int64_t ticks = 0, steps = 0, plans = 0, replans = 0;
  std::vector<Section> sections;  ///< that world and nodes declare (catalogue.h), and what else they set
  std::string only;               ///< the one section that is asked for; empty: the whole result
  std::string score_board;        ///< lines for a terminal; a world adds its own
  std::vector<RuleErrorResult> rule_errors;
  std::vector<std::string> warnings;  ///< given parameters that nothing read, and errors that rules printed
  /// Warnings that count what happened in this game ("skills failed: robot1 2 of 7"). Their text differs from game to
  /// game, so sweeps leave them to the metrics.
  std::vector<std::string> tallies;
  std::string journal_hash, physics_hash;
  std::vector<std::pair<std::string, std::string>> stream_hashes;  ///< name -> hash, by name

  /// Whether that section is asked for: a world need not make the others.
  bool wants(std::string_view key) const { return only.empty() || only == key; }
  /// Fills the section of that key, or adds it after the others. Text that is no JSON becomes a string.
  void set(const std::string& key, std::string json);
  std::string to_json() const;  ///< pretty-printed, UTF-8
  /// What a person sees as warnings: `warnings`, then `tallies`.
  std::vector<std::string> all_warnings() const;
  /// What result.json has at that path, as JSON ("teams.CYAN.points"); empty if there is nothing.
  std::string at(const std::string& path) const;
};

/// "teams" of "teams.CYAN.points".
std::string section_of_path(const std::string& path);
/// "completed", "stopped", ...
const char* to_string(RunStatus status);
/// What a result has before anything is played: the scenario's name, seed and tier, and the sections of its world and
/// nodes with their initial values.
Result initial_result(const Scenario& scenario);
/// The result of a run that has only begun: status failed, reason unfinished.
Result unfinished_result(const Scenario& scenario);
/// A result with one of everything that it can have.
Result sample_result(const Scenario& scenario);
/// Whether the scenario's result can have something at that path ("teams.CYAN.points", "orders[0].points"); else what
/// is wrong.
Status check_result_path(const std::string& path, const Scenario& scenario);
/// The first expectation that does not hold, as an error of kind kNo.
Status check_expectations(const std::vector<Expectation>& expectations, const std::string& result_json);

}  // namespace cxlab
