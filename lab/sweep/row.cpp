#include "lab/sweep/row.h"

#include <cctype>
#include <nlohmann/json.hpp>

#include "cx/base/file.h"
#include "cx/base/json_text.h"
#include "cx/journal/file_store.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kSchema = 1;

std::string quoted(const std::string& field) {
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

bool Row::is_current(const Cell& now, const std::string& program_now) const {
  if (program != program_now || cell.file != now.file || cell.overrides != now.overrides) return false;
  for (const auto& [file, hash] : files)
    if (hash_of(file) != hash) return false;
  return true;
}

std::string Row::to_json() const {
  const Json out{{"schema", kSchema},
                 {"scenario", cell.scenario},
                 {"strategy", cell.strategy},
                 {"game", cell.game},
                 {"seed", cell.seed},
                 {"file", cell.file.string()},
                 {"overrides", cell.overrides},
                 {"status", status},
                 {"exit", exit_code},
                 {"errors", errors},
                 {"points", figures.points},
                 {"deliveries", figures.deliveries},
                 {"busy", figures.busy},
                 {"real_time_factor", figures.real_time_factor},
                 {"journal_hash", journal_hash},
                 {"program", program},
                 {"files", files}};
  return json_text(out, 2) + '\n';
}

Expected<Row> Row::parse(const std::string& text) {
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != kSchema) return input_error("a row of another version of cxlab");
    Row row;
    row.cell = {json.at("scenario"),  json.at("strategy"),
                json.at("seed"),      fs::path(json.at("file").get<std::string>()),
                json.at("overrides"), json.value("game", std::string())};
    row.program = json.at("program");
    row.files = json.at("files").get<std::map<std::string, std::string>>();
    row.status = json.at("status");
    row.exit_code = json.at("exit");
    row.errors = json.at("errors").get<std::vector<std::string>>();
    row.figures = {json.at("points"), json.at("deliveries"), json.at("busy"), json.at("real_time_factor")};
    row.journal_hash = json.at("journal_hash");
    return row;
  } catch (const Json::exception& e) {
    return input_error(std::string("not a row of a sweep: ") + e.what());
  }
}

Figures figures_of(const std::string& result_json) {
  const Json result = Json::parse(result_json);
  Figures out;
  for (const auto& [team, t] : result["teams"].items()) out.points += t["points"].get<double>();
  for (const Json& delivery : result["deliveries"]) out.deliveries += delivery["correct"].get<bool>() ? 1 : 0;
  double busy = 0;
  for (const Json& robot : result["robots"]) busy += robot.value("busy_s", 0.0);
  const double robot_time = static_cast<double>(result["robots"].size()) * result["sim_time_s"].get<double>();
  out.busy = robot_time > 0 ? busy / robot_time : 0;
  out.real_time_factor = result["real_time_factor"].get<double>();
  return out;
}

std::string row_name(const Cell& cell) {
  std::string name = cell.scenario + '-' + cell.strategy + '-' + (cell.game.empty() ? "" : cell.game + '-') +
                     std::to_string(cell.seed),
              key = cell.file.string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  for (const std::string& part : cell.overrides) key += '\0' + part;
  constexpr std::size_t kLongest = 100;
  return name.substr(0, kLongest) + '-' + content_hash(key + '\0' + cell.strategy).substr(0, 8);
}

std::string to_csv(const std::vector<Row>& rows) {
  std::string out = "scenario,strategy,game,seed,status,exit,points,deliveries,busy,real_time_factor,journal_hash\n";
  for (const Row& row : rows) {
    out += quoted(row.cell.scenario) + ',' + quoted(row.cell.strategy) + ',' + quoted(row.cell.game) + ',' +
           std::to_string(row.cell.seed) + ',' + row.status + ',' + std::to_string(row.exit_code);
    const Figures& f = row.figures;
    for (const double figure : {f.points, f.deliveries, f.busy, f.real_time_factor})
      out += ',' + (row.journal_hash.empty() ? std::string() : json_text(Json(figure)));
    out += ',' + row.journal_hash + '\n';
  }
  return out;
}

}  // namespace cxlab::lab
