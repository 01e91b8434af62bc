#include "cx/engine/rule_counts.h"

#include <algorithm>
#include <ctime>
#include <set>

#include "internal/impl.h"
#include "internal/rule_counter.h"

namespace cxlab {

using namespace clips;

namespace {

/// A condition in the join network: its join, the one after it, and those within it.
struct ConditionJoins {
  const joinNode* join = nullptr;
  const joinNode* next = nullptr;
  std::vector<const joinNode*> inside{};
};

const joinNode* right_join(const joinNode& join) { return static_cast<const joinNode*>(join.rightSideEntryStructure); }

void add_inside(const joinNode& group, std::vector<const joinNode*>& inside) {
  for (const joinNode* join = right_join(group); join != nullptr && join != group.lastLevel; join = join->lastLevel) {
    inside.push_back(join);
    if (join->joinFromTheRight) add_inside(*join, inside);
  }
}

std::vector<ConditionJoins> joins_of(const Defrule& disjunct) {
  std::vector<ConditionJoins> joins;
  const joinNode* next = disjunct.lastJoin;
  for (const joinNode* join = next == nullptr ? nullptr : next->lastLevel; join != nullptr; join = join->lastLevel) {
    ConditionJoins& one = joins.emplace_back(ConditionJoins{join, next});
    if (join->joinFromTheRight) add_inside(*join, one.inside);
    next = join;
  }
  std::ranges::reverse(joins);
  return joins;
}

/// The nodes of the pattern network that lead to the pattern of a join, the last one first.
template <class Visit>
void for_each_pattern_node(Environment* env, const joinNode& join, Visit visit) {
  if (join.joinFromTheRight || join.rightSideEntryStructure == nullptr) return;
  if (join.rhsType == 0) return;
  const patternParser* parser = pattern_data(env)->PatternParserArray[join.rhsType - 1];
  if (std::string_view(parser->name) == "facts") {
    const auto* node = static_cast<const factPatternNode*>(join.rightSideEntryStructure);
    for (; node != nullptr; node = node->lastLevel) visit(node);
  } else {
    const auto* alpha = static_cast<const objectAlphaNode*>(join.rightSideEntryStructure);
    for (const OBJECT_PATTERN_NODE* node = alpha->patternNode; node != nullptr; node = node->lastLevel) visit(node);
  }
}

/// The tests that a join evaluates one after the other: an `and` by its arguments. As what CLIPS hands over.
std::vector<const expr*> tests_of(Environment* env, const expr* test) {
  std::vector<const expr*> tests;
  if (test == nullptr) return tests;
  if (test->value == expression_data(env)->PTR_AND) {
    for (const expr* one = test->argList; one != nullptr; one = one->nextArg) tests.push_back(one);
  } else {
    tests.push_back(test->value == expression_data(env)->PTR_OR ? test->argList : test);
  }
  return tests;
}

template <class Visit>
void for_each_rule(Environment* env, Visit visit) {
  Defmodule* current = GetCurrentModule(env);
  for (Defmodule* module = GetNextDefmodule(env, nullptr); module != nullptr; module = GetNextDefmodule(env, module)) {
    SetCurrentModule(env, module);
    for (Defrule* rule = GetNextDefrule(env, nullptr); rule != nullptr; rule = GetNextDefrule(env, rule)) visit(*rule);
  }
  SetCurrentModule(env, current);
}

JoinCounts counts_of_join(const ConditionJoins& joins) {
  const joinNode& join = *joins.join;
  JoinCounts counts;
  counts.passed = joins.next->memoryLeftAdds;
  counts.compared = join.memoryCompares;
  for (const joinNode* inside : joins.inside) counts.compared += inside->memoryCompares;
  counts.held = static_cast<std::int64_t>(joins.next->leftMemory->count);
  counts.initial = !join.joinFromTheRight && join.rightSideEntryStructure == nullptr;
  counts.tests_after = join.patternIsNegated || join.patternIsExists || join.joinFromTheRight;
  return counts;
}

ConstructInfo info_of(const RuleEngine& engine, const char* kind, const std::string& module, const std::string& name) {
  const ConstructInfo* known = engine.find_construct(kind, module + "::" + name);
  if (known != nullptr) return *known;
  return {kind, module, name, {}, 0, {}};
}

ConstructInfo info_of_rule(const RuleEngine& engine, const Defrule& rule) {
  return info_of(engine, "defrule", rule.header.whichModule->theModule->header.name->contents,
                 rule.header.name->contents);
}

std::int64_t clock_ns(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

double seconds_of(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace

/// How many rules stand below each node.
struct RuleCounter::Sharing {
  std::unordered_map<const void*, std::size_t> rules;

  explicit Sharing(Environment* env) {
    for_each_rule(env, [&](Defrule& rule) {
      std::set<const void*> nodes;
      const auto add = [&](const joinNode& join) {
        nodes.insert(&join);
        for_each_pattern_node(env, join, [&](const void* node) { nodes.insert(node); });
      };
      for (const Defrule* disjunct = &rule; disjunct != nullptr; disjunct = disjunct->disjunct)
        for (const ConditionJoins& joins : joins_of(*disjunct)) {
          add(*joins.join);
          for (const joinNode* inside : joins.inside) add(*inside);
        }
      for (const void* node : nodes) ++rules[node];
    });
  }
  std::size_t of(const void* node) const {
    const auto found = rules.find(node);
    return found == rules.end() ? 1 : found->second;
  }
};

RuleCounter::RuleCounter(RuleEngine& engine, Counting what) : engine_(engine) {
  Environment* env = engine.raw();
  agenda_data(env)->ActivationMade = on_activation;
  engine_data(env)->TestReached = on_test;
  engine_data(env)->RuleGoes = on_rule_goes;
  evaluate_function_ = std::exchange(evaluation_data(env)->PrimitivesArray[PCALL]->evaluateFunction, on_function);
  count(what);
}

RuleCounter::~RuleCounter() {
  Environment* env = engine_.raw();
  agenda_data(env)->ActivationMade = nullptr;
  engine_data(env)->TestReached = nullptr;
  engine_data(env)->RuleGoes = nullptr;
  engine_data(env)->WorkBegins = nullptr;
  evaluation_data(env)->PrimitivesArray[PCALL]->evaluateFunction = evaluate_function_;
  for (const Function& function : functions_) {
    ReleaseLexeme(env, function.name);
    ReleaseLexeme(env, function.module);
  }
}

void RuleCounter::count(Counting what) {
  if (what == Counting::kTimes && counting_ != Counting::kTimes) {
    wall_ = clock_ns(CLOCK_MONOTONIC);
    of_thread_ = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    engine_data(engine_.raw())->WorkBegins = on_work;
  }
  counting_ = std::max(counting_, what);
}

// --- What CLIPS calls

void RuleCounter::on_activation(Environment* env, Defrule* rule) noexcept {
  RuleCounter& self = *RuleEngine::of(env)->counter();
  ++entry(self.uses_, rule).activated;
}

void RuleCounter::on_test(Environment* env, joinNode* join, expr* test) noexcept {
  auto& reached = RuleEngine::of(env)->counter()->reached_[join];
  for (auto& [one, times] : reached)
    if (one == test) {
      ++times;
      return;
    }
  reached.emplace_back(test, 1);
}

void RuleCounter::on_rule_goes(Environment* env, Defrule* rule) noexcept {
  RuleCounter& self = *RuleEngine::of(env)->counter();
  if (rule->lastJoin == nullptr) return;
  const Sharing sharing(env);
  RuleCounts counts = self.counts_of(*rule, sharing);
  if (counts.info.line > 0) self.gone_.push_back(std::move(counts));
  for (const Defrule* disjunct = rule; disjunct != nullptr; disjunct = disjunct->disjunct) {
    self.uses_.erase(disjunct);
    self.work_.erase(disjunct);
    self.work_.erase(disjunct->lastJoin);
    for (const ConditionJoins& joins : joins_of(*disjunct)) {
      if (sharing.of(joins.join) > 1) continue;
      self.work_.erase(joins.join);
      self.reached_.erase(joins.join);
      for (const joinNode* inside : joins.inside) self.work_.erase(inside);
    }
  }
  for (Span& span : self.spans_)
    if (span.longest != nullptr && self.work_.find(span.longest) == nullptr) span.longest = nullptr;
}

std::size_t RuleCounter::place_of(const Deffunction& function) {
  CLIPSLexeme* name = function.header.name;
  CLIPSLexeme* module = function.header.whichModule->theModule->header.name;
  FunctionPlace& found = entry(function_places_, &function);
  // Another one may take the place of one that has been removed.
  if (found.place < functions_.size() && functions_[found.place].name == name &&
      functions_[found.place].module == module)
    return found.place;
  RetainLexeme(engine_.raw(), name);
  RetainLexeme(engine_.raw(), module);
  found.place = functions_.size();
  functions_.push_back({name, module});
  return found.place;
}

bool RuleCounter::on_function(Environment* env, void* deffunction, UDFValue* result) noexcept {
  RuleCounter& self = *RuleEngine::of(env)->counter();
  const std::size_t place = self.place_of(*static_cast<Deffunction*>(deffunction));
  ++self.functions_[place].calls;
  if (self.counting_ != Counting::kTimes) return self.evaluate_function_(env, deffunction, result);
  const std::int64_t begin = self.charge();
  self.active_.push_back({place, self.at_work_});
  const bool given = self.evaluate_function_(env, deffunction, result);
  const std::int64_t end = self.charge();
  self.active_.pop_back();
  self.add_span(WorkSpan::Kind::kFunction, qualified_name(static_cast<Deffunction*>(deffunction)->header), begin, end);
  return given;
}

void* RuleCounter::on_work(Environment* env, void* node) noexcept {
  RuleCounter& self = *RuleEngine::of(env)->counter();
  const std::int64_t now = self.charge();
  const bool was_matching = self.is_matching();
  const void* before = std::exchange(self.at_work_, node);
  const bool is_matching = self.is_matching();
  if (is_matching && !was_matching) {
    self.matching_since_ = now;
    self.longest_ns_ = 0;
  }
  if (was_matching && !is_matching && seconds_of(now - self.matching_since_) >= kShortestMatching)
    self.add_span(WorkSpan::Kind::kMatching, "matching", self.matching_since_, now, self.longest_);
  return const_cast<void*>(before);
}

void RuleCounter::fires(const Defrule& rule) {
  ++entry(uses_, &rule).fired;
  if (counting_ != Counting::kTimes) return;
  const std::int64_t now = charge();
  firing_.push_back({std::exchange(at_work_, &rule), &rule, now});
}

void RuleCounter::has_fired() {
  if (counting_ != Counting::kTimes || firing_.empty()) return;
  const std::int64_t now = charge();
  const Begun& begun = firing_.back();
  add_span(WorkSpan::Kind::kFiring, qualified_name(begun.rule->header), begun.ns, now);
  at_work_ = begun.node;
  firing_.pop_back();
}

/// The clock of the thread costs ten times as much as that of the machine. It is read only after a step in which the
/// thread may have waited for its turn.
std::int64_t RuleCounter::worked() {
  constexpr std::int64_t kMayHaveWaited = 20'000;  // ns
  const std::int64_t wall = clock_ns(CLOCK_MONOTONIC);
  std::int64_t step = wall - std::exchange(wall_, wall);
  since_then_ += step;
  if (step > kMayHaveWaited) {
    const std::int64_t now = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    const std::int64_t waited = since_then_ - (now - std::exchange(of_thread_, now));
    step = std::clamp<std::int64_t>(step - waited, 0, step);
    since_then_ = 0;
  }
  return worked_ += step;
}

bool RuleCounter::is_matching() const {
  return at_work_ != nullptr && (firing_.empty() || at_work_ != firing_.back().rule);
}

std::int64_t RuleCounter::charge() {
  const std::int64_t now = worked(), ns = now - last_;
  Work& work = at_work_ == nullptr ? elsewhere_ : entry(work_, at_work_);
  work.ns += ns;
  ++work.reads;
  if (!active_.empty() && active_.back().node == at_work_) {
    functions_[active_.back().function].ns += ns;
    ++functions_[active_.back().function].reads;
  }
  if (is_matching() && ns > longest_ns_) {
    longest_ = at_work_;
    longest_ns_ = ns;
  }
  ++reads_;
  last_ = now;
  return now;
}

void RuleCounter::add_span(WorkSpan::Kind kind, std::string name, std::int64_t begin, std::int64_t end,
                           const void* longest) {
  if (spans_.size() >= kMostSpans) {
    ++spans_left_out_;
    return;
  }
  spans_.push_back({{kind, std::move(name), seconds_of(begin), seconds_of(end), engine_.now()}, longest});
}

// --- Counts

WorkTime RuleCounter::work_of(const void* node) const {
  const Work* work = work_.find(node);
  return work == nullptr ? WorkTime() : WorkTime{seconds_of(work->ns), static_cast<double>(work->reads)};
}

RuleCounts RuleCounter::counts_of(const Defrule& rule, const Sharing& sharing) const {
  Environment* env = engine_.raw();
  RuleCounts counts;
  counts.info = info_of_rule(engine_, rule);
  const auto add_time = [&](const joinNode& join, WorkTime& time) {
    time += work_of(&join) / static_cast<double>(sharing.of(&join));
    for_each_pattern_node(env, join,
                          [&](const void* node) { time += work_of(node) / static_cast<double>(sharing.of(node)); });
  };
  for (const Defrule* disjunct = &rule; disjunct != nullptr; disjunct = disjunct->disjunct) {
    if (const Use* use = uses_.find(disjunct)) {
      counts.activated += use->activated;
      counts.fired += use->fired;
    }
    counts.acting += work_of(disjunct);
    counts.activating += work_of(disjunct->lastJoin);
    std::vector<JoinCounts>& list = counts.disjuncts.emplace_back();
    for (const ConditionJoins& joins : joins_of(*disjunct)) {
      JoinCounts& join = list.emplace_back(counts_of_join(joins));
      join.sharers = sharing.of(joins.join);
      const auto reached = reached_.find(joins.join);
      for (const expr* test :
           tests_of(env, join.tests_after ? joins.join->secondaryNetworkTest : joins.join->networkTest)) {
        std::int64_t times = 0;
        if (reached != reached_.end())
          for (const auto& [one, count] : reached->second)
            if (one == test) times = count;
        join.reached.push_back(times);
      }
      add_time(*joins.join, join.time);
      for (const joinNode* inside : joins.inside) add_time(*inside, join.time);
    }
  }
  return counts;
}

EngineCounts RuleCounter::counts() const {
  EngineCounts counts;
  counts.counting = counting_;
  counts.rules = gone_;
  const Sharing sharing(engine_.raw());
  std::vector<const Defrule*> rules;
  for_each_rule(engine_.raw(), [&](Defrule& rule) {
    rules.push_back(&rule);
    counts.rules.push_back(counts_of(rule, sharing));
  });
  std::set<std::string> called;
  for (const Function& function : functions_) {
    FunctionCounts& one = counts.functions.emplace_back();
    one.info = info_of(engine_, "deffunction", function.module->contents, function.name->contents);
    one.calls = function.calls;
    one.time = {seconds_of(function.ns), static_cast<double>(function.reads)};
    called.insert(one.info.module + "::" + one.info.name);
  }
  for (const ConstructInfo& info : engine_.constructs())
    if (info.kind == "deffunction" && called.insert(info.module + "::" + info.name).second)
      counts.functions.emplace_back().info = info;
  counts.elsewhere = {seconds_of(elsewhere_.ns), static_cast<double>(elsewhere_.reads)};
  counts.clock_reads = static_cast<double>(reads_);
  std::unordered_map<const void*, WorkSpan::Place> places;
  for (std::size_t rule = gone_.size(); const Defrule* first : rules) {
    std::size_t disjunct = 0;
    for (const Defrule* one = first; one != nullptr; one = one->disjunct, ++disjunct) {
      std::size_t join = 0;
      const auto add = [&](const void* node) { places.try_emplace(node, WorkSpan::Place{rule, disjunct, join}); };
      for (const ConditionJoins& joins : joins_of(*one)) {
        add(joins.join);
        for (const joinNode* inside : joins.inside) add(inside);
        for_each_pattern_node(engine_.raw(), *joins.join, add);
        ++join;
      }
      add(one->lastJoin);
    }
    ++rule;
  }
  for (const Span& span : spans_) {
    counts.spans.push_back(span.span);
    if (const auto place = places.find(span.longest); place != places.end())
      counts.spans.back().longest = place->second;
  }
  counts.spans_left_out = spans_left_out_;
  return counts;
}

// --- The engine

RuleCounter* RuleEngine::counter() const { return impl_->counter.get(); }

void RuleEngine::count(Counting what) {
  if (what == Counting::kNothing) return;
  if (impl_->counter == nullptr)
    impl_->counter = std::make_unique<RuleCounter>(*this, what);
  else
    impl_->counter->count(what);
}

EngineCounts RuleEngine::counts() const {
  return impl_->counter == nullptr ? EngineCounts() : impl_->counter->counts();
}

std::map<std::string, std::int64_t> RuleEngine::activations() const {
  std::map<std::string, std::int64_t> activations;
  for (const RuleCounts& rule : counts().rules)
    if (rule.activated > 0) activations[rule.info.module + "::" + rule.info.name] += rule.activated;
  return activations;
}

}  // namespace cxlab
