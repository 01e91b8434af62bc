#pragma once
// Asks a recorded run one of the questions that its world declares (scenarios/question.h).

#include <optional>
#include <string>

#include "cx/base/expected.h"
#include "lab/run.h"
#include "scenarios/question.h"

namespace cxlab::lab {

struct WorldAsk {
  std::string question, about = {};          ///< `about`: its argument; empty: everything
  std::optional<SimTime> at, from, to = {};  ///< as it was then; or the stretch. Without them up to the end
};

struct WorldAnswered {
  WorldAnswer answer;
  SimTime from{}, to{};
  bool cut_off = false;  ///< the journal ends before the time that was asked for
};

/// An error names the option ("--at") or the nearest question that this world answers.
Expected<WorldAnswered> ask_world(const Run& run, const WorldAsk& ask);

}  // namespace cxlab::lab
