#include "lab/moment_facts.h"

#include <algorithm>
#include <cstring>

#include "cx/explain/names.h"
#include "cx/explain/pattern.h"

namespace cxlab::lab {

namespace {

constexpr const char *kOpenClient = "(ros-msgs-client (service ",
                     *kOpenActionClient = "(ros-msgs-action-client (server ";

/// An expression that opens what this fact of the generic plugin says is open; empty for other facts.
std::string call_that_opens(const std::string& fact) {
  static const std::pair<const char*, const char*> kOpened[] = {{"(ros-msgs-subscription (topic ", "subscription"},
                                                                {"(ros-msgs-publisher (topic ", "publisher"},
                                                                {kOpenClient, "client"},
                                                                {kOpenActionClient, "action-client"}};
  for (const auto& [begin, kind] : kOpened) {
    if (!fact.starts_with(begin)) continue;
    std::string arguments = fact.substr(std::strlen(begin));
    if (const std::size_t type = arguments.find(") (type "); type != std::string::npos)
      arguments.replace(type, std::strlen(") (type "), " ");
    if (arguments.ends_with("))")) arguments.pop_back();
    return std::string("(ros-msgs-create-") + kind + ' ' + arguments;
  }
  return {};
}

/// The values of a slot in an expression that CLIPS does not check before it evaluates it.
std::string unchecked(const Value& value) {
  if (!value.is(ValueType::kMultifield)) return "(nth$ 1 (create$ " + value.print() + "))";
  std::string items;
  for (const Value& item : value.items()) items += ' ' + item.print();
  return "(create$" + items + ')';
}

/// What asserts a fact whose template does not allow its values. Null pointers are left to the default.
std::string expression_of(const FactCopy& fact, const RuleEngine& engine) {
  const std::string begin = '(' + fact.template_name;
  std::string out = begin;
  for (const auto& [name, value] : fact.slots) {
    FactCopy alone = fact;
    alone.slots = {{name, value}};
    const std::string text = alone.print();
    const bool is_null = value.is(ValueType::kHandle) && value.as_handle() == Handle::kNone;
    if (is_null && !has_allowed_values(begin + " (" + name + " nil))", engine)) continue;
    out += has_pointer(text) || has_allowed_values(text, engine)
               ? text.substr(begin.size(), text.size() - begin.size() - 1)
               : " (" + name + ' ' + unchecked(value) + ')';
  }
  return out + ')';
}

}  // namespace

std::string yaml_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + '\'';
}

bool has_pointer(const std::string& fact) {
  return fact.find("<Pointer-") != std::string::npos || fact.find("<Fact-") != std::string::npos;
}

bool has_allowed_values(const std::string& fact, const RuleEngine& engine) {
  const auto pattern = explain::Pattern::parse_plain(fact, "", 0);
  return pattern && explain::check_values(*pattern, engine, {}).ok();
}

void MomentFacts::begin(const RuleEngine& engine) {
  at_the_start_.clear();
  for (const auto& [global, value] : engine.globals()) at_the_start_[global] = value.print();
  for (const FactCopy& fact : engine.facts()) at_the_start_[fact.print()];
}

void MomentFacts::read(RuleEngine& engine, const MomentExchanges& exchanges) {
  const std::vector<FactCopy> facts = engine.facts();
  for (const FactCopy& fact : facts)
    if (fact.print().starts_with("(ros-msgs-")) of_plugin_.push_back(fact.print());
  std::vector<std::string> handles;  // of goals that the story sends
  for (const auto& [name, goals] : exchanges.actions())
    for (const Exchange& goal : goals)
      if (!goal.handle.empty() && has_action_client(name)) handles.push_back(goal.handle);
  for (const FactCopy& fact : facts) {
    const std::string text = fact.print();
    if (text == "(initial-fact)") continue;
    const bool is_checked =
        (fact.slots.size() == 1 && fact.slots[0].first == "implied") || has_allowed_values(text, engine);
    const std::string expression = is_checked ? "" : expression_of(fact, engine);
    if (const std::string why = what_it_lacks(is_checked ? text : expression, handles); why.empty())
      given_.push_back({text, "<Fact-" + std::to_string(fact.index) + '>', expression == text ? "" : expression});
    else
      lost_.push_back("left out, because " + why + ": " + text);
  }
  for (const FactCopy& fact : engine.facts_not_supported_when_settled())
    lost_.push_back("stays when the facts go from which it follows, because its rule computes it: " + fact.print());
  for (const auto& [name, goals] : exchanges.actions())
    if (!has_action_client(name) && exchanges.any_under_way(goals))
      lost_.push_back(name + " has a goal from before, sent through a binding: how it ends is not in the story");
  for (const auto& [name, requests] : exchanges.services())
    if (!has_client(name) && exchanges.any_under_way(requests))
      lost_.push_back(name + " has a request from before, sent through a binding: its answer is not in the story");
  for (const auto& [global, value] : engine.globals())
    if (const auto then = at_the_start_.find(global); then == at_the_start_.end() || then->second != value.print())
      globals_.emplace_back(global,
                            value.is(ValueType::kMultifield) ? "(create$ " + value.print().substr(1) : value.print());
  note_next_symbol(engine);
  if (const std::size_t waiting = engine.agenda().size(); waiting > 0)
    lost_.push_back(std::to_string(waiting) + " rules were on the agenda without their turn: a story forgets them");
}

/// `gensym` goes on where it was: `setgen` takes back that it was asked.
void MomentFacts::note_next_symbol(RuleEngine& engine) {
  const auto next = engine.eval("(gensym)");
  if (!next || !next->print().starts_with("gen")) return;
  const std::string set = "(setgen " + next->print().substr(3) + ")";
  if (engine.eval(set) && set != "(setgen 1)") setgen_ = set;
}

/// Why a fact that points to something cannot be given; empty if it can.
std::string MomentFacts::what_it_lacks(const std::string& fact, const std::vector<std::string>& handles) {
  std::string text = fact;
  for (const std::string& handle : handles)
    for (std::size_t at; (at = text.find(handle)) != std::string::npos;) text.erase(at, handle.size());
  if (text.find("<Pointer-") != std::string::npos) return "the message or goal to which it points is not in a story";
  std::vector<Given*> named;
  for (std::size_t at = 0; (at = text.find("<Fact-", at)) != std::string::npos; ++at) {
    const auto found = std::ranges::find(given_, text.substr(at, text.find('>', at) + 1 - at), &Given::name);
    if (found == given_.end()) return "the fact to which it points is not given before it";
    named.push_back(&*found);
  }
  for (Given* one : named) one->is_named = true;
  return {};
}

std::string MomentFacts::given() const {
  std::string out;
  for (const auto& [text, name, expression, is_named] : given_) {
    const std::string fact = yaml_quoted(expression.empty() ? text : expression);
    const bool needs_name = is_named || !expression.empty();
    out += "    - " + (needs_name ? "{fact: " + fact + ", as: " + yaml_quoted(name) + '}' : fact) + '\n';
  }
  return out;
}

/// They open what rules had opened after the start, and set what had changed by then.
std::string MomentFacts::calls() const {
  std::string out;
  for (const Given& fact : given_)
    if (const std::string call = call_that_opens(fact.text); !call.empty() && !at_the_start_.contains(fact.text))
      out += "    - " + yaml_quoted(call) + '\n';
  if (!setgen_.empty()) out += "    - " + yaml_quoted(setgen_) + '\n';
  for (const auto& [global, value] : globals_)
    out += "    - " + yaml_quoted("(bind ?*" + global + "* " + value + ")") + '\n';
  return out;
}

std::vector<std::string> MomentFacts::texts() const {
  std::vector<std::string> out;
  for (const Given& fact : given_) out.push_back(fact.text);
  return out;
}

bool MomentFacts::has_open(const std::string& begin, const std::string& name) const {
  return std::ranges::any_of(of_plugin_, [&](const std::string& fact) {
    return fact.starts_with(begin + '"' + name + '"') || fact.starts_with(begin + '"' + name.substr(1) + '"');
  });
}

bool MomentFacts::has_action_client(const std::string& name) const { return has_open(kOpenActionClient, name); }
bool MomentFacts::has_client(const std::string& service) const { return has_open(kOpenClient, service); }

std::string MomentFacts::as_written(const std::string& name) const {
  const std::string relative = '"' + name.substr(1) + '"';
  const auto has = [&](const std::string& fact) { return fact.find(relative) != std::string::npos; };
  return std::ranges::any_of(of_plugin_, has) ? name.substr(1) : name;
}

}  // namespace cxlab::lab
