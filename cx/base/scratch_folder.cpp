#include "cx/base/scratch_folder.h"

#include <cstdlib>
#include <string>
#include <system_error>

namespace cxlab {

namespace fs = std::filesystem;

Expected<std::unique_ptr<ScratchFolder>> ScratchFolder::create() {
  std::error_code error;
  std::string name = (fs::temp_directory_path(error) / "cxlab-XXXXXX").string();
  if (error || !mkdtemp(name.data())) return resource_error("cannot make a temporary folder " + name);
  return std::unique_ptr<ScratchFolder>(new ScratchFolder(name));
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace cxlab
