#include "planner/state/state.h"

#include <algorithm>
#include <cmath>

#include "planner/state/number.h"

namespace cxlab::planner {

State::State(const Domain& domain) {
  for (const Predicate& predicate : domain.predicates) derived_.push_back(predicate.derived);
}

State::State(const Domain& domain, const Problem& problem) : State(domain) {
  for (const Fact& fact : problem.init) set(fact.predicate, fact.objects, true);
  for (const Assignment& assignment : problem.values)
    set_value(assignment.function, assignment.objects, assignment.value);
}

bool State::holds(PredicateId predicate, std::span<const ObjectId> objects) const {
  const int atom = atoms_.find(predicate, objects);
  return atom >= 0 && since_[atom] != 0;
}

void State::set(PredicateId predicate, std::span<const ObjectId> objects, bool value) {
  int atom = atoms_.find(predicate, objects);
  if (value == (atom >= 0 && since_[atom] != 0)) return;
  if (atom < 0) {
    atom = atoms_.insert(predicate, objects);
    since_.push_back(0);
    if (derived_[predicate]) derived_atoms_.push_back(atom);
  }
  since_[atom] = value ? ++changes_ : 0;
}

void State::clear_derived() {
  for (const int atom : derived_atoms_) since_[atom] = 0;
}

std::optional<double> State::value(FunctionId function, std::span<const ObjectId> objects) const {
  const int found = functions_.find(function, objects);
  if (found < 0) return std::nullopt;
  return numbers_[found].after(ahead_);
}

void State::set_value(FunctionId function, std::span<const ObjectId> objects, double value) {
  const int found = functions_.insert(function, objects);
  if (found < static_cast<int>(numbers_.size()))
    numbers_[found].value = value;
  else
    numbers_.push_back({value, 0});
}

double State::rate(FunctionId function, std::span<const ObjectId> objects) const {
  const int found = functions_.find(function, objects);
  return found < 0 ? 0 : numbers_[found].rate;
}

void State::add_rate(FunctionId function, std::span<const ObjectId> objects, double rate) {
  const int found = functions_.find(function, objects);
  if (found < 0) return;
  numbers_[found].rate = sum(numbers_[found].rate, rate);
  if (std::ranges::find(changing_, found) == changing_.end()) changing_.push_back(found);
}

void State::clear_rates() {
  for (const int changing : changing_) numbers_[changing].rate = 0;
  changing_.clear();
}

double State::Number::after(double seconds) const { return seconds == 0 ? value : sum(value, product(rate, seconds)); }

void State::advance(double seconds) {
  for (const int changing : changing_) numbers_[changing].value = numbers_[changing].after(seconds);
}

std::vector<Fact> State::facts() const {
  std::vector<std::pair<std::uint64_t, int>> in_order;
  for (int atom = 0; atom < atoms_.size(); ++atom)
    if (since_[atom] != 0) in_order.push_back({since_[atom], atom});
  std::ranges::sort(in_order);
  std::vector<Fact> all;
  for (const auto& [since, atom] : in_order) {
    const std::span<const ObjectId> objects = atoms_.objects(atom);
    all.push_back({atoms_.predicate(atom), {objects.begin(), objects.end()}});
  }
  return all;
}

std::vector<Assignment> State::values() const {
  std::vector<Assignment> all;
  for (int each = 0; each < functions_.size(); ++each) {
    const std::span<const ObjectId> objects = functions_.objects(each);
    const Number& number = numbers_[each];
    all.push_back({functions_.predicate(each), {objects.begin(), objects.end()}, number.after(ahead_)});
  }
  return all;
}

bool apply_changes(const std::vector<Change>& changes, State& state) {
  for (const Change& change : changes)
    if (change.kind == Effect::Kind::kDelete) state.set(change.id, change.objects, false);
  for (const Change& change : changes)
    if (change.kind == Effect::Kind::kAdd) state.set(change.id, change.objects, true);
  for (const Change& change : changes) {
    if (change.kind == Effect::Kind::kAdd || change.kind == Effect::Kind::kDelete) continue;
    double value = change.value;
    if (change.kind != Effect::Kind::kAssign) {
      const auto before = state.value(change.id, change.objects);
      if (!before) return false;
      if (change.kind == Effect::Kind::kIncrease) value = sum(*before, change.value);
      if (change.kind == Effect::Kind::kDecrease) value = difference(*before, change.value);
      if (change.kind == Effect::Kind::kScaleUp) value = product(*before, change.value);
      if (change.kind == Effect::Kind::kScaleDown) value = quotient(*before, change.value);
    }
    if (!std::isfinite(value)) return false;
    state.set_value(change.id, change.objects, value);
  }
  return true;
}

}  // namespace cxlab::planner
