#pragma once

namespace cxlab {

/// Whether the program is built with a sanitizer that has its own handlers of faults, and more address space than there
/// is memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace cxlab
