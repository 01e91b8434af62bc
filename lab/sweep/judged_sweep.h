#pragma once
// A sweep that answers the requirements of its suite, and ends once they are answered.

#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/sweep/judge.h"
#include "lab/sweep/suite.h"
#include "lab/sweep/sweep.h"

namespace cxlab::lab {

struct JudgedRows {
  std::vector<Row> rows;        ///< of the games that were played, now or before
  std::vector<Answer> answers;  ///< none: the host has stopped the sweep
  std::size_t games = 0, planned = 0;
};

/// Plays as `sweep` does, the first games first, and stops after the look (lab/statistics/sequential.h) with which all
/// requirements are answered; with `all` it plays on, and the answers are the same.
Expected<JudgedRows> judged_sweep(const Suite& suite, const SweepOptions& options, bool all, const Host& host = {});

/// The same answers of rows that are there: those of all cells of the suite, in their order.
Expected<JudgedRows> judged_rows(const Suite& suite, const std::vector<Row>& rows);

}  // namespace cxlab::lab
