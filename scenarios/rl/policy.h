#pragma once
// What an agent in training learns with: a table of values of actions in states (Watkins, Q-learning, 1992).

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/random.h"

namespace cxlab::rl {

/// A step: what was done in a state, what it gave, and what can be done in the state that came of it.
struct Step {
  std::string state, action;
  double reward = 0;
  std::string next_state;
  std::vector<std::string> next_actions;  ///< none: the episode has ended
};

struct LearningRates {
  double learning_rate = 0.5;       ///< share of the new value
  double gamma = 0.95;              ///< value of the next step
  double exploration = 0.3;         ///< share of actions by chance in the first episode
  double exploration_decay = 0.95;  ///< times this in each episode
};

class QTable {
 public:
  explicit QTable(LearningRates rates) : rates_(rates) {}

  /// The best of `actions` (never empty), the first of those that are equal; with chance `explore` any of them.
  std::size_t choose(const std::string& state, const std::vector<std::string>& actions, double explore,
                     RandomStream& chance) const;
  void learn(const Step& step);
  double value(const std::string& state, const std::string& action) const;
  std::size_t states() const { return values_.size(); }
  double exploration(int episode) const;

  /// JSON: {"state": {"action": value}}.
  std::string to_text() const;
  /// kInput where the text is no such table.
  static Expected<QTable> from_text(std::string_view text, LearningRates rates, const std::string& file);

 private:
  LearningRates rates_;
  std::map<std::string, std::map<std::string, double>> values_;
};

}  // namespace cxlab::rl
