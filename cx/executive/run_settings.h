#pragma once
// Settings of all environments of a run. The episode sets them once; managers, environments and plugins read them.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "cx/engine/rule_counts.h"

namespace cxlab {
class LookOutside;
struct LimitsInUse;
}  // namespace cxlab
namespace cxlab::bus {
class Feed;
}
namespace cxlab::net {
class Network;
}

namespace cxlab::cx {

class ControlLog;
class Environment;
class LogSink;
class RunControl;

/// Releases of ROS 2 that an agent may have to run on, the oldest first.
enum class RosRelease : std::uint8_t { kHumble, kJazzy, kKilted };
inline constexpr std::string_view kRosReleases[] = {"humble", "jazzy", "kilted"};

/// How configurations are played: all managers of a run in the same way.
struct Conduct {
  bool keep_going = false;  ///< errors in rule files and plugins are noted and loading goes on
  bool strict = false;      ///< what the real CX would do otherwise are errors (docs/reference/strict-cx.md)
  RosRelease release = RosRelease::kKilted;  ///< that `strict` is about
  bool programs = true;  ///< libraries of packages may be opened, and programs that nodes name started
};

struct RunSettings : Conduct {
  LogSink* log = nullptr;                  ///< may be none
  LookOutside* outside = nullptr;          ///< may be none
  bus::Feed* feed = nullptr;               ///< where its deliveries come from; none: the bus
  net::Network* network = nullptr;         ///< of the episode; none: each manager has its own
  RunControl* control = nullptr;           ///< stops environments; may be none
  ControlLog* control_log = nullptr;       ///< of what was done there; may be none
  std::filesystem::path run_folder;        ///< for `logs/<env>.log` and what rules write; empty = no logs
  std::filesystem::path rules_folder;      ///< for what rules write where `run_folder` is empty; empty = they cannot
  std::uint64_t seed = 0;                  ///< each environment draws from a stream of its own
  double epoch = 0;                        ///< s since 1970 at simulated time 0
  std::int64_t max_firings = 100000;       ///< a run of an environment, or callbacks in a tick; 0 = no limit
  LimitsInUse* limits = nullptr;           ///< of all environments; may be none
  bool stop_on_rule_error = true;          ///< else errors are only noted, as CX does
  Counting counting = Counting::kNothing;  ///< `RuleEngine::count` of each environment
  /// Called with each environment before it is destroyed; may be none.
  std::function<void(const Environment&)> on_environment_end;
  bool trust_rules = false;  ///< rules read and write any file and call `system`
  bool next = false;         ///< behaves as the next CX where that differs (parameter `compat: next`)
};

}  // namespace cxlab::cx
