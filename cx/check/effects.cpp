#include "cx/check/effects.h"

namespace cxlab::check {

namespace {

/// May do anything to facts, or end what the rules do.
bool is_drastic(std::string_view head) {
  return is_any(
      head, {"halt", "cx-shutdown", "focus", "pop-focus", "clear-focus-stack", "reset", "clear", "undefrule", "eval",
             "build", "assert-string", "load-facts", "bload-facts", "load", "load*", "batch", "batch*", "exit", "run"});
}

bool changes_facts(std::string_view head) { return is_any(head, {"modify", "duplicate", "retract"}); }

}  // namespace

Effects::Effects(const RuleBase& base) {
  for (const Construct& construct : base.constructs())
    if (construct.kind == "deffunction") functions_[construct.name] = &construct;
  for (const Touch& touch : base.touches())
    if (touch.by->kind == "deffunction" &&
        (touch.how == How::kAssert || touch.how == How::kModify || touch.how == How::kRetract))
      touched_[touch.by].insert(touch.template_name);
}

void Effects::add(const Term& expression, std::set<std::string>& templates) {
  const std::string head(expression.head());
  if (is_drastic(head) || changes_facts(head)) templates.insert("");
  if (head == "assert")
    for (std::size_t i = 1; i < expression.items.size(); ++i)
      templates.insert(std::string(without_module(expression.items[i].head())));
  if (functions_.contains(head)) {
    const std::set<std::string>& more = of(head);
    templates.insert(more.begin(), more.end());
  }
  for (const Term& item : expression.items) add(item, templates);
}

const std::set<std::string>& Effects::of(const std::string& function) {
  const auto known = known_.find(function);
  if (known != known_.end()) return known->second;
  std::set<std::string> templates;
  std::set<const Construct*> seen;
  std::vector<const Construct*> open{functions_.at(function)};
  const auto walk = [&](const auto& self, const Term& term) -> void {
    const std::string head(term.head());
    if (is_drastic(head)) templates.insert("");
    if (const auto called = functions_.find(head); called != functions_.end()) open.push_back(called->second);
    for (const Term& item : term.items) self(self, item);
  };
  while (!open.empty()) {
    const Construct* at = open.back();
    open.pop_back();
    if (!seen.insert(at).second) continue;
    if (const auto touched = touched_.find(at); touched != touched_.end())
      templates.insert(touched->second.begin(), touched->second.end());
    walk(walk, at->tree);
  }
  return known_[function] = std::move(templates);
}

std::vector<std::pair<std::size_t, const Term*>> Effects::takes(const std::string& function) const {
  std::vector<std::pair<std::size_t, const Term*>> out;
  const auto found = functions_.find(function);
  if (found == functions_.end()) return out;
  const std::vector<Term>& items = found->second->tree.items;
  std::size_t list = 2;
  while (list < items.size() && !items[list].is_list()) ++list;
  for (std::size_t i = list + 1; i < items.size(); ++i) {
    const std::string_view head = items[i].head();
    if (head != "retract" && head != "modify") continue;
    for (std::size_t k = 1; k < items[i].items.size() && (head == "retract" || k == 1); ++k)
      for (std::size_t p = 0; p < items[list].items.size(); ++p)
        if (const std::string name = variable_name(items[i].items[k]);
            !name.empty() && name == variable_name(items[list].items[p]))
          out.emplace_back(p, &items[i]);
  }
  return out;
}

}  // namespace cxlab::check
