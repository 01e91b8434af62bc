#include "cx/base/random.h"

#include <cmath>

namespace cxlab {

namespace {

/// FNV-1a over the name, then one splitmix64 step with the seed, so that near seeds give far streams.
std::uint64_t stream_seed(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  std::uint64_t z = hash + (seed + 1) * 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view name) : engine_(stream_seed(seed, name)) {}

std::uint64_t RandomStream::below(std::uint64_t n) {
  const std::uint64_t limit = n * (UINT64_MAX / n);  // rejection: no modulo bias
  std::uint64_t draw = next();
  while (draw >= limit) draw = next();
  return draw % n;
}

std::int64_t RandomStream::between(std::int64_t low, std::int64_t high) {
  // Unsigned, as the distance may be larger than the largest signed number.
  const std::uint64_t values = static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low) + 1;
  const std::uint64_t step = values == 0 ? next() : below(values);  // 0: all numbers
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(low) + step);
}

double RandomStream::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double RandomStream::normal(double mean, double sigma) {
  double u = 0, v = 0, s = 0;
  do {
    u = uniform(-1, 1);
    v = uniform(-1, 1);
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  return mean + sigma * u * std::sqrt(-2 * std::log(s) / s);
}

}  // namespace cxlab
