#include "cx/journal/chunk.h"

#include <xxhash.h>

#include <cassert>
#include <cstdint>

namespace cxlab {

std::string framed_chunk(std::string_view bytes) {
  const auto length = static_cast<std::uint32_t>(bytes.size());
  const std::uint64_t checksum = XXH3_64bits(bytes.data(), bytes.size());
  assert(bytes.size() == length);
  std::string framed;
  ByteWriter(framed).fixed(length).fixed(checksum).raw(bytes);
  return framed;
}

Expected<std::string_view> read_chunk(ByteReader& in) {
  const auto length = in.fixed<std::uint32_t>();
  const auto checksum = in.fixed<std::uint64_t>();
  const std::string_view bytes = in.raw(length);
  if (!in.ok()) return input_error("the last chunk is cut off");
  if (XXH3_64bits(bytes.data(), bytes.size()) != checksum) return input_error("the chunk does not have its checksum");
  return bytes;
}

}  // namespace cxlab
