#pragma once
// Everything that enters a physics world from outside, write by write: enough to run it again.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "cx/base/byte_codec.h"
#include "cx/base/expected.h"

namespace cxlab::sim {

enum class WriteKind : std::uint8_t {
  kControl,    ///< actuator: target in units of kControlUnit
  kBeltSpeed,  ///< station: m/s
  kShape,      ///< body of the pool: base, three rings, cap
  kPlace,      ///< body of the pool: underside's centre x, y, z in the world
  kPark,       ///< body of the pool: out of play
  kWake,       ///< body of the pool: its surroundings changed while it slept
  kLights,     ///< station: red, yellow, green; only pictures show it
  kSetDown,    ///< robot: x, y, yaw of its base, which stands there
  kCarry,      ///< body of the pool: 1 when a grip carries its weight, else 0
};

/// Controls are whole multiples of this (m/s, rad/s, m): a motor's command has a resolution, and the log stays small.
inline constexpr double kControlUnit = 1e-5;

/// One write, made before the step of that number.
struct PhysicsWrite {
  std::int64_t step = 0;
  WriteKind kind{};
  int index = 0;
  std::array<double, 5> values{};
};

/// Writes as bytes: varint(steps since the last write), kind, varint(index), then whole numbers as zigzag varints
/// and others as 8 bytes, little endian. Append what `take` gives to a file as the run goes.
class PhysicsLog {
 public:
  void record(const PhysicsWrite& write);
  std::string_view bytes() const { return bytes_; }
  std::string take() { return std::exchange(bytes_, {}); }

 private:
  std::string bytes_;
  std::int64_t last_step_ = 0;
};

/// Reads what a PhysicsLog wrote. `bytes` must outlive it.
class PhysicsLogReader {
 public:
  explicit PhysicsLogReader(std::string_view bytes) : in_(bytes) {}
  /// The next write, none at the end; an error when the bytes are damaged.
  Expected<std::optional<PhysicsWrite>> next();

 private:
  ByteReader in_;
  std::int64_t step_ = 0;
};

}  // namespace cxlab::sim
