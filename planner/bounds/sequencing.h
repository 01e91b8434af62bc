#pragma once
// A lower bound from activities that every plan has, and the least times between their beginnings.

#include <cstdint>
#include <vector>

#include "planner/bounds/pair_times.h"

namespace cxlab::planner {

/// Times between beginnings; in whole units.
struct Activities {
  ById<PairTime> heads;        ///< not before
  ById<PairTime> tails;        ///< from the beginning to the end of the plan
  ById<ById<PairTime>> apart;  ///< [i][j]: j is at least this long after i if it is not before i

  int count() const { return static_cast<int>(heads.size()); }
};

/// No plan is shorter. Activities that cannot begin together are tried in every order (one machine with heads, tails
/// and set-up times: Carlier 1982; the orders by dynamic programming, Held and Karp 1962), in groups of a few.
PairTime shortest_sequence(const Activities& activities, Budget& budget);

}  // namespace cxlab::planner
