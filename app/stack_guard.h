#pragma once

namespace cxlab::app {

/// A deffunction that calls itself without end fills the stack of the process: says so, and ends with exit code 4
/// instead of a segmentation fault. Any other fault goes on as it would.
void install_stack_guard();

}  // namespace cxlab::app
