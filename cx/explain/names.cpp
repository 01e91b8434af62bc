#include "cx/explain/names.h"

#include <algorithm>
#include <optional>

namespace cxlab::explain {

namespace {

/// The slots of a deftemplate; none for one that CLIPS has made for an ordered fact.
std::optional<std::vector<std::string>> slots_of(const RuleEngine& engine, const std::string& name) {
  const ConstructInfo* info = engine.find_construct("deftemplate", name);
  if (info == nullptr) return std::nullopt;
  std::vector<std::string> slots;
  for (const Term& item : tree_of(Form{info->text, info->line, true, info->kind, info->name}).items)
    if (item.items.size() > 1 &&
        (item.head() == "slot" || item.head() == "multislot" || item.head() == "field" || item.head() == "multifield"))
      slots.push_back(item.items[1].text);
  return slots;
}

}  // namespace

std::string with_module(const std::string& module, const std::string& name) {
  return module.empty() || module == "MAIN" ? name : module + "::" + name;
}

std::vector<std::string> names_of(const RuleEngine& engine, std::string_view kind) {
  std::vector<std::string> names;
  for (const ConstructInfo& info : engine.constructs())
    if (info.kind == kind) names.push_back(info.name);
  return names;
}

Status check_names(const Pattern& pattern, const RuleEngine& engine) {
  const std::string& name = pattern.template_name();
  if (pattern.is_object()) return {};
  const auto slots = slots_of(engine, name);
  if (!slots && !engine.has("deftemplate", name)) {
    std::vector<std::string> known = names_of(engine, "deftemplate");
    for (const FactCopy& fact : engine.facts()) known.push_back(fact.template_name);
    return input_error("there is no template '" + name + "'" + did_you_mean(name, known));
  }
  for (const std::string& slot : pattern.slot_names()) {
    if (!slots) return input_error("template '" + name + "' has no slots: its facts are ordered");
    if (std::ranges::count(*slots, slot) == 0)
      return input_error("template '" + name + "' has no slot '" + slot + "'" + did_you_mean(slot, *slots));
  }
  return {};
}

}  // namespace cxlab::explain
