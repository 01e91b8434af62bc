#pragma once
// Why a rule of a recorded run has not fired at a time: the run's rules are played again up to then.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/explain/why_not.h"
#include "lab/host.h"
#include "lab/recorded_run.h"

namespace cxlab::lab {

struct WhyNotAnswer {
  struct InEnvironment {
    std::string environment;
    explain::WhyNot answer;
  };
  SimTime at{};                             ///< of the last tick that was played
  std::vector<InEnvironment> environments;  ///< that have the rule
  bool stopped = false;                     ///< by the host; then there is no answer
};
nlohmann::ordered_json to_json(const WhyNotAnswer& answer);

/// `rule` may have a module. Without `at`: at the end of the run, or of what was recorded.
Expected<WhyNotAnswer> why_not(const RecordedRun& run, const std::string& rule, std::optional<SimTime> at,
                               const Host& host = {});

}  // namespace cxlab::lab
