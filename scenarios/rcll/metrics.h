#pragma once
// The figures by which games are compared; points before all others.

#include "scenarios/metric.h"

namespace cxlab::rcll {

inline constexpr Metric kMetrics[]{
    {.name = "points", .what = "points of all teams", .from = "teams.*.points", .title = "points"},
    {.name = "deliveries", .what = "correct deliveries", .from = "deliveries.*.correct", .title = "deliveries"},
    {.name = "busy",
     .what = "share of the time in which robots are at work",
     .from = "robots.*.busy_s",
     .fold = Metric::Fold::kMean,
     .per = "sim_time_s",
     .unit = "share",
     .title = "busy",
     .digits = 3},
    {.name = "points_delivery", .what = "points for deliveries", .from = "teams.*.by_kind.delivery", .part_of = "points"},
    {.name = "points_ring", .what = "points for rings", .from = "teams.*.by_kind.ring", .part_of = "points"},
    {.name = "points_cap", .what = "points for caps", .from = "teams.*.by_kind.cap", .part_of = "points"},
    {.name = "points_buffer", .what = "points for buffered caps", .from = "teams.*.by_kind.buffer", .part_of = "points"},
    {.name = "points_payment", .what = "points for payments", .from = "teams.*.by_kind.payment", .part_of = "points"},
    {.name = "points_late", .what = "points lost by late deliveries", .from = "teams.*.by_kind.late", .part_of = "points"},
    {.name = "points_competitive", .what = "points for competitive orders", .from = "teams.*.by_kind.competitive", .part_of = "points"},
    {.name = "points_exploration", .what = "points for reported machines", .from = "teams.*.by_kind.exploration", .part_of = "points"},
    {.name = "points_penalty", .what = "points lost by penalties", .from = "teams.*.by_kind.penalty", .part_of = "points"},
    {.name = "late_s",
     .what = "how late deliveries were, in all",
     .from = "deliveries.*.late_s",
     .unit = "s",
     .more_is_better = false},
    {.name = "wait_s",
     .what = "how long robots waited within their skills, in all",
     .from = "robots.*.wait_s",
     .unit = "s",
     .more_is_better = false},
    {.name = "drive_s",
     .what = "how long robots drove, in all",
     .from = "robots.*.drive_s",
     .unit = "s",
     .more_is_better = false},
    {.name = "skills", .what = "skills that robots carried out", .from = "robots.*.skills"},
    {.name = "failures", .what = "skills that failed", .from = "robots.*.failures", .more_is_better = false},
    {.name = "contacts", .what = "contacts of robots", .from = "robots.*.contacts", .more_is_better = false},
    {.name = "maintenances",
     .what = "how often robots were off the field",
     .from = "robots.*.maintenances",
     .more_is_better = false},
};

}  // namespace cxlab::rcll
