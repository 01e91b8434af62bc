#include "planner/ground/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "planner/ground/formula.h"
#include "planner/ground/passes.h"
#include "planner/ground/reachable.h"
#include "planner/ground/sorted.h"

namespace cxlab::planner {

namespace {

constexpr std::size_t kMostActions = 1'000'000;  ///< beyond it the problem does not fit into memory
constexpr std::size_t kMostAlternatives = 32;    ///< actions that one is split into, before a derived fact is used
constexpr std::int64_t kActionWork =
    10;  ///< of an action besides its conditions and effects, in pieces of Work::kGround

bool same(const GroundCondition& a, const GroundCondition& b) {
  return a.facts == b.facts && a.comparisons == b.comparisons;
}

class Grounder {
 public:
  Grounder(const Task& task, Reachable reachable, Budget& budget)
      : task_(task), reachable_(std::move(reachable)), budget_(budget) {}

  /// Incomplete if the budget ends.
  GroundTask run() {
    find_absences();
    for (const Assignment& value : task_.problem.values) {
      const int atom = valued_.insert(value.function, value.objects);
      values_.resize(static_cast<std::size_t>(valued_.size()));
      values_[atom] = value.value;
    }
    for (const Binding& binding : reachable_.bindings) {
      add_actions(binding);
      if (budget_.over()) return std::move(out_);
    }
    ById<ObjectId> frame(static_cast<std::size_t>(task_.problem.goal_slots), -1);
    if (std::optional<GroundCondition> goal = conjunction(formula(task_.problem.goal, frame, false)))
      out_.goal = std::move(*goal);
    else
      out_.proved_unsolvable = true;
    for (std::size_t next = 0; next < demanded_.size() && !budget_.over(); ++next) derive(demanded_[next]);
    add_events();
    if (task_.problem.metric) {
      out_.metric = expression(task_.problem.metric->value, frame);
      if (task_.problem.metric->maximize) out_.metric.steps.push_back({GroundExpression::Kind::kNegate, -1, 0});
    }
    mirror_complements();
    if (budget_.late()) return std::move(out_);
    set_initial_state();
    order_axioms();
    out_.derived_reads = find_derived_reads(task_.domain);
    return std::move(out_);
  }

 private:
  /// A fact that is never true can be left out, but not if one action deletes it and another asks for its absence: the
  /// two must not share an instant.
  void find_absences() {
    ById<char> asked(task_.domain.predicates.size(), 0), deleted(asked);
    const auto ask = [&](const TimedCondition& condition) {
      for (const Condition* part : condition.parts())
        for_each_part(*part, [&](const Condition& each, bool negated) {
          if (each.kind == Condition::Kind::kAtom && negated) asked[each.predicate] = 1;
        });
    };
    for (const Action& action : task_.domain.actions) {
      ask(action.condition);
      for (const Effect& effect : action.effects) {
        ask(effect.condition);
        if (effect.kind == Effect::Kind::kDelete) deleted[effect.predicate] = 1;
      }
    }
    for (std::size_t p = 0; p < asked.size(); ++p) absence_matters_.push_back(asked[p] && deleted[p]);
  }

  int fact(PredicateId predicate, std::span<const ObjectId> arguments) {
    const int atom = fact_atoms_.insert(predicate, arguments);
    if (atom == static_cast<int>(fact_ids_.size())) {
      const bool derived = task_.domain.predicates[predicate].derived;
      fact_ids_.push_back(static_cast<int>(out_.facts.size()));
      out_.facts.push_back({predicate, {arguments.begin(), arguments.end()}, -1, false, derived});
      if (derived) demanded_.push_back(fact_ids_.back());
    }
    return fact_ids_[atom];
  }

  int complement(int id) {
    if (out_.facts[id].complement < 0) {
      GroundFact opposite = out_.facts[id];
      opposite.is_complement = true;
      opposite.complement = id;
      out_.facts[id].complement = static_cast<int>(out_.facts.size());
      out_.facts.push_back(std::move(opposite));
    }
    return out_.facts[id].complement;
  }

  int number(FunctionId function, std::span<const ObjectId> arguments) {
    const int id = number_atoms_.insert(function, arguments);
    if (id == static_cast<int>(out_.numbers.size()))
      out_.numbers.push_back({function, {arguments.begin(), arguments.end()}});
    return id;
  }

  double initial_value(FunctionId function, std::span<const ObjectId> arguments) const {
    const int found = valued_.find(function, arguments);
    return found < 0 ? std::numeric_limits<double>::quiet_NaN() : values_[found];
  }

  GroundExpression expression(const Expression& from, const ById<ObjectId>& frame) {
    using Kind = Expression::Kind;
    if (from.kind == Kind::kConstant) return GroundExpression::constant(from.value);
    if (from.kind == Kind::kFunction) {
      const Objects arguments(from.terms, frame);
      const double value = initial_value(from.function, arguments);
      if (!reachable_.changing[from.function] && !std::isnan(value)) return GroundExpression::constant(value);
      return {{{Kind::kFunction, number(from.function, arguments), 0}}};
    }
    GroundExpression out;
    for (std::size_t i = 0; i < from.operands.size(); ++i) {
      const GroundExpression part = expression(from.operands[i], frame);
      out.steps.insert(out.steps.end(), part.steps.begin(), part.steps.end());
      if (i > 0) out.steps.push_back({from.kind, -1, 0});
    }
    if (from.operands.size() < 2) out.steps.push_back({from.kind, -1, 0});  // a negation, or a leaf
    const auto is_constant = [](const GroundExpression::Step& step) {  // zero times an undefined number is undefined
      return step.kind != Kind::kFunction && step.kind != Kind::kDuration && step.kind != Kind::kTotalTime;
    };
    if (std::ranges::all_of(out.steps, is_constant)) return GroundExpression::constant(out.evaluate(nullptr));
    return out;
  }

  Formula comparison(GroundComparison::Kind kind, GroundExpression left, const GroundExpression& right) {
    GroundComparison made = GroundComparison::of(kind, std::move(left), right);
    if (made.linear.is_linear && made.linear.weights.empty() && made.linear.duration_weight == 0)
      return truth(made.holds(nullptr));
    std::string key(1, static_cast<char>(kind));
    made.expression.append_key(key);
    const auto [entry, fresh] = comparison_ids_.try_emplace(std::move(key), static_cast<int>(out_.comparisons.size()));
    if (fresh) out_.comparisons.push_back(std::move(made));
    return {Formula::Kind::kComparison, entry->second, {}};
  }

  Formula compare(const Condition& condition, const ById<ObjectId>& frame, bool negated) {
    using Kind = GroundComparison::Kind;
    GroundExpression left = expression(condition.sides[0], frame), right = expression(condition.sides[1], frame);
    switch (condition.comparison) {
      case Comparison::kLess: std::swap(left, right); [[fallthrough]];
      case Comparison::kGreater:
        return negated ? comparison(Kind::kNotNegative, right, left) : comparison(Kind::kPositive, left, right);
      case Comparison::kLessEqual: std::swap(left, right); [[fallthrough]];
      case Comparison::kGreaterEqual:
        return negated ? comparison(Kind::kPositive, right, left) : comparison(Kind::kNotNegative, left, right);
      case Comparison::kEqual: break;
    }
    if (!negated) return comparison(Kind::kZero, left, right);
    return join(Formula::Kind::kOr,
                {comparison(Kind::kPositive, left, right), comparison(Kind::kPositive, right, left)});
  }

  Formula formula(const Condition& condition, ById<ObjectId>& frame, bool negated) {
    using Kind = Condition::Kind;
    budget_.spend(Work::kGround, 1);
    switch (condition.kind) {
      case Kind::kAtom: {
        const Objects arguments(condition.terms, frame);
        if (!task_.domain.predicates[condition.predicate].derived) {
          const bool can_be_true = reachable_.atoms.find(condition.predicate, arguments) >= 0;
          if (!can_be_true && !(negated && absence_matters_[condition.predicate])) return truth(negated);
          if (!reachable_.fluent[condition.predicate]) return truth(!negated);
        }
        const int id = fact(condition.predicate, arguments);
        return {Formula::Kind::kFact, negated ? complement(id) : id, {}};
      }
      case Kind::kSame: {
        const Objects pair(condition.terms, frame);
        return truth((pair.begin()[0] == pair.begin()[1]) != negated);
      }
      case Kind::kCompare: return compare(condition, frame, negated);
      case Kind::kNot: return formula(condition.operands[0], frame, !negated);
      default: break;
    }
    std::vector<Formula> parts;
    const auto add_parts = [&] {
      for (std::size_t i = 0; i < condition.operands.size(); ++i)
        parts.push_back(formula(condition.operands[i], frame, negated != (condition.kind == Kind::kImply && i == 0)));
    };
    if (condition.kind == Kind::kForall || condition.kind == Kind::kExists)
      for_each_assignment(task_, condition.variables, frame, budget_, add_parts);
    else
      add_parts();
    const bool all = condition.kind == Kind::kAnd || condition.kind == Kind::kForall;
    return join(all != negated ? Formula::Kind::kAnd : Formula::Kind::kOr, std::move(parts));
  }

  /// The formula as a conjunction, with derived facts for disjunctions; none if it is false.
  std::optional<GroundCondition> conjunction(const Formula& from) {
    GroundCondition out;
    if (from.kind == Formula::Kind::kFalse) return std::nullopt;
    if (from.kind == Formula::Kind::kTrue) return out;
    const std::vector<Formula> single = {from};
    for (const Formula& part : from.kind == Formula::Kind::kAnd ? from.parts : single) {
      if (part.kind == Formula::Kind::kFact)
        out.facts.push_back(part.index);
      else if (part.kind == Formula::Kind::kComparison)
        out.comparisons.push_back(part.index);
      else
        out.facts.push_back(disjunction_fact(part));
    }
    sort_unique(out.facts);
    sort_unique(out.comparisons);
    return out;
  }

  int disjunction_fact(const Formula& from) {
    const int head = static_cast<int>(out_.facts.size());
    out_.facts.push_back({-1, {}, -1, false, true});
    for (const Formula& part : from.parts)
      if (std::optional<GroundCondition> body = conjunction(part)) out_.axioms.push_back({head, std::move(*body), 0});
    return head;
  }

  /// Conjunctions of which one holds exactly if the formula does.
  std::vector<GroundCondition> alternatives(const Formula& from) {
    std::vector<GroundCondition> out;
    for (const Formula& one : planner::alternatives(from, kMostAlternatives))
      if (std::optional<GroundCondition> made = conjunction(one)) out.push_back(std::move(*made));
    return out;
  }

  void add_actions(const Binding& binding) {
    const Action& schema = task_.domain.actions[binding.action];
    ById<ObjectId> frame(static_cast<std::size_t>(schema.slots), -1);
    std::ranges::copy(binding.arguments, frame.begin());
    const std::vector<GroundCondition> starts = alternatives(formula(schema.condition.start, frame, false));
    if (starts.empty()) return;
    const std::vector<GroundCondition> ends = alternatives(formula(schema.condition.end, frame, false));
    if (ends.empty()) return;
    GroundAction action;
    action.schema = binding.action;
    action.arguments = binding.arguments;
    action.durative = schema.durative;
    for (const DurationConstraint& constraint : schema.duration)
      action.duration.push_back({constraint.comparison, expression(constraint.bound, frame), constraint.at_end});
    bool asks_over_all = false;
    const auto add = [&](const GroundAction& with, bool instant) {
      GroundAction made = with;
      for (const Effect& effect : schema.effects)
        for_each_assignment(task_, effect.variables, frame, budget_, [&] { add_effect(effect, frame, instant, made); });
      for_each_effects(made, tidy);
      // What changes continuously needs a value, but not where it takes no time.
      for (const ContinuousEffect& effect : made.continuous) {
        asks_over_all |= is_undefined(effect.number);
        effect.rate.for_each_number([&](int n) { asks_over_all |= is_undefined(n); });
      }
      for (const GroundCondition& start : starts)
        for (const GroundCondition& end : ends) {
          if (instant && !may_be_instant(made, start)) continue;
          budget_.spend(Work::kGround, kActionWork);
          made.start = start;
          made.end = end;
          out_.actions.push_back(made);
        }
    };
    const bool takes_time = !schema.durative || constant_durations(action).most > 0;
    if (takes_time) {
      std::optional<GroundCondition> over_all = conjunction(formula(schema.condition.over_all, frame, false));
      asks_over_all |= !over_all || !std::ranges::all_of(starts, [&](const GroundCondition& start) {
        return over_all->comparisons.empty() && std::ranges::includes(start.facts, over_all->facts);
      });
      if (over_all) {
        action.over_all = std::move(*over_all);
        add(action, false);
        action.over_all = {};
      }
    }
    // Over all means nothing where an action takes no time: such an action is another one.
    for (const Effect& effect : schema.effects) {
      const bool ends_what_lasts = effect.kind == Effect::Kind::kDelete && effect.time == Effect::Time::kStart;
      asks_over_all |=
          !effect.condition.over_all.is_true() || (ends_what_lasts && !schema.condition.over_all.is_true());
    }
    if (!schema.durative || (takes_time && !asks_over_all)) return;
    action.duration.push_back({Comparison::kEqual, GroundExpression::constant(0), false});
    add(action, true);
  }

  bool is_undefined(int number) const {
    return std::isnan(initial_value(out_.numbers[number].function, out_.numbers[number].objects));
  }

  bool may_be_instant(const GroundAction& action, const GroundCondition& start) const {
    return std::ranges::none_of(action.duration, [&](const GroundDuration& duration) {
      return duration.comparison != Comparison::kLessEqual && is_surely_positive(out_, duration.bound, start);
    });
  }

  /// `instant`: what is asked over all counts as true.
  void add_effect(const Effect& effect, ById<ObjectId>& frame, bool instant, GroundAction& action) {
    using Kind = Effect::Kind;
    const Objects arguments(effect.terms, frame);
    if (effect.time == Effect::Time::kContinuous) {
      GroundExpression rate = expression(effect.value, frame);
      if (effect.kind == Kind::kDecrease) negate(rate);
      action.continuous.push_back({number(effect.function, arguments), std::move(rate)});
      return;
    }
    if (effect.kind == Kind::kDelete && !absence_matters_[effect.predicate] &&
        reachable_.atoms.find(effect.predicate, arguments) < 0)
      return;
    const bool at_start = effect.time == Effect::Time::kStart;
    GroundEffects* target = at_start ? &action.at_start : &action.at_end;
    if (!effect.condition.is_true()) {
      ConditionalEffects made;
      for (auto [from, to] : {std::pair{&effect.condition.start, &made.start},
                              {&effect.condition.over_all, &made.over_all},
                              {&effect.condition.end, &made.end}}) {
        if (instant && from == &effect.condition.over_all) continue;
        std::optional<GroundCondition> condition = conjunction(formula(*from, frame, false));
        if (!condition) return;
        *to = std::move(*condition);
      }
      if (!made.start.empty() || !made.over_all.empty() || !made.end.empty()) {
        auto known = std::ranges::find_if(action.conditional, [&](const ConditionalEffects& other) {
          return same(other.start, made.start) && same(other.over_all, made.over_all) && same(other.end, made.end);
        });
        if (known == action.conditional.end()) known = action.conditional.insert(known, std::move(made));
        target = at_start ? &known->at_start : &known->at_end;
      }
    }
    if (effect.kind == Kind::kAdd) {
      target->add.push_back(fact(effect.predicate, arguments));
    } else if (effect.kind == Kind::kDelete) {
      target->remove.push_back(fact(effect.predicate, arguments));
    } else {
      NumericEffect numeric{NumericEffect::Kind::kIncrease, number(effect.function, arguments),
                            expression(effect.value, frame)};
      if (effect.kind == Kind::kAssign) numeric.kind = NumericEffect::Kind::kAssign;
      if (effect.kind == Kind::kDecrease) negate(numeric.value);
      if (effect.kind == Kind::kScaleUp) numeric.kind = NumericEffect::Kind::kScale;
      if (effect.kind == Kind::kScaleDown) numeric.kind = NumericEffect::Kind::kDivide;
      target->numbers.push_back(std::move(numeric));
    }
  }

  static void negate(GroundExpression& value) {
    if (value.is_constant())
      value.steps[0].value = -value.steps[0].value;
    else
      value.steps.push_back({GroundExpression::Kind::kNegate, -1, 0});
  }

  static void tidy(GroundEffects& effects) {
    sort_unique(effects.add);
    sort_unique(effects.remove);
    std::erase_if(effects.remove, [&](int id) { return contains(effects.add, id); });
  }

  /// Axioms of a derived fact that some condition asks for.
  void derive(int id) {
    const PredicateId predicate = out_.facts[id].predicate;
    const std::vector<ObjectId> arguments = out_.facts[id].objects;
    for (const Derivation& rule : task_.domain.derivations) {
      if (rule.predicate != predicate) continue;
      bool typed = true;
      for (std::size_t i = 0; i < arguments.size(); ++i)
        typed = typed && fits(task_.domain, task_.problem.objects[arguments[i]], rule.parameters[i].types);
      if (!typed) continue;
      ById<ObjectId> frame(static_cast<std::size_t>(rule.slots), -1);
      for (std::size_t i = 0; i < arguments.size(); ++i) frame[rule.parameters[i].slot] = arguments[i];
      for (GroundCondition& body : alternatives(formula(rule.condition, frame, false)))
        out_.axioms.push_back({id, std::move(body), 0});
    }
  }

  void add_events() {
    std::map<Micros, GroundEffects> events;
    for (const TimedFact& timed : task_.problem.timed_facts) {
      GroundEffects& effects = events[in_micros(timed.time)];
      if (!timed.value && reachable_.atoms.find(timed.fact.predicate, timed.fact.objects) < 0) continue;
      const int id = fact(timed.fact.predicate, timed.fact.objects);
      std::erase(timed.value ? effects.remove : effects.add, id);  // of less than a microsecond before
      (timed.value ? effects.add : effects.remove).push_back(id);
    }
    for (const TimedAssignment& timed : task_.problem.timed_values)
      events[in_micros(timed.time)].numbers.push_back({NumericEffect::Kind::kAssign,
                                                       number(timed.assignment.function, timed.assignment.objects),
                                                       GroundExpression::constant(timed.assignment.value)});
    for (auto& [time, effects] : events) {
      tidy(effects);
      out_.events.push_back({time, std::move(effects), {}});
    }
  }

  void mirror_complements() {
    const auto mirror = [this](GroundEffects& effects) {
      const std::size_t adds = effects.add.size(), removes = effects.remove.size();
      for (std::size_t i = 0; i < adds; ++i)
        if (const int opposite = out_.facts[effects.add[i]].complement; opposite >= 0)
          effects.remove.push_back(opposite);
      for (std::size_t i = 0; i < removes; ++i)
        if (const int opposite = out_.facts[effects.remove[i]].complement; opposite >= 0)
          effects.add.push_back(opposite);
      tidy(effects);
    };
    for (GroundAction& action : out_.actions) for_each_effects(action, mirror);
    for (TimedEvent& event : out_.events) mirror(event.effects);
  }

  void set_initial_state() {
    out_.initial_facts.assign(out_.facts.size(), 0);
    for (const Fact& init : task_.problem.init)
      if (const int atom = fact_atoms_.find(init.predicate, init.objects); atom >= 0)
        out_.initial_facts[fact_ids_[atom]] = 1;
    for (std::size_t f = 0; f < out_.facts.size(); ++f)
      if (out_.facts[f].is_complement) out_.initial_facts[f] = !out_.initial_facts[out_.facts[f].complement];
    for (const GroundNumber& number : out_.numbers)
      out_.initial_numbers.push_back(initial_value(number.function, number.objects));
  }

  /// Negation in a body reaches lower strata only.
  void order_axioms() {
    ById<int> stratum(out_.facts.size(), 0);
    for (bool changed = true; changed && !budget_.over();) {
      changed = false;
      budget_.spend(Work::kGround, static_cast<std::int64_t>(out_.axioms.size()));
      for (const Axiom& axiom : out_.axioms)
        for (const int id : axiom.body.facts) {
          const GroundFact& read = out_.facts[id];
          if (!read.derived) continue;
          const int least = read.is_complement ? stratum[read.complement] + 1 : stratum[id];
          if (stratum[axiom.head] < least) {
            stratum[axiom.head] = least;
            changed = true;
          }
        }
    }
    for (Axiom& axiom : out_.axioms) axiom.stratum = stratum[axiom.head];
    std::ranges::stable_sort(out_.axioms, {}, &Axiom::stratum);
  }

  const Task& task_;
  Reachable reachable_;
  Budget& budget_;
  GroundTask out_;
  AtomTable fact_atoms_, number_atoms_, valued_;  ///< the functions of numbers in place of predicates
  ById<double> values_;                           ///< at first, by atom of valued_
  ById<int> fact_ids_;                            ///< by atom of fact_atoms_
  std::map<std::string, int> comparison_ids_;
  ById<char> absence_matters_;  ///< by predicate
  std::vector<int> demanded_;   ///< derived facts that conditions ask for
};

/// What reads or changes a number that has no value at first has to wait for one; and an effect that computes a product
/// or a quotient of numbers, for those that give one.
void ask_for_values(GroundTask& task) {
  std::map<std::string, int> known;
  const auto ask = [&](GroundCondition& condition, const GroundExpression& expression) {
    std::string key;
    expression.append_key(key);
    const auto [entry, fresh] = known.try_emplace(std::move(key), static_cast<int>(task.comparisons.size()));
    if (fresh) {  // its square is at least 0 where it is a number
      GroundExpression square = expression;
      square.steps.insert(square.steps.end(), expression.steps.begin(), expression.steps.end());
      square.steps.push_back({GroundExpression::Kind::kMultiply, -1, 0});
      LinearForm form = linear_form_of_all(square);
      task.comparisons.push_back({GroundComparison::Kind::kNotNegative, std::move(square), std::move(form)});
    }
    condition.comparisons.push_back(entry->second);
  };
  const auto ask_number = [&](GroundCondition& condition, int number) {
    if (std::isnan(task.initial_numbers[number])) ask(condition, {{{GroundExpression::Kind::kFunction, number, 0}}});
  };
  const auto ask_read = [&](GroundCondition& condition, const GroundExpression& expression) {
    expression.for_each_number([&](int number) { ask_number(condition, number); });
  };
  for (GroundAction& action : task.actions) {
    for (auto [effects, condition] : {std::pair{&action.at_start, &action.start}, {&action.at_end, &action.end}})
      for (const NumericEffect& effect : effects->numbers) {
        if (effect.kind != NumericEffect::Kind::kAssign) ask_number(*condition, effect.number);
        ask_read(*condition, effect.value);
        if (!linear_form(effect.value).is_linear) ask(*condition, effect.value);
      }
    // What the action itself assigns at its start has a value from then on.
    const auto assigns = [&](int number) {
      const auto is_it = [&](const NumericEffect& effect) {
        return effect.number == number && effect.kind == NumericEffect::Kind::kAssign;
      };
      bool found = false;
      for_each_share(action, [&](const ConditionalEffects& share) {
        found = found || std::ranges::any_of(share.at_start.numbers, is_it);
      });
      return found;
    };
    const auto ask_before = [&](int number) {
      if (!assigns(number)) ask_number(action.start, number);
    };
    for (const ContinuousEffect& effect : action.continuous) {
      ask_before(effect.number);
      effect.rate.for_each_number(ask_before);
    }
    sort_unique(action.start.comparisons);
    sort_unique(action.end.comparisons);
  }
}

/// Incomplete if the budget ends.
Expected<GroundTask> write_out(const Task& task, Budget& budget) {
  Expected<Reachable> reachable = find_reachable(task, kMostActions, budget);
  if (!reachable) return reachable.error();
  GroundTask out = Grounder(task, std::move(*reachable), budget).run();
  merge_instants(out);
  if (!budget.over()) ask_for_values(out);
  return out;
}

Expected<GroundTask> if_in_budget(Expected<GroundTask> task, Budget& budget) {
  if (task && budget.over()) return out_of_budget("while the problem was written out");
  return task;
}

}  // namespace

Expected<GroundTask> ground(const Task& task, Budget& budget) {
  Expected<GroundTask> out = write_out(task, budget);
  if (out && !budget.over()) prune(*out, budget);
  if (out && !budget.over()) find_idle(task, *out, budget);
  return if_in_budget(std::move(out), budget);
}

Expected<GroundTask> ground_by_facts(const Task& task, Budget& budget) {
  Expected<GroundTask> out = write_out(task, budget);
  if (out && !budget.over()) prune_by_facts(*out, budget);
  return if_in_budget(std::move(out), budget);
}

}  // namespace cxlab::planner
