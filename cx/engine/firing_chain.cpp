#include "internal/firing_chain.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace cxlab {

void FiringChain::clear() {
  firings_.clear();
  size_ = 0;
}

/// The last firing that began before the activation was made.
std::size_t FiringChain::maker_of(std::uint64_t tag) const {
  std::size_t low = size_ > kKept ? size_ - kKept : 0, high = size_;  // the answer is in low .. high
  while (low < high) {
    const std::size_t middle = low + (high - low + 1) / 2;
    if (firing(middle).first_tag <= tag)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
}

void FiringChain::add(Rule rule, std::uint64_t facts, std::uint64_t tag, std::uint64_t next_tag) {
  const Firing added{rule, facts, next_tag, maker_of(tag)};
  if (firings_.size() < kKept)
    firings_.push_back(added);
  else
    firings_[size_ % kKept] = added;
  ++size_;
}

std::vector<const FiringChain::Firing*> FiringChain::path() const {
  std::vector<const Firing*> found;
  for (std::size_t at = size_; is_kept(at) && found.size() < kLongestPath; at = firing(at).made_by)
    found.push_back(&firing(at));
  return found;
}

std::optional<FiringChain::Round> FiringChain::round(std::size_t alike, std::size_t any) const {
  const std::vector<const Firing*> path = this->path();
  std::unordered_map<std::uint64_t, std::size_t> with_facts, of_rule;
  std::size_t most_alike = 0, most = 0;
  for (const Firing* f : path) {
    if (f->facts != 0) most_alike = std::max(most_alike, ++with_facts[f->facts]);
    most = std::max(most, ++of_rule[f->rule]);
  }
  const bool are_alike = most_alike >= alike && most_alike > 0;
  if (!are_alike && (most < any || most == 0)) return std::nullopt;
  const std::size_t turns = are_alike ? most_alike : most;
  const auto takes_turns = [&](const Firing& f) { return 2 * of_rule[f.rule] >= turns; };
  // The last turn of each, from the oldest.
  Round round;
  round.turns = turns;
  for (const Firing* f : path)
    if (takes_turns(*f) && std::ranges::find(round.rules, f->rule) == round.rules.end()) round.rules.push_back(f->rule);
  std::ranges::reverse(round.rules);
  return round;
}

}  // namespace cxlab
