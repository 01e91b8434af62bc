// Ends rules that would not end by themselves, and explains why they would not.

#include <algorithm>
#include <string>
#include <utility>

#include "internal/impl.h"

namespace cxlab {

using namespace clips;

namespace {

// All of these count what rules do; none of them looks at a clock.

/// What a firing adds to the work of a tick, in steps, and how many bytes that are held are a step.
constexpr std::uint64_t kStepsOfAFiring = 100, kBytesHeldOfAStep = 8;
/// A tick with less work is left alone, whatever its rules do.
constexpr std::uint64_t kLeastWork = 16'000'000;
/// One firing, or one call of the host, may take that many steps; where no loop turns, some more for each fact that it
/// changes: a file of facts may be long.
constexpr std::uint64_t kMostOfAnAct = 16'000'000, kStepsOfAChange = 1000;
/// A loop in its actions can say where it is, so it has some steps less.
constexpr std::uint64_t kForALoop = 1'000'000;
/// With `--steps` both grow: they are parts of it.
constexpr std::uint64_t kLeastWorkOf = 32, kMostOfAnActOf = 32;

/// How often rules have taken turns when that is a loop: with facts that differ in numbers only, or with any.
constexpr std::size_t kAlike = 100, kAny = 1000;
/// The same where something else has already ended the rules.
constexpr std::size_t kAlikeAtEnd = 10, kAnyAtEnd = 50;
/// The facts of the first firings of a tick are not looked at.
constexpr std::size_t kFirstLookedAt = 64;
/// A loop is watched for so many firings or so much work, to see which facts keep changing.
constexpr std::size_t kWatched = 200;
constexpr std::uint64_t kWatchedWork = 2'000'000, kWorkBetweenLooks = 500'000;

/// A number that is equal for values that differ in nothing but numbers.
class Likeness {
 public:
  void add(std::string_view text) {
    for (const char c : text.substr(0, kLongest))
      if (c < '0' || c > '9') add_byte(static_cast<unsigned char>(c));
    add_byte(0);
  }
  void add(const CLIPSValue& value) {
    switch (value.header->type) {
      case SYMBOL_TYPE:
      case STRING_TYPE:
      case INSTANCE_NAME_TYPE: return add(value.lexemeValue->contents);
      case MULTIFIELD_TYPE:
        for (std::size_t i = 0; i < std::min(value.multifieldValue->length, kMostFields); ++i)
          add(value.multifieldValue->contents[i]);
        return;
      default: return add_byte(1);
    }
  }
  void add(const PatternEntity& item) {
    if (item.header.type != FACT_ADDRESS_TYPE) {
      const auto& instance = reinterpret_cast<const Instance&>(item);
      add(instance.cls->header.name->contents);
      return add(instance.name->contents);
    }
    const auto& fact = reinterpret_cast<const Fact&>(item);
    add(fact.whichDeftemplate->header.name->contents);
    for (std::size_t i = 0; i < fact.theProposition.length; ++i) add(fact.theProposition.contents[i]);
  }
  void add_byte(unsigned char byte) { hash_ = (hash_ ^ byte) * 0x100000001b3; }
  std::uint64_t number() const { return hash_ == 0 ? 1 : hash_; }

 private:
  static constexpr std::size_t kLongest = 64, kMostFields = 4;
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

std::uint64_t most_of_an_act(const LimitsInUse& limits, std::uint64_t changes) {
  return std::max(kMostOfAnAct, static_cast<std::uint64_t>(limits.steps) / kMostOfAnActOf) + kStepsOfAChange * changes;
}

std::string with_place(std::string text, const std::string& file, int line) {
  if (!file.empty()) text += ", " + file + ':' + std::to_string(line);
  return text + ')';
}

std::string list_of(const std::vector<LoopReport::Count>& counts) {
  std::string text;
  for (const LoopReport::Count& c : counts)
    text += (text.empty() ? "" : ", ") + with_place(c.name + " (" + std::to_string(c.count) + " x", c.file, c.line);
  return text.empty() ? "none" : text;
}

std::vector<LoopReport::Count> most_frequent(const std::map<std::string, std::int64_t>& counts) {
  std::vector<LoopReport::Count> sorted;
  for (const auto& [name, count] : counts) sorted.push_back({name, count, {}, 0});
  std::ranges::stable_sort(sorted, std::ranges::greater(), &LoopReport::Count::count);
  return sorted;
}

void add_place(const RuleEngine& engine, LoopReport::Count& rule) {
  const ConstructInfo* info = engine.find_construct("defrule", rule.name);
  if (info == nullptr) return;
  rule.file = info->file;
  rule.line = info->line;
}

}  // namespace

std::string LoopReport::text() const {
  return "rules still fire after " + std::to_string(fired) + " firings; most frequent at the end: " + list_of(rules) +
         "; facts that keep changing: " + list_of(templates);
}

// --- Firings

void RuleEngine::Impl::count_firings(std::int64_t most) {
  limit = most;
  fired = 0;
  limit_reached = false;
  rule_halted = false;
  if (round) return;
  if (!fired_rules.empty()) fired_rules.clear();
  if (!changed_templates.empty()) changed_templates.clear();
}

std::uint64_t RuleEngine::Impl::work() const {
  return evaluation_data(env)->Steps + steps_of_memory(tick_memory) + kStepsOfAFiring * chain.size();
}

std::uint64_t RuleEngine::Impl::steps_of_memory(std::int64_t before) const {
  const std::int64_t more = memory_data(env)->MemoryAmount - before;
  return more <= 0 ? 0 : static_cast<std::uint64_t>(more) / kBytesHeldOfAStep;
}

std::uint64_t RuleEngine::Impl::act_work() const {
  return evaluation_data(env)->Steps - act_began + steps_of_memory(act_memory);
}

FiringChain::Rule RuleEngine::Impl::number_of(const ConstructHeader& rule) {
  CLIPSLexeme* module = rule.whichModule->theModule->header.name;
  const auto [known, fresh] =
      rule_numbers.try_emplace({rule.name, module}, static_cast<FiringChain::Rule>(numbered_rules.size()));
  if (fresh) {
    RetainLexeme(env, rule.name);
    RetainLexeme(env, module);
    numbered_rules.push_back(qualified_name(rule));
  }
  return known->second;
}

void RuleEngine::Impl::note_firing(const Activation& activation) {
  begin_act();
  rule_number = number_of(activation.theRule->header);
  std::uint64_t facts = 0;
  if (chain.size() >= kFirstLookedAt) {
    Likeness likeness;
    likeness.add_byte(static_cast<unsigned char>(rule_number));
    for (unsigned short i = 0; i < activation.basis->bcount; ++i) {
      const AlphaMatch* match = activation.basis->binds[i].gm.theMatch;
      if (match != nullptr && match->matchingItem != nullptr) likeness.add(*match->matchingItem);
    }
    facts = likeness.number();
  }
  chain.add(rule_number, facts, activation.timetag, agenda_data(env)->CurrentTimetag);
  if (counting()) ++fired_rules[numbered_rules[rule_number]];
  if (work() >= look_for_round_at) look_for_round();
}

void RuleEngine::Impl::note_change(const Fact& fact) {
  ++act_changes;
  if (!counting()) return;
  if (round && (!rule_acting || std::ranges::find(round->rules, rule_number) == round->rules.end())) return;
  ++changed_templates[fact.whichDeftemplate->header.name->contents];
}

/// Where a tick has taken much work: are there rules that take turns? They are watched for a while, which also shows
/// whether they come to an end after all.
void RuleEngine::Impl::look_for_round() {
  const LimitsInUse* limits = engine.options_.limits;
  if (limits == nullptr || limits->steps == 0) return;
  if (!round) {
    round = chain.round(kAlike, kAny);
    look_for_round_at = work() + (round ? 0 : kWorkBetweenLooks);
    round_seen_at = chain.size();
    fired_rules.clear();
    changed_templates.clear();
    return;
  }
  if (chain.size() < round_seen_at + kWatched && work() < look_for_round_at + kWatchedWork) return;
  const auto now = chain.round(kAlike, kAny);
  if (!now || now->turns <= round->turns) {  // it has ended, and other rules go on
    round.reset();
    look_for_round_at = work() + kWorkBetweenLooks;
    return;
  }
  Error error{ErrorKind::kRun, "rules go round in a loop", {}, 0, "rule_loop"};
  if (const ConstructInfo* first = engine.find_construct("defrule", numbered_rules[round->rules.front()])) {
    error.file = first->file;
    error.line = first->line;
  }
  exceed(std::move(error), remedy());
}

std::optional<FiringChain::Round> RuleEngine::Impl::last_round() const {
  return round ? round : chain.round(kAlikeAtEnd, kAnyAtEnd);
}

LoopReport RuleEngine::Impl::loop_report() const {
  LoopReport report;
  report.fired = fired;
  report.rules = most_frequent(fired_rules);
  report.templates = most_frequent(changed_templates);
  for (std::vector<LoopReport::Count>* counts : {&report.rules, &report.templates})
    if (counts->size() > 5) counts->resize(5);
  for (LoopReport::Count& rule : report.rules) add_place(engine, rule);
  return report;
}

// --- Limits

void RuleEngine::Impl::begin_act() {
  act_began = evaluation_data(env)->Steps;
  act_memory = memory_data(env)->MemoryAmount;
  act_changes = 0;
  if (!act_workers.empty()) act_workers.clear();
}

RuleEngine::Impl::Worker RuleEngine::Impl::at_work() const {
  if (std::string tested = rule_under_test(); !tested.empty()) return {true, std::move(tested), true};
  const Context context = contexts.empty() ? Context() : contexts.back();
  if (rule_acting || context.name == kRun || contexts.empty())
    return {false, std::string(rule_module) + "::" + std::string(rule_name), true};
  return {false, std::string(context.name), false};
}

namespace {

RuleEngine::Impl::Worker busiest(const RuleEngine::Impl::Workers& seen) {
  const auto most = std::ranges::max_element(seen, {}, [](const auto& worker) { return worker.second; });
  return most == seen.end() ? RuleEngine::Impl::Worker() : most->first;
}

}  // namespace

/// Names the rule or function that was seen at work most often.
Error RuleEngine::Impl::too_many_steps(std::uint64_t steps, const char* in_what, const Workers& seen) const {
  const Worker worker = seen.empty() ? at_work() : busiest(seen);
  Error error{ErrorKind::kRun, {}, {}, 0, "rule_loop"};
  const ConstructInfo* rule = worker.is_rule ? engine.find_construct("defrule", worker.name) : nullptr;
  if (rule != nullptr) {
    error.file = rule->file;
    error.line = rule->line;
    error.message = "rule " + rule->name + ": ";
  } else if (!contexts.empty()) {
    error.file = contexts.back().file;
    error.line = contexts.back().line;
    if (!worker.name.empty() && !worker.is_rule) error.message = worker.name + ": ";
  }
  if (worker.matches) error.message += "its conditions are tried in many combinations of facts: ";
  error.message += "rules have taken more than " + std::to_string(steps) + " steps in " + in_what;
  return error;
}

void RuleEngine::Impl::look_at_limits() {
  LimitsInUse* limits = engine.options_.limits;
  if (limits == nullptr) return;
  evaluationData& counted = *evaluation_data(env);
  if (!limits->before) limits->before = {Charge::memory(), Charge::disk()};
  Charge::written(counted.Written - std::exchange(counted_written, counted.Written));
  const std::int64_t now = memory_data(env)->MemoryAmount;
  limits->held += now - std::exchange(counted_memory, now);
  const std::int64_t memory = limits->held + Charge::memory() - limits->before->memory;
  const std::int64_t disk = Charge::disk() - limits->before->disk;
  const std::uint64_t steps = counted.Steps, most = static_cast<std::uint64_t>(limits->steps);
  near_limit = most > 0 && steps > most - most / 10;
  const bool is_due = steps >= counted.LookAtStep;
  if (is_due) {
    const Worker worker = at_work();
    ++workers[worker];
    ++act_workers[worker];
  }
  const auto megabytes = [](std::int64_t bytes) { return std::to_string(bytes / 1'000'000) + " MB"; };
  if (limits->exceeded) {
    SetHaltExecution(env, true);
    SetHaltRules(env, true);
  } else if (limits->memory > 0 && memory > limits->memory) {
    engine.exceed_limits(resource_error("rules hold more than " + megabytes(limits->memory) +
                                        " of memory; if they are right, allow more with --memory"));
  } else if (limits->disk > 0 && disk > limits->disk) {
    engine.exceed_limits(resource_error("rules have written more than " + megabytes(limits->disk) +
                                        " to the disk; if they are right, allow more with --disk"));
  } else if (most > 0 && steps > most) {
    exceed(too_many_steps(most, "one tick", workers), remedy());
  } else if (most > 0 && act_work() > most_of_an_act(*limits, act_changes) + kForALoop) {
    exceed(too_many_steps(most_of_an_act(*limits, 0), rule_acting ? "one firing" : "one call", act_workers), remedy());
  } else if (limits->stop != nullptr && limits->stop->load(std::memory_order_relaxed)) {
    engine.exceed_limits(Error{ErrorKind::kRun, "stopped by a signal in the middle of a tick", {}, 0, kStoppedCode});
  }
  look_again_at = taken() + 1'000'000;
  counted.LookAtWritten = 0;
  if (limits->exceeded) {
    counted.LookAtStep = 0;
    return;
  }
  if (is_due || counted.LookAtStep > steps + kStepsBetweenLooks) counted.LookAtStep = steps + kStepsBetweenLooks;
  if (most > 0 && steps < most)
    counted.LookAtStep = std::min(counted.LookAtStep, static_cast<unsigned long long>(most));
  counted.LookAtWritten = counted.Written + 1'000'000;
}

bool RuleEngine::Impl::on_limits(Environment* env) noexcept {
  RuleEngine& engine = *of(env);
  engine.impl_->look_at_limits();
  return engine.options_.limits->exceeded.has_value();
}

void RuleEngine::begin_tick() {
  evaluation_data(environment_)->Steps = 0;
  Impl& impl = *impl_;
  impl.chain.clear();
  impl.round.reset();
  impl.workers.clear();
  impl.begin_act();
  impl.tick_memory = memory_data(environment_)->MemoryAmount;
  const LimitsInUse* limits = options_.limits;
  impl.look_for_round_at =
      std::max(kLeastWork, limits == nullptr ? 0 : static_cast<std::uint64_t>(limits->steps) / kLeastWorkOf);
  impl.look_at_limits();
}

void RuleEngine::exceed_limits(Error error) {
  LimitsInUse* limits = options_.limits;
  if (limits == nullptr || limits->exceeded) return;
  const Impl::Context context = impl_->contexts.empty() ? Impl::Context() : impl_->contexts.back();
  const Impl::Worker worker = impl_->at_work();
  const ConstructInfo* rule = worker.is_rule ? find_construct("defrule", worker.name) : nullptr;
  std::string where = context.name.empty() ? std::string() : std::string(context.name) + ": ";
  error.file = context.file;
  error.line = context.line;
  if (rule != nullptr) {
    where = (impl_->rule_acting || worker.matches ? "rule " : "after rule ") + rule->name + ": ";
    error.file = rule->file;
    error.line = rule->line;
  }
  error.message = where + error.message;
  impl_->exceed(std::move(error));
}

std::string RuleEngine::Impl::remedy() const { return "; if they are right, allow more with --steps"; }

/// With the rules that take turns, if any do.
void RuleEngine::Impl::exceed(Error error, const std::string& remedy) {
  LimitsInUse* limits = engine.options_.limits;
  if (limits == nullptr || limits->exceeded) return;
  if (const auto seen = last_round()) {
    LoopReport report = loop_report();
    report.fired = static_cast<std::int64_t>(chain.size());
    report.rules.clear();
    for (const FiringChain::Rule rule : seen->rules) {
      const auto counted = fired_rules.find(numbered_rules[rule]);
      const bool was_counted = counted != fired_rules.end() && round;
      report.rules.push_back(
          {numbered_rules[rule], was_counted ? counted->second : static_cast<std::int64_t>(seen->turns), {}, 0});
      add_place(engine, report.rules.back());
    }
    error.message += "; " + report.text();
  }
  error.message = "environment '" + engine.name() + "': " + error.message + remedy;
  limits->exceeded = std::move(error);
  SetHaltExecution(env, true);
  SetHaltRules(env, true);
}

void RuleEngine::Impl::on_turn(Environment* env, void* self) noexcept {
  Impl& impl = *static_cast<Impl*>(self);
  impl.glance_at_limits();
  const LimitsInUse* limits = impl.engine.options_.limits;
  ++evaluation_data(env)->Steps;
  const bool too_long = limits != nullptr && limits->steps > 0 && impl.act_work() > most_of_an_act(*limits, 0);
  if (++impl.turns != kMostTurns && !too_long) return;
  if (too_long && busiest(impl.act_workers).matches)  // the loop only asserts what takes so long to match
    return impl.exceed(impl.too_many_steps(most_of_an_act(*limits, 0), "one firing", impl.act_workers), impl.remedy());
  impl.begin_act();
  PrintErrorID(env, "CXLAB", 2, false);
  const std::string text = "Still looping after " + std::to_string(impl.turns) +
                           " turns of loops and deffunctions in one action: stopped.\n";
  WriteString(env, STDERR, text.c_str());
  SetHaltExecution(env, true);
  SetEvaluationError(env, true);
}

bool RuleEngine::Impl::stack_is_full() {
  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  if (calls == 0) calls_begin = here;
  return calls_begin - here > kMostStack;
}

void RuleEngine::Impl::leave_calls(const std::string& function) {
  if (leaving_calls) return;
  PrintErrorID(env, "CXLAB", 2, false);
  const std::string text =
      "Function '" + function +
      "' is called again and again from within itself, until 6 MB of the stack are full: stopped.\n";
  WriteString(env, STDERR, text.c_str());
  SetHaltExecution(env, true);
  SetEvaluationError(env, true);
  leaving_calls = true;
}

bool RuleEngine::Impl::call(EntityEvaluationFunction* evaluate, void* construct, UDFValue* result) {
  if (stack_is_full()) {
    leave_calls(qualified_name(*static_cast<ConstructHeader*>(construct)));
    result->value = FalseSymbol(env);
    return false;
  }
  glance_at_limits();
  ++evaluation_data(env)->Steps;
  ++calls;
  const bool given = evaluate(env, construct, result);
  --calls;
  if (calls == 0) leaving_calls = false;
  return given;
}

bool RuleEngine::Impl::on_deffunction(Environment* env, void* deffunction, UDFValue* result) noexcept {
  Impl& impl = *of(env)->impl_;
  return impl.call(impl.call_deffunction, deffunction, result);
}

bool RuleEngine::Impl::on_generic(Environment* env, void* generic, UDFValue* result) noexcept {
  Impl& impl = *of(env)->impl_;
  return impl.call(impl.call_generic, generic, result);
}

}  // namespace cxlab
