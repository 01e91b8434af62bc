// Hooks of CLIPS on facts, firings, loops and calls: the journal, the counts for the report on a loop, and what never
// ends.

#include <utility>

#include "internal/impl.h"
#include "internal/rule_counter.h"

namespace cxlab {

using namespace clips;

namespace {

// A fact `decision` is a rule's own record of what it decided and why.
RecordKind record_kind(const Fact& fact, bool again) {
  if (again) return RecordKind::kModify;
  const std::string_view name = fact.whichDeftemplate->header.name->contents;
  return name == "decision" ? RecordKind::kDecision : RecordKind::kAssert;
}

}  // namespace

void RuleEngine::set_cause(std::span<const RecordRef> causes) {
  // Mostly one record; `assign` is a call that much code would be read for.
  if (causes.size() == 1 && impl_->host_causes.size() == 1)
    impl_->host_causes.front() = causes.front();
  else
    impl_->host_causes.assign(causes.begin(), causes.end());
}

std::span<const RecordRef> RuleEngine::cause() const {
  if (impl_->rule_acting && impl_->fire_recorded) return {&impl_->fire_record, 1};
  return impl_->host_causes;
}

void RuleEngine::Impl::write(RecordKind kind) {
  engine.options_.journal->write(engine.stream_, engine.now(), kind, data, engine.cause());
}

// Symbols are written as they are, strings in their quotes, handles and facts as maps of one.
void RuleEngine::Impl::put_value(const CLIPSValue& value) {
  switch (value.header->type) {
    case INTEGER_TYPE: data.value(static_cast<std::int64_t>(value.integerValue->contents)); break;
    case FLOAT_TYPE: data.value(value.floatValue->contents); break;
    case SYMBOL_TYPE: data.value(std::string_view(value.lexemeValue->contents)); break;
    case STRING_TYPE: data.value_between("\"", value.lexemeValue->contents, "\""); break;
    case INSTANCE_NAME_TYPE: data.value_between("[", value.lexemeValue->contents, "]"); break;
    case EXTERNAL_ADDRESS_TYPE:
      data.open_map(1).text_key("handle").value(
          static_cast<std::int64_t>(reinterpret_cast<std::uintptr_t>(value.externalAddressValue->contents)));
      break;
    case FACT_ADDRESS_TYPE: {
      const KnownFact* entry = known_facts.find(value.factValue);
      data.open_map(1).text_key("fact").value(static_cast<std::int64_t>(entry == nullptr ? 0 : entry->number));
      break;
    }
    case MULTIFIELD_TYPE: {
      const Multifield& list = *value.multifieldValue;
      data.open_list(list.length);
      for (std::size_t i = 0; i < list.length; ++i) put_value(list.contents[i]);
      break;
    }
    default: data.nil();
  }
}

void RuleEngine::Impl::put_slots(const Fact& fact, bool changed_only) {
  const Deftemplate& deftemplate = *fact.whichDeftemplate;
  const CLIPSValue* values = fact.theProposition.contents;
  data.name("slots");
  if (deftemplate.implied) {
    data.open_map(1).text_key("implied");
    put_value(values[0]);
    return;
  }
  const auto skipped = [&](std::size_t i) { return changed_only && old_slots[i] == values[i].value; };
  std::size_t size = deftemplate.numberOfSlots;
  for (std::size_t i = 0; changed_only && i < deftemplate.numberOfSlots; ++i) size -= skipped(i);
  data.open_map(size);
  std::size_t i = 0;
  for (const templateSlot* slot = deftemplate.slotList; slot != nullptr; slot = slot->next, ++i) {
    if (skipped(i)) continue;
    data.text_key(slot->slotName->contents);
    put_value(values[i]);
  }
}

void RuleEngine::Impl::on_assert(Environment*, void* asserted, void* self) noexcept {
  Impl& impl = *static_cast<Impl*>(self);
  const Fact& fact = *static_cast<Fact*>(asserted);
  const bool again = &fact == impl.modified;
  KnownFact& entry = again ? *impl.known_facts.find(&fact) : impl.known_facts.insert(&fact);
  if (again) {
    impl.modified_again = true;
  } else {
    entry.number = ++impl.last_fact_number;
  }
  impl.note_change(fact);
  impl.glance_at_limits();
  RecordSink* journal = impl.engine.options_.journal;
  if (journal == nullptr) return;
  impl.data.begin().field("fact", entry.number).field("template", fact.whichDeftemplate->header.name->contents);
  impl.put_slots(fact, again);
  evaluation_data(impl.env)->Steps += impl.data.bytes().size() / kBytesOfAStep;
  entry.record =
      journal->write(impl.engine.stream_, impl.engine.now(), record_kind(fact, again), impl.data, impl.engine.cause())
          .n;
}

void RuleEngine::Impl::on_retract(Environment*, void* retracted, void* self) noexcept {
  Impl& impl = *static_cast<Impl*>(self);
  const Fact& fact = *static_cast<Fact*>(retracted);
  if (&fact == impl.modified) return;
  RetainFact(static_cast<Fact*>(retracted));
  impl.kept_facts.push_back(static_cast<Fact*>(retracted));
  const KnownFact* entry = impl.known_facts.find(&fact);
  if (entry == nullptr) return;
  if (impl.engine.options_.journal != nullptr) {
    impl.data.begin().field("fact", entry->number).field("template", fact.whichDeftemplate->header.name->contents);
    impl.write(RecordKind::kRetract);
  }
  impl.note_change(fact);
  impl.known_facts.erase(&fact);
}

void RuleEngine::Impl::on_modify(Environment*, Fact* before, Fact*, void* self) noexcept {
  Impl& impl = *static_cast<Impl*>(self);
  if (before != nullptr) {
    impl.modified = before;
    impl.modified_again = false;
    impl.old_slots.clear();
    for (std::size_t i = 0; i < before->theProposition.length; ++i) {
      const CLIPSValue& slot = before->theProposition.contents[i];
      impl.old_slots.push_back(slot.value);
      Retain(impl.env, slot.header);
      impl.kept_values.push_back(slot.header);
    }
    return;
  }
  const Fact* fact = std::exchange(impl.modified, nullptr);
  // The changed fact equals another one, so CLIPS removed it.
  if (fact != nullptr && !impl.modified_again) on_retract(impl.env, const_cast<Fact*>(fact), self);
}

void RuleEngine::Impl::release_kept() {
  if (kept_facts.empty() && kept_values.empty()) return;
  for (TypeHeader* value : kept_values) Release(env, value);
  for (Fact* fact : kept_facts) ReleaseFact(fact);
  kept_values.clear();
  kept_facts.clear();
  // Else the facts would wait for other garbage.
  utility_data(env)->CurrentGarbageFrame->dirty = true;
}

void RuleEngine::Impl::on_fire(Environment*, Activation* activation, void* self) noexcept {
  Impl& impl = *static_cast<Impl*>(self);
  if (impl.rule_open) impl.flush_errors();
  const auto keep = [&impl](CLIPSLexeme*& kept, CLIPSLexeme* name, std::string_view& text) {
    if (name == kept) return;
    if (kept != nullptr) ReleaseLexeme(impl.env, kept);
    kept = name;
    RetainLexeme(impl.env, name);
    text = name->contents;
  };
  const ConstructHeader& rule = activation->theRule->header;
  keep(impl.rule_atom, rule.name, impl.rule_name);
  keep(impl.module_atom, rule.whichModule->theModule->header.name, impl.rule_module);
  impl.rule_open = true;
  impl.rule_acting = true;
  impl.turns = 0;
  impl.reads_at_end = 0;
  impl.rule_depth = impl.contexts.size();
  impl.note_firing(*activation);
  impl.glance_at_limits();
  impl.fire_recorded = false;
  if (impl.counter) impl.counter->fires(*activation->theRule);
  RecordSink* journal = impl.engine.options_.journal;
  if (journal == nullptr) return;

  const partialMatch& basis = *activation->basis;
  impl.fire_causes.clear();
  impl.data.begin().field("rule", impl.rule_name);
  if (impl.rule_module != "MAIN") impl.data.field("module", impl.rule_module);
  impl.data.name("facts").open_list(basis.bcount);
  for (unsigned short i = 0; i < basis.bcount; ++i) {
    const AlphaMatch* match = basis.binds[i].gm.theMatch;
    const KnownFact* entry = match == nullptr ? nullptr : impl.known_facts.find(match->matchingItem);
    if (entry == nullptr) {
      impl.data.nil();
      continue;
    }
    impl.data.value(static_cast<std::int64_t>(entry->number));
    impl.fire_causes.push_back({impl.engine.stream_, entry->record});
  }
  impl.fire_record =
      journal->write(impl.engine.stream_, impl.engine.now(), RecordKind::kFire, impl.data, impl.fire_causes);
  impl.fire_recorded = true;
}

void RuleEngine::Impl::on_fired(Environment*, Activation* activation, void* self) noexcept {
  Impl& impl = *static_cast<Impl*>(self);
  if (activation == nullptr) return;
  impl.rule_acting = false;
  if (impl.counter) impl.counter->has_fired();
  // A deffunction may have called `run`.
  if (evaluation_data(impl.env)->CurrentEvaluationDepth == 0) impl.release_kept();
  ++impl.fired;
  impl.rule_halted = GetHaltRules(impl.env);
  if (impl.limit > 0 && impl.fired >= impl.limit && impl.anything_left()) {
    impl.limit_reached = true;
    SetHaltRules(impl.env, true);
  }
}

void RuleEngine::Impl::on_clear(Environment*, void* self) noexcept {
  Impl& impl = *static_cast<Impl*>(self);
  impl.known_facts.clear();
  impl.constructs.clear();
  impl.construct_index.clear();
  impl.definitions.clear();
  impl.calls_of.clear();
  impl.known_acting.clear();
  impl.lhs_calls_of.clear();
  impl.rules_calling.clear();
  impl.functions_calling.clear();
  impl.reported_lhs.clear();
}

namespace {

/// Evaluates expressions of a construct, with it as the context of what goes wrong.
template <class Evaluate>
void reset_construct(RuleEngine::Impl& impl, const char* kind, ConstructHeader& header, Evaluate evaluate) {
  const std::string name = std::string(kind) + ' ' + header.name->contents;
  const ConstructInfo* info = impl.engine.find_construct(kind, qualified_name(header));
  const std::string file = info ? info->file : "";  // what is evaluated may load constructs, which moves `info`
  impl.flush_errors();
  impl.contexts.push_back({ErrorSide::kCallback, name, file, info ? info->line : 0, nullptr});
  evaluate();
  impl.flush_errors();
  impl.contexts.pop_back();
}

/// Calls `visit` for the constructs of each module, while that is the current one.
template <class Construct, class Visit>
void for_each_module(Environment* env, Construct* (*next)(Environment*, Construct*), Visit visit) {
  Defmodule* current = GetCurrentModule(env);
  for (Defmodule* module = GetNextDefmodule(env, nullptr); module != nullptr; module = GetNextDefmodule(env, module)) {
    SetCurrentModule(env, module);
    for (Construct* one = next(env, nullptr); one != nullptr; one = next(env, one)) visit(*one);
  }
  SetCurrentModule(env, current);
}

}  // namespace

void RuleEngine::Impl::on_reset_deffacts(Environment* env, void* self) {
  for_each_module<Deffacts>(env, GetNextDeffacts, [&](Deffacts& deffacts) {
    if (deffacts.assertList == nullptr) return;
    reset_construct(*static_cast<Impl*>(self), "deffacts", deffacts.header, [&] {
      UDFValue ignored;
      SetEvaluationError(env, false);
      EvaluateExpression(env, deffacts.assertList, &ignored);
    });
  });
}

void RuleEngine::Impl::on_reset_definstances(Environment* env, void* self) {
  for_each_module<Definstances>(env, GetNextDefinstances, [&](Definstances& definstances) {
    reset_construct(*static_cast<Impl*>(self), "definstances", definstances.header, [&] {
      ++definstances.busy;
      UDFValue made;
      for (Expression* make = definstances.mkinstance; make != nullptr; make = make->nextArg) {
        EvaluateExpression(env, make, &made);
        if (GetHaltExecution(env) || made.value == FalseSymbol(env)) break;
      }
      --definstances.busy;
    });
  });
}

void RuleEngine::Impl::install_hooks() {
  for (voidCallFunctionItem* item = construct_data(env)->ListOfResetFunctions; item != nullptr; item = item->next) {
    const std::string_view name = item->name;
    if (name != "deffacts" && name != "definstances") continue;
    item->func = name == "deffacts" ? on_reset_deffacts : on_reset_definstances;
    item->context = this;
  }
  AddAssertFunction(env, "cxlab", on_assert, 0, this);
  AddRetractFunction(env, "cxlab", on_retract, 0, this);
  AddModifyFunction(env, "cxlab", on_modify, 0, this);
  AddBeforeRuleFiresFunction(env, "cxlab", on_fire, 0, this);
  AddAfterRuleFiresFunction(env, "cxlab", on_fired, 0, this);
  AddClearFunction(env, "cxlab", on_clear, 0, this);
  AddPeriodicFunction(env, "cxlab", on_turn, 0, this);
  call_deffunction = std::exchange(evaluation_data(env)->PrimitivesArray[PCALL]->evaluateFunction, on_deffunction);
  call_generic = std::exchange(evaluation_data(env)->PrimitivesArray[GCALL]->evaluateFunction, on_generic);
}

}  // namespace cxlab
