#pragma once
// The nodes that come with cxlab and stand beside world and agents: what `servers:` of a scenario and `--with` of
// `cxlab env` name. One explicit list; who adds a node adds it there.

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "cx/node/log.h"
#include "cx/yaml/yaml.h"
#include "scenarios/scenario.h"
#include "scenarios/stage.h"

namespace cxlab {

/// What a node is made with; all of it outlives the node.
struct NodeSetup {
  const Scenario& scenario;
  bus::Bus& bus;
  RecordSink& sink;
  cx::LogSink* log = nullptr;        ///< may be none
  std::filesystem::path run_folder;  ///< empty = nothing is written
  /// Told of each file that a node reads, before it does, for the run's copy.
  std::function<Status(const std::string& logical_name, const std::filesystem::path& file)> keep;
};

struct NodeKind {
  std::string_view name;
  std::string_view what;                            ///< one line for people
  void (*read)(yaml::Map& keys, ServerSpec& spec);  ///< the node's own keys; the caller finishes the map
  Status (*add)(const ServerSpec& spec, const NodeSetup& setup, Stage& stage);  ///< puts it on the stage
};

std::span<const NodeKind> node_kinds();
/// nullptr if there is none of that name.
const NodeKind* find_node(std::string_view name);

}  // namespace cxlab
