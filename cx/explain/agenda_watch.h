#pragma once
// Which activations of a rule left the agenda without firing, and what was at work then.

#include <map>
#include <string>
#include <vector>

#include "cx/base/time.h"
#include "cx/engine/engine.h"

namespace cxlab::explain {

/// An activation that was taken off the agenda.
struct LostActivation {
  SimTime t{};
  std::vector<std::string> facts;  ///< as they were while it waited
  std::string by;                  ///< rule whose actions took it off, with a module other than MAIN; empty: no rule
};

class AgendaWatch {
 public:
  /// `rule` without a module: all of this name are followed.
  explicit AgendaWatch(std::string rule) : rule_(std::move(rule)) {}

  /// To be called before each firing, with the rule that fires, and after each run of the rules, without one.
  void look(const RuleEngine& engine, SimTime t, const std::string& module = {}, const std::string& firing = {});
  /// The last one of the rule in that module; null if there is none.
  const LostActivation* last(const std::string& module) const;

 private:
  struct Waiting {
    ActivationInfo activation;
    std::vector<std::string> facts;
  };
  std::string rule_, at_work_;
  SimTime since_{};
  std::vector<Waiting> waiting_;
  std::map<std::string, LostActivation> lost_;  // by module
};

}  // namespace cxlab::explain
