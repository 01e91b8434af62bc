#pragma once
// `index.html` of a run: score board, points over time, orders, what each robot did when, pictures. Self-contained.

#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/picture.h"
#include "scenarios/result.h"

namespace cxlab::app {

/// A skill of one robot.
struct SkillBar {
  std::string robot, skill, target;
  double begin = 0, end = 0;  ///< s
  bool succeeded = false;
  bool ended = true;  ///< false: it was still at work when the run ended
};
/// Points of one team given or taken at a time.
struct ScoreStep {
  std::string team, kind;
  double t = 0;  ///< s
  std::int64_t points = 0;
};
struct Report {
  Result result;
  std::vector<SkillBar> skills;
  std::vector<ScoreStep> scores;
  std::vector<lab::Picture> pictures;
  std::vector<std::string> files;  ///< of the run's folder, that the page links to
};

/// Skills and scores as `journal.jsonl` tells them.
Status read_story(const std::filesystem::path& journal, Report& report);
std::string to_html(const Report& report);

}  // namespace cxlab::app
