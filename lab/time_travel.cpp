#include "lab/time_travel.h"

#include <cstdio>
#include <optional>
#include <utility>

#include "cx/base/file.h"
#include "lab/control/debugger.h"
#include "lab/moment.h"
#include "lab/scene_answer.h"
#include "lab/why_not.h"
#include "lab/world_answer.h"

namespace cxlab::lab {

namespace {

constexpr const char* kSaid = "said.txt";

Status serve(const Run& run, const ControlAddress& address, Host host, Counting counting) {
  auto server = ControlServer::open(address);
  if (!server) return server.error();
  Debugger::Options options;
  options.recorded = true;
  const std::atomic<bool>* const ends = host.stop;
  options.over = [ends] { return ends && *ends; };
  Debugger debugger(**server, std::move(options));
  host.stop = &debugger.gives_up();
  host.log = &debugger;
  host.progress = nullptr;
  const auto scenario = run.scenario();
  if (!scenario) return scenario.error();
  auto opened = Moment::open(run, host, {.counting = counting, .control = &debugger});
  if (!opened) return opened.error();
  Moment& moment = **opened;
  std::optional<RuleWitness> witness;
  debugger.watch({.environments = [&moment] { return moment.episode().environments(); },
                  .inspect = [&moment](cx::Environment& environment) { return moment.inspector(environment); },
                  .look = [&moment](const std::string& what) -> Expected<std::string> {
                    auto seen = moment.scene();
                    return seen ? scene_text(*std::move(seen), what) : seen.error();
                  },
                  .look_json = [&moment](const std::string& what) -> Expected<Json> {
                    auto seen = moment.scene();
                    return seen ? scene_json(*std::move(seen), what) : seen.error();
                  },
                  .why_not = [&witness](cx::Environment& environment, const ConstructInfo& rule,
                                        const explain::Wanted& wanted) -> std::optional<Expected<explain::WhyNot>> {
                    if (!witness || !witness->follows(rule.name)) return std::nullopt;
                    return witness->why_not(environment, rule, wanted);
                  },
                  .world_questions = scenario->world.kind->questions,
                  .ask_world =
                      [&moment, &run](const WorldQuestion& question, const std::string& about) {
                        return ask_world(run,
                                         {.question = std::string(question.name), .about = about, .at = moment.t()});
                      }});
  moment.after_tick = [&] {
    if (witness) witness->tick_is_over();
    debugger.tick_is_over(moment.t());
  };
  while (!debugger.has_left() && !(ends && *ends)) {
    debugger.begin_again();
    const Status played = moment.seek(std::nullopt);
    if (!debugger.gives_up()) debugger.stay_at_end(moment.t(), played);
    if (debugger.has_left()) break;
    witness.reset();  // before the episode that it watches goes
    if (Status s = moment.rewind(); !s) return s;
    if (!debugger.followed_rule().empty()) witness.emplace(moment.episode(), debugger.followed_rule());
  }
  return {};
}

}  // namespace

Expected<std::unique_ptr<TimeTravel>> TimeTravel::start(const Run& run, const Host& host, Options options) {
  auto folder = ScratchFolder::create();
  if (!folder) return folder.error();
  ControlAddress address{.path = ((*folder)->path() / "control.sock").string()};
  ProcessOptions streams;
  if (options.quiet) streams.err = Stream::file((*folder)->path() / kSaid);
  auto process = Process::fork(streams, [&] {
    const Status served = serve(run, address, host, options.counting);
    if (served) return 0;
    std::fprintf(stderr, "error: %s\n", served.error().text().c_str());
    return static_cast<int>(served.error().kind);
  });
  if (!process) return process.error();
  return std::unique_ptr<TimeTravel>(new TimeTravel(*std::move(folder), std::move(address), *std::move(process)));
}

std::string TimeTravel::said() const {
  constexpr std::size_t kMost = 10'000;
  auto text = read_file(folder_->path() / kSaid);
  if (!text) return {};
  return text->size() > kMost ? text->substr(text->size() - kMost) : *std::move(text);
}

}  // namespace cxlab::lab
