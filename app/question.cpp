#include "app/question.h"

#include <cstdio>

#include "app/arguments.h"
#include "app/console.h"
#include "cx/base/json.h"
#include "cx/inspect/text.h"

namespace cxlab::app {

namespace {

/// What happens before the first tick has a time below 0.
constexpr SimTime kEarliest = SimTime::min() + SimTime(1);

}  // namespace

Expected<lab::Run> open_run(const std::string& folder, bool trust_programs) {
  auto run = lab::Run::open(folder, catalogue(), trust_programs);
  if (run && run->failure)
    std::fprintf(stderr, "note: the run failed at %s: %s\n", inspect::seconds_text(run->sim_time).c_str(),
                 printable(run->failure->text()).c_str());
  return run;
}

void add_question(CLI::App& command, Question& question, Times times) {
  add_limit_options(command);
  command.add_option("run", question.run, "Folder of the run")->required();
  command.add_option("--env", question.environment, "Only this environment (default: all)");
  CLI::Option* at = nullptr;
  if (times != Times::kStretch)
    at = time_option(
        command.add_option("--at", question.at, "Time: 312.4, 5:12 or 5:12.4 (default: the end of the run)"));
  if (times != Times::kAt) {
    CLI::Option* from = time_option(
        command.add_option("--from", question.from, "Beginning of the stretch (default: the start of the run)"));
    CLI::Option* to =
        time_option(command.add_option("--to", question.to, "End of the stretch (default: the end of the run)"));
    if (at) {
      from->excludes(at);
      to->excludes(at);
    }
  }
  add_trust_programs(command, question.trust_programs);
  command.add_flag("--json", question.json, "Prints the answer as JSON");
}

SimTime from_of(const Question& question) { return question.from ? from_seconds(*question.from) : kEarliest; }
SimTime to_of(const Question& question) { return question.to ? from_seconds(*question.to) : kNever; }

int ask(const Question& question, const Ask& ask, lab::Moment::Options options) {
  if (question.from && question.to && *question.from > *question.to) return fail(usage_error("--from is after --to"));
  auto run = open_run(question.run, question.trust_programs);
  if (!run) return fail(run.error());
  Console console(true);
  auto moment = lab::Moment::open(*run, console.host(), options);
  if (!moment) return fail(moment.error());
  const std::optional<double> end = question.at ? question.at : question.to;
  if (Status s = (*moment)->seek(end ? std::optional(from_seconds(*end)) : std::nullopt); !s && !(*moment)->stopped())
    return fail(lab::about_option(s.error(), question.at ? "--at" : "--to"));
  if (const int code = interrupted("the run was not replayed up to that time")) return code;
  if (question.from && from_seconds(*question.from) > (*moment)->t())
    return fail(usage_error("--from: the run ends at " + inspect::seconds_text((*moment)->t())));
  auto inspectors = (*moment)->inspectors(question.environment);
  if (!inspectors) return fail(inspectors.error());
  Json environments = Json::array();
  std::string text;
  std::optional<Error> refused;
  for (inspect::Inspector& inspector : *inspectors) {
    auto answer = ask(inspector);
    if (!answer) {
      if (!refused || answer.error().kind == ErrorKind::kNo) refused = answer.error();
      continue;
    }
    if (answer->json.is_null()) {
      std::fputs(answer->text.c_str(), stdout);
      return 0;
    }
    Json json{{"environment", inspector.name()}};
    json.update(answer->json);
    environments.push_back(std::move(json));
    text += (inspectors->size() > 1 ? inspector.name() + ":\n" : "") + answer->text;
  }
  if (environments.empty() && refused) return fail(*refused);
  if (question.json) {
    Json json{{"at_s", to_seconds((*moment)->t())}};
    if ((*moment)->cut_off()) json["cut_off"] = true;
    json["environments"] = std::move(environments);
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  std::printf("after the tick at %s%s:\n%s", inspect::seconds_text((*moment)->t()).c_str(),
              (*moment)->cut_off() ? run->cut_off_text("log").c_str() : "", text.c_str());
  return 0;
}

}  // namespace cxlab::app
