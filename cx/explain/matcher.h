#pragma once
// Which combinations of facts satisfy conditions, as CLIPS would find them, and how far they get.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cx/engine/engine.h"
#include "cx/explain/left_hand_side.h"

namespace cxlab::explain {

/// The facts and instances of an environment, as they are when this is made and as rules of one module see them.
class Facts {
 public:
  Facts(const RuleEngine& engine, std::string module);
  Facts(const Facts&) = delete;
  Facts& operator=(const Facts&) = delete;
  /// The facts that the pattern may match, in order of assertion.
  const std::vector<const FactCopy*>& of(const Pattern& pattern) const;

 private:
  const RuleEngine& engine_;
  std::string module_;
  std::vector<FactCopy> facts_, instances_;
  mutable std::map<std::string, std::vector<const FactCopy*>, std::less<>> by_template_;  // as a pattern names it
};

/// A combination that satisfies conditions.
struct Combination {
  Bindings bindings;
  std::vector<const FactCopy*> facts{};  ///< of the patterns, in order
};

/// As conditions within a `not`, `exists` or `forall` see it: what they bind is their own, and may have any value.
Combination inside(Combination combination);

class Matcher {
 public:
  Matcher(const Facts& facts, Evaluator& evaluator) : facts_(facts), evaluator_(evaluator) {}

  using Found = std::function<bool(const Combination&)>;
  using Conditions = std::vector<const Condition*>;
  /// Calls `found` with each combination that satisfies all conditions, until it returns true; whether it did.
  bool satisfy(const Conditions& conditions, const Combination& begun, const Found& found);
  bool satisfiable(const Conditions& conditions, const Combination& begun);

  /// How far the conditions get together: the first `depth` are satisfied by `combinations`, no combination satisfies
  /// one more. All are satisfied where `depth` is their number.
  struct Reach {
    std::size_t depth = 0;
    std::vector<Combination> combinations;  ///< at most `kKept`
    std::size_t count = 0;                  ///< of all combinations
  };
  static constexpr std::size_t kKept = 1000;
  Reach reach(const Conditions& conditions, const Combination& begun);

  const Facts& facts() const { return facts_; }
  Evaluator& evaluator() const { return evaluator_; }
  /// Whether so much was tried that the search has ended early.
  bool exhausted() const { return tried_ > kMostTried; }

 private:
  static constexpr std::int64_t kMostTried = 20'000'000;
  bool walk(const Conditions& conditions, std::size_t from, Combination& now, const Found& found);
  bool satisfy_one(const Condition& condition, Combination& now, const std::function<bool()>& then);

  const Facts& facts_;
  Evaluator& evaluator_;
  std::int64_t tried_ = 0;  // facts compared with patterns
};

/// The alternatives of a left-hand side: each `or` outside of other conditions taken apart, each `and` there flattened.
/// In the order of CLIPS, which makes a rule of each.
struct Alternative {
  Matcher::Conditions conditions;
  std::vector<int> numbers;  ///< of the conditions of the rule that they are or are part of, from 1
  /// Variables that its patterns bind, each once.
  std::vector<std::string> binds() const;
};
std::vector<Alternative> alternatives_of(const std::vector<Condition>& conditions);

}  // namespace cxlab::explain
