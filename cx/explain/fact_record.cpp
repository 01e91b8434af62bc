#include "cx/explain/fact_record.h"

#include <algorithm>

namespace cxlab::explain {

namespace {

/// A value as `RuleEngine` writes it into a record.
Value value_of(const RecordValue& record) {
  if (const auto* integer = std::get_if<std::int64_t>(&record.value)) return Value::integer(*integer);
  if (const auto* number = std::get_if<double>(&record.value)) return Value::number(*number);
  if (const auto* text = std::get_if<std::string>(&record.value)) {
    const auto between = [&](char first, char last) {
      return text->size() > 1 && text->front() == first && text->back() == last;
    };
    const std::string inner = text->size() > 1 ? text->substr(1, text->size() - 2) : std::string();
    return between('"', '"')   ? Value::string(inner)
           : between('[', ']') ? Value::instance_name(inner)
                               : Value::symbol(*text);
  }
  if (const auto* list = std::get_if<RecordValue::List>(&record.value)) {
    std::vector<Value> items;
    for (const RecordValue& item : *list) items.push_back(value_of(item));
    return Value::multifield(std::move(items));
  }
  if (record.find("handle")) return Value::handle(static_cast<Handle>(record.integer("handle")));
  if (record.find("fact")) return Value::fact(record.integer("fact"));
  return {};
}

}  // namespace

void apply(const JournalRecord& record, FactCopy& fact) {
  fact.number = static_cast<std::uint64_t>(record.data.integer("fact"));
  fact.template_name = record.data.text("template");
  const RecordValue* slots = record.data.find("slots");
  const auto* map = slots ? std::get_if<RecordValue::Map>(&slots->value) : nullptr;
  if (!map) return;
  for (const auto& [name, value] : *map) {
    const auto known =
        std::find_if(fact.slots.begin(), fact.slots.end(), [&](const auto& slot) { return slot.first == name; });
    if (known == fact.slots.end())
      fact.slots.emplace_back(name, value_of(value));
    else
      known->second = value_of(value);
  }
}

std::vector<std::int64_t> facts_of_firing(const RecordValue& data) {
  std::vector<std::int64_t> numbers;
  const RecordValue* facts = data.find("facts");
  if (const auto* list = facts ? std::get_if<RecordValue::List>(&facts->value) : nullptr)
    for (const RecordValue& fact : *list) {
      const auto* number = std::get_if<std::int64_t>(&fact.value);
      numbers.push_back(number ? *number : -1);
    }
  return numbers;
}

}  // namespace cxlab::explain
