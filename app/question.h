#pragma once
// Code that all questions about a recorded run share: which run, which environment, which time, and how to print.

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>
#include "cx/base/json.h"

#include "app/command.h"
#include "lab/moment.h"

namespace cxlab::app {

/// Opens a run to ask it. If the run failed, standard error first says when and why.
Expected<lab::Run> open_run(const std::string& folder, bool trust_programs = false);

struct Question {
  std::string run, environment;
  std::optional<double> at, from, to;  ///< s
  bool trust_programs = false, json = false;
};

/// Declares RUN, `--env`, `--trust-programs`, `--json`, and the limits; as times either only `--at`, or `--from` and
/// `--to` too.
enum class Times { kAt, kStretch, kAtOrStretch };
void add_question(CLI::App& command, Question& question, Times times);

/// The answer of one environment.
struct Answer {
  std::string text;  ///< lines
  Json json;         ///< null: the text is the whole answer, of one environment
};
using Ask = std::function<Expected<Answer>(inspect::Inspector&)>;
/// Plays the run's rules up to the time, asks each environment, and prints. An environment that does not know what is
/// asked about is left out as long as another one knows it. Gives the exit code.
int ask(const Question& question, const Ask& ask, lab::Moment::Options options = {});

/// The begin and the end of the stretch; those of the run where the option is missing.
SimTime from_of(const Question& question);
SimTime to_of(const Question& question);

}  // namespace cxlab::app
