// cxlab diff: where the rules of two recorded runs part first, what led to it, and what came of it.

#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/json.h"
#include "cx/inspect/text.h"
#include "lab/comparison.h"

namespace cxlab::app {

namespace {

struct DiffOptions {
  std::string a, b;
  bool trust_programs = false, json = false;
};

Json json_of(const lab::Comparison::Side& side) {
  Json json{{"what", side.what.empty() ? Json() : Json(side.what)}};
  Json steps = Json::array();
  if (side.because)
    for (const auto& step : side.because->steps)
      steps.push_back({{"n", step.n}, {"text", inspect::line_of(step)}, {"because", step.because}});
  json["steps"] = std::move(steps);
  if (!side.remark.empty()) json["remark"] = side.remark;
  return json;
}

Json json_of(const lab::Comparison& found) {
  Json json{{"same", found.same()}, {"compared_s", to_seconds(found.compared)}};
  json["only_in_a"] = found.only_in_a;
  json["only_in_b"] = found.only_in_b;
  json["constructs"] = Json::array();
  for (const auto& c : found.constructs)
    json["constructs"].push_back({{"kind", c.kind}, {"name", c.name}, {"a", c.a}, {"b", c.b}});
  json["first"] = !found.first ? Json()
                               : Json{{"environment", found.first->environment},
                                      {"t_s", to_seconds(found.first->t)},
                                      {"a", json_of(found.first->a)},
                                      {"b", json_of(found.first->b)}};
  json["outcomes"] = Json::array();
  for (const auto& o : found.outcomes) {
    const auto value = [](const std::string& text) { return text.empty() ? Json() : parse_json(text); };
    json["outcomes"].push_back({{"path", o.path}, {"a", value(o.a)}, {"b", value(o.b)}});
  }
  return json;
}

int diff(const DiffOptions& options) {
  auto a = open_run(options.a, options.trust_programs);
  if (!a) return fail(a.error());
  auto b = open_run(options.b, options.trust_programs);
  if (!b) return fail(b.error());
  Console console(true);
  const auto found = lab::compare(*a, *b, console.host());
  if (const int code = interrupted("the runs were not compared")) return code;
  if (!found) return fail(found.error());
  if (options.json)
    std::printf("%s\n", json_text(json_of(*found), 2).c_str());
  else
    std::fputs(lab::text_of(*found).c_str(), stdout);
  return found->same() ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_diff(CLI::App& app, Action& action) {
  auto options = std::make_shared<DiffOptions>();
  CLI::App* command = app.add_subcommand(
      "diff", "Compare two recorded runs: where their rules part first, what led to it, and what came of it");
  add_limit_options(*command);
  command->add_option("a", options->a, "Folder of a run")->required();
  command->add_option("b", options->b, "Folder of another run")->required();
  add_trust_programs(*command, options->trust_programs);
  command->add_flag("--json", options->json, "Prints the answer as JSON");
  command->footer(
      "Exit code 0: the rules did the same, and the results agree; 1: they differ. The answer names constructs that\n"
      "are written differently, the first event of rules that differs, and the differences in result.json.\n"
      "Example:\n  cxlab diff runs/game-1 runs/game-2");
  command->callback([options, &action] { action = [options] { return diff(*options); }; });
}

}  // namespace cxlab::app
