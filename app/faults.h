#pragma once

namespace cxlab::app {

/// A fault of the program, as an access to memory that is not its own, ends it with exit code 70, the rule at work and
/// a result with the reason. Message-handlers that send to themselves without end fill the stack of the process (the
/// engine stops deffunctions before): exit code 4.
void install_fault_handlers();

}  // namespace cxlab::app
