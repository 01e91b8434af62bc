#include "lab/sweep/plots.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "cx/base/number_text.h"
#include "lab/statistics/statistics.h"
#include "lab/sweep/read_rows.h"
#include "lab/sweep/score_tables.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

namespace {

constexpr std::size_t kMostDots = 300;  ///< games of a strategy that are drawn one by one
constexpr double kRowHeight = 20, kTop = 24, kCharacter = 7, kWidth = 520, kLine = 16;
constexpr double kBelow = 6;  ///< games lie so far below their mean, which would hide them

/// Colours of series, readable on white and on black.
constexpr const char* kSeries[] = {"#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#b07aa1",
                                   "#76b7b2", "#d4a800", "#9c755f", "#ff9da7", "#8c8c8c"};
constexpr const char* kDashes[] = {"", "6 3", "2 2", "8 3 2 3"};

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  return out;
}

/// One strategy in one scenario.
struct PlotLine {
  std::string scenario, strategy;
  std::string name;  ///< without the scenario where there is only one
  std::vector<double> values;
};

struct PlotLines {
  MetricOfRows metric;
  std::vector<PlotLine> lines;
  std::size_t scenarios = 0;
  std::vector<std::string> strategies;
  double least = 0, most = 0;
};

/// A plot has one scale.
Error different_figures(const std::string& one, const std::string& other) {
  return input_error("the scenarios have different figures, " + one + " and " + other +
                     "; expected --scenario with one of them, or --metric with the figure to be drawn");
}

void name_lines(std::vector<PlotLine>& lines, std::size_t scenarios) {
  for (PlotLine& line : lines) line.name = (scenarios > 1 ? line.scenario + ", " : "") + line.strategy;
}

Expected<PlotLines> lines_of(const std::vector<Row>& rows, const std::string& metric, const Catalogue& catalogue) {
  const auto shown = metric_of(rows, metric, catalogue);
  if (!shown) return shown.error();
  PlotLines out;
  out.metric = *shown;
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  std::map<std::string, bool> scenarios, strategies;
  bool any = false;
  for (const Row& row : rows) {
    if (metric.empty() && !row.compared.empty() && row.compared != shown->name)
      return different_figures(shown->name, row.compared);
    const auto [place, is_new] = places.try_emplace({row.cell.scenario, row.cell.strategy}, out.lines.size());
    if (is_new) {
      out.lines.push_back({row.cell.scenario, row.cell.strategy, {}, {}});
      out.scenarios += scenarios.emplace(row.cell.scenario, true).second;
      if (strategies.emplace(row.cell.strategy, true).second) out.strategies.push_back(row.cell.strategy);
    }
    const auto value = row.counts() ? row.figure(shown->name) : std::nullopt;
    if (!value) continue;
    out.lines[place->second].values.push_back(*value);
    out.least = any ? std::min(out.least, *value) : *value;
    out.most = any ? std::max(out.most, *value) : *value;
    any = true;
  }
  if (!any) return input_error("no game was completed");
  name_lines(out.lines, out.scenarios);
  return out;
}

/// A line for each answer, with what `values` makes of it, and what all of them are compared with.
struct AnswerLines {
  std::vector<PlotLine> lines;
  std::string against;
};

template <class Values>
Expected<AnswerLines> lines_of(const std::vector<Answer>& answers, Values&& values) {
  AnswerLines out;
  std::set<std::string> scenarios, references;
  for (const Answer& one : answers) {
    if (one.metric.name != answers.front().metric.name)
      return different_figures(answers.front().metric.name, one.metric.name);
    scenarios.insert(one.scenario);
    references.insert(one.asked);
    out.lines.push_back({one.scenario, one.strategy, {}, values(one)});
  }
  if (out.lines.empty()) return input_error("there is only one strategy, and none to compare it with");
  if (std::ranges::all_of(answers, [](const Answer& one) { return one.values.empty(); }))
    return input_error("no game was completed by two strategies");
  name_lines(out.lines, scenarios.size());
  out.against = references.size() == 1 ? *references.begin() : "what it is compared with";
  return out;
}

/// What dots and lines of games mean.
std::string games_text(const std::vector<PlotLine>& lines) {
  const bool some_only =
      std::ranges::any_of(lines, [](const PlotLine& line) { return line.values.size() > kMostDots; });
  return "grey " + (some_only ? std::to_string(kMostDots) + " quantiles of the games" : std::string("each game")) +
         ", coloured the mean with its 95 % interval";
}

/// A mean with its 95 % interval, as far as there are any.
struct Estimate {
  double mean;
  statistics::Interval interval;
};

std::vector<Estimate> estimates_of(const std::vector<PlotLine>& lines) {
  std::vector<Estimate> out;
  for (const PlotLine& line : lines)
    out.push_back({statistics::mean(line.values), statistics::mean_interval_95(line.values)});
  return out;
}

/// What a scale has room for.
struct Span {
  double least, most;
  void add(double value) {
    if (std::isnan(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  void add(const std::vector<Estimate>& estimates) {
    for (const auto& [mean, interval] : estimates)
      for (const double end : {mean, interval.low, interval.high}) add(end);
  }
};

/// All values, or as many quantiles, the least and the most among them; in order.
std::vector<double> quantiles_of(std::vector<double> values) {
  std::ranges::sort(values);
  if (values.size() <= kMostDots) return values;
  std::vector<double> out;
  for (std::size_t i = 0; i < kMostDots; ++i) out.push_back(values[i * (values.size() - 1) / (kMostDots - 1)]);
  return out;
}

/// Round numbers from one below the least to one above the most.
std::vector<double> ticks_between(double least, double most) {
  const double raw = most > least ? (most - least) / 6 : std::max(std::abs(most), 1.0) / 2;
  const double tens = std::pow(10, std::floor(std::log10(raw)));
  const double step = raw <= tens ? tens : raw <= 2 * tens ? 2 * tens : raw <= 5 * tens ? 5 * tens : 10 * tens;
  std::vector<double> out;
  const double first = std::floor(least / step), last = std::max(first + 1, std::ceil(most / step));
  for (double i = first; i <= last; ++i) out.push_back(i * step);
  return out;
}

std::string number(double value) { return general_text(value, 8); }

/// A drawing whose lines have names on the left, and a scale below.
class Drawing {
 public:
  Drawing(const std::vector<std::string>& names, double height, double least, double most, double left_margin = 20)
      : bottom_(kTop + height), ticks_(ticks_between(least, most)) {
    std::size_t longest = 0;
    for (const std::string& name : names) longest = std::max(longest, name.size());
    left_ = left_margin + kCharacter * static_cast<double>(longest);
    width_ = left_ + kWidth + 30;
    for (const double tick : ticks_) {
      line("grid", x(tick), kTop - 8, x(tick), bottom_, "#ddd");
      text("axis", x(tick), bottom_ + 18, "middle", "#555", general_text(tick, 6));
    }
  }

  double x(double value) const { return left_ + kWidth * (value - ticks_.front()) / (ticks_.back() - ticks_.front()); }
  static double y_of(std::size_t row) { return kTop + kRowHeight * (static_cast<double>(row) + 0.5); }
  double bottom() const { return bottom_; }
  double left() const { return left_; }
  double right() const { return left_ + kWidth; }

  void line(const std::string& kind, double x1, double y1, double x2, double y2, const std::string& colour,
            const std::string& more = {}) {
    out_ += "<line class=\"" + kind + "\" x1=\"" + place(x1) + "\" y1=\"" + place(y1) + "\" x2=\"" + place(x2) +
            "\" y2=\"" + place(y2) + "\" stroke=\"" + colour + '"' + more + "/>\n";
  }
  void text(const std::string& kind, double x, double y, const std::string& anchor, const std::string& colour,
            const std::string& words) {
    out_ += "<text class=\"" + kind + "\" x=\"" + place(x) + "\" y=\"" + place(y) + "\" text-anchor=\"" + anchor +
            "\" fill=\"" + colour + "\">" + xml_text(words) + "</text>\n";
  }
  void name(std::size_t row, const std::string& words) {
    text("name", left_ - 10, y_of(row) + 4, "end", "#111", words);
  }
  void dot(const std::string& kind, double x, double y, double radius, const std::string& colour) {
    out_ += "<circle class=\"" + kind + "\" cx=\"" + place(x) + "\" cy=\"" + place(y) + "\" r=\"" + number(radius) +
            "\" fill=\"" + colour + "\"/>\n";
  }
  void bar(const std::string& kind, double x1, double x2, double y, double height, const std::string& colour,
           const std::string& remark) {
    out_ += "<rect class=\"" + kind + "\" x=\"" + place(std::min(x1, x2)) + "\" y=\"" + place(y) + "\" width=\"" +
            place(std::abs(x2 - x1)) + "\" height=\"" + place(height) + "\" fill=\"" + colour + "\"><title>" +
            xml_text(remark) + "</title></rect>\n";
  }
  void path(const std::string& kind, const std::string& steps, const std::string& colour, const std::string& more,
            const std::string& remark) {
    out_ += "<path class=\"" + kind + "\" d=\"" + steps + "\" fill=\"none\" stroke=\"" + colour +
            "\" stroke-width=\"2\"" + more + "><title>" + xml_text(remark) + "</title></path>\n";
  }
  /// A mean with its interval.
  void estimate(const std::string& kind, std::size_t row, const Estimate& found, const std::string& colour) {
    const auto& [mean, interval] = found;
    if (!std::isnan(interval.low))
      line(kind, x(interval.low), y_of(row), x(interval.high), y_of(row), colour, " stroke-width=\"3\"");
    dot(kind, x(mean), y_of(row), 4.5, colour);
  }
  /// The figure of each game in grey, and above them their mean with its interval.
  void games(std::size_t row, const PlotLine& games, const Estimate& found, const std::string& kind,
             const std::string& colour) {
    name(row, games.name);
    if (games.values.empty()) return;
    for (const double value : quantiles_of(games.values)) dot("game", x(value), y_of(row) + kBelow, 2.5, "#bbb");
    estimate(kind, row, found, colour);
  }
  /// What the scale on the left is of; it stands upright beside the names.
  void side_caption(const std::string& words) {
    out_ += "<text class=\"caption\" transform=\"translate(14 " + place((kTop + bottom_) / 2) +
            ") rotate(-90)\" text-anchor=\"middle\" fill=\"#111\">" + xml_text(words) + "</text>\n";
  }
  /// What the scale is of, on as many lines as the drawing needs.
  void caption(const std::string& words) {
    constexpr auto kMost = static_cast<std::size_t>(kWidth / kCharacter);
    caption_height_ = -kLine;
    for (std::size_t begin = 0; begin < words.size();) {
      std::size_t end = words.size();
      if (end - begin > kMost) {
        end = words.rfind(' ', begin + kMost);
        if (end == std::string::npos || end <= begin) end = std::min(words.find(' ', begin + 1), words.size());
      }
      caption_height_ += kLine;
      text("caption", (left_ + right()) / 2, bottom_ + 38 + caption_height_, "middle", "#111",
           words.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  /// Names beside their colours, below the caption.
  void key(const std::vector<std::string>& names) {
    double at = 10, y = bottom_ + caption_height_ + 62;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const double wide = 30 + kCharacter * static_cast<double>(names[i].size());
      if (at > 10 && at + wide > width_) {
        at = 10;
        y += 18;
      }
      const std::string dash = dash_of(i);
      line(series_class(i), at, y - 4, at + 18, y - 4, colour_of(i), " stroke-width=\"4\"" + dash);
      text("name", at + 24, y, "start", "#111", names[i]);
      at += wide + 14;
    }
    key_height_ = y - bottom_ - caption_height_ - 38;
  }
  static std::string series_class(std::size_t i) { return "series s" + std::to_string(i % std::size(kSeries)); }
  static const char* colour_of(std::size_t i) { return kSeries[i % std::size(kSeries)]; }
  static std::string dash_of(std::size_t i) {
    const char* const dash = kDashes[i / std::size(kSeries) % std::size(kDashes)];
    return *dash ? " stroke-dasharray=\"" + std::string(dash) + '"' : "";
  }

  std::string svg() const {
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width_) + ' ' +
           number(bottom_ + 46 + caption_height_ + key_height_) + "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
           "<rect class=\"paper\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n" + out_ + "</svg>\n";
  }

 private:
  static std::string place(double value) { return general_text(std::round(value * 10) / 10, 8); }

  double left_ = 0, width_ = 0, bottom_ = 0, caption_height_ = 0, key_height_ = 0;
  std::vector<double> ticks_;
  std::string out_;
};

std::vector<std::string> names_of(const std::vector<PlotLine>& lines) {
  std::vector<std::string> out;
  for (const PlotLine& line : lines) out.push_back(line.name);
  return out;
}

}  // namespace

Expected<std::string> score_plot(const std::vector<Row>& rows, const std::string& metric, const std::string& against,
                                 const Catalogue& catalogue) {
  const auto all = lines_of(rows, metric, catalogue);
  if (!all) return all.error();
  if (Status s = check_strategy(rows, against); !s) return s.error();
  const std::vector<PlotLine>& lines = all->lines;
  const std::vector<Estimate> estimates = estimates_of(lines);
  Span span{all->least, all->most};
  span.add(estimates);
  Drawing out(names_of(lines), kRowHeight * static_cast<double>(lines.size()), span.least, span.most);
  out.caption(all->metric.title + " of a game: " + games_text(lines));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const PlotLine& line = lines[i];
    const bool reference = line.strategy == (against.empty() ? all->strategies.front() : against);
    const std::string colour = Drawing::colour_of(i), kind = Drawing::series_class(i);
    if (reference && all->scenarios == 1 && !line.values.empty()) {
      const double mean = out.x(estimates[i].mean);
      out.line(kind, mean, kTop - 8, mean, out.bottom(), colour, " stroke-dasharray=\"4 3\"");
    }
    out.games(i, line, estimates[i], kind, colour);
  }
  return out.svg();
}

Expected<std::string> difference_plot(const std::vector<Answer>& answers, const std::string& against) {
  auto named = lines_of(answers, [](const Answer& one) { return one.values; });
  if (!named) return named.error();
  const std::vector<PlotLine>& lines = named->lines;
  const std::vector<Estimate> estimates = estimates_of(lines);
  Span span{0, 0};
  span.add(estimates);
  Drawing out(names_of(lines), kRowHeight * static_cast<double>(lines.size()), span.least, span.most);
  const MetricOfRows& metric = answers.front().metric;
  out.caption(metric.title + " more than " + (against.empty() ? named->against : against) +
              " in the same game, with the 95 % interval" + (metric.more_is_better ? "" : " (less is better)"));
  out.line("zero", out.x(0), kTop - 8, out.x(0), out.bottom(), "#555", " stroke-width=\"1.5\"");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out.name(i, lines[i].name);
    if (lines[i].values.empty()) continue;
    const Judgement judgement = answers[i].judgement;
    const char* const colour = judgement == Judgement::kBetter  ? "#1a7f37"
                               : judgement == Judgement::kWorse ? "#c62828"
                                                                : "#777";
    out.estimate(std::string(to_string(judgement)), i, estimates[i], colour);
  }
  return out.svg();
}

Expected<std::string> share_plot(const std::vector<Answer>& answers) {
  auto named = lines_of(answers, [](const Answer& one) {
    std::vector<double> percent = shares_of(one);
    for (double& share : percent) share *= 100;
    return percent;
  });
  if (!named) return named.error();
  const std::vector<PlotLine>& lines = named->lines;
  if (std::ranges::all_of(lines, [](const PlotLine& line) { return line.values.empty(); }))
    return input_error("no game has a share: " + named->against + " has no figure above 0 in the games of the others");
  const std::vector<Estimate> estimates = estimates_of(lines);
  Span span{100, 100};
  span.add(estimates);
  for (const PlotLine& line : lines)
    for (const double share : line.values) span.add(share);
  Drawing out(names_of(lines), kRowHeight * static_cast<double>(lines.size()), span.least, span.most);
  out.caption("share of the " + answers.front().metric.title + " of " + named->against +
              " in the same game, in %: " + games_text(lines));
  out.line("zero", out.x(100), kTop - 8, out.x(100), out.bottom(), "#555", " stroke-dasharray=\"4 3\"");
  for (std::size_t i = 0; i < lines.size(); ++i)
    out.games(i, lines[i], estimates[i], Drawing::series_class(0), Drawing::colour_of(0));
  return out.svg();
}

Expected<std::string> profile_plot(const std::vector<Row>& rows, const std::string& metric,
                                   const Catalogue& catalogue) {
  const auto all = lines_of(rows, metric, catalogue);
  if (!all) return all.error();
  const bool more = all->metric.more_is_better;
  constexpr double kHeight = 240;
  std::vector<std::string> shares;
  for (int percent = 0; percent <= 100; percent += 25) shares.push_back(std::to_string(percent) + " %");
  Drawing out(shares, kHeight, all->least, all->most, 40);
  const auto y = [&](double share) { return out.bottom() - kHeight * share; };
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double at = y(static_cast<double>(i) / static_cast<double>(shares.size() - 1));
    out.line("grid", out.left(), at, out.right(), at, "#ddd");
    out.text("axis", out.left() - 8, at + 4, "end", "#555", shares[i]);
  }
  out.caption(all->metric.title + " of a game");
  out.side_caption("games with " + std::string(more ? "at least" : "at most") + " so much");
  std::vector<std::string> key;
  std::map<std::vector<double>, std::size_t> drawn;  // curves, by their values
  for (std::size_t i = 0; i < all->lines.size(); ++i) {
    const PlotLine& line = all->lines[i];
    key.push_back(line.name);
    if (line.values.empty()) continue;
    const std::vector<double> values = quantiles_of(line.values);
    const double n = static_cast<double>(values.size());
    std::string steps = 'M' + general_text(out.left(), 8) + ' ' + general_text(y(more ? 1 : 0), 8);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double share = more ? 1 - static_cast<double>(k + 1) / n : static_cast<double>(k + 1) / n;
      steps += 'H' + fixed_text(out.x(values[k]), 1) + 'V' + fixed_text(y(share), 1);
    }
    steps += 'H' + general_text(out.right(), 8);
    // The same curve again is drawn with gaps, so that the first one shows through them.
    const auto [first, is_new] = drawn.try_emplace(values, i);
    if (!is_new) key.back() += " (as " + all->lines[first->second].name + ")";
    out.path(Drawing::series_class(i), steps, Drawing::colour_of(i),
             is_new ? Drawing::dash_of(i) : " stroke-dasharray=\"7 9\"", line.name);
  }
  out.key(key);
  return out.svg();
}

Expected<std::string> parts_plot(const std::vector<Row>& rows, const std::string& metric, const Catalogue& catalogue) {
  const auto all = lines_of(rows, metric, catalogue);
  if (!all) return all.error();
  const auto found = parts_of(rows, all->metric.name, catalogue);
  if (!found) return found.error();
  const std::vector<const Metric*>& parts = *found;
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  for (std::size_t i = 0; i < all->lines.size(); ++i) places[{all->lines[i].scenario, all->lines[i].strategy}] = i;
  std::vector<std::vector<std::vector<double>>> values(all->lines.size(),
                                                       std::vector<std::vector<double>>(parts.size()));
  for (const Row& row : rows) {
    if (!row.counts()) continue;
    auto& of_line = values[places.at({row.cell.scenario, row.cell.strategy})];
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (const auto value = row.figure(parts[k]->name)) of_line[k].push_back(*value);
  }
  double least = 0, most = 0;
  std::vector<std::vector<double>> means;
  for (const auto& of_line : values) {
    auto& mean = means.emplace_back();
    double below = 0, above = 0;
    for (const auto& of_part : of_line) {
      mean.push_back(of_part.empty() ? 0 : statistics::mean(of_part));
      (mean.back() < 0 ? below : above) += mean.back();
    }
    least = std::min(least, below);
    most = std::max(most, above);
  }
  Drawing out(names_of(all->lines), kRowHeight * static_cast<double>(all->lines.size()), least, most);
  out.caption("mean " + all->metric.title + " of a game by kind");
  for (std::size_t i = 0; i < all->lines.size(); ++i) {
    out.name(i, all->lines[i].name);
    double below = 0, above = 0;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const double mean = means[i][k];
      if (mean == 0) continue;
      double& from = mean < 0 ? below : above;
      out.bar(Drawing::series_class(k), out.x(from), out.x(from + mean), Drawing::y_of(i) - 7, 14,
              Drawing::colour_of(k),
              all->lines[i].name + ", " + std::string(parts[k]->what) + ": " + fixed_text(mean, parts[k]->digits));
      from += mean;
    }
  }
  out.line("zero", out.x(0), kTop - 8, out.x(0), out.bottom(), "#555", " stroke-width=\"1.5\"");
  std::vector<std::string> key;
  for (const Metric* part : parts) key.emplace_back(part->what);
  out.key(key);
  return out.svg();
}

}  // namespace cxlab::lab
