#pragma once
// The scenario that `cxlab env` plays: configurations of the CX in an empty world, or with a world and nodes by name.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "lab/bag_options.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

struct EnvOptions {
  std::vector<std::string> configs;      ///< files; one environment manager each
  std::vector<std::string> with;         ///< a world, and nodes beside it, by name
  std::vector<std::string> packages;     ///< NAME=DIR; the packages around the configurations are found without
  std::vector<std::string> params;       ///< NODE.NAME=VALUE
  std::vector<std::string> remaps;       ///< FROM:=TO
  std::string name_space = "/";          ///< of the managers
  std::string stimuli;                   ///< file
  std::vector<std::string> transitions;  ///< SECONDS:NAME or SECONDS:NAME@NODE
  bool trust_rules = false;
  bool stop_on_rule_error = false;
  bool activate = true;  ///< managers without autostart_node are configured and activated
  std::optional<std::int64_t> max_firings;
  std::optional<std::uint64_t> seed;
  BagOptions bag;
  std::optional<double> until;  ///< s; none: a second after the end of the bag, without a bag 60
};

/// Errors name the option that they are in.
Expected<Scenario> env_scenario(const EnvOptions& options, const Catalogue& catalogue);
/// A world or node that `with` can name; each name appears once.
struct Companion {
  std::string_view name, what;  ///< `what`: one line for people
};
std::vector<Companion> companions(const Catalogue& catalogue);
/// The same for people: "rcll, a game of ...; turtlesim, ...".
std::string known_companions(const Catalogue& catalogue);

}  // namespace cxlab::lab
