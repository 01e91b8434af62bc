#include "planner/ground/passes.h"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

namespace cxlab::planner {

namespace {

constexpr std::size_t kMostFacts = 1500;
constexpr std::size_t kWordsOfWork = 200;  ///< words of rows that take as long as one piece of Work::kGround

/// What one happening needs, adds and surely removes.
struct Operator {
  std::vector<int> needs, adds, removes;
  int looked_at = -1;  ///< the time of the last look at it: nothing is new unless a row of its needs has changed since
};

class Pairs {
 public:
  Pairs(const GroundTask& task, Budget& budget)
      : facts_(task.facts.size() + task.actions.size()),
        words_((facts_ + 63) / 64),
        rows_(facts_ * words_, 0),
        alone_(words_, 0),
        changed_(facts_, 0) {
    std::vector<int> initial;
    for (std::size_t f = 0; f < task.facts.size(); ++f)
      if (task.initial_facts[f]) initial.push_back(static_cast<int>(f));
    for (const int a : initial) {
      set(alone_.data(), a);
      for (const int b : initial) set(row(a), b);
    }
    for (std::size_t a = 0; a < task.actions.size(); ++a) add_operators(task, static_cast<int>(a));
    for (const TimedEvent& event : task.events) operators_.push_back({{}, event.effects.add, event.effects.remove});
    std::size_t words = 0;
    for (bool changed = true; changed;) {
      changed = false;
      for (Operator& op : operators_) {
        words += 1 + op.needs.size();
        if (has_news(op) && reachable(op.needs)) {
          if (apply(op)) changed = true;
          words += (op.needs.size() + op.adds.size() + 1) * words_;
        }
        op.looked_at = now_++;
        if (words < kWordsOfWork) continue;
        budget.spend(Work::kGround, static_cast<std::int64_t>(words / kWordsOfWork));
        words %= kWordsOfWork;
        if (budget.over()) return;
      }
    }
  }

  bool reachable(const std::vector<int>& facts) const {
    for (std::size_t i = 0; i < facts.size(); ++i)
      for (std::size_t j = i; j < facts.size(); ++j)
        if (!is_set(row(facts[i]), facts[j])) return false;
    return true;
  }

  Together together() && { return {words_, std::move(rows_)}; }

 private:
  /// Its own effects are no news to it: they are in what it left possible.
  bool has_news(const Operator& op) const {
    if (op.needs.empty()) return last_change_ > op.looked_at;
    return std::ranges::any_of(op.needs, [&](int need) { return changed_[need] > op.looked_at; });
  }

  Word* row(int fact) { return &rows_[static_cast<std::size_t>(fact) * words_]; }
  const Word* row(int fact) const { return &rows_[static_cast<std::size_t>(fact) * words_]; }

  /// That an action has begun is a fact that nothing removes: it may end at any time, and several may run.
  void add_operators(const GroundTask& task, int index) {
    const GroundAction& action = task.actions[index];
    const int begun = static_cast<int>(task.facts.size()) + index;
    Operator begin{action.start.facts, action.at_start.add, action.at_start.remove};
    if (action.durative) begin.adds.push_back(begun);
    Operator end{action.end.facts, action.at_end.add, action.at_end.remove};
    end.needs.push_back(begun);
    for (const ConditionalEffects& conditional : action.conditional) {
      // An effect whose condition does not hold removes nothing. A conditional addition joins the other additions of
      // its happening, so everything that the happening needs can be true beside it.
      for (auto [op, when, effects] : {std::tuple{&begin, &conditional.start, &conditional.at_start},
                                       {&end, &conditional.end, &conditional.at_end}}) {
        if (effects->add.empty()) continue;
        Operator extra{op->needs, effects->add, {}};
        extra.needs.insert(extra.needs.end(), when->facts.begin(), when->facts.end());
        operators_.push_back(std::move(extra));
        std::erase_if(op->removes, [&add = effects->add](int f) { return std::ranges::find(add, f) != add.end(); });
      }
    }
    operators_.push_back(std::move(begin));
    if (action.durative) operators_.push_back(std::move(end));
  }

  bool apply(const Operator& op) {
    // What can be true beside: reachable with every need, and not removed.
    if (op.needs.empty()) {
      beside_ = alone_;
    } else {
      beside_.assign(row(op.needs[0]), row(op.needs[0]) + words_);
      for (const int need : op.needs)
        for (std::size_t w = 0; w < words_; ++w) beside_[w] &= row(need)[w];
    }
    for (const int f : op.removes) reset(beside_.data(), f);
    for (const int f : op.adds) set(beside_.data(), f);
    bool changed = false;
    for (const int added : op.adds) {
      set(alone_.data(), added);
      for (std::size_t w = 0; w < words_; ++w) {
        Word fresh = beside_[w] & ~row(added)[w];
        if (!fresh) continue;
        changed = true;
        row(added)[w] |= fresh;
        changed_[added] = last_change_ = now_;
        for (; fresh; fresh &= fresh - 1) {
          const int other = static_cast<int>(w * 64 + static_cast<std::size_t>(std::countr_zero(fresh)));
          set(row(other), added);
          changed_[other] = now_;
        }
      }
    }
    return changed;
  }

  const std::size_t facts_, words_;
  std::vector<Word> rows_;   ///< by fact: with which others it can be true
  std::vector<Word> alone_;  ///< what can be true at all
  ById<int> changed_;        ///< by fact: the time of the last change of its row
  int now_ = 0, last_change_ = 0;
  std::vector<Operator> operators_;
  std::vector<Word> beside_;  ///< used by apply, kept for its memory
};

}  // namespace

Possible possible_by_pairs(const GroundTask& task, Budget& budget) {
  Possible possible{ById<char>(task.actions.size(), 1)};
  if (!task.axioms.empty() || task.facts.size() > kMostFacts || task.actions.size() > 4 * kMostFacts) return possible;
  Pairs pairs(task, budget);
  if (budget.over()) return possible;
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    possible.actions[a] = pairs.reachable(action.start.facts) && pairs.reachable(action.over_all.facts) &&
                          pairs.reachable(action.end.facts);
  }
  possible.goal = pairs.reachable(task.goal.facts);
  possible.together = std::move(pairs).together();
  return possible;
}

}  // namespace cxlab::planner
