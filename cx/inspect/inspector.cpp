#include "cx/inspect/inspector.h"

#include <algorithm>
#include <map>
#include <set>

#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/engine/template_names.h"
#include "cx/explain/fact_record.h"
#include "cx/explain/left_hand_side.h"
#include "cx/explain/matcher.h"
#include "cx/explain/names.h"
#include "cx/journal/journal_reader.h"

namespace cxlab::inspect {

namespace {

/// Whether `wanted`, with or without a module, stands for the rule of that name.
bool names(std::string_view wanted, std::string_view rule) {
  if (wanted.starts_with("MAIN::")) return rule == without_module(wanted);
  return wanted == rule || (without_module(wanted).size() == wanted.size() && without_module(rule) == wanted);
}

/// The number in "f-12".
std::optional<std::int64_t> index_in(const std::string& what) {
  if (!what.starts_with("f-")) return std::nullopt;
  return read_number<std::int64_t>(what.substr(2));
}

bool is_by_story(const JournalRecord& act) {
  return act.data.text("name") == kActOfStory && act.data.text("what") != "set";
}

/// The text that was evaluated, a file that was loaded, `NAME = VALUE` of what was set.
std::string text_of_act(const JournalRecord& act) {
  const std::string name(act.data.text("name"));
  if (name.empty() || is_by_story(act)) return std::string(act.data.text("text"));
  return act.data.text("what") == "set" ? name + " = " + std::string(act.data.text("text")) : name;
}

bool is_by_program(const JournalRecord& act) { return !act.data.text("by").empty(); }

bool is_template(const RuleEngine& engine, const std::string& name) {
  return engine.has("deftemplate", name) || !engine.facts(name).empty();
}

}  // namespace

std::string Doer::text() const {
  switch (kind) {
    case Kind::kRule: return "rule " + name;
    case Kind::kInput: return name;
    case Kind::kPerson: return "a person: " + name;
    case Kind::kWhatIf: return "what if: " + name;
    case Kind::kStory: return "the story: " + name;
    case Kind::kProgram: return "the program: " + name;
    case Kind::kStart: return "the start of the environment";
    case Kind::kOutside: break;
  }
  return "the executive or a plugin";
}

// --- Who did it

Doer Inspector::doer_of(std::uint64_t n) const {
  for (const Timeline::Cause& cause : timeline_->causes(n)) {
    if (cause.stream || !timeline_->has(cause.n)) continue;
    switch (timeline_->kind(cause.n)) {
      case RecordKind::kFire: return {Doer::Kind::kRule, timeline_->name(cause.n), cause.n};
      case RecordKind::kInput: {
        const JournalRecord input = timeline_->read(cause.n);
        return {Doer::Kind::kInput, std::string(input.data.text("what")) + ' ' + std::string(input.data.text("name")),
                cause.n};
      }
      case RecordKind::kControl: {
        const JournalRecord act = timeline_->read(cause.n);
        if (is_by_program(act))
          return {Doer::Kind::kProgram, std::string(act.data.text("what")) + ' ' + text_of_act(act), cause.n};
        return {is_by_story(act)  ? Doer::Kind::kStory
                : is_planned(act) ? Doer::Kind::kWhatIf
                                  : Doer::Kind::kPerson,
                text_of_act(act), cause.n};
      }
      default: break;
    }
  }
  return {timeline_->is_of_start(n) ? Doer::Kind::kStart : Doer::Kind::kOutside, {}, std::nullopt};
}

FactChange Inspector::change(std::uint64_t n) const {
  RecordKind kind = timeline_->kind(n);
  if (kind == RecordKind::kDecision) kind = RecordKind::kAssert;
  return {n, timeline_->time(n), kind, doer_of(n), timeline_->fact_after(n)};
}

// --- Facts

FactHistory Inspector::history_of(std::int64_t number, std::int64_t index, std::uint64_t end) const {
  FactHistory history;
  for (const std::uint64_t n : timeline_->changes(number))
    if (n < end) history.changes.push_back(change(n));
  history.fact = history.changes.back().after;
  history.fact.index = index;
  history.present = history.changes.back().kind != RecordKind::kRetract;
  return history;
}

Error Inspector::no_template(const std::string& name) const {
  if (name.find_first_of(" ()") != name.npos)
    return input_error(found_text(name, "a template, or a pattern in parentheses: '(order (id 3))'"));
  return input_error("there is no template '" + name + "'" + did_you_mean(name, template_names(*engine_)));
}

Expected<Inspector::Wanted> Inspector::wanted_in(const std::string& what) const {
  Wanted wanted;
  if (const auto index = index_in(what)) {
    auto fact = engine_->fact(*index);
    if (!fact)
      return input_error("there is no fact " + what +
                         " when that tick is over; a pattern, as '(order (id 3))', also finds retracted facts");
    wanted.template_name = fact->template_name;
    wanted.fact = *std::move(fact);
  } else if (!what.empty() && what.front() == '(') {
    auto pattern = explain::Pattern::parse_plain(what, {}, 0);
    if (!pattern) return pattern.error();
    if (Status s = explain::check_names(*pattern, *engine_); !s) return s.error();
    wanted.template_name = pattern->template_name();
    wanted.pattern = *std::move(pattern);
  } else {
    wanted.template_name = what;
  }
  return wanted;
}

Expected<std::vector<FactCopy>> Inspector::present(const std::string& what) const {
  auto wanted = wanted_in(what);
  if (!wanted) return wanted.error();
  if (wanted->fact) return std::vector{*std::move(wanted->fact)};
  std::vector<FactCopy> found = engine_->facts(wanted->template_name);
  if (!what.empty() && found.empty() && !is_template(*engine_, wanted->template_name))
    return no_template(wanted->template_name);
  if (!wanted->pattern) return found;
  std::erase_if(found, [&](const FactCopy& fact) { return !wanted->pattern->matches(fact); });
  if (found.empty())
    if (Status s = explain::check_values(*wanted->pattern, *engine_, engine_->facts()); !s) return s.error();
  return found;
}

std::vector<std::string> Inspector::slot_names(const std::string& what) const {
  const auto wanted = wanted_in(what);
  return wanted ? engine_->slot_names(wanted->template_name) : std::vector<std::string>();
}

Expected<std::vector<FactHistory>> Inspector::facts(const std::string& what) const {
  const auto found = present(what);
  if (!found) return found.error();
  std::vector<FactHistory> histories;
  for (const FactCopy& fact : *found)
    if (const auto number = static_cast<std::int64_t>(fact.number); !timeline_->changes(number).empty())
      histories.push_back(history_of(number, fact.index, timeline_->end()));
  // A fact's number counts it.
  std::ranges::sort(histories, {}, [](const FactHistory& history) { return history.fact.number; });
  return histories;
}

Expected<std::vector<FactHistory>> Inspector::facts(const std::string& what, SimTime from, SimTime to) const {
  const auto wanted = wanted_in(what);
  if (!wanted) return wanted.error();
  const std::string& name = wanted->template_name;
  const std::uint64_t begin = timeline_->end_of(from - SimTime(1)), end = timeline_->end_of(to);
  const std::vector<FactCopy> present = engine_->facts();
  std::map<std::int64_t, std::int64_t> indices;  // by number
  for (const FactCopy& fact : present) indices[static_cast<std::int64_t>(fact.number)] = fact.index;
  bool template_is_known = name.empty() || is_template(*engine_, name);
  std::set<std::int64_t> numbers;
  for (std::uint64_t n = timeline_->begin(); n < end; ++n)
    if (const std::int64_t fact = timeline_->fact(n); fact > 0 && (name.empty() || timeline_->name(n) == name)) {
      template_is_known = true;
      if (!wanted->fact || fact == static_cast<std::int64_t>(wanted->fact->number)) numbers.insert(fact);
    }
  if (!template_is_known) return no_template(name);
  std::vector<FactHistory> found;
  for (const std::int64_t fact : numbers) {
    const auto index = indices.find(fact);
    FactHistory history = history_of(fact, index == indices.end() ? 0 : index->second, end);
    if (!history.present && history.changes.back().n < begin) continue;
    const auto matches = [&](const FactChange& change) { return wanted->pattern->matches(change.after); };
    if (!wanted->pattern || std::ranges::any_of(history.changes, matches)) found.push_back(std::move(history));
  }
  if (wanted->pattern && found.empty())
    if (Status s = explain::check_values(*wanted->pattern, *engine_, present); !s) return s.error();
  return found;
}

bool Inspector::assert_time() const {
  const auto was_there = [&] {
    for (std::uint64_t n = timeline_->begin(); n < timeline_->end(); ++n)
      if (timeline_->fact(n) > 0 && timeline_->name(n) == "time") return true;
    return false;
  };
  if (!engine_->find_construct("defrule", "time-retract") || !engine_->facts("time").empty() || !was_there())
    return false;
  const Value time = Value::number(to_seconds(engine_->now()));
  if (!engine_->assert_ordered("time", {&time, 1})) return false;
  engine_->refresh_all_agendas();
  return true;
}

// --- Rules

Error Inspector::unknown_rule(const std::string& rule) const {
  return input_error("there is no rule '" + rule + "'" + did_you_mean(rule, explain::names_of(*engine_, "defrule")));
}

const std::string& Inspector::shown_file(const std::string& file) const {
  const auto [known, fresh] = shown_files_.try_emplace(file);
  if (fresh) known->second = file_names_(file);
  return known->second;
}

FiringCopy Inspector::firing(std::uint64_t n) const {
  FiringCopy firing;
  firing.n = n;
  firing.t = timeline_->time(n);
  firing.rule = timeline_->name(n);
  for (const std::int64_t fact : explain::facts_of_firing(timeline_->read(n).data)) {
    if (fact < 0) continue;
    std::optional<std::uint64_t> last;
    for (const std::uint64_t change : timeline_->changes(fact))
      if (change < n) last = change;
    if (last) firing.facts.push_back(timeline_->fact_after(*last));
  }
  if (const ConstructInfo* info = engine_->find_construct("defrule", firing.rule)) {
    firing.file = shown_file(info->file);
    firing.line = info->line;
    firing.values = values_of(*info, firing.facts);
  }
  return firing;
}

const Inspector::LeftHandSide& Inspector::left_hand_side(const ConstructInfo& rule) const {
  const auto [known, fresh] = left_hand_sides_.try_emplace(rule.text);
  LeftHandSide& side = known->second;
  if (!fresh) return side;
  auto conditions = explain::conditions_of(rule.text, rule.file, rule.line);
  if (!conditions) return side;
  side.conditions = *std::move(conditions);
  for (const explain::Alternative& alternative : explain::alternatives_of(side.conditions)) {
    auto& patterns = side.patterns.emplace_back();
    for (const explain::Condition* condition : alternative.conditions)
      if (condition->kind == explain::Condition::Kind::kPattern && !condition->pattern.is_object())
        patterns.push_back(&condition->pattern);
  }
  return side;
}

Values Inspector::values_of(const ConstructInfo& rule, const std::vector<FactCopy>& facts) const {
  Values values;
  for (const auto& patterns : left_hand_side(rule).patterns) {
    if (patterns.size() != facts.size()) continue;
    explain::Bindings bindings;
    const std::function<bool(std::size_t)> match = [&](std::size_t i) {
      if (i < patterns.size())
        return patterns[i]->template_name() == facts[i].template_name &&
               patterns[i]->match(facts[i], bindings, nullptr, [&] { return match(i + 1); });
      for (const auto& [name, value] : bindings) values.emplace_back(name, value.print());
      return true;
    };
    if (match(0)) break;
  }
  return values;
}

std::optional<std::uint64_t> Inspector::last_firing(const std::string& rule, std::uint64_t end) const {
  const auto& all = timeline_->firings();
  const auto last = std::find_if(all.rbegin(), all.rend(),
                                 [&](std::uint64_t n) { return n < end && names(rule, timeline_->name(n)); });
  return last == all.rend() ? std::nullopt : std::optional(*last);
}

std::optional<std::uint64_t> Inspector::last_made(const explain::Pattern& pattern, explain::Evaluator* evaluator,
                                                  std::uint64_t end) const {
  for (std::uint64_t n = std::min(timeline_->end(), end); n-- > timeline_->begin();) {
    const std::int64_t fact = timeline_->fact(n);
    if (fact == 0 || timeline_->kind(n) == RecordKind::kRetract || timeline_->name(n) != pattern.template_name() ||
        !pattern.matches(timeline_->fact_after(n), evaluator))
      continue;
    const auto changes = timeline_->changes(fact);
    const auto at = std::ranges::lower_bound(changes, n);
    if (at == changes.begin() || !pattern.matches(timeline_->fact_after(*(at - 1)), evaluator)) return n;
  }
  return std::nullopt;
}

Expected<std::vector<FiringCopy>> Inspector::firings(const std::string& rule, SimTime from, SimTime to) const {
  std::vector<FiringCopy> found;
  bool known = rule.empty() || engine_->has("defrule", rule);
  for (const std::uint64_t n : timeline_->firings()) {
    if (!rule.empty() && !names(rule, timeline_->name(n))) continue;
    known = true;
    if (timeline_->time(n) >= from && timeline_->time(n) <= to) found.push_back(firing(n));
  }
  if (!known) return unknown_rule(rule);
  return found;
}

std::vector<RuleUse> Inspector::rules(bool explain) const {
  struct Count {
    std::int64_t fired = 0;
    SimTime first{}, last{};
  };
  std::map<std::string, Count> counts;
  for (const std::uint64_t n : timeline_->firings()) {
    Count& count = counts[timeline_->name(n)];
    if (count.fired++ == 0) count.first = timeline_->time(n);
    count.last = timeline_->time(n);
  }
  const auto activations = engine_->activations();
  std::vector<RuleUse> uses;
  std::set<std::string> seen;
  const auto add = [&](const std::string& name, const std::string& module, const ConstructInfo* info) {
    if (!seen.insert(name).second) return;
    RuleUse use;
    use.rule = name;
    if (info) {
      use.file = shown_file(info->file);
      use.line = info->line;
    }
    if (const auto count = counts.find(name); count != counts.end()) {
      use.fired = count->second.fired;
      use.first = count->second.first;
      use.last = count->second.last;
    }
    const auto activated = activations.find(module + "::" + std::string(without_module(name)));
    if (!activations.empty()) use.activated = activated == activations.end() ? 0 : activated->second;
    if (explain && info && use.fired == 0 && use.activated.value_or(0) == 0 && engine_->acting_call(*info).empty())
      use.unmet = explain::unmet_condition(*engine_, *info);
    uses.push_back(std::move(use));
  };
  // A copy: to look for what a rule lacks defines functions for a while.
  for (const ConstructInfo& info : engine_->constructs())
    if (info.kind == "defrule" && engine_->has("defrule", info.module + "::" + info.name))
      add(explain::with_module(info.module, info.name), info.module, &info);
  // Rules that fired and were removed since.
  for (const auto& [name, count] : counts) {
    const std::size_t mark = name.find("::");
    add(name, mark == name.npos ? "MAIN" : name.substr(0, mark), nullptr);
  }
  return uses;
}

std::vector<RuleUse> Inspector::rules_explained() const {
  std::vector<RuleUse> uses = rules(false);
  assert_time();  // after what was counted
  const std::vector<RuleUse> explained = rules(true);
  for (std::size_t i = 0; i < uses.size(); ++i) uses[i].unmet = explained[i].unmet;
  return uses;
}

// --- Why

Expected<std::uint64_t> Inspector::record_of(const std::string& what) const {
  const bool is_fact = index_in(what) || what.starts_with('(');
  if (!is_fact) {
    if (const auto fired = last_firing(what)) return *fired;
    if (engine_->has("defrule", what))
      return negative("rule '" + what + "' has not fired up to then; why-not says what it lacks");
    if (!is_template(*engine_, what))
      return input_error("there is neither a rule nor a template '" + what + "'" + [&] {
        std::vector<std::string> known = explain::names_of(*engine_, "defrule");
        for (std::string& name : explain::names_of(*engine_, "deftemplate")) known.push_back(std::move(name));
        return did_you_mean(what, known);
      }());
  }
  auto found = facts(what);
  if (!found) return found.error();
  std::optional<std::uint64_t> last;
  for (const FactHistory& history : *found) last = std::max(last.value_or(0), history.changes.back().n);
  if (last) return *last;
  // A retracted fact: the last change after which it matched.
  auto gone = facts(what, SimTime::min() + SimTime(1), SimTime::max());
  if (!gone) return gone.error();
  for (const FactHistory& history : *gone)
    for (const FactChange& change : history.changes) {
      if (!what.starts_with('(') || explain::Pattern::parse_plain(what, {}, 0)->matches(change.after))
        last = std::max(last.value_or(0), change.n);
    }
  if (!last) return negative("no fact matches " + what + " up to then");
  return *last;
}

Expected<Derivation> Inspector::why(const std::string& what) const {
  const auto begun = record_of(what);
  if (!begun) return begun.error();
  return why(*begun);
}

Derivation Inspector::why(std::uint64_t record) const {
  std::map<std::int64_t, std::int64_t> indices;
  for (const FactCopy& fact : engine_->facts()) indices[static_cast<std::int64_t>(fact.number)] = fact.index;

  Derivation derivation;
  std::map<std::uint64_t, std::size_t> known;  // by record
  const auto step_of = [&](std::uint64_t n) {
    const auto [at, fresh] = known.emplace(n, derivation.steps.size());
    if (fresh) derivation.steps.emplace_back().n = n;
    return at->second;
  };
  step_of(record);
  for (std::size_t i = 0; i < derivation.steps.size(); ++i) {
    const std::uint64_t n = derivation.steps[i].n;
    std::vector<std::uint64_t> own;
    Derivation::Step step;
    step.n = n;
    step.t = timeline_->time(n);
    step.kind = timeline_->kind(n);
    for (const Timeline::Cause& cause : timeline_->causes(n)) {
      if (cause.stream)
        step.outside = *cause.stream + ':' + std::to_string(cause.n);
      else if (timeline_->has(cause.n))
        own.push_back(cause.n);
    }
    if (const std::int64_t fact = timeline_->fact(n); fact > 0) {
      step.text = timeline_->fact_after(n).print();
      const auto index = indices.find(fact);
      // Only what it is now: an older version of the fact has no index of its own.
      if (index != indices.end() && timeline_->changes(fact).back() == n) step.index = index->second;
      if (own.empty() && !step.outside) step.note = doer_of(n).text();
      if (const std::uint64_t first = timeline_->changes(fact).front(); i == 0 && first != n)
        if (FactChange made = change(first); made.by.kind != Doer::Kind::kStart) step.asserted = std::move(made);
    } else if (step.kind == RecordKind::kFire) {
      FiringCopy fired = firing(n);
      step.text = fired.rule;
      step.values = std::move(fired.values);
      step.file = std::move(fired.file);
      step.line = fired.line;
      if (own.empty()) step.note = "its conditions need no fact";
    } else {
      const JournalRecord cause = timeline_->read(n);
      step.planned = is_planned(cause);
      step.by_story = is_by_story(cause);
      step.by_program = is_by_program(cause);
      step.text = step.kind == RecordKind::kControl ? text_of_act(cause)
                  : step.kind == RecordKind::kError
                      ? std::string(cause.data.text("message"))
                      : std::string(cause.data.text("what")) + ' ' + std::string(cause.data.text("name"));
    }
    std::ranges::sort(own, std::greater());
    own.erase(std::ranges::unique(own).begin(), own.end());
    for (const std::uint64_t cause : own) step.because.push_back(step_of(cause));
    derivation.steps[i] = std::move(step);
  }
  return derivation;
}

}  // namespace cxlab::inspect
