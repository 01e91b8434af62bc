#pragma once

namespace cxlab::app {

/// Message-handlers that send to themselves without end fill the stack of the process (the engine stops deffunctions
/// before): says so, and ends with exit code 4 instead of a segmentation fault. Any other fault goes on as it would.
void install_stack_guard();

}  // namespace cxlab::app
