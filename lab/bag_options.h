#pragma once
// The options `--bag...` of `cxlab run` and `cxlab env`: a recording that is played into the run
// (docs/how-to/replay-a-bag.md).

#include <optional>
#include <string>
#include <vector>

#include "scenarios/scenario.h"

namespace cxlab::lab {

struct BagOptions {
  std::string file;
  std::optional<double> start, offset, rate;
  std::string topics, exclude;      ///< regular expressions
  std::vector<std::string> remaps;  ///< FROM:=TO
  bool own = false;
};

/// The same as changes of a scenario, in which errors name the option. kUsage for a remap without ":=".
Expected<std::vector<Override>> overrides_of(const BagOptions& options);

}  // namespace cxlab::lab
