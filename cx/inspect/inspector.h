#pragma once
// Answers about one environment of rules at an instant, live or played again: what there is, since when, and why.
//
//   Inspector inspector("main", engine, timelines.of("env/main"));
//   auto facts = inspector.facts("(order (state OPEN))");
//   auto why = inspector.why(Inspector::FactIndex{12});

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/engine.h"
#include "cx/explain/left_hand_side.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/timeline.h"

namespace cxlab::inspect {

using Values = explain::Values;

/// Who did something.
struct Doer {
  enum class Kind {
    kRule,     ///< a rule that fired
    kInput,    ///< something came from outside, for example "topic /game_state"
    kPerson,   ///< with cxlab attach
    kWhatIf,   ///< cxlab rerun --then, --set or --assert
    kStory,    ///< the story that the run plays
    kProgram,  ///< the program that played the run, between ticks
    kStart,    ///< the environment when it started: deffacts, plugins
    kOutside,  ///< the executive or a plugin, for no reason that was recorded
  };
  Kind kind{};
  std::string name;                ///< of the rule, or what came
  std::optional<std::uint64_t> n;  ///< the record of it
  /// "rule order-begin", "topic /game_state", "(at the start)"
  std::string text() const;
};

struct FactChange {
  std::uint64_t n = 0;
  SimTime t{};
  RecordKind kind{};  ///< assert (also for a decision), modify, retract
  Doer by;
  FactCopy after;  ///< of a retract: as it was before
};

/// A fact from its assertion to now, or to its end.
struct FactHistory {
  FactCopy fact;  ///< as it is, or was last; `index` is 0 for a retracted fact
  bool present = true;
  std::vector<FactChange> changes;  ///< the first is its assertion
};

struct FiringCopy {
  std::uint64_t n = 0;
  SimTime t{};
  std::string rule;  ///< with a module other than MAIN
  std::string file;
  int line = 0;
  Values values;                ///< of its variables; empty if the rule was removed or changed since
  std::vector<FactCopy> facts;  ///< that it matched, as they were then
};

/// What a rule has done.
struct RuleUse {
  std::string rule;  ///< with a module other than MAIN
  std::string file;
  int line = 0;
  std::int64_t fired = 0;
  std::optional<std::int64_t> activated;         ///< how often it was put on the agenda; none: nobody counted
  std::optional<SimTime> first, last;            ///< firings
  std::optional<explain::UnmetCondition> unmet;  ///< what it lacks now; of rules that never were on the agenda
};

/// How something came about: steps back to what came from outside.
struct Derivation {
  struct Step {
    std::uint64_t n = 0;
    SimTime t{};
    RecordKind kind{};
    std::string text;        ///< the fact as the step left it; the rule; what came from outside
    std::int64_t index = 0;  ///< of a fact that is still there, as in f-12; else 0
    Values values;           ///< of a firing
    std::string file;        ///< of a firing: where its rule is defined
    int line = 0;
    std::vector<std::size_t> because;    ///< indices of steps; the latest first
    std::optional<std::string> outside;  ///< record of another stream, "node/robot1:17"
    std::string note;                    ///< of a step without a cause: why it has none
    std::optional<FactChange> asserted;  ///< of the fact that was asked for, where it has been changed since
    bool planned = false;                ///< of what was done from outside: `cxlab rerun` was to do it
    bool by_story = false;               ///< the same: the story that the run plays did it
    bool by_program = false;             ///< the same: the program that played the run did it, between ticks
  };
  std::vector<Step> steps;  ///< the first is what was asked for; each record once
};

class Inspector {
 public:
  /// How a file of rules is called for people.
  using FileNames = std::function<std::string(const std::string&)>;
  /// Engine and timeline outlive it.
  Inspector(std::string name, RuleEngine& engine, const Timeline& timeline, FileNames file_names)
      : name_(std::move(name)), engine_(&engine), timeline_(&timeline), file_names_(std::move(file_names)) {}

  const std::string& name() const { return name_; }
  RuleEngine& engine() const { return *engine_; }
  /// A file of rules as people know it.
  const std::string& shown_file(const std::string& file) const;
  const Timeline& timeline() const { return *timeline_; }

  /// `what`: a template, a pattern `(order (id 3))`, `f-12`, or nothing for all. Fails where no fact can ever match.
  Expected<std::vector<FactCopy>> present(const std::string& what) const;
  /// The same with their histories, in order of assertion.
  Expected<std::vector<FactHistory>> facts(const std::string& what) const;
  /// The facts that existed at any time of this stretch.
  Expected<std::vector<FactHistory>> facts(const std::string& what, SimTime from, SimTime to) const;
  /// The names of the slots of the facts that `what` means, also where there are none.
  std::vector<std::string> slot_names(const std::string& what) const;

  /// The executive takes its time fact back after each run of the rules: asserts what the next run would find, where
  /// one has been there. Before conditions are looked at; facts and agenda are others afterwards. Whether it did so.
  bool assert_time() const;

  std::vector<ActivationInfo> agenda() const { return engine_->agenda(); }
  std::vector<std::string> focus() const { return engine_->focus(); }
  std::vector<std::pair<std::string, Value>> globals() const { return engine_->globals(); }

  /// The firings of one rule (with or without a module), or of all if `rule` is empty. Fails for a rule that never was
  /// there.
  Expected<std::vector<FiringCopy>> firings(const std::string& rule, SimTime from, SimTime to) const;

  /// In order of definition. `unmet` is set where `explain` says so.
  std::vector<RuleUse> rules(bool explain) const;
  /// The same as it is now, with what each lacks when the time is there (`assert_time`).
  std::vector<RuleUse> rules_explained() const;

  /// `what`: `f-12`, a pattern (its fact that changed last), or a rule (its last firing). A pattern that no fact
  /// matches now may name a retracted one.
  Expected<Derivation> why(const std::string& what) const;

  static constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();
  /// The record of the rule's last firing, of those before `end`; none if it has not fired.
  std::optional<std::uint64_t> last_firing(const std::string& rule, std::uint64_t end = kAll) const;
  /// The last record that made a fact match the pattern by itself, of those before `end`. Expressions have their
  /// present values; they hold without an evaluator.
  std::optional<std::uint64_t> last_made(const explain::Pattern& pattern, explain::Evaluator* evaluator = nullptr,
                                         std::uint64_t end = kAll) const;

  /// How record `n` came about.
  Derivation why(std::uint64_t n) const;

  /// The change of a fact.
  FactChange change(std::uint64_t n) const;
  FiringCopy firing(std::uint64_t n) const;

 private:
  struct LeftHandSide {
    std::vector<explain::Condition> conditions;
    std::vector<std::vector<const explain::Pattern*>> patterns;  // of each alternative, those that match a fact
  };
  FactHistory history_of(std::int64_t number, std::int64_t index, std::uint64_t end) const;
  /// What a text asks for: all facts, those of a template, those that match a pattern, or one.
  struct Wanted {
    std::string template_name;
    std::optional<explain::Pattern> pattern;
    std::optional<FactCopy> fact;
  };
  Expected<Wanted> wanted_in(const std::string& what) const;
  Error no_template(const std::string& name) const;
  Doer doer_of(std::uint64_t n) const;
  Expected<std::uint64_t> record_of(const std::string& what) const;
  Values values_of(const ConstructInfo& rule, const std::vector<FactCopy>& facts) const;
  const LeftHandSide& left_hand_side(const ConstructInfo& rule) const;
  Error unknown_rule(const std::string& rule) const;

  std::string name_;
  RuleEngine* engine_;
  const Timeline* timeline_;
  FileNames file_names_;
  mutable std::map<std::string, LeftHandSide> left_hand_sides_;  // by text of the rule
  mutable std::map<std::string, std::string> shown_files_;
};

}  // namespace cxlab::inspect
