#include "lab/sweep/suite.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/yaml/seeds.h"
#include "cx/yaml/yaml.h"
#include "lab/child.h"
#include "lab/session.h"
#include "lab/sweep/row.h"
#include "scenarios/metric.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

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
    value.fail(found_text(value.text(), "a folder: " + error.message()));
  else if (out.empty())
    value.fail(found_text(value.text(), "a folder with files of games, NAME.yaml"));
  return out;
}

void read_requirement(const yaml::Value& value, std::vector<Requirement>& out) {
  const auto same = [&value](const Requirement& other) { return other.text == value.text(); };
  if (!value.is_scalar()) {
    value.fail(found_expected(value.found(),
                              "a text, as mean(points) >= 250; in quotes if it begins with the name of a strategy"));
  } else if (std::ranges::any_of(out, same)) {
    value.fail(found_expected("'" + value.text() + "' twice", "it once"));
  } else if (auto requirement = Requirement::parse(value.text()); !requirement) {
    value.fail(requirement.error().message);
  } else {
    out.push_back(*std::move(requirement));
    out.back().origin = value.origin();
  }
}

/// The text in single quotes; a quote in it becomes `quote`.
std::string in_quotes(const std::string& text, const char* quote) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string(quote) : std::string(1, c);
  return out + '\'';
}

constexpr const char* kYamlQuote = "''";
constexpr const char* kShellQuote = "'\\''";

std::string game_override(const std::string& path, const std::string& file) {
  return path + '=' + in_quotes(file, kYamlQuote);
}

// --- grids

/// One value of one parameter of a grid.
struct Choice {
  std::string label;  ///< in names of strategies
  std::vector<std::string> overrides;
  std::vector<Origin> origins;
};
struct Axis {
  std::string name;
  std::vector<Choice> choices;
};

void read_overrides(const yaml::Value& list, std::vector<std::string>& overrides, std::vector<Origin>& origins) {
  if (!list) return;
  for (const yaml::Value& item : list.as_list()) {
    overrides.push_back(item.as_string());
    origins.push_back(item.origin());
  }
}

/// `PATH: [1, 2, 3]`, or `NAME: {LABEL: [overrides], ...}`.
Axis read_axis(const std::string& path, const yaml::Value& values) {
  Axis axis{path, {}};
  const auto add = [&axis](Choice choice, const yaml::Value& place) {
    if (choice.label.empty() || choice.label.find('/') != std::string::npos)
      place.fail(found_text(choice.label, "a value without '/'; with a label any value can be given: " + axis.name +
                                              ": {LABEL: [PATH=VALUE]}"));
    else if (std::ranges::find(axis.choices, choice.label, &Choice::label) != axis.choices.end())
      place.fail(found_expected("the value '" + choice.label + "' twice", "each once"));
    else
      axis.choices.push_back(std::move(choice));
  };
  if (values.is_map()) {
    yaml::Map map = values.as_map();
    for (const auto& [label, overrides] : map.entries()) {
      Choice choice{label, {}, {}};
      read_overrides(overrides, choice.overrides, choice.origins);
      add(std::move(choice), overrides ? overrides : values);
    }
  } else {
    for (const yaml::Value& item : values.as_list())
      if (!item.is_scalar())
        item.fail(found_expected(
            item.found(), "a number or a word; other values need a label: " + axis.name + ": {LABEL: [PATH=VALUE]}"));
      else
        add({item.text(), {path + '=' + item.dump()}, {item.origin()}}, item);
  }
  if (axis.choices.empty()) values.fail("expected at least one value of " + path);
  return axis;
}

/// The end of each path that is enough to tell it from the others: "robots" for "world.robots".
void shorten_names(std::vector<Axis>& axes) {
  std::vector<std::string> names;
  for (const Axis& axis : axes) {
    std::size_t from = axis.name.rfind('.');
    const auto same = [&](const Axis& other) {
      return &other != &axis && ('.' + other.name).ends_with('.' + axis.name.substr(from + 1));
    };
    while (from != std::string::npos && std::any_of(axes.begin(), axes.end(), same))
      from = from == 0 ? std::string::npos : axis.name.rfind('.', from - 1);
    names.push_back(axis.name.substr(from + 1));  // of npos: the whole name
  }
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i].name = names[i];
}

/// A strategy for each combination of values, each on top of `base`; the last parameter varies fastest.
std::vector<Strategy> read_grid(const yaml::Value& value, const Strategy& base) {
  constexpr std::size_t kMost = 10000;
  std::vector<Axis> axes;
  yaml::Map map = value.as_map();
  for (const auto& [path, values] : map.entries()) {
    if (path.empty()) map.fail("expected the path of a parameter, as world.robots");
    if (std::ranges::find(axes, path, &Axis::name) != axes.end())
      map.fail(found_expected("'" + path + "' twice", "each once"));
    axes.push_back(read_axis(path, values));
  }
  shorten_names(axes);
  std::vector<Strategy> out;
  if (axes.empty()) {
    value.fail("expected parameters, each with its values: {world.robots: [1, 2, 3]}");
    return out;
  }
  std::size_t combinations = 1;
  for (const Axis& axis : axes) {
    if (axis.choices.empty()) return out;  // reported
    combinations *= axis.choices.size();
    if (combinations > kMost) {
      value.fail(found_expected("more than " + std::to_string(kMost) + " combinations", "fewer"));
      return out;
    }
  }
  for (std::size_t number = 0; number < combinations; ++number) {
    Strategy& strategy = out.emplace_back(base);
    std::size_t below = combinations, rest = number;
    for (const Axis& axis : axes) {
      below /= axis.choices.size();
      const Choice& choice = axis.choices[rest / below];
      rest %= below;
      strategy.name += (strategy.name.empty() ? "" : " ") + axis.name + '=' + choice.label;
      strategy.parameters.push_back({axis.name, choice.label});
      strategy.overrides.insert(strategy.overrides.end(), choice.overrides.begin(), choice.overrides.end());
      strategy.origins.insert(strategy.origins.end(), choice.origins.begin(), choice.origins.end());
    }
  }
  return out;
}

/// `NAME: [overrides]`, or `NAME: {set: [overrides], grid: {...}, tags: [...]}`.
std::vector<Strategy> read_strategy(const std::string& name, const yaml::Value& value) {
  Strategy strategy{name, {}};
  if (!value || !value.is_map()) {
    read_overrides(value, strategy.overrides, strategy.origins);
    return {strategy};
  }
  yaml::Map map = value.as_map();
  read_overrides(map.get("set"), strategy.overrides, strategy.origins);
  map.read("tags", strategy.tags);
  const yaml::Value grid = map.get("grid");
  std::vector<Strategy> out = grid ? read_grid(grid, strategy) : std::vector{strategy};
  map.finish();
  return out;
}

void add_strategies(std::vector<Strategy> more, const yaml::Value& place, std::vector<Strategy>& out) {
  for (Strategy& strategy : more)
    if (std::ranges::find(out, strategy.name, &Strategy::name) != out.end())
      place.fail(found_expected("strategy '" + strategy.name + "' twice", "each once"));
    else
      out.push_back(std::move(strategy));
}

/// What a suite says itself, a strategy cannot set: it would have no effect.
Status check_own_keys(const Suite& suite) {
  for (const Strategy& strategy : suite.strategies)
    for (std::size_t i = 0; i < strategy.overrides.size(); ++i) {
      const std::string path = strategy.overrides[i].substr(0, strategy.overrides[i].find('='));
      if (path == "seed" || (path == "tier" && !suite.tier.empty()))
        return input_error("strategy '" + strategy.name + "' sets " + strategy.overrides[i] + ", but the suite has `" +
                               (path == "seed" ? "seeds" : "tier") + "`, which wins: remove one of them",
                           strategy.origins[i]);
    }
  return {};
}

}  // namespace

Expected<Suite> Suite::load(const fs::path& file) {
  auto document = yaml::Document::load(file);
  if (!document) return document.error();
  Suite suite;
  suite.file = file;
  yaml::Map map = document->root().as_map();
  if (document->root().as_map().has("schema") && !map.has("scenarios"))
    return input_error("this is a scenario, and no suite; cxlab run plays it, and 'scenarios: [" +
                           file.filename().string() + "]' makes a suite of it",
                       file.string(), 1);
  if (const yaml::Value scenarios = map.require("scenarios")) {
    std::vector<fs::path> files;
    std::vector<Origin> origins;
    std::vector<std::string> names;
    for (const yaml::Value& item : scenarios.as_list()) {
      fs::path path = (file.parent_path() / item.as_string()).lexically_normal();
      if (!path_exists(path))
        if (const auto own = own_scenario(item.text())) path = *own;
      if (std::find(files.begin(), files.end(), path) != files.end()) {
        item.fail(found_expected("the scenario '" + item.text() + "' twice", "each once"));
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
  const yaml::Value grid = map.get("grid");
  if (const yaml::Value strategies = grid ? map.get("strategies") : map.require("strategies")) {
    yaml::Map names = strategies.as_map();
    for (const auto& [name, value] : names.entries()) {
      if (name.empty() || name.find('/') != name.npos)
        strategies.fail(found_text(name, "a name for the strategy, without '/'"));
      add_strategies(read_strategy(name, value), strategies, suite.strategies);
    }
  }
  if (grid) add_strategies(read_grid(grid, {}), grid, suite.strategies);
  map.read("tags", suite.tags);
  const yaml::Value games = map.get("games");
  if (games) {
    suite.games = read_games(games, file.parent_path());
    suite.games_origin = games.origin();
  }
  if (games && !map.has("seeds"))
    suite.seeds = {1};
  else if (const yaml::Value seeds = map.require("seeds"))
    suite.seeds = yaml::read_seeds(seeds);
  map.read_word("tier", suite.tier, {"timed", "physics"});
  if (const yaml::Value tier = map.get("tier")) suite.tier_origin = tier.origin();
  if (const yaml::Value require = map.get("require"))
    for (const yaml::Value& item : require.is_list() ? require.as_list() : std::vector{require})
      read_requirement(item, suite.require);
  if (const yaml::Value earlier = map.get("earlier")) {
    yaml::Map sweeps = earlier.as_map();
    for (const auto& [name, path] : sweeps.entries())
      suite.earlier.push_back({name, (file.parent_path() / path.as_string()).lexically_normal(), path.origin()});
  }
  map.finish();
  if (suite.scenarios.empty() || suite.strategies.empty() || suite.seeds.empty())
    map.fail("expected at least one scenario, strategy and seed");
  if (Status s = document->status(); !s) return s.error();
  if (Status s = check_own_keys(suite); !s) return s.error();
  return suite;
}

namespace {

Expected<Scenario> load_scenario(const Suite& suite, const fs::path& file, const std::vector<std::string>& overrides) {
  std::vector<Override> all;
  for (const std::string& set : overrides) all.emplace_back(set, set);
  return Scenario::load(file, *suite.catalogue, all);
}

}  // namespace

std::string shell_word(const std::string& text) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,+@%";
  return !text.empty() && text.find_first_not_of(kPlain) == text.npos ? text : in_quotes(text, kShellQuote);
}

std::vector<std::string> words_of_shell(const std::string& command) {
  std::vector<std::string> out;
  bool in_word = false, quoted = false;
  for (std::size_t i = 0; i < command.size(); ++i) {
    if (command[i] == ' ' && !quoted) {
      in_word = false;
      continue;
    }
    if (!in_word) out.emplace_back();
    in_word = true;
    if (command[i] == '\'')
      quoted = !quoted;
    else if (command[i] == '\\' && !quoted && i + 1 < command.size())
      out.back() += command[++i];
    else
      out.back() += command[i];
  }
  return out;
}

std::vector<std::string> portable_overrides(const Cell& cell) {
  std::vector<std::string> out = cell.overrides;
  for (std::string& item : out)
    if (!cell.game_override.empty() && item == cell.game_override)
      item = game_override(item.substr(0, item.find('=')), cell.game_file.filename().string());
  return out;
}

std::string title_of(const Cell& cell) {
  return cell.scenario + ' ' + cell.strategy + (cell.game.empty() ? "" : " game " + cell.game) + " seed " +
         std::to_string(cell.seed);
}

std::string command_of(const Cell& cell) {
  const std::string seed = std::to_string(cell.seed);
  std::string out = "cxlab run " + shell_word(fs::absolute(cell.file).lexically_normal().string());
  for (const std::string& item : cell.overrides) {
    if (item == "seed=" + seed) continue;
    const bool game = !cell.game_override.empty() && item == cell.game_override;
    out += " --set " + shell_word(game ? game_override(item.substr(0, item.find('=')),
                                                       fs::absolute(cell.game_file).lexically_normal().string())
                                       : item);
  }
  return out + " --seed " + seed;
}

std::size_t Suite::planned_games() const { return std::max<std::size_t>(1, games.size()) * seeds.size(); }

std::size_t Suite::size() const { return scenarios.size() * strategies.size() * planned_games(); }

std::vector<Cell> Suite::cells(std::size_t first, std::size_t last) const {
  std::vector<Cell> out;
  const std::size_t of_game = seeds.size(), of_strategy = planned_games(),
                    of_scenario = of_strategy * strategies.size();
  const SuiteScenario* scenario = nullptr;
  const Strategy* strategy = nullptr;
  std::string path_of_game;
  for (std::size_t i = first - 1; i < last; ++i) {
    const SuiteScenario& scenario_now = scenarios[i / of_scenario];
    const Strategy& strategy_now = strategies[i % of_scenario / of_strategy];
    if (&scenario_now != scenario || &strategy_now != strategy) {
      scenario = &scenario_now;
      strategy = &strategy_now;
      path_of_game.clear();
      if (!games.empty())
        if (const auto read = load_scenario(*this, scenario->file, strategy->overrides))
          path_of_game = games_path(*read->world.kind);
    }
    const SuiteGame game = games.empty() ? SuiteGame() : games[i % of_strategy / of_game];
    const std::uint64_t seed = seeds[i % of_game];
    Cell& cell =
        out.emplace_back(Cell{scenario->name, strategy->name, seed, scenario->file, strategy->overrides, game.name});
    if (!tier.empty()) cell.overrides.push_back("tier=" + tier);
    if (!path_of_game.empty())
      cell.overrides.push_back(cell.game_override = game_override(path_of_game, game.file.string()));
    cell.overrides.push_back("seed=" + std::to_string(seed));
    cell.named = scenario->named;
    cell.game_file = game.file;
    cell.parameters = strategy->parameters;
    cell.tags = tags;
    for (const std::string& tag : strategy->tags)
      if (std::ranges::find(tags, tag) == tags.end()) cell.tags.push_back(tag);
    cell.number = i + 1;
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

/// Whether the agents of this cell may read other rules than those of the first strategy do. A grid has many
/// combinations, and most differ in figures of the world.
bool may_have_other_rules(const Cell& cell, const Suite& suite) {
  return cell.strategy == suite.strategies.front().name ||
         std::ranges::any_of(cell.overrides, [](const std::string& set) {
           return set.starts_with("agents") || set.starts_with("packages");
         });
}

/// Begins a game as the sweep does, with its rules and up to its first tick, in a copy of this process.
Status begin_apart(const Scenario& scenario) {
  const Host host{.confine = true};
  auto child = Child::start([&]() -> Expected<Json> {
    PlayOptions options;
    options.out = "none";
    const auto begun = Session::load(options, scenario, host);
    return begun ? Expected<Json>(Json()) : begun.error();
  });
  if (!child) return child.error();
  const auto begun = child->finish(host);
  return begun ? Status() : begun.error();
}

}  // namespace

Status Suite::check() const {
  for (const SuiteScenario& scenario : scenarios) {
    const auto text = read_file(scenario.file);
    if (text) continue;
    const auto own = own_scenario(scenario.named);
    return input_error((own || path_exists(scenario.file) ? text.error() : own.error()).text(), scenario.origin);
  }
  for (const Cell& cell : cells()) {
    const bool first_game = games.empty() || cell.game == games.front().name;
    if (cell.seed != seeds.front() || (!first_game && cell.strategy != strategies.front().name)) continue;
    if (Status s = check(cell); !s) return s;
  }
  return {};
}

Status Suite::check(const Cell& cell) const {
  const auto wrong = [&](const Error& error) {
    const auto used = std::ranges::find(strategies, cell.strategy, &Strategy::name);
    const std::string what = "strategy '" + cell.strategy + "': " + error.text();
    if (!tier.empty() && error.text().starts_with("tier=")) return input_error(what, tier_origin);
    for (std::size_t i = 0; i < used->origins.size(); ++i)
      if (error.text().starts_with(used->overrides[i] + ':')) return input_error(what, used->origins[i]);
    return input_error(what);
  };
  auto scenario = load_scenario(*this, cell.file, cell.overrides);
  if (!scenario) return wrong(scenario.error());
  if (Status s = check_world(*scenario, *this); !s) return s;
  auto episode = Episode::load(*scenario, shared_episode_options());
  if (!episode) return wrong(episode.error());
  if (cell.seed != seeds.front() || !may_have_other_rules(cell, *this)) return {};
  const Status begun = begin_apart(*scenario);
  return begun || begun.error().kind != ErrorKind::kInput ? Status() : Status(wrong(begun.error()));
}

}  // namespace cxlab::lab
