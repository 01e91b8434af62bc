#include "lab/answers.h"

#include <map>

namespace cxlab::lab {

namespace {

Json fact_json(const FactCopy& fact) {
  Json slots = Json::object();
  for (const auto& [name, value] : fact.slots) slots[name] = to_json(value);
  Json json;
  if (fact.index > 0) json["fact"] = "f-" + std::to_string(fact.index);
  json["template"] = fact.template_name;
  json["slots"] = std::move(slots);
  return json;
}

Json doer_json(const inspect::Doer& doer) {
  static const std::map<inspect::Doer::Kind, const char*> kKinds{
      {inspect::Doer::Kind::kRule, "rule"},     {inspect::Doer::Kind::kInput, "input"},
      {inspect::Doer::Kind::kPerson, "person"}, {inspect::Doer::Kind::kWhatIf, "what_if"},
      {inspect::Doer::Kind::kStory, "story"},   {inspect::Doer::Kind::kProgram, "program"},
      {inspect::Doer::Kind::kStart, "start"},   {inspect::Doer::Kind::kOutside, "executive"}};
  Json json{{"kind", kKinds.at(doer.kind)}};
  if (!doer.name.empty()) json["name"] = doer.name;
  if (doer.n) json["n"] = *doer.n;
  return json;
}

Json history_json(const inspect::FactHistory& history) {
  Json json = fact_json(history.fact);
  json["present"] = history.present;
  Json changes = Json::array();
  for (const inspect::FactChange& change : history.changes)
    changes.push_back({{"n", change.n},
                       {"t_s", to_seconds(change.t)},
                       {"what", std::string(to_string(change.kind))},
                       {"by", doer_json(change.by)},
                       {"text", change.after.print()}});
  json["changes"] = std::move(changes);
  return json;
}

/// A change in a list of changes: its fact as text.
Json change_json(const inspect::FactChange& change) {
  return {{"fact", change.after.print()},
          {"what", std::string(to_string(change.kind))},
          {"t_s", to_seconds(change.t)},
          {"by", change.by.text()}};
}

Json users_json(const std::vector<inspect::FactUser>& users) {
  Json list = Json::array();
  for (const inspect::FactUser& user : users) {
    list.push_back({{"rule", user.rule},
                    {"place", user.file + ':' + std::to_string(user.line)},
                    {"condition", user.condition},
                    {"fired", user.fired}});
    if (user.last) list.back()["last_s"] = to_seconds(*user.last);
    if (!user.differs.empty()) list.back()["differs"] = user.differs;
    if (user.lacks) list.back()["lacks"] = to_text(*user.lacks);
  }
  return list;
}

}  // namespace

Json to_json(const Value& value) {
  switch (value.type()) {
    case ValueType::kInteger: return value.as_integer();
    case ValueType::kFloat: return value.as_number();
    case ValueType::kMultifield: {
      Json list = Json::array();
      for (const Value& item : value.items()) list.push_back(to_json(item));
      return list;
    }
    default: return value.print();
  }
}

Json to_json(const inspect::Values& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = value;
  return json;
}

Json place_json(const std::string& file, int line) {
  return file.empty() ? Json() : Json(file + ':' + std::to_string(line));
}

Json facts_json(const std::vector<inspect::FactHistory>& facts) {
  Json list = Json::array();
  for (const inspect::FactHistory& history : facts) list.push_back(history_json(history));
  return {{"facts", std::move(list)}};
}

Json agenda_json(const std::vector<ActivationInfo>& agenda, const std::vector<std::string>& focus) {
  Json list = Json::array();
  for (const ActivationInfo& a : agenda) {
    Json facts = Json::array();
    for (const std::int64_t fact : a.facts) facts.push_back(fact < 0 ? Json() : Json("f-" + std::to_string(fact)));
    list.push_back({{"module", a.module}, {"rule", a.rule}, {"salience", a.salience}, {"facts", facts}});
  }
  return {{"focus", focus}, {"agenda", std::move(list)}};
}

Json globals_json(const std::vector<std::pair<std::string, Value>>& globals) {
  Json json = Json::object();
  for (const auto& [name, value] : globals) json[name] = to_json(value);
  return {{"globals", std::move(json)}};
}

Json firings_json(const std::vector<inspect::FiringCopy>& firings) {
  Json list = Json::array();
  for (const inspect::FiringCopy& firing : firings) {
    Json facts = Json::array();
    for (const FactCopy& fact : firing.facts) facts.push_back(fact.print());
    list.push_back({{"n", firing.n},
                    {"t_s", to_seconds(firing.t)},
                    {"rule", firing.rule},
                    {"place", place_json(firing.file, firing.line)},
                    {"values", to_json(firing.values)},
                    {"facts", std::move(facts)}});
  }
  return {{"firings", std::move(list)}};
}

Json rules_json(const std::vector<inspect::RuleUse>& rules) {
  Json list = Json::array();
  for (const inspect::RuleUse& use : rules) {
    Json json{{"rule", use.rule}, {"place", place_json(use.file, use.line)}, {"fired", use.fired}};
    json["activated"] = use.activated ? Json(*use.activated) : Json();
    json["first_s"] = use.first ? Json(to_seconds(*use.first)) : Json();
    json["last_s"] = use.last ? Json(to_seconds(*use.last)) : Json();
    if (use.unmet)
      json["unmet"] = {{"condition", use.unmet->number}, {"text", use.unmet->text}, {"because", use.unmet->because}};
    list.push_back(std::move(json));
  }
  return {{"rules", std::move(list)}};
}

Json why_json(const inspect::Derivation& derivation) {
  Json steps = Json::array();
  for (const inspect::Derivation::Step& step : derivation.steps) {
    Json json{
        {"n", step.n}, {"t_s", to_seconds(step.t)}, {"kind", std::string(to_string(step.kind))}, {"text", step.text}};
    if (step.index > 0) json["fact"] = "f-" + std::to_string(step.index);
    if (!step.file.empty()) json["place"] = place_json(step.file, step.line);
    if (!step.values.empty()) json["values"] = to_json(step.values);
    json["because"] = step.because;
    if (step.outside) json["outside"] = *step.outside;
    if (!step.note.empty()) json["note"] = step.note;
    if (step.asserted) json["asserted"] = {{"t_s", to_seconds(step.asserted->t)}, {"by", doer_json(step.asserted->by)}};
    steps.push_back(std::move(json));
  }
  return {{"steps", std::move(steps)}};
}

Json future_json(const inspect::FactFuture& future) {
  Json json = Json::object();
  if (future.fact) {
    json["fact"] = "f-" + std::to_string(future.fact->fact.index);
    json["text"] = future.fact->fact.print();
    json["waiting"] = users_json(future.waiting);
    json["nearly"] = users_json(future.nearly);
    json["forbidden"] = users_json(future.forbidden);
  }
  if (!future.nearest.empty()) json["nearest"] = future.nearest;
  if (future.makers) json["makers"] = to_json(*future.makers);
  return json;
}

Json to_json(const inspect::Makers& makers) {
  Json json{{"pattern", makers.pattern}, {"forbids", makers.forbids}};
  if (makers.changed) json["nearest_changed"] = change_json(*makers.changed);
  if (makers.made) json["last_made"] = change_json(*makers.made);
  if (makers.gone) json["then"] = change_json(*makers.gone);
  auto rules = Json::array();
  for (const auto& maker : makers.makers) {
    rules.push_back({{"rule", maker.rule},
                     {"place", maker.file + ':' + std::to_string(maker.line)},
                     {"how", maker.how},
                     {"fired", maker.fired}});
    if (!maker.through.empty()) rules.back()["through"] = maker.through;
    if (maker.last) rules.back()["last_s"] = to_seconds(*maker.last);
    if (maker.lacks) rules.back()["lacks"] = to_text(*maker.lacks);
  }
  json["rules"] = std::move(rules);
  return json;
}

Json to_json(const std::vector<explain::ConditionNow>& conditions) {
  Json list = Json::array();
  for (const explain::ConditionNow& condition : conditions) {
    list.push_back({{"condition", condition.number},
                    {"text", condition.text},
                    {"line", condition.line},
                    {"end_line", condition.end_line},
                    {"holds", condition.holds ? Json(*condition.holds) : Json()}});
    if (condition.matches_alone) list.back()["matches_alone"] = *condition.matches_alone;
  }
  return list;
}

std::string to_text(const explain::UnmetCondition& lacks) {
  return "condition " + std::to_string(lacks.number) + ": " + lacks.print();
}

}  // namespace cxlab::lab
