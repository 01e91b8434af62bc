// cxlab test: plays stories, regression tests of rules.

#include <poll.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/coverage.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "lab/confine.h"
#include "lab/coverage.h"
#include "lab/failed_stories.h"
#include "lab/file_watch.h"
#include "lab/stories.h"
#include "lab/story_filter.h"
#include "lab/sweep/suite.h"
#include "lab/table_text.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

using lab::PlayedStory;

struct TestOptions {
  std::vector<std::string> paths;
  std::string filter, junit, runs;
  std::vector<std::string> limits;  // of rules and processes: options with their values
  lab::CoverageOptions coverage;
  std::optional<std::uint64_t> seed;
  lab::PackageOptions packages;
  double patience_s = 60;
  int jobs = 1;
  bool stop = false, load_once = false, last_failed = false, accept = false, quiet = false, verbose = false,
       watch = false, json = false;
};

// --- What a person reads

/// The command that plays this story again with the seed of its result, and no other; it has all options that may
/// change the result. For a file that cannot be read, it plays the file.
std::string again(const PlayedStory& story, const TestOptions& options) {
  std::string out = "cxlab test " + lab::shell_word(story.spec.file + (story.unreadable ? "" : "::" + story.spec.name));
  if (!story.spec.seeds.empty() || options.seed) out += " --seed " + std::to_string(story.seed);
  for (const std::string& package : options.packages.named) out += " --package " + lab::shell_word(package);
  for (const std::string& prefix : options.packages.prefixes) out += " --prefix " + lab::shell_word(prefix);
  for (const std::string& word : options.limits) out += ' ' + lab::shell_word(word);
  return out;
}

void print(const PlayedStory& p, const TestOptions& options) {
  if (options.quiet && p.passed()) return;
  const std::string seeds = p.seeds_played > 1 ? std::to_string(p.seeds_played) + " seeds, " : "";
  // The process of a story that did not end has not said how far it came.
  const std::string simulated = p.late ? std::string() : ", " + general_text(p.result.sim_time_s, 6) + " s simulated";
  if (p.unreadable)
    std::printf("FAILED  %s: cannot be read, so none of its stories was played\n", p.spec.file.c_str());
  else
    std::printf("%s  %s: %s (%s%.0f ms%s)\n", p.passed() ? "ok    " : "FAILED", p.spec.file.c_str(),
                p.spec.name.c_str(), seeds.c_str(), p.wall_s * 1e3, simulated.c_str());
  for (const std::string& c : p.complaints()) std::printf("  %s\n", c.c_str());
  for (const std::string& note : p.result.notes) std::printf("  note: %s\n", note.c_str());
  if (!p.passed() && !p.result.bad)
    std::printf("  seed %llu; again: %s\n", static_cast<unsigned long long>(p.seed), again(p, options).c_str());
  if (!p.run.empty()) {
    const std::string run = lab::shell_word(p.run.string());
    std::printf("  run %s; ask it: cxlab attach %s, cxlab why-not %s RULE\n", run.c_str(), run.c_str(), run.c_str());
  }
  if (options.verbose)
    for (const std::string& line : p.result.printed) std::printf("    %s\n", line.c_str());
  std::fflush(stdout);
}

Json json_of(const PlayedStory& p, const TestOptions& options) {
  Json row{{"file", p.spec.file},
           {"story", p.unreadable ? Json() : Json(p.spec.name)},
           {"passed", p.passed()},
           {"failures", p.complaints()},
           {"notes", p.result.notes},
           {"seed", p.seed},
           {"again", again(p, options)},
           {"wall_s", p.wall_s},
           {"sim_time_s", p.result.sim_time_s}};
  if (p.seeds_played > 1) {
    row["seeds_played"] = p.seeds_played;
    row["failed_seeds"] = p.failed_seeds;
  }
  if (p.accepted) row["accepted"] = p.spec.golden.string();
  if (!p.run.empty()) row["run"] = p.run.string();
  if (options.verbose) row["printed"] = p.result.printed;
  return row;
}

// --- Playing

/// The stories that the options choose.
Expected<std::vector<PlayedStory>> chosen(const TestOptions& options, const lab::StoryFilter& filter) {
  auto stories = lab::read_stories(options.paths.empty() ? std::vector<std::string>{"."} : options.paths);
  if (!stories) return stories;
  const std::size_t all = stories->size();
  std::erase_if(*stories, [&](const PlayedStory& story) {  // a file that cannot be read may have any stories
    return !story.unreadable &&
           !filter.takes(std::filesystem::path(story.spec.file).filename().string() + "::" + story.spec.name);
  });
  if (options.seed)
    for (PlayedStory& story : *stories) {
      story.spec.seed = *options.seed;
      if (!story.spec.seeds.empty()) story.spec.seeds = {*options.seed};
    }
  if (stories->empty())
    return usage_error("-k '" + options.filter + "': it holds for none of " + std::to_string(all) + " stories");
  return stories;
}

/// Keeps the stories that failed the last time; keeps all if none did.
void keep_last_failed(std::vector<PlayedStory>& stories, const lab::FailedStories& failed) {
  if (std::ranges::none_of(stories, [&](const PlayedStory& story) { return failed.has(story); }))
    std::fprintf(stderr, "nothing of this failed the last time: all is played\n");
  else
    std::erase_if(stories, [&](const PlayedStory& story) { return !story.unreadable && !failed.has(story); });
}

/// The setup of all stories.
Expected<lab::StoryPlan> plan_of(const TestOptions& options, const lab::Host& host) {
  auto packages = lab::find_packages(options.packages);
  if (!packages) return packages.error();
  lab::StoryPlan plan;
  plan.setup = {find_share().interfaces, options.coverage.asked(), *std::move(packages), host.limits(), own_packages()};
  plan.jobs = options.jobs;
  plan.stop_at_failure = options.stop;
  plan.load_once = options.load_once;
  plan.patience_s = options.patience_s;
  plan.runs = options.runs;
  plan.begins = [](const PlayedStory& story) {
    doing("playing story '" + story.spec.name + "' of " + story.spec.file);
  };
  if (!options.json) plan.ended = [&options](const PlayedStory& story) { print(story, options); };
  return plan;
}

struct Counts {
  std::size_t passed = 0, failed = 0, not_played = 0;
  bool bad = false;  ///< a story or a rule file cannot be used

  explicit Counts(const std::vector<PlayedStory>& stories) {
    for (const PlayedStory& p : stories) {
      ++(!p.played ? not_played : p.passed() ? passed : failed);
      bad |= p.result.bad.has_value();
    }
  }
  std::string text() const {
    return std::to_string(passed) + " passed, " + std::to_string(failed) + " failed" +
           (not_played > 0 ? ", " + std::to_string(not_played) + " not played" : "");
  }
  int exit_code() const {
    return bad ? static_cast<int>(ErrorKind::kInput) : failed > 0 ? static_cast<int>(ErrorKind::kNo) : 0;
  }
};

/// Plays them, and remembers which failed.
Status play(std::vector<PlayedStory>& stories, const lab::StoryPlan& plan, const lab::Host& host,
            const TestOptions& options) {
  if (Status s = lab::play_stories(stories, plan, host); !s) return s;
  if (options.accept) {
    lab::accept_golden_runs(stories, host);
    for (const PlayedStory& p : stories)
      if (p.result.differs && !options.json)
        std::printf(
            "%s  %s: %s: %s\n", p.accepted ? "accepted" : "kept    ", p.spec.file.c_str(), p.spec.name.c_str(),
            p.accepted ? (p.spec.golden.string() + " is the run of now").c_str() : p.result.failures.back().c_str());
  }
  lab::FailedStories failed = lab::FailedStories::remembered();
  failed.note(stories);
  if (Status s = failed.save(); !s)
    std::fprintf(stderr, "warning: --last-failed will not know of this: %s\n", printable(s.error().text()).c_str());
  return {};
}

Status write_reports(const std::vector<PlayedStory>& stories, const explain::Coverage& coverage,
                     const TestOptions& options) {
  if (!options.junit.empty()) {
    const auto junit = lab::to_junit(stories, options.verbose);
    if (!junit) return junit.error();
    if (Status s = write_output(options.junit, *junit); !s) return s;
  }
  return lab::write_reports(
      coverage, options.coverage, {}, {},
      stories.size() == 1 ? "Coverage of a story" : "Coverage of " + std::to_string(stories.size()) + " stories");
}

int play_once(std::vector<PlayedStory>& stories, const lab::StoryPlan& plan, const lab::Host& host,
              const TestOptions& options) {
  if (Status s = play(stories, plan, host, options); !s) return fail(s.error());
  if (signal_that_came() != 0) return interrupted("not all stories were played");
  const Counts counts(stories);
  const explain::Coverage coverage = lab::coverage_of(stories);
  if (options.json) {
    Json report{{"passed", counts.passed}, {"failed", counts.failed}, {"stories", Json::array()}};
    if (counts.not_played > 0) report["not_played"] = counts.not_played;
    for (const PlayedStory& p : stories)
      if (p.played) report["stories"].push_back(json_of(p, options));
    if (plan.setup.coverage) report.update(lab::json_of(coverage));
    std::printf("%s\n", json_text(report, 2).c_str());
  } else {
    if (plan.setup.coverage) std::fputs(explain::text_of(coverage).c_str(), stdout);
    std::printf("%s\n", counts.text().c_str());
  }
  if (plan.setup.coverage)
    for (const std::string& note : lab::notes_on_coverage(stories))
      std::fprintf(stderr, "note: %s\n", printable(note).c_str());
  if (Status s = write_reports(stories, coverage, options); !s) return fail(s.error());
  if (const int code = counts.exit_code(); code != 0) return code;
  const Status enough = lab::check_share(coverage, options.coverage);
  return enough ? 0 : fail(enough.error());
}

// --- Playing again what a change affects

std::int64_t clock_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

using Paths = std::set<std::filesystem::path>;

class Watching {
 public:
  Watching(const TestOptions& options, const lab::StoryFilter& filter, const lab::StoryPlan& plan,
           const lab::Host& host)
      : options_(options), filter_(filter), plan_(plan), host_(host) {}

  int watch(std::vector<PlayedStory> stories) {
    std::vector<PlayedStory> turn = std::move(stories);
    (void)new_files();
    while (true) {
      const std::int64_t begun = clock_ns();
      if (!turn.empty()) {
        if (Status s = play(turn, plan_, host_, options_); !s) return fail(s.error());
        for (const PlayedStory& story : turn) note(story);
      }
      if (signal_that_came() != 0) break;
      files_.watch(all_files(), begun);
      std::printf("%swatching %s, Ctrl-C ends\n", turn.empty() ? "" : (Counts(turn).text() + "; ").c_str(),
                  lab::count_text(files_.size(), "file").c_str());
      std::fflush(stdout);
      doing({});
      const Paths changed = wait();
      if (signal_that_came() != 0) break;
      turn = affected(changed);
    }
    return interrupted("no file is watched any more");
  }

 private:
  using Key = std::pair<std::string, std::string>;  // file, name
  static Key key_of(const PlayedStory& story) { return {story.spec.file, story.spec.name}; }
  static std::filesystem::path whole(const std::string& file) {
    return std::filesystem::absolute(file).lexically_normal();
  }

  void note(const PlayedStory& story) {
    if (!story.played) return;
    Paths files(story.result.files.begin(), story.result.files.end());
    if (story.result.bad && !story.result.bad->file.empty()) files.insert(whole(story.result.bad->file));
    // One whose process died has not told what it read: what it read before, or anything.
    if (!story.result.files.empty())
      read_[key_of(story)] = std::move(files);
    else
      read_.try_emplace(key_of(story));
    files_of_stories_.insert(whole(story.spec.file));
  }

  Paths all_files() const {
    Paths all = files_of_stories_;
    for (const auto& [story, files] : read_) all.insert(files.begin(), files.end());
    return all;
  }

  /// The present stories that read one of these files, or are new.
  std::vector<PlayedStory> affected(const Paths& now_changed) {
    changed_.insert(now_changed.begin(), now_changed.end());
    for (const std::filesystem::path& file : now_changed)
      std::printf("\n%s %s\n", file.lexically_proximate(std::filesystem::current_path()).c_str(),
                  path_exists(file) ? "has changed" : "was removed");
    std::erase_if(files_of_stories_, [](const std::filesystem::path& file) { return !path_exists(file); });
    auto stories = chosen(options_, filter_);
    if (!stories) {
      fail(stories.error());
      if (!stories.error().file.empty()) files_of_stories_.insert(whole(stories.error().file));
      return {};
    }
    const Paths changed = std::exchange(changed_, {});
    std::set<Key> there;
    for (const PlayedStory& story : *stories) there.insert(key_of(story));
    std::erase_if(read_, [&](const auto& story) { return !there.contains(story.first); });
    std::erase_if(*stories, [&](const PlayedStory& story) {
      const auto read = read_.find(key_of(story));
      if (read == read_.end() || read->second.empty() || changed.contains(whole(story.spec.file))) return false;
      return std::ranges::none_of(read->second, [&](const auto& file) { return changed.contains(file); });
    });
    return *std::move(stories);
  }

  /// The files that have changed, or story files that are new.
  Paths wait() {
    constexpr int kLooks = 5;  // at the files, before folders are read again
    for (int look = 1;; ++look) {
      (void)poll(nullptr, 0, 100);
      if (signal_that_came() != 0) return {};
      Paths changed = files_.changed();
      if (look % kLooks == 0)
        for (const std::filesystem::path& file : new_files()) changed.insert(file);
      if (!changed.empty()) return changed;
    }
  }

  Paths new_files() {
    Paths out;
    const auto files = lab::story_files(options_.paths.empty() ? std::vector<std::string>{"."} : options_.paths);
    if (files)
      for (const std::filesystem::path& file : *files)
        if (files_of_stories_.insert(whole(file.string())).second) out.insert(whole(file.string()));
    return out;
  }

  const TestOptions& options_;
  const lab::StoryFilter& filter_;
  const lab::StoryPlan& plan_;
  const lab::Host& host_;
  lab::FileWatch files_;
  std::map<Key, Paths> read_;  // by story
  Paths files_of_stories_;
  Paths changed_;  // and not looked at, because stories could not be read
};

int test(const TestOptions& options) {
  const auto filter =
      options.filter.empty() ? Expected<lab::StoryFilter>(lab::StoryFilter()) : lab::StoryFilter::parse(options.filter);
  if (!filter) return fail(filter.error());
  auto stories = chosen(options, *filter);
  if (!stories) return fail(stories.error());
  if (options.last_failed) keep_last_failed(*stories, lab::FailedStories::remembered());
  if (options.load_once)
    for (const PlayedStory& story : *stories)
      if (!story.spec.golden.empty())
        return fail(usage_error("--load-once: the story '" + story.spec.name + "' of " + story.spec.file +
                                " is a golden run, which is played alone: leave it out with -k, or --load-once away"));
  Console console(true);
  if (options.quiet) stop_reporting();
  const lab::Host host = console.host();
  const auto plan = plan_of(options, host);
  if (!plan) return fail(plan.error());
  if (const auto warning = lab::warning_without_wall()) std::fprintf(stderr, "%s\n", warning->c_str());
  if (options.watch) return Watching(options, *filter, *plan, host).watch(*std::move(stories));
  return play_once(*stories, *plan, host, options);
}

}  // namespace

void add_test(CLI::App& app, Action& action) {
  auto options = std::make_shared<TestOptions>();
  CLI::App* command = app.add_subcommand("test", "Play stories: regression tests of rules (docs/reference/stories.md)");
  command->footer(
      "Exit code 0: all passed; 1: a story failed, or fewer rules fired than --fail-under says; 2: no story is "
      "chosen;\n"
      "3: a story file or a rule file cannot be used; 5: a report cannot be written; 130, 143: SIGINT (Ctrl-C) or\n"
      "SIGTERM ended it.\n"
      "EXPR is a word that the name of a story or of its file contains, or several words with `and`, `or`, `not` and\n"
      "parentheses. The file $XDG_STATE_HOME/cxlab/failed_stories.json (~/.local/state/cxlab/...) keeps the stories\n"
      "that failed the last time.\n"
      "Examples:\n  cxlab test scenarios/rcll/agent/stories --junit report.xml\n"
      "  cxlab test -k 'pick and not (slow or \"two robots\")' -x\n"
      "  cxlab test 'stories/door.story.yaml::a bell opens the door' -v\n"
      "  cxlab test --last-failed --keep-runs runs; cxlab why-not runs/door-a-bell-opens-the-door open\n"
      "  cxlab test --watch");
  add_limit_options(*command);
  command->add_option("paths", options->paths,
                      "Story files, folders with *.story.yaml (default: this folder), or FILE::NAME for one story");
  add_package_options(*command, options->packages);
  command->add_option("-k", options->filter, "Plays the stories for which this holds, as pytest -k does")
      ->type_name("EXPR");
  command->add_flag("-x", options->stop, "Stops after the first story that fails");
  command->add_flag("--last-failed,--lf", options->last_failed,
                    "Plays the stories that failed the last time, or all if none failed");
  command->add_flag("-q", options->quiet, "Names only stories that fail");
  command->add_flag("-v", options->verbose, "Shows what the agent of each story printed")->excludes("-q");
  command
      ->add_option("--patience", options->patience_s,
                   "Wall time that a story may take, s (default 60); a slower story fails")
      ->check(positive());
  command
      ->add_option("--keep-runs", options->runs,
                   "Keeps the run of each story that fails in a folder below DIR, for why-not, attach, ...")
      ->type_name("DIR");
  seed_number(command->add_option("--seed", options->seed, "Plays the stories with this seed alone"));
  command->add_option("--junit", options->junit, "Writes a JUnit report, and makes its folder if it is missing");
  command->add_option(
      "--coverage", options->coverage.lcov,
      "Reports which rules fired, how far conditions got, and what was called; writes the counts as lcov");
  add_coverage(*command, "--coverage-page", options->coverage);
  whole_number(command->add_option("-j,--jobs", options->jobs, "Processes"), 1, 256);
  command
      ->add_flag("--load-once", options->load_once,
                 "Loads each agent once for all of its stories, and plays these one after the other")
      ->excludes("--jobs")
      ->excludes("--keep-runs");
  command->add_flag("--json", options->json, "Prints JSON");
  command->add_flag("--accept", options->accept,
                    "Replaces golden runs that differ by the new runs; look at the difference first");
  command->add_flag("--watch", options->watch, "Plays again what a changed rule or story file affects, until Ctrl-C")
      ->excludes("--json")
      ->excludes("--accept")
      ->excludes("--load-once")
      ->excludes("--junit")
      ->excludes("--coverage")
      ->excludes("--coverage-page")
      ->excludes("--fail-under");
  command->callback([command, options, &action] {
    options->limits = given_options(*command, {"--memory", "--disk", "--steps", "--patience"});
    action = [options] { return test(*options); };
  });
}

}  // namespace cxlab::app
