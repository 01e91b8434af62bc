// cxlab facts, agenda, globals, firings, rules and why: questions about a moment of a recorded run.

#include <algorithm>
#include <cstdio>

#include "app/arguments.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/json.h"
#include "cx/inspect/text.h"
#include "lab/answers.h"

namespace cxlab::app {

namespace {

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
    return Answer{found->empty() ? "none\n" : inspect::text_of(*found, options.changes || stretch),
                  question.json ? lab::facts_json(*found) : Json::object()};
  });
}

// --- rules

struct RulesOptions {
  Question question;
  std::string against;
};

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
               const std::vector<inspect::RuleUse> uses = inspector.rules_explained();
               return Answer{inspect::text_of(uses), lab::rules_json(uses)};
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
    return Answer{
        options.whole ? inspect::whole_text(*derivation) : inspect::text_of(inspect::tree_of(*derivation, false)),
        lab::why_json(*derivation)};
  });
}

}  // namespace

void add_facts(CLI::App& app, Action& action) {
  auto options = std::make_shared<FactsOptions>();
  CLI::App* command = app.add_subcommand("facts", "List the facts of a recorded run at a time, and who made them");
  add_question(*command, options->question, Times::kAtOrStretch);
  command->add_option("what", options->what,
                      "A template, a pattern such as '(order (id 3))', or a fact such as f-12 (default: all)");
  command->add_flag("--changes", options->changes, "Lists each change of the facts, with who made it");
  command->footer(
      "With --from or --to, it lists all facts that existed at any time of this stretch, with their changes.\n"
      "Examples:\n  cxlab facts runs/game-1 order --at 5:12\n  cxlab facts runs/game-1 '(robot (name robot1))' "
      "--changes");
  command->callback([options, &action] { action = [options] { return facts(*options); }; });
}

void add_agenda(CLI::App& app, Action& action) {
  auto question = std::make_shared<Question>();
  CLI::App* command =
      app.add_subcommand("agenda", "List the rules of a recorded run that wait to fire at a time, the next one first");
  add_question(*command, *question, Times::kAt);
  command->callback([question, &action] {
    action = [question] {
      return ask(*question, [](inspect::Inspector& inspector) -> Expected<Answer> {
        const auto agenda = inspector.agenda();
        const std::string text = inspect::text_of(agenda, inspector.focus());
        return Answer{
            agenda.empty()
                ? text + "no rule waits when the tick is over; inside it: cxlab attach RUN -c 'at T' -c agenda\n"
                : text,
            lab::agenda_json(agenda, inspector.focus())};
      });
    };
  });
}

void add_globals(CLI::App& app, Action& action) {
  auto question = std::make_shared<Question>();
  CLI::App* command = app.add_subcommand("globals", "List the global variables of a recorded run at a time");
  add_question(*command, *question, Times::kAt);
  command->callback([question, &action] {
    action = [question] {
      return ask(*question, [](inspect::Inspector& inspector) -> Expected<Answer> {
        const auto globals = inspector.globals();
        return Answer{globals.empty() ? "none\n" : inspect::text_of(globals), lab::globals_json(globals)};
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
      app.add_subcommand("firings", "List which rules of a recorded run fired when, and for which values");
  add_question(*command, options->question, Times::kStretch);
  command->add_option("rule", options->rule, "Only this rule, with or without its module (default: all)");
  command->footer("Example:\n  cxlab firings runs/game-1 order-begin --from 5:00 --to 6:00");
  command->callback([options, &action] {
    action = [options] {
      return ask(options->question, [&](inspect::Inspector& inspector) -> Expected<Answer> {
        auto found = inspector.firings(options->rule, from_of(options->question), to_of(options->question));
        if (!found) return found.error();
        return Answer{found->empty() ? "none\n" : inspect::text_of(*found),
                      options->question.json ? lab::firings_json(*found) : Json::object()};
      });
    };
  });
}

void add_rules(CLI::App& app, Action& action) {
  auto options = std::make_shared<RulesOptions>();
  CLI::App* command = app.add_subcommand(
      "rules", "List which rules of a recorded run fired, waited in vain, or never matched, and what these lack");
  add_question(*command, options->question, Times::kAt);
  command->add_option("--against", options->against, "Another run: lists the rules that fired in only one of both");
  command->footer("Examples:\n  cxlab rules runs/game-1\n  cxlab rules runs/game-1 --against runs/game-2");
  command->callback([options, &action] { action = [options] { return rules(*options); }; });
}

void add_why(CLI::App& app, Action& action) {
  auto options = std::make_shared<WhyOptions>();
  CLI::App* command = app.add_subcommand("why", "Explain how a fact of a recorded run came about, or why a rule fired");
  add_question(*command, options->question, Times::kAt);
  command
      ->add_option(
          "what", options->what,
          "A fact such as f-12, a pattern such as '(order (id 3))' (if several facts match, the one that changed "
          "last), or a rule (its last firing)")
      ->required();
  command->add_flag("--whole", options->whole,
                    "Lists all firings that led to it, not only the latest cause of each step");
  command->add_flag("--svg", options->svg, "The tree as a picture (SVG), on standard output")->excludes("--json");
  command->footer(
      "The tree goes from the fact or firing back to events from outside of the rules. With --whole, the answer lists\n"
      "each firing once, the latest first. With --json, it has all causes.\n"
      "Examples:\n  cxlab why runs/game-1 '(order (id 3))' --at 5:12\n  cxlab why runs/game-1 order-begin --at 300\n"
      "  cxlab why runs/game-1 order-begin --svg > why.svg");
  command->callback([options, &action] { action = [options] { return why(*options); }; });
}

}  // namespace cxlab::app
