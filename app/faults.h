#pragma once

namespace cxlab::app {

/// A sanitizer says more of a fault than we do, and takes more address space than there is memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// A fault of the program, as an access to memory that is not its own, ends it with exit code 70, the rule at work and
/// a result that says so. Message-handlers that send to themselves without end fill the stack of the process (the
/// engine stops deffunctions before): exit code 4.
void install_fault_handlers();

}  // namespace cxlab::app
