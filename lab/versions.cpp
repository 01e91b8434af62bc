#include "lab/versions.h"

#include <gnu/libc-version.h>
#include <sys/utsname.h>

#include <cmath>

#include "cx/engine/version.h"
#include "cx/journal/file_store.h"
#include "cx/template/template.h"
#include "sim/box2d/library.h"
#include "sim/mujoco/library.h"

namespace cxlab::lab {

const char* cxlab_version() { return CXLAB_VERSION; }

std::vector<std::pair<std::string, std::string>> versions() {
  return {{"cxlab", CXLAB_VERSION},
          {"CLIPS", clips_version()},
          {"MuJoCo", sim::mujoco_version()},
          {"minijinja", templates::minijinja_version()},
          {"Box2D", sim::box2d_version()}};
}

namespace {

std::string digest_of_functions() {
  std::string bytes;
  const auto add = [&bytes](double value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (int i = 1; i <= 2000; ++i) {
    const double x = 0.0173 * i, y = 1 / x;
    for (const double value : {std::sin(x), std::cos(x), std::tan(x), std::atan2(x, y), std::exp(y), std::log(x)})
      add(value);
    add(std::pow(x, y));
  }
  return content_hash(bytes);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> machine() {
  utsname system{};
  uname(&system);
  return {{"architecture", system.machine},
          {"C library", std::string("glibc ") + gnu_get_libc_version()},
          {"digest of sin, cos, pow", digest_of_functions()}};
}

}  // namespace cxlab::lab
