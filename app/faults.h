#pragma once

namespace cxlab::app {

/// Installs handlers for crashes of the program, such as an access to memory that is not its own. The program then ends
/// with exit code 70. It names the rule at work, and its result has the reason. Message-handlers that send to
/// themselves without end fill the stack of the process, which ends with exit code 4. The engine stops deffunctions
/// earlier.
void install_fault_handlers();

}  // namespace cxlab::app
