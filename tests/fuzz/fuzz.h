#pragma once
// What every fuzz target is: one function that takes bytes. libFuzzer calls it in the preset `fuzz`, `corpus_main.cpp`
// with each file of tests/fuzz/corpus/<target> in all others. A target ends the program where the code under test
// breaks its promise; what it refuses with an error is fine.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace cxlab::fuzz {

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Ends the program when a promise is broken.
inline void promise(bool kept, const std::string& what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what.c_str());
  std::abort();
}

}  // namespace cxlab::fuzz
