// cxlab why-not: why a rule of a recorded run has not fired at a time, from the rules alone, played up to then.

#include <algorithm>
#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/json.h"
#include "cx/explain/names.h"
#include "cx/inspect/layout.h"
#include "cx/inspect/text.h"
#include "cx/inspect/users.h"
#include "lab/answers.h"
#include "lab/why_not.h"

namespace cxlab::app {

namespace {

struct WhyNotOptions {
  Question question;
  std::string rule;
  std::vector<std::string> where;
};

void print(const std::string& text, const std::string& indent) {
  std::fputs(inspect::laid_out(text, indent, indent + "  ").c_str(), stdout);
}

void print(const char* before, const explain::Values& values) {
  if (!values.empty()) print(before + (' ' + inspect::values_text(values)), "    ");
}

void print(const std::vector<std::string>& facts) {
  for (const std::string& fact : facts) print(fact, "    ");
}

void print_agenda(const explain::WhyNot& answer) {
  std::string stack;
  for (const std::string& module : answer.focus) stack += (stack.empty() ? "" : ", ") + module;
  if (answer.verdict == explain::Verdict::kFocus)
    print("all its conditions hold, with salience " + std::to_string(answer.salience) + ", but its module " +
              answer.module + " is not in focus: the next run looks at " + stack + " only; (focus " + answer.module +
              ") or auto-focus brings it there",
          "  ");
  else
    print("all its conditions hold: the next run fires it, with salience " + std::to_string(answer.salience) + "; " +
              std::to_string(answer.above) + " activations stand above it",
          "  ");
  if (!answer.first_above.empty())
    std::printf("  %s:\n",
                answer.verdict == explain::Verdict::kFocus ? "on the agenda of what is in focus" : "above it");
  for (const auto& [rule, salience] : answer.first_above) std::printf("    %s, salience %d\n", rule.c_str(), salience);
}

void print(const explain::UnmetCondition& unmet, std::size_t alternatives) {
  if (alternatives > 1)
    std::printf("  none of the %zu alternatives of its or conditions holds; the one that gets furthest:\n",
                alternatives);
  print("condition " + std::to_string(unmet.number) + " does not hold" + (unmet.text.empty() ? "" : ": " + unmet.text),
        "  ");
  print(unmet.because, "  ");
  if (unmet.fact) print(*unmet.fact, "    ");
  print("with", unmet.values);
}

void print(const lab::WhyNotAnswer::InEnvironment& found, const explain::Wanted& wanted) {
  const explain::WhyNot& answer = found.answer;
  std::string where;
  for (const auto& [name, value] : wanted) where += (where.empty() ? ", where ?" : " and ?") + name + " = " + value;
  print(explain::with_module(answer.module, answer.rule) + " (" + answer.file + ':' + std::to_string(answer.line) +
            ") in " + found.environment + where,
        "");
  switch (answer.verdict) {
    case explain::Verdict::kWaiting:
    case explain::Verdict::kFocus: print_agenda(answer); break;
    case explain::Verdict::kFired:
      print("all its conditions hold, and it has fired for what holds, the last time at " +
                seconds_text(*answer.fired_for_it) + "; it fires again when one of these facts has changed",
            "  ");
      break;
    case explain::Verdict::kTaken:
      print(
          "all its conditions hold now, but it is not on the agenda and has not fired for these facts. CLIPS "
          "evaluates a test when a fact of the test changes, not when a function in it gives another value",
          "  ");
      break;
    case explain::Verdict::kCondition: print(*answer.unmet, answer.alternatives); break;
  }
  if (!answer.unmet) {
    print(answer.facts);
    print("with", answer.values);
    if (answer.combinations > 1) std::printf("    and %zu other combinations\n", answer.combinations - 1);
  }
  if (answer.lost) {
    std::printf("  was on the agenda up to %s, until %s took it off%s\n", seconds_text(answer.lost->t).c_str(),
                answer.lost->by.empty() ? "something from outside of rules" : ("rule " + answer.lost->by).c_str(),
                answer.lost->facts.empty() ? "" : ", with");
    print(answer.lost->facts);
  }
  if (answer.fired == 0)
    std::printf("  has not fired so far\n");
  else
    std::printf("  fired %zu time%s so far, the last time at %s with\n", answer.fired, answer.fired == 1 ? "" : "s",
                seconds_text(answer.last_fired).c_str());
  print(answer.last_facts);
  if (found.makers) std::printf("%s", found.makers->text().c_str());
}

/// `id=5`; the variable may be written with its mark.
Expected<explain::Wanted> wanted_of(const std::vector<std::string>& where) {
  explain::Wanted wanted;
  for (const std::string& text : where) {
    const std::size_t equals = text.find('=');
    std::string name = text.substr(0, equals);
    name.erase(0, name.starts_with("$?") ? 2 : name.starts_with('?') ? 1 : 0);
    if (equals == text.npos || name.empty())
      return usage_error("--where: " + found_text(text, "VARIABLE=VALUE, as in id=5"));
    const auto [known, fresh] = wanted.emplace(name, text.substr(equals + 1));
    if (!fresh && known->second != text.substr(equals + 1))
      return usage_error("--where: ?" + name + " cannot have two values");
  }
  return wanted;
}

/// Answers for a fact instead of a rule.
int why_not_fact(const WhyNotOptions& options) {
  if (!options.where.empty()) return fail(usage_error("--where asks about a rule, not about a fact"));
  return ask(options.question, [&](inspect::Inspector& inspector) -> Expected<Answer> {
    inspector.assert_time();
    auto future = inspect::future_of(inspector, options.rule);
    if (!future) return future.error();
    return Answer{future->text(), lab::future_json(*future)};
  });
}

int why_not(const WhyNotOptions& options) {
  if (options.rule.starts_with('(') || options.rule.starts_with("f-")) return why_not_fact(options);
  auto wanted = wanted_of(options.where);
  if (!wanted) return fail(wanted.error());
  const Question& asked = options.question;
  auto run = open_run(asked.run, asked.trust_programs);
  if (!run) return fail(run.error());
  Console console(true);
  lab::WhyNotQuestion question{options.rule, {}, *std::move(wanted), asked.environment};
  if (asked.at) question.at = from_seconds(*asked.at);
  const auto answer = lab::why_not(*run, question, console.host());
  if (const int code = interrupted("the run was not replayed up to that time")) return code;
  if (!answer) return fail(answer.error());
  if (asked.json) {
    std::printf("%s\n", json_text(lab::to_json(*answer), 2).c_str());
    return 0;
  }
  std::printf("after the tick at %s%s%s:\n", seconds_text(answer->at).c_str(),
              answer->cut_off ? run->cut_off_text("log").c_str() : "",
              asked.at ? "" : ", the last one; --at T asks about another time");
  for (const auto& found : answer->environments) print(found, question.wanted);
  return 0;
}

}  // namespace

void add_why_not(CLI::App& app, Action& action) {
  auto options = std::make_shared<WhyNotOptions>();
  CLI::App* command = app.add_subcommand(
      "why-not",
      "Explain why a rule of a recorded run has not fired, or which rules wait for a fact and what they lack");
  add_question(*command, options->question, Times::kAt);
  command
      ->add_option("rule", options->rule,
                   "Name of the rule, with or without its module: nav, NAV::nav; or a fact: f-12, or a pattern such as "
                   "'(order (id 3))'")
      ->required();
  once_each(command->add_option("--where", options->where,
                                "VARIABLE=VALUE: only combinations in which the variable has this value (repeatable)"));
  command->footer(
      "For a fact that exists, it lists the rules that need it, and what each lacks to fire for it. For a missing "
      "fact,\n"
      "it lists the rules that could make it.\n"
      "Examples:\n  cxlab why-not runs/game-1 order-begin --at 5:12\n"
      "  cxlab why-not runs/game-1 '(product (order 2))' --at 5:12");
  command->callback([options, &action] { action = [options] { return why_not(*options); }; });
}

}  // namespace cxlab::app
