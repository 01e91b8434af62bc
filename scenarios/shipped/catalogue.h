#pragma once
// The worlds and nodes that come with cxlab.

#include "scenarios/catalogue.h"

namespace cxlab {

const Catalogue& shipped();

}  // namespace cxlab
