#include "lab/sweep/row.h"

#include <algorithm>
#include <cctype>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/file_store.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr int kSchema = 2;
/// The keys of a row in JSON, without the figures.
constexpr std::string_view kKeys[] = {"schema",    "scenario",     "strategy", "game",   "seed",  "file",
                                      "overrides", "status",       "exit",     "errors", "world", "compared",
                                      "metrics",   "journal_hash", "program",  "files"};

std::string csv_field(const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
  std::string out = "\"";
  for (const char c : field) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

}  // namespace

std::string hash_of(const fs::path& file) {
  const auto content = read_file(file);
  return content ? content_hash(*content) : std::string();
}

std::optional<double> Row::figure(std::string_view metric) const {
  const auto found = std::ranges::find(figures, metric, &Figure::metric);
  return found == figures.end() ? std::nullopt : found->value;
}

void Row::measure(const WorldKind& kind, const std::string& result_json) {
  world = kind.name;
  compared = kind.metrics.empty() ? std::string_view() : kind.metrics.front().name;
  const std::vector<const Metric*> metrics = metrics_of(kind);
  const std::vector<std::optional<double>> values = cxlab::measure(metrics, result_json);
  figures.clear();
  for (std::size_t i = 0; i < metrics.size(); ++i) figures.push_back({std::string(metrics[i]->name), values[i]});
}

bool is_key_of_row(std::string_view name) { return std::ranges::find(kKeys, name) != std::end(kKeys); }

namespace {

/// Whether two overrides set the same. A file of a game may lie elsewhere: its name and its content say which it is.
bool same_override(const std::string& then, const std::string& now, const Cell& cell_now) {
  if (cell_now.game_override.empty() || now != cell_now.game_override) return then == now;
  const std::size_t path = now.find('=') + 1;
  return then.starts_with(now.substr(0, path));
}

}  // namespace

bool Row::is_current(const Cell& now, const std::string& program_now, const FileNames& names) const {
  const bool played = !files.empty() && !journal_hash.empty();  // else a file that was missing may be there now
  if (!played || program != program_now || cell.game != now.game) return false;
  if (!std::ranges::equal(cell.overrides, now.overrides,
                          [&now](const std::string& a, const std::string& b) { return same_override(a, b, now); }))
    return false;
  return std::ranges::all_of(files, [&names](const auto& file) {
    const fs::path path = names.path_of(file.first);
    return !path.empty() && hash_of(path) == file.second;
  });
}

std::string Row::to_json() const {
  Json names = Json::array();
  for (const Figure& figure : figures) names.push_back(figure.metric);
  Json out{{"schema", kSchema},
           {"scenario", cell.scenario},
           {"strategy", cell.strategy},
           {"game", cell.game},
           {"seed", cell.seed},
           {"file", cell.file.string()},
           {"overrides", cell.overrides},
           {"status", status},
           {"exit", exit_code},
           {"errors", errors},
           {"world", world},
           {"compared", compared},
           {"metrics", std::move(names)}};
  for (const Figure& figure : figures) out[figure.metric] = figure.value ? Json(*figure.value) : Json(nullptr);
  out["journal_hash"] = journal_hash;
  out["program"] = program;
  out["files"] = files;
  return json_text(out, 2) + '\n';
}

Expected<Row> Row::parse(const std::string& text) {
  try {
    const Json json = parse_json(text);
    if (json.at("schema") != kSchema) return input_error("a row of another version of cxlab");
    Row row;
    row.cell.scenario = json.at("scenario");
    row.cell.strategy = json.at("strategy");
    row.cell.seed = json.at("seed");
    row.cell.file = json.at("file").get<std::string>();
    row.cell.overrides = json.at("overrides").get<std::vector<std::string>>();
    row.cell.game = json.at("game");
    row.program = json.at("program");
    row.files = json.at("files").get<std::map<std::string, std::string>>();
    row.status = json.at("status");
    row.exit_code = json.at("exit");
    row.errors = json.at("errors").get<std::vector<std::string>>();
    row.world = json.at("world");
    row.compared = json.at("compared");
    for (const std::string& metric : json.at("metrics").get<std::vector<std::string>>()) {
      const Json& value = json.at(metric);
      row.figures.push_back({metric, value.is_null() ? std::nullopt : std::optional(value.get<double>())});
    }
    row.journal_hash = json.at("journal_hash");
    return row;
  } catch (const Json::exception& e) {
    return input_error(std::string("not a row of a sweep: ") + e.what());
  }
}

std::string row_name(const Cell& cell) {
  std::string name = cell.scenario + '-' + cell.strategy + '-' + (cell.game.empty() ? "" : cell.game + '-') +
                     std::to_string(cell.seed),
              key = cell.named;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  for (const std::string& part : cell.overrides)
    if (part != cell.game_override || part.empty()) key += '\0' + part;
  constexpr std::size_t kLongest = 100;
  return name.substr(0, kLongest) + '-' + content_hash(key + '\0' + cell.game + '\0' + cell.strategy).substr(0, 8);
}

std::string to_csv(const std::vector<Row>& rows) {
  std::vector<std::string> metrics;
  for (const Row& row : rows)
    for (const Figure& figure : row.figures)
      if (std::ranges::find(metrics, figure.metric) == metrics.end()) metrics.push_back(figure.metric);
  std::string out = "scenario,strategy,game,seed,status,exit";
  for (const std::string& metric : metrics) out += ',' + csv_field(metric);
  out += ",journal_hash\n";
  for (const Row& row : rows) {
    out += csv_field(row.cell.scenario) + ',' + csv_field(row.cell.strategy) + ',' + csv_field(row.cell.game) + ',' +
           std::to_string(row.cell.seed) + ',' + row.status + ',' + std::to_string(row.exit_code);
    for (const std::string& metric : metrics) {
      const std::optional<double> value = row.figure(metric);
      out += ',' + (value && !row.journal_hash.empty() ? json_text(Json(*value)) : std::string());
    }
    out += ',' + row.journal_hash + '\n';
  }
  return out;
}

}  // namespace cxlab::lab
