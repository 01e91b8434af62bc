#pragma once
// When an episode begins: a section of scenarios for worlds that are about the middle of something.

#include "scenarios/catalogue.h"

namespace cxlab {

/// `begin: {at_s: 312.4}`
struct Begin {
  SimTime at{};  ///< of the start of the agents and of the first tick

  template <class Keys>
  void fields(Keys& keys) {
    keys("at_s", at);
  }
};

extern const SectionKind kBegin;

}  // namespace cxlab
