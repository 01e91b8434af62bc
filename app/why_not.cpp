// cxlab why-not: why a rule of a recorded run has not fired at a time, from the rules alone, played up to then.

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "lab/why_not.h"

namespace cxlab::app {

namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string run, rule;
  std::optional<double> at;
  bool json = false;
};

std::string seconds(SimTime t) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", to_seconds(t));
  return text;
}

void print(const lab::WhyNotAnswer::InEnvironment& found) {
  const explain::WhyNot& answer = found.answer;
  std::printf("%s (%s:%d) in %s\n", answer.rule.c_str(), answer.file.c_str(), answer.line, found.environment.c_str());
  switch (answer.verdict) {
    case explain::Verdict::kWaiting:
      std::printf(
          "  all its conditions hold: the next run fires it, with salience %d; %zu activations stand above it\n",
          answer.salience, answer.above);
      for (const auto& [rule, salience] : answer.first_above)
        std::printf("    %s, salience %d\n", rule.c_str(), salience);
      break;
    case explain::Verdict::kFired: std::printf("  all its conditions hold, and it has fired for what holds\n"); break;
    case explain::Verdict::kTaken:
      std::printf("  all its conditions hold, but it is not on the agenda and has never fired\n");
      break;
    case explain::Verdict::kCondition:
      std::printf("  condition %d does not hold%s%s\n  %s\n", answer.unmet->number,
                  answer.unmet->text.empty() ? "" : ": ", answer.unmet->text.c_str(), answer.unmet->because.c_str());
      if (answer.unmet->fact) std::printf("    %s\n", answer.unmet->fact->c_str());
      if (!answer.unmet->values.empty()) {
        std::printf("    with");
        for (const auto& [name, value] : answer.unmet->values) std::printf(" ?%s = %s", name.c_str(), value.c_str());
        std::printf("\n");
      }
  }
  std::printf("  fired %zu times so far", answer.fired);
  if (answer.fired > 0) std::printf(", the last time at %s with", seconds(answer.last_fired).c_str());
  std::printf("\n");
  for (const std::string& fact : answer.last_facts) std::printf("    %s\n", fact.c_str());
}

int why_not(const Options& options) {
  auto run = lab::RecordedRun::open(options.run, catalogue());
  if (!run) return fail(run.error());
  Console console(true);
  std::optional<SimTime> at;
  if (options.at) at = from_seconds(*options.at);
  const auto answer = lab::why_not(*run, options.rule, at, console.host());
  if (signal_that_came()) return 128 + signal_that_came();
  if (!answer) return fail(answer.error());
  if (options.json) {
    std::printf("%s\n", lab::to_json(*answer).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    return 0;
  }
  std::printf("after the tick at %s:\n", seconds(answer->at).c_str());
  for (const auto& found : answer->environments) print(found);
  return 0;
}

}  // namespace

void add_why_not(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("why-not", "Says why a rule of a recorded run has not fired");
  add_memory_option(*command);
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("rule", options->rule, "Name of the rule")->required();
  command->add_option("--at", options->at, "When, s of simulated time (default: the end)")->check(not_negative());
  command->add_flag("--json", options->json, "The answer as JSON");
  command->callback([options, &action] { action = [options] { return why_not(*options); }; });
}

}  // namespace cxlab::app
