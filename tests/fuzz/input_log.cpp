// inputs.bin. The first byte says whether the rest is a file, or the payload of a chunk that gets its checksum here.

#include <xxhash.h>

#include <cstring>

#include "cx/journal/input_log.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_input_log {

FUZZ_TARGET(input_log) {
  using namespace cxlab;
  if (size == 0) return 0;
  std::string bytes = fuzz::text_of(data + 1, size - 1);
  if (data[0] % 2 == 0) {
    const auto length = static_cast<std::uint32_t>(bytes.size());
    const std::uint64_t checksum = XXH3_64bits(bytes.data(), bytes.size());
    std::string framed("CXLABIN2");
    framed.append(reinterpret_cast<const char*>(&length), sizeof length);
    framed.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
    bytes = framed + bytes;
  }
  auto log = InputLogReader::from_bytes(std::move(bytes), "inputs.bin");
  if (!log) return 0;
  std::size_t entries = 0;
  while (log->next()) ++entries;
  fuzz::promise(entries <= size, "no more entries than bytes");
  (void)log->status();
  return 0;
}

}  // namespace fuzz_input_log
