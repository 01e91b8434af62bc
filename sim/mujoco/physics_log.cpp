#include "sim/mujoco/physics_log.h"

#include <cmath>

namespace cxlab::sim {
namespace {

struct Layout {
  std::size_t count = 0;
  bool whole = true;  ///< integers
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
    case WriteKind::kSetDown: return {3, false};
    case WriteKind::kCarry: return {1, true};
  }
  return {0, true};
}
constexpr WriteKind kLastKind = WriteKind::kCarry;

}  // namespace

void PhysicsLog::record(const PhysicsWrite& write) {
  ByteWriter out(bytes_);
  out.varint(static_cast<std::uint64_t>(write.step - last_step_)).fixed(write.kind);
  out.varint(static_cast<std::uint64_t>(write.index));
  last_step_ = write.step;
  const Layout layout = layout_of(write.kind);
  for (std::size_t i = 0; i < layout.count; ++i) {
    if (layout.whole)
      out.zigzag(std::llround(write.values[i]));
    else
      out.fixed(write.values[i]);
  }
}

Expected<std::optional<PhysicsWrite>> PhysicsLogReader::next() {
  if (in_.left() == 0) return std::optional<PhysicsWrite>{};
  const std::size_t start = in_.position();
  PhysicsWrite write;
  step_ += static_cast<std::int64_t>(in_.varint());
  write.step = step_;
  write.kind = in_.fixed<WriteKind>();
  const std::uint64_t index = in_.varint();
  if (write.kind > kLastKind || index > 0xffffff) in_.refuse();
  write.index = static_cast<int>(index);
  const Layout layout = in_.ok() ? layout_of(write.kind) : Layout{};
  for (std::size_t i = 0; i < layout.count; ++i)
    write.values[i] = layout.whole ? static_cast<double>(in_.zigzag()) : in_.fixed<double>();
  if (!in_.ok()) return input_error("physics log: damaged at byte " + std::to_string(start));
  return std::optional<PhysicsWrite>{write};
}

}  // namespace cxlab::sim
