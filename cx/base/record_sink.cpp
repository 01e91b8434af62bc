#include "cx/base/record_sink.h"

#include <algorithm>
#include <array>

namespace cxlab {

std::string_view to_string(RecordKind kind) {
  static constexpr std::array<std::string_view, 11> kNames{"input", "assert",  "retract",  "modify",  "fire", "bus",
                                                           "skill", "referee", "decision", "control", "error"};
  return kNames[static_cast<std::size_t>(kind)];
}

void RecordData::grow(std::size_t bytes) { memory_.resize(std::max<std::size_t>(256, 2 * (size_ + bytes))); }

RecordData& RecordData::begin(const RecordData& opening) {
  fields_ = opening.fields_;
  size_ = 0;
  record_data::put(room(opening.size_), opening.bytes());
  return took(opening.size_);
}

RecordData& RecordData::field(std::string_view key, std::span<const double> values) {
  name(key).open_list(values.size());
  for (const double v : values) value(v);
  return *this;
}

}  // namespace cxlab
