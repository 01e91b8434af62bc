#pragma once
// The values of a `RecordData`, one after the other. Only for the sources of the journal.

#include <bit>
#include <cstdint>
#include <string_view>

#include "cx/base/byte_codec.h"

namespace cxlab {

enum class ItemType { kBad, kNil, kTruth, kInteger, kUnsigned, kReal, kText, kList, kMap };

struct Item {
  ItemType type = ItemType::kBad;
  std::int64_t integer = 0;  ///< also the truth, the bits of an unsigned, and the size of a list or map
  double real = 0;
  std::string_view text;
};

/// Reads the subset of MessagePack that `RecordData` writes.
class ItemReader {
 public:
  explicit ItemReader(std::string_view bytes) : in_(bytes) {}

  bool at_end() const { return in_.left() == 0; }
  std::size_t position() const { return in_.position(); }

  Item next() {
    const auto tag = in_.fixed<std::uint8_t>();
    if (!in_.ok()) return {};
    if (tag < 0x80) return {ItemType::kInteger, tag, 0, {}};
    if (tag >= 0xa0 && tag < 0xc0) return text(tag & 0x1f);
    switch (tag) {
      case 0xc0: return {ItemType::kNil, 0, 0, {}};
      case 0xc2: return {ItemType::kTruth, 0, 0, {}};
      case 0xc3: return {ItemType::kTruth, 1, 0, {}};
      case 0xcb: return whole({ItemType::kReal, 0, std::bit_cast<double>(number<std::uint64_t>()), {}});
      case 0xcf: return whole({ItemType::kUnsigned, static_cast<std::int64_t>(number<std::uint64_t>()), 0, {}});
      case 0xd2: return whole({ItemType::kInteger, static_cast<std::int32_t>(number<std::uint32_t>()), 0, {}});
      case 0xd3: return whole({ItemType::kInteger, static_cast<std::int64_t>(number<std::uint64_t>()), 0, {}});
      case 0xdb: return text(number<std::uint32_t>());
      case 0xdd: return container(ItemType::kList, number<std::uint32_t>());
      case 0xde: return container(ItemType::kMap, number<std::uint16_t>());
      case 0xdf: return container(ItemType::kMap, number<std::uint32_t>());
      default: return {};
    }
  }

 private:
  /// MessagePack is big-endian.
  template <class T>
  T number() {
    std::uint64_t value = 0;
    for (const char byte : in_.raw(sizeof(T))) value = value << 8 | static_cast<std::uint8_t>(byte);
    return static_cast<T>(value);
  }
  Item whole(const Item& item) const { return in_.ok() ? item : Item{}; }
  Item text(std::size_t size) { return whole({ItemType::kText, 0, 0, in_.raw(size)}); }
  /// Each element takes a byte at least, so a size beyond the rest is malformed (and never allocated).
  Item container(ItemType type, std::size_t size) const {
    return size > in_.left() ? Item{} : whole({type, static_cast<std::int64_t>(size), 0, {}});
  }

  ByteReader in_;
};

}  // namespace cxlab
