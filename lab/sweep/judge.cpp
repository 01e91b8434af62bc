#include "lab/sweep/judge.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "lab/statistics/sequential.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"
#include "scenarios/scenario.h"

namespace cxlab::lab {

std::string_view to_string(Judgement judgement) {
  switch (judgement) {
    case Judgement::kBetter: return "better";
    case Judgement::kWorse: return "worse";
    case Judgement::kUndecided: break;
  }
  return "undecided";
}

int exit_code_of(const std::vector<Answer>& answers) {
  const auto any = [&answers](Judgement judgement) {
    return std::ranges::find(answers, judgement, &Answer::judgement) != answers.end();
  };
  if (any(Judgement::kWorse)) return static_cast<int>(ErrorKind::kNo);
  return any(Judgement::kUndecided) ? kUndecidedExit : 0;
}

namespace {

using statistics::Question;
using Game = std::pair<std::string, std::uint64_t>;      // game and seed
using Contestant = std::pair<std::string, std::string>;  // scenario and strategy
using RowsOfGames = std::map<Game, const Row*>;

/// Rows by scenario and strategy, and by game; in the order in which they come.
struct Sorted {
  explicit Sorted(const std::vector<Row>& rows) {
    std::map<std::string, std::set<Game>> known;  // by scenario
    for (const Row& row : rows) {
      const Contestant contestant{row.cell.scenario, row.cell.strategy};
      if (!of.contains(contestant)) order.push_back(contestant);
      of[contestant].emplace(Game{row.cell.game, row.cell.seed}, &row);
      const Game game{row.cell.game, row.cell.seed};
      if (known[row.cell.scenario].insert(game).second) games_of[row.cell.scenario].push_back(game);
    }
  }
  std::map<Contestant, RowsOfGames> of;
  std::vector<Contestant> order;
  std::map<std::string, std::vector<Game>> games_of;  ///< of a scenario

  std::vector<std::string> strategies_in(const std::string& scenario) const {
    std::vector<std::string> out;
    for (const Contestant& contestant : order)
      if (contestant.first == scenario) out.push_back(contestant.second);
    return out;
  }
};

std::optional<double> figure_of(const RowsOfGames& rows, const Game& game, const std::string& metric) {
  const auto found = rows.find(game);
  return found == rows.end() || !found->second->counts() ? std::nullopt : found->second->figure(metric);
}

/// Whether this game was played, and not to its end.
bool is_incomplete(const RowsOfGames& rows, const Game& game) {
  const auto found = rows.find(game);
  return found != rows.end() && !found->second->counts();
}

const RowsOfGames* rows_of(const Sorted& rows, const Contestant& contestant) {
  const auto found = rows.of.find(contestant);
  return found == rows.of.end() ? nullptr : &found->second;
}

/// With whom an earlier sweep is compared: the strategy of the same name, else its only one. nullptr: there is none.
const RowsOfGames* opponent(const Sorted& before, const Contestant& contestant) {
  if (const RowsOfGames* same = rows_of(before, contestant)) return same;
  const std::vector<std::string> there = before.strategies_in(contestant.first);
  return there.size() == 1 ? rows_of(before, {contestant.first, there.front()}) : nullptr;
}

/// Games of a folder have names.
bool are_of_folder(const std::vector<Game>& games) { return !games.empty() && !games.front().first.empty(); }

/// An answer that waits for its judgement, and the question of it.
struct Asked {
  Answer answer;
  Question question;
};

/// Above 0 is better.
Asked ask_mean(const RowsOfGames& rows, const std::vector<Game>& games, double bound, bool at_least, Answer answer) {
  Asked out{std::move(answer), {Question::About::kMean, {}}};
  out.answer.bound = bound;
  out.answer.of_folder = are_of_folder(games);
  for (const Game& game : games) {
    const auto value = figure_of(rows, game, out.answer.metric.name);
    if (value) {
      out.answer.values.push_back(*value);
      out.answer.games.push_back(game);
    }
    out.question.values.push_back(value ? std::optional(at_least ? *value - bound : bound - *value) : std::nullopt);
    if (is_incomplete(rows, game)) ++out.answer.lost;
  }
  return out;
}

Asked ask_difference(const RowsOfGames& first, const RowsOfGames& second, const std::vector<Game>& games, double margin,
                     Answer answer) {
  // With a margin, differences do not have either sign alike if nothing differs.
  Asked out{std::move(answer), {margin == 0 ? Question::About::kDifferences : Question::About::kMean, {}}};
  const MetricOfRows& metric = out.answer.metric;
  out.answer.is_difference = true;
  out.answer.of_folder = are_of_folder(games);
  out.answer.bound = metric.more_is_better ? -margin : margin;
  for (const Game& game : games) {
    const auto a = figure_of(first, game, metric.name), b = figure_of(second, game, metric.name);
    out.question.values.emplace_back();
    if (a && is_incomplete(second, game)) ++out.answer.lost;
    if (b && is_incomplete(first, game)) ++out.answer.gained;
    if (!a || !b) continue;
    out.answer.first.push_back(*a);
    out.answer.second.push_back(*b);
    out.answer.values.push_back(*b - *a);
    out.answer.games.push_back(game);
    out.question.values.back() = (metric.more_is_better ? *b - *a : *a - *b) + margin;
  }
  return out;
}

std::vector<Answer> answers_of(std::vector<Asked> asked, const std::vector<std::size_t>& look_after) {
  std::vector<Question> questions;
  for (Asked& one : asked) questions.push_back(std::move(one.question));
  const std::vector<statistics::Decision> decisions = statistics::decide(questions, look_after);
  std::vector<Answer> out;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    Answer& answer = out.emplace_back(std::move(asked[i].answer));
    answer.after = decisions[i].after;
    answer.p = decisions[i].p;
    // A game that is not completed is a defect by itself: the figures of the others say nothing of it.
    if (decisions[i].side == statistics::Side::kBelow || answer.lost > 0)
      answer.judgement = Judgement::kWorse;
    else if (decisions[i].side == statistics::Side::kAbove)
      answer.judgement = Judgement::kBetter;
  }
  return out;
}

}  // namespace

namespace {

/// Every scenario's world has the metrics that requirements name.
Status check_metric_names(const Suite& suite) {
  MetricNames names;
  for (const SuiteScenario& one : suite.scenarios) {
    std::vector<Override> overrides;
    for (const std::string& set : suite.strategies.front().overrides) overrides.emplace_back(set, set);
    const auto scenario = Scenario::load(one.file, *suite.catalogue, overrides);
    if (!scenario) return scenario.error();
    auto& of_world = names.emplace_back(one.name, std::vector<std::string>()).second;
    for (const Metric* metric : metrics_of(*scenario->world.kind)) of_world.emplace_back(metric->name);
  }
  for (const Requirement& requirement : suite.require) {
    if (requirement.metric.empty()) continue;
    const std::string& metric = requirement.metric;
    const auto lacks = [&metric](const auto& one) { return std::ranges::count(one.second, metric) == 0; };
    const auto one = std::ranges::find_if(names, lacks);
    if (one == names.end()) continue;
    const bool some_have = !std::ranges::all_of(names, lacks);
    return input_error("'" + requirement.text + "': the world of " + one->first + " has no metric '" + metric + "'; " +
                           metrics_text(metric, names) +
                           (some_have ? "; scenarios of different worlds need suites of their own for it" : ""),
                       requirement.origin);
  }
  return {};
}

Status check_names(const Requirement& requirement, const std::vector<std::string>& strategies,
                   const std::vector<std::string>& names) {
  const auto wrong = [&](const std::string& what) {
    return input_error("'" + requirement.text + "': " + what, requirement.origin);
  };
  const std::string& of = requirement.strategy;
  if (!of.empty() && std::ranges::find(strategies, of) == strategies.end())
    return wrong("there is no strategy '" + of + "'; there are " + some_of_and_nearest(of, strategies, 8));
  if (requirement.kind != Requirement::Kind::kNotWorse) return {};
  if (std::ranges::find(names, requirement.than) == names.end())
    return wrong("there is no strategy and no earlier sweep '" + requirement.than + "'; there are " +
                 some_of(names, 8) + " (a sweep gets a name by 'earlier: {NAME: FOLDER}')" +
                 did_you_mean(requirement.than, names, "; "));
  if (requirement.than == of || strategies == std::vector{requirement.than})
    return wrong("no other strategy is compared with '" + requirement.than + "'");
  return {};
}

/// The earlier sweep has what the requirement compares.
Status check_earlier(const Requirement& requirement, const std::vector<Row>& rows, const Suite& suite) {
  const Sorted before(rows);
  for (const SuiteScenario& scenario : suite.scenarios)
    for (const Strategy& strategy : suite.strategies) {
      if (!requirement.strategy.empty() && strategy.name != requirement.strategy) continue;
      const std::vector<std::string> there = before.strategies_in(scenario.name);
      const RowsOfGames* const games = opponent(before, {scenario.name, strategy.name});
      if (!games)
        return input_error("'" + requirement.text + "': " + requirement.than + " has no " +
                               (there.empty() ? "scenario '" + scenario.name + "'"
                                              : "strategy '" + strategy.name + "' in " + scenario.name +
                                                    "; there are " + some_of(there, 8)),
                           requirement.origin);
      const bool common = std::ranges::any_of(*games, [&suite](const auto& game) {
        const auto& [name, seed] = game.first;
        return std::ranges::find(suite.seeds, seed) != suite.seeds.end() &&
               (suite.games.empty() || std::ranges::find(suite.games, name, &SuiteGame::name) != suite.games.end());
      });
      if (!common)
        return input_error("'" + requirement.text + "': " + requirement.than + " has no game of " + scenario.name +
                               " that this suite plays; differences are taken in the same games, so expected the same "
                               "seeds",
                           requirement.origin);
    }
  return {};
}

}  // namespace

Expected<Judge> Judge::make(const Suite& suite) {
  Judge judge;
  judge.requirements_ = suite.require;
  judge.catalogue_ = suite.catalogue;
  std::vector<std::string> strategies;
  for (const Strategy& strategy : suite.strategies) strategies.push_back(strategy.name);
  std::vector<std::string> names = strategies;
  for (const EarlierSweep& sweep : suite.earlier) {
    if (std::ranges::find(names, sweep.name) != names.end())
      return input_error("earlier: '" + sweep.name + "' is the name of a strategy, too; expected another one",
                         sweep.origin);
    names.push_back(sweep.name);
    if (std::ranges::find(suite.require, sweep.name, &Requirement::than) == suite.require.end())
      return input_error(
          "earlier: no requirement names '" + sweep.name + "', expected 'not worse than " + sweep.name + "' in require",
          sweep.origin);
    auto rows = read_rows(sweep.path, *suite.catalogue);
    if (!rows) return input_error("earlier: '" + sweep.name + "': " + rows.error().text(), sweep.origin);
    judge.earlier_.emplace_back(sweep.name, *std::move(rows));
  }
  for (const Requirement& one : suite.require)
    if (Status s = check_names(one, strategies, names); !s) return s.error();
  if (Status s = check_metric_names(suite); !s) return s.error();
  for (const auto& [name, rows] : judge.earlier_)
    for (const Requirement& one : suite.require)
      if (one.than == name)
        if (Status s = check_earlier(one, rows, suite); !s) return s.error();
  return judge;
}

Expected<std::vector<Answer>> Judge::judge(const std::vector<Row>& rows,
                                           const std::vector<std::size_t>& look_after) const {
  const Sorted sorted(rows);
  std::vector<Asked> asked;
  for (const Requirement& requirement : requirements_) {
    const auto earlier = std::ranges::find(earlier_, requirement.than, [](const auto& one) { return one.first; });
    const std::optional<Sorted> before =
        earlier == earlier_.end() ? std::nullopt : std::optional<Sorted>(std::in_place, earlier->second);
    for (const Contestant& contestant : sorted.order) {
      const auto& [scenario, strategy] = contestant;
      if (!requirement.strategy.empty() && strategy != requirement.strategy) continue;
      if (strategy == requirement.than) continue;
      auto metric = metric_of(rows, requirement.metric, *catalogue_, &scenario);
      if (!metric && before) metric = metric_of(earlier->second, requirement.metric, *catalogue_, &scenario);
      const bool any = std::ranges::any_of(
          rows, [&scenario](const Row& row) { return row.cell.scenario == scenario && row.counts(); });
      if (!metric && !any)  // no game was completed: the answer needs no figure
        metric = MetricOfRows{requirement.metric, requirement.metric};
      if (!metric)
        return at(requirement.origin,
                  input_error("'" + requirement.text + "', " + scenario + ": " + metric.error().message));
      Answer answer;
      answer.scenario = scenario;
      answer.strategy = strategy;
      answer.asked = requirement.text;
      answer.metric = *metric;
      const std::vector<Game>& games = sorted.games_of.at(scenario);
      const RowsOfGames& mine = sorted.of.at(contestant);
      if (requirement.kind != Requirement::Kind::kNotWorse) {
        asked.push_back(
            ask_mean(mine, games, requirement.bound, requirement.kind == Requirement::Kind::kAtLeast, answer));
        continue;
      }
      const RowsOfGames* const other =
          before ? opponent(*before, contestant) : rows_of(sorted, {scenario, requirement.than});
      static const RowsOfGames kNone;
      asked.push_back(ask_difference(other ? *other : kNone, mine, games, requirement.bound, answer));
    }
  }
  return answers_of(std::move(asked), look_after);
}

Expected<std::vector<Answer>> compare_sweeps(const std::vector<Row>& before, const std::vector<Row>& now,
                                             const std::string& metric, std::vector<std::string>& notes,
                                             const Catalogue& catalogue) {
  const Sorted old_rows(before), new_rows(now);
  std::vector<Asked> asked;
  std::set<Contestant> used;
  std::size_t most = 0;
  bool lacks_metric = false;
  for (const Contestant& contestant : new_rows.order) {
    const auto& [scenario, strategy] = contestant;
    const std::vector<std::string> here = new_rows.strategies_in(scenario), there = old_rows.strategies_in(scenario);
    Contestant other = contestant;
    if (!old_rows.of.contains(contestant) && here.size() == 1 && there.size() == 1) other.second = there.front();
    if (!old_rows.of.contains(other)) {
      notes.push_back(scenario + ", " + strategy + " is in the new sweep only");
      continue;
    }
    used.insert(other);
    auto found = metric_of(now, metric, catalogue, &scenario);
    if (!found) found = metric_of(before, metric, catalogue, &other.first);
    if (!found) {
      notes.push_back(scenario + ", " + strategy + ": " + found.error().message);
      lacks_metric = true;
      continue;
    }
    Answer answer;
    answer.scenario = scenario;
    answer.strategy = strategy;
    answer.asked = other.second;
    answer.metric = *found;
    const RowsOfGames &first = old_rows.of.at(other), &second = new_rows.of.at(contestant);
    std::vector<Game> games;
    for (const Game& game : new_rows.games_of.at(scenario))
      if (first.contains(game) && second.contains(game)) games.push_back(game);
    if (games.empty()) {
      notes.push_back(scenario + ", " + strategy + ": the sweeps have no game in common");
      continue;
    }
    if (const std::size_t apart = std::max(first.size(), second.size()) - games.size(); apart > 0)
      notes.push_back(scenario + ", " + strategy + ": " + std::to_string(games.size()) +
                      " games are in both sweeps, and " +
                      std::to_string(first.size() + second.size() - 2 * games.size()) + " in one only");
    most = std::max(most, games.size());
    asked.push_back(ask_difference(first, second, games, 0, answer));
  }
  for (const Contestant& contestant : old_rows.order)
    if (!used.contains(contestant))
      notes.push_back(contestant.first + ", " + contestant.second + " is in the old sweep only");
  if (asked.empty() && lacks_metric)
    if (const auto any = metric_of(now, metric, catalogue); !any) return any.error();
  if (asked.empty()) {
    std::string why;
    for (const std::string& note : notes) why += "; " + note;
    return input_error("the sweeps have no scenario, strategy and game in common" + why +
                       "; expected the same scenarios and seeds in both");
  }
  for (Asked& one : asked) one.question.values.resize(most);
  return answers_of(std::move(asked), {most});
}

Status check_strategy(const std::vector<Row>& rows, const std::string& name) {
  std::vector<std::string> names;
  for (const Row& row : rows) {
    if (name.empty() || row.cell.strategy == name) return {};
    if (std::ranges::find(names, row.cell.strategy) == names.end()) names.push_back(row.cell.strategy);
  }
  return input_error("there is no strategy '" + name + "'; there are " + some_of_and_nearest(name, names, 8));
}

Expected<std::vector<Answer>> compare_strategies(const std::vector<Row>& rows, const std::string& against,
                                                 const std::string& metric, const Catalogue& catalogue) {
  const Sorted sorted(rows);
  std::vector<Asked> asked;
  std::size_t most = 0;
  if (Status s = check_strategy(rows, against); !s) return s.error();
  const auto metrics = metrics_of_scenarios(rows, metric, catalogue);
  if (!metrics) return metrics.error();
  for (const Contestant& contestant : sorted.order) {
    const auto& [scenario, strategy] = contestant;
    const std::string first = against.empty() ? sorted.strategies_in(scenario).front() : against;
    const auto found = metrics->find(scenario);
    if (strategy == first || !sorted.of.contains({scenario, first}) || found == metrics->end()) continue;
    Answer answer;
    answer.scenario = scenario;
    answer.strategy = strategy;
    answer.asked = first;
    answer.metric = found->second;
    const std::vector<Game>& games = sorted.games_of.at(scenario);
    most = std::max(most, games.size());
    asked.push_back(ask_difference(sorted.of.at({scenario, first}), sorted.of.at(contestant), games, 0, answer));
  }
  for (Asked& one : asked) one.question.values.resize(most);
  return answers_of(std::move(asked), {most});
}

}  // namespace cxlab::lab
