#pragma once
// MuJoCo as a library: what a program asks of it as a whole.

#include <string>

namespace cxlab::sim {

std::string mujoco_version();

/// For the program alone, once: `on_error` takes MuJoCo's fatal errors and must not return; its warnings are not
/// written to MUJOCO_LOG.TXT in the current folder (a world that diverges reports that itself).
void on_mujoco_bug(void (*on_error)(const char* message));

}  // namespace cxlab::sim
