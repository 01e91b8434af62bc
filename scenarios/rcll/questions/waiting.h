#pragma once
// What something waits for, read off machines and robots meanwhile. Only what the records show is named.

#include <string>
#include <vector>

#include "scenarios/rcll/story/story.h"

namespace cxlab::rcll {

struct Waiting {
  Interval when;
  std::string what;  ///< a machine, a robot, "agent", "window", "work", "way", "fault", "pause", ...
  std::string why;   ///< one sentence's end: "C-CS2 was PROCESSING"
  friend bool same_reason(const Waiting& a, const Waiting& b) { return a.what == b.what && a.why == b.why; }
};

/// What a workpiece, or the robot that holds it, needs of a machine.
struct Needed {
  const MachineStory* machine = nullptr;  ///< nullptr: not known; then only the game itself can be in the way
  bool take = false;                      ///< a workpiece at its output; else that it takes one in
  std::string part;                       ///< the work to do: "RING_BLUE", "CAP_GREY", "delivery"; empty: not known
  const Order* order = nullptr;
  std::string_view robot;  ///< who asks
  bool on_belt = false;    ///< the workpiece lies there: the time to draw it in is "belt", not a wait
  /// The reason for a stretch in which the machine is ready and nobody is in the way.
  Waiting otherwise{{}, "agent", "the agent had not given the next command"};
};

/// The stretch cut into parts with one reason each.
std::vector<Waiting> reasons_for(const GameStory& story, const Interval& when, const Needed& needed);
/// The machine that the last decision about the robot has it bring a workpiece to; nullptr where none says it.
const MachineStory* destination_of(const GameStory& story, const RobotStory& robot, SimTime t);
/// Adds the time to that of the same reason, or as a new one; for sums.
void add_to(std::vector<Waiting>& sums, const Waiting& waiting);
/// "85.0 s: C-RS1 had too few payments; ...": the longest first, at most so many; without those that do not count.
std::string sums_text(std::vector<Waiting> sums, std::size_t most);

/// Everything that a robot waited for, in order of time, within what is asked about. A time without a skill is a wait,
/// as is each part of a skill in which the way was blocked or no workpiece had come yet; `in_skill` tells which.
struct RobotWait {
  Waiting waiting;
  bool in_skill = false;
};
std::vector<RobotWait> waits_of(const GameStory& story, const RobotStory& robot);

}  // namespace cxlab::rcll
