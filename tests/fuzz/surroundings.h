#pragma once
// What targets with an environment manager share.

#include <filesystem>

#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/journal/journal.h"
#include "cx/run/loop.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz.h"

namespace cxlab::fuzz {

/// The packages that come with cxlab.
inline bus::Registry& registry() {
  static bus::Registry packages = [] {
    bus::Registry made;
    promise(made.add_packages_in(std::filesystem::path(CXLAB_SOURCE_DIR) / "cx/interfaces").ok(),
            "the packages of cxlab are there");
    return made;
  }();
  return packages;
}

/// A manager in `folder()` that comes up, is prepared, lives for some ticks of 20 ms, and goes with all that it wrote.
template <class Prepare>
void live(cx::ManagerOptions options, int ticks, const Prepare& prepare) {
  const std::filesystem::path run = options.run_folder = folder() / "run";
  options.max_firings = 100;
  options.keep_going = true;
  {
    Journal journal;
    bus::Bus bus(registry(), journal);
    auto manager = cx::EnvironmentManager::create(std::move(options), bus, journal);
    promise(manager.ok() && (*manager)->configure().ok() && (*manager)->activate().ok(), "the plugins load");
    prepare(**manager);
    Loop loop(bus, std::chrono::milliseconds(20), {.agents = {manager->get()}});
    for (int tick = 0; tick < ticks; ++tick)
      if (!loop.tick_at(tick * std::chrono::milliseconds(20))) break;
    (void)(*manager)->deactivate();
    (void)(*manager)->cleanup();
  }
  std::error_code ignored;
  std::filesystem::remove_all(run, ignored);
}

}  // namespace cxlab::fuzz
