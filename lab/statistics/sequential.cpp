#include "lab/statistics/sequential.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace cxlab::statistics {

std::vector<std::size_t> looks(std::size_t planned, std::size_t together) {
  constexpr std::size_t kFewest = 11;
  const std::size_t blocks = planned / together;
  std::vector<std::size_t> out;
  for (std::size_t i = 1; i <= kEarlyLooks + 1; ++i) {
    const std::size_t after = (blocks * i + kEarlyLooks) / (kEarlyLooks + 1) * together;
    if (i <= kEarlyLooks && after < kFewest) continue;
    if (after > 0 && (out.empty() || after > out.back())) out.push_back(after);
  }
  return out;
}

std::size_t fewest_games(Question::About about, std::size_t questions) {
  if (about == Question::About::kMean) return kFewestForMean;
  std::size_t games = 1;
  // At best all differences have one sign: of 2^n combinations of signs two are as far from 0.
  for (double p = std::pow(2.0, 1 - static_cast<double>(games)); p * static_cast<double>(questions) > kLastLevel;
       p /= 2)
    ++games;
  return games;
}

namespace {

/// Whether an early look may say on which side of 0 the mean is.
bool is_enough(const std::vector<double>& values, double middle) {
  const bool all_equal = std::ranges::adjacent_find(values, std::not_equal_to()) == values.end();
  return !all_equal && (middle < 0 || values.size() >= kFewestForEarlyMean);
}

}  // namespace

std::vector<Decision> decide(const std::vector<Question>& questions, const std::vector<std::size_t>& look_after,
                             const Resampling& flips) {
  std::vector<Decision> out(questions.size());
  for (const std::size_t look : look_after) {
    const bool early = look < look_after.back();
    const double level = early ? kEarlyLevel : kLastLevel;
    const auto open = [](const Decision& decision) { return decision.side == Side::kUndecided; };
    if (std::ranges::any_of(questions, [look](const Question& one) { return one.values.size() < look; })) break;
    if (std::ranges::none_of(out, open)) break;
    std::vector<double> p, means;
    for (const Question& question : questions) {
      std::vector<double> values;
      for (std::size_t i = 0; i < look; ++i)
        if (question.values[i]) values.push_back(*question.values[i]);
      means.push_back(mean(values));
      if (question.about == Question::About::kDifferences)
        p.push_back(sign_flip_p(values, flips));
      else
        p.push_back(early && !is_enough(values, means.back()) ? 1 : mean_p(values));
    }
    const std::vector<double> corrected = holm(p);
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (!open(out[i])) continue;
      out[i].after = look;
      out[i].p = corrected[i];
      if (corrected[i] <= level) out[i].side = means[i] > 0 ? Side::kAbove : Side::kBelow;
    }
  }
  return out;
}

}  // namespace cxlab::statistics
