#pragma once
// Where programs of a user remember things.

#include <filesystem>

namespace cxlab::lab {

/// `$XDG_STATE_HOME/cxlab`, without it `~/.local/state/cxlab`; empty where neither is known. Who writes there makes it.
std::filesystem::path state_folder();

}  // namespace cxlab::lab
