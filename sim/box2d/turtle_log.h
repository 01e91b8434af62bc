#pragma once
// Everything that enters a world of turtles from outside, write by write: enough to run it again.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cx/base/byte_codec.h"
#include "cx/base/expected.h"

namespace cxlab::sim {

enum class TurtleId : std::int32_t {};  ///< counted from 1 in order of spawning, never used again

enum class TurtleVerb : std::uint8_t {
  kSpawn,  ///< x, y, theta
  kKill,
  kDrive,     ///< vx, vy, omega
  kTeleport,  ///< x, y, theta
  kPen,       ///< r, g, b, width, off
  kClear,
  kBackground,  ///< r, g, b
};

/// One write after the step of that number was taken.
struct TurtleWrite {
  std::int64_t step = 0;
  TurtleVerb verb{};
  TurtleId turtle{};
  std::array<double, 5> values{};
};

/// Writes as bytes: step and id as 8 and 4 bytes, verb, then as many values of 8 bytes as the verb has, little endian.
class TurtleLog {
 public:
  void record(const TurtleWrite& write);
  std::string take() { return std::exchange(bytes_, {}); }

 private:
  std::string bytes_;
};

/// Reads what a TurtleLog wrote. `bytes` must outlive it.
class TurtleLogReader {
 public:
  explicit TurtleLogReader(std::string_view bytes) : in_(bytes) {}
  /// The next write, none at the end; an error when the bytes are damaged.
  Expected<std::optional<TurtleWrite>> next();

 private:
  ByteReader in_;
};

}  // namespace cxlab::sim
