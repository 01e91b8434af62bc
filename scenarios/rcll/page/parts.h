#pragma once
// The parts of the page of a game. What they say of waits and orders is what the questions answer.

#include <vector>

#include "scenarios/rcll/questions/products.h"
#include "scenarios/rcll/story/story.h"
#include "scenarios/run_page.h"

namespace cxlab::rcll {

// Kinds beside those that are the names of skills, teams and kinds of points.
inline constexpr const char *kHoldsKind = "holds", *kWaitsKind = "waits", *kIdleKind = "idle", *kBusyKind = "busy",
                            *kBlockedKind = "blocked", *kDownKind = "down", *kBrokenKind = "broken",
                            *kFailedKind = "failed", *kAwayKind = "maintenance", *kFaultKind = "fault",
                            *kPauseKind = "pause", *kPointsKind = "points", *kOrderKind = "order",
                            *kInTimeKind = "in_time", *kLateKind = "is_late", *kLostKind = "lost", *kOpenKind = "open";

inline double begin_of(const Interval& when) { return to_seconds(when.from); }
inline double end_of(const Interval& when) { return to_seconds(when.to); }

/// "5", or "CYAN-5" where both teams have orders.
std::string task_id(const std::vector<Team>& teams, Team team, int order);
inline std::string task_id(const GameStory& story, Team team, int order) { return task_id(story.teams, team, order); }

PageTasks tasks_of(const GameStory& story, const std::vector<OrderWork>& works);
PageLanes robot_lanes(const GameStory& story, const std::vector<OrderWork>& works);
PageLanes machine_lanes(const GameStory& story);

}  // namespace cxlab::rcll
