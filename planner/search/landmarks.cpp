#include "planner/search/landmarks.h"

#include <algorithm>
#include <deque>

namespace cxlab::planner {

namespace {

constexpr std::size_t kLookEvery = 256;  ///< operators between two looks at the clock

}  // namespace

Landmarks::Landmarks(const Simulator& simulator, const RelaxedTask& relaxed, std::int64_t most_work, Budget& budget)
    : simulator_(simulator), facts_(relaxed.facts()) {
  const PackedState initial = simulator.initial();
  const std::size_t atoms = static_cast<std::size_t>(relaxed.atoms()), words = (atoms + 63) / 64;
  const auto& operators = relaxed.operators();
  std::int64_t one_round = 0;
  for (const RelaxedOperator& op : operators)
    one_round += static_cast<std::int64_t>((op.conditions.size() + op.adds.size() + op.gains.size()) * words);
  if (3 * one_round > most_work) return;

  std::vector<Word> sets(atoms * words, 0);
  ById<char> known(atoms, 0), initially(atoms, 0), queued(operators.size(), 0);
  for (int f = 0; f < relaxed.facts(); ++f)
    initially[f] =
        is_set(initial.data(), f) || (simulator.task().facts[f].derived && simulator.task().facts[f].is_complement);
  for (std::size_t c = 0; c < simulator.task().comparisons.size(); ++c)
    initially[static_cast<std::size_t>(relaxed.facts()) + c] =
        simulator.task().comparisons[c].holds(simulator.numbers(initial.data()));
  for (std::size_t a = 0; a < atoms; ++a)
    if (initially[a]) known[a] = 1;
  std::deque<int> queue;
  ById<int> missing(operators.size(), 0);
  for (std::size_t o = 0; o < operators.size(); ++o) {
    missing[o] = static_cast<int>(std::ranges::count_if(operators[o].conditions, [&](int c) { return !known[c]; }));
    if (missing[o] == 0) {
      queue.push_back(static_cast<int>(o));
      queued[o] = 1;
    }
  }
  std::vector<Word> before(words);
  for (std::size_t looked = 0; !queue.empty(); ++looked) {
    if (looked % kLookEvery == 0 && budget.late()) return;
    const int o = queue.front();
    queue.pop_front();
    queued[o] = 0;
    if (work_ > most_work) return;
    std::ranges::fill(before, 0);
    for (const int condition : operators[o].conditions)
      for (std::size_t w = 0; w < words; ++w) before[w] |= sets[static_cast<std::size_t>(condition) * words + w];
    work_ += static_cast<std::int64_t>((operators[o].conditions.size() + operators[o].adds.size() + 1) * words);
    const auto reach = [&](int atom) {
      if (initially[atom]) return;
      Word* own = &sets[static_cast<std::size_t>(atom) * words];
      bool changed = !known[atom];
      if (!known[atom]) {
        std::copy(before.begin(), before.end(), own);
        set(own, atom);
      } else {
        for (std::size_t w = 0; w < words; ++w) {
          Word next = own[w] & before[w];
          if (static_cast<std::size_t>(atom >> 6) == w) next |= Word{1} << (atom & 63);
          if (next != own[w]) {
            own[w] = next;
            changed = true;
          }
        }
      }
      if (!changed) return;
      for (const int reader : relaxed.readers(atom)) {
        if (!known[atom]) --missing[reader];
        if (missing[reader] == 0 && !queued[reader]) {
          queue.push_back(reader);
          queued[reader] = 1;
        }
      }
      known[atom] = 1;
    };
    for (const int fact : operators[o].adds) reach(fact);
    for (const RelaxedOperator::Gain& gain : operators[o].gains) reach(gain.atom);
  }

  std::vector<Word> all(words, 0);
  for (const int atom : relaxed.goal()) {
    set(all.data(), atom);
    for (std::size_t w = 0; w < words; ++w) all[w] |= sets[static_cast<std::size_t>(atom) * words + w];
  }
  ById<int> index(atoms, -1);
  for (std::size_t a = 0; a < atoms; ++a) {
    if (!is_set(all.data(), static_cast<int>(a))) continue;
    index[a] = static_cast<int>(atoms_.size());
    atoms_.push_back(static_cast<int>(a));
  }
  goal_.assign(atoms_.size(), 0);
  for (const int atom : relaxed.goal()) goal_[index[atom]] = 1;
  // l is needed directly before m if every operator that can be first to reach m has l as a condition.
  needed_by_.resize(atoms_.size());
  ById<std::vector<int>> common(atoms);
  ById<char> seen(atoms, 0);
  for (const RelaxedOperator& op : operators) {
    const auto first = [&](int atom) {
      if (index[atom] < 0 || initially[atom]) return;
      for (const int condition : op.conditions)
        if (!known[condition] || is_set(&sets[static_cast<std::size_t>(condition) * words], atom)) return;
      if (!seen[atom]) {
        seen[atom] = 1;
        for (const int condition : op.conditions)
          if (index[condition] >= 0) common[atom].push_back(condition);
      } else {
        std::erase_if(common[atom], [&](int c) { return std::ranges::find(op.conditions, c) == op.conditions.end(); });
      }
    };
    for (const int fact : op.adds) first(fact);
    for (const RelaxedOperator::Gain& gain : op.gains) first(gain.atom);
  }
  for (const int atom : atoms_)
    for (const int before_it : common[atom])
      if (before_it != atom) needed_by_[index[before_it]].push_back(index[atom]);
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
