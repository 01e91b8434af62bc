// What facts rest on that rules assert with `logical`.

#include <algorithm>
#include <utility>

#include "internal/impl.h"

namespace cxlab {

using namespace clips;

namespace {

std::string_view called(const expr& call) { return call.functionValue->callFunctionName->contents; }

/// Calls `visit` for each fact that these actions assert as they stand there, not within a condition or a loop.
template <class Visit>
void for_each_assert(const expr* actions, Visit visit) {
  if (actions == nullptr || actions->type != FCALL) return;
  if (called(*actions) == "assert") return visit(*actions);
  if (called(*actions) != "progn") return;
  for (const expr* action = actions->argList; action != nullptr; action = action->nextArg)
    for_each_assert(action, visit);
}

template <class Visit>
void for_each_disjunct(Environment* env, Visit visit) {
  for (Defmodule* module = GetNextDefmodule(env, nullptr); module != nullptr; module = GetNextDefmodule(env, module)) {
    const auto* rules =
        reinterpret_cast<const defruleModule*>(module->itemsArray[defrule_data(env)->DefruleModuleIndex]);
    for (auto* rule = reinterpret_cast<Defrule*>(rules->header.firstItem); rule != nullptr;
         rule = reinterpret_cast<Defrule*>(rule->header.next))
      for (Defrule* disjunct = rule; disjunct != nullptr; disjunct = disjunct->disjunct) visit(*disjunct);
  }
}

}  // namespace

/// Whether these expressions do nothing but give a value. Variables may be bound in the functions that they call only.
bool RuleEngine::Impl::only_gives_values(const expr* expressions, std::vector<const Deffunction*> within) {
  for (const expr* one = expressions; one != nullptr; one = one->nextArg) {
    if ((one->type == PROC_GET_BIND || one->type == PROC_BIND) && within.empty()) return false;
    if (one->type == GCALL) return false;  // any of its methods may be the one
    if (one->type == FCALL && (called(*one) == "bind" || is_acting(std::string(called(*one))))) return false;
    if (one->type == PCALL) {
      const auto* function = static_cast<const Deffunction*>(one->value);
      if (std::ranges::find(within, function) == within.end()) {
        std::vector<const Deffunction*> inside = within;
        inside.push_back(function);
        if (!only_gives_values(function->code, std::move(inside))) return false;
      }
    }
    if (!only_gives_values(one->argList, within)) return false;
  }
  return true;
}

/// The facts that this activation would assert and that are there rest on what it matches, as if it had fired.
void RuleEngine::Impl::support_facts_of(const Activation& activation) {
  const Defrule& rule = *activation.theRule;
  if (rule.logicalJoin == nullptr) return;
  PartialMatch* match = FindLogicalBind(rule.logicalJoin, activation.basis);
  if (match == nullptr) return;
  engineData& clips_data = *engine_data(env);
  PartialMatch* const lhs = std::exchange(clips_data.GlobalLHSBinds, activation.basis);
  PartialMatch* const rhs = std::exchange(clips_data.GlobalRHSBinds, nullptr);
  clips_data.TheLogicalJoin = rule.logicalJoin;
  Defmodule* const module = GetCurrentModule(env);
  SetCurrentModule(env, rule.header.whichModule->theModule);
  for_each_assert(rule.actions, [&](const expr& action) {
    if (!only_gives_values(action.argList)) return;
    // Without a match to rest on, CLIPS finds a fact that is there, and asserts none.
    UDFValue found;
    EvaluateExpression(env, const_cast<expr*>(&action), &found);
    if (found.header->type != FACT_ADDRESS_TYPE) return;
    clips_data.TheLogicalBind = match;
    AddLogicalDependencies(env, &found.factValue->patternHeader, false);
    clips_data.TheLogicalBind = nullptr;
  });
  SetCurrentModule(env, module);
  clips_data.TheLogicalJoin = nullptr;
  clips_data.GlobalLHSBinds = lhs;
  clips_data.GlobalRHSBinds = rhs;
}

void RuleEngine::settle_agenda() {
  HostCall call(*impl_, {ErrorSide::kCallback, "settle", {}, 0, nullptr});
  for (Defmodule* module = GetNextDefmodule(environment_, nullptr); module != nullptr;
       module = GetNextDefmodule(environment_, module)) {
    const auto* rules =
        reinterpret_cast<const defruleModule*>(module->itemsArray[defrule_data(environment_)->DefruleModuleIndex]);
    for (const Activation* one = rules->agenda; one != nullptr; one = one->next) impl_->support_facts_of(*one);
  }
  for (Defmodule* module = GetNextDefmodule(environment_, nullptr); module != nullptr;
       module = GetNextDefmodule(environment_, module))
    DeleteAllActivations(module);
}

std::vector<FactCopy> RuleEngine::facts_not_supported_when_settled() const {
  std::vector<FactCopy> out;
  for (Fact* fact = fact_data(environment_)->FactList; fact != nullptr; fact = fact->nextFact) {
    const auto* supports = static_cast<const dependency*>(fact->patternHeader.dependents);
    if (supports == nullptr) continue;
    bool again = false;
    for_each_disjunct(environment_, [&](const Defrule& rule) {
      for (const dependency* one = supports; one != nullptr; one = one->next)
        if (rule.logicalJoin != nullptr && static_cast<const PartialMatch*>(one->dPtr)->owner == rule.logicalJoin)
          for_each_assert(rule.actions, [&](const expr& action) {
            again =
                again || (action.argList->value == fact->whichDeftemplate && impl_->only_gives_values(action.argList));
          });
    });
    if (!again) out.push_back(impl_->copy_fact(*fact));
  }
  return out;
}

}  // namespace cxlab
