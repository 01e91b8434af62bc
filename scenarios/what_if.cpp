#include "scenarios/what_if.h"

#include <filesystem>

namespace cxlab {

std::string WhatIf::file_name() const { return std::filesystem::path(file).filename().string(); }

void name_copies(std::vector<WhatIf>& changes) {
  for (std::size_t k = 0; k < changes.size(); ++k)
    changes[k].copy = changes[k].file.empty() ? "" : "what_if/" + std::to_string(k) + '/' + changes[k].file_name();
}

}  // namespace cxlab
