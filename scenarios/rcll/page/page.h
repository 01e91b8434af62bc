#pragma once
// What the page of a game shows: points, orders, what robots did, faults.

#include "scenarios/question.h"
#include "scenarios/run_page.h"

namespace cxlab::rcll {

Expected<RunPage> page_of(const AskedRun& run, const Result& result);

}  // namespace cxlab::rcll
