// cxlab test: plays stories, regression tests of rules.

#include <cstdio>
#include <map>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/confine.h"
#include "lab/stories.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

using lab::Coverage;
using lab::PlayedStory;

struct TestOptions {
  std::vector<std::string> paths;
  std::string junit, coverage;
  lab::PackageOptions packages;
  int jobs = 1;
  bool json = false;
};

void print(const Coverage& files) {
  std::map<std::string, int> counts;
  for (const auto& [file, rules] : files)
    for (const auto& [rule, covered] : rules) {
      ++counts[covered.state()];
      if (covered.fired == 0)
        std::printf("%s:%d: %s: %s\n", file.c_str(), rule.first, rule.second.c_str(), covered.state());
    }
  std::printf("rules: %d fired, %d activated but never fired, %d never matched\n", counts["fired"],
              counts["activated but never fired"], counts["never matched"]);
}

void print(const PlayedStory& p) {
  std::printf("%s  %s: %s (%.0f ms, %.6g s simulated)\n", p.result.passed() ? "ok    " : "FAILED", p.spec.file.c_str(),
              p.spec.name.c_str(), p.wall_s * 1e3, p.result.sim_time_s);
  for (const std::string& c : p.complaints()) std::printf("  %s\n", c.c_str());
  for (const std::string& note : p.result.notes) std::printf("  note: %s\n", note.c_str());
}

/// One by one, so that a person can see which one takes long.
Status play(std::vector<PlayedStory>& stories, const testing::StorySetup& setup, int jobs, const lab::Host& host) {
  if (jobs > 1) return lab::play_stories(stories, setup, jobs, host);
  for (PlayedStory& story : stories) {
    if (host.stopped()) break;
    doing("playing story '" + story.spec.name + "' of " + story.spec.file);
    std::vector<PlayedStory> one;
    one.push_back(std::move(story));
    Status played = lab::play_stories(one, setup, 1, host);
    story = std::move(one.front());
    if (!played) return played;
  }
  return {};
}

int test(const TestOptions& options) {
  auto stories = lab::read_stories(options.paths.empty() ? std::vector<std::string>{"."} : options.paths);
  if (!stories) return fail(stories.error());
  auto packages = lab::find_packages(options.packages);
  if (!packages) return fail(packages.error());
  if (const auto warning = lab::warning_without_wall()) std::fprintf(stderr, "%s\n", warning->c_str());
  Console console(true);
  const lab::Host host = console.host();
  const testing::StorySetup setup{find_share().interfaces, !options.coverage.empty(), *std::move(packages),
                                  host.limits(), own_packages()};
  if (Status s = play(*stories, setup, options.jobs, host); !s) return fail(s.error());
  if (signal_that_came() != 0) {
    for (const PlayedStory& p : *stories)
      if (p.wall_s > 0) print(p);  // the last one has what it was stopped in
    return interrupted("not all stories were played");
  }
  std::size_t passed = 0;
  bool bad = false;
  Json rows = Json::array();
  for (const PlayedStory& p : *stories) {
    passed += p.result.passed();
    bad |= p.result.bad.has_value();
    if (!options.json) print(p);
    rows.push_back({{"file", p.spec.file},
                    {"story", p.spec.name},
                    {"passed", p.result.passed()},
                    {"failures", p.complaints()},
                    {"notes", p.result.notes},
                    {"wall_s", p.wall_s},
                    {"sim_time_s", p.result.sim_time_s}});
  }
  const Coverage coverage = lab::coverage_of(*stories);
  Json report{{"passed", passed}, {"failed", stories->size() - passed}, {"stories", rows}};
  if (setup.coverage) report["rules"] = parse_json(lab::to_json(coverage));
  if (setup.coverage && !options.json) print(coverage);
  if (options.json)
    std::printf("%s\n", json_text(report, 2).c_str());
  else
    std::printf("%zu passed, %zu failed\n", passed, stories->size() - passed);
  if (!options.junit.empty()) {
    const auto junit = lab::to_junit(*stories);
    if (!junit) return fail(junit.error());
    if (Status s = write_file(options.junit, *junit); !s) return fail(s.error());
  }
  if (!options.coverage.empty()) {
    const auto lcov = lab::to_lcov(coverage);
    if (!lcov) return fail(lcov.error());
    if (Status s = write_file(options.coverage, *lcov); !s) return fail(s.error());
  }
  if (bad) return static_cast<int>(ErrorKind::kInput);
  return passed == stories->size() ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_test(CLI::App& app, Action& action) {
  auto options = std::make_shared<TestOptions>();
  CLI::App* command = app.add_subcommand("test", "Plays stories: regression tests of rules (docs/testing.md)");
  command->footer("Example:\n  cxlab test scenarios/rcll/agent/stories --junit report.xml");
  add_limit_options(*command);
  command->add_option("paths", options->paths, "Story files, or folders with *.story.yaml (default: this folder)");
  add_package_options(*command, options->packages);
  command->add_option("--junit", options->junit, "Writes a JUnit report");
  command->add_option("--coverage", options->coverage,
                      "Says which rules fired, were only activated, or never matched; writes the counts as lcov");
  whole_number(command->add_option("-j", options->jobs, "Processes"), 1, 256);
  command->add_flag("--json", options->json, "Prints JSON");
  command->callback([options, &action] { action = [options] { return test(*options); }; });
}

}  // namespace cxlab::app
