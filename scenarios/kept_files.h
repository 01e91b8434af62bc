#pragma once
// Copies of what a run reads, in its folder: the names that they have there, for keeping and for finding them again.
// Names do not depend on where the files lay.
//
//   scenario.yaml                 the scenario
//   models/FILE                   of the world
//   world/KEY/FILE                what a key of its settings names
//   nodes/NAME                    what a node beside the world read
//   interfaces/PACKAGE/msg/FILE   definitions
//   agents/N/config/FILE          the configuration of the agent of that number: two agents may call different folders
//   agents/N/packages/PACKAGE/... by one name
//   agents/N/outside/...          what lies in no package
//   what_if/N/FILE                rules that came in the middle of the run (lab/what_if.h)

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/journal/file_store.h"
#include "scenarios/scenario.h"

namespace cxlab {

/// Package -> folder, absolute.
using Shares = std::map<std::string, std::string>;

class KeptFiles {
 public:
  using FileRead = std::function<void(const std::filesystem::path&)>;

  /// Keeps nothing where there is no folder. `shares` are those of the agents, `packages` those of the whole scenario.
  /// `file_read`, if any, is called with each file.
  static Expected<KeptFiles> create(const std::filesystem::path& run_folder, std::vector<Shares> shares,
                                    const Shares& packages, FileRead file_read = {});

  Status keep(const std::string& name, const std::filesystem::path& file);
  Status keep_text(const std::string& name, const std::string& text);
  /// A file that an agent read; its configuration is `config`.
  Status keep_for_agent(std::size_t agent, const std::filesystem::path& config, const std::filesystem::path& file);
  /// Every definition that was read since the last call.
  Status keep_interfaces(const bus::Registry& registry);

 private:
  std::filesystem::path run_folder_;
  std::vector<Shares> shares_;
  Shares own_;                                             // of cxlab
  std::map<std::filesystem::path, std::string> packages_;  // by folder
  std::set<std::filesystem::path> interfaces_;             // that were kept
  FileRead file_read_;
  std::optional<FileStore> store_;
};

/// Lets the manager of the agent of that number read the copies below `copies` instead of the files.
void read_from_copies(const std::filesystem::path& copies, std::size_t agent, cx::ManagerOptions& manager);
/// Lets the world read the copies.
void read_from_copies(const std::filesystem::path& copies, Scenario& scenario);
/// The name of the copy of a file that the world's settings name by that key.
std::string kept_name(const std::string& key, const NamedFile& file);
/// The definitions among the copies.
std::filesystem::path interfaces_below(const std::filesystem::path& copies);

}  // namespace cxlab
