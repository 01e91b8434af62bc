#pragma once
// Counts what rules do: from the joins of CLIPS, which count by themselves, and from what CLIPS calls on the way.

#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "clips_api.h"
#include "cx/base/flat_table.h"
#include "cx/engine/engine.h"

namespace cxlab {

class RuleCounter {
 public:
  RuleCounter(RuleEngine& engine, Counting what);
  ~RuleCounter();
  RuleCounter(const RuleCounter&) = delete;
  RuleCounter& operator=(const RuleCounter&) = delete;

  void count(Counting what);
  void fires(const clips::Defrule& rule);
  void has_fired();
  EngineCounts counts() const;

 private:
  struct Use {
    const void* key = nullptr;  ///< the rule
    std::int64_t activated = 0, fired = 0;
  };
  struct Work {
    const void* key = nullptr;  ///< a node of the pattern or join network, or a rule that acts
    std::int64_t ns = 0, reads = 0;
  };
  struct Function {
    clips::CLIPSLexeme *name = nullptr, *module = nullptr;  ///< retained
    std::int64_t calls = 0, ns = 0, reads = 0;
  };
  struct FunctionPlace {
    const void* key = nullptr;
    std::size_t place = 0;  ///< in `functions_`
  };
  struct Active {
    std::size_t function = 0;
    const void* node = nullptr;  ///< at work when it was called
  };
  struct Begun {
    const void* node = nullptr;  ///< at work before
    const clips::Defrule* rule = nullptr;
    std::int64_t ns = 0;
  };
  struct Span {
    WorkSpan span;
    const void* longest = nullptr;  ///< the node that took longest in it
  };
  struct Sharing;

  static void on_activation(clips::Environment*, clips::Defrule* rule) noexcept;
  static void on_test(clips::Environment*, clips::joinNode* join, clips::expr* test) noexcept;
  static void on_rule_goes(clips::Environment*, clips::Defrule* rule) noexcept;
  static bool on_function(clips::Environment*, void* deffunction, clips::UDFValue* result) noexcept;
  static void* on_work(clips::Environment*, void* node) noexcept;

  template <class Entry>
  static Entry& entry(FlatTable<Entry>& table, const void* key) {
    Entry* found = table.find(key);
    return found == nullptr ? table.insert(key) : *found;
  }
  std::size_t place_of(const clips::Deffunction& function);
  std::int64_t worked();     ///< ns that this thread has been at work
  std::int64_t charge();     ///< the time since the last call to what is at work; gives the time
  bool is_matching() const;  ///< at work is a condition or the agenda
  void add_span(WorkSpan::Kind kind, std::string name, std::int64_t begin, std::int64_t end,
                const void* longest = nullptr);
  WorkTime work_of(const void* node) const;
  RuleCounts counts_of(const clips::Defrule& rule, const Sharing& sharing) const;

  RuleEngine& engine_;
  Counting counting_ = Counting::kNothing;
  clips::EntityEvaluationFunction* evaluate_function_ = nullptr;  ///< before
  FlatTable<Use> uses_;
  std::unordered_map<const clips::joinNode*, std::vector<std::pair<const clips::expr*, std::int64_t>>> reached_;
  std::vector<RuleCounts> gone_;
  FlatTable<FunctionPlace> function_places_;
  std::vector<Function> functions_;

  // With kTimes
  FlatTable<Work> work_;
  Work elsewhere_;
  const void* at_work_ = nullptr;
  std::int64_t last_ = 0, matching_since_ = 0, reads_ = 0;
  std::int64_t wall_ = 0, worked_ = 0;           ///< at the last reading
  std::int64_t of_thread_ = 0, since_then_ = 0;  ///< its own clock when it was read last, and `worked_` since then
  const void* longest_ = nullptr;                ///< since `matching_since_`
  std::int64_t longest_ns_ = 0;
  std::vector<Active> active_;
  std::vector<Begun> firing_;
  std::vector<Span> spans_;
  std::int64_t spans_left_out_ = 0;
};

}  // namespace cxlab
