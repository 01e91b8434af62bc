#pragma once
// Control of a run: environments stop at ticks and before they fire a rule, and there a person evaluates and builds, or
// what was planned is done (lab/what_if.h). Between ticks the program that plays the run may act (Episode::act). All
// that was done is in the input log with its place, so that the run replays.

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

  /// After the tick at `t`, which is less than 0 before the first tick, and before the next one.
  static ControlPlace after_tick(SimTime t) { return {t, 0, -2}; }
  bool is_between_ticks() const { return fired == -2; }
};

/// One intervention in an environment.
struct ControlAct {
  enum class Verb : std::uint8_t {
    kEval,     ///< by a person: evaluate the text
    kBuild,    ///< by a person: the text is a construct
    kLoad,     ///< planned: the text is that of a file of the name, as `batch*` loads it
    kAssert,   ///< planned: the text is a fact
    kSet,      ///< planned: the text is the value of the name, `?*global*` or a parameter of the node
    kFail,     ///< planned: the run ends here, the text says why
    kRetract,  ///< planned: the text is the index of a fact
    kSettle,   ///< planned: the activations on the agenda count as fired
    kCount,    ///< planned: the next request to the service of the name has the number of the text
  };
  ControlPlace place;
  Verb verb = Verb::kEval;
  std::string text;
  std::string name = {};
};
/// A planned act belongs to what the run is played with: the run stays deterministic, and an error in it ends the run.
/// Between ticks none is planned.
inline bool is_planned(ControlAct::Verb verb) { return verb >= ControlAct::Verb::kLoad; }

/// Decides where environments stop, and acts there.
class RunControl {
 public:
  virtual ~RunControl() = default;
  /// Called at each tick and when rules are about to run; before each firing only where `before_each_firing` says so.
  /// It may wait. It does what rules could notice with `Environment::act`. An error ends the run.
  virtual Status stop_at(Environment& environment, const ControlPlace& place) = 0;
  virtual bool before_each_firing() const = 0;
};

/// Two of them: the first one acts first. Both outlive this.
class BothControls final : public RunControl {
 public:
  BothControls(RunControl& first, RunControl& second) : first_(first), second_(second) {}
  Status stop_at(Environment& environment, const ControlPlace& place) override {
    const Status done = first_.stop_at(environment, place);
    return done ? second_.stop_at(environment, place) : done;
  }
  bool before_each_firing() const override { return first_.before_each_firing() || second_.before_each_firing(); }

 private:
  RunControl &first_, &second_;
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
