// What a program asks of a run, by name; answers have the fields of `--json` of the commands (docs/reference/view.md).

#include <algorithm>

#include "cx/base/file.h"
#include "cx/explain/history.h"
#include "cx/explain/json.h"
#include "cx/explain/names.h"
#include "cx/inspect/makers.h"
#include "cx/inspect/text.h"
#include "cx/inspect/users.h"
#include "lab/answers.h"
#include "lab/control/debugger.h"
#include "lab/moment.h"

namespace cxlab::lab {

namespace {

/// The text of a field; empty where it is missing, or no text.
std::string text_field(const Json& request, const char* key) {
  const auto found = request.find(key);
  return found != request.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<double> number_field(const Json& request, const char* key) {
  const auto found = request.find(key);
  if (found == request.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

bool flag_field(const Json& request, const char* key) {
  const auto found = request.find(key);
  return found != request.end() && found->is_boolean() && found->get<bool>();
}

/// A time of the run in s; what lies outside of all runs is cut.
SimTime time_field(const Json& request, const char* key, SimTime otherwise) {
  const auto t = number_field(request, key);
  constexpr double kLongest = 1e9;
  return t ? from_seconds(std::clamp(*t, -kLongest, kLongest)) : otherwise;
}

/// The first so many, or with `last` the last ones; `total` says how many there are.
template <class T>
std::size_t limit(std::vector<T>& all, const Json& request, bool last) {
  const std::size_t total = all.size();
  const auto most = number_field(request, "limit");
  if (!most || !(*most >= 0) || *most >= static_cast<double>(total)) return total;
  const auto gone = static_cast<std::ptrdiff_t>(total - static_cast<std::size_t>(*most));
  last ? all.erase(all.begin(), all.begin() + gone) : all.erase(all.end() - gone, all.end());
  return total;
}

/// Keeps the first and the last change of each fact, which are enough for a list.
void keep_ends(std::vector<inspect::FactHistory>& facts) {
  for (inspect::FactHistory& fact : facts)
    if (fact.changes.size() > 2) fact.changes.erase(fact.changes.begin() + 1, fact.changes.end() - 1);
}

Json tree_json(const inspect::Tree& tree) {
  Json branches = Json::array();
  for (const inspect::Tree& branch : tree.branches) branches.push_back(tree_json(branch));
  return {{"text", tree.text}, {"branches", std::move(branches)}};
}

bool is_about_fact(const std::string& what) { return what.starts_with('(') || what.starts_with("f-"); }

/// A pattern that every fact of the template matches, for its name or one of its facts; a pattern as it is.
Expected<std::string> pattern_for(const inspect::Inspector& inspector, const std::string& what) {
  const auto facts = inspector.present(what);
  if (!facts) return facts.error();
  if (what.starts_with('(')) return what;
  return '(' + (what.starts_with("f-") ? facts->front().template_name : what) + ')';
}

const ConstructInfo* find_named(const RuleEngine& engine, const std::string& name) {
  for (const char* kind : {"defrule", "deftemplate", "deffunction", "deffacts", "defglobal"})
    if (const ConstructInfo* info = engine.find_construct(kind, name)) return info;
  return nullptr;
}

int last_line(const ConstructInfo& info) { return info.line + static_cast<int>(std::ranges::count(info.text, '\n')); }

bool is_about(const explain::Condition& condition, const std::string& template_name) {
  if (condition.kind == explain::Condition::Kind::kPattern)
    return !condition.pattern.is_object() && condition.pattern.template_name() == template_name;
  return std::ranges::any_of(condition.parts, [&](const auto& part) { return is_about(part, template_name); });
}

/// Rules with a condition about facts of a pattern's template, where there is no such fact.
Json users_of_template(inspect::Inspector& inspector, const std::string& text) {
  Json users = Json::array();
  const auto pattern = explain::Pattern::parse_plain(text, {}, 0);
  if (!pattern) return users;
  RuleEngine& engine = inspector.engine();
  const std::vector<ConstructInfo> constructs = engine.constructs();  // a copy: to look at conditions defines functions
  for (const ConstructInfo& rule : constructs) {
    if (rule.kind != "defrule" || !engine.has("defrule", rule.module + "::" + rule.name)) continue;
    const auto conditions = explain::conditions_of(rule.text, rule.file, rule.line);
    if (!conditions) continue;
    const auto about = std::ranges::find_if(
        *conditions, [&](const auto& condition) { return is_about(condition, pattern->template_name()); });
    if (about == conditions->end()) continue;
    users.push_back({{"rule", explain::with_module(rule.module, rule.name)},
                     {"place", place_json(inspector.shown_file(rule.file), rule.line)},
                     {"condition", about->text},
                     {"fired", 0}});
    if (!engine.acting_call(rule).empty()) continue;
    if (const auto unmet = explain::unmet_condition(engine, rule)) users.back()["lacks"] = to_text(*unmet);
  }
  return users;
}

/// A file of rules, as the run has it.
Expected<Json> file_source(const cx::Environment& environment, const std::string& file) {
  Json constructs = Json::array();
  std::string path;
  std::vector<std::string> known;
  for (const ConstructInfo& info : environment.engine().constructs()) {
    const std::string name = info.file.empty() ? "" : environment.files().journal_name(info.file);
    if (!name.empty() && (known.empty() || known.back() != name)) known.push_back(name);
    if (name != file) continue;
    path = info.file;
    constructs.push_back({{"kind", info.kind},
                          {"module", info.module},
                          {"name", info.name},
                          {"line", info.line},
                          {"end_line", last_line(info)}});
  }
  if (path.empty()) return input_error("no rules were read from a file '" + file + "'" + did_you_mean(file, known));
  const auto text = read_file(path);
  if (!text) return text.error();
  return Json{{"file", file}, {"first_line", 1}, {"text", *text}, {"constructs", std::move(constructs)}};
}

}  // namespace

struct Debugger::Question {
  /// What it looks at.
  enum class Of {
    kPlace,       ///< where the person is; no rules need to be there
    kRecords,     ///< what has happened up to there
    kFacts,       ///< what is there
    kConditions,  ///< what is there, and the time with it
  };
  const char* name;
  Of of;
  std::optional<Expected<Json>> (*answer)(Debugger&, const Json& request);
};

const std::vector<Debugger::Question>& Debugger::questions() {
  using D = Debugger;
  using Of = Question::Of;
  using Reply = std::optional<Expected<Json>>;
  /// For those that look at one environment.
  static const auto ask_one = [](D& d, const Json& request, auto answer) -> Reply {
    const auto environment = d.environment_in(request);
    if (!environment) return environment.error();
    inspect::Inspector inspector = d.inspect(**environment);
    Expected<Json> found = answer(inspector);
    if (!found) return found.error();
    Json json{{"environment", inspector.name()}};
    json.update(*found);
    return json;
  };
  static const std::vector<Question> all{
      {"where", Of::kPlace, [](D& d, const Json&) -> Reply { return d.place_json(); }},
      {"envs", Of::kFacts,
       [](D& d, const Json&) -> Reply {
         Json list = Json::array();
         for (const cx::Environment* e : d.environments())
           list.push_back({{"environment", e->unique_name()},
                           {"facts", e->engine().fact_count()},
                           {"agenda", e->engine().agenda().size()}});
         return Json{{"environments", std::move(list)}};
       }},
      {"facts", Of::kFacts,
       [](D& d, const Json& request) {
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           const std::string what = text_field(request, "what");
           auto found = i.facts(what);
           if (!found) return found.error();
           const std::size_t total = limit(*found, request, false);
           if (flag_field(request, "brief")) keep_ends(*found);
           Json json = facts_json(*found);
           json["total"] = total;
           json["slots"] = i.slot_names(what);
           return json;
         });
       }},
      {"changes", Of::kFacts,
       [](D& d, const Json& request) {
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           auto found = i.facts(text_field(request, "what"), time_field(request, "from", SimTime::min() + SimTime(1)),
                                time_field(request, "to", SimTime::max()));
           if (!found) return found.error();
           const std::size_t total = limit(*found, request, true);
           Json json = facts_json(*found);
           json["total"] = total;
           return json;
         });
       }},
      {"agenda", Of::kFacts,
       [](D& d, const Json& request) {
         return ask_one(d, request,
                        [&](inspect::Inspector& i) -> Expected<Json> { return agenda_json(i.agenda(), i.focus()); });
       }},
      {"globals", Of::kRecords,
       [](D& d, const Json& request) {
         return ask_one(d, request, [](inspect::Inspector& i) -> Expected<Json> { return globals_json(i.globals()); });
       }},
      {"firings", Of::kRecords,
       [](D& d, const Json& request) {
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           auto found = i.firings(text_field(request, "rule"), time_field(request, "from", SimTime::min()),
                                  time_field(request, "to", SimTime::max()));
           if (!found) return found.error();
           const std::size_t total = limit(*found, request, true);
           Json json = firings_json(*found);
           json["total"] = total;
           return json;
         });
       }},
      {"rules", Of::kConditions,
       [](D& d, const Json& request) {
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           return rules_json(d.may_assert_time() ? i.rules_explained() : i.rules(true));
         });
       }},
      {"why", Of::kRecords,
       [](D& d, const Json& request) {
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           const auto found = i.why(text_field(request, "what"));
           if (!found) return found.error();
           Json json = why_json(*found);
           json["tree"] = tree_json(inspect::tree_of(*found, false));
           return json;
         });
       }},
      {"why_not", Of::kConditions,
       [](D& d, const Json& request) -> Reply {
         const std::string what = text_field(request, "what");
         if (!is_about_fact(what)) {
           const auto environment = d.environment_in(request);
           if (!environment) return environment.error();
           return d.why_not_rule(**environment, what, request);
         }
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           const auto found = inspect::future_of(i, what);
           if (!found) return found.error();
           return future_json(*found);
         });
       }},
      {"consumers", Of::kConditions,
       [](D& d, const Json& request) {
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           const std::string what = text_field(request, "what");
           const auto pattern = is_about_fact(what) ? Expected<std::string>(what) : pattern_for(i, what);
           if (!pattern) return pattern.error();
           const auto found = inspect::future_of(i, *pattern);
           if (!found) return found.error();
           Json json = future_json(*found);
           if (!found->fact) json["waiting"] = users_of_template(i, found->makers ? found->makers->pattern : *pattern);
           return json;
         });
       }},
      {"producers", Of::kConditions,
       [](D& d, const Json& request) {
         return ask_one(d, request, [&](inspect::Inspector& i) -> Expected<Json> {
           const auto pattern = pattern_for(i, text_field(request, "what"));
           if (!pattern) return pattern.error();
           explain::UnmetCondition wanted;
           wanted.text = *pattern;
           const auto makers = inspect::makers_of(i, wanted);
           if (!makers) return input_error("the rules of this run cannot be searched for who makes " + *pattern);
           return to_json(*makers);
         });
       }},
      {"source", Of::kConditions,
       [](D& d, const Json& request) -> Reply {
         const auto environment = d.environment_in(request);
         if (!environment) return environment.error();
         const std::string rule = text_field(request, "rule"), file = text_field(request, "file");
         return rule.empty() && !file.empty() ? file_source(**environment, file) : d.rule_source(**environment, rule);
       }},
      {"words", Of::kRecords,
       [](D& d, const Json& request) -> Reply {
         const auto environment = d.environment_in(request);
         if (!environment) return environment.error();
         const std::string begun = text_field(request, "begun");
         constexpr std::size_t kMost = 200;
         Json list = Json::array();
         for (const ConstructInfo& info : (*environment)->engine().constructs())
           if (list.size() < kMost && (info.kind == "defrule" || info.kind == "deftemplate") &&
               info.name.find(begun) != info.name.npos)
             list.push_back({{"word", explain::with_module(info.module, info.name)},
                             {"kind", info.kind == "defrule" ? "rule" : "template"}});
         return Json{{"environment", (*environment)->unique_name()}, {"words", std::move(list)}};
       }},
      {"scene", Of::kRecords,
       [](D& d, const Json& request) -> Reply {
         if (!d.knows_.look_json) return input_error("this run has no scene");
         return d.knows_.look_json(text_field(request, "what"));
       }},
  };
  return all;
}

std::optional<Expected<Json>> Debugger::ask(const std::string& name, const Json& request) {
  const auto question = std::ranges::find_if(questions(), [&](const Question& one) { return name == one.name; });
  if (question == questions().end()) {
    if (const WorldQuestion* of_world = world_question(name)) {
      if (shown_) return std::nullopt;
      const auto answered = ask_world(*of_world, text_field(request, "what"));
      return answered ? Expected<Json>(world_json(*answered)) : answered.error();
    }
    std::vector<std::string> names;
    for (const Question& one : questions()) names.emplace_back(one.name);
    for (const WorldQuestion& one : knows_.world_questions) names.emplace_back(one.name);
    return input_error("there is no question '" + name + "'; it is one of " + some_of_and_nearest(name, names));
  }
  using Of = Question::Of;
  if (shown_ && question->of != Of::kPlace) return std::nullopt;
  if (time_is_there_ && question->of == Of::kFacts) return std::nullopt;
  if (question->of == Of::kConditions && may_assert_time()) {
    for (cx::Environment* environment : environments()) {
      // Who counts the rules must do so first.
      if (name != "rules") time_is_there_ = inspect(*environment).assert_time() || time_is_there_;
    }
    time_is_there_ = time_is_there_ || name == "rules";
  }
  return question->answer(*this, request);
}

/// A recorded run can be played up to here again, and the executive is not about to assert the time itself.
bool Debugger::may_assert_time() const { return options_.recorded && place_.fired < 0; }

Json Debugger::place_json() const {
  Json json{{"t", to_seconds(place_.t)},
            {"env", Json()},
            {"rule", Json()},
            {"facts", Json::array()},
            {"firing", Json()},
            {"at_end", false},
            {"live", !options_.recorded},
            {"running", !options_.recorded && !stopped_},
            {"text", where()}};
  const auto there = place();
  if (!there) return json;
  json["t"] = to_seconds(there->place.t);
  if (!there->environment.empty()) json["env"] = there->environment;
  json["at_end"] = there->at_end;
  if (there->place.fired >= 0) json["firing"] = there->place.fired;
  if (there->rule) json["rule"] = *there->rule;
  for (const std::int64_t fact : there->facts)
    json["facts"].push_back(fact < 0 ? Json() : Json("f-" + std::to_string(fact)));
  return json;
}

Expected<cx::Environment*> Debugger::environment_in(const Json& request) const {
  const std::string name = text_field(request, "env");
  if (name.empty()) return looked_at();
  std::vector<std::string> known;
  for (cx::Environment* environment : environments()) {
    known.push_back(environment->unique_name());
    if (name == environment->unique_name() || name == environment->name_in_log() || name == environment->name())
      return environment;
  }
  return input_error(no_environment(name, known));
}

/// The conditions of a rule now; null where a look would change the run.
Json Debugger::conditions_json(cx::Environment& environment, const ConstructInfo& rule) {
  if (!environment.engine().acting_call(rule).empty()) return nullptr;
  const auto conditions = explain::conditions_now(environment.engine(), rule);
  return conditions ? to_json(*conditions) : Json();
}

Expected<Json> Debugger::rule_source(cx::Environment& environment, const std::string& name) {
  const ConstructInfo* found = find_named(environment.engine(), name);
  if (!found)
    return input_error("there is no rule '" + name + "'" +
                       did_you_mean(name, explain::names_of(environment.engine(), "defrule")));
  const ConstructInfo info = *found;  // to look at conditions defines functions for a while
  Json json{{"environment", environment.unique_name()},
            {"kind", info.kind},
            {"module", info.module},
            {"rule", info.name},
            {"file", info.file.empty() ? Json() : Json(environment.files().journal_name(info.file))},
            {"first_line", info.line},
            {"end_line", last_line(info)},
            {"text", info.text}};
  if (info.kind != "defrule") return json;
  json["conditions"] = conditions_json(environment, info);
  if (json["conditions"].is_null()) return json;
  if (const auto unmet = explain::unmet_condition(environment.engine(), info)) json["because"] = unmet->because;
  return json;
}

std::optional<Expected<Json>> Debugger::why_not_rule(cx::Environment& environment, const std::string& name,
                                                     const Json& request) {
  RuleEngine& engine = environment.engine();
  explain::Wanted wanted;
  if (const auto where = request.find("where"); where != request.end() && where->is_object())
    for (const auto& [variable, value] : where->items())
      if (value.is_string()) wanted.emplace(variable, value.get<std::string>());
  const inspect::Inspector inspector = inspect(environment);
  Json explanations = Json::array();
  std::optional<Error> refused;
  for (const ConstructInfo& rule : engine.find_constructs("defrule", name)) {
    if (!engine.has("defrule", rule.module + "::" + rule.name)) continue;  // rules removed it
    const std::string acting = engine.acting_call(rule);
    if (!acting.empty() && !options_.recorded)
      return input_error("its conditions call '" + acting +
                         "', which acts: to look would change the run; it can be asked when the run is over");
    changed_ = changed_ || !acting.empty();
    std::optional<Expected<explain::WhyNot>> found;
    if (knows_.why_not) {
      followed_rule_ = name;
      found = knows_.why_not(environment, rule, wanted);
      if (!found) {
        time_is_there_ = true;  // so that it is played again
        return std::nullopt;
      }
    } else {
      found = explain::why_not(engine, rule, history_of(inspector.timeline(), rule.name), wanted);
      if (*found) (*found)->file = environment.files().journal_name((*found)->file);
    }
    if (!*found) {
      refused = found->error();
      continue;
    }
    Json json{{"environment", environment.unique_name()}};
    json.update(explain::to_json(**found));
    if ((*found)->unmet)
      if (const auto makers = inspect::makers_of(inspector, *(*found)->unmet)) json["makers"] = to_json(*makers);
    json["conditions"] = conditions_json(environment, rule);
    explanations.push_back(std::move(json));
  }
  if (explanations.empty() && refused) return *refused;
  if (explanations.empty())
    return input_error("there is no rule '" + name + "'" + did_you_mean(name, explain::names_of(engine, "defrule")));
  return Json{{"explanations", std::move(explanations)}};
}

/// The history so far, with the records that tell why a rule has not fired.
explain::History Debugger::history_of(const inspect::Timeline& timeline, const std::string& rule) {
  explain::History history({.past_facts = false, .rule = rule});
  for (std::uint64_t n = timeline.begin(); n < timeline.end(); ++n)
    if (timeline.fact(n) > 0 || timeline.kind(n) == RecordKind::kFire) history.add(timeline.read(n));
  return history;
}

}  // namespace cxlab::lab
