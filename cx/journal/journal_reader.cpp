#include "cx/journal/journal_reader.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cx/base/number_text.h"

namespace cxlab {
namespace {

using Json = nlohmann::ordered_json;

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
        map.emplace_back(key, RecordValue{});
        if (!convert(item, map.back().second, depth + 1)) return false;
      }
      out.value = std::move(map);
      break;
    }
    default: out.value = std::monostate{};
  }
  return true;
}

std::optional<RecordKind> kind_of(std::string_view word) {
  for (int i = 0; i <= static_cast<int>(RecordKind::kError); ++i) {
    if (word == to_string(static_cast<RecordKind>(i))) return static_cast<RecordKind>(i);
  }
  return std::nullopt;
}

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
  return kind_of(rest.substr(0, rest.find('"')));
}

}  // namespace

Expected<JournalRecord> parse_journal_line(std::string_view line) {
  const Json json = Json::parse(line, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return input_error("expected a record, a JSON object");
  const Json missing;
  const auto member = [&](const char* key) -> const Json& {
    const auto found = json.find(key);
    return found == json.end() ? missing : *found;
  };
  const Json& stream = member("stream");
  const Json& n = member("n");
  const Json& t = member("t");
  const Json& kind = member("kind");
  const Json& data = member("data");
  const Json& causes = member("cause");
  if (!stream.is_string()) return input_error("expected \"stream\", a text");
  if (!n.is_number_unsigned()) return input_error("expected \"n\", a number from 0");
  if (!t.is_number_integer()) return input_error("expected \"t\", a number of ns");
  if (!kind.is_string()) return input_error("expected \"kind\", a text");
  if (!data.is_object()) return input_error("expected \"data\", an object");
  if (!causes.is_array()) return input_error("expected \"cause\", a list of stream:n");

  JournalRecord record;
  record.stream = stream.get<std::string>();
  record.n = n.get<std::uint64_t>();
  record.t = SimTime{t.get<std::int64_t>()};
  const auto known = kind_of(kind.get<std::string>());
  if (!known) return input_error("'" + kind.get<std::string>() + "' is no kind of record");
  record.kind = *known;
  if (!convert(data, record.data, 0)) return input_error("\"data\" is nested too deep");
  for (const Json& text : causes) {
    auto cause = text.is_string() ? parse_cause(text.get<std::string>()) : std::nullopt;
    if (!cause) return input_error("expected \"cause\", a list of stream:n, found " + text.dump(-1, ' ', true));
    record.causes.push_back(std::move(*cause));
  }
  return record;
}

Expected<JournalReader> JournalReader::open(const std::filesystem::path& path) {
  JournalReader reader;
  reader.path_ = path.string();
  reader.file_.open(path);
  if (!reader.file_ || std::filesystem::is_directory(path)) return input_error("cannot be read", path.string());
  return reader;
}

Expected<std::optional<JournalRecord>> JournalReader::next() {
  const auto wanted = [this](RecordKind kind) {
    return kinds_.empty() || std::find(kinds_.begin(), kinds_.end(), kind) != kinds_.end();
  };
  while (std::getline(file_, text_)) {
    ++line_;
    if (file_.eof()) {
      cut_off_ = true;
      break;
    }
    const auto kind = kinds_.empty() ? std::nullopt : kind_in_head(text_);
    if (kind && !wanted(*kind)) continue;
    auto record = parse_journal_line(text_);
    if (!record) return input_error(record.error().message, path_, line_);
    if (wanted(record->kind)) return std::optional<JournalRecord>(std::move(*record));
  }
  return std::optional<JournalRecord>{};
}

Expected<std::vector<JournalRecord>> read_journal(const std::filesystem::path& path) {
  auto reader = JournalReader::open(path);
  if (!reader) return reader.error();
  std::vector<JournalRecord> records;
  while (true) {
    auto record = reader->next();
    if (!record) return record.error();
    if (!*record) return records;
    records.push_back(std::move(**record));
  }
}

}  // namespace cxlab
