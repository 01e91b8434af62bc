#pragma once
// Two recorded runs, compared: where their rules part first, what led to it in both, and what came of it.

#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/inspector.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

struct Comparison {
  /// A rule or another construct that only one run has, or that is written differently.
  struct Construct {
    std::string kind, name;
    std::string a, b;  ///< FILE:LINE in each; empty: it is not there
  };
  std::vector<Construct> constructs;
  std::vector<std::string> only_in_a, only_in_b;  ///< environments that the other run has not

  /// What one of the runs did where they part.
  struct Side {
    std::string what;  ///< in one line; empty: it did nothing more
    std::optional<inspect::Derivation> because;
    /// Why a rule that fired in the other run did not fire here, or what is in the message; one line.
    std::string remark;
    std::string rule;                              ///< it fired in the other run, and not here for what it lacks:
    std::optional<explain::UnmetCondition> lacks;  ///< the same that the remark says
  };
  /// The first event of rules that differs; none: all that both runs did is the same.
  struct First {
    std::string environment;
    SimTime t{};
    Side a, b;
  };
  std::optional<First> first;
  SimTime compared{};  ///< up to then

  /// Numbers and texts of result.json that differ, by their path, as JSON; empty: not there.
  struct Outcome {
    std::string path, a, b;
  };
  std::vector<Outcome> outcomes;
  bool stopped = false;  ///< by the host; then nothing was compared

  bool same() const { return !first && outcomes.empty() && only_in_a.empty() && only_in_b.empty(); }
};

/// As people read it, in lines of at most 100 columns.
std::string text_of(const Comparison& comparison);

/// Plays the rules of both runs again. Runs that have no environment in common are an error.
Expected<Comparison> compare(const Run& a, const Run& b, const Host& host = {});

}  // namespace cxlab::lab
