#pragma once
// Inputs that are played in copies of the process.

#include <functional>

namespace cxlab::fuzz {

/// Calls `play` in a copy of this process. So objects made here before need not be made again for each input, and
/// cannot change. Code that the copy covers counts as covered here. It may also end because calls without end fill its
/// stack; where it ends in any other way, this process aborts.
void in_copy(const std::function<void()>& play);

}  // namespace cxlab::fuzz
