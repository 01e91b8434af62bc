// Configurations of the environment manager: the first byte says how strict, the rest is the YAML. A configuration that
// can be read lives for two ticks, with all plugins of cxlab and the rules of an example, and ends.

#include <filesystem>
#include <fstream>

#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/journal/journal.h"
#include "cx/plugins/builtin.h"
#include "cx/run/loop.h"
#include "tests/fuzz/surroundings.h"

namespace fuzz_configuration {
namespace {

namespace fs = std::filesystem;

/// Whether it went well.
bool reported(const cxlab::Status& status) {
  cxlab::fuzz::promise(status.ok() || !status.error().message.empty(), "an error says what it is");
  return status.ok();
}

void two_ticks(cxlab::cx::EnvironmentManager& manager, cxlab::bus::Bus& bus) {
  cxlab::Loop loop(bus, std::chrono::milliseconds(20), {.agents = {&manager}});
  for (int tick = 0; tick < 2; ++tick)
    if (!reported(loop.tick_at(tick * std::chrono::milliseconds(20)))) return;
}

void live(cxlab::cx::ManagerOptions options) {
  using namespace cxlab;
  Journal journal;
  bus::Bus bus(fuzz::registry(), journal);
  auto made = cx::EnvironmentManager::create(std::move(options), bus, journal);
  if (!made) return (void)reported(made.error());
  cx::EnvironmentManager& manager = **made;
  if (!reported(manager.configure())) return;
  // A node whose activation failed is active all the same, so it must be deactivated, too.
  if (reported(manager.activate())) two_ticks(manager, bus);
  reported(manager.deactivate());
  fuzz::promise(manager.state() != cx::LifeState::kActive, "what was deactivated is not active");
  reported(manager.cleanup());
}

}  // namespace

FUZZ_TARGET(configuration) {
  using namespace cxlab;
  if (size == 0) return 0;
  const fs::path config = fuzz::folder() / "config.yaml";
  std::ofstream(config, std::ios::binary) << fuzz::text_of(data + 1, size - 1);
  cx::ManagerOptions options;
  options.config = config;
  options.plugin_types = cx::builtin_plugins();
  options.packages["example"] = {fs::path(CXLAB_SOURCE_DIR) / "docs/examples/file_load", {}};
  options.run_folder = fuzz::folder() / "run";
  options.max_firings = 100;
  options.strict = (data[0] & 1U) != 0;
  options.keep_going = (data[0] & 2U) != 0;
  options.stop_on_rule_error = (data[0] & 4U) != 0;
  live(std::move(options));
  std::error_code ignored;
  fs::remove_all(fuzz::folder() / "run", ignored);
  return 0;
}

}  // namespace fuzz_configuration
