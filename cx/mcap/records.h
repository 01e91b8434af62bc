#pragma once
// The records of MCAP: a byte that says what it is, the length of what follows, and that.

#include <cstdint>

namespace cxlab::mcap {

inline constexpr char kMagic[] = "\x89MCAP0\r\n";
inline constexpr std::size_t kMagicSize = 8;

enum class Opcode : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kMetadata = 12,
  kMetadataIndex = 13,
  kSummaryOffset = 14,
  kDataEnd = 15,
};

}  // namespace cxlab::mcap
