#pragma once
// The folder in which programs of a user keep their state.

#include <filesystem>

namespace cxlab::lab {

/// `$XDG_STATE_HOME/cxlab`, without it `~/.local/state/cxlab`; empty where neither is known. Who writes there makes it.
std::filesystem::path state_folder();

}  // namespace cxlab::lab
