#include "cx/journal/journal_reader.h"

#include <algorithm>
#include <cerrno>
#include <charconv>

#include "cx/base/json.h"
#include "cx/base/number_text.h"

namespace cxlab {
namespace {

constexpr int kDeepest = 64;

bool convert(const Json& json, RecordValue& out, int depth) {
  if (depth > kDeepest) return false;
  switch (json.type()) {
    case Json::value_t::boolean: out.value = json.get<bool>(); break;
    case Json::value_t::number_integer: out.value = json.get<std::int64_t>(); break;
    case Json::value_t::number_unsigned:
      if (const auto number = json.get<std::uint64_t>(); number > INT64_MAX)
        out.value = number;
      else
        out.value = static_cast<std::int64_t>(number);
      break;
    case Json::value_t::number_float: out.value = json.get<double>(); break;
    case Json::value_t::string: out.value = json.get<std::string>(); break;
    case Json::value_t::array: {
      RecordValue::List list;
      for (const Json& item : json) {
        if (!convert(item, list.emplace_back(), depth + 1)) return false;
      }
      out.value = std::move(list);
      break;
    }
    case Json::value_t::object: {
      RecordValue::Map map;
      for (const auto& [key, item] : json.items()) {
        map.push_back({key, {}});
        if (!convert(item, map.back().value, depth + 1)) return false;
      }
      out.value = std::move(map);
      break;
    }
    default: out.value = std::monostate{};
  }
  return true;
}

struct Converter {
  Json operator()(std::monostate) const { return nullptr; }
  Json operator()(const RecordValue::List& list) const {
    Json out = Json::array();
    for (const RecordValue& item : list) out.push_back(std::visit(*this, item.value));
    return out;
  }
  Json operator()(const RecordValue::Map& map) const {
    Json out = Json::object();
    for (const auto& [key, item] : map) out[key] = std::visit(*this, item.value);
    return out;
  }
  Json operator()(const auto& scalar) const { return scalar; }
};

std::optional<JournalRecord::Cause> parse_cause(const std::string& text) {
  const auto colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  const auto n = read_number<std::uint64_t>(std::string_view(text).substr(colon + 1));
  return n ? std::optional(JournalRecord::Cause{text.substr(0, colon), *n}) : std::nullopt;
}

/// The kind of a line as the journal writes it, with nothing nested before it; none if it looks otherwise.
std::optional<RecordKind> kind_in_head(std::string_view line) {
  static constexpr std::string_view kKey = "\"kind\":\"";
  const std::string_view head = line.substr(0, line.find('{', 1));
  const auto key = head.find(kKey);
  if (key == std::string_view::npos) return std::nullopt;
  const std::string_view rest = head.substr(key + kKey.size());
  return record_kind(rest.substr(0, rest.find('"')));
}

/// Takes a text from the front of another one.
bool take(std::string_view& rest, std::string_view wanted) {
  if (!rest.starts_with(wanted)) return false;
  rest.remove_prefix(wanted.size());
  return true;
}

template <class T>
bool take_number(std::string_view& rest, T& out) {
  if (rest.starts_with('0') && rest.size() > 1 && rest[1] >= '0' && rest[1] <= '9') return false;  // no JSON
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), out);
  if (error != std::errc()) return false;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return true;
}

/// Takes what stands before a quote, of ASCII without escapes: of any other text the parser says whether it is one.
bool take_plain_text(std::string_view& rest, std::string_view& out) {
  const auto end = rest.find('"');
  if (end == rest.npos) return false;
  out = rest.substr(0, end);
  rest.remove_prefix(end + 1);
  return std::ranges::all_of(out, [](char c) { return c >= ' ' && c <= '~' && c != '\\'; });
}

/// "a:1","b:2", or nothing.
bool are_plain_causes(std::string_view causes) {
  for (bool first = true; !causes.empty(); first = false) {
    std::string_view cause;
    if ((!first && !take(causes, ",")) || !take(causes, "\"") || !take_plain_text(causes, cause)) return false;
    const auto colon = cause.rfind(':');
    std::uint64_t n = 0;
    if (colon == cause.npos) return false;
    cause.remove_prefix(colon + 1);
    if (!take_number(cause, n) || !cause.empty()) return false;
  }
  return true;
}

}  // namespace

std::optional<RecordKind> record_kind(std::string_view word) {
  for (int i = 0; i <= static_cast<int>(RecordKind::kError); ++i) {
    if (word == to_string(static_cast<RecordKind>(i))) return static_cast<RecordKind>(i);
  }
  return std::nullopt;
}

std::optional<JournalLine> split_journal_line(std::string_view line) {
  JournalLine out;
  std::string_view kind;
  std::int64_t t = 0;
  if (!take(line, "{\"stream\":\"") || !take_plain_text(line, out.stream) || !take(line, ",\"n\":") ||
      !take_number(line, out.n) || !take(line, ",\"t\":") || !take_number(line, t) || !take(line, ",\"kind\":\"") ||
      !take_plain_text(line, kind) || !take(line, ",\"data\":{"))
    return std::nullopt;
  // Quotes within texts are escaped, so that the last one of these is no part of a text.
  static constexpr std::string_view kCause = ",\"cause\":[";
  const auto cause = line.rfind(kCause);
  if (cause == line.npos || !line.ends_with("]}")) return std::nullopt;
  out.data = std::string_view(line.data() - 1, cause + 1);
  line.remove_prefix(cause + kCause.size());
  if (line.size() < 2) return std::nullopt;
  out.causes = line.substr(0, line.size() - 2);
  const auto known = record_kind(kind);
  if (!known || !are_plain_causes(out.causes) || !Json::accept(out.data)) return std::nullopt;
  out.t = SimTime{t};
  out.kind = *known;
  return out;
}

bool operator==(const RecordValue& a, const RecordValue& b) { return a.value == b.value; }

const RecordValue* RecordValue::find(std::string_view key) const {
  const auto* map = std::get_if<Map>(&value);
  if (!map) return nullptr;
  const auto found = std::ranges::find(*map, key, &Entry::key);
  return found == map->end() ? nullptr : &found->value;
}

std::int64_t RecordValue::integer(std::string_view key) const {
  const RecordValue* found = find(key);
  const auto* integer = found ? std::get_if<std::int64_t>(&found->value) : nullptr;
  return integer ? *integer : 0;
}

std::string_view RecordValue::text(std::string_view key) const {
  const RecordValue* found = find(key);
  const auto* text = found ? std::get_if<std::string>(&found->value) : nullptr;
  return text ? std::string_view(*text) : std::string_view();
}

double RecordValue::real(std::string_view key) const {
  const RecordValue* found = find(key);
  const auto* real = found ? std::get_if<double>(&found->value) : nullptr;
  return real ? *real : static_cast<double>(integer(key));
}

bool RecordValue::flag(std::string_view key) const {
  const RecordValue* found = find(key);
  const auto* flag = found ? std::get_if<bool>(&found->value) : nullptr;
  return flag && *flag;
}

bool is_planned(const JournalRecord& record) {
  if (record.kind != RecordKind::kControl || !record.stream.starts_with("env/")) return false;
  const std::string_view what = record.data.text("what");
  return what == "load" || what == "assert" || what == "set" || what == "fail";
}

Expected<JournalRecord> parse_journal_line(std::string_view line) {
  const Json json = parse_json(line);
  if (!json.is_object()) return input_error("expected a record, a JSON object");
  const Json missing;
  const auto member = [&](const char* key) -> const Json& { return json.contains(key) ? json[key] : missing; };
  const Json &stream = member("stream"), &n = member("n"), &t = member("t"), &kind = member("kind"),
             &data = member("data"), &causes = member("cause");
  if (!stream.is_string()) return input_error("expected \"stream\", a text");
  if (!n.is_number_unsigned()) return input_error("expected \"n\", a number from 0");
  if (!t.is_number_integer()) return input_error("expected \"t\", a number of ns");
  if (!kind.is_string()) return input_error("expected \"kind\", a text");
  if (!data.is_object()) return input_error("expected \"data\", an object");
  if (!causes.is_array()) return input_error("expected \"cause\", a list of stream:n");
  const auto known = record_kind(kind.get<std::string>());
  if (!known) return input_error("'" + kind.get<std::string>() + "' is no kind of record");

  JournalRecord record{stream, n, SimTime{t.get<std::int64_t>()}, *known, {}, {}};
  if (!convert(data, record.data, 0)) return input_error("\"data\" is nested too deep");
  for (const Json& text : causes) {
    auto cause = text.is_string() ? parse_cause(text.get<std::string>()) : std::nullopt;
    if (!cause) return input_error("expected \"cause\", a list of stream:n, found " + text.dump(-1, ' ', true));
    record.causes.push_back(std::move(*cause));
  }
  return record;
}

std::string to_json(const RecordValue& value) { return json_text(std::visit(Converter(), value.value)); }

bool RecordFilter::takes(RecordKind kind) const {
  return kinds.empty() || std::ranges::find(kinds, kind) != kinds.end();
}

bool RecordFilter::takes(RecordKind kind, std::string_view name, SimTime t) const {
  return takes(kind) && (stream.empty() || name == stream) && t >= from && t <= to;
}

Expected<JournalReader> JournalReader::open(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return input_error("there is no such file", path.string());
  if (!std::filesystem::is_regular_file(path, ignored))
    return input_error("is no regular file, expected a journal", path.string());
  std::ifstream file(path, std::ios::binary);
  if (!file) return input_error("cannot be read: " + std::generic_category().message(errno), path.string());
  return JournalReader(path, std::move(file));
}

bool JournalReader::next_line(const RecordFilter& filter) {
  while (true) {
    ++number_;
    if (!std::getline(file_, line_) || file_.eof()) return false;
    const auto kind = filter.kinds.empty() ? std::nullopt : kind_in_head(line_);
    if (!kind || filter.takes(*kind)) return true;
  }
}

Expected<JournalRecord> JournalReader::record() const {
  auto record = parse_journal_line(line_);
  if (!record) return input_error(record.error().message, path_.string(), number_);
  return record;
}

Expected<std::optional<JournalRecord>> JournalReader::next(const RecordFilter& filter) {
  while (next_line(filter)) {
    auto read = record();
    if (!read) return read.error();
    if (filter.takes(*read)) return std::optional(*std::move(read));
  }
  return std::optional<JournalRecord>();
}

Expected<std::vector<JournalRecord>> JournalReader::all(const RecordFilter& filter) {
  std::vector<JournalRecord> records;
  while (true) {
    auto record = next(filter);
    if (!record) return record.error();
    if (!*record) return records;
    records.push_back(**std::move(record));
  }
}

Expected<std::vector<JournalRecord>> read_journal(const std::filesystem::path& path, const RecordFilter& filter) {
  auto reader = JournalReader::open(path);
  if (!reader) return reader.error();
  return reader->all(filter);
}

std::vector<std::string> slot_texts(const RecordValue& fact) {
  std::vector<std::string> out;
  const RecordValue* slots = fact.find("slots");
  const auto* map = slots ? std::get_if<RecordValue::Map>(&slots->value) : nullptr;
  if (!map) return out;
  for (const RecordValue::Entry& slot : *map) {
    std::string text(slots->text(slot.key));
    if (text.empty()) text = to_json(slot.value);
    if (text.size() > 1 && text.front() == '"' && text.back() == '"') text = text.substr(1, text.size() - 2);
    out.push_back(std::move(text));
  }
  return out;
}

}  // namespace cxlab
