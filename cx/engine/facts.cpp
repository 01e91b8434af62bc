// Facts in and out, without a detour over text.

#include <cstring>
#include <set>
#include <span>

#include "cx/engine/template_names.h"
#include "internal/impl.h"

namespace cxlab {

using namespace clips;

Value to_value(const CLIPSValue& value) {
  const std::size_t size = value.header->type == MULTIFIELD_TYPE ? value.multifieldValue->length : 0;
  return ValueRef(value.value, value_type(*value.header), 0, size).copy();
}

void* to_clips(Environment* env, const Value& value) {
  switch (value.type()) {
    case ValueType::kInteger: return CreateInteger(env, value.as_integer());
    case ValueType::kFloat: return CreateFloat(env, value.as_number());
    case ValueType::kSymbol: return CreateSymbol(env, value.text().c_str());
    case ValueType::kString: return CreateString(env, value.text().c_str());
    case ValueType::kInstanceName:
    case ValueType::kInstance: return CreateInstanceName(env, value.text().c_str());
    case ValueType::kHandle:
      return CreateCExternalAddress(env, reinterpret_cast<void*>(static_cast<std::uintptr_t>(value.as_handle())));
    case ValueType::kFact: {
      for (Fact* fact = GetNextFact(env, nullptr); fact != nullptr; fact = GetNextFact(env, fact)) {
        if (fact->factIndex == value.fact_index()) return fact;
      }
      return &fact_data(env)->DummyFact;
    }
    case ValueType::kMultifield: {
      Multifield* list = CreateMultifield(env, value.items().size());
      for (std::size_t i = 0; i < value.items().size(); ++i) list->contents[i].value = to_clips(env, value.items()[i]);
      return list;
    }
    case ValueType::kVoid: break;
  }
  return CreateSymbol(env, "nil");
}

std::string qualified_name(const ConstructHeader& header) {
  const char* module = header.whichModule->theModule->header.name->contents;
  return std::string_view(module) == "MAIN" ? header.name->contents
                                            : std::string(module) + "::" + header.name->contents;
}

Deftemplate* RuleEngine::Impl::find_template(const std::string& name) {
  // Most facts from C++ are of a few templates of the current module: their names are looked up once.
  KnownName& known = template_names[(name.size() + static_cast<unsigned char>(name.empty() ? 0 : name.back())) %
                                    template_names.size()];
  if (known.text != name || known.atom == nullptr) {
    if (known.atom != nullptr) ReleaseLexeme(env, known.atom);
    known = {name, CreateSymbol(env, name.c_str())};
    RetainLexeme(env, known.atom);
  }
  for (Deftemplate* found = GetNextDeftemplate(env, nullptr); found != nullptr;
       found = reinterpret_cast<Deftemplate*>(found->header.next)) {
    if (found->header.name == known.atom) return found;
  }
  if (Deftemplate* found = FindDeftemplate(env, name.c_str())) return found;
  // A plugin's template lives in MAIN, whatever module the rules have made the current one.
  Defmodule* current = GetCurrentModule(env);
  Deftemplate* found = nullptr;
  for (Defmodule* module = GetNextDefmodule(env, nullptr); module != nullptr && found == nullptr;
       module = GetNextDefmodule(env, module)) {
    SetCurrentModule(env, module);
    found = FindDeftemplate(env, name.c_str());
  }
  SetCurrentModule(env, current);
  return found;
}

Fact* RuleEngine::Impl::find_fact(std::int64_t index) const {
  for (Fact* fact = fact_data(env)->LastFact; fact != nullptr; fact = fact->previousFact) {
    if (fact->factIndex == index) return fact;
  }
  return nullptr;
}

Multifield* RuleEngine::Impl::make_multifield(const std::vector<Value>& items) {
  Multifield* list = CreateUnmanagedMultifield(env, items.size());
  for (std::size_t i = 0; i < items.size(); ++i) list->contents[i].value = to_clips(env, items[i]);
  return list;
}

std::optional<Error> RuleEngine::Impl::put_slot(Deftemplate& deftemplate, const Slot& slot, CLIPSValue* slots) {
  std::size_t position = 0;
  const templateSlot* found = deftemplate.slotList;
  const auto is_name = [&slot](const char* name) {
    return std::strncmp(name, slot.name.data(), slot.name.size()) == 0 && name[slot.name.size()] == '\0';
  };
  while (found != nullptr && !is_name(found->slotName->contents)) {
    found = found->next;
    ++position;
  }
  if (found == nullptr) {
    return input_error("deftemplate '" + std::string(deftemplate.header.name->contents) + "' has no slot '" +
                       std::string(slot.name) + "'");
  }
  if (slots[position].header->type == MULTIFIELD_TYPE) ReturnMultifield(env, slots[position].multifieldValue);
  slots[position].voidValue = VoidConstant(env);
  if (found->multislot) {
    slots[position].multifieldValue =
        slot.value.is(ValueType::kMultifield) ? make_multifield(slot.value.items()) : make_multifield({slot.value});
  } else if (slot.value.is(ValueType::kMultifield)) {
    return input_error("slot '" + std::string(slot.name) + "' of deftemplate '" + deftemplate.header.name->contents +
                       "' takes one value, found a multifield");
  } else {
    slots[position].value = to_clips(env, slot.value);
  }
  return std::nullopt;
}

Expected<std::int64_t> RuleEngine::Impl::assert_made(Fact* fact) {
  const CLIPSLexeme& name = *fact->whichDeftemplate->header.name;
  Fact* asserted = Assert(fact);
  if (asserted == nullptr) return run_error("CLIPS refused a fact of '" + std::string(name.contents) + "'");
  return asserted->factIndex;
}

Expected<std::int64_t> RuleEngine::assert_string(const std::string& fact) {
  HostCall call(*impl_, {ErrorSide::kCallback, {}, {}, 0, nullptr});
  impl_->asserted_text = fact;
  Fact* asserted = AssertString(environment_, fact.c_str());
  impl_->asserted_text = {};
  if (asserted == nullptr) return input_error("not a fact that CLIPS can assert: " + fact);
  return asserted->factIndex;
}

Expected<std::int64_t> RuleEngine::assert_fact(const std::string& template_name, std::span<const Slot> slots) {
  HostCall call(*impl_, {ErrorSide::kCallback, {}, {}, 0, nullptr}, Collect::kLater);
  Deftemplate* deftemplate = impl_->find_template(template_name);
  if (deftemplate == nullptr || deftemplate->implied) {
    return input_error("there is no deftemplate '" + template_name + "'");
  }
  Fact* fact = CreateFact(deftemplate);
  for (const Slot& slot : slots) {
    if (std::optional<Error> error = impl_->put_slot(*deftemplate, slot, fact->theProposition.contents)) {
      ReturnFact(environment_, fact);
      return *error;
    }
  }
  if (!AssignFactSlotDefaults(fact)) {
    ReturnFact(environment_, fact);
    return input_error("a slot of deftemplate '" + template_name + "' has no default and was given no value");
  }
  return impl_->assert_made(fact);
}

Expected<std::int64_t> RuleEngine::assert_ordered(const std::string& name, std::span<const Value> values) {
  HostCall call(*impl_, {ErrorSide::kCallback, {}, {}, 0, nullptr}, Collect::kLater);
  Deftemplate* deftemplate = impl_->find_template(name);
  if (deftemplate == nullptr) {
    deftemplate = CreateImpliedDeftemplate(environment_, CreateSymbol(environment_, name.c_str()), true);
  }
  if (!deftemplate->implied) return input_error("'" + name + "' is a deftemplate with slots, not an ordered fact");
  Fact* fact = CreateFact(deftemplate);
  ReturnMultifield(environment_, fact->theProposition.contents[0].multifieldValue);
  fact->theProposition.contents[0].multifieldValue = impl_->make_multifield({values.begin(), values.end()});
  return impl_->assert_made(fact);
}

Status RuleEngine::modify_fact(std::int64_t index, std::span<const Slot> slots) {
  HostCall call(*impl_, {ErrorSide::kCallback, {}, {}, 0, nullptr});
  Fact* fact = impl_->find_fact(index);
  if (fact == nullptr) return input_error("there is no fact f-" + std::to_string(index));
  Deftemplate& deftemplate = *fact->whichDeftemplate;
  if (deftemplate.implied) return input_error("f-" + std::to_string(index) + " is an ordered fact and has no slots");

  const std::size_t size = deftemplate.numberOfSlots;
  std::vector<CLIPSValue> changed(size);
  for (CLIPSValue& value : changed) value.voidValue = VoidConstant(environment_);
  const auto drop = [&](CLIPSValue& value) {
    if (value.header->type == MULTIFIELD_TYPE) ReturnMultifield(environment_, value.multifieldValue);
    value.voidValue = VoidConstant(environment_);
  };
  for (const Slot& slot : slots) {
    if (std::optional<Error> error = impl_->put_slot(deftemplate, slot, changed.data())) {
      for (CLIPSValue& value : changed) drop(value);
      return *error;
    }
  }
  std::vector<char> change_map(size / 8 + 1, 0);
  bool any = false;
  for (std::size_t i = 0; i < size; ++i) {
    if (changed[i].voidValue == VoidConstant(environment_)) continue;
    const CLIPSValue& old = fact->theProposition.contents[i];
    const bool lists = changed[i].header->type == MULTIFIELD_TYPE && old.header->type == MULTIFIELD_TYPE;
    if (lists ? MultifieldsEqual(changed[i].multifieldValue, old.multifieldValue) : changed[i].value == old.value) {
      drop(changed[i]);
    } else {
      change_map[i / 8] = static_cast<char>(change_map[i / 8] | (1 << (i % 8)));
      any = true;
    }
  }
  if (any) ReplaceFact(environment_, fact, changed.data(), change_map.data());
  return {};
}

bool RuleEngine::retract(std::int64_t index) {
  HostCall call(*impl_, {ErrorSide::kCallback, {}, {}, 0, nullptr});
  Fact* fact = impl_->find_fact(index);
  if (fact == nullptr) return false;
  Retract(fact);
  return true;
}

bool RuleEngine::fact_exists(std::int64_t index) const { return impl_->find_fact(index) != nullptr; }

std::size_t RuleEngine::fact_count() const { return GetNumberOfFacts(environment_); }

FactCopy RuleEngine::Impl::copy_fact(Fact& fact) {
  FactCopy copy;
  copy.index = fact.factIndex;
  if (const KnownFact* entry = known_facts.find(&fact)) copy.number = entry->number;
  copy.module = fact.whichDeftemplate->header.whichModule->theModule->header.name->contents;
  copy.template_name = fact.whichDeftemplate->header.name->contents;
  if (fact.whichDeftemplate->implied) {
    copy.slots.emplace_back("implied", to_value(fact.theProposition.contents[0]));
    return copy;
  }
  std::size_t i = 0;
  for (const templateSlot* slot = fact.whichDeftemplate->slotList; slot != nullptr; slot = slot->next) {
    copy.slots.emplace_back(slot->slotName->contents, to_value(fact.theProposition.contents[i++]));
  }
  return copy;
}

std::vector<FactCopy> RuleEngine::facts(std::string_view template_name) const {
  std::vector<FactCopy> copies;
  for (Fact* fact = fact_data(environment_)->FactList; fact != nullptr; fact = fact->nextFact) {
    if (template_name.empty() || template_name == fact->whichDeftemplate->header.name->contents) {
      copies.push_back(impl_->copy_fact(*fact));
    }
  }
  return copies;
}

std::vector<std::string> RuleEngine::slot_names(const std::string& template_name) const {
  const Deftemplate* deftemplate = impl_->find_template(template_name);
  if (deftemplate == nullptr) return {};
  if (deftemplate->implied) return {"implied"};
  std::vector<std::string> names;
  for (const templateSlot* slot = deftemplate->slotList; slot != nullptr; slot = slot->next)
    names.emplace_back(slot->slotName->contents);
  return names;
}

Expected<FactCopy> RuleEngine::fact(std::int64_t index) const {
  Fact* fact = impl_->find_fact(index);
  if (fact == nullptr) return input_error("there is no fact f-" + std::to_string(index));
  return impl_->copy_fact(*fact);
}

std::string RuleEngine::template_module(const std::string& module, const std::string& name) const {
  Defmodule* const current = GetCurrentModule(environment_);
  SetCurrentModule(environment_, FindDefmodule(environment_, module.c_str()));
  const Deftemplate* found = FindDeftemplate(environment_, name.c_str());
  SetCurrentModule(environment_, current);
  return found == nullptr ? std::string() : found->header.whichModule->theModule->header.name->contents;
}

std::vector<std::string> template_names(const RuleEngine& engine) {
  Environment* env = engine.raw();
  Defmodule* const current = GetCurrentModule(env);
  std::set<std::string> names;
  for (Defmodule* module = GetNextDefmodule(env, nullptr); module != nullptr; module = GetNextDefmodule(env, module)) {
    SetCurrentModule(env, module);
    for (Deftemplate* known = GetNextDeftemplate(env, nullptr); known != nullptr;
         known = GetNextDeftemplate(env, known))
      names.emplace(DeftemplateName(known));
  }
  SetCurrentModule(env, current);
  return {names.begin(), names.end()};
}

FactCopy RuleEngine::Impl::copy_instance(Instance& instance) {
  FactCopy copy;
  const Defclass& own_class = *instance.cls;
  copy.module = own_class.header.whichModule->theModule->header.name->contents;
  copy.template_name = "object";
  const auto& parents = own_class.allSuperclasses;
  for (std::size_t i = 0; i < parents.classCount; ++i)
    copy.classes.emplace_back(parents.classArray[i]->header.name->contents);
  copy.slots.emplace_back("is-a", Value::symbol(own_class.header.name->contents));
  copy.slots.emplace_back("name", Value::instance_name(instance.name->contents));
  for (std::size_t i = 0; i < own_class.instanceSlotCount; ++i) {
    const InstanceSlot& slot = *instance.slotAddresses[i];
    CLIPSValue value;
    value.value = slot.value;
    copy.slots.emplace_back(slot.desc->slotName->name->contents, to_value(value));
  }
  return copy;
}

std::vector<FactCopy> RuleEngine::instances(const std::string& module) const {
  std::vector<FactCopy> copies;
  Defmodule* const rules = FindDefmodule(environment_, module.c_str());
  for (Instance* instance = GetNextInstance(environment_, nullptr); instance != nullptr;
       instance = GetNextInstance(environment_, instance)) {
    if (instance->cls->reactive && DefclassInScope(environment_, instance->cls, rules))
      copies.push_back(Impl::copy_instance(*instance));
  }
  return copies;
}

const Value* FactCopy::slot(std::string_view name) const {
  for (const auto& [slot_name, value] : slots) {
    if (slot_name == name) return &value;
  }
  return nullptr;
}

std::string FactCopy::print() const {
  const bool instance = !classes.empty();
  std::string text = instance ? slots[1].second.print() + " of " + slots[0].second.text() : "(" + template_name;
  const auto append_items = [&text](const Value& list) {
    for (const Value& item : list.items()) text += " " + item.print();
  };
  if (slots.size() == 1 && slots[0].first == "implied" && slots[0].second.is(ValueType::kMultifield)) {
    append_items(slots[0].second);
    return text + ")";
  }
  for (const auto& [name, value] : std::span(slots).subspan(instance ? 2 : 0)) {
    text += " (" + name;
    if (value.is(ValueType::kMultifield)) {
      append_items(value);
    } else {
      text += " " + value.print();
    }
    text += ")";
  }
  return instance ? text : text + ")";
}

}  // namespace cxlab
