#include "planner/ground/reachable.h"

#include <algorithm>

#include "planner/ground/passes.h"

namespace cxlab::planner {

namespace {

constexpr std::int64_t kBindingWork = 3;  ///< of an action that is found, in pieces of Work::kGround

struct Atom {
  PredicateId predicate = -1;
  std::vector<Term> terms;
};

struct Equality {
  Term left, right;
  bool same = true;
};

/// What the join looks at in one action.
struct Pattern {
  ById<Atom> atoms;
  std::vector<Equality> equalities;
  std::vector<std::vector<ObjectId>> candidates;  ///< by parameter
  ById<ById<char>> allowed;                       ///< by parameter, object
};

class Join {
 public:
  Join(const Task& task, std::size_t most, Budget& budget) : task_(task), most_(most), budget_(budget) {}

  Expected<Reachable> run() {
    find_changing();
    const std::size_t predicates = task_.domain.predicates.size();
    by_argument_.resize(predicates);
    everything_.resize(predicates);
    for (std::size_t p = 0; p < predicates; ++p)
      by_argument_[p].assign(task_.domain.predicates[p].parameters.size(), ById<int>(task_.problem.objects.size(), 0));
    relevant_ = relevant_actions(task_);
    for (std::size_t a = 0; a < task_.domain.actions.size(); ++a)
      patterns_.push_back(make_pattern(task_.domain.actions[a]));

    AtomTable& atoms = result_.atoms;
    for (const Fact& fact : task_.problem.init)
      if (!result_.fluent[fact.predicate]) show(atoms.insert(fact.predicate, fact.objects));
    visible_ = atoms.size();
    for (const Fact& fact : task_.problem.init) atoms.insert(fact.predicate, fact.objects);
    for (const TimedFact& timed : task_.problem.timed_facts)
      if (timed.value) atoms.insert(timed.fact.predicate, timed.fact.objects);
    for (std::size_t a = 0; a < patterns_.size(); ++a)
      if (relevant_[a] && std::ranges::none_of(patterns_[a].atoms, [this](const Atom& atom) {
            return result_.fluent[atom.predicate] != 0;
          }))
        begin(a, -1, -1);
    while (visible_ < atoms.size() && !stopped()) {
      const int atom = visible_++;
      show(atom);
      for (std::size_t a = 0; a < patterns_.size(); ++a)
        for (std::size_t k = 0; k < patterns_[a].atoms.size(); ++k)
          if (relevant_[a] && patterns_[a].atoms[k].predicate == atoms.predicate(atom))
            begin(a, static_cast<int>(k), atom);
    }
    if (too_many_)
      return resource_error("found more than " + std::to_string(most_) +
                                " ground actions: the problem is too large to be written out",
                            task_.problem.file)
          .with_code(word_of(Failure::kOutOfMemory));
    if (budget_.over()) return out_of_budget("while the problem was written out");
    return std::move(result_);
  }

 private:
  bool stopped() { return too_many_ || budget_.over(); }

  void find_changing() {
    Symbols found = changing(task_.domain, task_.problem);
    result_.fluent = std::move(found.predicates);
    result_.changing = std::move(found.functions);
    for (std::size_t p = 0; p < task_.domain.predicates.size(); ++p)
      result_.fluent[p] |= static_cast<char>(task_.domain.predicates[p].derived);
  }

  /// Whether the action may take no time, so that nothing is asked over all.
  bool may_be_instant(const Action& action) const {
    return std::ranges::none_of(action.duration, [this](const DurationConstraint& constraint) {
      return constraint.comparison != Comparison::kLessEqual && is_positive(constraint.bound);
    });
  }

  /// Whether a number is above 0 with any arguments; unknown is no.
  bool is_positive(const Expression& expression) const {
    using Kind = Expression::Kind;
    switch (expression.kind) {
      case Kind::kConstant: return expression.value > 0;
      case Kind::kFunction:
        return !result_.changing[expression.function] &&
               std::ranges::all_of(task_.problem.values, [&](const Assignment& value) {
                 return value.function != expression.function || value.value > 0;
               });
      case Kind::kAdd:
      case Kind::kMultiply:
      case Kind::kDivide:
        return std::ranges::all_of(expression.operands, [this](const Expression& part) { return is_positive(part); });
      default: return false;
    }
  }

  Pattern make_pattern(const Action& action) const {
    Pattern pattern;
    // The action itself, or another one that overlaps it, may make a later condition true. So at the end only facts
    // that cannot change count. Over all, the facts count that no action adds which begins in the same instant.
    const ById<char>& later = result_.fluent;
    ById<char> at_once(later.size(), 0);
    for (const Effect& effect : action.effects)
      if (effect.kind == Effect::Kind::kAdd && effect.time == Effect::Time::kStart) at_once[effect.predicate] = 1;
    for (const Action& other : task_.domain.actions)
      for (const Effect& effect : other.effects)
        if (effect.kind == Effect::Kind::kAdd && effect.time == Effect::Time::kStart &&
            !other.condition.over_all.is_true())
          at_once[effect.predicate] = 1;
    collect(action.condition.start, nullptr, pattern);
    if (!may_be_instant(action)) collect(action.condition.over_all, &at_once, pattern);
    collect(action.condition.end, &later, pattern);
    ById<char> used(static_cast<std::size_t>(action.slots), 0);
    const auto use = [&used](const auto& part) {
      for (const Term& term : part.terms)
        if (term.is_variable) used[term.index] = 1;
    };
    const auto use_condition = [&](const Condition& part, bool) {
      use(part);
      for (const Expression& side : part.sides) for_each_part(side, use);
    };
    for (const Condition* condition : action.condition.parts()) for_each_part(*condition, use_condition);
    for (const DurationConstraint& constraint : action.duration) for_each_part(constraint.bound, use);
    for (const Effect& effect : action.effects) {
      use(effect);
      for_each_part(effect.value, use);
      for (const Condition* condition : effect.condition.parts()) for_each_part(*condition, use_condition);
    }
    for (const Variable& parameter : action.parameters) {
      pattern.candidates.push_back(objects_of(task_.domain, task_.problem, parameter.types));
      if (!used[parameter.slot] && pattern.candidates.back().size() > 1)
        pattern.candidates.back().resize(1);  // all would be the same
      pattern.allowed.emplace_back(task_.problem.objects.size(), 0);
      for (const ObjectId object : pattern.candidates.back()) pattern.allowed.back()[object] = 1;
    }
    return pattern;
  }

  /// `left_out`: by predicate, atoms that do not count.
  void collect(const Condition& condition, const ById<char>* left_out, Pattern& pattern) const {
    using Kind = Condition::Kind;
    if (condition.kind == Kind::kAnd) {
      for (const Condition& operand : condition.operands) collect(operand, left_out, pattern);
    } else if (condition.kind == Kind::kAtom) {
      if (!task_.domain.predicates[condition.predicate].derived && !(left_out && (*left_out)[condition.predicate]))
        pattern.atoms.push_back({condition.predicate, condition.terms});
    } else if (condition.kind == Kind::kSame) {
      pattern.equalities.push_back({condition.terms[0], condition.terms[1], true});
    } else if (condition.kind == Kind::kNot && condition.operands[0].kind == Kind::kSame) {
      pattern.equalities.push_back({condition.operands[0].terms[0], condition.operands[0].terms[1], false});
    }
  }

  void show(int atom) {
    const PredicateId predicate = result_.atoms.predicate(atom);
    everything_[predicate].push_back(atom);
    const std::span<const ObjectId> objects = result_.atoms.objects(atom);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      int& list = by_argument_[predicate][i][objects[i]];
      if (list == 0) {
        list = static_cast<int>(lists_.size());
        lists_.emplace_back();
      }
      lists_[list].push_back(atom);
    }
  }

  void begin(std::size_t action, int first, int atom) {
    action_ = action;
    frame_.assign(static_cast<std::size_t>(task_.domain.actions[action].slots), -1);
    ById<char> done(patterns_[action].atoms.size(), 0);
    if (first >= 0) {
      std::vector<int> bound;
      if (!match(patterns_[action].atoms[first], atom, bound)) return;
      done[first] = 1;
    }
    extend(done);
  }

  /// Binds the variables of `pattern` to the objects of `atom`; the slots bound are added to `bound`.
  bool match(const Atom& pattern, int atom, std::vector<int>& bound) {
    const std::span<const ObjectId> objects = result_.atoms.objects(atom);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const Term& term = pattern.terms[i];
      const ObjectId now = term.in(frame_);
      if (now == objects[i]) continue;
      if (now >= 0 || !patterns_[action_].allowed[term.index][objects[i]]) return release(bound);
      frame_[term.index] = objects[i];
      bound.push_back(term.index);
    }
    return equalities_hold() || release(bound);
  }

  bool release(std::vector<int>& bound) {
    for (const int slot : bound) frame_[slot] = -1;
    bound.clear();
    return false;
  }

  bool equalities_hold() const {
    return std::ranges::all_of(patterns_[action_].equalities, [this](const Equality& equality) {
      const ObjectId left = equality.left.in(frame_), right = equality.right.in(frame_);
      return left < 0 || right < 0 || (left == right) == equality.same;
    });
  }

  void extend(ById<char> done) {
    const Pattern& pattern = patterns_[action_];
    int best = -1;
    const std::vector<int>* candidates = nullptr;
    for (std::size_t k = 0; k < pattern.atoms.size(); ++k) {
      if (done[k]) continue;
      const Atom& atom = pattern.atoms[k];
      bool ground = true;
      const std::vector<int>* fewest = &everything_[atom.predicate];
      key_.clear();
      for (std::size_t i = 0; i < atom.terms.size(); ++i) {
        const ObjectId object = atom.terms[i].in(frame_);
        key_.push_back(object);
        if (object < 0)
          ground = false;
        else if (const std::vector<int>& with = lists_[by_argument_[atom.predicate][i][object]];
                 with.size() < fewest->size())
          fewest = &with;
      }
      if (ground) {
        const int known = result_.atoms.find(atom.predicate, key_);
        if (known < 0 || known >= visible_) return;
        done[k] = 1;
      } else if (!candidates || fewest->size() < candidates->size()) {
        best = static_cast<int>(k);
        candidates = fewest;
      }
    }
    if (best < 0) {
      enumerate(0);
      return;
    }
    done[best] = 1;
    std::vector<int> bound;
    for (const int atom : *candidates) {
      budget_.spend(Work::kGround, 1);
      if (match(pattern.atoms[best], atom, bound)) {
        extend(done);
        release(bound);
      }
      if (stopped()) return;
    }
  }

  void enumerate(std::size_t parameter) {
    const Pattern& pattern = patterns_[action_];
    while (parameter < pattern.candidates.size() && frame_[parameter] >= 0) ++parameter;
    if (parameter == pattern.candidates.size()) {
      record();
      return;
    }
    for (const ObjectId object : pattern.candidates[parameter]) {
      frame_[parameter] = object;
      budget_.spend(Work::kGround, 1);
      if (equalities_hold()) enumerate(parameter + 1);
      if (stopped()) break;
    }
    frame_[parameter] = -1;
  }

  void record() {
    const Action& action = task_.domain.actions[action_];
    const std::vector<ObjectId> arguments(frame_.begin(),
                                          frame_.begin() + static_cast<std::ptrdiff_t>(action.parameters.size()));
    const int before = seen_.size();
    seen_.insert(static_cast<PredicateId>(action_), arguments);
    if (seen_.size() == before) return;
    if (result_.bindings.size() >= most_) {
      too_many_ = true;
      return;
    }
    budget_.spend(Work::kGround, kBindingWork);
    result_.bindings.push_back({static_cast<ActionId>(action_), arguments});
    ById<ObjectId> frame = frame_;
    for (const Effect& effect : action.effects) {
      if (effect.kind != Effect::Kind::kAdd) continue;
      for_each_assignment(task_, effect.variables, frame, budget_,
                          [&] { result_.atoms.insert(effect.predicate, Objects(effect.terms, frame)); });
    }
  }

  const Task& task_;
  const std::size_t most_;
  Budget& budget_;
  Reachable result_;
  std::vector<Pattern> patterns_;
  std::vector<char> relevant_;         ///< by action
  ById<ById<ById<int>>> by_argument_;  ///< predicate, position, object: list of visible atoms
  ById<std::vector<int>> lists_{{}};   ///< the first one is of all that have none
  ById<std::vector<int>> everything_;  ///< predicate: visible atoms
  AtomTable seen_;                     ///< bindings
  int visible_ = 0;
  std::size_t action_ = 0;
  ById<ObjectId> frame_, key_;
  bool too_many_ = false;
};

}  // namespace

Expected<Reachable> find_reachable(const Task& task, std::size_t most_bindings, Budget& budget) {
  return Join(task, most_bindings, budget).run();
}

}  // namespace cxlab::planner
