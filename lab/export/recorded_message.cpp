#include "lab/export/recorded_message.h"

#include <cmath>
#include <limits>
#include <optional>

#include "cx/journal/journal_reader.h"

namespace cxlab::lab {

namespace {

std::optional<double> real_of(const RecordValue& value) {
  if (const auto* real = std::get_if<double>(&value.value)) return *real;
  if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return static_cast<double>(*whole);
  if (const auto* text = std::get_if<std::string>(&value.value)) {
    if (*text == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (*text == "inf") return std::numeric_limits<double>::infinity();
    if (*text == "-inf") return -std::numeric_limits<double>::infinity();
  }
  return std::nullopt;
}

std::optional<std::int64_t> whole_of(const RecordValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return *whole;
  if (const auto* large = std::get_if<std::uint64_t>(&value.value)) return static_cast<std::int64_t>(*large);
  if (const auto* flag = std::get_if<bool>(&value.value)) return *flag ? 1 : 0;
  return std::nullopt;
}

Status set_element(const bus::MessageView& message, const bus::Field& field, std::size_t index,
                   const RecordValue& value) {
  if (field.is_message()) return set_message(message.nested(field, index), value);
  if (field.is_text()) {
    if (const auto* text = std::get_if<std::string>(&value.value)) return message.set_text(field, *text, index);
  } else if (field.is_real()) {
    if (const auto real = real_of(value)) {
      message.set_real(field, *real, index);
      return {};
    }
  } else if (const auto whole = whole_of(value)) {
    return message.set_integer(field, *whole, index);
  }
  return input_error("field '" + field.name + "': " + found_expected(to_json(value), field.type_text()));
}

}  // namespace

Status set_message(const bus::MessageView& message, const RecordValue& recorded) {
  const std::string& type = message.type().name();
  const auto* map = std::get_if<RecordValue::Map>(&recorded.value);
  if (!map) return input_error(found_expected(to_json(recorded), "a message " + type));
  const auto& fields = message.type().fields();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const bus::Field& field = fields[i];
    // Fields are recorded in their order.
    const RecordValue* value = i < map->size() && (*map)[i].key == field.name ? &(*map)[i].value : nullptr;
    if (!value)
      return input_error("a message " + type + " of the journal has no field '" + field.name +
                         "' where its definition has it");
    if (field.array == bus::ArrayKind::kSingle) {
      if (Status s = set_element(message, field, 0, *value); !s) return s;
      continue;
    }
    const auto* list = std::get_if<RecordValue::List>(&value->value);
    if (!list) return input_error("field '" + field.name + "': " + found_expected(to_json(*value), "a list"));
    if (field.is_sequence()) {
      if (Status s = message.resize(field, list->size()); !s) return s;
    } else if (list->size() != field.size_limit) {
      return input_error("field '" + field.name + "': " +
                         found_expected(std::to_string(list->size()) + " elements", std::to_string(field.size_limit)));
    }
    for (std::size_t k = 0; k < list->size(); ++k)
      if (Status s = set_element(message, field, k, (*list)[k]); !s) return s;
  }
  if (map->size() != fields.size())
    return input_error("a message " + type + " of the journal has " + std::to_string(map->size()) +
                       " fields, its definition has " + std::to_string(fields.size()));
  return {};
}

}  // namespace cxlab::lab
