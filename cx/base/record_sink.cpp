#include "cx/base/record_sink.h"

#include <array>
#include <bit>
#include <cstring>

namespace cxlab {

std::string_view to_string(RecordKind kind) {
  static constexpr std::array<std::string_view, 11> kNames{"input", "assert", "retract", "modify", "fire", "bus",
                                                           "skill", "referee", "decision", "control", "error"};
  return kNames[static_cast<std::size_t>(kind)];
}

// MessagePack, https://github.com/msgpack/msgpack/blob/master/spec.md; the outer map is always a map 16.

RecordData& RecordData::begin() {
  bytes_.assign("\xde\x00\x00", 3);
  fields_ = 0;
  return *this;
}

void RecordData::put_be(std::uint64_t value, int size) {
  // What is not used of the eight bytes is shifted out.
  std::uint64_t big_endian = value << (64 - 8 * size);
  if constexpr (std::endian::native == std::endian::little) big_endian = __builtin_bswap64(big_endian);
  std::array<char, 8> bytes;
  std::memcpy(bytes.data(), &big_endian, bytes.size());
  bytes_.append(bytes.data(), static_cast<std::size_t>(size));
}

RecordData& RecordData::name(std::string_view key) {
  ++fields_;
  bytes_[1] = static_cast<char>(fields_ >> 8);
  bytes_[2] = static_cast<char>(fields_);
  return value(key);
}

RecordData& RecordData::value(std::int64_t value) {
  if (value >= 0 && value < 128) {
    bytes_.push_back(static_cast<char>(value));
  } else if (value >= INT32_MIN && value <= INT32_MAX) {
    bytes_.push_back('\xd2');
    put_be(static_cast<std::uint64_t>(value), 4);
  } else {
    bytes_.push_back('\xd3');
    put_be(static_cast<std::uint64_t>(value), 8);
  }
  return *this;
}

RecordData& RecordData::value(double value) {
  bytes_.push_back('\xcb');
  put_be(std::bit_cast<std::uint64_t>(value), 8);
  return *this;
}

RecordData& RecordData::value(bool value) {
  bytes_.push_back(value ? '\xc3' : '\xc2');
  return *this;
}

RecordData& RecordData::value(std::string_view value) {
  if (value.size() < 32) {
    bytes_.push_back(static_cast<char>(0xa0 | value.size()));
  } else {
    bytes_.push_back('\xdb');
    put_be(value.size(), 4);
  }
  bytes_.append(value);
  return *this;
}

RecordData& RecordData::nil() {
  bytes_.push_back('\xc0');
  return *this;
}

RecordData& RecordData::open_list(std::size_t size) {
  bytes_.push_back('\xdd');
  put_be(size, 4);
  return *this;
}

RecordData& RecordData::open_map(std::size_t size) {
  bytes_.push_back('\xdf');
  put_be(size, 4);
  return *this;
}

RecordData& RecordData::field(std::string_view key, std::span<const double> values) {
  name(key).open_list(values.size());
  for (const double v : values) value(v);
  return *this;
}

}  // namespace cxlab
