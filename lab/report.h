#pragma once
// `index.html` of a run: score board, points over time, orders, what each robot did when, pictures.

#include "cx/base/expected.h"
#include "lab/session.h"

namespace cxlab::lab {

/// Writes the page of a run into its folder, and `report.json`, the data that it is made of (docs/journal.md). Does
/// nothing for a run without a folder or without an end.
Status write_report(const Played& played);

}  // namespace cxlab::lab
