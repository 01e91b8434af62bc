#include "lab/coverage_of_runs.h"

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/scratch_folder.h"
#include "cx/journal/file_store.h"
#include "lab/child.h"
#include "lab/json_fields.h"
#include "lab/moment.h"
#include "lab/sweep/play_again.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

bool is_run(const fs::path& folder) { return is_file(folder / "manifest.json"); }

void add_runs_below(const fs::path& folder, std::vector<fs::path>& runs) {
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (!it->is_directory(error) || !is_run(it->path())) continue;
    runs.push_back(it->path());
    it.disable_recursion_pending();
  }
}

/// What the process that plays a run says of it.
Expected<Json> cover(const Run& run, Host host) {
  explain::Coverage coverage;
  const auto add = [&coverage](const cx::Environment& environment) {
    coverage.add(explain::coverage_of(environment.engine().counts(), [&environment](const std::string& file) {
      return environment.files().journal_name(file);
    }));
  };
  host.confine = true;
  host.log = nullptr;
  host.progress = nullptr;
  auto moment = Moment::open(run, host, {.timelines = false, .counting = Counting::kUse, .on_environment_end = add});
  if (!moment) return moment.error();
  const Status played = (*moment)->seek(std::nullopt);
  if (auto error = run.untrusted(played)) return *error;
  std::string note;
  if ((*moment)->cut_off()) note = "its log ends at " + seconds_text(to_seconds((*moment)->end()));
  if (!played) note = played.error().text();
  if ((*moment)->cut_off()) {  // its agents were not deactivated by then
    for (const cx::Environment* environment : (*moment)->episode().environments()) add(*environment);
  } else {
    (void)(*moment)->episode().close(RunStatus::kStopped, played ? std::nullopt : std::optional<Error>(played.error()));
    moment->reset();
  }
  return Json{{"coverage", JsonWriter::json(coverage)}, {"note", note}};
}

/// Where the file of that name in the journal is now. The folders of packages are those of the run, then those of now.
std::optional<std::string> place_of(const Run& run, const std::vector<Shares>& packages, const std::string& name) {
  const std::size_t slash = name.find('/');
  for (const Shares& some : packages)
    if (const auto share = some.find(name.substr(0, slash)); share != some.end() && slash != name.npos)
      if (const fs::path place = run.found(share->second) / name.substr(slash + 1); is_file(place))
        return place.lexically_normal().string();
  return std::nullopt;
}

Status take(const Run& run, const Json& said, RunsCoverage& out) {
  explain::Coverage coverage;
  if (Status s = read_fields(said.at("coverage"), coverage); !s) return s;
  out.coverage.add(coverage);
  const auto files = StoredFiles::open(run.folder);
  if (!files) return files.error();
  // A copy of a package's file is called after its agent, too: agents/0/packages/NAME.
  static constexpr std::string_view kPackages = "/packages/";
  std::map<std::string, std::string> copies;
  for (const std::string& copy : files->names()) {
    const std::size_t at = copy.find(kPackages);
    copies.emplace(at == copy.npos ? copy : copy.substr(at + kPackages.size()), copy);
  }
  std::set<std::string> names;
  for (const explain::Coverage::Rule& rule : coverage.rules) names.insert(rule.file);
  for (const explain::Coverage::Function& function : coverage.functions) names.insert(function.file);
  std::vector<Shares> packages = run.manifest.shares();
  packages.push_back(own_packages());
  packages.push_back({{"run", fs::absolute(run.folder).string()}});  // files that its rules wrote
  for (const std::string& name : names) {
    if (auto place = place_of(run, packages, name)) out.places.emplace(name, *std::move(place));
    const auto copy = copies.find(name);
    if (out.sources.contains(name) || copy == copies.end()) continue;
    if (auto text = files->read(copy->second)) out.sources.emplace(name, *std::move(text));
  }
  if (const std::string note = said.at("note"); !note.empty()) out.notes.push_back(run.folder.string() + ": " + note);
  return {};
}

}  // namespace

Expected<std::vector<fs::path>> run_folders(const std::vector<std::string>& paths) {
  std::vector<fs::path> runs;
  for (const std::string& path : paths) {
    if (!path_exists(path)) return input_error("there is no such folder", path);
    const std::size_t before = runs.size();
    if (is_run(path) || !is_folder(path))
      runs.emplace_back(path);
    else
      add_runs_below(path, runs);
    if (runs.size() == before)
      return input_error("expected the folder of a run, or one with such folders below; there is no manifest.json",
                         path);
    std::sort(runs.begin() + static_cast<std::ptrdiff_t>(before), runs.end());
  }
  return runs;
}

Expected<RunsCoverage> coverage_of_runs(const std::vector<Run>& runs, int jobs, const Host& host) {
  RunsCoverage out;
  std::deque<Child> playing;
  std::size_t begun = 0;
  out.runs = runs.size();
  for (std::size_t done = 0; done < runs.size(); ++done) {
    for (; begun < runs.size() && playing.size() < static_cast<std::size_t>(std::max(jobs, 1)); ++begun) {
      auto child = Child::start([&run = runs[begun], &host] { return cover(run, host); });
      if (!child) return child.error();
      playing.push_back(*std::move(child));
    }
    const auto said = playing.front().finish(host);
    if (said) {
      if (Status s = take(runs[done], *said, out); !s) return s.error();
    } else if (runs.size() == 1 || said.error().kind != ErrorKind::kInput) {
      return said.error();
    } else {  // of many, one that cannot be played is left out
      out.notes.push_back("left out: " + said.error().text());
      --out.runs;
    }
    playing.pop_front();
    if (runs.size() > 1) host.show_games(done + 1, runs.size(), playing.size());
  }
  if (out.runs == 0 && !out.notes.empty()) return input_error("no run can be played; " + out.notes.front());
  return out;
}

void RunsCoverage::add(RunsCoverage other) {
  coverage.add(other.coverage);
  sources.merge(std::move(other.sources));
  places.merge(std::move(other.places));
  notes.insert(notes.end(), other.notes.begin(), other.notes.end());
  runs += other.runs;
}

explain::Coverage RunsCoverage::by_place() const {
  explain::Coverage named = coverage, out;
  const auto name = [this](std::string& file) {
    if (const auto place = places.find(file); place != places.end()) file = place->second;
  };
  for (explain::Coverage::Rule& rule : named.rules) name(rule.file);
  for (explain::Coverage::Function& function : named.functions) name(function.file);
  out.add(named);  // in the order of the new names
  return out;
}

Expected<RunsCoverage> coverage_of_sweep(const SweepRecord& sweep, int jobs, const Host& host) {
  auto scratch = ScratchFolder::create(RemovedBy::kServant);
  if (!scratch) return scratch.error();
  std::vector<GameAgain> games;
  for (const IndexedRow& row : sweep.rows)
    if (!row.row.journal_hash.empty()) games.push_back({&row, (*scratch)->path() / std::to_string(games.size())});
  if (games.empty()) return input_error("no game of the sweep has ended", sweep.path.string());
  RunsCoverage out;
  const auto remarks = play_again(games, jobs, host, [&](const GameAgain& game) -> Status {
    auto run = Run::open(game.folder);
    if (!run) return run.error();
    std::vector<Run> one;
    one.push_back(*std::move(run));
    auto covered = coverage_of_runs(one, 1, host);
    if (!covered) return covered.error();
    out.add(*std::move(covered));
    std::error_code error;
    fs::remove_all(game.folder, error);
    return {};
  });
  if (!remarks) return remarks.error();
  out.notes.insert(out.notes.end(), remarks->begin(), remarks->end());
  return out;
}

}  // namespace cxlab::lab
