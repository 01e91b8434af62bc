#include "lab/golden.h"

#include <vector>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "cx/journal/run_folder.h"
#include "lab/child.h"
#include "lab/comparison.h"
#include "lab/coverage_of_runs.h"
#include "lab/rerun.h"
#include "lab/run.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

constexpr const char* kError = "error.txt";

Status play_again(const testing::StorySpec& story, const fs::path& folder, const Host& host) {
  auto run = Run::open(story.golden);
  if (!run) return run.error();
  if (!run->finished)
    return input_error("the golden run is not finished: it is still being played, or it was killed",
                       run->folder.string());
  if (story.end > run->sim_time)
    return input_error("end: " + general_text(to_seconds(story.end), 9) + " s is after the end of the golden run, " +
                       general_text(to_seconds(run->sim_time), 9) + " s");
  RerunOptions options;
  options.out = folder.string();
  options.force = true;
  options.from_copies = false;  // they go as they went, whatever the files are now
  if (story.end > SimTime::zero()) options.until = to_seconds(story.end);
  const auto again = rerun(*run, options, host);
  return again ? Status() : again.error();
}

/// The differences, in lines; empty if the run goes as its golden run.
Expected<std::vector<std::string>> difference(const testing::StorySpec& story, const fs::path& folder,
                                              const Host& host) {
  const std::string place = story.file + ':' + std::to_string(story.line) + ": ";
  auto then = Run::open(story.golden);
  if (!then) return then.error();
  auto now = Run::open(folder);
  if (!now) return now.error();
  const std::optional<Error> fails = then->failure ? std::nullopt : now->failure;
  const std::string failure = fails ? place + "the run fails now: " + fails->text() : "";
  const bool loads = !fails || now->ticks > 0 || fails->code != "bad_input";
  if (!loads) return std::vector{failure};  // not all of its constructs are there to be compared
  auto found = compare(*then, *now, host);
  if (!found) return fails ? Expected(std::vector{failure}) : found.error();
  const bool cut_short = story.end > SimTime::zero();
  if (cut_short) found->outcomes.clear();  // of runs of two lengths
  std::vector<std::string> out;
  if (found->same()) return out;
  if (fails) out.push_back(failure);
  out.push_back(place + "the run goes otherwise than " + story.golden.string() +
                (found->first ? " from " + general_text(to_seconds(found->first->t), 9) + " s on"
                              : ": its rules do the same, its result is another"));
  out.push_back("a is the golden run, b the present one\n" + text_of(*found));
  return out;
}

/// Rules and configurations of the agents, which a change of may make it go otherwise.
std::vector<std::string> files_of(const testing::StorySpec& story) {
  constexpr std::size_t kMost = 2000;
  std::vector<std::string> out{fs::absolute(story.golden / "manifest.json").lexically_normal().string()};
  const auto run = Run::open(story.golden);
  const auto scenario = run ? run->scenario() : Expected<Scenario>(Error{});
  if (!scenario) return out;
  out.push_back(fs::absolute(scenario->file).lexically_normal().string());
  std::map<std::string, PackageSpec> packages = scenario->packages;
  for (const AgentSpec& agent : scenario->agents) {
    out.push_back(fs::absolute(scenario->resolve(agent.config)).lexically_normal().string());
    packages.insert(agent.packages.begin(), agent.packages.end());
  }
  for (const auto& [name, package] : packages) {
    std::error_code error;
    for (fs::recursive_directory_iterator it(fs::absolute(scenario->resolve(package.folder)), error), end;
         !error && it != end && out.size() < kMost; it.increment(error))
      if (it->path().extension() == ".clp" || it->path().extension() == ".yaml")
        out.push_back(it->path().lexically_normal().string());
  }
  return out;
}

}  // namespace

testing::StoryResult play_golden(const testing::StorySpec& story, bool coverage, const Host& host) {
  testing::StoryResult result;
  result.files = files_of(story);
  const auto scratch = ScratchFolder::create(RemovedBy::kServant);
  if (!scratch) {
    result.bad = scratch.error();
    return result;
  }
  const fs::path folder = (*scratch)->path() / "run", error = (*scratch)->path() / kError;
  auto process = Process::fork({}, [&] {
    const Status played = play_again(story, folder, host);
    if (!played) (void)write_file(error, played.error().text());
    return played ? 0 : static_cast<int>(played.error().kind);
  });
  if (!process) {
    result.bad = process.error();
    return result;
  }
  const int code = process->wait();
  auto run = Run::open(folder);
  if (run) result.sim_time_s = to_seconds(run->sim_time);
  const auto why = is_file(error) ? read_file(error) : Expected<std::string>(std::string());
  if (code != 0) {
    const std::string what = why && !why->empty() ? *why
                                                  : "the process that played " + story.golden.string() +
                                                        " again ended with code " + std::to_string(code);
    const Error failure = input_error(what, story.file, story.line);
    if (code == static_cast<int>(ErrorKind::kInput) || code == static_cast<int>(ErrorKind::kUsage))
      result.bad = failure;
    else
      result.failures.push_back(failure.text());
    return result;
  }
  if (coverage) {
    std::vector<Run> runs;
    if (run) runs.push_back(*std::move(run));
    const auto covered = run ? coverage_of_runs(runs, 1, host) : run.error();
    if (covered)
      result.coverage = covered->by_place();
    else
      result.notes.push_back("its rules are not counted: " + covered.error().text());
  }
  if (const auto then = Run::open(story.golden); then && !path_exists(then->found(then->manifest.scenario_file())))
    result.notes.push_back("the scenario is missing: " + then->found(then->manifest.scenario_file()).string() +
                           "; the copy of the golden run was played");
  auto differs = difference(story, folder, host);
  if (!differs)
    result.bad = differs.error();
  else
    result.failures = *std::move(differs);
  result.differs = !result.failures.empty();
  return result;
}

Status keep_golden(const testing::StorySpec& story, const fs::path& folder, const Host& host) {
  return play_again(story, folder, host);
}

Status accept_golden(const testing::StorySpec& story, const Host& host) {
  testing::StorySpec whole = story;
  whole.end = SimTime::zero();
  const fs::path golden = fs::absolute(story.golden).lexically_normal();
  fs::path now = golden, then = golden;
  now += ".now";
  then += ".then";
  Host confined = host;
  confined.confine = true;
  auto child = Child::start([&]() -> Expected<Json> {
    const Status played = play_again(whole, now, confined);
    return played ? Expected<Json>(Json()) : played.error();
  });
  if (!child) return child.error();
  if (const auto played = child->finish(host); !played) return played.error();
  std::error_code error;
  const auto before = Run::open(golden), run = Run::open(now);
  if (run && run->failure && before && !before->failure) {
    fs::remove_all(now, error);
    return input_error("this golden run stays, because the run fails now: " + run->failure->text(), golden.string());
  }
  fs::remove_all(then, error);
  if (!error) fs::rename(golden, then, error);
  if (!error) {
    fs::rename(now, golden, error);
    if (std::error_code none; error) fs::rename(then, golden, none);
  }
  if (!error) fs::remove_all(then, error);
  return error ? resource_error("the new run " + now.string() + " cannot be put in its place: " + error.message(),
                                golden.string())
               : Status();
}

}  // namespace cxlab::lab
