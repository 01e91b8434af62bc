#include "planner/search/landmarks.h"

#include <algorithm>
#include <deque>
#include <iterator>
#include <utility>

namespace cxlab::planner {

namespace {

constexpr std::size_t kLookEvery = 256;  ///< operators between two looks at the clock

std::size_t words_of(const RelaxedTask& relaxed) { return (static_cast<std::size_t>(relaxed.atoms()) + 63) / 64; }

/// Work of looking once at each operator.
std::int64_t one_round(const RelaxedTask& relaxed) {
  std::size_t lists = 0;
  for (const RelaxedOperator& op : relaxed.operators())
    lists += op.conditions.size() + op.adds.size() + op.gains.size();
  return static_cast<std::int64_t>(lists * words_of(relaxed));
}

/// By atom, the atoms that are true before it in every relaxed plan, and itself; computed by propagation.
class Propagation {
 public:
  Propagation(const Simulator& simulator, const RelaxedTask& relaxed)
      : relaxed_(relaxed),
        atoms_(static_cast<std::size_t>(relaxed.atoms())),
        words_(words_of(relaxed)),
        sets_(atoms_ * words_, 0),
        initially_(atoms_, 0),
        missing_(relaxed.operators().size(), 0),
        queued_(relaxed.operators().size(), 0),
        before_(words_) {
    const GroundTask& task = simulator.task();
    const PackedState initial = simulator.initial();
    for (int f = 0; f < relaxed.facts(); ++f)
      initially_[f] = is_set(initial.data(), f) || (task.facts[f].derived && task.facts[f].is_complement);
    for (std::size_t c = 0; c < task.comparisons.size(); ++c)
      initially_[static_cast<std::size_t>(relaxed.facts()) + c] =
          task.comparisons[c].holds(simulator.numbers(initial.data()));
    known_ = initially_;
  }

  /// False if it takes more than `most_work` or the time runs out.
  bool run(std::int64_t most_work, Budget& budget, std::int64_t& work) {
    const auto& operators = relaxed_.operators();
    for (std::size_t o = 0; o < operators.size(); ++o) {
      missing_[o] = static_cast<int>(std::ranges::count_if(operators[o].conditions, [&](int c) { return !known_[c]; }));
      if (missing_[o] == 0) queue(static_cast<int>(o));
    }
    for (std::size_t looked = 0; !queue_.empty(); ++looked) {
      if (looked % kLookEvery == 0 && budget.late()) return false;
      const RelaxedOperator& op = operators[queue_.front()];
      queued_[queue_.front()] = 0;
      queue_.pop_front();
      if (work > most_work) return false;
      std::ranges::fill(before_, 0);
      for (const int condition : op.conditions) unite(condition, before_);
      work += static_cast<std::int64_t>((op.conditions.size() + op.adds.size() + 1) * words_);
      for_each_reached(op, [this](int atom) { reach(atom); });
    }
    return true;
  }

  /// The landmarks of all parts of the goal, ascending.
  std::vector<int> of_goal() const {
    std::vector<Word> all(words_, 0);
    for (const int atom : relaxed_.goal()) {
      set(all.data(), atom);
      unite(atom, all);
    }
    std::vector<int> found;
    for (int atom = 0; atom < relaxed_.atoms(); ++atom)
      if (is_set(all.data(), atom)) found.push_back(atom);
    return found;
  }

  /// By atom: those of `landmarks` that every operator which can be first to reach it has as a condition.
  ById<std::vector<int>> needed_directly(const std::vector<int>& landmarks) const {
    ById<char> is_landmark(atoms_, 0), seen(atoms_, 0);
    for (const int atom : landmarks) is_landmark[atom] = 1;
    ById<std::vector<int>> common(atoms_);
    for (const RelaxedOperator& op : relaxed_.operators())
      for_each_reached(op, [&](int atom) {
        if (!is_landmark[atom] || initially_[atom]) return;
        for (const int condition : op.conditions)
          if (!known_[condition] || is_set(of(condition), atom)) return;
        if (std::exchange(seen[atom], 1) == 0)
          std::ranges::copy_if(op.conditions, std::back_inserter(common[atom]), [&](int c) { return is_landmark[c]; });
        else
          std::erase_if(common[atom],
                        [&](int c) { return std::ranges::find(op.conditions, c) == op.conditions.end(); });
      });
    return common;
  }

 private:
  template <class Visit>
  static void for_each_reached(const RelaxedOperator& op, const Visit& visit) {
    for (const int fact : op.adds) visit(fact);
    for (const RelaxedOperator::Gain& gain : op.gains) visit(gain.atom);
  }

  const Word* of(int atom) const { return &sets_[static_cast<std::size_t>(atom) * words_]; }

  void unite(int atom, std::vector<Word>& into) const {
    for (std::size_t w = 0; w < words_; ++w) into[w] |= of(atom)[w];
  }

  void queue(int op) {
    if (std::exchange(queued_[op], 1) == 0) queue_.push_back(op);
  }

  /// An operator reaches an atom after `before_`.
  void reach(int atom) {
    if (initially_[atom]) return;
    Word* own = &sets_[static_cast<std::size_t>(atom) * words_];
    bool changed = !known_[atom];
    for (std::size_t w = 0; w < words_; ++w) {
      Word next = known_[atom] ? own[w] & before_[w] : before_[w];
      if (static_cast<std::size_t>(atom >> 6) == w) next |= Word{1} << (atom & 63);
      changed = changed || next != own[w];
      own[w] = next;
    }
    if (!changed) return;
    for (const int reader : relaxed_.readers(atom)) {
      if (!known_[atom]) --missing_[reader];
      if (missing_[reader] == 0) queue(reader);
    }
    known_[atom] = 1;
  }

  const RelaxedTask& relaxed_;
  const std::size_t atoms_, words_;
  ById<Word> sets_;
  ById<char> initially_, known_;
  ById<int> missing_;  ///< by operator: conditions that are not known
  ById<char> queued_;
  std::deque<int> queue_;
  std::vector<Word> before_;
};

}  // namespace

Landmarks::Landmarks(const Simulator& simulator, const RelaxedTask& relaxed, std::int64_t most_work, Budget& budget)
    : simulator_(simulator), facts_(relaxed.facts()) {
  if (3 * one_round(relaxed) > most_work) return;
  Propagation propagation(simulator, relaxed);
  if (!propagation.run(most_work, budget, work_)) return;
  atoms_ = ById<int>(propagation.of_goal());
  ById<int> index(static_cast<std::size_t>(relaxed.atoms()), -1);
  for (std::size_t l = 0; l < atoms_.size(); ++l) index[atoms_[l]] = static_cast<int>(l);
  goal_.assign(atoms_.size(), 0);
  for (const int atom : relaxed.goal()) goal_[index[atom]] = 1;
  needed_by_.resize(atoms_.size());
  const ById<std::vector<int>> needed = propagation.needed_directly(atoms_);
  for (const int atom : atoms_)
    for (const int before : needed[atom])
      if (before != atom) needed_by_[index[before]].push_back(index[atom]);
}

bool Landmarks::holds(int landmark, const Word* state) const {
  const int atom = atoms_[landmark];
  return atom < facts_ ? is_set(state, atom)
                       : simulator_.task().comparisons[atom - facts_].holds(simulator_.numbers(state));
}

void Landmarks::mark(const Word* state, Word* reached) const {
  for (int l = 0; l < count(); ++l)
    if (!is_set(reached, l) && holds(l, state)) set(reached, l);
}

int Landmarks::remaining(const Word* state, const Word* reached) const {
  int left = 0;
  for (int l = 0; l < count(); ++l) {
    if (!is_set(reached, l)) {
      ++left;
      continue;
    }
    const auto missing = [&](int next) { return !is_set(reached, next); };
    if ((goal_[l] || std::ranges::any_of(needed_by_[l], missing)) && !holds(l, state)) ++left;
  }
  return left;
}

}  // namespace cxlab::planner
