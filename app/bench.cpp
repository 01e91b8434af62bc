// cxlab bench: scenarios x strategies x seeds, each episode in a process of its own.

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/command.h"
#include "cx/yaml/yaml.h"
#include "scenarios/scenario.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct BenchOptions {
  std::string suite, out;
  int jobs = 1;
  bool json = false;
};

struct Suite {
  std::vector<fs::path> scenarios;
  std::vector<std::pair<std::string, std::vector<std::string>>>
      strategies;  ///< name, overrides; in the order of the file
  std::vector<std::uint64_t> seeds;
  std::string tier;
};

struct Episode {
  std::string scenario, strategy;
  std::uint64_t seed = 0;
  std::vector<std::string> arguments;
  fs::path row, log;
  ordered_json found;  ///< of the row file
};

std::vector<std::uint64_t> read_seeds(const yaml::Value& value) {
  std::vector<std::uint64_t> out;
  if (value.is_list()) {
    for (const yaml::Value& item : value.as_list())
      if (const std::int64_t seed = item.as_integer(); seed < 0)
        item.fail("expected a seed of at least 0");
      else
        out.push_back(static_cast<std::uint64_t>(seed));
    return out;
  }
  unsigned long first = 0, last = 0;
  char rest = 0;
  if (std::sscanf(value.text().c_str(), "%lu..%lu%c", &first, &last, &rest) != 2 || last < first ||
      last - first >= 100000) {
    value.fail("found '" + value.text() + "', expected a list of seeds or a range \"0..29\"");
    return out;
  }
  for (std::uint64_t seed = first; seed <= last; ++seed) out.push_back(seed);
  return out;
}

Expected<Suite> read_suite(const fs::path& file) {
  auto document = yaml::Document::load(file);
  if (!document) return document.error();
  Suite suite;
  yaml::Map map = document->root().as_map();
  if (const yaml::Value scenarios = map.require("scenarios"))
    for (const std::string& path : scenarios.as_strings())
      suite.scenarios.push_back((file.parent_path() / path).lexically_normal());
  if (const yaml::Value strategies = map.require("strategies")) {
    yaml::Map names = strategies.as_map();
    for (const auto& [name, overrides] : names.entries())
      suite.strategies.emplace_back(name, overrides ? overrides.as_strings() : std::vector<std::string>());
  }
  if (const yaml::Value seeds = map.require("seeds")) suite.seeds = read_seeds(seeds);
  map.read_word("tier", suite.tier, {"timed", "physics"});
  map.finish();
  if (suite.scenarios.empty() || suite.strategies.empty() || suite.seeds.empty())
    map.fail("expected at least one scenario, strategy and seed");
  if (Status s = document->status(); !s) return s.error();
  return suite;
}

/// A row of the same command that a former bench left.
bool read_row(Episode& episode) {
  std::ifstream in(episode.row);
  if (!in) return false;
  ordered_json row = ordered_json::parse(in, nullptr, false);
  if (row.is_discarded() || !row.is_object() || row.value("arguments", ordered_json()) != episode.arguments)
    return false;
  episode.found = std::move(row);
  return true;
}

std::optional<pid_t> start(const Episode& episode) {
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid != 0) return pid > 0 ? std::optional<pid_t>(pid) : std::nullopt;
  const std::string output = episode.row.string() + ".out";
  const int out = open(output.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644),
            log = open(episode.log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
  if (out < 0 || log < 0 || dup2(out, 1) < 0 || dup2(log, 2) < 0) _exit(5);
  std::vector<char*> argv{const_cast<char*>("cxlab")};
  for (const std::string& a : episode.arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  execv("/proc/self/exe", argv.data());
  _exit(5);
}

/// The row of an episode that has ended, however it did.
Status write_row(Episode& episode, int wait_status) {
  const fs::path output = episode.row.string() + ".out";
  std::ifstream in(output);
  ordered_json result = ordered_json::parse(in, nullptr, false);
  ordered_json& row = episode.found;
  row["scenario"] = episode.scenario;
  row["strategy"] = episode.strategy;
  row["seed"] = episode.seed;
  row["arguments"] = episode.arguments;
  row["exit"] = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
  const bool there = result.is_object() && result.contains("status");
  row["status"] = there ? result["status"] : ordered_json("crashed");
  if (there) {
    double points = 0, busy = 0;
    int deliveries = 0;
    for (const auto& [team, t] : result["teams"].items()) points += t["points"].get<double>();
    for (const auto& d : result["deliveries"]) deliveries += d["correct"].get<bool>();
    for (const auto& robot : result["robots"]) busy += robot["busy_s"].get<double>();
    const double robot_time = static_cast<double>(result["robots"].size()) * result["sim_time_s"].get<double>();
    row["points"] = points;
    row["deliveries"] = deliveries;
    row["busy"] = robot_time > 0 ? busy / robot_time : 0.0;
    row["real_time_factor"] = result["real_time_factor"];
    row["journal_hash"] = result["journal_hash"];
  }
  const fs::path fresh = episode.row.string() + ".new";
  std::ofstream out(fresh);
  out << row.dump(2) << '\n';
  out.close();
  std::error_code error;
  if (out) fs::rename(fresh, episode.row, error);
  if (!out || error) return resource_error("cannot write this file", episode.row.string());
  fs::remove(output, error);
  return {};
}

Status play(std::vector<Episode>& episodes, int jobs) {
  std::map<pid_t, Episode*> running;
  std::size_t next = 0, done = 0;
  for (const Episode& e : episodes) done += !e.found.is_null();
  while (true) {
    while (next < episodes.size() && running.size() < static_cast<std::size_t>(jobs)) {
      Episode& episode = episodes[next++];
      if (!episode.found.is_null()) continue;
      const auto pid = start(episode);
      if (!pid) return resource_error("cannot start a process");
      running[*pid] = &episode;
    }
    if (running.empty()) return {};
    int status = 0;
    const pid_t pid = waitpid(-1, &status, 0);
    const auto ended = running.find(pid);
    if (ended == running.end()) continue;
    Episode& episode = *ended->second;
    running.erase(ended);
    if (Status s = write_row(episode, status); !s) return s;
    std::fprintf(stderr, "[%zu/%zu] %s %s seed %lu: %s, exit %d, points %s\n", ++done, episodes.size(),
                 episode.scenario.c_str(), episode.strategy.c_str(), static_cast<unsigned long>(episode.seed),
                 episode.found["status"].get<std::string>().c_str(), episode.found["exit"].get<int>(),
                 episode.found.contains("points") ? episode.found["points"].dump().c_str() : "-");
  }
}

bool counts(const Episode& e) { return e.found.contains("points") && e.found["status"] == "completed"; }

struct Summary {
  std::size_t n = 0;
  double mean = 0, half = std::numeric_limits<double>::quiet_NaN(), min = 0,
         max = 0;  ///< half width of the 95 % interval
};

/// The 97.5 % quantile of Student's t.
double t_quantile(std::size_t freedom) {
  static constexpr double kTable[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                                      2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                                      2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};
  const double f = static_cast<double>(freedom);
  return freedom <= 30 ? kTable[freedom - 1] : 1.95996 + 2.3723 / f + 2.8225 / (f * f);  // Cornish and Fisher, 1937
}

Summary summarize(const std::vector<double>& values) {
  Summary s;
  s.n = values.size();
  if (values.empty()) return s;
  s.min = *std::min_element(values.begin(), values.end());
  s.max = *std::max_element(values.begin(), values.end());
  for (const double v : values) s.mean += v / static_cast<double>(s.n);
  double squares = 0;
  for (const double v : values) squares += (v - s.mean) * (v - s.mean);
  if (s.n > 1)
    s.half = t_quantile(s.n - 1) * std::sqrt(squares / static_cast<double>(s.n - 1) / static_cast<double>(s.n));
  return s;
}

ordered_json to_json(const Summary& s) {
  ordered_json half = std::isnan(s.half) ? ordered_json() : ordered_json(s.half);
  return {{"n", s.n}, {"mean", s.mean}, {"interval_95", half}, {"min", s.min}, {"max", s.max}};
}

std::string text(const Summary& s, const char* format) {
  if (s.n == 0) return "-";
  char a[32], b[32];
  std::snprintf(a, sizeof a, format, s.mean);
  std::snprintf(b, sizeof b, *format == '%' && format[1] == '+' ? "%.1f" : format, s.half);
  return std::string(a) + (std::isnan(s.half) ? "" : std::string(" +- ") + b);
}

ordered_json summary_of(const std::vector<Episode>& episodes, const Suite& suite, std::string& table) {
  ordered_json out = ordered_json::array();
  std::map<std::pair<std::string, std::uint64_t>, double> first;
  char line[512];
  std::snprintf(line, sizeof line, "%-20s %-20s %7s  %-18s %6s %6s  %-14s %-14s %-14s %s\n", "scenario", "strategy",
                "done", "points", "min", "max", "deliveries", "busy", "real time", "points against the first strategy");
  table = line;
  for (const fs::path& scenario : suite.scenarios)
    for (const auto& [strategy, overrides] : suite.strategies) {
      std::map<std::string, std::vector<double>> values;
      std::vector<double> difference;
      std::size_t all = 0;
      for (const Episode& e : episodes) {
        if (e.scenario != scenario.stem() || e.strategy != strategy) continue;
        ++all;
        if (!counts(e)) continue;
        for (const char* key : {"points", "deliveries", "busy", "real_time_factor"})
          values[key].push_back(e.found[key].get<double>());
        const double points = e.found["points"].get<double>();
        if (strategy == suite.strategies.front().first)
          first[{e.scenario, e.seed}] = points;
        else if (const auto other = first.find({e.scenario, e.seed}); other != first.end())
          difference.push_back(points - other->second);
      }
      const Summary points = summarize(values["points"]), against = summarize(difference);
      std::snprintf(line, sizeof line, "%-20s %-20s %3zu/%-3zu  %-18s %6g %6g  %-14s %-14s %-14s %s\n",
                    scenario.stem().c_str(), strategy.c_str(), points.n, all, text(points, "%.1f").c_str(), points.min,
                    points.max, text(summarize(values["deliveries"]), "%.1f").c_str(),
                    text(summarize(values["busy"]), "%.3f").c_str(),
                    text(summarize(values["real_time_factor"]), "%.0f").c_str(), text(against, "%+.1f").c_str());
      table += line;
      out.push_back({{"scenario", scenario.stem().string()},
                     {"strategy", strategy},
                     {"episodes", all},
                     {"points", to_json(points)},
                     {"deliveries", to_json(summarize(values["deliveries"]))},
                     {"busy", to_json(summarize(values["busy"]))},
                     {"real_time_factor", to_json(summarize(values["real_time_factor"]))},
                     {"points_against_first", to_json(against)}});
    }
  return out;
}

/// Reads every scenario with every strategy, so that a misspelt override does not cost a night of failed episodes.
Status check_scenarios(const Suite& suite) {
  for (const fs::path& scenario : suite.scenarios)
    for (const auto& [strategy, overrides] : suite.strategies) {
      std::vector<std::string> all = overrides;
      if (!suite.tier.empty()) all.push_back("tier=" + suite.tier);
      auto read = Scenario::load(scenario, all);
      if (read) continue;
      Error error = read.error();
      error.message = "strategy '" + strategy + "': " + error.message;
      return error;
    }
  return {};
}

int bench(const BenchOptions& options) {
  auto suite = read_suite(options.suite);
  if (!suite) return fail(suite.error());
  if (Status s = check_scenarios(*suite); !s) return fail(s.error());
  const fs::path folder = options.out.empty() ? fs::path("runs") / ("bench-" + fs::path(options.suite).stem().string())
                                              : fs::path(options.out);
  std::error_code error;
  fs::create_directories(folder / "rows", error);
  if (error) return fail(resource_error(error.message(), folder.string()));
  std::vector<Episode> episodes;
  for (const fs::path& scenario : suite->scenarios)
    for (const auto& [strategy, overrides] : suite->strategies)
      for (const std::uint64_t seed : suite->seeds) {
        Episode e{scenario.stem().string(), strategy, seed, {}, {}, {}, {}};
        e.arguments = {"run", scenario.string(), "--seed", std::to_string(seed), "--json", "--quiet", "--out", "none"};
        if (!suite->tier.empty()) e.arguments.insert(e.arguments.end(), {"--tier", suite->tier});
        for (const std::string& set : overrides) e.arguments.insert(e.arguments.end(), {"--set", set});
        const std::string name = e.scenario + '-' + strategy + '-' + std::to_string(seed);
        e.row = folder / "rows" / (name + ".json");
        e.log = folder / "rows" / (name + ".log");
        read_row(e);
        episodes.push_back(std::move(e));
      }
  if (Status s = play(episodes, options.jobs); !s) return fail(s.error());
  std::ofstream csv(folder / "rows.csv");
  csv << "scenario,strategy,seed,status,exit,points,deliveries,busy,real_time_factor,journal_hash\n";
  bool all_well = true;
  for (const Episode& e : episodes) {
    all_well &= counts(e);
    csv << e.scenario << ',' << e.strategy << ',' << e.seed << ',' << e.found["status"].get<std::string>() << ','
        << e.found["exit"];
    for (const char* key : {"points", "deliveries", "busy", "real_time_factor"})
      csv << ',' << (e.found.contains(key) ? e.found[key].dump() : "");
    csv << ',' << e.found.value("journal_hash", "") << '\n';
  }
  csv.close();
  if (!csv) return fail(resource_error("cannot write this file", (folder / "rows.csv").string()));
  std::string table;
  const ordered_json summary = summary_of(episodes, *suite, table);
  if (options.json)
    std::printf("%s\n", summary.dump(2).c_str());
  else
    std::printf("%s%s\n", table.c_str(), (folder / "rows.csv").c_str());
  return all_well ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_bench(CLI::App& app, Action& action) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = app.add_subcommand("bench", "Plays scenarios x strategies x seeds and compares (docs/bench.md)");
  command->footer("Example:\n  cxlab bench benchmarks/rcll.yaml -j 2");
  command->add_option("suite", options->suite, "Suite file (YAML)")->required();
  command->add_option("-j", options->jobs, "Episodes at once")->check(CLI::Range(1, 256));
  command->add_option("--out", options->out,
                      "Folder of the rows (default runs/bench-<suite>); rows that are there are kept");
  command->add_flag("--json", options->json, "Prints JSON instead of the table");
  command->callback([options, &action] { action = [options] { return bench(*options); }; });
}

}  // namespace cxlab::app
