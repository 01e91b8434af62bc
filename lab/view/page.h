#pragma once
// Pages, scripts and data of `cxlab view` (docs/reference/view.md); what is in a run's folder is read, and nothing of
// it is run.

#include <filesystem>
#include <string>

#include "cx/base/json.h"
#include "lab/view/request.h"

namespace cxlab::lab {

/// /run/ID/; `head` is that of `page_of_recorded`, and what the server adds.
ViewReply view_run_page(Json head);
/// "runs.html" or "two.html"
ViewReply view_page(const std::string& name);
/// "run.js", "runs.js", "two.js", "three.js"
ViewReply view_script(const std::string& name);
/// /run/ID/scene.bin: the whole chunks from byte `from` on.
ViewReply view_scene(const std::filesystem::path& run, std::size_t from);
/// A file of the run by its name, if the page of the run links to it.
ViewReply view_file(const std::filesystem::path& run, const std::string& name);

}  // namespace cxlab::lab
