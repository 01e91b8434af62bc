#include "sim/box2d/turtle_log.h"

#include <cmath>

namespace cxlab::sim {

namespace {

constexpr std::array<std::size_t, 7> kValues{3, 0, 3, 3, 5, 0, 3};  // by verb

}  // namespace

void TurtleLog::record(const TurtleWrite& write) {
  ByteWriter out(bytes_);
  out.fixed(write.step).fixed(write.turtle).fixed(write.verb);
  for (std::size_t i = 0; i < kValues[static_cast<std::size_t>(write.verb)]; ++i) out.fixed(write.values[i]);
}

Expected<std::optional<TurtleWrite>> TurtleLogReader::next() {
  if (in_.left() == 0) return std::optional<TurtleWrite>();
  const std::size_t start = in_.position();
  TurtleWrite write;
  write.step = in_.fixed<std::int64_t>();
  write.turtle = in_.fixed<TurtleId>();
  write.verb = in_.fixed<TurtleVerb>();
  const auto verb = static_cast<std::size_t>(write.verb);
  if (verb >= kValues.size()) in_.refuse();
  for (std::size_t i = 0; in_.ok() && i < kValues[verb]; ++i) {
    write.values[i] = in_.fixed<double>();
    if (!std::isfinite(write.values[i])) in_.refuse();
  }
  if (!in_.ok()) return input_error("the log of the turtles is damaged at byte " + std::to_string(start));
  return std::optional(write);
}

}  // namespace cxlab::sim
