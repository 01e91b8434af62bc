#pragma once
// Random problems with tiny and huge constants, each made around a plan of its own, so that it has one.

#include <string>
#include <vector>

#include "cx/base/random.h"

namespace cxlab::planner {

struct PlantedProblem {
  std::string domain, problem;
  std::string plan;  ///< as a file of a plan

  static PlantedProblem draw(RandomStream& random);
};

}  // namespace cxlab::planner
