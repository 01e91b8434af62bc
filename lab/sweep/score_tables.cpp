#include "lab/sweep/score_tables.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

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
  std::map<std::string, MetricOfRows> metrics;
  for (const Row& row : rows) {
    const std::string& scenario = row.cell.scenario;
    if (metrics.contains(scenario)) continue;
    const auto found = metric_of(rows, metric, catalogue, &scenario);
    if (!found) return input_error(scenario + ": " + found.error().message);
    metrics[scenario] = *found;
  }
  std::vector<Scores> out;
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  for (const Row& row : rows) {
    const auto [place, is_new] = places.try_emplace({row.cell.scenario, row.cell.strategy}, out.size());
    if (is_new) out.push_back({row.cell.scenario, row.cell.strategy, metrics.at(row.cell.scenario), 0, {}});
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

/// "differences, points in game"
void set_title(Table& table, const std::string& what) {
  const std::string metric = take_common(table, "metric"), scenario = take_common(table, "scenario");
  table.title = what + (metric.empty() ? "" : ", " + metric) + (scenario.empty() ? "" : " in " + scenario);
}

std::string done_text(const Scores& scores) {
  return std::to_string(scores.values.size()) + '/' + std::to_string(scores.episodes);
}

}  // namespace

Expected<Table> score_table(const std::vector<Row>& rows, const std::string& metric, const Catalogue& catalogue) {
  const auto scores = scores_of(rows, metric, catalogue);
  if (!scores) return scores.error();
  Table table{"scores",
              "",
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
  set_title(table, "scores");
  return table;
}

namespace {

/// The metrics with a title of the worlds of these rows, without those that are compared; each once.
std::vector<std::string> further_metrics(const std::vector<Row>& rows, const Catalogue& catalogue) {
  std::vector<std::string> out;
  for (const Row& row : rows)
    if (const WorldKind* world = catalogue.find_world(row.world))
      for (const Metric* metric : metrics_of(*world)) {
        const std::string name(metric->name);
        if (!metric->title.empty() && name != row.compared && row.figure(name) &&
            std::ranges::find(out, name) == out.end())
          out.push_back(name);
      }
  return out;
}

}  // namespace

Expected<Table> overview_table(const std::vector<Row>& rows, const std::string& against, const Catalogue& catalogue) {
  const auto scores = scores_of(rows, "", catalogue);
  if (!scores) return scores.error();
  const auto answers = compare_strategies(rows, against, "", catalogue);
  if (!answers) return answers.error();
  Table table{"overview",
              "",
              {{"scenario", "scenario"},
               {"strategy", "strategy"},
               {"metric", "metric"},
               {"games", "games", Kind::kNumber},
               {"mean", "mean", Kind::kNumber},
               {"mean_95", "95 %", Kind::kNumber},
               {"min", "least", Kind::kNumber}},
              {}};
  const std::vector<std::string> further = further_metrics(rows, catalogue);
  std::map<std::string, std::vector<Scores>> of_metric;
  for (const std::string& name : further) {
    const auto shown = metric_of(rows, name, catalogue);
    if (!shown) return shown.error();
    table.columns.push_back({name, shown->title, Kind::kNumber});
    for (Scores one : *scores) {
      one.metric = *shown;
      one.values.clear();
      for (const Row& row : rows)
        if (row.cell.scenario == one.scenario && row.cell.strategy == one.strategy && row.counts())
          if (const auto value = row.figure(name)) one.values.push_back(*value);
      of_metric[name].push_back(std::move(one));
    }
  }
  table.columns.push_back({"difference", "difference", Kind::kNumber});
  table.columns.push_back({"difference_95", "95 %", Kind::kNumber});
  for (std::size_t i = 0; i < scores->size(); ++i) {
    const Scores& one = (*scores)[i];
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
    for (const std::string& name : further) {
      const Scores& other = of_metric.at(name)[i];
      row.push_back(number_cell(statistics::mean(other.values), other.metric.digits));
    }
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
  set_title(table, "strategies");
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
  std::vector<double> all;
  for (const Scores& one : *scores) all.insert(all.end(), one.values.begin(), one.values.end());
  if (all.empty()) return input_error("no game was completed");
  const auto [least, most] = std::ranges::minmax_element(all);
  const std::vector<double> thresholds = thresholds_between(*least, *most);
  const bool more = scores->front().metric.more_is_better;
  Table table{"profile", "", {{"scenario", "scenario"}, {"strategy", "strategy"}, {"metric", "metric"}}, {}};
  for (const double threshold : thresholds) {
    const std::string text = general_text(threshold, 6);
    table.columns.push_back({(more ? "at_least_" : "at_most_") + text, (more ? ">= " : "<= ") + text, Kind::kShare});
  }
  for (const Scores& one : *scores) {
    std::vector<TableCell> row{one.scenario, one.strategy, one.metric.title};
    const std::vector<double> shares = statistics::profile(one.values, thresholds, more);
    for (const double share : shares) {
      TableCell cell;
      if (!one.values.empty()) {
        cell = TableCell(share);
        cell.shown = fixed_text(100 * share, 0) + " %";
      }
      row.push_back(std::move(cell));
    }
    table.rows.push_back(std::move(row));
  }
  set_title(table, "share of games that reach a figure");
  return table;
}

Expected<std::vector<const Metric*>> parts_of(const std::vector<Row>& rows, const std::string& metric,
                                              const Catalogue& catalogue) {
  std::vector<const Metric*> parts, out;
  std::vector<std::string> names, whole;
  for (const Row& row : rows) {
    const WorldKind* const world = catalogue.find_world(row.world);
    if (!world) continue;
    for (const Metric& one : world->metrics) {
      if (one.part_of == metric) names.emplace_back(parts.emplace_back(&one)->name);
      if (std::string of(one.part_of); !of.empty() && std::ranges::find(whole, of) == whole.end())
        whole.push_back(std::move(of));
    }
    break;
  }
  if (parts.empty())
    return input_error(metric + " has no parts" +
                       (whole.empty() ? ", nor has another metric of this world"
                                      : "; expected a metric that has some: " + some_of(whole)));
  std::ranges::copy_if(parts, std::back_inserter(out), [&rows](const Metric* part) {
    return std::ranges::any_of(rows, [part](const Row& row) { return row.figure(part->name).has_value(); });
  });
  if (out.empty())
    return input_error("no row has the parts of " + metric + "; expected some of the columns " + some_of(names, 8));
  return out;
}

Expected<Table> part_table(const std::vector<Row>& rows, const std::string& metric, const Catalogue& catalogue) {
  const auto whole = scores_of(rows, metric, catalogue);
  if (!whole) return whole.error();
  Table table{"parts", "", {{"scenario", "scenario"}, {"strategy", "strategy"}, {"metric", "metric"}}, {}};
  for (const Scores& one : *whole) {
    std::vector<TableCell> row{one.scenario, one.strategy, one.metric.title};
    row.push_back(number_cell(statistics::mean(one.values), one.metric.digits));
    table.rows.push_back(std::move(row));
  }
  table.columns.push_back({"mean", "mean", Kind::kNumber});
  const auto parts = parts_of(rows, whole->front().metric.name, catalogue);
  if (!parts) return parts.error();
  for (const Metric* part : *parts) {
    const auto scores = scores_of(rows, std::string(part->name), catalogue);
    if (!scores) continue;  // no game has any
    table.columns.push_back({std::string(part->name), std::string(part->what), Kind::kNumber});
    for (std::size_t i = 0; i < scores->size(); ++i)
      table.rows[i].push_back(number_cell(statistics::mean((*scores)[i].values), part->digits));
  }
  set_title(table, "means by kind");
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
              "",
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
  set_title(table, "share in the same game");
  return table;
}

Table difference_table(const std::vector<Answer>& answers) {
  Table table{"differences",
              "",
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
  set_title(table, "differences");
  return table;
}

Table requirement_table(const std::vector<Answer>& answers) {
  Table table{"requirements",
              "",
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
  set_title(table, "requirements");
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
    const std::size_t fewest =
        statistics::fewest_games(one.is_difference ? About::kDifferences : About::kMean, answers.size());
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
