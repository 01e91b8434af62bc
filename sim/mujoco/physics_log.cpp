#include "sim/mujoco/physics_log.h"

#include <bit>
#include <cmath>

namespace cxlab::sim {
namespace {

struct Layout {
  int count;
  bool whole;  ///< integers
};

constexpr Layout layout_of(WriteKind kind) {
  switch (kind) {
    case WriteKind::kControl: return {1, true};
    case WriteKind::kBeltSpeed: return {1, false};
    case WriteKind::kShape: return {5, true};
    case WriteKind::kPlace: return {3, false};
    case WriteKind::kPark: return {0, true};
    case WriteKind::kWake: return {0, true};
    case WriteKind::kLights: return {3, true};
  }
  return {0, true};
}
constexpr std::uint8_t kLastKind = static_cast<std::uint8_t>(WriteKind::kLights);

void put_varint(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<char>(value | 0x80));
  out.push_back(static_cast<char>(value));
}

std::uint64_t zigzag(std::int64_t v) {
  return (static_cast<std::uint64_t>(v) << 1) ^ static_cast<std::uint64_t>(v >> 63);
}
std::int64_t unzigzag(std::uint64_t v) { return static_cast<std::int64_t>(v >> 1) ^ -static_cast<std::int64_t>(v & 1); }

}  // namespace

void PhysicsLog::record(const PhysicsWrite& write) {
  put_varint(bytes_, static_cast<std::uint64_t>(write.step - last_step_));
  last_step_ = write.step;
  bytes_.push_back(static_cast<char>(write.kind));
  put_varint(bytes_, static_cast<std::uint64_t>(write.index));
  const Layout layout = layout_of(write.kind);
  for (int i = 0; i < layout.count; ++i) {
    const double value = write.values[static_cast<std::size_t>(i)];
    if (layout.whole) {
      put_varint(bytes_, zigzag(std::llround(value)));
    } else {
      const auto bits = std::bit_cast<std::uint64_t>(value);
      for (int shift = 0; shift < 64; shift += 8) bytes_.push_back(static_cast<char>(bits >> shift));
    }
  }
}

bool PhysicsLogReader::read_varint(std::uint64_t& value) {
  value = 0;
  for (int shift = 0; shift < 64 && at_ < bytes_.size(); shift += 7) {
    const auto byte = static_cast<std::uint8_t>(bytes_[at_++]);
    value |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
    if (byte < 0x80) return true;
  }
  return false;
}

Expected<std::optional<PhysicsWrite>> PhysicsLogReader::next() {
  if (at_ == bytes_.size()) return std::optional<PhysicsWrite>{};
  const std::size_t start = at_;
  const auto damaged = [&] { return input_error("physics log: damaged at byte " + std::to_string(start)); };
  PhysicsWrite write;
  std::uint64_t number = 0;
  if (!read_varint(number)) return damaged();
  step_ += static_cast<std::int64_t>(number);
  write.step = step_;
  if (at_ == bytes_.size() || static_cast<std::uint8_t>(bytes_[at_]) > kLastKind) return damaged();
  write.kind = static_cast<WriteKind>(bytes_[at_++]);
  if (!read_varint(number) || number > 0xffffff) return damaged();
  write.index = static_cast<int>(number);
  const Layout layout = layout_of(write.kind);
  for (int i = 0; i < layout.count; ++i) {
    double& value = write.values[static_cast<std::size_t>(i)];
    if (layout.whole) {
      if (!read_varint(number)) return damaged();
      value = static_cast<double>(unzigzag(number));
    } else {
      if (bytes_.size() - at_ < 8) return damaged();
      std::uint64_t bits = 0;
      for (int shift = 0; shift < 64; shift += 8)
        bits |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(bytes_[at_++])) << shift;
      value = std::bit_cast<double>(bits);
    }
  }
  return std::optional<PhysicsWrite>{write};
}

}  // namespace cxlab::sim
