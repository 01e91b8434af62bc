#pragma once
// Control of a run by a person: environments stop before they fire a rule, and the person evaluates and builds there.
// All that was done is in the input log with its place, so that the run replays.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::cx {

class Environment;

/// Where an environment may stop. Places of one environment never come twice.
struct ControlPlace {
  SimTime t{};
  std::int64_t run = 0;     ///< how many times its rules have been run, this one included
  std::int64_t fired = -1;  ///< in this run so far; -1: at a tick, before its plugins act
  bool operator==(const ControlPlace&) const = default;
};

/// What a person did in an environment.
struct ControlAct {
  enum class Verb : std::uint8_t { kEval, kBuild };
  ControlPlace place;
  Verb verb = Verb::kEval;
  std::string text;
};

/// Decides where environments stop, and does there what it is told.
class RunControl {
 public:
  virtual ~RunControl() = default;
  /// Called at each tick and when rules are about to run; before each firing only where `before_each_firing` says so.
  /// It may wait. What rules could notice it does with `Environment::act`.
  virtual void stop_at(Environment& environment, const ControlPlace& place) = 0;
  virtual bool before_each_firing() const = 0;
};

/// The part of the input log that has what was done, by name of the environment's stream.
class ControlLog {
 public:
  virtual ~ControlLog() = default;
  /// Called for each act before it is carried out.
  virtual void add(std::string_view stream, const ControlAct& act) = 0;
  /// In a replay: the act that comes next; none after the last.
  virtual std::optional<ControlAct> next(std::string_view stream) = 0;
  virtual void take(std::string_view stream) = 0;  ///< the one that `next` returns
};

}  // namespace cxlab::cx
