#pragma once
// What if: a run is played again exactly up to a time. From there it goes on with other rules, parameters or facts, in
// the same world and with the same chance.

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/executive/environment.h"
#include "cx/executive/run_control.h"
#include "scenarios/what_if.h"

namespace cxlab {
struct Scenario;
struct WorldKind;
}  // namespace cxlab

namespace cxlab::lab {

struct Run;

/// Reads the named file, and finds faults before anything is played: a form that CLIPS cannot read, names that the run
/// does not have, or a time after its end.
Status prepare(WhatIf& what_if, const Run& run, const Scenario& scenario);

/// Something that was done: "replaces defrule go (rules.clp:12)".
struct WhatIfAct {
  SimTime t{};
  std::string environment, what;
};

/// `Error::code` of a change that cannot be made.
inline constexpr const char* kWhatIfCode = "what_if";

/// Carries the changes out where their time has come. An error of one ends the run.
class WhatIfControl final : public cx::RunControl {
 public:
  explicit WhatIfControl(std::vector<WhatIf> changes);

  /// The environments of the run, asked for when a change begins.
  void watch(std::function<std::vector<cx::Environment*>()> environments) { environments_ = std::move(environments); }
  Status stop_at(cx::Environment& environment, const cx::ControlPlace& place) override;
  bool before_each_firing() const override { return false; }
  const std::vector<WhatIfAct>& done() const { return done_; }

 private:
  struct Change {
    WhatIf what_if;
    bool begun = false;
    std::set<std::string> waiting = {};  // environments whose turn has not come
    std::set<std::string> set = {};      // of `what_if.set`: what has been set
  };

  Status change(cx::Environment& environment, const cx::ControlPlace& place);
  Status begin(Change& change, SimTime t) const;
  Status carry_out(Change& change, cx::Environment& environment);
  Status set_parameters(Change& change, cx::Environment& environment);
  Status load(const WhatIf& what_if, cx::Environment& environment);
  Status set_globals(Change& change, cx::Environment& environment);
  Status assert_facts(const WhatIf& what_if, cx::Environment& environment);
  Status end(const Change& change) const;
  void note(const cx::Environment& environment, std::string what);

  std::vector<Change> changes_;
  std::function<std::vector<cx::Environment*>()> environments_ = [] { return std::vector<cx::Environment*>(); };
  std::vector<WhatIfAct> done_;
};

/// A line of a comparison of two results.
struct ResultChange {
  std::string what, then, now;
};
/// How the run ended and what it was worth, then and now; further metrics of the world where they differ.
std::vector<ResultChange> compare_results(const WorldKind& world, const std::string& then_json,
                                          const std::string& now_json);

}  // namespace cxlab::lab
