#include "sim/box2d/turtle_log.h"

#include <bit>
#include <cmath>

namespace cxlab::sim {

namespace {

constexpr std::array<std::size_t, 7> kValues{3, 0, 3, 3, 5, 0, 3};  // by verb

template <typename Int>
void put(std::string& out, Int value) {
  for (std::size_t i = 0; i < sizeof value; ++i) out += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i));
}

std::uint64_t read_le(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(bytes[i]);
  return value;
}

}  // namespace

void TurtleLog::record(const TurtleWrite& write) {
  put(bytes_, write.step);
  put(bytes_, static_cast<std::int32_t>(write.turtle));
  put(bytes_, static_cast<std::uint8_t>(write.verb));
  for (std::size_t i = 0; i < kValues[static_cast<std::size_t>(write.verb)]; ++i)
    put(bytes_, std::bit_cast<std::uint64_t>(write.values[i]));
}

Expected<std::optional<TurtleWrite>> TurtleLogReader::next() {
  if (at_ == bytes_.size()) return std::optional<TurtleWrite>();
  const auto broken = [this] {
    return input_error("the log of the turtles is damaged at byte " + std::to_string(at_));
  };
  constexpr std::size_t kHead = 13;
  if (bytes_.size() - at_ < kHead) return broken();
  TurtleWrite write;
  write.step = static_cast<std::int64_t>(read_le(bytes_.substr(at_, 8)));
  write.turtle = TurtleId{static_cast<std::int32_t>(read_le(bytes_.substr(at_ + 8, 4)))};
  const auto verb = static_cast<std::uint8_t>(bytes_[at_ + 12]);
  if (verb >= kValues.size() || bytes_.size() - at_ - kHead < 8 * kValues[verb]) return broken();
  write.verb = TurtleVerb{verb};
  for (std::size_t i = 0; i < kValues[verb]; ++i) {
    write.values[i] = std::bit_cast<double>(read_le(bytes_.substr(at_ + kHead + 8 * i, 8)));
    if (!std::isfinite(write.values[i])) return broken();
  }
  at_ += kHead + 8 * kValues[verb];
  return std::optional(write);
}

}  // namespace cxlab::sim
