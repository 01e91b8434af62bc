// A laboratory in a program of one's own: plays a minute of a scenario into a folder, replays its rules, and compares
// what another number of robots is worth.
//
//   own_lab SCENARIO.yaml FOLDER

#include <lab/replay.h>
#include <lab/session.h>
#include <lab/sweep/sweep.h>
#include <lab/sweep/table.h>
#include <scenarios/shipped/catalogue.h>

#include <cstdio>

namespace {

int fail(const cxlab::Error& error) {
  std::fprintf(stderr, "error: %s\n", error.text().c_str());
  return static_cast<int>(error.kind);
}

/// Hears what there is to say to a person.
class Notes final : public cxlab::lab::ProgressSink {
 public:
  void progress(double, double) override {}
  void note(std::string_view text) override {
    std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: own_lab SCENARIO.yaml FOLDER\n");
    return 2;
  }
  namespace lab = cxlab::lab;
  const std::filesystem::path folder = argv[2];
  Notes notes;
  const lab::Host host{.progress = &notes};

  auto scenario = cxlab::Scenario::load(argv[1], cxlab::shipped());
  if (!scenario) return fail(scenario.error());
  lab::PlayOptions options;
  options.spec.until = 60;
  options.out = folder / "run";
  auto played = lab::play_scenario(options, *std::move(scenario), host);
  if (!played) return fail(played.error());
  if (played->failure) return fail(*played->failure);

  auto run = lab::Run::open(played->folder);
  if (!run) return fail(run.error());
  auto again = lab::replay_rules(*run, host);
  if (!again) return fail(again.error());
  std::printf("the replay %s\n", again->agrees() ? "agrees" : "differs");

  lab::Suite suite;
  suite.scenarios = {{"game", argv[1]}};
  suite.strategies = {{"three", {"duration_s=60"}}, {"one", {"duration_s=60", "world.robots=1"}}};
  suite.seeds = {1, 2};
  suite.tier = "timed";
  auto rows = lab::sweep(suite, {folder / "sweep", 2}, host);
  if (!rows) return fail(rows.error());
  std::fputs(lab::to_text(lab::table_of(*rows)).c_str(), stdout);
  return 0;
}
