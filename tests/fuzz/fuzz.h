#pragma once
// What every fuzz target is: a function of bytes, in a namespace of its own. In the preset `fuzz` each target is a
// program in which libFuzzer calls it. In all others the targets are one program, and `corpus_main.cpp` calls one with
// each file of tests/fuzz/corpus/<target>. A target ends the program where the code under test breaks its promise; what
// it refuses with an error is fine.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

namespace cxlab::fuzz {

struct Target {
  std::string_view name;
  int (*play)(const std::uint8_t* data, std::size_t size) = nullptr;
  std::string_view options;  // of AddressSanitizer
};

/// The targets of this program.
inline std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}

struct Registered {
  explicit Registered(const Target& target) { targets().push_back(target); }
};

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

/// Begins the function of a target, which takes `data` and `size` and returns 0. The second argument has options of
/// AddressSanitizer, as in ASAN_OPTIONS.
#ifdef CXLAB_FUZZ
#define FUZZ_TARGET(name, ...)                                               \
  extern "C" const char* __asan_default_options() { return "" __VA_ARGS__; } \
  extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
#else
#define FUZZ_TARGET(name, ...)                                                          \
  static int play_bytes(const std::uint8_t* data, std::size_t size);                    \
  static const cxlab::fuzz::Registered registered({#name, play_bytes, "" __VA_ARGS__}); \
  static int play_bytes(const std::uint8_t* data, std::size_t size)
#endif
