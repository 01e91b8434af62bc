#pragma once
// Chunks of binary files: each can be checked alone, so that a file that was cut off is read up to its last whole one.

#include <string>
#include <string_view>

#include "cx/base/byte_codec.h"
#include "cx/base/expected.h"

namespace cxlab {

/// Length and checksum (XXH3, 64 bit) of the bytes, then the bytes.
std::string framed_chunk(std::string_view bytes);
/// The bytes of the chunk that begins here; the error says only what is wrong with it.
Expected<std::string_view> read_chunk(ByteReader& in);

}  // namespace cxlab
