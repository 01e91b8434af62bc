#pragma once
// Why a rule of a recorded run has not fired at a time: the run's rules are played again up to then.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/makers.h"
#include "lab/host.h"
#include "lab/run.h"
#include "scenarios/episode.h"

namespace cxlab::lab {

/// Hears from the start of a run of what a rule did: its firings, and what it had on the agenda and lost.
class RuleWitness {
 public:
  /// `rule` may have a module: the rules of that name in all modules are followed.
  RuleWitness(Episode& episode, const std::string& rule);
  ~RuleWitness();
  RuleWitness(const RuleWitness&) = delete;
  RuleWitness& operator=(const RuleWitness&) = delete;

  /// To be called after each tick.
  void tick_is_over();
  bool follows(const std::string& rule) const;
  /// Why the rule has not fired in that environment, as it is now; the file as people know it.
  Expected<explain::WhyNot> why_not(cx::Environment& environment, const ConstructInfo& rule,
                                    const explain::Wanted& wanted) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct WhyNotQuestion {
  std::string rule;           ///< may have a module; without one, rules of this name in all modules
  std::optional<SimTime> at;  ///< none: the end of the run, or of what was recorded
  explain::Wanted wanted{};   ///< of which combinations; all by default
  std::string environment{};  ///< only this one; empty: all
};

struct WhyNotAnswer {
  struct InEnvironment {
    std::string environment;
    explain::WhyNot answer;
    std::optional<inspect::Makers> makers;  ///< of what its condition lacks
  };
  SimTime at{};                             ///< of the last tick that was played
  bool cut_off = false;                     ///< the log of a killed run ends before the time asked for
  std::vector<InEnvironment> environments;  ///< that have the rule; one of several modules comes more than once
  bool stopped = false;                     ///< by the host; then there is no answer
};
Json to_json(const WhyNotAnswer& answer);

Expected<WhyNotAnswer> why_not(const Run& run, const WhyNotQuestion& question, const Host& host = {});

}  // namespace cxlab::lab
