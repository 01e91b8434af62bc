// cxlab why-not: why a rule of a recorded run has not fired at a time, from the rules alone, played up to then.

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/json_text.h"
#include "lab/why_not.h"

namespace cxlab::app {

namespace {

using Json = nlohmann::ordered_json;

struct WhyNotOptions {
  std::string run, rule, environment;
  std::optional<double> at;
  std::vector<std::string> where;
  bool trust_programs = false, json = false;
};

void print(const char* before, const explain::Values& values) {
  if (values.empty()) return;
  std::printf("    %s", before);
  for (const auto& [name, value] : values) std::printf(" ?%s = %s", name.c_str(), value.c_str());
  std::printf("\n");
}

void print(const std::vector<std::string>& facts) {
  for (const std::string& fact : facts) std::printf("    %s\n", fact.c_str());
}

void print_agenda(const explain::WhyNot& answer) {
  std::string stack;
  for (const std::string& module : answer.focus) stack += (stack.empty() ? "" : ", ") + module;
  if (answer.verdict == explain::Verdict::kFocus)
    std::printf(
        "  all its conditions hold, with salience %d, but its module %s is not in focus: the next run looks at %s "
        "only; "
        "(focus %s) or auto-focus brings it there\n",
        answer.salience, answer.module.c_str(), stack.c_str(), answer.module.c_str());
  else
    std::printf("  all its conditions hold: the next run fires it, with salience %d; %zu activations stand above it\n",
                answer.salience, answer.above);
  if (!answer.first_above.empty())
    std::printf("  %s:\n",
                answer.verdict == explain::Verdict::kFocus ? "on the agenda of what is in focus" : "above it");
  for (const auto& [rule, salience] : answer.first_above) std::printf("    %s, salience %d\n", rule.c_str(), salience);
}

void print(const explain::UnmetCondition& unmet, std::size_t alternatives) {
  if (alternatives > 1)
    std::printf("  none of the %zu alternatives of its or conditions holds; the one that gets furthest:\n",
                alternatives);
  std::printf("  condition %d does not hold%s%s\n  %s\n", unmet.number, unmet.text.empty() ? "" : ": ",
              unmet.text.c_str(), unmet.because.c_str());
  if (unmet.fact) std::printf("    %s\n", unmet.fact->c_str());
  print("with", unmet.values);
}

void print(const lab::WhyNotAnswer::InEnvironment& found) {
  const explain::WhyNot& answer = found.answer;
  const std::string module = answer.module == "MAIN" ? "" : answer.module + "::";
  std::printf("%s%s (%s:%d) in %s\n", module.c_str(), answer.rule.c_str(), answer.file.c_str(), answer.line,
              found.environment.c_str());
  switch (answer.verdict) {
    case explain::Verdict::kWaiting:
    case explain::Verdict::kFocus: print_agenda(answer); break;
    case explain::Verdict::kFired:
      std::printf(
          "  all its conditions hold, and it has fired for what holds, the last time at %s; it fires again when "
          "one of these facts has changed\n",
          seconds_text(*answer.fired_for_it).c_str());
      break;
    case explain::Verdict::kTaken:
      std::printf(
          "  all its conditions hold now, but it is not on the agenda and has not fired for these facts: CLIPS "
          "evaluates a test when a fact of it changes, not when what it calls gives another value\n");
      break;
    case explain::Verdict::kCondition: print(*answer.unmet, answer.alternatives); break;
  }
  if (!answer.unmet) {
    print(answer.facts);
    print("with", answer.values);
    if (answer.combinations > 1) std::printf("    and %zu other combinations\n", answer.combinations - 1);
  }
  if (answer.lost) {
    std::printf("  was on the agenda up to %s, until %s took it off%s\n", seconds_text(answer.lost->t).c_str(),
                answer.lost->by.empty() ? "something from outside of rules" : ("rule " + answer.lost->by).c_str(),
                answer.lost->facts.empty() ? "" : ", with");
    print(answer.lost->facts);
  }
  if (answer.fired == 0)
    std::printf("  has not fired so far\n");
  else
    std::printf("  fired %zu time%s so far, the last time at %s with\n", answer.fired, answer.fired == 1 ? "" : "s",
                seconds_text(answer.last_fired).c_str());
  print(answer.last_facts);
  if (found.makers) std::printf("%s", found.makers->text().c_str());
}

/// `id=5`; the variable may be written with its mark.
Expected<explain::Wanted> wanted_of(const std::vector<std::string>& where) {
  explain::Wanted wanted;
  for (const std::string& text : where) {
    const std::size_t equals = text.find('=');
    std::string name = text.substr(0, equals);
    name.erase(0, name.starts_with("$?") ? 2 : name.starts_with('?') ? 1 : 0);
    if (equals == text.npos || name.empty())
      return usage_error("--where: found '" + text + "', expected VARIABLE=VALUE, as in id=5");
    const auto [known, fresh] = wanted.emplace(name, text.substr(equals + 1));
    if (!fresh && known->second != text.substr(equals + 1))
      return usage_error("--where: ?" + name + " cannot have two values");
  }
  return wanted;
}

int why_not(const WhyNotOptions& options) {
  auto wanted = wanted_of(options.where);
  if (!wanted) return fail(wanted.error());
  auto run = lab::Run::open(options.run, catalogue(), options.trust_programs);
  if (!run) return fail(run.error());
  Console console(true);
  lab::WhyNotQuestion question{options.rule, {}, *std::move(wanted), options.environment};
  if (options.at) question.at = from_seconds(*options.at);
  const auto answer = lab::why_not(*run, question, console.host());
  if (const int code = interrupted("the run was not replayed up to that time")) return code;
  if (!answer) return fail(answer.error());
  if (options.json) {
    std::printf("%s\n", json_text(lab::to_json(*answer), 2).c_str());
    return 0;
  }
  std::printf("after the tick at %s%s:\n", seconds_text(answer->at).c_str(),
              answer->cut_off ? ", where the log of the run is cut off" : "");
  for (const auto& found : answer->environments) print(found);
  return 0;
}

}  // namespace

void add_why_not(CLI::App& app, Action& action) {
  auto options = std::make_shared<WhyNotOptions>();
  CLI::App* command = app.add_subcommand("why-not", "Says why a rule of a recorded run has not fired");
  add_limit_options(*command);
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("rule", options->rule, "Name of the rule, with or without its module: nav, NAV::nav")->required();
  command->add_option("--env", options->environment, "Only this environment (default: all)");
  time_option(command->add_option("--at", options->at, "When: 312.4, 5:12 or 5:12.4 (default: the end of the run)"));
  once_each(command->add_option("--where", options->where,
                                "VARIABLE=VALUE: only combinations in which the variable has this value (repeatable)"));
  add_trust_programs(*command, options->trust_programs);
  command->add_flag("--json", options->json, "The answer as JSON");
  command->callback([options, &action] { action = [options] { return why_not(*options); }; });
}

}  // namespace cxlab::app
