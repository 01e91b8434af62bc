#include "scenarios/rl/policy.h"

#include <algorithm>
#include <cmath>

#include "cx/base/json.h"

namespace cxlab::rl {

std::size_t QTable::choose(const std::string& state, const std::vector<std::string>& actions, double explore,
                           RandomStream& chance) const {
  if (chance.chance(explore)) return chance.below(actions.size());
  std::size_t best = 0;
  for (std::size_t i = 1; i < actions.size(); ++i)
    if (value(state, actions[i]) > value(state, actions[best])) best = i;
  return best;
}

void QTable::learn(const Step& step) {
  double next = 0;
  for (std::size_t i = 0; i < step.next_actions.size(); ++i) {
    const double v = value(step.next_state, step.next_actions[i]);
    next = i == 0 ? v : std::max(next, v);
  }
  double& now = values_[step.state][step.action];
  now += rates_.learning_rate * (step.reward + rates_.gamma * next - now);
}

double QTable::value(const std::string& state, const std::string& action) const {
  const auto row = values_.find(state);
  if (row == values_.end()) return 0;
  const auto found = row->second.find(action);
  return found == row->second.end() ? 0 : found->second;
}

double QTable::exploration(int episode) const {
  return rates_.exploration * std::pow(rates_.exploration_decay, episode);
}

std::string QTable::to_text() const { return json_text(Json(values_), 1) + '\n'; }

Expected<QTable> QTable::from_text(std::string_view text, LearningRates rates, const std::string& file) {
  const auto json = parse_json(text);
  QTable table(rates);
  const auto refuse = [&file](const std::string& what) {
    return input_error("not a table of values: " + what + ", expected {\"STATE\": {\"ACTION\": NUMBER}}", file);
  };
  if (!json.is_object()) return refuse("found no object");
  for (const auto& [state, row] : json.items()) {
    if (!row.is_object()) return refuse("'" + state + "' is no object");
    for (const auto& [action, value] : row.items()) {
      if (!value.is_number()) return refuse("the value of '" + action + "' is no number");
      table.values_[state][action] = value.get<double>();
    }
  }
  return table;
}

}  // namespace cxlab::rl
