#include "lab/sweep/requirement.h"

#include <cmath>
#include <optional>
#include <string_view>

#include "cx/base/number_text.h"

namespace cxlab::lab {

namespace {

std::string without_blanks(const std::string& text) {
  const std::size_t from = text.find_first_not_of(" \t");
  return from == text.npos ? "" : text.substr(from, text.find_last_not_of(" \t") - from + 1);
}

}  // namespace

Expected<Requirement> Requirement::parse(const std::string& text) {
  const auto wrong = [&text](const std::string& what) {
    return input_error("found '" + text + "', " + what +
                       "; a requirement is 'mean(METRIC) >= NUMBER', 'mean(METRIC) <= NUMBER' or "
                       "'not worse than NAME [in METRIC] [by NUMBER]', each after 'STRATEGY: ' if it is asked of that "
                       "one only");
  };
  const auto bound_of = [](const std::string& number) -> std::optional<double> {
    const auto value = read_number<double>(number);
    return value && std::isfinite(*value) ? value : std::nullopt;
  };
  Requirement out;
  out.text = without_blanks(text);
  constexpr std::string_view kMean = "mean(", kNotWorse = "not worse than ";
  std::string rest = out.text;
  if (!rest.starts_with(kMean) && !rest.starts_with(kNotWorse))
    if (const std::size_t colon = rest.find(": "); colon != rest.npos) {
      out.strategy = without_blanks(rest.substr(0, colon));
      rest = without_blanks(rest.substr(colon + 2));
    }
  if (rest.starts_with(kNotWorse)) {
    out.kind = Kind::kNotWorse;
    out.than = without_blanks(rest.substr(kNotWorse.size()));
    const auto take_after = [&out](const std::string& word) -> std::optional<std::string> {
      const std::size_t at = out.than.rfind(word);
      if (at == out.than.npos) return std::nullopt;
      const std::string after = without_blanks(out.than.substr(at + word.size()));
      out.than = without_blanks(out.than.substr(0, at));
      return after;
    };
    if (const auto number = take_after(" by ")) {
      const auto margin = bound_of(*number);
      if (!margin || *margin < 0) return wrong("expected a number of at least 0 after 'by', found '" + *number + "'");
      out.bound = *margin;
    }
    if (const auto metric = take_after(" in ")) out.metric = *metric;
    if (out.than.empty()) return wrong("expected the name of a strategy or of an earlier sweep");
    return out;
  }
  const std::size_t end = rest.find(')');
  if (!rest.starts_with(kMean) || end == rest.npos) return wrong("which is no requirement");
  out.metric = without_blanks(rest.substr(kMean.size(), end - kMean.size()));
  const std::string comparison = without_blanks(rest.substr(end + 1));
  if (out.metric.empty()) return wrong("expected a metric in the brackets");
  if (!comparison.starts_with(">=") && !comparison.starts_with("<="))
    return wrong("expected '>=' or '<=' after the mean");
  out.kind = comparison.starts_with(">=") ? Kind::kAtLeast : Kind::kAtMost;
  const auto bound = bound_of(without_blanks(comparison.substr(2)));
  if (!bound) return wrong("expected a number after '" + comparison.substr(0, 2) + "'");
  out.bound = *bound;
  return out;
}

}  // namespace cxlab::lab
