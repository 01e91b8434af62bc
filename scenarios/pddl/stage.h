#pragma once
// Puts a PDDL manager on the stage.

#include "cx/base/expected.h"
#include "scenarios/nodes.h"
#include "scenarios/pddl/config.h"
#include "scenarios/stage.h"

namespace cxlab::pddl {

Status add_manager(const Config& config, const NodeSetup& setup, Stage& stage);

}  // namespace cxlab::pddl
