#include "lab/sweep/score_tables.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "cx/base/number_text.h"
#include "lab/statistics/sequential.h"
#include "lab/statistics/statistics.h"
#include "lab/table_text.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

namespace {

using Kind = Column::Kind;
using statistics::Values;

TableCell number_cell(double value, int digits, bool with_sign = false) {
  if (std::isnan(value)) return {};
  TableCell out(value);
  out.shown = (with_sign && value >= 0 ? "+" : "") + fixed_text(value, digits);
  return out;
}

TableCell interval(const statistics::Interval& found, int digits) {
  if (std::isnan(found.low)) return {};
  TableCell out(TableCell::Stretch{found.low, found.high});
  out.shown = '[' + fixed_text(found.low, digits) + ", " + fixed_text(found.high, digits) + ']';
  return out;
}

TableCell count_cell(std::size_t n) { return TableCell(static_cast<std::int64_t>(n)); }

TableCell probability(double p) {
  TableCell out(p);
  out.shown = p < 0.0001 ? "< 0.0001" : fixed_text(p, 4);
  return out;
}

/// The figures of one strategy in one scenario.
struct Scores {
  std::string scenario, strategy;
  MetricOfRows metric;
  std::size_t episodes = 0;
  std::vector<double> values;
};

Expected<std::vector<Scores>> scores_of(const std::vector<Row>& rows, const std::string& metric,
                                        const Catalogue& catalogue) {
  const auto metrics = metrics_of_scenarios(rows, metric, catalogue);
  if (!metrics) return metrics.error();
  // A scenario without the figure has lines without values.
  const MetricOfRows lacking = metric.empty() ? MetricOfRows() : metrics->begin()->second;
  std::vector<Scores> out;
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  for (const Row& row : rows) {
    const auto [place, is_new] = places.try_emplace({row.cell.scenario, row.cell.strategy}, out.size());
    if (is_new) {
      const auto found = metrics->find(row.cell.scenario);
      out.push_back({row.cell.scenario, row.cell.strategy, found == metrics->end() ? lacking : found->second, 0, {}});
    }
    Scores& one = out[place->second];
    ++one.episodes;
    if (const auto value = row.counts() ? row.figure(one.metric.name) : std::nullopt) one.values.push_back(*value);
  }
  return out;
}

/// Takes a column out whose texts are all the same, and gives that text.
std::string take_common(Table& table, std::string_view key) {
  const auto column = std::ranges::find(table.columns, key, &Column::key);
  if (column == table.columns.end() || table.rows.empty()) return {};
  const auto at = static_cast<std::size_t>(column - table.columns.begin());
  const auto value = table.rows.front()[at].value;
  if (std::ranges::any_of(table.rows, [&](const auto& row) { return row[at].value != value; })) return {};
  drop_column(table, key);
  return std::get<std::string>(value);
}

/// The figures of the games of one strategy in one scenario.
std::vector<double> values_of(const std::vector<Row>& rows, const Scores& of, std::string_view metric) {
  std::vector<double> out;
  for (const Row& row : rows)
    if (row.cell.scenario == of.scenario && row.cell.strategy == of.strategy && row.counts())
      if (const auto value = row.figure(metric)) out.push_back(*value);
  return out;
}

/// Whether rows have a column of that metric, with figures or without: tables have the same columns then.
bool has_column(const Row& row, std::string_view metric) {
  return std::ranges::find(row.figures, metric, &Figure::metric) != row.figures.end();
}

std::string done_text(const Scores& scores) {
  return std::to_string(scores.values.size()) + '/' + std::to_string(scores.episodes);
}

}  // namespace

Table titled(Table table) {
  const std::string metric = take_common(table, "metric"), scenario = take_common(table, "scenario");
  table.title += (metric.empty() ? "" : ", " + metric) + (scenario.empty() ? "" : " in " + scenario);
  return table;
}

Expected<Table> score_table(const std::vector<Row>& rows, const std::string& metric, const Catalogue& catalogue) {
  const auto scores = scores_of(rows, metric, catalogue);
  if (!scores) return scores.error();
  Table table{"scores",
              "scores",
              {{"scenario", "scenario"},
               {"strategy", "strategy"},
               {"metric", "metric"},
               {"games", "games", Kind::kNumber},
               {"mean", "mean", Kind::kNumber},
               {"mean_95", "95 %", Kind::kNumber},
               {"median", "median", Kind::kNumber},
               {"median_95", "95 %", Kind::kNumber},
               {"iqm", "middle half", Kind::kNumber},
               {"iqm_95", "95 %", Kind::kNumber},
               {"min", "least", Kind::kNumber},
               {"max", "most", Kind::kNumber}},
              {}};
  for (const Scores& one : *scores) {
    const Values values = one.values;
    const int digits = one.metric.digits;
    TableCell games = count_cell(values.size());
    games.shown = done_text(one);
    std::vector<TableCell> row{one.scenario, one.strategy, one.metric.title, games};
    row.push_back(number_cell(statistics::mean(values), digits));
    row.push_back(interval(statistics::mean_interval_95(values), digits));
    for (double (*statistic)(Values) : {statistics::median, statistics::interquartile_mean}) {
      row.push_back(number_cell(statistic(values), digits));
      row.push_back(interval(statistics::interval_95(values, statistic), digits));
    }
    const auto [least, most] = std::ranges::minmax_element(values);
    row.push_back(values.empty() ? TableCell() : number_cell(*least, digits));
    row.push_back(values.empty() ? TableCell() : number_cell(*most, digits));
    table.rows.push_back(std::move(row));
  }
  return table;
}

namespace {

/// The metrics with a title of the worlds of these rows, without those that are compared; each once.
std::vector<const Metric*> further_metrics(const std::vector<Row>& rows, const Catalogue& catalogue) {
  std::vector<const Metric*> out;
  for (const Row& row : rows)
    if (const WorldKind* world = catalogue.find_world(row.world))
      for (const Metric* metric : metrics_of(*world))
        if (!metric->title.empty() && metric->name != row.compared && has_column(row, metric->name) &&
            std::ranges::find(out, metric->name, &Metric::name) == out.end())
          out.push_back(metric);
  return out;
}

}  // namespace

Expected<Table> overview_table(const std::vector<Row>& rows, const std::string& against, const Catalogue& catalogue) {
  const auto scores = scores_of(rows, "", catalogue);
  if (!scores) return scores.error();
  const auto answers = compare_strategies(rows, against, "", catalogue);
  if (!answers) return answers.error();
  Table table{"overview",
              "strategies",
              {{"scenario", "scenario"},
               {"strategy", "strategy"},
               {"metric", "metric"},
               {"games", "games", Kind::kNumber},
               {"mean", "mean", Kind::kNumber},
               {"mean_95", "95 %", Kind::kNumber},
               {"min", "least", Kind::kNumber}},
              {}};
  const std::vector<const Metric*> further = further_metrics(rows, catalogue);
  for (const Metric* metric : further)
    table.columns.push_back({std::string(metric->name), std::string(metric->title), Kind::kNumber});
  table.columns.push_back({"difference", "difference", Kind::kNumber});
  table.columns.push_back({"difference_95", "95 %", Kind::kNumber});
  for (const Scores& one : *scores) {
    const int digits = one.metric.digits;
    TableCell games = count_cell(one.values.size());
    games.shown = done_text(one);
    std::vector<TableCell> row{one.scenario,
                               one.strategy,
                               one.metric.title,
                               games,
                               number_cell(statistics::mean(one.values), digits),
                               interval(statistics::mean_interval_95(one.values), digits),
                               one.values.empty() ? TableCell() : number_cell(std::ranges::min(one.values), digits)};
    for (const Metric* metric : further)
      row.push_back(number_cell(statistics::mean(values_of(rows, one, metric->name)), metric->digits));
    const auto difference = std::ranges::find_if(*answers, [&one](const Answer& answer) {
      return answer.scenario == one.scenario && answer.strategy == one.strategy;
    });
    if (difference == answers->end()) {
      row.resize(row.size() + 2);
    } else {
      row.push_back(number_cell(statistics::mean(difference->values), digits, true));
      row.push_back(interval(statistics::interval_95(difference->values, statistics::mean), digits));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

namespace {

/// Some round numbers from the least value on.
std::vector<double> thresholds_between(double least, double most) {
  constexpr int kSteps = 8;
  const double raw = (most - least) / kSteps;
  if (!(raw > 0)) return {least};
  const double tens = std::pow(10, std::floor(std::log10(raw)));
  const double step = raw <= tens ? tens : raw <= 2 * tens ? 2 * tens : raw <= 5 * tens ? 5 * tens : 10 * tens;
  std::vector<double> out;
  for (double i = std::ceil(least / step); i * step <= most; ++i) out.push_back(i * step);
  return out;
}

}  // namespace

Expected<Table> profile_table(const std::vector<Row>& rows, const std::string& metric, const Catalogue& catalogue) {
  const auto scores = scores_of(rows, metric, catalogue);
  if (!scores) return scores.error();
  struct OfMetric {
    std::string name;
    std::vector<double> values{}, thresholds{};
  };
  std::vector<OfMetric> metrics;
  const auto of_metric = [&metrics](const Scores& one) {
    return std::ranges::find(metrics, one.metric.name, &OfMetric::name);
  };
  for (const Scores& one : *scores) {
    auto found = of_metric(one);
    if (found == metrics.end()) found = metrics.insert(metrics.end(), {one.metric.name});
    found->values.insert(found->values.end(), one.values.begin(), one.values.end());
  }
  if (std::ranges::all_of(metrics, [](const OfMetric& one) { return one.values.empty(); }))
    return input_error("no game was completed");
  for (OfMetric& one : metrics)
    if (!one.values.empty())
      one.thresholds = thresholds_between(std::ranges::min(one.values), std::ranges::max(one.values));
  Table table{"profile",
              "share of games that reach a figure",
              {{"scenario", "scenario"}, {"strategy", "strategy"}, {"metric", "metric"}},
              {}};
  const auto key_of = [](const Scores& one, const std::string& threshold) {
    return (one.metric.more_is_better ? "at_least_" : "at_most_") + threshold;
  };
  const auto column_of = [&table](const std::string& key) {
    return static_cast<std::size_t>(std::ranges::find(table.columns, key, &Column::key) - table.columns.begin());
  };
  for (const Scores& one : *scores)
    for (const double threshold : of_metric(one)->thresholds) {
      const std::string text = general_text(threshold, 6), key = key_of(one, text);
      if (column_of(key) == table.columns.size())
        table.columns.push_back({key, (one.metric.more_is_better ? ">= " : "<= ") + text, Kind::kShare});
    }
  for (const Scores& one : *scores) {
    std::vector<TableCell> row{one.scenario, one.strategy, one.metric.title};
    row.resize(table.columns.size());
    const std::vector<double>& thresholds = of_metric(one)->thresholds;
    const std::vector<double> shares = statistics::profile(one.values, thresholds, one.metric.more_is_better);
    for (std::size_t i = 0; i < thresholds.size() && !one.values.empty(); ++i) {
      TableCell& cell = row[column_of(key_of(one, general_text(thresholds[i], 6)))];
      cell = TableCell(shares[i]);
      cell.shown = fixed_text(100 * shares[i], 0) + " %";
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Expected<std::vector<const Metric*>> parts_of(const std::vector<Row>& rows, const std::string& metric,
                                              const Catalogue& catalogue, const std::string* scenario) {
  std::vector<const Metric*> parts, out;
  std::vector<std::string> names, whole;
  std::set<const WorldKind*> worlds;
  for (const Row& row : rows) {
    if (scenario && row.cell.scenario != *scenario) continue;
    const WorldKind* const world = catalogue.find_world(row.world);
    if (!world || !worlds.insert(world).second) continue;
    for (const Metric& one : world->metrics) {
      if (one.part_of == metric) names.emplace_back(parts.emplace_back(&one)->name);
      if (std::string of(one.part_of); !of.empty() && std::ranges::find(whole, of) == whole.end())
        whole.push_back(std::move(of));
    }
  }
  if (parts.empty())
    return input_error(metric + " has no parts" +
                       (whole.empty() ? ", nor has another metric of this world"
                                      : "; expected a metric that has some: " + some_of(whole)));
  std::ranges::copy_if(parts, std::back_inserter(out), [&rows](const Metric* part) {
    return std::ranges::any_of(rows, [part](const Row& row) { return has_column(row, part->name); });
  });
  if (out.empty())
    return input_error("no row has the parts of " + metric + "; expected some of the columns " + some_of(names, 8));
  return out;
}

Expected<Table> part_table(const std::vector<Row>& rows, const std::string& metric, const Catalogue& catalogue) {
  const auto whole = scores_of(rows, metric, catalogue);
  if (!whole) return whole.error();
  Table table{"parts", "means by kind", {{"scenario", "scenario"}, {"strategy", "strategy"}, {"metric", "metric"}}, {}};
  table.columns.push_back({"mean", "mean", Kind::kNumber});
  std::map<std::string, std::vector<const Metric*>> of_scenario;  // scenarios whose figure has parts
  std::vector<const Metric*> all;
  Status none;
  for (const Scores& one : *whole) {
    if (of_scenario.contains(one.scenario)) continue;
    auto parts = parts_of(rows, one.metric.name, catalogue, &one.scenario);
    if (!parts) {
      if (none) none = parts.error();
      continue;
    }
    for (const Metric* part : *parts)
      if (std::ranges::find(all, part) == all.end()) all.push_back(part);
    of_scenario[one.scenario] = *std::move(parts);
  }
  if (of_scenario.empty() && !none) return none.error();
  for (const Metric* part : all)
    table.columns.push_back({std::string(part->name), std::string(part->what), Kind::kNumber});
  for (const Scores& one : *whole) {
    std::vector<TableCell> row{one.scenario, one.strategy, one.metric.title};
    row.push_back(number_cell(statistics::mean(one.values), one.metric.digits));
    const std::vector<const Metric*>& parts = of_scenario[one.scenario];
    for (const Metric* part : all)
      row.push_back(std::ranges::find(parts, part) == parts.end()
                        ? TableCell()
                        : number_cell(statistics::mean(values_of(rows, one, part->name)), part->digits));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<double> shares_of(const Answer& answer) {
  std::vector<double> out;
  for (std::size_t i = 0; i < answer.first.size(); ++i)
    if (answer.first[i] > 0) out.push_back(answer.second[i] / answer.first[i]);
  return out;
}

Expected<Table> share_table(const std::vector<Row>& rows, const std::string& against, const std::string& metric,
                            const Catalogue& catalogue) {
  const auto answers = compare_strategies(rows, against, metric, catalogue);
  if (!answers) return answers.error();
  Table table{"shares",
              "share in the same game",
              {{"scenario", "scenario"},
               {"strategy", "strategy"},
               {"against", "of"},
               {"metric", "metric"},
               {"games", "pairs", Kind::kNumber},
               {"share", "share", Kind::kShare},
               {"share_95", "95 %"},
               {"min", "least", Kind::kShare},
               {"max", "most", Kind::kShare}},
              {}};
  const auto percent = [](double share) {
    if (std::isnan(share)) return TableCell();
    TableCell out(share);
    out.shown = fixed_text(100 * share, 1) + " %";
    return out;
  };
  for (const Answer& one : *answers) {
    const std::vector<double> shares = shares_of(one);
    const statistics::Interval within = statistics::mean_interval_95(shares);
    TableCell shown;
    if (!std::isnan(within.low)) {
      shown = TableCell(TableCell::Stretch{within.low, within.high});
      shown.shown = '[' + fixed_text(100 * within.low, 1) + ", " + fixed_text(100 * within.high, 1) + "] %";
    }
    std::vector<TableCell> row{one.scenario, one.strategy, one.asked, one.metric.title, count_cell(shares.size())};
    row.push_back(percent(statistics::mean(shares)));
    row.push_back(shown);
    row.push_back(shares.empty() ? TableCell() : percent(std::ranges::min(shares)));
    row.push_back(shares.empty() ? TableCell() : percent(std::ranges::max(shares)));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table difference_table(const std::vector<Answer>& answers) {
  Table table{"differences",
              "differences",
              {{"scenario", "scenario"},
               {"strategy", "strategy"},
               {"against", "against"},
               {"metric", "metric"},
               {"games", "pairs", Kind::kNumber},
               {"difference", "difference", Kind::kNumber},
               {"difference_95", "95 %", Kind::kNumber},
               {"effect", "effect", Kind::kNumber},
               {"improvement", "P(better)", Kind::kShare},
               {"won", "won", Kind::kNumber},
               {"drawn", "drawn", Kind::kNumber},
               {"lost", "lost", Kind::kNumber},
               {"p", "p", Kind::kNumber},
               {"p_holm", "p (Holm)", Kind::kNumber},
               {"answer", "answer"},
               {"more_games", "more games", Kind::kNumber}},
              {}};
  std::vector<double> p;
  for (const Answer& one : answers)
    if (one.is_difference) p.push_back(statistics::sign_flip_p(one.values));
  std::size_t row = 0;
  for (const Answer& one : answers) {
    if (!one.is_difference) continue;
    const double own_p = p[row++];
    const int digits = one.metric.digits;
    const bool more = one.metric.more_is_better;
    const Values values = one.values;
    const double effect = statistics::effect_size(values);
    statistics::Counts signs = statistics::count_signs(values);
    if (!more) std::swap(signs.above, signs.below);
    const double improved = more ? statistics::probability_of_improvement(one.first, one.second)
                                 : statistics::probability_of_improvement(one.second, one.first);
    TableCell more_games;
    const bool always_the_same = std::isnan(effect) && !values.empty() && values.front() != 0;
    if (one.judgement == Judgement::kUndecided && (always_the_same || effect > 0 || effect < 0)) {
      constexpr double kMost = 100000;
      // Holm multiplies p by the number of comparisons that are no clearer than this one.
      const auto compared =
          static_cast<std::size_t>(std::ranges::count_if(p, [own_p](double other) { return other >= own_p; }));
      const double needed =
          std::max(statistics::pairs_needed(effect, statistics::kLastLevel / static_cast<double>(compared)),
                   static_cast<double>(statistics::fewest_games(statistics::Question::About::kDifferences, compared))) -
          static_cast<double>(values.size());
      if (needed > kMost)
        more_games.shown = "> 100000";
      else
        more_games = count_cell(static_cast<std::size_t>(std::max(1.0, needed)));
    }
    TableCell share;
    if (!std::isnan(improved)) {
      share = TableCell(improved);
      share.shown = fixed_text(100 * improved, 0) + " %";
    }
    table.rows.push_back({one.scenario, one.strategy, one.asked, one.metric.title, count_cell(values.size()),
                          number_cell(statistics::mean(values), digits, true),
                          interval(statistics::mean_interval_95(values), digits), number_cell(effect, 2, true), share,
                          count_cell(signs.above), count_cell(signs.equal), count_cell(signs.below), probability(own_p),
                          probability(one.p), TableCell(to_string(one.judgement)), more_games});
  }
  return table;
}

Table requirement_table(const std::vector<Answer>& answers) {
  Table table{"requirements",
              "requirements",
              {{"scenario", "scenario"},
               {"strategy", "strategy"},
               {"requirement", "requirement"},
               {"metric", "metric"},
               {"answer", "answer"},
               {"after", "after games", Kind::kNumber},
               {"found", "found", Kind::kNumber},
               {"found_95", "95 %", Kind::kNumber},
               {"games", "pairs or games", Kind::kNumber},
               {"p_holm", "p (Holm)", Kind::kNumber}},
              {}};
  for (const Answer& one : answers)
    table.rows.push_back({one.scenario, one.strategy, one.asked, one.metric.title, TableCell(to_string(one.judgement)),
                          count_cell(one.after),
                          number_cell(statistics::mean(one.values), one.metric.digits, one.is_difference),
                          interval(statistics::mean_interval_95(one.values), one.metric.digits),
                          count_cell(one.values.size()), probability(one.p)});
  return table;
}

std::vector<std::string> remarks_on(const std::vector<Answer>& answers) {
  using About = statistics::Question::About;
  std::vector<std::string> out;
  const auto add = [&out](std::string line) {  // two requirements may have the same to say
    if (std::ranges::find(out, line) == out.end()) out.push_back(std::move(line));
  };
  for (const Answer& one : answers) {
    const std::string who = one.scenario + ", " + one.strategy + ": ";
    if (one.lost > 0)
      add(who + "worse, because " + count_text(one.lost, "game") + (one.lost == 1 ? " was" : " were") +
          " not completed" + (one.is_difference ? " that the other side completed" : ""));
    if (one.gained > 0)
      add(who + count_text(one.gained, "game") + (one.gained == 1 ? " was" : " were") +
          " completed that the other side did not complete; they count in no difference");
    const bool by_signs = one.is_difference && one.bound == 0;
    const std::size_t fewest = statistics::fewest_games(by_signs ? About::kDifferences : About::kMean, answers.size());
    if (one.judgement == Judgement::kUndecided && one.values.size() < fewest)
      add(who + found_expected(one.is_difference ? count_text(one.values.size(), "pair") + " of games"
                                                 : count_text(one.values.size(), "game"),
                               "at least " + std::to_string(fewest) + " to answer anything; add " +
                                   (one.of_folder ? "games to the suite's folder of games" : "seeds to the suite")));
  }
  return out;
}

std::vector<std::size_t> worst_games(const Answer& answer) {
  constexpr std::size_t kMost = 3;
  std::vector<std::size_t> out(answer.values.size());
  std::iota(out.begin(), out.end(), std::size_t{0});
  std::ranges::stable_sort(out, {}, [&answer](std::size_t i) {
    return answer.metric.more_is_better ? answer.values[i] : -answer.values[i];
  });
  out.resize(std::min(out.size(), kMost));
  return out;
}

}  // namespace cxlab::lab
