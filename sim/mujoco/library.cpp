#include "sim/mujoco/library.h"

#include <mujoco/mujoco.h>

namespace cxlab::sim {

std::string mujoco_version() { return mj_versionString(); }

void on_mujoco_bug(void (*on_error)(const char* message)) {
  mju_user_warning = [](const char*) {};
  mju_user_error = on_error;
}

}  // namespace cxlab::sim
