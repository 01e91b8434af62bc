#pragma once
// Why a rule of a recorded run has not fired at a time: the run's rules are played again up to then.

#include <optional>
#include <string>
#include <vector>
#include "cx/base/json.h"

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/makers.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

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
Json to_json(const inspect::Makers& makers);
/// "condition 2: (order (id 3)): there is no fact of order", as JSON has it.
std::string to_text(const explain::UnmetCondition& lacks);

Expected<WhyNotAnswer> why_not(const Run& run, const WhyNotQuestion& question, const Host& host = {});

}  // namespace cxlab::lab
