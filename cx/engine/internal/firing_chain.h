#pragma once
// Which firing of a tick put which other one on the agenda. Rules that keep each other going form a chain without end.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cxlab {

/// The firings of one tick, of very many the last ones. An activation is made while a firing acts, or before the first
/// one; the links from each firing to the one that made its activation are a tree. Rules that drain an agenda which
/// was there before make a broad and low tree. A tick that does not end makes a path that grows without end.
class FiringChain {
 public:
  using Rule = std::uint32_t;

  /// A tick begins.
  void clear();
  /// A rule is about to fire. `tag` is the number of its activation, `next_tag` the one that the next activation gets.
  /// `facts` is equal for firings whose facts differ in nothing but numbers; 0 where nobody has looked.
  void add(Rule rule, std::uint64_t facts, std::uint64_t tag, std::uint64_t next_tag);
  /// How many were added.
  std::size_t size() const { return size_; }

  struct Round {
    std::vector<Rule> rules;  ///< in the order in which they take turns, each once
    std::size_t turns = 0;    ///< how often the most frequent of them is on the path
  };
  /// The rules that take turns on the path to the last firing. These are the rules that appear on it at least `alike`
  /// times with facts that differ only in numbers. If no rule does, they are those that appear at least `any` times.
  std::optional<Round> round(std::size_t alike, std::size_t any) const;

 private:
  struct Firing {
    Rule rule = 0;
    std::uint64_t facts = 0;
    std::uint64_t first_tag = 0;  ///< of the activations that it makes
    std::size_t made_by = 0;      ///< number of the firing, from 1; 0: none of this tick
  };
  static constexpr std::size_t kKept = 1 << 16;
  static constexpr std::size_t kLongestPath = 20'000;

  const Firing& firing(std::size_t number) const { return firings_[(number - 1) % kKept]; }
  bool is_kept(std::size_t number) const { return number > 0 && number + kKept > size_; }
  std::size_t maker_of(std::uint64_t tag) const;
  std::vector<const Firing*> path() const;  // the last firing first

  std::vector<Firing> firings_;
  std::size_t size_ = 0;
};

}  // namespace cxlab
