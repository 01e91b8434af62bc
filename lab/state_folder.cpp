#include "lab/state_folder.h"

#include <cstdlib>

namespace cxlab::lab {

namespace fs = std::filesystem;

fs::path state_folder() {
  const char* state = std::getenv("XDG_STATE_HOME");
  const char* home = std::getenv("HOME");
  fs::path folder;
  if (state != nullptr && *state == '/')
    folder = state;
  else if (home != nullptr && *home == '/')
    folder = fs::path(home) / ".local" / "state";
  return folder.empty() ? folder : folder / "cxlab";
}

}  // namespace cxlab::lab
