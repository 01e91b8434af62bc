// Measures how much of the time of whole games each part takes. The parts are: physics, nodes beside the world (the
// PDDL manager with its planner), rules (facts from messages, and firing), and the rest (skill servers, factory,
// referee, files). Journals are written, as by `cxlab run`.
//
//   bench_shares SCENARIO SEED...   a file, or the name of a scenario that comes with cxlab; exit codes as of cxlab

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "cx/base/scratch_folder.h"
#include "lab/session.h"
#include "scenarios/share.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab {
namespace {

using Clock = std::chrono::steady_clock;

class Stopwatch final : public WallMeter {
 public:
  void begin() override { start_ = Clock::now(); }
  void end() override { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
  double seconds() const { return seconds_; }

 private:
  Clock::time_point start_;
  double seconds_ = 0;
};

struct Seconds {
  double all = 0, physics = 0, nodes = 0, rules = 0;
};

void need(const Status& status) {
  if (status) return;
  std::fprintf(stderr, "bench_shares: %s\n", status.error().text().c_str());
  std::exit(static_cast<int>(status.error().kind));
}

Seconds play(const std::string& name, const std::string& seed) {
  const auto file = find_scenario(name);
  need(file ? Status() : Status(file.error()));
  auto scenario = Scenario::load(*file, shipped(), {"seed=" + seed});
  need(scenario ? Status() : Status(scenario.error()));
  const auto folder = ScratchFolder::create();
  need(folder ? Status() : Status(folder.error()));
  Stopwatch nodes, rules;
  const auto played = lab::play_scenario(
      {.out = (*folder)->path() / "run", .meters = {.nodes = &nodes, .rules = &rules}}, *std::move(scenario));
  need(played ? Status() : Status(played.error()));
  if (played->failure) need(*played->failure);
  return {played->result.wall_time_s, played->result.physics_wall_s, nodes.seconds(), rules.seconds()};
}

void print(const std::string& name, const Seconds& s) {
  const double percent = 100 / s.all;
  std::printf("%-8s %7.2f %8.1f %6.1f %6.1f %6.1f\n", name.c_str(), s.all, percent * s.physics, percent * s.nodes,
              percent * s.rules, percent * (s.all - s.physics - s.nodes - s.rules));
}

}  // namespace
}  // namespace cxlab

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: bench_shares SCENARIO SEED...\n");
    return 2;
  }
  std::printf("seed      time s  physics %%  nodes %%  rules %%  rest %%\n");
  cxlab::Seconds sum;
  for (int i = 2; i < argc; ++i) {
    const cxlab::Seconds s = cxlab::play(argv[1], argv[i]);
    cxlab::print(argv[i], s);
    sum = {sum.all + s.all, sum.physics + s.physics, sum.nodes + s.nodes, sum.rules + s.rules};
  }
  cxlab::print("all", sum);
}
