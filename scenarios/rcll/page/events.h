#pragma once
// The events of a game that people are told: faults, failed skills, machines that break, deliveries, points.

#include <vector>

#include "scenarios/question.h"
#include "scenarios/run_page.h"

namespace cxlab::rcll {

/// `WorldKind::happened`.
void happened(const Scenario& scenario, const JournalRecord& record, std::vector<PageEvent>& out);

}  // namespace cxlab::rcll
