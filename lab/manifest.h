#pragma once
// manifest.json in the folder of a run: what was played, with what, and where, so that it can be played again.
//
// Here all files and folders have the names that they had when the run was played: its rules may know them. The file
// names `folder` from the run's folder and the others from the folder of the scenario, so that a checkout can be moved
// together with its runs (`Run::found`); absolute names, as older manifests have them, mean the same.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "scenarios/kept_files.h"
#include "scenarios/run_spec.h"

namespace cxlab::lab {

struct Manifest {
  struct Agent {
    std::string config;  ///< as the scenario names it
    Shares packages;     ///< the share directory of each that it sees, absolute

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("config", config);
      keys.required("packages", packages);
    }
  };

  std::int64_t schema = 1;
  std::string scenario;  ///< its file, from `folder`
  std::vector<std::string> overrides;
  std::uint64_t seed = 0;
  std::map<std::string, std::string> versions, machine;  ///< of lab/versions.h
  std::string tier;
  std::vector<std::string> command;  ///< the arguments of the program
  std::string folder;                ///< in which it was given, absolute
  std::string out;                   ///< its folder when it was played, absolute
  RunSpec spec;
  std::vector<Agent> agents;
  std::vector<std::string> seats;                  ///< names of programs that took part (scenarios/seat.h)
  std::map<std::string, std::string> world_files;  ///< absolute; by key, as Scenario::world_files
  std::map<std::string, std::string> bag;          ///< `file`, absolute, and its `digest`; empty: none is played
  std::string repeat;                              ///< the command that plays the run again

  std::filesystem::path scenario_file() const { return std::filesystem::path(folder) / scenario; }
  std::vector<Shares> shares() const;  ///< by agent

  template <class Keys>
  void fields(Keys& keys) {
    keys("schema", schema);
    keys.required("scenario", scenario);
    keys.required("overrides", overrides);
    keys("seed", seed);
    keys.required("versions", versions);
    keys("machine", machine);
    keys("tier", tier);
    keys("command", command);
    keys.required("folder", folder);
    keys.unless_empty("out", out);
    spec.fields(keys);
    keys.required("agents", agents);
    keys.unless_empty("seats", seats);
    keys("world_files", world_files);
    keys.unless_empty("bag", bag);
    keys("repeat", repeat);
  }

  std::string to_json() const;
  /// Reads that of a run's folder. Errors name manifest.json, and the key.
  static Expected<Manifest> read(const std::filesystem::path& folder);
};

}  // namespace cxlab::lab
