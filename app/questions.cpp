// cxlab facts, agenda, globals, firings, rules and why: questions about a moment of a recorded run.

#include <algorithm>
#include <cstdio>
#include <map>

#include "app/arguments.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/json.h"
#include "cx/inspect/text.h"

namespace cxlab::app {

namespace {

Json json_of(const Value& value) {
  switch (value.type()) {
    case ValueType::kInteger: return value.as_integer();
    case ValueType::kFloat: return value.as_number();
    case ValueType::kMultifield: {
      Json list = Json::array();
      for (const Value& item : value.items()) list.push_back(json_of(item));
      return list;
    }
    default: return value.print();
  }
}

Json json_of(const FactCopy& fact) {
  Json slots = Json::object();
  for (const auto& [name, value] : fact.slots) slots[name] = json_of(value);
  Json json;
  if (fact.index > 0) json["fact"] = "f-" + std::to_string(fact.index);
  json["template"] = fact.template_name;
  json["slots"] = std::move(slots);
  return json;
}

Json json_of(const inspect::Values& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = value;
  return json;
}

Json json_of(const inspect::Doer& doer) {
  static const std::map<inspect::Doer::Kind, const char*> kKinds{
      {inspect::Doer::Kind::kRule, "rule"},     {inspect::Doer::Kind::kInput, "input"},
      {inspect::Doer::Kind::kPerson, "person"}, {inspect::Doer::Kind::kWhatIf, "what_if"},
      {inspect::Doer::Kind::kStart, "start"},   {inspect::Doer::Kind::kOutside, "executive"}};
  Json json{{"kind", kKinds.at(doer.kind)}};
  if (!doer.name.empty()) json["name"] = doer.name;
  if (doer.n) json["n"] = *doer.n;
  return json;
}

Json json_of(const inspect::FactHistory& history) {
  Json json = json_of(history.fact);
  json["present"] = history.present;
  Json changes = Json::array();
  for (const inspect::FactChange& change : history.changes)
    changes.push_back({{"n", change.n},
                       {"t_s", to_seconds(change.t)},
                       {"what", std::string(to_string(change.kind))},
                       {"by", json_of(change.by)},
                       {"text", change.after.print()}});
  json["changes"] = std::move(changes);
  return json;
}

Json place(const std::string& file, int line) {
  return file.empty() ? Json() : Json(file + ':' + std::to_string(line));
}

// --- facts

struct FactsOptions {
  Question question;
  std::string what;
  bool changes = false;
};

int facts(const FactsOptions& options) {
  const Question& question = options.question;
  return ask(question, [&](inspect::Inspector& inspector) -> Expected<Answer> {
    const bool stretch = question.from || question.to;
    auto found =
        stretch ? inspector.facts(options.what, from_of(question), to_of(question)) : inspector.facts(options.what);
    if (!found) return found.error();
    Json list = Json::array();
    if (question.json)
      for (const inspect::FactHistory& history : *found) list.push_back(json_of(history));
    return Answer{found->empty() ? "none\n" : inspect::text_of(*found, options.changes || stretch),
                  {{"facts", std::move(list)}}};
  });
}

// --- rules

struct RulesOptions {
  Question question;
  std::string against;
};

Json json_of(const inspect::RuleUse& use) {
  Json json{{"rule", use.rule}, {"place", place(use.file, use.line)}, {"fired", use.fired}};
  json["activated"] = use.activated ? Json(*use.activated) : Json();
  json["first_s"] = use.first ? Json(to_seconds(*use.first)) : Json();
  json["last_s"] = use.last ? Json(to_seconds(*use.last)) : Json();
  if (use.unmet)
    json["unmet"] = {{"condition", use.unmet->number}, {"text", use.unmet->text}, {"because", use.unmet->because}};
  return json;
}

/// What fires in only one of two runs.
int rules_against(const RulesOptions& options) {
  const Question& question = options.question;
  auto a = open_run(question.run, question.trust_programs);
  auto b = open_run(options.against, question.trust_programs);
  if (!a || !b) return fail((a ? b : a).error());
  Console console(true);
  auto two = lab::TwoMoments::open(*a, *b, console.host());
  if (!two) return fail(two.error());
  if (Status s = two->seek(question.at ? std::optional(from_seconds(*question.at)) : std::nullopt);
      !s && !two->stopped())
    return fail(lab::about_option(s.error(), "--at"));
  if (const int code = interrupted("the runs were not replayed up to that time")) return code;
  const auto found = two->environments(question.environment);
  if (!found) return fail(found.error());
  const SimTime t = two->t();
  Json environments = Json::array();
  if (!question.json) std::printf("up to %s, in both runs:\n", inspect::seconds_text(t).c_str());
  for (const auto& [in_a, in_b] : found->both) {
    Json json{{"environment", in_a.name()}};
    if (!question.json && found->both.size() + found->only_in_a.size() > 1) std::printf("%s:\n", in_a.name().c_str());
    const std::vector<inspect::RuleUse> uses_of_a = in_a.rules(false), uses_of_b = in_b.rules(false);
    const auto only = [&](const char* run, const auto& here, const auto& there) {
      Json list = Json::array();
      for (const inspect::RuleUse& use : here) {
        const auto same = std::ranges::find(there, use.rule, &inspect::RuleUse::rule);
        if (use.fired == 0 || (same != there.end() && same->fired > 0)) continue;
        list.push_back({{"rule", use.rule}, {"fired", use.fired}, {"exists_in_other", same != there.end()}});
        if (!question.json)
          std::printf("only in %s  %s (%s:%d): fired %lld time%s, first at %s%s\n", run, use.rule.c_str(),
                      use.file.c_str(), use.line, static_cast<long long>(use.fired), use.fired == 1 ? "" : "s",
                      inspect::seconds_text(*use.first).c_str(),
                      same == there.end() ? "; the other run has no such rule" : "");
      }
      return list;
    };
    json["only_in_a"] = only("a", uses_of_a, uses_of_b);
    json["only_in_b"] = only("b", uses_of_b, uses_of_a);
    if (!question.json && json["only_in_a"].empty() && json["only_in_b"].empty())
      std::printf("the same rules fired in both runs\n");
    environments.push_back(std::move(json));
  }
  if (question.json)
    std::printf("%s\n", json_text(Json{{"at_s", to_seconds(t)}, {"environments", std::move(environments)}}, 2).c_str());
  return 0;
}

int rules(const RulesOptions& options) {
  if (!options.against.empty()) return rules_against(options);
  return ask(options.question,
             [&](inspect::Inspector& inspector) -> Expected<Answer> {
               std::vector<inspect::RuleUse> uses = inspector.rules(false);
               inspector.assert_time();  // after what was counted
               const std::vector<inspect::RuleUse> explained = inspector.rules(true);
               for (std::size_t i = 0; i < uses.size(); ++i) uses[i].unmet = explained[i].unmet;
               Json list = Json::array();
               for (const inspect::RuleUse& use : uses) list.push_back(json_of(use));
               return Answer{inspect::text_of(uses), {{"rules", std::move(list)}}};
             },
             {.counting = Counting::kUse});
}

// --- why

struct WhyOptions {
  Question question;
  std::string what;
  bool whole = false, svg = false;
};

int why(const WhyOptions& options) {
  return ask(options.question, [&](inspect::Inspector& inspector) -> Expected<Answer> {
    auto derivation = inspector.why(options.what);
    if (!derivation) return derivation.error();
    if (options.svg) return Answer{inspect::svg_of(inspect::tree_of(*derivation, options.whole)), {}};
    Json steps = Json::array();
    for (const inspect::Derivation::Step& step : derivation->steps) {
      Json json{
          {"n", step.n}, {"t_s", to_seconds(step.t)}, {"kind", std::string(to_string(step.kind))}, {"text", step.text}};
      if (step.index > 0) json["fact"] = "f-" + std::to_string(step.index);
      if (!step.file.empty()) json["place"] = place(step.file, step.line);
      if (!step.values.empty()) json["values"] = json_of(step.values);
      json["because"] = step.because;
      if (step.outside) json["outside"] = *step.outside;
      if (!step.note.empty()) json["note"] = step.note;
      if (step.asserted) json["asserted"] = {{"t_s", to_seconds(step.asserted->t)}, {"by", json_of(step.asserted->by)}};
      steps.push_back(std::move(json));
    }
    return Answer{
        options.whole ? inspect::whole_text(*derivation) : inspect::text_of(inspect::tree_of(*derivation, false)),
        {{"steps", std::move(steps)}}};
  });
}

}  // namespace

void add_facts(CLI::App& app, Action& action) {
  auto options = std::make_shared<FactsOptions>();
  CLI::App* command = app.add_subcommand("facts", "Lists the facts of a recorded run at a time, and who made them");
  add_question(*command, options->question, Times::kAtOrStretch);
  command->add_option("what", options->what,
                      "A template, a pattern such as '(order (id 3))', or a fact such as f-12 (default: all)");
  command->add_flag("--changes", options->changes, "Each change of the facts, with who made it");
  command->footer(
      "With --from or --to it lists all facts that were there at some time of this stretch, with their changes.\n"
      "Examples:\n  cxlab facts runs/game-1 order --at 5:12\n  cxlab facts runs/game-1 '(robot (name robot1))' "
      "--changes");
  command->callback([options, &action] { action = [options] { return facts(*options); }; });
}

void add_agenda(CLI::App& app, Action& action) {
  auto question = std::make_shared<Question>();
  CLI::App* command =
      app.add_subcommand("agenda", "Lists the rules of a recorded run that wait to fire at a time, the next one first");
  add_question(*command, *question, Times::kAt);
  command->callback([question, &action] {
    action = [question] {
      return ask(*question, [](inspect::Inspector& inspector) -> Expected<Answer> {
        const auto agenda = inspector.agenda();
        Json list = Json::array();
        for (const ActivationInfo& a : agenda) {
          Json facts = Json::array();
          for (const std::int64_t fact : a.facts)
            facts.push_back(fact < 0 ? Json() : Json("f-" + std::to_string(fact)));
          list.push_back({{"module", a.module}, {"rule", a.rule}, {"salience", a.salience}, {"facts", facts}});
        }
        const std::string text = inspect::text_of(agenda, inspector.focus());
        return Answer{
            agenda.empty()
                ? text + "no rule waits when the tick is over; inside it: cxlab attach RUN -c 'at T' -c agenda\n"
                : text,
            {{"focus", inspector.focus()}, {"agenda", std::move(list)}}};
      });
    };
  });
}

void add_globals(CLI::App& app, Action& action) {
  auto question = std::make_shared<Question>();
  CLI::App* command = app.add_subcommand("globals", "Lists the global variables of a recorded run at a time");
  add_question(*command, *question, Times::kAt);
  command->callback([question, &action] {
    action = [question] {
      return ask(*question, [](inspect::Inspector& inspector) -> Expected<Answer> {
        Json json = Json::object();
        for (const auto& [name, value] : inspector.globals()) json[name] = json_of(value);
        const std::string text = inspect::text_of(inspector.globals());
        return Answer{text.empty() ? "none\n" : text, {{"globals", std::move(json)}}};
      });
    };
  });
}

void add_firings(CLI::App& app, Action& action) {
  struct Options {
    Question question;
    std::string rule;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("firings", "Lists which rules of a recorded run fired when, and for which values");
  add_question(*command, options->question, Times::kStretch);
  command->add_option("rule", options->rule, "Only this rule, with or without its module (default: all)");
  command->footer("Example:\n  cxlab firings runs/game-1 order-begin --from 5:00 --to 6:00");
  command->callback([options, &action] {
    action = [options] {
      return ask(options->question, [&](inspect::Inspector& inspector) -> Expected<Answer> {
        auto found = inspector.firings(options->rule, from_of(options->question), to_of(options->question));
        if (!found) return found.error();
        Json list = Json::array();
        if (options->question.json)
          for (const inspect::FiringCopy& firing : *found) {
            Json facts = Json::array();
            for (const FactCopy& fact : firing.facts) facts.push_back(fact.print());
            list.push_back({{"n", firing.n},
                            {"t_s", to_seconds(firing.t)},
                            {"rule", firing.rule},
                            {"place", place(firing.file, firing.line)},
                            {"values", json_of(firing.values)},
                            {"facts", std::move(facts)}});
          }
        return Answer{found->empty() ? "none\n" : inspect::text_of(*found), {{"firings", std::move(list)}}};
      });
    };
  });
}

void add_rules(CLI::App& app, Action& action) {
  auto options = std::make_shared<RulesOptions>();
  CLI::App* command = app.add_subcommand(
      "rules", "Lists which rules of a recorded run fired, waited in vain, or never matched, and what these lack");
  add_question(*command, options->question, Times::kAt);
  command->add_option("--against", options->against, "Another run: lists the rules that fired in only one of the two");
  command->footer("Examples:\n  cxlab rules runs/game-1\n  cxlab rules runs/game-1 --against runs/game-2");
  command->callback([options, &action] { action = [options] { return rules(*options); }; });
}

void add_why(CLI::App& app, Action& action) {
  auto options = std::make_shared<WhyOptions>();
  CLI::App* command = app.add_subcommand("why", "Says how a fact of a recorded run came about, or why a rule fired");
  add_question(*command, options->question, Times::kAt);
  command
      ->add_option(
          "what", options->what,
          "A fact such as f-12, a pattern such as '(order (id 3))' (of several the one that changed last), or a "
          "rule (its last firing)")
      ->required();
  command->add_flag("--whole", options->whole,
                    "Lists all firings that led to it, not only the latest cause of each step");
  command->add_flag("--svg", options->svg, "The tree as a picture (SVG), on standard output")->excludes("--json");
  command->footer(
      "The tree goes from what was asked for to what came from outside of the rules; --whole lists each firing once, "
      "the\n"
      "latest first; --json has all causes.\n"
      "Examples:\n  cxlab why runs/game-1 '(order (id 3))' --at 5:12\n  cxlab why runs/game-1 order-begin --at 300\n"
      "  cxlab why runs/game-1 order-begin --svg > why.svg");
  command->callback([options, &action] { action = [options] { return why(*options); }; });
}

}  // namespace cxlab::app
