#include "app/share.h"

#include <cstdlib>

namespace cxlab::app {

namespace fs = std::filesystem;

Share find_share() {
  const auto installed = [](const fs::path& root) {
    return Share{root / "interfaces", root / "models", root / "scenarios", root / "docs"};
  };
  if (const char* named = std::getenv("CXLAB_SHARE")) return installed(named);
  std::error_code ignored;
  const fs::path beside = fs::read_symlink("/proc/self/exe", ignored).parent_path().parent_path() / "share/cxlab";
  if (fs::is_directory(beside, ignored)) return installed(beside);
  const fs::path source = CXLAB_SOURCE_DIR;
  return Share{source / "cx/interfaces", source / "models", source / "scenarios", source / "docs"};
}

}  // namespace cxlab::app
