#pragma once
// Pictures, and PNG files of them.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::sim {

/// RGB, 8 bits each, top row first.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

Status write_png(const Picture& picture, const std::filesystem::path& file);

}  // namespace cxlab::sim
