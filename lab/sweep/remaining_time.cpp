#include "lab/sweep/remaining_time.h"

#include <algorithm>

namespace cxlab::lab {

void RemainingTime::begun(const std::string& kind) {
  Kind& of = kinds_[kind];
  if (of.open > 0) --of.open;
  ++of.playing;
}

void RemainingTime::ended(const std::string& kind, double seconds) {
  Kind& of = kinds_[kind];
  if (of.playing > 0) --of.playing;
  ++of.ended;
  of.seconds += seconds;
}

std::optional<double> RemainingTime::estimate(int jobs, double playing_s) const {
  Kind all;
  for (const auto& [name, kind] : kinds_) {
    all.ended += kind.ended;
    all.seconds += kind.seconds;
  }
  if (all.ended == 0) return std::nullopt;
  double open = 0, playing = 0;
  for (const auto& [name, kind] : kinds_) {
    const Kind& like = kind.ended > 0 ? kind : all;  // nothing better is known of a kind that has not been played
    const double each = like.seconds / static_cast<double>(like.ended);
    open += each * static_cast<double>(kind.open);
    playing += each * static_cast<double>(kind.playing);
  }
  return (open + std::max(0.0, playing - playing_s)) / std::max(1, jobs);
}

}  // namespace cxlab::lab
