#include "lab/time_travel.h"

#include <cstdio>
#include <utility>

#include "lab/control/debugger.h"
#include "lab/moment.h"
#include "lab/scene_answer.h"

namespace cxlab::lab {

namespace {

Status serve(const Run& run, const ControlAddress& address, Host host) {
  auto server = ControlServer::open(address);
  if (!server) return server.error();
  Debugger::Options options;
  options.recorded = true;
  Debugger debugger(**server, std::move(options));
  const std::atomic<bool>* const stop = std::exchange(host.stop, &debugger.gives_up());
  host.log = &debugger;
  host.progress = nullptr;
  auto opened = Moment::open(run, host, {.control = &debugger});
  if (!opened) return opened.error();
  Moment& moment = **opened;
  debugger.watch([&moment] { return moment.episode().environments(); },
                 [&moment](cx::Environment& environment) { return moment.inspector(environment); },
                 [&moment](const std::string& what) -> Expected<std::string> {
                   auto seen = moment.scene();
                   if (!seen) return seen.error();
                   return scene_text(*std::move(seen), what);
                 });
  while (!debugger.has_left() && !(stop && *stop)) {
    debugger.begin_again();
    const Status played = moment.seek(std::nullopt);
    if (!debugger.gives_up()) debugger.stay_at_end(moment.t(), played);
    if (debugger.has_left()) break;
    if (Status s = moment.rewind(); !s) return s;
  }
  return {};
}

}  // namespace

Expected<std::unique_ptr<TimeTravel>> TimeTravel::start(const Run& run, const Host& host) {
  auto folder = ScratchFolder::create();
  if (!folder) return folder.error();
  ControlAddress address{.path = ((*folder)->path() / "control.sock").string()};
  auto process = Process::fork({}, [&] {
    const Status served = serve(run, address, host);
    if (served) return 0;
    std::fprintf(stderr, "error: %s\n", served.error().text().c_str());
    return static_cast<int>(served.error().kind);
  });
  if (!process) return process.error();
  return std::unique_ptr<TimeTravel>(new TimeTravel(*std::move(folder), std::move(address), *std::move(process)));
}

}  // namespace cxlab::lab
