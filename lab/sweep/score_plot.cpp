#include "lab/sweep/score_plot.h"

#include <algorithm>
#include <cmath>

#include "cx/base/number_text.h"
#include "lab/statistics/statistics.h"
#include "lab/sweep/read_rows.h"

namespace cxlab::lab {

namespace {

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
  std::vector<double> values;
};

/// Round numbers from one below the least to one above the most.
std::vector<double> ticks_between(double least, double most) {
  const double raw = most > least ? (most - least) / 8 : std::max(std::abs(most), 1.0) / 2;
  const double tens = std::pow(10, std::floor(std::log10(raw)));
  const double step = raw <= tens ? tens : raw <= 2 * tens ? 2 * tens : raw <= 5 * tens ? 5 * tens : 10 * tens;
  std::vector<double> out;
  const double first = std::floor(least / step), last = std::max(first + 1, std::ceil(most / step));
  for (double i = first; i <= last; ++i) out.push_back(i * step);
  return out;
}

}  // namespace

Expected<std::string> score_plot(const std::vector<Row>& rows, const std::string& metric, const std::string& against,
                                 const Catalogue& catalogue) {
  const auto shown = metric_of(rows, metric, catalogue);
  if (!shown) return shown.error();
  std::vector<PlotLine> lines;
  std::vector<double> all;
  std::vector<std::string> scenarios, strategies;
  const auto note = [](std::vector<std::string>& names, const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const Row& row : rows) {
    if (metric.empty() && !row.compared.empty() && row.compared != shown->name)
      return input_error("the scenarios have different figures, " + shown->name + " and " + row.compared +
                         "; expected --metric with one that all have");
    note(scenarios, row.cell.scenario);
    note(strategies, row.cell.strategy);
    auto line = std::ranges::find_if(lines, [&row](const PlotLine& one) {
      return one.scenario == row.cell.scenario && one.strategy == row.cell.strategy;
    });
    if (line == lines.end()) line = lines.insert(lines.end(), PlotLine{row.cell.scenario, row.cell.strategy, {}});
    const auto value = row.counts() ? row.figure(shown->name) : std::nullopt;
    if (!value) continue;
    line->values.push_back(*value);
    all.push_back(*value);
  }
  if (all.empty()) return input_error("no game was completed");
  if (!against.empty() && std::ranges::find(strategies, against) == strategies.end())
    return input_error("there is no strategy '" + against + "'" + did_you_mean(against, strategies) + "; there are " +
                       some_of(strategies, 8));

  constexpr double kRow = 20, kTop = 24, kCharacter = 7, kWidth = 720;
  std::vector<std::string> names;
  std::size_t longest = 0;
  for (const PlotLine& line : lines) {
    names.push_back((scenarios.size() > 1 ? line.scenario + ", " : "") + line.strategy);
    longest = std::max(longest, names.back().size());
  }
  const double left = 20 + kCharacter * static_cast<double>(longest), right = left + kWidth;
  const double bottom = kTop + kRow * static_cast<double>(lines.size());
  const auto [least, most] = std::ranges::minmax_element(all);
  const std::vector<double> ticks = ticks_between(std::min(0.0, *least), *most);
  const auto x = [&](double value) {
    return fixed_text(left + kWidth * (value - ticks.front()) / (ticks.back() - ticks.front()), 1);
  };
  const auto number = [](double value) { return general_text(value, 8); };
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(right + 30) + ' ' +
                    number(bottom + 46) + "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
                    "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  for (const double tick : ticks)
    out += "<line x1=\"" + x(tick) + "\" y1=\"" + number(kTop - 8) + "\" x2=\"" + x(tick) + "\" y2=\"" +
           number(bottom) + "\" stroke=\"#ddd\"/><text x=\"" + x(tick) + "\" y=\"" + number(bottom + 18) +
           "\" text-anchor=\"middle\" fill=\"#555\">" + general_text(tick, 6) + "</text>\n";
  out += "<text x=\"" + number((left + right) / 2) + "\" y=\"" + number(bottom + 38) + "\" text-anchor=\"middle\">" +
         xml_text(shown->title) + " of a game: grey each game, coloured the mean with its 95 % interval</text>\n";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const PlotLine& line = lines[i];
    const std::string y = number(kTop + kRow * static_cast<double>(i) + kRow / 2);
    const bool reference = line.strategy == (against.empty() ? strategies.front() : against);
    const std::string colour = reference ? "#c2187f" : "#0093b8";
    out += "<text x=\"" + number(left - 10) + "\" y=\"" + number(kTop + kRow * static_cast<double>(i) + kRow / 2 + 4) +
           "\" text-anchor=\"end\">" + xml_text(names[i]) + "</text>\n";
    if (line.values.empty()) continue;
    const std::string mean = x(statistics::mean(line.values));
    if (reference && scenarios.size() == 1)
      out += "<line x1=\"" + mean + "\" y1=\"" + number(kTop - 8) + "\" x2=\"" + mean + "\" y2=\"" + number(bottom) +
             "\" stroke=\"" + colour + "\" stroke-dasharray=\"4 3\"/>\n";
    for (const double value : line.values)
      out += "<circle cx=\"" + x(value) + "\" cy=\"" + y + "\" r=\"2.5\" fill=\"#bbb\"/>";
    const statistics::Interval interval = statistics::interval_95(line.values, statistics::mean);
    if (!std::isnan(interval.low))
      out += "<line x1=\"" + x(interval.low) + "\" y1=\"" + y + "\" x2=\"" + x(interval.high) + "\" y2=\"" + y +
             "\" stroke=\"" + colour + "\" stroke-width=\"3\"/>";
    out += "<circle cx=\"" + mean + "\" cy=\"" + y + "\" r=\"4.5\" fill=\"" + colour + "\"/>\n";
  }
  return out + "</svg>\n";
}

}  // namespace cxlab::lab
