// Slots that a template does not have, wherever a rule or function names them.

#include <map>
#include <optional>
#include <set>

#include "cx/check/judge.h"

namespace cxlab::check {

namespace {

using Templates = std::set<std::string>;

/// `slot` stands at `place`, for a fact of one of these templates.
void judge_slot(const RuleBase& base, const Templates& of, const std::string& slot, const Place& place,
                Findings& findings) {
  std::vector<std::string> known;
  std::string names;
  for (const std::string& name : of) {
    if (!base.lacks_slot(name, slot)) return;
    const std::vector<std::string> slots = base.slots_of(name);
    known.insert(known.end(), slots.begin(), slots.end());
    names += (names.empty() ? "'" : ", '") + name + '\'';
  }
  if (of.empty()) return;
  add(findings, place, "unknown-slot",
      (of.size() == 1 ? "template " + names + " has no slot '" : "templates " + names + " have no slot '") + slot +
          '\'' + did_you_mean(slot, known));
}

bool is_query_of_instances(std::string_view head) {
  return is_any(head, {"do-for-instance", "do-for-all-instances", "delayed-do-for-all-instances", "any-instancep",
                       "find-instance", "find-all-instances"});
}

/// The templates of a member `(?order order)`; none where an expression says which.
std::optional<Templates> templates_of_member(const Term& member) {
  Templates names;
  for (std::size_t i = 1; i < member.items.size(); ++i) {
    if (!is_symbol(member.items[i])) return std::nullopt;
    names.emplace(without_module(member.items[i].text));
  }
  return names.empty() ? std::nullopt : std::optional(std::move(names));
}

/// Slots that actions and queries of one construct name. A variable stands for facts of known templates only if each
/// condition, `bind` and loop that gives it a value gives it such a fact. The order of actions does not matter.
class SlotsOfActions {
 public:
  SlotsOfActions(const RuleBase& base, const Construct& construct, Findings& findings)
      : base_(base), construct_(construct), findings_(findings) {
    const std::vector<Term>& items = construct.tree.items;
    const bool is_rule = construct.is_rule();
    const std::size_t action = is_rule ? first_action(construct.tree) : 0;
    for (std::size_t i = 0; i < action; ++i) collect_condition(items, i);
    for (std::size_t i = 0; !is_rule && i < items.size(); ++i)
      if (items[i].is_list()) {  // parameters
        forget_variables(items[i]);
        break;
      }
    for (const Term& item : items) collect(item);
    for (const std::string& name : members_) forget(name);
    for (const std::string& name : in_conditions_)
      if (!of_conditions_.contains(name)) forget(name);
  }

  void judge() { walk(construct_.tree); }

 private:
  /// What a variable, or each value of a list, may stand for.
  struct Source {
    Templates names;
    std::set<std::string> from;  ///< keys of other sources
    bool unknown = false;
  };

  // The keys of a variable: as a fact, and as a list of facts.
  static std::string fact_key(const std::string& name) { return "f:" + name; }
  static std::string list_key(const std::string& name) { return "l:" + name; }

  void forget(const std::string& name) { sources_[fact_key(name)].unknown = sources_[list_key(name)].unknown = true; }
  void forget_variables(const Term& term) {
    if (const std::string name = variable_name(term); !name.empty()) forget(name);
    for (const Term& item : term.items) forget_variables(item);
  }

  void collect_condition(const std::vector<Term>& items, std::size_t i) {
    const Term& item = items[i];
    const std::string name = variable_name(item);
    if (!name.empty() && i + 2 < items.size() && items[i + 1].is("<-")) {
      of_conditions_.insert(name);
      if (items[i + 2].head().empty() || is_group(items[i + 2].head()))
        forget(name);
      else
        sources_[fact_key(name)].names.emplace(without_module(items[i + 2].head()));
    } else if (!name.empty()) {
      in_conditions_.insert(name);
    }
    for (std::size_t k = 0; k < item.items.size(); ++k) collect_condition(item.items, k);
  }

  void collect(const Term& term) {
    const std::vector<Term>& items = term.items;
    if (term.head() == "bind" && items.size() > 1 && is_variable(items[1])) {
      const std::string name = variable_name(items[1]);
      if (items.size() == 3) {
        add_fact(items[2], sources_[fact_key(name)]);
        add_list(items[2], sources_[list_key(name)]);
      } else {
        forget(name);
      }
    } else if (is_any(term.head(), {"foreach", "progn$"}) && items.size() > 2) {
      const bool listed = items[1].is_list() && items[1].items.size() == 2;  // (progn$ (?fact ?facts) ...)
      const std::string name = variable_name(listed ? items[1].items[0] : items[1]);
      add_list(listed ? items[1].items[1] : items[2], sources_[fact_key(name)]);
      sources_[list_key(name)].unknown = true;
    } else if (term.head() == "loop-for-count" && items.size() > 1) {
      forget_variables(items[1]);
    } else if ((is_query(term.head()) || is_query_of_instances(term.head())) && items.size() > 1) {
      for (const Term& member : items[1].items)
        if (!member.items.empty()) members_.insert(variable_name(member.items[0]));
    }
    for (const Term& item : items) collect(item);
  }

  /// The value of the term is a fact of ...
  static void add_fact(const Term& term, Source& to) {
    const std::string_view head = term.head();
    if (is_variable(term) && term.text.starts_with('?') && term.text.find(':') == std::string::npos)
      to.from.insert(fact_key(variable_name(term)));
    else if (head == "assert" && !term.items.back().head().empty())
      to.names.emplace(without_module(term.items.back().head()));
    else if ((head == "modify" || head == "duplicate") && term.items.size() > 1)
      add_fact(term.items[1], to);
    else if (head == "nth$" && term.items.size() == 3)
      add_list(term.items[2], to);
    else
      to.unknown = true;
  }

  /// The value of the term is a list of facts of ...
  static void add_list(const Term& term, Source& to) {
    if (is_variable(term) && term.text.find(':') == std::string::npos) {
      to.from.insert(list_key(variable_name(term)));
    } else if (is_any(term.head(), {"find-fact", "find-all-facts"}) && term.items.size() > 1) {
      for (const Term& member : term.items[1].items)
        if (const auto names = templates_of_member(member))
          to.names.insert(names->begin(), names->end());
        else
          to.unknown = true;
    } else {
      to.unknown = true;
    }
  }

  /// None: not known, or over many steps.
  std::optional<Templates> templates_of(const Source& source) const {
    constexpr std::size_t kMostSteps = 100;  // rules of a stranger may have any number
    Templates names;
    std::set<std::string> seen;
    std::vector<const Source*> open{&source};
    while (!open.empty()) {
      const Source& at = *open.back();
      open.pop_back();
      if (at.unknown) return std::nullopt;
      names.insert(at.names.begin(), at.names.end());
      for (const std::string& key : at.from) {
        if (!seen.insert(key).second) continue;
        const auto found = sources_.find(key);
        if (found == sources_.end() || seen.size() > kMostSteps) return std::nullopt;
        open.push_back(&found->second);
      }
    }
    return names;
  }

  std::optional<Templates> templates_of(const Term& fact) {
    const bool is_name = is_variable(fact) && fact.text.find(':') == std::string::npos;
    if (is_name) {
      if (const auto* of_member = find_member(variable_name(fact))) return *of_member;
      if (const auto known = known_.find(variable_name(fact)); known != known_.end()) return known->second;
    }
    Source source;
    add_fact(fact, source);
    std::optional<Templates> names = templates_of(source);
    if (is_name) known_[variable_name(fact)] = names;
    return names;
  }

  /// Null if no query around has such a member.
  const std::optional<Templates>* find_member(const std::string& name) const {
    for (auto member = in_query_.rbegin(); member != in_query_.rend(); ++member)
      if (member->first == name) return &member->second;
    return nullptr;
  }

  void judge(const std::optional<Templates>& of, const std::string& slot, const Term& at) {
    if (of) judge_slot(base_, *of, slot, {construct_.place.source, at.line}, findings_);
  }

  void walk(const Term& term) {
    const std::vector<Term>& items = term.items;
    if (const auto colon = term.text.find(':'); is_variable(term) && colon != std::string::npos) {
      if (const auto* of_member = find_member(variable_name(term)))  // elsewhere CLIPS takes ?fact:slot for a variable
        judge(*of_member, term.text.substr(colon + 1), term);
    } else if ((term.head() == "modify" || term.head() == "duplicate") && items.size() > 1) {
      const auto of = templates_of(items[1]);
      for (std::size_t i = 2; i < items.size(); ++i)
        if (!items[i].head().empty()) judge(of, std::string(items[i].head()), items[i]);
    } else if (term.head() == "fact-slot-value" && items.size() == 3 && is_symbol(items[2])) {
      judge(templates_of(items[1]), items[2].text, items[2]);
    }
    const bool of_facts = is_query(term.head());
    const std::size_t before = in_query_.size();
    if ((of_facts || is_query_of_instances(term.head())) && items.size() > 1)
      for (const Term& member : items[1].items)
        if (!member.items.empty())
          in_query_.emplace_back(variable_name(member.items[0]), of_facts ? templates_of_member(member) : std::nullopt);
    for (const Term& item : items) walk(item);
    in_query_.resize(before);
  }

  const RuleBase& base_;
  const Construct& construct_;
  Findings& findings_;
  std::set<std::string> members_, in_conditions_, of_conditions_;  // variables
  std::map<std::string, Source> sources_;
  std::map<std::string, std::optional<Templates>> known_;                   // outside of queries
  std::vector<std::pair<std::string, std::optional<Templates>>> in_query_;  // members of the queries around
};

}  // namespace

void judge_unknown_slots(const RuleBase& base, Findings& findings) {
  for (const Touch& touch : base.touches()) {
    if (!touch.term || !touch.by->judged()) continue;
    const std::vector<Term>& items = touch.term->items;
    const auto is_slot = [](const Term& item) { return !item.head().empty(); };
    if (!std::all_of(items.begin() + 1, items.end(), is_slot)) continue;  // an ordered fact
    for (std::size_t i = 1; i < items.size(); ++i)
      judge_slot(base, {touch.template_name}, std::string(items[i].head()), {touch.place.source, items[i].line},
                 findings);
  }
  for (const Construct& construct : base.constructs())
    if (construct.judged()) SlotsOfActions(base, construct, findings).judge();
}

}  // namespace cxlab::check
