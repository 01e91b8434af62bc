#pragma once
// Random numbers, in named streams of one seed: one more draw in one stream changes no other stream.

#include <cstdint>
#include <random>
#include <string_view>

namespace cxlab {

/// A stream of random numbers that depends on (seed, name) only: the same on every platform, but for normal (log).
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name);

  std::uint64_t next() { return engine_(); }
  /// Uniform in 0 .. n-1; n > 0.
  std::uint64_t below(std::uint64_t n);
  /// Uniform integer, both ends included; low <= high.
  std::int64_t between(std::int64_t low, std::int64_t high);
  /// Uniform in [0, 1).
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Normal by the polar method of Marsaglia.
  double normal(double mean, double sigma);
  bool chance(double probability) { return uniform() < probability; }

  /// Fisher-Yates, from the last element down.
  template <class Container>
  void shuffle(Container& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[below(i)]);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace cxlab
