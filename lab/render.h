#pragma once
// One picture of a world at a time, or a film of a time span.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/run.h"
#include "lab/video.h"

namespace cxlab::lab {

struct RenderOptions {
  std::filesystem::path out;         ///< PNG
  std::vector<std::string> cameras;  ///< side by side; empty = the view's first
  int width = 960, height = 600;
  bool caption = true;
  std::optional<double> at;  ///< s; of a run: default its end, or how far its log goes
};

Status render_run(const Run& run, const RenderOptions& options);
/// Plays the scenario up to `at`, which must be given. Draws nothing after a stop by the host.
Status render_scenario(Scenario scenario, const RenderOptions& options, const Host& host = {});

/// A film from `from` to `to`, s; default the whole run. A stop by the host ends it earlier.
struct FilmOptions {
  VideoOptions video;
  double from = 0;
  std::optional<double> to;
};
Status film_run(const Run& run, const FilmOptions& options, const Host& host = {});
/// Plays the scenario up to `to`.
Status film_scenario(Scenario scenario, const FilmOptions& options, const Host& host = {});

}  // namespace cxlab::lab
