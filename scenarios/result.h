#pragma once
// What an episode ends with: `result.json` (docs/contracts.md 4).

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "scenarios/scenario.h"

namespace cxlab {

enum class RunStatus : std::uint8_t { kCompleted, kStopped, kFailed, kInterrupted };

/// Points of one team, by kind; the kinds sum to the points.
struct TeamResult {
  std::string team;
  std::int64_t points = 0;
  std::vector<std::pair<std::string, std::int64_t>> by_kind;
};
struct OrderResult {
  int id = 0;
  std::string complexity;
  double ordered = 0;                  ///< s, when it became active
  std::optional<double> delivered_at;  ///< s
  bool correct = false;
  std::int64_t points = 0;
};
struct DeliveryResult {
  int order = 0;
  std::string team;
  double time = 0;  ///< s
  bool correct = false;
  double late_s = 0;
  std::int64_t points = 0;
};
struct RobotResult {
  std::string name;
  double busy_s = 0, drive_s = 0, wait_s = 0;
  int skills = 0, failures = 0, contacts = 0;
};
struct TurtleResult {
  std::string name;
  bool alive = true;
  double x = 0, y = 0, theta = 0;  ///< m, m, rad: last seen
  double driven_m = 0;             ///< without jumps
  int walls = 0, touches = 0, teleports = 0;
};
struct RuleErrorResult {
  std::string rule, file, side, message;
  int line = 0;
  std::int64_t tick = 0;
};

struct Result {
  std::string scenario;
  std::uint64_t seed = 0;
  Tier tier{};
  bool has_world = true;  ///< an empty one has no tier
  RunStatus status = RunStatus::kFailed;
  std::optional<Error> reason;
  bool deterministic = true;
  SimTime sim_time{};
  double wall_time_s = 0, physics_wall_s = 0, real_time_factor = 0, peak_rss_mb = 0;  ///< measured by the caller
  std::int64_t ticks = 0, steps = 0, plans = 0, replans = 0;
  std::vector<TeamResult> teams;
  std::vector<OrderResult> orders;
  std::vector<DeliveryResult> deliveries;
  std::vector<RobotResult> robots;
  std::vector<TurtleResult> turtles;
  std::vector<RuleErrorResult> rule_errors;
  std::string journal_hash, physics_hash;
  std::vector<std::pair<std::string, std::string>> stream_hashes;  ///< name -> hash, by name

  std::string to_json() const;  ///< pretty-printed, UTF-8
};

/// "completed", "stopped", ...
const char* to_string(RunStatus status);
/// The result of a run that has only begun: status failed, reason unfinished.
Result unfinished_result(const Scenario& scenario);
/// Whether result.json can have something at that path ("teams.CYAN.points", "orders[0].points"); else what is wrong.
Status check_result_path(const std::string& path);
/// The first expectation that does not hold, as an error of kind kNo.
Status check_expectations(const std::vector<Expectation>& expectations, const std::string& result_json,
                          const std::string& file);

}  // namespace cxlab
