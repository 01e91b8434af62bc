#include "cx/check/check.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "cx/check/judge.h"

namespace cxlab::check {

namespace {

constexpr std::string_view kUnusedAllow = "unused-allow";

// --- Constructs that are defined twice

/// What a construct defines, as CLIPS tells constructs apart; empty where another of the name may stand beside it.
std::string identity(const Construct& construct) {
  static const std::set<std::string> kNamed{"defrule",     "deftemplate", "deffacts",
                                            "deffunction", "defclass",    "defmodule"};
  if (!kNamed.contains(construct.kind)) return {};
  const auto& items = construct.tree.items;
  const auto lists = std::ranges::count_if(items, &Term::is_list);
  if (construct.kind == "deffunction" && lists == 1 && items.back().is_list()) return {};  // a declaration
  return construct.kind + ' ' + construct.module + "::" + construct.name;
}

void judge_twice(const RuleBase& base, Findings& findings) {
  std::map<std::string, const Construct*> first;
  for (const Construct& construct : base.constructs()) {
    const std::string name = identity(construct);
    if (name.empty() || !construct.place.source->loaded) continue;
    const auto [known, fresh] = first.emplace(name, &construct);
    // Who defines again what a library defines means to.
    if (!fresh && known->second->judged())
      add(findings, construct.place, "defined-twice",
          construct.kind + " '" + construct.name + "' is defined at " + known->second->place.text() +
              " already, and this one replaces it; rename or remove one");
  }
  std::set<const Source*> with_rules;  // others are settings, which may replace those of another file
  for (const Construct& construct : base.constructs())
    if (construct.is_rule()) with_rules.insert(construct.place.source);
  std::map<std::string, Place> globals;
  for (const Construct& construct : base.constructs())
    if (construct.kind == "defglobal" && construct.place.source->loaded)
      for (const Term& item : construct.tree.items)
        if (item.kind == Token::Kind::kWord && item.text.starts_with("?*")) {
          const Place place{construct.place.source, item.line};
          const auto [known, fresh] = globals.emplace(item.text, place);
          if (!fresh && known->second.source->judged &&
              (place.source == known->second.source || with_rules.contains(place.source)))
            add(findings, place, "defined-twice",
                "global " + item.text + " is defined at " + known->second.text() + " already; remove one");
        }
}

// --- Variables

class Variables {
 public:
  struct Seen {
    int count = 0, line = 0;
    bool bound = false;  ///< by bind
  };

  void read(const Term& term) {
    if (term.kind == Token::Kind::kString) texts_ += term.text + ' ';
    const std::string head(term.head());
    const bool query = head.starts_with("do-for-") || head.starts_with("delayed-do-for-") || head == "any-factp" ||
                       head.starts_with("find-");
    const bool loop = head == "foreach" || head == "progn$" || head == "loop-for-count";
    if ((query || loop) && term.items.size() > 1) {
      const Term& members = term.items[1];
      if (loop) {
        const std::string name = variable_name(members.is_list() ? members.items.front() : members);
        its_own_.insert(name);
        if (head != "loop-for-count") its_own_.insert(name + "-index");  // which foreach and progn$ count
      }
      for (const Term& member : members.items)
        if (query && !member.items.empty()) its_own_.insert(variable_name(member.items[0]));
    }
    if (const std::string name = variable_name(term); !name.empty()) {
      Seen& seen = seen_[name];
      if (++seen.count == 1) seen.line = term.line;
    }
    if (head == "bind" && term.items.size() > 1) {
      const std::string name = variable_name(term.items[1]);
      for (std::size_t i = 2; i < term.items.size(); ++i) read(term.items[i]);
      Seen& seen = seen_[name];
      if (seen.count == 0) seen.line = term.items[1].line;
      seen.bound = true;
      return;
    }
    for (const Term& item : term.items) read(item);
  }

  bool has(const std::string& name) const {
    return seen_.contains(name) || texts_.find('?' + name) != std::string::npos;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const auto& [name, seen] : seen_) out.push_back(name);
    return out;
  }

  /// The variables that are bound but never used.
  std::map<std::string, Seen> useless() const {
    std::map<std::string, Seen> out;
    for (const auto& [name, seen] : seen_) {
      const bool useless = seen.bound ? seen.count == 0 : seen.count == 1;
      if (useless && !name.empty() && !name.starts_with('_') && !its_own_.contains(name) &&
          texts_.find('?' + name) == std::string::npos)
        out.emplace(name, seen);
    }
    return out;
  }

 private:
  std::map<std::string, Seen> seen_;
  std::set<std::string> its_own_;  // of loops and queries
  std::string texts_;
};

void judge_variables(const RuleBase& base, Findings& findings) {
  std::map<std::string, int> definitions;
  for (const Construct& construct : base.constructs())
    if (construct.kind == "deffunction" && !identity(construct).empty()) ++definitions[construct.name];
  for (const Construct& construct : base.constructs()) {
    const bool function = construct.kind == "deffunction";
    if (!construct.judged() || (!construct.is_rule() && !function)) continue;
    Variables variables;
    const Term* parameters = nullptr;
    for (const Term& item : construct.tree.items) {
      if (function && !parameters) {
        parameters = item.is_list() ? &item : nullptr;
        continue;
      }
      const bool last = &item == &construct.tree.items.back();
      // The value of the last action is the function's.
      if (!function || !last || item.head() != "bind")
        variables.read(item);
      else
        for (std::size_t i = 2; i < item.items.size(); ++i) variables.read(item.items[i]);
    }
    // Callbacks, and functions that other files define as well, have the parameters that they must have.
    if (parameters && !construct.name.ends_with("-callback") && !identity(construct).empty() &&
        definitions[construct.name] == 1)
      for (const Term& parameter : parameters->items)
        if (const std::string name = variable_name(parameter); !variables.has(name) && !name.starts_with('_'))
          add(findings, {construct.place.source, parameter.line}, "used-once",
              "the function '" + construct.name + "' does not use its parameter " + parameter.text +
                  "; use it, remove it, or call it ?_" + name);
    const std::map<std::string, Variables::Seen> useless = variables.useless();
    for (const auto& [name, seen] : useless) {
      if (function && !seen.bound) continue;  // a parameter, which its callers give
      const std::string near = meant(name, variables.names());
      const auto other = useless.find(near);
      if (other != useless.end() && std::pair(other->second.line, near) > std::pair(seen.line, name))
        continue;  // said there
      add(findings, {construct.place.source, seen.line}, "used-once",
          seen.bound ? "?" + name + " is bound here and never used; remove the bind, or use the variable"
                     : "?" + name + " occurs only here in '" + construct.name + "'" +
                           (near.empty() ? "; write ? for any value, or correct the name"
                                         : ", did you mean '?" + near + "'? For any value: ?"));
    }
  }
}

// --- What nobody uses

void judge_unused(const RuleBase& base, Findings& findings) {
  std::set<std::string> overrides;
  for (const Construct& construct : base.constructs())
    if (!construct.judged() && construct.place.source->loaded) overrides.insert(construct.name);
  const auto used = [&](const std::string& name, const Construct* itself) {
    return std::ranges::any_of(base.users(name), [&](const Construct* by) { return by != itself; });
  };
  // A function is used if something else calls it, or a function that is used.
  std::map<const Construct*, std::vector<const Construct*>> called;
  std::vector<const Construct*> functions, open;
  std::set<const Construct*> alive;
  for (const Construct& construct : base.constructs()) {
    if (construct.kind != "deffunction" || identity(construct).empty()) continue;
    functions.push_back(&construct);
    bool by_others = construct.name.ends_with("-callback") || overrides.contains(construct.name) ||
                     base.outside().functions.contains(construct.name);
    for (const Construct* by : base.users(construct.name)) {
      by_others = by_others || by->kind != "deffunction" || !by->judged();
      called[by].push_back(&construct);
    }
    if (by_others) open.push_back(&construct);
  }
  while (!open.empty()) {
    const Construct* function = open.back();
    open.pop_back();
    if (!alive.insert(function).second) continue;
    const auto more = called.find(function);
    if (more != called.end()) open.insert(open.end(), more->second.begin(), more->second.end());
  }
  for (const Construct* function : functions)
    if (!alive.contains(function))
      add(findings, function->place, "unused-function",
          used(function->name, function)
              ? "only functions that nothing calls call '" + function->name + "'; use or remove them"
              : "nothing calls the function '" + function->name + "'; call it or remove it");
  for (const auto& [name, global] : base.globals())
    if (!used(name, global.defined))
      add(findings, {global.defined->place.source, global.line}, "unused-global",
          "nothing reads ?" + name + "; use it or remove it");
}

// --- Comments that allow

struct Allowance {
  Place place;
  std::string code;
  bool alone = false;  ///< on its line: for the next line that is no allowance
  bool used = false;
};

std::vector<Allowance> allowances_in(const Source& source) {
  constexpr std::string_view kMark = "; check: allow ";
  std::vector<Allowance> out;
  std::istringstream lines(source.text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::size_t at = line.find(kMark);
    if (at == std::string::npos || std::ranges::count(line.substr(0, at), '"') % 2 == 1) continue;
    std::istringstream rest(line.substr(at + kMark.size()));
    Allowance allowance{{&source, number}, {}, line.find_first_not_of(" \t;") >= at, false};
    rest >> allowance.code;
    out.push_back(std::move(allowance));
  }
  return out;
}

}  // namespace

std::string Finding::text() const { return file + ':' + std::to_string(line) + ": [" + code + "] " + message; }

const std::vector<Code>& codes() {
  static const std::vector<Code> kCodes{{"unknown-symbol", "a value is compared with a symbol that it never has"},
                                        {"unknown-slot", "a slot is named that its template does not have"},
                                        {"never-asserted", "rules read facts that nothing asserts"},
                                        {"never-read", "facts are asserted that nothing reads"},
                                        {"unused-template", "a template whose facts nothing asserts or reads"},
                                        {"never-set", "rules read a slot, or allow a value of it, that nothing sets"},
                                        {"not-loaded", "CLIPS refuses a construct"},
                                        {"defined-twice", "a construct replaces another one of the same name"},
                                        {"used-once", "a variable occurs only once"},
                                        {"loop", "rules make each other fire without an end"},
                                        {"unreachable", "the conditions of a rule can never hold"},
                                        {"unused-function", "nothing calls a function"},
                                        {"unused-global", "nothing reads a global"},
                                        {"salience", "only the salience decides which of two rules acts"},
                                        {kUnusedAllow, "a comment allows a finding that does not exist there"}};
  return kCodes;
}

void judge_constructs(const RuleBase& base, Findings& findings) {
  judge_twice(base, findings);
  judge_variables(base, findings);
  judge_unused(base, findings);
}

std::string meant(const std::string& word, const std::vector<std::string>& known) {
  constexpr std::size_t kShortest = 4;  // of shorter ones many are near
  const auto without_digits = [](std::string text) {
    std::erase_if(text, [](unsigned char c) { return std::isdigit(c) != 0; });
    return text;
  };
  if (word.size() < kShortest) return {};
  std::vector<std::string> others;
  for (const std::string& other : known)
    if (other.size() >= kShortest && without_digits(other) != without_digits(word)) others.push_back(other);
  return nearest_word(word, others);
}

RuleParts parts_of(const Construct& rule) {
  RuleParts parts;
  const std::size_t action = first_action(rule.tree);
  const auto take = [&](const auto& self, const std::vector<Term>& items, std::size_t from, std::size_t end) -> void {
    std::string fact;
    for (std::size_t i = from; i < end; ++i) {
      const Term& item = items[i];
      if (i + 1 < end && items[i + 1].is("<-")) fact = variable_name(item);
      if (!item.is_list()) continue;
      if (item.head() == "and" || item.head() == "logical") {
        self(self, item.items, 1, item.items.size());
      } else if (item.head() == "declare") {
        for (const Term& property : item.items)
          if (property.head() == "salience" && property.items.size() > 1) parts.salience = &property.items[1];
      } else {
        parts.conditions.push_back({&item, std::exchange(fact, {})});
      }
    }
  };
  take(take, rule.tree.items, 2, action);
  for (std::size_t i = action; i < rule.tree.items.size(); ++i) parts.actions.push_back(&rule.tree.items[i]);
  return parts;
}

std::vector<Finding> examine(const RuleBase& base) {
  Findings findings;
  judge_facts(base, findings);
  judge_unknown_slots(base, findings);
  judge_reach(base, findings);
  judge_constructs(base, findings);
  judge_loops(base, findings);
  judge_salience(base, findings);
  std::ranges::sort(findings);
  findings.erase(std::unique(findings.begin(), findings.end()), findings.end());
  return findings;
}

std::vector<Finding> without_allowed(std::vector<Finding> findings, const std::vector<Source>& sources) {
  std::ranges::sort(findings);
  findings.erase(std::unique(findings.begin(), findings.end()), findings.end());
  std::vector<std::string> known;
  for (const Code& code : codes()) known.emplace_back(code.name);
  std::set<std::string> done;
  for (const Source& source : sources) {
    if (!source.judged || !done.insert(source.file).second) continue;
    std::vector<Allowance> allowances = allowances_in(source);
    for (std::size_t i = 0; i < allowances.size(); ++i) {
      Allowance& allowance = allowances[i];
      int line = allowance.place.line;
      if (allowance.alone) {
        ++line;
        for (std::size_t k = i + 1; k < allowances.size() && allowances[k].alone && allowances[k].place.line == line;
             ++k)
          ++line;
      }
      allowance.used = std::erase_if(findings, [&](const Finding& f) {
                         return f.file == source.file && f.code == allowance.code &&
                                (f.line == line || f.line == allowance.place.line);
                       }) > 0;
      if (allowance.used) continue;
      const bool is_code = std::ranges::count(known, allowance.code) > 0;
      findings.push_back(
          {source.file, allowance.place.line, std::string(kUnusedAllow),
           is_code ? "nothing is found here that this comment allows; remove it"
                   : "there is no code '" + allowance.code + "' to allow" + did_you_mean(allowance.code, known)});
    }
  }
  std::ranges::sort(findings);
  return findings;
}

}  // namespace cxlab::check
