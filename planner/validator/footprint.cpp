#include "planner/validator/footprint.h"

#include <algorithm>

#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

constexpr std::int64_t kOfAFact = 50;  ///< combinations that cost as much as one that stays in memory

const Fact* common(const std::vector<Fact>& a, const std::vector<Fact>& b) {
  for (const Fact& fact : a)
    if (std::ranges::find(b, fact) != b.end()) return &fact;
  return nullptr;
}

}  // namespace

const Fact* Footprint::derived_from(ById<char> Symbols::* kind, const std::vector<Fact>& facts) const {
  for (const Fact& fact : facts)
    for (const PredicateId derived : derived_reads_)
      if ((validator_->bases(derived).*kind)[fact.predicate]) return &fact;
  return nullptr;
}

void Footprint::read(const Condition& condition, Frame& frame) {
  if (condition.kind == Condition::Kind::kAtom) gather_atom(condition, frame);
  for (const Expression& side : condition.sides) read(side, frame);
  const Evaluator& evaluator = validator_->evaluator();
  evaluator.each_binding(condition.variables, frame, [&] {
    for (const Condition& operand : condition.operands) read(operand, frame);
    return condition.variables.empty() || evaluator.spend(kOfAFact);
  });
}

void Footprint::read(const Expression& expression, const Frame& frame) {
  if (expression.kind == Expression::Kind::kFunction && validator_->fluents().functions[expression.function]) {
    const Objects objects(expression.terms, frame);
    number_reads_.push_back({expression.function, {objects.begin(), objects.end()}});
  }
  for (const Expression& operand : expression.operands) read(operand, frame);
}

Footprint::Known Footprint::gather_atom(const Condition& condition, Frame& frame) {
  const Predicate& predicate = validator_->evaluator().domain().predicates[condition.predicate];
  const Objects objects(condition.terms, frame);
  if (predicate.derived) {
    derived_reads_.push_back(condition.predicate);
    return {};
  }
  if (!validator_->fluents().predicates[condition.predicate])
    return validator_->initial().holds(condition.predicate, objects);
  reads_.push_back({condition.predicate, {objects.begin(), objects.end()}});
  return {};
}

/// Conditions that one known operand decides: all of the operands, with each binding, count alike.
Footprint::Known Footprint::gather_many(const Condition& condition, Frame& frame) {
  using Kind = Condition::Kind;
  const bool any = condition.kind == Kind::kOr || condition.kind == Kind::kExists || condition.kind == Kind::kImply;
  bool open = false;
  const bool undecided = validator_->evaluator().each_binding(condition.variables, frame, [&] {
    for (std::size_t i = 0; i < condition.operands.size(); ++i) {
      Known known = gather(condition.operands[i], frame);
      if (known && condition.kind == Kind::kImply && i == 0) known = !*known;
      if (known == any) return false;
      open = open || !known;
    }
    return condition.variables.empty() || validator_->evaluator().spend(kOfAFact);
  });
  if (!undecided) return any;
  return open ? Known() : !any;
}

Footprint::Known Footprint::gather(const Condition& condition, Frame& frame) {
  using Kind = Condition::Kind;
  if (condition.kind == Kind::kAtom) return gather_atom(condition, frame);
  if (condition.kind == Kind::kSame) {
    const Objects both(condition.terms, frame);
    return both.begin()[0] == both.begin()[1];
  }
  if (condition.kind == Kind::kCompare) {
    for (const Expression& side : condition.sides) read(side, frame);
    return {};
  }
  if (condition.kind == Kind::kNot) {
    const Known known = gather(condition.operands[0], frame);
    return known ? Known(!*known) : known;
  }
  const std::size_t reads = reads_.size(), number_reads = number_reads_.size(), derived_reads = derived_reads_.size();
  const Known known = gather_many(condition, frame);
  if (known) {
    reads_.resize(reads);
    number_reads_.resize(number_reads);
    derived_reads_.resize(derived_reads);
  }
  return known;
}

void Footprint::write(const std::vector<Change>& changes) {
  for (const Change& change : changes) {
    Fact fact{change.id, change.objects};
    switch (change.kind) {
      case Effect::Kind::kAdd: adds_.push_back(std::move(fact)); break;
      case Effect::Kind::kDelete: deletes_.push_back(std::move(fact)); break;
      case Effect::Kind::kIncrease:
      case Effect::Kind::kDecrease: increased_.push_back(std::move(fact)); break;
      default: assigned_.push_back(std::move(fact));
    }
  }
}

std::string Footprint::one_way(const Footprint& reader, const Footprint& writer) {
  const Domain& domain = reader.validator_->evaluator().domain();
  const auto text = [&](const Fact& fact, const auto& declarations) {
    return ground_text(declarations[fact.predicate].name, fact.objects,
                       reader.validator_->evaluator().problem().objects);
  };
  for (const auto* written : {&writer.adds_, &writer.deletes_}) {
    if (const Fact* fact = common(reader.reads_, *written)) return text(*fact, domain.predicates);
    if (const Fact* fact = reader.derived_from(&Symbols::predicates, *written)) return text(*fact, domain.predicates);
  }
  if (const Fact* fact = common(reader.adds_, writer.deletes_)) return text(*fact, domain.predicates);
  for (const auto* written : {&writer.assigned_, &writer.increased_}) {
    if (const Fact* fact = common(reader.number_reads_, *written)) return text(*fact, domain.functions);
    if (const Fact* fact = reader.derived_from(&Symbols::functions, *written)) return text(*fact, domain.functions);
    if (const Fact* fact = common(reader.assigned_, *written)) return text(*fact, domain.functions);
  }
  return {};
}

std::string Footprint::interference(const Footprint& a, const Footprint& b) {
  std::string name = one_way(a, b);
  return name.empty() ? one_way(b, a) : name;
}

}  // namespace cxlab::planner
