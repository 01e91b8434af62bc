#pragma once
// A stage that does something in environments itself, as a story makes facts.

#include <memory>

#include "cx/executive/run_control.h"
#include "scenarios/stage.h"

namespace cxlab {

struct ActingStage : Stage {
  std::unique_ptr<cx::RunControl> control;  ///< acts before that of the caller (EpisodeOptions); not none
};

}  // namespace cxlab
