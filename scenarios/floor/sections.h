#pragma once
// Sections of a scenario whose world is a floor with robots (sim/world.h), whatever is played there: how long skills
// take in the timed tier, and what goes wrong. They have the same meaning in each such world, whose row lists them in
// `WorldKind::reads`.

#include <vector>

#include "scenarios/catalogue.h"
#include "sim/faults/fault.h"
#include "sim/skills/timed_config.h"

namespace cxlab {

/// `timed:`. Other worlds ignore it.
extern const SectionKind kTimedSection;
/// `faults:`. An error in other worlds.
extern const SectionKind kFaultsSection;

const sim::TimedSkillsConfig& timed_of(const Scenario& scenario);
/// Numbered in order of the list.
std::vector<sim::Fault> faults_of(const Scenario& scenario);

}  // namespace cxlab
