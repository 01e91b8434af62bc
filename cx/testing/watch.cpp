#include "cx/testing/watch.h"

#include <algorithm>

#include "cx/engine/value.h"
#include "cx/journal/record_value.h"

namespace cxlab::testing {

namespace {

std::string print(const RecordValue& value) {
  if (const auto* text = std::get_if<std::string>(&value.value)) return *text;
  if (const auto* integer = std::get_if<std::int64_t>(&value.value)) return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value.value)) return print_float(*number);
  if (const auto* map = std::get_if<RecordValue::Map>(&value.value); map && map->size() == 1)
    return '<' + map->front().first + ' ' + print(map->front().second) + '>';
  return "<nothing>";
}

std::vector<std::string> values_of(const RecordValue& slot) {
  const auto* list = std::get_if<RecordValue::List>(&slot.value);
  if (!list) return {print(slot)};
  std::vector<std::string> out;
  for (const RecordValue& item : *list) out.push_back(print(item));
  return out;
}

void put_slots(const RecordValue& record, FactText& fact) {
  const RecordValue* slots = record.find("slots");
  for (const auto& [name, value] : std::get<RecordValue::Map>(slots->value)) {
    const auto known =
        std::find_if(fact.slots.begin(), fact.slots.end(), [&](const auto& slot) { return slot.first == name; });
    if (known == fact.slots.end())
      fact.slots.emplace_back(name, values_of(value));
    else
      known->second = values_of(value);
  }
}

}  // namespace

StreamId Watch::open_stream(std::string_view name) {
  const auto known = std::find(streams_.begin(), streams_.end(), name);
  if (known != streams_.end()) return static_cast<StreamId>(known - streams_.begin());
  streams_.emplace_back(name);
  counts_.push_back(0);
  return static_cast<StreamId>(streams_.size() - 1);
}

void Watch::end_version(std::int64_t fact, SimTime t) {
  if (const auto live = live_.find(fact); live != live_.end()) facts_[live->second].until = t;
}

RecordRef Watch::write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                       std::span<const RecordRef>) {
  const auto index = static_cast<std::size_t>(stream);
  const RecordRef here{stream, counts_[index]++};
  const bool wanted = kind == RecordKind::kAssert || kind == RecordKind::kModify || kind == RecordKind::kRetract ||
                      kind == RecordKind::kFire;
  if (!wanted || streams_[index] != stream_name_) return here;
  const auto record = decode_record_data(data.bytes());
  if (!record) return here;
  if (kind == RecordKind::kFire) {
    firings_.push_back({t, std::string(record->text("rule"))});
    return here;
  }
  const std::int64_t number = record->integer("fact");
  end_version(number, t);
  if (kind == RecordKind::kRetract) {
    live_.erase(number);
    return here;
  }
  FactVersion version;
  version.from = t;
  if (const auto live = live_.find(number); live != live_.end()) version.fact = facts_[live->second].fact;
  version.fact.template_name = record->text("template");
  put_slots(*record, version.fact);
  live_[number] = facts_.size();
  facts_.push_back(std::move(version));
  return here;
}

}  // namespace cxlab::testing
