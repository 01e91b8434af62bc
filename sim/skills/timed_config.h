#pragma once
// The durations and failures of the timed tier.

#include <optional>
#include <string>

#include "cx/base/expected.h"

namespace cxlab::sim {

/// How long handling takes, and how often skills fail. Every duration is at least `shortest_s`.
struct TimedSkillsConfig {
  std::string durations = "physics";  ///< or "measured": on the league's robots. What the means are by default
  // From standing before the spot to standing there again.
  std::optional<double> pick_mean_s;
  std::optional<double> pick_shelf_mean_s;  ///< pick_mean_s when that alone is given
  double pick_sigma_s = 0.4;
  std::optional<double> place_mean_s;
  std::optional<double> place_slide_mean_s;  ///< place_mean_s when that alone is given
  double place_sigma_s = 0.6;
  std::optional<double> discard_mean_s;
  double discard_sigma_s = 0.2;
  double shortest_s = 2.0;
  double drive_sigma = 0;    ///< of a drive's time, as a share of what is planned; it takes at least 0.4 of that
  double drive_failure = 0;  ///< probability a drive_to that it ends with 201, where it should have ended well
  double pick_failure = 0;   ///< a pick: 206, the piece stays
  double place_failure = 0;  ///< a place: 204, the piece stays in the gripper

  template <class Keys>
  void fields(Keys& keys) {
    keys.word("durations", durations, {"physics", "measured"});
    keys("pick_mean_s", pick_mean_s);
    keys("pick_shelf_mean_s", pick_shelf_mean_s);
    keys("pick_sigma_s", pick_sigma_s);
    keys("place_mean_s", place_mean_s);
    keys("place_slide_mean_s", place_slide_mean_s);
    keys("place_sigma_s", place_sigma_s);
    keys("discard_mean_s", discard_mean_s);
    keys("discard_sigma_s", discard_sigma_s);
    keys("shortest_s", shortest_s);
    keys("drive_sigma", drive_sigma);
    keys("drive_failure", drive_failure);
    keys("pick_failure", pick_failure);
    keys("place_failure", place_failure);
  }
};
/// The means of a tier, in s.
struct HandlingMeans {
  double pick, pick_shelf, place, place_slide, discard;
};
HandlingMeans means_of(const TimedSkillsConfig& config);
/// Probabilities lie in 0..1, times are positive.
Status validate(const TimedSkillsConfig& config);

}  // namespace cxlab::sim
