// What a person may ask of a run, by name.

#include <algorithm>
#include <array>
#include <iterator>

#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/explain/names.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/makers.h"
#include "cx/inspect/text.h"
#include "cx/inspect/users.h"
#include "lab/control/debugger.h"

namespace cxlab::lab {

namespace {

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// The first word, and what follows it.
std::pair<std::string, std::string> split(std::string_view text) {
  text = trimmed(text);
  const auto end = std::min(text.find_first_of(" \t"), text.size());
  return {std::string(text.substr(0, end)), std::string(trimmed(text.substr(end)))};
}

std::string place_of(const ConstructInfo& info) {
  return info.file.empty() ? std::string() : "  " + info.file + ':' + std::to_string(info.line);
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

constexpr std::array kConstructs{"defrule",   "deffacts",     "deftemplate",       "deffunction",
                                 "defglobal", "defmodule",    "defclass",          "defgeneric",
                                 "defmethod", "definstances", "defmessage-handler"};

constexpr std::size_t kMostLines = 1000;

/// One line each, of many only the last.
std::string lines_of(const std::vector<std::string>& lines, const char* none) {
  if (lines.empty()) return none;
  std::string text;
  const std::size_t first = lines.size() > kMostLines ? lines.size() - kMostLines : 0;
  if (first > 0) text = "(the last " + std::to_string(kMostLines) + " of " + std::to_string(lines.size()) + ")\n";
  for (std::size_t i = first; i < lines.size(); ++i) text += (i > first ? "\n" : "") + lines[i];
  return text;
}

}  // namespace

struct Debugger::Command {
  const char *name, *arguments, *what;
  Answer (*carry_out)(Debugger&, const std::string& rest);
  bool anywhere = false;  ///< needs no rules at the place where the person is
};

const std::vector<Debugger::Command>& Debugger::commands() {
  using A = Answer;
  using D = Debugger;
  /// For commands that look at one environment.
  static const auto look = [](D& d, auto show) -> A {
    const auto environment = d.looked_at();
    if (!environment) return {false, environment.error().message};
    Expected<std::string> text = show(**environment);
    return text ? A{true, *text} : A{false, text.error().text()};
  };
  static const auto ask = [](D& d, auto show) -> A {
    return look(d, [&](cx::Environment& e) -> Expected<std::string> {
      inspect::Inspector inspector = d.inspect(e);
      auto text = show(inspector);
      if (text && text->ends_with('\n')) text->pop_back();
      return text;
    });
  };
  static const auto count = [](D& d, const std::string& rest, std::int64_t D::* what) -> A {
    const auto n = rest.empty() ? std::optional<std::int64_t>(1) : read_number<std::int64_t>(rest);
    if (!n || *n < 1) return {false, found_text(rest, "a number from 1")};
    d.*what = *n;
    return d.go_on();
  };
  static const std::vector<Command> all{
      {"help", "[COMMAND]", "what there is", [](D& d, const std::string& rest) -> A { return {true, d.help(rest)}; },
       true},
      {"where", "", "where the run is", [](D& d, const std::string&) -> A { return {true, d.where()}; }, true},
      {"envs", "", "the environments, with their facts and rules on the agenda",
       [](D& d, const std::string&) -> A {
         std::vector<std::string> lines;
         for (const cx::Environment* e : d.environments())
           lines.push_back(e->unique_name() + "  " + std::to_string(e->engine().fact_count()) + " facts, " +
                           std::to_string(e->engine().agenda().size()) + " on the agenda" +
                           (e->unique_name() == d.selected_ ? "  (in use)" : ""));
         return {true, lines_of(lines, "none")};
       }},
      {"use", "ENV|all", "looks at this environment, and stops only there",
       [](D& d, const std::string& rest) -> A {
         std::vector<std::string> known{"all"};
         for (const cx::Environment* e : d.environments()) known.push_back(e->unique_name());
         if (std::find(known.begin(), known.end(), rest) == known.end())
           return {false, "there is no environment '" + rest + "'" + did_you_mean(rest, known)};
         d.selected_ = rest == "all" ? std::string() : rest;
         return {true, "uses " + rest};
       },
       true},
      {"facts", "[TEMPLATE|PATTERN]", "facts: all, of a template, or those that match: facts (order (id 3))",
       [](D& d, const std::string& rest) {
         return ask(d, [&](inspect::Inspector& i) -> Expected<std::string> {
           auto facts = i.present(rest);
           if (!facts) return facts.error();
           std::vector<std::string> lines;
           for (const FactCopy& fact : *facts) lines.push_back("f-" + std::to_string(fact.index) + "  " + fact.print());
           return lines_of(lines, "none");
         });
       }},
      {"agenda", "", "rules that wait to fire, the next one first",
       [](D& d, const std::string&) {
         return look(d, [](cx::Environment& e) -> Expected<std::string> {
           std::vector<std::string> lines;
           for (const ActivationInfo& a : e.engine().agenda()) {
             lines.push_back(std::to_string(a.salience) + "  " + (a.module == "MAIN" ? "" : a.module + "::") + a.rule +
                             ":");
             for (const std::int64_t fact : a.facts) lines.back() += fact < 0 ? " *" : " f-" + std::to_string(fact);
           }
           return lines_of(lines, "empty");
         });
       }},
      {"rules", "[NAME]", "rules with their places, or one as it is written",
       [](D& d, const std::string& rest) {
         return look(d, [&](cx::Environment& e) -> Expected<std::string> {
           std::vector<std::string> lines;
           for (const ConstructInfo& info : e.engine().constructs()) {
             if (info.kind != "defrule") continue;
             if (rest.empty())
               lines.push_back(explain::with_module(info.module, info.name) + place_of(info));
             else if (rest == info.name || rest == info.module + "::" + info.name)
               lines.push_back(info.text + '\n' + place_of(info));
           }
           if (!rest.empty() && lines.empty())
             return input_error("there is no rule '" + rest + "'" +
                                did_you_mean(rest, explain::names_of(e.engine(), "defrule")));
           return lines_of(lines, "none");
         });
       }},
      {"globals", "", "globals with their values",
       [](D& d, const std::string&) {
         return look(d, [](cx::Environment& e) -> Expected<std::string> {
           std::vector<std::string> lines;
           for (const auto& [name, value] : e.engine().globals()) lines.push_back("?*" + name + "* = " + value.print());
           return lines_of(lines, "none");
         });
       }},
      {"scene", "[NAME|KIND]", "what there is to see: what stands, moves or is carried where, and its state",
       [](D& d, const std::string& rest) { return said(d.knows_.look(rest)); }},
      {"changes", "FACT|PATTERN", "facts with all their changes, and who made them: changes f-12",
       [](D& d, const std::string& rest) {
         return ask(d, [&](inspect::Inspector& i) -> Expected<std::string> {
           auto found = i.facts(rest);
           if (!found) return found.error();
           return found->empty() ? "none" : inspect::text_of(*found, true);
         });
       }},
      {"firings", "[RULE]", "the last 1000 rules that fired, or firings of this one",
       [](D& d, const std::string& rest) {
         return ask(d, [&](inspect::Inspector& i) -> Expected<std::string> {
           auto found = i.firings(rest, SimTime::min(), SimTime::max());
           if (!found) return found.error();
           if (found->size() > kMostLines) found->erase(found->begin(), found->end() - kMostLines);
           return found->empty() ? "none" : inspect::text_of(*found);
         });
       }},
      {"why", "FACT|PATTERN|RULE", "how a fact came about, or why a rule fired: why f-12",
       [](D& d, const std::string& rest) {
         return ask(d, [&](inspect::Inspector& i) -> Expected<std::string> {
           auto found = i.why(rest);
           if (!found) return found.error();
           return inspect::text_of(inspect::tree_of(*found, false));
         });
       }},
      {"why-not", "RULE|FACT|PATTERN", "what a rule lacks to fire; which rules wait for a fact, or could make it",
       [](D& d, const std::string& rest) {
         if (rest.starts_with('(') || rest.starts_with("f-"))
           return ask(d, [&](inspect::Inspector& i) -> Expected<std::string> {
             auto found = inspect::future_of(i, rest);
             if (!found) return found.error();
             return found->text();
           });
         return look(d, [&](cx::Environment& e) -> Expected<std::string> {
           const ConstructInfo* rule = e.engine().find_construct("defrule", rest);
           if (!rule)
             return input_error("there is no rule '" + rest + "'" +
                                did_you_mean(rest, explain::names_of(e.engine(), "defrule")));
           if (const std::string acting = e.engine().acting_call(*rule); !acting.empty())
             return input_error("its conditions call '" + acting +
                                "', which acts: to look would change the run; cxlab why-not looks when it is over");
           const auto unmet = explain::unmet_condition(e.engine(), *rule);
           if (unmet) {
             std::string text =
                 inspect::text_of(*unmet, "condition " + std::to_string(unmet->number) + " does not hold", "");
             if (const auto makers = inspect::makers_of(d.inspect(e), *unmet)) text += makers->text();
             if (text.ends_with('\n')) text.pop_back();
             return text;
           }
           return std::string("all its conditions hold");
         });
       }},
      {"pause", "", "stops before the next rule that fires, or at the next tick",
       [](D& d, const std::string&) -> A {
         d.pause_ = true;
         return {true, d.stopped_ ? "it is stopped" : "", !d.stopped_};
       }},
      {"continue", "", "goes on", [](D& d, const std::string&) { return d.go_on(); }},
      {"step", "[N]", "goes on until N rules have fired (1)",
       [](D& d, const std::string& rest) { return count(d, rest, &D::steps_); }},
      {"tick", "[N]", "goes on to the beginning of the next tick, or the N-th",
       [](D& d, const std::string& rest) { return count(d, rest, &D::ticks_); }},
      {"at", "T", "of a recorded run: goes to the first tick from T on, 312.4 or 5:12.4",
       [](D& d, const std::string& rest) { return d.go_to_time(rest); }, true},
      {"after", "T", "of a recorded run: goes to after the last tick up to T, where cxlab facts --at T looks",
       [](D& d, const std::string& rest) { return d.go_after(rest); }, true},
      {"back", "[N]", "of a recorded run: goes back to before the last rule that fired, or the N-th last",
       [](D& d, const std::string& rest) { return d.back(rest); }, true},
      {"back-until", "RULE|PATTERN", "of a recorded run: goes back to before that rule fired, or the fact was made",
       [](D& d, const std::string& rest) { return d.back_until(rest); }, true},
      {"speed", "[X]", "plays at most X times as fast as the wall clock; 0: as fast as it can",
       [](D& d, const std::string& rest) { return d.set_speed(rest); }, true},
      {"until", "T|RULE|PATTERN", "goes on until a time, before a rule fires, or until a fact is there",
       [](D& d, const std::string& rest) {
         A set = d.set_break(rest, true);
         return set.ok ? d.go_on() : set;
       }},
      {"break", "T|RULE|PATTERN", "stops there from now on",
       [](D& d, const std::string& rest) { return d.set_break(rest, false); }},
      {"breaks", "", "the break points",
       [](D& d, const std::string&) -> A {
         std::vector<std::string> lines;
         for (const BreakPoint& point : d.breaks_) lines.push_back(std::to_string(point.number) + "  " + point.text);
         return {true, lines_of(lines, "none")};
       }},
      {"delete", "N|all", "takes a break point away",
       [](D& d, const std::string& rest) -> A {
         const auto n = read_number<int>(rest);
         const auto gone =
             std::erase_if(d.breaks_, [&](const BreakPoint& b) { return rest == "all" || (n && b.number == *n); });
         return {gone > 0 || rest == "all", gone > 0 || rest == "all" ? "" : "there is no break point '" + rest + "'"};
       }},
      {"eval", "EXPRESSION", "evaluates; (...) alone does the same",
       [](D& d, const std::string& rest) { return d.act(cx::ControlAct::Verb::kEval, rest); }},
      {"build", "CONSTRUCT", "adds a rule or another construct; (defrule ...) alone does the same",
       [](D& d, const std::string& rest) { return d.act(cx::ControlAct::Verb::kBuild, rest); }},
      {"assert", "FACT", "asserts, for example assert (order (id 3))",
       [](D& d, const std::string& rest) { return d.act(cx::ControlAct::Verb::kEval, "(assert " + rest + ")"); }},
      {"retract", "N|PATTERN", "retracts a fact by its index, or all that match",
       [](D& d, const std::string& rest) -> A {
         if (rest.empty() || rest.front() != '(') {
           const std::string index = rest.starts_with("f-") ? rest.substr(2) : rest;
           if (!read_number<std::uint64_t>(index)) return {false, found_text(rest, "a fact's index or a pattern")};
           return d.act(cx::ControlAct::Verb::kEval, "(retract " + index + ")");
         }
         const auto environment = d.looked_at();
         if (!environment) return {false, environment.error().message};
         const auto facts = d.inspect(**environment).present(rest);
         if (!facts) return {false, facts.error().text()};
         if (facts->empty()) return {false, "no fact matches " + rest};
         std::string indices;
         for (const FactCopy& fact : *facts) indices += ' ' + std::to_string(fact.index);
         return d.act(cx::ControlAct::Verb::kEval, "(retract" + indices + ")");
       }},
      {"watch", "ITEM [NAME]...", "shows facts, rules, activations, ... in the log as they change",
       [](D& d, const std::string& rest) { return d.act(cx::ControlAct::Verb::kEval, "(watch " + rest + ")"); }},
      {"unwatch", "ITEM [NAME]...", "no longer",
       [](D& d, const std::string& rest) { return d.act(cx::ControlAct::Verb::kEval, "(unwatch " + rest + ")"); }},
      {"log", "[TEXT]", "the last 1000 lines of the log, or of those that contain the text",
       [](D& d, const std::string& rest) -> A {
         std::vector<std::string> lines;
         for (const std::string& line : d.log_)
           if (lower(line).find(lower(rest)) != std::string::npos) lines.push_back(line);
         return {true, lines_of(lines, "nothing")};
       }},
  };
  return all;
}

Debugger::Answer Debugger::said(Expected<std::string> text) {
  if (!text) return {false, text.error().kind == ErrorKind::kUsage ? text.error().message : text.error().text()};
  if (text->ends_with('\n')) text->pop_back();
  return {true, *std::move(text)};
}

std::string Debugger::help(const std::string& wanted) const {
  std::string text;
  const auto add = [&](const std::string& name, const std::string& arguments, const std::string& what) {
    if (!wanted.empty() && wanted != name) return;
    std::string line = name + ' ' + arguments;
    line.resize(std::max<std::size_t>(line.size() + 2, 34), ' ');
    text += (text.empty() ? "" : "\n") + line + what;
  };
  for (const Command& command : commands()) add(command.name, command.arguments, command.what);
  for (const WorldQuestion& question : knows_.world_questions) {
    const std::string argument(question.argument), what(question.what);
    add(std::string(question.name), argument.empty() ? "" : '[' + upper(argument) + ']',
        lower(what.substr(0, 1)) + what.substr(1));
  }
  if (text.empty()) return "there is no command '" + wanted + "'";
  if (wanted.empty()) text += "\nquit                              leaves; the run stays as it is";
  return text;
}

/// Whether the rules must have been played up to the place where the person is.
bool Debugger::asks_about_place(const std::string& line) {
  const std::string word = split(line).first;
  const auto command = std::ranges::find(commands(), word, &Command::name);
  return !word.empty() && (command == commands().end() || !command->anywhere);
}

Debugger::Answer Debugger::carry_out(const std::string& line) {
  const std::string_view text = trimmed(line);
  if (text.empty()) return {};
  if (text.front() == '(') {
    const std::string head = split(text.substr(1)).first;
    const bool construct = std::find(kConstructs.begin(), kConstructs.end(), head) != kConstructs.end();
    return act(construct ? cx::ControlAct::Verb::kBuild : cx::ControlAct::Verb::kEval, std::string(text));
  }
  const auto [word, rest] = split(text);
  const std::vector<std::string> names = command_names();
  std::vector<std::string> meant;
  if (std::ranges::find(names, word) != names.end())
    meant = {word};
  else
    std::ranges::copy_if(names, std::back_inserter(meant), [&](const auto& name) { return name.starts_with(word); });
  if (meant.empty()) return {false, "there is no command '" + word + "' (help lists them)" + did_you_mean(word, names)};
  if (meant.size() > 1) return {false, "'" + word + "' may be " + meant[0] + " or " + meant[1]};
  const auto command = std::ranges::find(commands(), meant.front(), &Command::name);
  if (command != commands().end()) return command->carry_out(*this, rest);
  const auto answered = ask_world(*world_question(meant.front()), rest);
  return said(answered ? Expected<std::string>(world_text(*answered)) : answered.error());
}

std::vector<std::string> Debugger::command_names() const {
  std::vector<std::string> names;
  for (const Command& command : commands()) names.emplace_back(command.name);
  for (const WorldQuestion& question : knows_.world_questions) names.emplace_back(question.name);
  return names;
}

const WorldQuestion* Debugger::world_question(const std::string& name) const {
  const auto found = std::ranges::find(knows_.world_questions, name, &WorldQuestion::name);
  return found == knows_.world_questions.end() ? nullptr : &*found;
}

Expected<WorldAnswered> Debugger::ask_world(const WorldQuestion& question, const std::string& about) const {
  if (question.argument.empty() && !about.empty()) return usage_error("one argument too many: '" + about + "'");
  return knows_.ask_world(question, about);
}

std::vector<std::string> Debugger::completions(const std::string& begun) {
  std::vector<std::string> words;
  const auto add = [&](const std::string& word) {
    if (word.starts_with(begun)) words.push_back(word);
  };
  for (const std::string& name : command_names()) add(name);
  for (const cx::Environment* e : environments()) add(e->unique_name());
  if (const auto environment = looked_at()) {
    for (const ConstructInfo& info : (*environment)->engine().constructs()) add(info.name);
    for (const FunctionSpec& function : (*environment)->engine().functions()) add(function.name);
  }
  std::sort(words.begin(), words.end());
  words.erase(std::unique(words.begin(), words.end()), words.end());
  return words;
}

Expected<cx::Environment*> Debugger::looked_at() const {
  const auto all = environments();
  for (cx::Environment* environment : all)
    if (selected_.empty() ? here_ == nullptr || environment == here_ : environment->unique_name() == selected_)
      return environment;
  return input_error(selected_.empty() ? "there is no environment"
                                       : "there is no environment '" + selected_ + "' any more");
}

Debugger::Answer Debugger::act(cx::ControlAct::Verb verb, const std::string& text) {
  const auto environment = looked_at();
  if (!environment) return {false, environment.error().message};
  if (!stopped_) return {false, "the run goes on: pause first"};
  if (*environment != here_)
    return {false, "the run stopped in " + here_->unique_name() + "; tick goes on to where " +
                       (*environment)->unique_name() + " stops"};
  if (const std::size_t forms = read_forms(text, {}).forms.size(); forms > 1)
    return {false, "expected one expression or construct, found " + std::to_string(forms)};
  changed_ = options_.recorded;
  auto done = here_->act(verb, text);
  return done ? Answer{true, *done} : Answer{false, done.error().text()};
}

Debugger::Answer Debugger::go_on() {
  if (!stopped_) return {false, "the run goes on already"};
  if (at_end_) return {false, "this is the end of the run: at T, back and back-until go back"};
  stopped_ = false;
  return {true, {}, true};
}

std::optional<SimTime> Debugger::time_in(const std::string& text) {
  constexpr double kLongest = 1e9;
  const auto seconds = inspect::seconds_in(text);
  const auto t = seconds ? read_number<double>(*seconds) : std::nullopt;
  return t && *t < kLongest ? std::optional(from_seconds(*t)) : std::nullopt;
}

Status Debugger::check_rule(const std::string& rule) const {
  std::vector<std::string> known;
  for (const cx::Environment* e : environments())
    for (const ConstructInfo& info : e->engine().constructs())
      if (info.kind == "defrule") known.insert(known.end(), {info.name, info.module + "::" + info.name});
  if (std::ranges::find(known, rule) != known.end()) return {};
  return input_error("there is no rule '" + rule + "'" + did_you_mean(rule, known));
}

Expected<explain::Pattern> Debugger::pattern_of(const std::string& text) const {
  auto pattern = explain::Pattern::parse_plain(text, {}, 0);
  if (!pattern) return pattern;
  Status possible = input_error("there is no environment");
  for (const cx::Environment* e : environments()) {
    if (possible) break;
    possible = explain::check_names(*pattern, e->engine());
    const std::vector<FactCopy> facts = e->engine().facts(pattern->template_name());
    const auto matches = [&](const FactCopy& fact) { return pattern->matches(fact); };
    if (possible && std::ranges::none_of(facts, matches))
      possible = explain::check_values(*pattern, e->engine(), facts);
  }
  if (!possible) return possible.error();
  return pattern;
}

Debugger::Answer Debugger::set_break(const std::string& what, bool once) {
  BreakPoint point;
  const auto [word, rest] = split(what);
  point.text = what;
  if (const auto time = time_in(what)) {
    point.time = *time;
    if (here_ && place_.t >= point.time) return {false, "that time has passed"};
    point.text += " s";
  } else if (what.starts_with('(') || word == "fact") {
    auto pattern = pattern_of(word == "fact" ? rest : what);
    if (!pattern) return {false, pattern.error().message};
    point.kind = BreakPoint::Kind::kFact;
    point.pattern = *std::move(pattern);
    for (const cx::Environment* e : environments())
      if (holds(point, *e)) point.held.insert(e);
    if (once && here_ && point.held.contains(here_)) return {false, "that fact is there already"};
  } else if (!what.empty()) {
    point.kind = BreakPoint::Kind::kRule;
    point.rule = word == "rule" && !rest.empty() ? rest : what;
    if (Status s = check_rule(point.rule); !s) return {false, s.error().message};
  } else {
    return {false, "expected a time, the name of a rule, or a pattern (TEMPLATE (SLOT VALUE)...)"};
  }
  point.once = once;
  if (!once) point.number = ++last_break_;
  breaks_.push_back(std::move(point));
  return {true, once ? "" : "break point " + std::to_string(last_break_)};
}

// --- A recorded run

Debugger::Answer Debugger::only_when_recorded() {
  return {false, "this run is still played, and does not go back; when it is over: cxlab attach RUN"};
}

Debugger::Answer Debugger::go_to_time(const std::string& text) {
  if (!options_.recorded) return only_when_recorded();
  const auto time = time_in(text);
  if (!time) return {false, found_text(text, "a time such as 312.4, 5:12 or 5:12.4")};
  const auto there = std::ranges::lower_bound(visits_, *time, {}, [](const Visit& visit) { return visit.place.t; });
  if (there != visits_.end()) return show({static_cast<std::size_t>(there - visits_.begin()), there->place.fired});
  if (at_end_) return {false, "the run ends at " + seconds_text(to_seconds(place_.t))};
  breaks_.push_back({.text = text + " s", .time = *time, .once = true});
  stopped_ = false;
  return {true, {}, true};
}

Debugger::Answer Debugger::go_after(const std::string& text) {
  if (!options_.recorded) return only_when_recorded();
  const auto time = time_in(text);
  if (!time) return {false, found_text(text, "a time such as 312.4, 5:12 or 5:12.4")};
  const auto later = std::ranges::upper_bound(visits_, *time, {}, [](const Visit& visit) { return visit.place.t; });
  if (later == visits_.end()) return show(kEnd);
  const auto over = std::find_if(std::reverse_iterator(later), visits_.rend(),
                                 [](const Visit& visit) { return visit.place.fired == kAfterTick; });
  if (over == visits_.rend()) return {false, "no tick is over at " + seconds_text(to_seconds(*time))};
  return show({static_cast<std::size_t>(visits_.rend() - over) - 1, kAfterTick});
}

Debugger::Answer Debugger::set_speed(const std::string& text) {
  if (options_.recorded) return {false, "this run is over, and is played as fast as it can be"};
  if (!text.empty()) {
    constexpr double kMost = 1e6;
    const auto speed = read_number<double>(text);
    if (!speed || !(*speed >= 0 && *speed <= kMost)) return {false, found_text(text, "a number from 0 to 1000000")};
    speed_ = *speed;
    pace_.reset();
  }
  return {true, speed_ > 0 ? "at most " + general_text(speed_, 6) + " x real time" : "as fast as it can"};
}

Debugger::Answer Debugger::back(const std::string& rest) {
  if (!options_.recorded) return only_when_recorded();
  const auto n = rest.empty() ? std::optional<std::int64_t>(1) : read_number<std::int64_t>(rest);
  if (!n || *n < 1) return {false, found_text(rest, "a number from 1")};
  const auto there = before_firing(*n);
  if (!there) return {false, "no rule fired before" + std::string(rest.empty() ? "" : " that often")};
  return show(*there);
}

Debugger::Answer Debugger::back_until(const std::string& what) {
  if (!options_.recorded) return only_when_recorded();
  const bool is_fact = what.starts_with('(');
  std::optional<explain::Pattern> pattern;
  if (is_fact) {
    auto read = pattern_of(what);
    if (!read) return {false, read.error().message};
    pattern = *std::move(read);
  } else if (Status s = check_rule(what); !s) {
    return {false, s.error().message};
  }
  std::optional<Target> last;
  for (cx::Environment* environment : environments()) {
    if (!selected_.empty() && environment->unique_name() != selected_) continue;
    const inspect::Inspector inspector = inspect(*environment);
    const std::uint64_t end = end_here(*environment);
    const auto n = is_fact ? inspector.last_made(*pattern, nullptr, end) : inspector.last_firing(what, end);
    const auto there = n ? before_record(*environment, *n) : std::nullopt;
    if (there && (!last || *there > *last)) last = there;
  }
  if (!last) return {false, what + (is_fact ? " was not made before" : " did not fire before")};
  return show(*last);
}

}  // namespace cxlab::lab
