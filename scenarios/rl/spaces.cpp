#include "scenarios/rl/spaces.h"

#include <algorithm>

#include "cx/base/json.h"

namespace cxlab::rl {

namespace {

/// Adds `name(a#b)` for all objects of the types.
Status add_grounded(const Schema& schema, const SpaceAnswers& answers, std::vector<std::string>& all) {
  std::vector<std::string> beginnings{schema.name + '('};
  for (std::size_t i = 0; i < schema.types.size(); ++i) {
    const auto objects = answers.objects.find(schema.types[i]);
    if (objects == answers.objects.end()) return {};
    if (!objects->second.empty() && beginnings.size() > Spaces::kMost / objects->second.size())
      return input_error(schema.name + " has more than " + std::to_string(Spaces::kMost) +
                         " combinations of objects; name those that matter as predefined");
    std::vector<std::string> longer;
    for (const std::string& beginning : beginnings)
      for (const std::string& object : objects->second) longer.push_back(beginning + (i > 0 ? "#" : "") + object);
    beginnings = std::move(longer);
  }
  for (std::string& beginning : beginnings) all.push_back(std::move(beginning) + ')');
  return {};
}

Expected<std::vector<std::string>> all_of(const std::vector<std::string>& predefined,
                                          const std::vector<Schema>& schemas, const SpaceAnswers& answers) {
  std::vector<std::string> all = predefined;
  for (const Schema& schema : schemas)
    if (Status s = add_grounded(schema, answers, all); !s) return s.error();
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (all.size() > Spaces::kMost)
    return input_error(found_expected(std::to_string(all.size()), "at most " + std::to_string(Spaces::kMost)));
  return all;
}

}  // namespace

Expected<Spaces> Spaces::make(const SpaceAnswers& answers) {
  Spaces spaces;
  auto observables = all_of(answers.observables, answers.predicates, answers);
  if (!observables) return input_error("the space of observations: " + observables.error().message);
  auto actions = all_of(answers.actions, answers.action_schemas, answers);
  if (!actions) return input_error("the space of actions: " + actions.error().message);
  spaces.observables_ = *std::move(observables);
  spaces.actions_.insert(spaces.actions_.end(), actions->begin(), actions->end());
  return spaces;
}

std::vector<std::uint8_t> Spaces::observation(const std::vector<std::string>& true_now,
                                              std::vector<std::string>* unknown) const {
  std::vector<std::uint8_t> bits(observables_.size());
  for (const std::string& one : true_now) {
    const auto found = std::lower_bound(observables_.begin(), observables_.end(), one);
    if (found != observables_.end() && *found == one)
      bits[static_cast<std::size_t>(found - observables_.begin())] = 1;
    else if (unknown)
      unknown->push_back(one);
  }
  return bits;
}

std::size_t Spaces::place_of(std::string_view action) const {
  const auto found = std::lower_bound(actions_.begin() + 1, actions_.end(), action);
  return found != actions_.end() && *found == action ? static_cast<std::size_t>(found - actions_.begin()) : 0;
}

std::string Spaces::to_json() const {
  return json_text(Json{{"observables", observables_}, {"actions", actions_}}, 1) + "\n";
}

std::vector<Schema> schemas_of(const std::vector<std::string>& names, const std::vector<std::int64_t>& counts,
                               const std::vector<std::string>& types) {
  std::vector<Schema> schemas;
  std::size_t next = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    Schema& schema = schemas.emplace_back(Schema{names[i], {}});
    const std::int64_t count = i < counts.size() ? counts[i] : 0;
    for (std::int64_t k = 0; k < count && next < types.size(); ++k) schema.types.push_back(types[next++]);
  }
  return schemas;
}

}  // namespace cxlab::rl
