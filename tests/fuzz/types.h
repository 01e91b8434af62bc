#pragma once
// Types for targets that read messages: those that come with cxlab, and every/msg/Kind with a field of each kind.

#include <filesystem>

#include "cx/bus/interface.h"
#include "tests/fuzz/fuzz.h"

namespace cxlab::fuzz {

inline bus::Registry& types() {
  static bus::Registry packages = [] {
    bus::Registry made;
    const std::filesystem::path source = CXLAB_SOURCE_DIR;
    promise(made.add_packages_in(source / "cx/interfaces").ok(), "the packages of cxlab are there");
    promise(made.add_package("every", source / "tests/fuzz/every").ok(), "the package of these targets is there");
    return made;
  }();
  return packages;
}

}  // namespace cxlab::fuzz
