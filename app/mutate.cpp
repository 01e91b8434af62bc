// cxlab mutate: how well the stories of an agent bite.

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/coverage.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "lab/confine.h"
#include "lab/mutate.h"
#include "lab/story_filter.h"
#include "lab/table_text.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

using lab::Fate;
using lab::Mutant;
using lab::Mutation;
using lab::PlayedMutant;

struct MutateOptions {
  std::string agent, filter, mutant, show;
  std::vector<std::string> files;
  std::int64_t mutants = 200;
  std::uint64_t seed = 1;
  double time_limit_s = 0, patience_s = 0;
  std::optional<double> fail_under;
  lab::PackageOptions packages;
  int jobs = 1;
  bool all = false, list = false, quiet = false, verbose = false, json = false;
};

std::string percent(double share) { return fixed_text(100 * share, 1) + " %"; }

std::string number_of(std::size_t n, const std::string& what) {
  return std::to_string(n) + ' ' + what + (n == 1 ? "" : "s");
}

std::string stories_text(std::size_t n) { return std::to_string(n) + (n == 1 ? " story" : " stories"); }

// --- Mutants

Json json_of(const Mutation& mutation, const Mutant& mutant) {
  const std::string place = mutation.place_of(mutant);
  return {{"id", mutant.id},
          {"file", place.substr(0, place.rfind(':'))},
          {"line", mutant.line},
          {"construct", mutant.kind + ' ' + mutant.construct},
          {"change", to_string(mutant.change)},
          {"before", mutant.before},
          {"after", mutant.after}};
}

std::string line_of(const Mutation& mutation, const Mutant& mutant) {
  return mutant.id + "  " + mutation.place_of(mutant) + ": " + mutant.construct + ": " + mutant.what();
}

int list_mutants(const Mutation& mutation, const MutateOptions& options) {
  Json rows = Json::array();
  for (const Mutant& mutant : mutation.mutants()) {
    if (options.json)
      rows.push_back(json_of(mutation, mutant));
    else
      std::printf("%s\n", line_of(mutation, mutant).c_str());
  }
  if (options.json) std::printf("%s\n", json_text(rows, 2).c_str());
  return 0;
}

int show_mutant(const Mutation& mutation, const std::string& id) {
  const auto found = mutation.find(id);
  if (!found) return fail(found.error());
  const Mutant& mutant = mutation.mutants()[*found];
  std::fputs(diff_of(mutation.file_of(mutant), mutant).c_str(), stdout);
  return 0;
}

/// "fires in a.story.yaml::one, b.story.yaml::two and 3 more"
std::string reach_text(const std::vector<std::string>& stories) {
  constexpr std::size_t kMost = 2;
  if (stories.empty()) return "no story fires it";
  std::string out = "fires in ";
  for (std::size_t i = 0; i < std::min(kMost, stories.size()); ++i) out += (i > 0 ? ", " : "") + stories[i];
  return out + (stories.size() > kMost ? " and " + std::to_string(stories.size() - kMost) + " more" : "");
}

int play_one(const Mutation& mutation, const MutateOptions& options, const lab::Host& host) {
  const auto found = mutation.find(options.mutant);
  if (!found) return fail(found.error());
  const Mutant& mutant = mutation.mutants()[*found];
  const auto stories = mutation.play_one(mutant, host);
  if (!stories) return fail(stories.error());
  if (const int code = interrupted("not all stories were played")) return code;
  Json failed = Json::array();
  std::size_t fail_count = 0;
  bool late = false;
  for (const lab::PlayedStory& story : *stories) {
    if (story.passed()) continue;
    ++fail_count;
    late |= story.late;
    failed.push_back({{"file", story.spec.file}, {"story", story.spec.name}, {"failures", story.complaints()}});
  }
  const bool survived = fail_count == 0;
  if (options.json) {
    Json row = json_of(mutation, mutant);
    row["verdict"] = to_string(survived ? Fate::kSurvived : late ? Fate::kTimedOut : Fate::kKilled);
    row["diff"] = diff_of(mutation.file_of(mutant), mutant);
    row["reached_by"] = mutation.reached_by(mutant);
    row["failed"] = std::move(failed);
    std::printf("%s\n", json_text(row, 2).c_str());
  } else {
    std::fputs(diff_of(mutation.file_of(mutant), mutant).c_str(), stdout);
    for (const lab::PlayedStory& story : *stories)
      if (!story.passed())
        std::printf("FAILED  %s: %s\n  %s\n", story.spec.file.c_str(), story.spec.name.c_str(),
                    story.complaints().front().c_str());
    if (survived)
      std::printf("survived: %s that can notice it %s; %s\n",
                  (stories->size() == 1 ? "the only story" : "all " + stories_text(stories->size())).c_str(),
                  stories->size() == 1 ? "passes" : "pass", reach_text(mutation.reached_by(mutant)).c_str());
    else
      std::printf("killed by %zu of %zu stories\n", fail_count, stories->size());
  }
  return survived ? static_cast<int>(ErrorKind::kNo) : 0;
}

// --- The score

/// By kind of change: how many were played, and how many survived.
std::map<lab::Change, std::pair<std::size_t, std::size_t>> by_change(const Mutation& mutation,
                                                                     const lab::MutationResult& result) {
  std::map<lab::Change, std::pair<std::size_t, std::size_t>> out;
  for (const PlayedMutant& played : result.played) {
    auto& [count, survived] = out[mutation.mutants()[played.mutant].change];
    ++count;
    survived += played.fate == Fate::kSurvived;
  }
  return out;
}

void print_json(const Mutation& mutation, const lab::MutationResult& result, const MutateOptions& options) {
  Json report{{"score", result.score()},
              {"mutants", result.played.size()},
              {"wanted", result.wanted},
              {"possible", mutation.mutants().size()},
              {"killed", result.count(Fate::kKilled)},
              {"timed_out", result.count(Fate::kTimedOut)},
              {"survived", result.count(Fate::kSurvived)},
              {"not_loaded", result.not_loaded},
              {"seed", options.seed},
              {"stories", mutation.stories().size()},
              {"changes", Json::object()},
              {"results", Json::array()}};
  if (const auto interval = result.interval()) report["interval_95"] = {interval->low, interval->high};
  for (const auto& [change, counts] : by_change(mutation, result))
    report["changes"][to_string(change)] = {{"mutants", counts.first}, {"survived", counts.second}};
  for (const PlayedMutant& played : result.played) {
    const Mutant& mutant = mutation.mutants()[played.mutant];
    Json row = json_of(mutation, mutant);
    row["verdict"] = to_string(played.fate);
    row["reached_by"] = mutation.reached_by(mutant);
    if (played.fate != Fate::kSurvived) {
      row["killed_by"] = played.killer;
      row["failure"] = played.complaint;
    }
    report["results"].push_back(std::move(row));
  }
  std::printf("%s\n", json_text(report, 2).c_str());
}

void print_text(const Mutation& mutation, const lab::MutationResult& result, const MutateOptions& options) {
  std::size_t unreached = 0;
  for (const PlayedMutant& played : result.played) {
    const Mutant& mutant = mutation.mutants()[played.mutant];
    const bool survived = played.fate == Fate::kSurvived;
    if (!survived && !options.verbose) continue;
    const std::vector<std::string> reached = survived ? mutation.reached_by(mutant) : std::vector<std::string>();
    unreached += survived && reached.empty();
    std::printf("%-8s  %s\n", survived ? "SURVIVED" : to_string(played.fate), line_of(mutation, mutant).c_str());
    std::printf("  %s\n", survived ? reach_text(reached).c_str() : played.complaint.c_str());
  }
  const std::size_t survived = result.count(Fate::kSurvived), late = result.count(Fate::kTimedOut);
  std::printf("%s of %zu possible changes: %zu killed", number_of(result.played.size(), "mutant").c_str(),
              mutation.mutants().size(), result.count(Fate::kKilled));
  if (late > 0) std::printf(", %zu timed out", late);
  std::printf(", %zu survive", survived);
  if (unreached > 0) std::printf(" (%zu in what no story fires)", unreached);
  if (result.not_loaded > 0)
    std::printf("; %s did not load and %s not count", number_of(result.not_loaded, "change").c_str(),
                result.not_loaded == 1 ? "does" : "do");
  std::printf("\n");
  if (survived > 0) {
    std::string text = "survivors by change:";
    for (const auto& [change, counts] : by_change(mutation, result))
      if (counts.second > 0)
        text += std::string(text.ends_with(':') ? " " : ", ") + to_string(change) + ' ' +
                std::to_string(counts.second) + " of " + std::to_string(counts.first);
    std::printf("%s\n", text.c_str());
  }
  const auto interval = result.interval();
  if (result.played.empty()) return;
  std::printf("score %s%s\n", percent(result.score()).c_str(),
              interval ? (" (95 % interval " + percent(interval->low) + " to " + percent(interval->high) + "; seed " +
                          std::to_string(options.seed) + ')')
                             .c_str()
                       : "");
}

int play_drawn(const Mutation& mutation, const MutateOptions& options, const lab::Host& host, Console& console) {
  lab::MutationDraw draw;
  draw.mutants = options.all ? 0 : static_cast<std::size_t>(options.mutants);
  draw.seed = options.seed;
  draw.time_limit_s = options.time_limit_s;
  doing("playing mutants");
  draw.progress = [&console](const lab::MutationProgress& now) {
    std::string text = std::to_string(now.done) + " of " + number_of(now.total, "mutant") + ", " +
                       std::to_string(now.survived) + " survive, " + std::to_string(now.playing) + " at play";
    if (now.seconds_left) text += ", " + fixed_text(*now.seconds_left, 0) + " s left";
    console.share_done(now.total > 0 ? static_cast<double>(now.done) / static_cast<double>(now.total) : 0, text);
  };
  const auto result = mutation.play(draw, host);
  console.clear();
  if (!result) return fail(result.error());
  if (options.json)
    print_json(mutation, *result, options);
  else
    print_text(mutation, *result, options);
  std::fflush(stdout);
  const std::string finished = std::to_string(result->played.size()) + " of " + number_of(result->wanted, "mutant") +
                               (result->played.size() == 1 ? " was played" : " were played");
  if (const int code = interrupted(finished)) return code;
  if (result->played.size() < result->wanted && !options.quiet)
    std::fprintf(stderr, "note: %s before the time limit\n", finished.c_str());
  if (options.fail_under && 100 * result->score() < *options.fail_under)
    return fail(negative("the score is " + percent(result->score()) + ", expected at least " +
                         general_text(*options.fail_under, 6) + " % (--fail-under)"));
  return 0;
}

int mutate(const MutateOptions& options) {
  const auto filter =
      options.filter.empty() ? Expected<lab::StoryFilter>(lab::StoryFilter()) : lab::StoryFilter::parse(options.filter);
  if (!filter) return fail(filter.error());
  auto subject = lab::mutation_subject(options.agent, catalogue());
  if (!subject) return fail(subject.error());
  const std::size_t stories = subject->stories.size();
  std::erase_if(subject->stories, [&](const lab::PlayedStory& story) {
    return !filter->takes(std::filesystem::path(story.spec.file).filename().string() + "::" + story.spec.name);
  });
  if (subject->stories.empty())
    return fail(
        usage_error("-k '" + options.filter + "': it holds for none of " + std::to_string(stories) + " stories"));
  auto packages = lab::find_packages(options.packages);
  if (!packages) return fail(packages.error());
  Console console(options.quiet);
  if (options.quiet) stop_reporting();
  const lab::Host host = console.host();
  if (const auto warning = lab::warning_without_wall()) std::fprintf(stderr, "%s\n", warning->c_str());
  lab::StoryPlan plan;
  plan.setup = {find_share().interfaces, false, *std::move(packages), host.limits(), own_packages()};
  plan.jobs = options.jobs;
  plan.patience_s = options.patience_s;
  plan.begins = [](const lab::PlayedStory& story) {
    doing("playing story '" + story.spec.name + "' of " + story.spec.file);
  };
  if (options.list || !options.show.empty()) {
    const auto mutation = Mutation::load(*std::move(subject), options.files, std::move(plan), host);
    if (!mutation) return fail(mutation.error());
    if (const int code = interrupted("not all agents were loaded")) return code;
    return options.list ? list_mutants(*mutation, options) : show_mutant(*mutation, options.show);
  }
  const auto mutation = Mutation::prepare(*std::move(subject), options.files, std::move(plan), host);
  if (!mutation) return fail(mutation.error());
  if (const int code = interrupted("no mutant was played")) return code;
  if (!options.quiet) {
    console.note(stories_text(mutation->stories().size()) +
                 (mutation->stories().size() == 1 ? " passes in " : " pass in ") +
                 fixed_text(mutation->stories_s(), 1) + " s; " + number_of(mutation->files(), "rule file") + " with " +
                 number_of(mutation->mutants().size(), "possible change"));
    if (mutation->golden() > 0)
      console.note(number_of(mutation->golden(), "golden run") + " left out, which any change of a rule kills");
  }
  if (!options.mutant.empty()) return play_one(*mutation, options, host);
  return play_drawn(*mutation, options, host, console);
}

}  // namespace

void add_mutate(CLI::App& app, Action& action) {
  auto options = std::make_shared<MutateOptions>();
  CLI::App* command = app.add_subcommand(
      "mutate", "Change rules one by one and count how often a story fails (docs/how-to/measure-stories.md)");
  command->footer(
      "A mutant is the agent with one small change. It lacks a condition, constraint, action or slot; or it has "
      "another\n"
      "comparison, number, symbol or salience; or `and` is `or`, or a condition is negated. A mutant is killed if a\n"
      "story fails or does not end. A mutant that survives shows behaviour that no story tests: write that story, or\n"
      "remove what is not needed. Changes whose rules do not load do not count; others are drawn instead. No file is\n"
      "changed. The comment `; mutate: skip` at the end of a line, or above it, spares whatever begins on that line.\n"
      "On the first line of a rule or function it spares all of it.\n"
      "Exit code 0: done; 1: the score is below --fail-under, a story fails without any change, or --mutant survives;\n"
      "2: usage; 3: a story file or a rule file cannot be used; 130: Ctrl-C, after what was finished.\n"
      "Examples:\n  cxlab mutate scenarios/rcll/agent -j 2\n"
      "  cxlab mutate params/agent.yaml --mutants 500 --seed 3 --time-limit 600 --fail-under 85\n"
      "  cxlab mutate my_agent --file clips/doors.clp --all -k door\n"
      "  cxlab mutate my_agent --mutant 3fa1c09e; cxlab mutate my_agent --show 3fa1c09e");
  add_limit_options(*command);
  command
      ->add_option("agent", options->agent,
                   "A folder with stories, a configuration, a scenario, a story file, or FILE::NAME")
      ->required()
      ->type_name("AGENT");
  CLI::Option* mutants =
      whole_number(command->add_option("--mutants", options->mutants, "Mutants to draw and play (default 200)"), 1);
  mutants->type_name("N");
  CLI::Option* all = command->add_flag("--all", options->all, "Plays all mutants")->excludes(mutants);
  seed_number(
      command->add_option("--seed", options->seed, "Seed of the draw (default 1): the same mutants for any -j"));
  command
      ->add_option(
          "--time-limit", options->time_limit_s,
          "Begins no other mutant after so many seconds; the first play of the stories without a mutant does not count")
      ->check(positive())
      ->type_name("S");
  whole_number(command->add_option("-j,--jobs", options->jobs, "Mutants at once"), 1, 256);
  command->add_option("-k", options->filter, "Plays only the stories for which this holds, as cxlab test -k does")
      ->type_name("EXPR");
  once_each(command->add_option("--file", options->files, "Changes only this rule file, or those of this folder"))
      ->type_name("FILE");
  CLI::Option* one =
      command->add_option("--mutant", options->mutant, "Plays one mutant with all stories")->type_name("ID");
  CLI::Option* show =
      command->add_option("--show", options->show, "Shows a mutant as a diff of its file")->type_name("ID");
  CLI::Option* list = command->add_flag("--list", options->list, "Lists all mutants and plays none");
  CLI::Option* fail_under =
      add_fail_under(*command, options->fail_under, "Exit code 1 if fewer percent of the mutants die");
  command
      ->add_option("--patience", options->patience_s,
                   "Wall time that a story may take, s (default 2 s and ten times the slowest story)")
      ->check(positive());
  add_package_options(*command, options->packages);
  command->add_flag("-q,--quiet", options->quiet, "Prints no progress");
  command->add_flag("-v", options->verbose, "Also lists mutants that died, with the message of the story");
  command->add_flag("--json", options->json, "Prints JSON")->excludes(show);
  const std::array modes{one, show, list};
  for (std::size_t i = 0; i < modes.size(); ++i) {
    for (std::size_t j = i + 1; j < modes.size(); ++j) modes[i]->excludes(modes[j]);
    for (CLI::Option* other : {mutants, all, fail_under}) modes[i]->excludes(other);
  }
  command->callback([options, &action] { action = [options] { return mutate(*options); }; });
}

}  // namespace cxlab::app
