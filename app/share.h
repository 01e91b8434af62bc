#pragma once
// Where the data that comes with cxlab lies: the source tree, or share/cxlab beside an installed program.

#include <filesystem>

namespace cxlab::app {

struct Share {
  std::filesystem::path interfaces;  ///< packages of interface definitions
  std::filesystem::path models;      ///< MJCF
  std::filesystem::path scenarios;
  std::filesystem::path docs;
};

/// $CXLAB_SHARE, else ../share/cxlab seen from the program, else the source tree that it was built from.
Share find_share();

}  // namespace cxlab::app
