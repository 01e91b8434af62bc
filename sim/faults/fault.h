#pragma once
// Faults: what goes wrong whatever the rules do. A scenario lists them; each kind acts in the place that it is about
// (skills: sim/skills/faulty_skills.h; machines and maintenance: scenarios/rcll) and is the same in both tiers.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/origin.h"
#include "cx/base/random.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"

namespace cxlab::sim {

enum class FaultKind : std::uint8_t {
  kSkillFails,
  kSkillStalls,
  kGoalLost,
  kResultLate,
  kGraspSlips,
  kPieceMisplaced,
  kPieceDropped,
  kRobotHalts,
  kRobotSlow,
  kPoseNoise,
  kMachineBreaks,  ///< from here on about machines
  kMachineDown,
  kPieceTaken,
  kInstructionLost,
  kInstructionLate,
  kRobotMaintenance
};

struct Fault {
  FaultKind kind{};
  // When: `at`, or by chance between `from` and `until`. An occasion is a goal, a result, a pick that ended well
  // (FaultWord::by_occasion), or any time.
  std::optional<SimTime> at;  ///< once, at the first occasion not before
  double probability = 0;     ///< of each occasion
  SimTime mean{};             ///< others: mean time between two, exponentially distributed
  SimTime from{}, until = kNever;
  std::int64_t times = 0;  ///< at most that often, 0 = no limit
  // Where.
  std::string robot;  ///< empty = each robot, on its own
  std::string skill;  ///< empty = each
  std::string machine;
  // What.
  int error = 0;    ///< code that the skill ends with; 0 = 201, 206 or 204, by skill
  SimTime after{};  ///< from the beginning of the skill, or the end of a pick
  SimTime duration{};
  double factor = 1;                  ///< share of the speed
  double sigma_m = 0, sigma_deg = 0;  ///< standard deviations: of each direction, of the angle
  Origin origin{};
  std::size_t number = 0;  ///< in the scenario's list, from 0
};

/// For `cxlab list faults` and for reading.
struct FaultWord {
  std::string_view name;
  FaultKind kind{};
  std::string_view arguments;  ///< keys in addition to `when`: required ones first, marked with *
  std::string_view what;
  bool by_occasion = false;  ///< chance is `probability` and not `mean_s`
};
std::span<const FaultWord> fault_words();
std::string_view to_string(FaultKind kind);
bool by_occasion(FaultKind kind);

/// When one fault strikes at one place (a robot, a machine), from a stream of chance of its own: whatever happens
/// elsewhere moves none of its draws.
class FaultTimer {
 public:
  FaultTimer(const Fault& fault, std::uint64_t seed, std::string_view place);

  const Fault& fault() const { return fault_; }
  /// At an occasion (faults with a probability, or `at`): whether it strikes. Draws once.
  bool strikes_occasion(SimTime now);
  /// When it strikes next (faults with a mean time, or `at`); kNever after the last.
  SimTime due() const { return due_; }
  /// One of so many, which it strikes: draws once.
  std::size_t choose(std::size_t count) { return random_.below(count); }
  /// How large: normally distributed around 0. Draws.
  double draw(double sigma) { return random_.normal(0, sigma); }
  /// Strikes by chance that are due before `now` do not happen.
  void skip_until(SimTime now);
  /// It has struck at `now`, not before `due`.
  void struck(SimTime now);

 private:
  bool open(SimTime now) const;
  void draw_next(SimTime from);

  Fault fault_;
  RandomStream random_;
  std::int64_t left_ = 0;  // -1 = no limit
  SimTime due_ = kNever;
};

/// Begins the record of a strike, which goes to the stream "faults": which fault of the scenario it is.
RecordData& begin_strike(RecordData& data, const Fault& fault);

}  // namespace cxlab::sim
