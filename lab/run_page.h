#pragma once
// The page of a run: one file that plays the run, from its scene and from what its world declares
// (scenarios/run_page.h).
//
//   RunPageData data{...};
//   auto html = run_page(head, data);
//
// The page reads `data` alone, so that whoever serves it may give it the data in another way (lab/pages/run/data.js).

#include <string>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "scenarios/run_page.h"

namespace cxlab::lab {

/// What the scripts of the page read (docs/reference/run-page.md).
struct RunPageData {
  Json run;           ///< end, kinds, shades, parts but tables, events
  std::string scene;  ///< bytes of scene.bin; empty: there is none
};

/// Charts, lanes and tasks of the page, and the rest of it but its tables; `end` in s.
Json run_data(const RunPage& page, double end);
/// The tables of the page, for its template.
Json tables_of(const RunPage& page);

/// `index.html`. `head`: what the template run.html shows without any script. A scene that would make the page larger
/// than `kLargestPage` is shown as far as it fits in; the page says so.
Expected<std::string> run_page(const Json& head, RunPageData data);
inline constexpr std::size_t kLargestPage = 3'000'000;

// --- Pages that `cxlab view` serves: they have no data, but fetch it (docs/reference/view.md)

/// The page of a run. `head` as for `run_page`; its `live`: the run goes on; `in_folder`: "/" lists more runs.
Expected<std::string> served_run_page(Json head);
/// "runs.html", the table of the runs of a folder, or "two.html", two runs side by side.
Expected<std::string> served_page(const std::string& name);
/// The script that a served page loads: "run.js", "runs.js" or "two.js"; an error for any other name.
Expected<std::string> served_script(std::string_view name);

/// Bytes compressed with gzip, in base64; the same bytes give the same text.
std::string packed(std::string_view bytes);

}  // namespace cxlab::lab
