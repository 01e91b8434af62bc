#include "lab/sweep/row.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <set>
#include <tuple>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/file_store.h"
#include "lab/table_text.h"
#include "scenarios/catalogue.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr int kSchema = 3;
/// The keys of a row in JSON without the figures, and the columns of the index (index.cpp).
constexpr std::string_view kKeys[] = {
    "schema",    "key",          "scenario", "strategy",     "game",     "seed",      "parameters", "file",
    "overrides", "status",       "exit",     "errors",       "warnings", "world",     "compared",   "metrics",
    "played",    "journal_hash", "program",  "files",        "cell",     "completed", "reason",     "tags",
    "cpu_s",     "peak_rss_mb",  "host",     "agent_commit", "command",  "row",       "allowance"};

}  // namespace

std::string_view shared_name(std::string_view metric) {
  static std::set<std::string, std::less<>> names;
  const auto found = names.find(metric);
  return found != names.end() ? *found : *names.emplace(metric).first;
}

bool Allowance::covers(const Allowance& other) const {
  const auto at_least = [](std::int64_t mine, std::int64_t its) { return mine == 0 || (its != 0 && mine >= its); };
  return at_least(memory, other.memory) && at_least(disk, other.disk) && at_least(steps, other.steps);
}

std::string Allowance::options() const {
  std::string out;
  for (const auto& [name, now, otherwise] : {std::tuple("memory", memory, Allowance().memory),
                                             {"disk", disk, Allowance().disk},
                                             {"steps", steps, Allowance().steps}})
    if (now != otherwise) out += std::string(" --") + name + ' ' + std::to_string(now);
  return out;
}

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
  for (std::size_t i = 0; i < metrics.size(); ++i)
    figures.push_back({shared_name(metrics[i]->name), values[i], metrics[i]->of_machine});
}

bool is_key_of_row(std::string_view name) {
  std::string low(name);
  std::ranges::transform(low, low.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::find(kKeys, low) != std::end(kKeys);
}

std::string Row::digest() const {
  std::string text = program;
  for (const std::string& part : portable_overrides(cell)) text += '\0' + part;
  for (const auto& [name, hash] : files) text += '\0' + name + '\0' + hash;
  if (const std::string options = allowance.options(); !options.empty()) text += '\0' + options;
  return content_hash(text);
}

bool Row::is_current(const Cell& now, const std::string& program_now, const FileNames& names, const Hash& hash,
                     const Allowance& allowed) const {
  return !journal_hash.empty() && (counts() ? allowed.covers(allowance) : allowed == allowance) &&
         tells_of(now, program_now, names, hash);
}

bool Row::tells_of(const Cell& now, const std::string& program_now, const FileNames& names, const Hash& hash) const {
  if (files.empty() || program != program_now || cell.game != now.game || cell.seed != now.seed) return false;
  if (file != names.name_of(now.file) || portable_overrides(cell) != portable_overrides(now)) return false;
  return std::ranges::all_of(files, [&](const auto& read) {
    const fs::path path = names.path_of(read.first);
    return !path.empty() && (hash ? hash(path) : hash_of(path)) == read.second;
  });
}

std::string Row::to_json() const {
  Json names = Json::array(), parameters = Json::object(), played = Json::object();
  for (const Figure& figure : figures) names.push_back(figure.metric);
  for (const Parameter& parameter : cell.parameters) parameters[parameter.name] = parameter.value;
  Json out{{"schema", kSchema},
           {"key", key},
           {"scenario", cell.scenario},
           {"strategy", cell.strategy},
           {"game", cell.game},
           {"seed", cell.seed},
           {"parameters", std::move(parameters)},
           {"file", file},
           {"overrides", portable_overrides(cell)},
           {"status", status},
           {"exit", exit_code},
           {"errors", errors},
           {"warnings", warnings},
           {"world", world},
           {"compared", compared},
           {"metrics", std::move(names)}};
  for (const Figure& figure : figures)
    (figure.of_machine ? played : out)[figure.metric] = figure.value ? Json(*figure.value) : Json(nullptr);
  out["journal_hash"] = journal_hash;
  out["program"] = program;
  out["files"] = files;
  if (allowance != Allowance())
    out["allowance"] = {{"memory", allowance.memory}, {"disk", allowance.disk}, {"steps", allowance.steps}};
  played["cpu_s"] = circumstances.cpu_s;
  played["peak_rss_mb"] = circumstances.peak_rss_mb;
  played["host"] = circumstances.host;
  played["agent_commit"] = circumstances.agent_commit;
  out["played"] = std::move(played);
  return json_text(out, 2) + '\n';
}

Expected<Row> Row::parse(const std::string& text) {
  try {
    const Json json = parse_json(text);
    if (json.at("schema") != kSchema) return input_error("a row of another version of cxlab");
    Row row;
    row.key = json.at("key");
    row.cell.scenario = json.at("scenario");
    row.cell.strategy = json.at("strategy");
    row.cell.seed = json.at("seed");
    row.file = json.at("file");
    row.cell.overrides = json.at("overrides").get<std::vector<std::string>>();
    row.cell.game = json.at("game");
    for (const auto& [name, value] : json.at("parameters").items()) row.cell.parameters.push_back({name, value});
    row.program = json.at("program");
    row.files = json.at("files").get<std::map<std::string, std::string>>();
    if (const auto allowance = json.find("allowance"); allowance != json.end()) {
      row.allowance.memory = allowance->at("memory");
      row.allowance.disk = allowance->at("disk");
      row.allowance.steps = allowance->at("steps");
    }
    row.status = json.at("status");
    row.exit_code = json.at("exit");
    row.errors = json.at("errors").get<std::vector<std::string>>();
    row.warnings = json.at("warnings").get<std::vector<std::string>>();
    row.world = json.at("world");
    row.compared = json.at("compared");
    const Json& played = json.at("played");
    for (const std::string& metric : json.at("metrics").get<std::vector<std::string>>()) {
      if (is_key_of_row(metric)) return input_error("not a row of a sweep: a metric is called '" + metric + "'");
      const bool of_machine = played.contains(metric);
      const Json& value = of_machine ? played.at(metric) : json.at(metric);
      row.figures.push_back(
          {shared_name(metric), value.is_null() ? std::nullopt : std::optional(value.get<double>()), of_machine});
    }
    row.journal_hash = json.at("journal_hash");
    row.circumstances = {played.at("cpu_s"), played.at("peak_rss_mb"), played.at("host"), played.at("agent_commit")};
    return row;
  } catch (const Json::exception&) {
    return input_error("is not a row of a sweep, or is cut short; cxlab bench with its suite plays the game again");
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
      if (!figure.of_machine && std::ranges::find(metrics, figure.metric) == metrics.end())
        metrics.emplace_back(figure.metric);
  std::string out = "scenario,strategy,game,seed,status,exit";
  for (const std::string& metric : metrics) out += ',' + csv_text(metric);
  out += ",journal_hash\n";
  for (const Row& row : rows) {
    out += csv_text(row.cell.scenario) + ',' + csv_text(row.cell.strategy) + ',' + csv_text(row.cell.game) + ',' +
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
