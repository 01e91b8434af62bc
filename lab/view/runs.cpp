#include "lab/view/runs.h"

#include <algorithm>
#include <set>
#include <utility>

#include "cx/base/file.h"
#include "lab/sweep/index.h"
#include "lab/sweep/row_folder.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

constexpr int kDeepest = 3;  // below the folder that was given: SWEEP/games/NAME
constexpr std::size_t kMostRuns = 5'000;

bool is_folder_of_run(const fs::path& folder) { return is_file(folder / "manifest.json"); }

/// Runs below a folder, in order of their names. Links are not followed.
void add_runs(const fs::path& folder, int depth, std::vector<fs::path>& out) {
  std::vector<fs::path> folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (!entry.is_symlink(ignored) && entry.is_directory(ignored)) folders.push_back(entry.path());
  std::ranges::sort(folders);
  for (const fs::path& one : folders) {
    if (out.size() >= kMostRuns) return;
    if (is_folder_of_run(one))
      out.push_back(one);
    else if (depth < kDeepest)
      add_runs(one, depth + 1, out);
  }
}

/// A name that may stand in an address as it is.
std::string id_text(const std::string& name) {
  std::string id;
  for (const char c : name) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    id += plain ? c : '-';
  }
  return id.empty() ? "run" : id;
}

Json metric_json(const Metric& metric) {
  return {
      {"name", metric.name}, {"unit", metric.unit}, {"more_is_better", metric.more_is_better}, {"what", metric.what}};
}

std::string name_of(const fs::path& folder) { return fs::absolute(folder).lexically_normal().filename().string(); }

}  // namespace

ViewedRuns::ViewedRuns(ViewedRuns&& other) noexcept
    : place_(std::move(other.place_)),
      catalogue_(other.catalogue_),
      only_(std::move(other.only_)),
      folders_(std::move(other.folders_)),
      rows_(std::move(other.rows_)) {}

Expected<ViewedRuns> ViewedRuns::open(const fs::path& place, const Catalogue& catalogue) {
  if (!is_folder(place)) return input_error("there is no folder of a run, or of runs", place.string());
  std::error_code ignored;
  fs::path whole = fs::canonical(place, ignored);
  ViewedRuns runs(whole.empty() ? place : std::move(whole), catalogue);
  if (is_folder_of_run(runs.place_)) {
    if (const auto run = Run::open(runs.place_, catalogue); !run) return run.error();
    runs.only_ = id_text(name_of(runs.place_));
    runs.folders_[*runs.only_] = runs.place_;
    return runs;
  }
  runs.look();
  if (runs.folders_.empty() && row_files(runs.place_).empty())
    return input_error(
        "is neither the folder of a run nor one with runs in it: there is no manifest.json in it or in the "
        "folders below",
        place.string());
  return runs;
}

/// New runs get an id that no other one has.
void ViewedRuns::look() {
  std::set<fs::path> known;
  for (const auto& [id, folder] : folders_) known.insert(folder);
  std::vector<fs::path> all;
  add_runs(place_, 1, all);
  for (const fs::path& folder : all) {
    if (known.contains(folder)) continue;
    const std::string id = id_text(folder.lexically_relative(place_).generic_string());
    std::string free = id;
    for (int n = 2; folders_.contains(free); ++n) free = id + "--" + std::to_string(n);
    folders_[free] = folder;
  }
}

std::optional<fs::path> ViewedRuns::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = folders_.find(id);
  return found == folders_.end() ? std::nullopt : std::optional(found->second);
}

Json ViewedRuns::row_of(const std::string& id, const fs::path& folder, Players& players) {
  Json row{{"id", id}, {"name", only_ ? name_of(folder) : folder.lexically_relative(place_).generic_string()}};
  const auto text = read_file(folder / "result.json");
  auto& [seen, known] = rows_[id];
  if (text && seen == *text) return known;
  const auto run = Run::open(folder, *catalogue_);
  if (!run) {
    row["status"] = "unreadable";
    row["problem"] = run.error().text();
    return row;
  }
  const Json result = parse_json(run->result);
  for (const auto& [key, from] : {std::pair("scenario", "scenario"),
                                  {"seed", "seed"},
                                  {"status", "status"},
                                  {"tier", "tier"},
                                  {"sim_time_s", "sim_time_s"}})
    row[key] = result.contains(from) ? result[from] : Json();
  row["live"] = run->unfinished && players.is_live(folder);
  if (run->unfinished) row["status"] = "unfinished";
  row["warnings"] = result.contains("warnings") ? result["warnings"].size() : 0;
  row["errors"] = result.contains("rule_errors") ? result["rule_errors"].size() : 0;
  row["problem"] = run->failure ? run->failure->text() : "";
  row["parameters"] = Json::object();
  for (const std::string& override : run->manifest.overrides)
    if (const std::size_t equals = override.find('='); equals != override.npos)
      row["parameters"][override.substr(0, equals)] = override.substr(equals + 1);
  row["world"] = Json();
  row["metrics"] = Json::object();
  if (const auto scenario = run->scenario()) {
    row["world"] = scenario->world.kind->name;
    const std::vector<const Metric*> metrics = metrics_of(*scenario->world.kind);
    const auto values = measure(metrics, run->result);
    for (std::size_t i = 0; i < metrics.size(); ++i)
      if (values[i]) row["metrics"][std::string(metrics[i]->name)] = *values[i];
  }
  if (!run->unfinished) {
    seen = run->result;
    known = row;
  }
  return row;
}

Json ViewedRuns::table(Players& players) {
  const std::lock_guard lock(mutex_);
  if (!only_) look();
  Json rows = Json::array(), metrics = Json::array();
  std::map<std::string, std::size_t> by_name;  // rows of runs by the name of their folder
  for (const auto& [id, folder] : folders_) {
    by_name[name_of(folder)] = rows.size();
    rows.push_back(row_of(id, folder, players));
  }
  std::set<std::string> worlds, named;
  const auto name_metrics = [&](const std::string& world) {
    if (!worlds.insert(world).second) return;
    for (const WorldKind* kind : catalogue_->worlds)
      if (kind->name == world)
        for (const Metric* metric : metrics_of(*kind))
          if (named.insert(std::string(metric->name)).second) metrics.push_back(metric_json(*metric));
  };
  for (const Json& row : rows)
    if (row.contains("world") && row["world"].is_string()) name_metrics(row["world"]);
  // A sweep has games, of which a few have a folder.
  if (const fs::path index = place_ / "runs.sqlite"; !only_ && is_file(index)) {
    if (const auto games = read_index(index))
      for (const IndexedRow& game : *games) {
        const std::string name = fs::path(game.file).stem().string();
        const Row& played = game.row;
        Json row;
        if (const auto folder = by_name.find(name); folder != by_name.end()) {
          rows[folder->second]["strategy"] = played.cell.strategy;
          continue;
        }
        row = {{"id", Json()},
               {"name", name},
               {"scenario", played.cell.scenario},
               {"seed", played.cell.seed},
               {"status", played.status},
               {"strategy", played.cell.strategy},
               {"live", false},
               {"warnings", played.warnings.size()},
               {"errors", played.errors.size()},
               {"problem", played.errors.empty() ? "" : played.errors.front()},
               {"command", game.command},
               {"world", played.world},
               {"metrics", Json::object()}};
        for (const Figure& figure : played.figures)
          if (figure.value) row["metrics"][std::string(figure.metric)] = *figure.value;
        name_metrics(played.world);
        rows.push_back(std::move(row));
      }
  }
  return {{"folder", place_.string()}, {"runs", std::move(rows)}, {"metrics", std::move(metrics)}};
}

}  // namespace cxlab::lab
