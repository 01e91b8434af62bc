#pragma once
// `index.html` of a run: score board, points over time, orders, what each robot did when, pictures.

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "lab/run.h"
#include "lab/session.h"

namespace cxlab::lab {

/// Writes the page of a run into its folder, and `report.json`, the data that it is made of
/// (docs/reference/run-folder.md). Does nothing for a run without a folder or without an end.
Status write_report(const Played& played);

/// What the page of a run shows (lab/run_page.h).
struct PageParts {
  Json head;  ///< of its template
  Json run;   ///< of its scripts
};
/// The same of a recorded run, as far as it was recorded: it may have been killed, or may still be played. Pictures
/// are left out.
Expected<PageParts> page_of_recorded(const Run& run);
/// Files of a run's folder that its page links to, by their names in it.
Json readable_files(const std::filesystem::path& folder);

}  // namespace cxlab::lab
