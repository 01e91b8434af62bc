#include "planner/explain/out_of_reach.h"

#include <algorithm>
#include <set>
#include <utility>

#include "planner/explain/choices.h"
#include "planner/explain/reach.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {

namespace {

constexpr std::size_t kMostActions = 1'000'000;
constexpr std::size_t kMostMakers = 3;             ///< actions that a text names
constexpr std::size_t kMostCauses = 4;             ///< that a text tells, half of them at each end
constexpr std::size_t kMostCausesInSearch = 200;   ///< of a chain
constexpr std::size_t kLongestAlternatives = 100;  ///< that a text quotes

/// A number that should move.
struct Move {
  FunctionId function = -1;
  std::vector<std::vector<ObjectId>> objects;
  bool up = false, down = false;
  std::string name;
};

/// A smallest part of a condition that never holds with any of the choices.
struct Gap {
  enum class Kind {
    kFact,      ///< `facts[0]`
    kNumber,    ///< one of `moves` is needed
    kValue,     ///< a number of `moves` needs a value
    kTogether,  ///< two facts
    kNever,     ///< whatever is done
  };
  Kind kind = Kind::kNever;
  std::string text;
  std::string when;
  std::vector<FactPattern> facts;
  std::vector<Move> moves;
  std::string reason;  ///< of kNever
};

/// An effect or a rule that would bring something about, for some of its arguments.
struct Maker {
  std::string name;
  Source source;
  Choices choices;
  std::vector<Demand> demands;
  std::vector<const Condition*> conjunctions;  ///< each asked for at one time
  std::vector<Gap> gaps;                       ///< the best instance lacks these
  std::pair<int, int> lacks{0, 0};             ///< how many of them nothing can change, how many in all
};

bool is_fixed(const std::vector<std::vector<ObjectId>>& objects) {
  return std::ranges::all_of(objects, [](const auto& any) { return any.size() == 1; });
}

std::string file_name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

class Explainer {
 public:
  Explainer(const Task& task, const Reachable& reachable, Budget& budget, const PairJudge* pairs,
            std::string_view initial)
      : domain_(task.domain),
        problem_(task.problem),
        budget_(budget),
        reach_(task, reachable, budget, pairs),
        judge_(reach_, budget),
        initial_(initial) {}

  std::optional<OutOfReach> run() {
    if (budget_.over()) return std::nullopt;
    const Choices choices(static_cast<std::size_t>(problem_.goal_slots));
    std::vector<Gap> gaps;
    name_variables({}, {}, {&problem_.goal});
    for_each_conjunct(problem_.goal, true, [&](const Condition& part, bool wanted) {
      if (!budget_.over() && judge_.is_impossible(part, wanted, choices)) find_gaps(part, wanted, choices, "", gaps);
    });
    Frame frame(choices.size(), -1);
    if (gaps.empty())
      if (const auto apart = reach_.never_together(problem_.goal, frame)) gaps.push_back(apart_gap(*apart));
    for (const Gap& gap : gaps) {
      OutOfReach chain;
      if (follow(gap, chain) && !budget_.over()) return chain;
    }
    if (budget_.over() || circle_.causes.empty()) return std::nullopt;
    return circle_;
  }

 private:
  // --- Texts

  static void bind(std::vector<Term>& terms, const Choices& choices) {
    for (Term& term : terms)
      if (term.is_variable && choices[term.index].size() == 1) term = Term::object(choices[term.index][0]);
  }
  static Expression bound(Expression expression, const Choices& choices) {
    bind(expression.terms, choices);
    for (Expression& operand : expression.operands) operand = bound(std::move(operand), choices);
    return expression;
  }
  static Condition bound(Condition condition, const Choices& choices) {
    bind(condition.terms, choices);
    for (Expression& side : condition.sides) side = bound(std::move(side), choices);
    for (Condition& operand : condition.operands) operand = bound(std::move(operand), choices);
    return condition;
  }

  Printer printer(const Choices& choices) const {
    Printer printer(domain_, problem_.objects);
    std::vector<Variable> names;
    for (std::size_t slot = 0; slot < choices.size(); ++slot)
      if (choices[slot].size() > 1) names.push_back({variable_name(slot), {}, static_cast<int>(slot)});
    printer.name_variables(names);
    return printer;
  }
  /// Objects where there is one choice, otherwise variables.
  std::string text_of(const Condition& condition, const Choices& choices) const {
    return printer(choices).condition(bound(condition, choices));
  }
  std::string text_of(const Expression& expression, const Choices& choices) const {
    return printer(choices).expression(bound(expression, choices));
  }

  std::string variable_name(std::size_t slot) const {
    if (slot < variables_.size() && !variables_[slot].empty()) return variables_[slot];
    return "?x" + std::to_string(slot);
  }

  /// The names of the variables of an action, a rule or the goal, for texts from now on.
  void name_variables(const std::vector<Variable>& parameters, const std::vector<Variable>& others,
                      std::initializer_list<const Condition*> conditions) {
    variables_.clear();
    const auto note = [this](const std::vector<Variable>& variables) {
      for (const Variable& variable : variables) {
        if (variables_.size() <= static_cast<std::size_t>(variable.slot))
          variables_.resize(static_cast<std::size_t>(variable.slot) + 1);
        variables_[variable.slot] = variable.name;
      }
    };
    note(parameters);
    note(others);
    for (const Condition* condition : conditions)
      for_each_part(*condition, [&](const Condition& part, bool) { note(part.variables); });
  }

  std::string place(const Source& source) const {
    const bool in_domain = source.file == Source::File::kDomain;
    const std::string file = file_name(in_domain ? domain_.file : problem_.file);
    return source.line > 0 ? file + ':' + std::to_string(source.line) : file;
  }

  // --- Gaps

  Gap fact_gap(const Condition& atom, bool value, const Choices& choices) const {
    Gap gap{Gap::Kind::kFact, text_of(atom, choices), "", {}, {}, ""};
    if (!value) gap.text = "(not " + gap.text + ")";
    gap.facts.push_back({atom.predicate, chosen(atom.terms, choices), value});
    return gap;
  }

  Gap apart_gap(const std::pair<GroundLiteral, GroundLiteral>& apart) const {
    Gap gap{Gap::Kind::kTogether, "", "", {}, {}, ""};
    for (const GroundLiteral& one : {apart.first, apart.second}) {
      const std::string text = ground_text(domain_.predicates[one.predicate].name, one.objects, problem_.objects);
      gap.text += (gap.text.empty() ? "" : " and ") + (one.value ? text : "(not " + text + ")");
      FactPattern& fact = gap.facts.emplace_back(FactPattern{one.predicate, {}, one.value});
      for (const ObjectId object : one.objects) fact.objects.push_back({object});
    }
    return gap;
  }

  /// The moves of numbers that would make an expression greater, or less.
  void find_moves(const Expression& expression, bool up, bool down, const Choices& choices,
                  std::vector<Move>& moves) const {
    using Kind = Expression::Kind;
    const auto& parts = expression.operands;
    switch (expression.kind) {
      case Kind::kConstant:
      case Kind::kDuration:
      case Kind::kTotalTime: return;
      case Kind::kFunction:
        moves.push_back(
            {expression.function, chosen(expression.terms, choices), up, down, text_of(expression, choices)});
        return;
      case Kind::kAdd:
        for (const Expression& part : parts) find_moves(part, up, down, choices, moves);
        return;
      case Kind::kSubtract:
        find_moves(parts[0], up, down, choices, moves);
        find_moves(parts[1], down, up, choices, moves);
        return;
      case Kind::kNegate: find_moves(parts[0], down, up, choices, moves); return;
      default: {
        const bool factor_is_constant = parts[1].kind == Kind::kConstant || parts[0].kind == Kind::kConstant;
        const double factor = parts[0].kind == Kind::kConstant ? parts[0].value : parts[1].value;
        const bool same = parts.size() == 2 && factor_is_constant && factor > 0;
        for (const Expression& part : parts) find_moves(part, up || !same, down || !same, choices, moves);
        return;
      }
    }
  }

  Gap value_gap(const Expression& expression, const Choices& choices) {
    Gap gap{Gap::Kind::kValue, "", "", {}, {}, ""};
    for_each_part(expression, [&](const Expression& part) {
      if (part.kind != Expression::Kind::kFunction || !gap.moves.empty()) return;
      std::set<int> slots;
      note_slots(part, choices, slots);
      if (judge_.any(slots, choices, [&](Frame& frame) { return reach_.range(part, frame).has_value(); })) return;
      gap.text = text_of(part, choices);
      gap.moves.push_back({part.function, chosen(part.terms, choices), true, true, gap.text});
      gap.text = "a value of " + gap.text;
    });
    if (!gap.moves.empty()) return gap;
    gap.kind = Gap::Kind::kNever;
    gap.text = "a value of " + text_of(expression, choices);
    gap.reason = "it has none: something is divided by 0";
    return gap;
  }

  Gap number_gap(const Condition& condition, bool wanted, const Choices& choices) {
    const std::set<int> slots = slots_of(condition, choices);
    for (const Expression& side : condition.sides)
      if (wanted && !judge_.any(slots, choices, [&](Frame& frame) { return reach_.range(side, frame).has_value(); }))
        return value_gap(side, choices);
    Gap gap{Gap::Kind::kNumber, text_of(condition, choices), "", {}, {}, ""};
    if (!wanted) gap.text = "(not " + gap.text + ")";
    bool up = true, down = true;  // of the left side
    const bool more = condition.comparison == Comparison::kGreater || condition.comparison == Comparison::kGreaterEqual;
    if (condition.comparison != Comparison::kEqual) {
      up = more == wanted;
      down = !up;
    } else if (wanted) {
      Frame frame(choices.size(), -1);
      for (const int slot : slots) frame[slot] = choices[slot][0];
      const auto left = reach_.range(condition.sides[0], frame), right = reach_.range(condition.sides[1], frame);
      if (left && right) {
        up = left->high < right->low;
        down = !up;
      }
    }
    find_moves(condition.sides[0], up, down, choices, gap.moves);
    find_moves(condition.sides[1], down, up, choices, gap.moves);
    if (!gap.moves.empty()) return gap;
    gap.kind = Gap::Kind::kNever;
    gap.reason = "it compares constants";
    return gap;
  }

  Gap never(std::string text, std::string reason) const {
    return {Gap::Kind::kNever, std::move(text), "", {}, {}, std::move(reason)};
  }

  /// The smallest parts that keep a condition from being `wanted` with any of the choices.
  void find_gaps(const Condition& condition, bool wanted, const Choices& choices, const char* when,
                 std::vector<Gap>& gaps) {
    const std::size_t before = gaps.size();
    find_parts(condition, wanted, choices, gaps);
    for (std::size_t i = before; i < gaps.size(); ++i) gaps[i].when = when;
  }

  void find_parts(const Condition& condition, bool wanted, const Choices& choices, std::vector<Gap>& gaps) {
    using Kind = Condition::Kind;
    if (budget_.over()) return;
    switch (condition.kind) {
      case Kind::kAtom: gaps.push_back(fact_gap(condition, wanted, choices)); return;
      case Kind::kCompare: gaps.push_back(number_gap(condition, wanted, choices)); return;
      case Kind::kNot: find_parts(condition.operands[0], !wanted, choices, gaps); return;
      case Kind::kSame: {
        const std::string text = text_of(condition, choices);
        gaps.push_back(never(wanted ? text : "(not " + text + ")",
                             wanted ? "no objects that fit are the same" : "no objects that fit are different"));
        return;
      }
      case Kind::kForall:
      case Kind::kExists: {
        Choices inner = choices;
        for (const Variable& variable : condition.variables)
          inner[variable.slot] = objects_of(domain_, problem_, variable.types);
        if ((condition.kind == Kind::kExists) == wanted)
          find_some(condition, wanted, inner, gaps);
        else
          find_each(condition, wanted, choices, inner, gaps);
        return;
      }
      default: break;
    }
    std::vector<std::pair<const Condition*, bool>> parts;
    for (const Condition& operand : condition.operands)
      parts.emplace_back(&operand,
                         condition.kind == Kind::kImply && &operand == &condition.operands[0] ? !wanted : wanted);
    if ((condition.kind == Kind::kAnd) == wanted) {
      find_in_all(parts, choices, gaps);
      return;
    }
    const std::string text = text_of(condition, choices);
    if (parts.empty())
      gaps.push_back(never(wanted ? text : "(not " + text + ")", "nothing is asked for that could be so"));
    const std::size_t before = gaps.size();  // each of them is out of reach
    for (const auto& [part, sign] : parts) find_parts(*part, sign, choices, gaps);
    // First those that an action could bring about.
    std::stable_partition(gaps.begin() + static_cast<std::ptrdiff_t>(before), gaps.end(), [this](const Gap& gap) {
      return gap.kind != Gap::Kind::kFact || !reach_.is_static(gap.facts[0].predicate);
    });
    for (std::size_t i = before; i < gaps.size() && parts.size() > 1 && text.size() <= kLongestAlternatives; ++i)
      gaps[i].text += ", one way to " + std::string(wanted ? "" : "break ") + text + ",";
  }

  /// Finds the parts of a conjunction that are out of reach alone. If no part is, finds those that are out of reach
  /// with the nearest choice of objects.
  void find_in_all(const std::vector<std::pair<const Condition*, bool>>& parts, const Choices& choices,
                   std::vector<Gap>& gaps) {
    const std::size_t before = gaps.size();
    for (const auto& [part, wanted] : parts)
      if (judge_.is_impossible(*part, wanted, choices)) find_parts(*part, wanted, choices, gaps);
    if (gaps.size() > before) return;
    std::vector<Demand> demands;
    for (const auto& [part, wanted] : parts) demands.push_back({part, wanted, "", {}});
    const Choices nearest = judge_.nearest_choice(demands, choices).first;
    Frame frame = frame_of(nearest);
    for (const auto& [part, wanted] : parts)
      if (!reach_.can_hold(*part, frame, wanted)) find_parts(*part, wanted, nearest, gaps);
  }

  void find_some(const Condition& condition, bool wanted, const Choices& inner, std::vector<Gap>& gaps) {
    for (const Variable& variable : condition.variables)
      if (inner[variable.slot].empty()) {
        gaps.push_back(no_object(variable));
        return;
      }
    find_parts(condition.operands[0], wanted, inner, gaps);
  }

  void find_each(const Condition& condition, bool wanted, const Choices& choices, const Choices& inner,
                 std::vector<Gap>& gaps) {
    std::vector<int> slots;
    for (const Variable& variable : condition.variables) slots.push_back(variable.slot);
    Frame frame(choices.size(), -1);
    const auto look = [&](const Choices& outer) {
      return judge_.any_choice(slots, 0, inner, frame, [&] {
        Choices one = outer;
        for (const int slot : slots) one[slot] = {frame[slot]};
        if (!judge_.is_impossible(condition.operands[0], wanted, one)) return false;
        find_parts(condition.operands[0], wanted, one, gaps);
        return true;
      });
    };
    if (look(choices)) return;
    look(judge_.nearest_choice({{&condition, wanted, "", {}}}, choices).first);
  }

  Gap no_object(const Variable& variable) const {
    return never("an object of type " + types_text(domain_, variable.types), "there is none");
  }

  // --- What would close a gap

  /// Restricts the choices to those with which `terms` are among `objects`; false if there are none.
  static bool fit(const std::vector<Term>& terms, const std::vector<std::vector<ObjectId>>& objects, Choices& choices) {
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const auto fits = [&](ObjectId object) { return std::ranges::find(objects[i], object) != objects[i].end(); };
      if (!terms[i].is_variable) {
        if (!fits(terms[i].index)) return false;
        continue;
      }
      std::vector<ObjectId>& any = choices[terms[i].index];
      std::erase_if(any, [&](ObjectId object) { return !fits(object); });
      if (any.empty()) return false;
    }
    return true;
  }

  bool helps(const Effect& effect, const Gap& gap, Choices& choices) const {
    using Kind = Effect::Kind;
    if (gap.kind == Gap::Kind::kFact) {
      const FactPattern& fact = gap.facts[0];
      return effect.kind == (fact.value ? Kind::kAdd : Kind::kDelete) && effect.predicate == fact.predicate &&
             fit(effect.terms, fact.objects, choices);
    }
    for (const Move& move : gap.moves) {
      if (!effect.is_numeric() || effect.function != move.function) continue;
      if (gap.kind == Gap::Kind::kValue && effect.kind != Kind::kAssign) continue;
      if (effect.kind == Kind::kIncrease || effect.kind == Kind::kDecrease) {
        const bool known = effect.value.kind == Expression::Kind::kConstant;
        const bool adds = effect.kind == Kind::kIncrease;
        const bool rises = !known || (adds ? effect.value.value > 0 : effect.value.value < 0);
        const bool falls = !known || (adds ? effect.value.value < 0 : effect.value.value > 0);
        if (!(move.up && rises) && !(move.down && falls)) continue;
      }
      Choices fitting = choices;
      if (!fit(effect.terms, move.objects, fitting)) continue;
      choices = std::move(fitting);
      return true;
    }
    return false;
  }

  void choose(const std::vector<Variable>& variables, Choices& choices) const {
    for (const Variable& variable : variables) choices[variable.slot] = objects_of(domain_, problem_, variable.types);
  }

  static void demand_all(const Condition& condition, const char* when, Maker& maker) {
    for_each_conjunct(condition, true,
                      [&](const Condition& part, bool wanted) { maker.demands.push_back({&part, wanted, when, {}}); });
  }

  Maker maker_of(const Action& action, const Effect& effect, Choices choices) {
    Maker maker{action.name, action.source, std::move(choices), {}, {}, {}, {}};
    const bool timed = action.durative;
    demand_all(action.condition.start, timed ? "at start" : "", maker);
    maker.conjunctions = {&action.condition.start, &action.condition.end};
    const std::set<int> read = [&] {
      std::set<int> slots;
      for (const DurationConstraint& duration : action.duration) note_slots(duration.bound, maker.choices, slots);
      return slots;
    }();
    const bool lasts =
        !judge_.any(read, maker.choices, [&](Frame& frame) { return !reach_.takes_time(action, frame); });
    if (timed && lasts) {
      demand_all(action.condition.over_all, "over all", maker);
      maker.conjunctions.push_back(&action.condition.over_all);
    }
    demand_all(action.condition.end, "at end", maker);
    for (const Condition* part : effect.condition.parts()) demand_all(*part, "for this effect", maker);
    for (const DurationConstraint& duration : action.duration)
      maker.demands.push_back({nullptr, true, "for its duration", duration.bound});
    for (const Effect& each : action.effects) {
      if (!each.is_numeric() || !each.condition.is_true() || !each.variables.empty()) continue;
      if (each.time == Effect::Time::kContinuous && !lasts) continue;
      maker.demands.push_back({nullptr, true, "for an effect", each.value});
      if (each.kind == Effect::Kind::kAssign) continue;
      Expression changed{Expression::Kind::kFunction, 0, each.function, each.terms, {}};
      maker.demands.push_back({nullptr, true, "for an effect", std::move(changed)});
    }
    return maker;
  }

  /// What the maker lacks; nothing if it seems to lack nothing.
  void find_lacks(Maker& maker, const std::vector<Variable>& parameters) {
    for (const Variable& variable : parameters)
      if (maker.choices[variable.slot].empty()) {
        maker.gaps.push_back(no_object(variable));
        maker.lacks = {1, 1};
        return;
      }
    for (const Demand& demand : maker.demands)
      if (judge_.is_impossible(demand, maker.choices)) {
        maker.lacks.first += judge_.is_fixed_relation(demand);
        ++maker.lacks.second;
        close(demand, maker.choices, maker.gaps);
      }
    if (!maker.gaps.empty()) return;
    const auto [nearest, lacks] = judge_.nearest_choice(maker.demands, maker.choices);
    maker.lacks = lacks;
    Frame frame = frame_of(nearest);
    for (const Demand& demand : maker.demands)
      if (!judge_.is_met(demand, frame)) close(demand, nearest, maker.gaps);
    if (!maker.gaps.empty()) return;
    for (const Condition* conjunction : maker.conjunctions)
      if (const auto apart = reach_.never_together(*conjunction, frame)) {
        maker.gaps.push_back(apart_gap(*apart));
        maker.lacks = {0, 1};
        return;
      }
  }

  void close(const Demand& demand, const Choices& choices, std::vector<Gap>& gaps) {
    if (demand.condition) {
      find_gaps(*demand.condition, demand.wanted, choices, demand.when, gaps);
    } else {
      gaps.push_back(value_gap(demand.value, choices));
      gaps.back().when = demand.when;
    }
  }

  std::vector<Maker> makers_of(const Gap& gap) {
    std::vector<Maker> makers;
    if (gap.kind == Gap::Kind::kTogether || gap.kind == Gap::Kind::kNever) return makers;
    for (const Action& action : domain_.actions) {
      std::optional<Maker> best;
      for (const Effect& effect : action.effects) {
        Choices choices(static_cast<std::size_t>(action.slots));
        choose(action.parameters, choices);
        choose(effect.variables, choices);
        if (!helps(effect, gap, choices)) continue;
        Maker maker = maker_of(action, effect, std::move(choices));
        name_variables(action.parameters, effect.variables,
                       {&action.condition.start, &action.condition.over_all, &action.condition.end});
        find_lacks(maker, action.parameters);
        if (!best || maker.lacks < best->lacks) best = std::move(maker);
      }
      if (best) makers.push_back(std::move(*best));
    }
    for (const Derivation& rule : domain_.derivations) {
      if (gap.kind != Gap::Kind::kFact || !gap.facts[0].value || rule.predicate != gap.facts[0].predicate) continue;
      Maker maker{"the rule of " + domain_.predicates[rule.predicate].name,
                  rule.source,
                  Choices(static_cast<std::size_t>(rule.slots)),
                  {},
                  {&rule.condition},
                  {},
                  {}};
      choose(rule.parameters, maker.choices);
      std::vector<Term> terms;
      for (const Variable& parameter : rule.parameters) terms.push_back(Term::variable(parameter.slot));
      if (!fit(terms, gap.facts[0].objects, maker.choices)) continue;
      demand_all(rule.condition, "", maker);
      name_variables(rule.parameters, {}, {&rule.condition});
      find_lacks(maker, rule.parameters);
      makers.push_back(std::move(maker));
    }
    std::ranges::stable_sort(makers, {}, &Maker::lacks);
    return makers;
  }

  // --- The chain

  static std::string key_of(const Gap& gap) {
    std::string key = std::to_string(static_cast<int>(gap.kind)) + gap.text;
    const auto add = [&key](const auto& objects) {
      for (const auto& any : objects) {
        key += '|';
        for (const ObjectId object : any) key += std::to_string(object) + ',';
      }
    };
    for (const FactPattern& fact : gap.facts) add(fact.objects);
    for (const Move& move : gap.moves) add(move.objects);
    return key;
  }

  static std::string verb_of(const Gap& gap) {
    if (gap.kind == Gap::Kind::kFact) return gap.facts[0].value ? "makes it true" : "makes it false";
    std::string text;
    for (const Move& move : gap.moves) {
      const char* verb = gap.kind == Gap::Kind::kValue ? "gives a value to "
                         : move.up && move.down        ? "changes "
                         : move.up                     ? "raises "
                                                       : "lowers ";
      text += (text.empty() ? "" : " or ") + (verb + move.name);
    }
    return text;
  }

  /// What the end of a chain says.
  std::string end_of(const Gap& gap) const {
    if (gap.kind == Gap::Kind::kNever) return gap.reason;
    if (gap.kind == Gap::Kind::kTogether) return "each alone can be, but never both at once";
    if (gap.kind != Gap::Kind::kFact) return "no action " + verb_of(gap) + initial_numbers(gap);
    const FactPattern& fact = gap.facts[0];
    const Predicate& predicate = domain_.predicates[fact.predicate];
    const bool one = is_fixed(fact.objects);
    if (!fact.value) return "no action makes " + std::string(one ? "it" : "any of them") + " false" + told(fact);
    std::vector<std::string> others;
    for (const Action& action : domain_.actions)
      if (std::ranges::any_of(action.effects, [&](const Effect& effect) {
            return effect.kind == Effect::Kind::kAdd && effect.predicate == fact.predicate;
          }))
        others.push_back(action.name);
    std::string text = "no action makes it true";
    if (predicate.derived)
      text = "no rule derives it";
    else if (!others.empty())
      text += " (" + some_of(others, kMostMakers) + (others.size() == 1 ? " makes" : " make") + " others of " +
              predicate.name + " true)";
    if (predicate.derived) return text;
    return text + told(fact) + nearest_initial(fact);
  }

  /// What the initial state says of it.
  std::string told(const FactPattern& fact) const {
    if (domain_.predicates[fact.predicate].derived) return "";
    const bool one = is_fixed(fact.objects);
    return ", and " + initial_ + (fact.value ? one ? " lacks it" : " has none" : one ? " has it" : " has them all");
  }

  /// A fact of the initial state that differs in one object: a name may be misspelt.
  std::string nearest_initial(const FactPattern& fact) const {
    for (const Fact& known : problem_.init) {
      if (known.predicate != fact.predicate) continue;
      std::size_t others = 0;
      for (std::size_t i = 0; i < known.objects.size(); ++i)
        others += std::ranges::find(fact.objects[i], known.objects[i]) == fact.objects[i].end();
      if (others == 1 && (known.objects.size() > 1 || is_fixed(fact.objects)))
        return "; nearest is " + ground_text(domain_.predicates[known.predicate].name, known.objects, problem_.objects);
    }
    return "";
  }

  std::string initial_numbers(const Gap& gap) const {
    std::string text;
    for (const Move& move : gap.moves) {
      if (!is_fixed(move.objects)) continue;
      std::vector<ObjectId> objects;
      for (const auto& one : move.objects) objects.push_back(one[0]);
      const std::optional<double> value = reach_.initial_value(move.function, objects);
      text += (text.empty() ? ", and in " + initial_ + " " : " and ") + move.name +
              (value ? " is " + number_text(*value) : " has no value");
    }
    if (text.empty() && gap.kind == Gap::Kind::kValue) return ", and in " + initial_ + " none has one";
    return text;
  }

  Cause cause_of(const Gap& gap) const {
    Cause cause;
    cause.condition = gap.text;
    cause.when = gap.when;
    cause.facts = gap.facts;
    cause.together = gap.kind == Gap::Kind::kTogether;
    return cause;
  }

  /// Adds the causes from `gap` on. False where every way leads back to what is asked for already; the first such way
  /// is kept as `circle_`.
  bool follow(const Gap& gap, OutOfReach& chain) {
    if (budget_.over() || chain.causes.size() > kMostCausesInSearch) return false;
    const std::string key = key_of(gap);
    Cause cause = cause_of(gap);
    if (!seen_.insert(key).second) {
      if (!circle_.causes.empty() || std::ranges::find(path_, key) == path_.end()) return false;
      cause.again = true;
      cause.end = "which is needed for itself" + (gap.kind == Gap::Kind::kFact ? told(gap.facts[0]) : "");
      circle_ = chain;
      circle_.causes.push_back(std::move(cause));
      return false;
    }
    const std::vector<Maker> makers = makers_of(gap);
    if (makers.empty()) {
      cause.end = end_of(gap);
      chain.causes.push_back(std::move(cause));
      return true;
    }
    cause.verb = verb_of(gap);
    for (const Maker& maker : makers) cause.makers.push_back(maker.name);
    path_.push_back(key);
    chain.causes.push_back(std::move(cause));
    for (const Maker& maker : makers) {
      // A circle says more than one that could not help with these objects at all.
      if (maker.lacks.first > makers[0].lacks.first && !circle_.causes.empty()) break;
      Cause& here = chain.causes.back();
      here.followed = maker.name;
      here.at = place(maker.source);
      for (const Gap& next : maker.gaps)
        if (follow(next, chain)) {
          path_.pop_back();
          return true;
        }
    }
    path_.pop_back();
    if (gap.kind == Gap::Kind::kNumber &&
        std::ranges::any_of(makers, [](const Maker& one) { return one.gaps.empty(); })) {
      chain.causes.back().end =
          "what " + some_of(chain.causes.back().makers, kMostMakers) + " can do to it is not enough";
      return true;
    }
    chain.causes.pop_back();
    return false;
  }

  const Domain& domain_;
  const Problem& problem_;
  Budget& budget_;
  const Reach reach_;
  ChoiceJudge judge_;
  const std::string initial_;
  ById<std::string> variables_;    ///< by slot, of the action that is looked at
  std::set<std::string> seen_;     ///< gaps that have been followed
  std::vector<std::string> path_;  ///< from the goal to here
  OutOfReach circle_;
};

/// What brings a cause about, and what that needs.
std::string makers_text(const Cause& cause, const Cause& next) {
  const std::string place = cause.followed + " (" + cause.at + ")";
  const std::string needs = " and needs " + next.condition + (next.when.empty() ? "" : ' ' + next.when);
  if (cause.makers.size() == 1) return "only " + place + ' ' + cause.verb + ',' + needs;
  return "each of " + some_of(cause.makers, kMostMakers) + ' ' + cause.verb + "; " + place + " comes closest," + needs;
}

}  // namespace

std::string OutOfReach::text() const {
  if (causes.empty()) return "";
  if (causes[0].together) return "the goal is out of reach: it asks for " + causes[0].condition + "; " + causes[0].end;
  std::string text = causes[0].condition.starts_with('(')
                         ? "the goal " + causes[0].condition + " is out of reach: "
                         : "the goal is out of reach: it needs " + causes[0].condition + "; ";
  const std::size_t links = causes.size() - 1, half = kMostCauses / 2;
  for (std::size_t i = 0; i < links; ++i) {
    if (links > kMostCauses && i == half) {
      i = links - half;
      text += "; ... and so on to " + causes[i].condition;
    }
    text += (i > 0 ? "; " : "") + makers_text(causes[i], causes[i + 1]);
  }
  const Cause& last = causes.back();
  return text + (last.again ? ", " : links > 0 ? "; " : "") + last.end;
}

std::optional<OutOfReach> explain_out_of_reach(const Task& task, Budget& budget, std::string_view initial) {
  const Expected<Reachable> reachable = find_reachable(task, kMostActions, budget);
  if (!reachable) return std::nullopt;
  if (auto found = Explainer(task, *reachable, budget, nullptr, initial).run()) return found;
  if (budget.over()) return std::nullopt;
  const Expected<GroundTask> ground = ground_by_facts(task, budget);
  if (!ground || ground->proved_unsolvable) return std::nullopt;
  Possible possible = possible_by_pairs(*ground, budget);
  if (budget.over() || possible.together.words == 0) return std::nullopt;
  const PairJudge pairs(*ground, std::move(possible.together));
  return Explainer(task, *reachable, budget, &pairs, initial).run();
}

}  // namespace cxlab::planner
