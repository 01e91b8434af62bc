#pragma once
// Values as bytes and back: what all binary files of cxlab are made of. Little-endian.
//
//   ByteWriter(out).varint(step).fixed(speed).text("belt");
//   ByteReader in(bytes);
//   const auto step = in.varint();  const auto speed = in.fixed<double>();  const auto name = in.text();
//   if (!in.ok()) ...  // the bytes were cut off or malformed; what was read since then is zero or empty

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace cxlab {

static_assert(std::endian::native == std::endian::little, "fixed() copies memory");

/// Appends to a string.
class ByteWriter {
 public:
  explicit ByteWriter(std::string& out) : out_(out) {}

  /// All bytes of an integer, an enumerator or a double.
  template <class T>
    requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_enum_v<T>
  ByteWriter& fixed(T value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    return raw({bytes, sizeof value});
  }
  /// 7 bits a byte, lowest first; the high bit says that more follow.
  ByteWriter& varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) out_.push_back(static_cast<char>(value | 0x80));
    out_.push_back(static_cast<char>(value));
    return *this;
  }
  /// A varint with the sign in its lowest bit.
  ByteWriter& zigzag(std::int64_t value) {
    return varint((static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
  }
  ByteWriter& raw(std::string_view bytes) {
    out_.append(bytes);
    return *this;
  }
  /// The length as a varint, then the bytes.
  ByteWriter& text(std::string_view bytes) { return varint(bytes.size()).raw(bytes); }

 private:
  std::string& out_;
};

/// Takes values from the front of bytes that must outlive it. After the first value that is not whole, `ok` is false
/// and every value is zero or empty.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  /// The caller has found a value that no writer writes.
  void refuse() { ok_ = false; }
  std::size_t position() const { return at_; }  ///< bytes read so far
  std::size_t left() const { return bytes_.size() - at_; }

  template <class T>
    requires(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_enum_v<T>
  T fixed() {
    T value{};
    const std::string_view bytes = raw(sizeof value);
    if (ok_) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const auto next = fixed<std::uint8_t>();
      value |= static_cast<std::uint64_t>(next & 0x7f) << shift;
      if (next < 0x80) return ok_ ? value : 0;
    }
    refuse();
    return 0;
  }
  std::int64_t zigzag() {
    const std::uint64_t value = varint();
    return static_cast<std::int64_t>(value >> 1 ^ (0 - (value & 1)));
  }
  std::string_view raw(std::uint64_t size) {
    if (!ok_ || size > left()) {
      ok_ = false;
      return {};
    }
    const std::string_view taken = bytes_.substr(at_, size);
    at_ += size;
    return taken;
  }
  std::string_view text() { return raw(varint()); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace cxlab
