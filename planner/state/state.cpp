#include "planner/state/state.h"

#include <cmath>

namespace cxlab::planner {

State::State(const Domain& domain, const Problem& problem) : State(domain) {
  for (const Fact& fact : problem.init) set(fact.predicate, fact.objects, true);
  for (const Assignment& assignment : problem.values)
    set_value(assignment.function, assignment.objects, assignment.value);
}

bool State::holds(PredicateId predicate, std::span<const ObjectId> objects) const {
  const auto& table = facts_[predicate];
  return table.find(objects) != table.end();
}

void State::set(PredicateId predicate, std::span<const ObjectId> objects, bool value) {
  auto& table = facts_[predicate];
  const auto found = table.find(objects);
  if (value == (found != table.end())) return;
  if (value) {
    table.emplace(std::vector<ObjectId>(objects.begin(), objects.end()), ++changes_);
  } else {
    table.erase(found);
  }
}

const State::Number* State::number(FunctionId function, std::span<const ObjectId> objects) const {
  const auto& table = numbers_[function];
  const auto found = table.find(objects);
  return found == table.end() ? nullptr : &found->second;
}

std::optional<double> State::value(FunctionId function, std::span<const ObjectId> objects) const {
  const Number* found = number(function, objects);
  if (found == nullptr) return std::nullopt;
  return found->value + found->rate * ahead_;
}

void State::set_value(FunctionId function, std::span<const ObjectId> objects, double value) {
  auto& table = numbers_[function];
  const auto found = table.find(objects);
  if (found != table.end()) {
    found->second.value = value;
  } else {
    table.emplace(std::vector<ObjectId>(objects.begin(), objects.end()), Number{value, 0, ++changes_});
  }
}

double State::rate(FunctionId function, std::span<const ObjectId> objects) const {
  const Number* found = number(function, objects);
  return found == nullptr ? 0 : found->rate;
}

void State::add_rate(FunctionId function, std::span<const ObjectId> objects, double rate) {
  auto& table = numbers_[function];
  const auto found = table.find(objects);
  if (found == table.end()) return;
  found->second.rate += rate;
  changing_.push_back({function, {objects.begin(), objects.end()}});
}

void State::clear_rates() {
  for (const Fact& changing : changing_) {
    const auto found = numbers_[changing.predicate].find(std::span<const ObjectId>(changing.objects));
    if (found != numbers_[changing.predicate].end()) found->second.rate = 0;
  }
  changing_.clear();
}

void State::advance(double seconds) {
  std::vector<Number*> moved;
  for (const Fact& changing : changing_) {
    auto& table = numbers_[changing.predicate];
    const auto found = table.find(std::span<const ObjectId>(changing.objects));
    if (found == table.end() || std::find(moved.begin(), moved.end(), &found->second) != moved.end()) continue;
    found->second.value += found->second.rate * seconds;
    moved.push_back(&found->second);
  }
}

namespace {

template <class Item>
std::vector<Item> in_order(std::vector<std::pair<std::uint64_t, Item>> items) {
  std::ranges::sort(items, {}, [](const auto& item) { return item.first; });
  std::vector<Item> ordered;
  ordered.reserve(items.size());
  for (auto& [_, item] : items) ordered.push_back(std::move(item));
  return ordered;
}

}  // namespace

std::vector<Fact> State::facts() const {
  std::vector<std::pair<std::uint64_t, Fact>> all;
  for (std::size_t predicate = 0; predicate < facts_.size(); ++predicate)
    for (const auto& [objects, order] : facts_[predicate])
      all.push_back({order, {static_cast<PredicateId>(predicate), objects}});
  return in_order(std::move(all));
}

std::vector<Assignment> State::values() const {
  std::vector<std::pair<std::uint64_t, Assignment>> all;
  for (std::size_t function = 0; function < numbers_.size(); ++function)
    for (const auto& [objects, entry] : numbers_[function])
      all.push_back({entry.order, {static_cast<FunctionId>(function), objects, entry.value + entry.rate * ahead_}});
  return in_order(std::move(all));
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
      if (change.kind == Effect::Kind::kIncrease) value = *before + change.value;
      if (change.kind == Effect::Kind::kDecrease) value = *before - change.value;
      if (change.kind == Effect::Kind::kScaleUp) value = *before * change.value;
      if (change.kind == Effect::Kind::kScaleDown) value = *before / change.value;
    }
    if (!std::isfinite(value)) return false;
    state.set_value(change.id, change.objects, value);
  }
  return true;
}

Objects::Objects(const std::vector<Term>& terms, const Frame& frame) : size_(terms.size()) {
  if (size_ > kFew) many_.resize(size_);
  ObjectId* out = size_ > kFew ? many_.data() : few_;
  for (const Term& term : terms) *out++ = term.in(frame);
}

}  // namespace cxlab::planner
