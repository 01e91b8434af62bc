#include "lab/sweep/suite.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/yaml/yaml.h"
#include "lab/session.h"
#include "lab/sweep/row.h"
#include "scenarios/metric.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

void add_seed(std::uint64_t seed, const yaml::Value& place, std::vector<std::uint64_t>& seeds) {
  if (std::find(seeds.begin(), seeds.end(), seed) != seeds.end())
    place.fail("found seed " + std::to_string(seed) + " twice, expected each once: the same game is no second sample");
  else
    seeds.push_back(seed);
}

std::vector<std::uint64_t> read_seeds(const yaml::Value& value) {
  std::vector<std::uint64_t> out;
  if (value.is_list()) {
    for (const yaml::Value& item : value.as_list())
      if (const std::int64_t seed = item.as_integer(); seed < 0)
        item.fail("expected a seed of at least 0");
      else
        add_seed(static_cast<std::uint64_t>(seed), item, out);
    return out;
  }
  constexpr std::uint64_t kMost = 100000;
  const std::string text = value.text();
  const std::size_t dots = text.find("..");
  const auto first = read_number<std::uint64_t>(text.substr(0, dots));
  const auto last = read_number<std::uint64_t>(dots == text.npos ? "" : text.substr(dots + 2));
  if (!first || !last || *last < *first || *last - *first >= kMost) {
    value.fail("found '" + text + "', expected a list of seeds or a range \"0..29\"");
    return out;
  }
  out.resize(*last - *first + 1);
  std::iota(out.begin(), out.end(), *first);
  return out;
}

/// Each file's name without extension, and as many of its folders as keep it apart from the others.
std::vector<SuiteScenario> named(const std::vector<fs::path>& files) {
  std::vector<SuiteScenario> out;
  for (const fs::path& file : files) {
    fs::path folder = file.parent_path();
    std::string name = file.stem().string();
    const auto same = [&](const fs::path& other) {
      return other != file && ('/' + fs::path(other).replace_extension().string()).ends_with('/' + name);
    };
    for (; std::any_of(files.begin(), files.end(), same) && folder.has_filename(); folder = folder.parent_path())
      name = folder.filename().string() + '/' + name;
    out.push_back({name, file});
  }
  return out;
}

std::vector<SuiteGame> read_games(const yaml::Value& value, const fs::path& from) {
  std::vector<SuiteGame> out;
  const fs::path folder = (from / value.as_string()).lexically_normal();
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".yaml") out.push_back({it->path().stem().string(), it->path()});
  std::ranges::sort(out, {}, &SuiteGame::name);
  if (error)
    value.fail("found '" + value.text() + "', expected a folder: " + error.message());
  else if (out.empty())
    value.fail("found '" + value.text() + "', expected a folder with files of games, NAME.yaml");
  return out;
}

/// Single-quoted YAML.
std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + '\'';
}

}  // namespace

Expected<Suite> Suite::load(const fs::path& file) {
  auto document = yaml::Document::load(file);
  if (!document) return document.error();
  Suite suite;
  yaml::Map map = document->root().as_map();
  if (const yaml::Value scenarios = map.require("scenarios")) {
    std::vector<fs::path> files;
    std::vector<Origin> origins;
    std::vector<std::string> names;
    const auto own = own_scenarios();
    for (const yaml::Value& item : scenarios.as_list()) {
      fs::path path = (file.parent_path() / item.as_string()).lexically_normal();
      if (const auto known = own.find(item.text()); known != own.end() && !path_exists(path)) path = known->second;
      if (std::find(files.begin(), files.end(), path) != files.end()) {
        item.fail("found the scenario '" + item.text() + "' twice, expected each once");
      } else {
        files.push_back(path);
        origins.push_back(item.origin());
        names.push_back(item.text());
      }
    }
    suite.scenarios = named(files);
    for (std::size_t i = 0; i < files.size(); ++i) {
      suite.scenarios[i].origin = origins[i];
      suite.scenarios[i].named = names[i];
    }
  }
  if (const yaml::Value strategies = map.require("strategies")) {
    yaml::Map names = strategies.as_map();
    for (const auto& [name, overrides] : names.entries()) {
      const auto same = [&name = name](const Strategy& other) { return other.name == name; };
      if (std::any_of(suite.strategies.begin(), suite.strategies.end(), same))
        strategies.fail("found strategy '" + name + "' twice, expected each once");
      if (name.empty() || name.find('/') != name.npos)
        strategies.fail("found '" + name + "', expected a name for the strategy, without '/'");
      Strategy& strategy = suite.strategies.emplace_back(Strategy{name, {}});
      if (!overrides) continue;
      for (const yaml::Value& item : overrides.as_list()) {
        strategy.overrides.push_back(item.as_string());
        strategy.origins.push_back(item.origin());
      }
    }
  }
  const yaml::Value games = map.get("games");
  if (games) {
    suite.games = read_games(games, file.parent_path());
    suite.games_origin = games.origin();
  }
  if (games && !map.has("seeds"))
    suite.seeds = {1};
  else if (const yaml::Value seeds = map.require("seeds"))
    suite.seeds = read_seeds(seeds);
  map.read_word("tier", suite.tier, {"timed", "physics"});
  map.finish();
  if (suite.scenarios.empty() || suite.strategies.empty() || suite.seeds.empty())
    map.fail("expected at least one scenario, strategy and seed");
  if (Status s = document->status(); !s) return s.error();
  return suite;
}

namespace {

Expected<Scenario> load_scenario(const Suite& suite, const fs::path& file, const std::vector<std::string>& overrides) {
  std::vector<Override> all;
  for (const std::string& set : overrides) all.emplace_back(set, set);
  return Scenario::load(file, *suite.catalogue, all);
}

}  // namespace

std::vector<Cell> Suite::cells() const {
  std::vector<Cell> out;
  for (const SuiteScenario& scenario : scenarios)
    for (const Strategy& strategy : strategies) {
      std::string path_of_game;
      if (!games.empty())
        if (const auto read = load_scenario(*this, scenario.file, strategy.overrides))
          path_of_game = games_path(*read->world.kind);
      for (const SuiteGame& game : games.empty() ? std::vector<SuiteGame>(1) : games)
        for (const std::uint64_t seed : seeds) {
          Cell& cell =
              out.emplace_back(Cell{scenario.name, strategy.name, seed, scenario.file, strategy.overrides, game.name});
          if (!tier.empty()) cell.overrides.push_back("tier=" + tier);
          if (!path_of_game.empty())
            cell.overrides.push_back(cell.game_override = path_of_game + '=' + in_quotes(game.file.string()));
          cell.overrides.push_back("seed=" + std::to_string(seed));
          cell.named = scenario.named;
        }
    }
  return out;
}

namespace {

Status check_world(const Scenario& scenario, const Suite& suite) {
  const WorldKind& world = *scenario.world.kind;
  if (!suite.games.empty() && world.games_key.empty())
    return input_error("games: the world of " + scenario.file.string() + ", " + std::string(world.name) +
                           ", is not made from files of games; expected seeds alone",
                       suite.games_origin);
  for (const Metric* metric : metrics_of(world))
    if (is_key_of_row(metric->name))
      return bug_error("the world " + std::string(world.name) + " declares a metric '" + std::string(metric->name) +
                       "', which is the name of another key of a row");
  return check_metrics(scenario);
}

}  // namespace

Status Suite::check() const {
  for (const SuiteScenario& scenario : scenarios)
    if (const auto text = read_file(scenario.file); !text) return input_error(text.error().text(), scenario.origin);
  for (const Cell& cell : cells()) {
    const bool first_game = games.empty() || cell.game == games.front().name;
    if (cell.seed != seeds.front() || (!first_game && cell.strategy != strategies.front().name)) continue;
    const auto wrong = [&](const Error& error) {
      const auto used = std::ranges::find(strategies, cell.strategy, &Strategy::name);
      const std::string what = "strategy '" + cell.strategy + "': " + error.text();
      for (std::size_t i = 0; i < used->origins.size(); ++i)
        if (error.text().starts_with(used->overrides[i] + ':')) return input_error(what, used->origins[i]);
      return input_error(what);
    };
    auto scenario = load_scenario(*this, cell.file, cell.overrides);
    if (!scenario) return wrong(scenario.error());
    if (Status s = check_world(*scenario, *this); !s) return s;
    auto episode = Episode::load(*std::move(scenario), shared_episode_options());
    if (!episode) return wrong(episode.error());
  }
  return {};
}

}  // namespace cxlab::lab
