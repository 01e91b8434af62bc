#pragma once

#include <filesystem>
#include <string>

namespace cxlab::lab {

/// One picture of a run.
struct Picture {
  std::string caption;
  std::filesystem::path file;  ///< PNG
};

}  // namespace cxlab::lab
