#include "lab/sweep/index.h"

#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <variant>

#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr const char* kTables = R"sql(
PRAGMA journal_mode = OFF;
PRAGMA synchronous = OFF;
BEGIN;
CREATE TABLE parameters (
  cell INTEGER NOT NULL REFERENCES runs (cell), name TEXT NOT NULL, value TEXT NOT NULL,
  PRIMARY KEY (cell, name)
) WITHOUT ROWID;
CREATE TABLE tags (
  cell INTEGER NOT NULL REFERENCES runs (cell), tag TEXT NOT NULL,
  PRIMARY KEY (cell, tag)
) WITHOUT ROWID;
CREATE TABLE messages (
  cell INTEGER NOT NULL REFERENCES runs (cell), number INTEGER NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('error', 'warning')), text TEXT NOT NULL,
  PRIMARY KEY (cell, number)
) WITHOUT ROWID;
CREATE TABLE metrics (
  world TEXT NOT NULL, name TEXT NOT NULL, what TEXT NOT NULL, formula TEXT NOT NULL, unit TEXT NOT NULL,
  more_is_better INTEGER NOT NULL, of_machine INTEGER NOT NULL, compared INTEGER NOT NULL,
  PRIMARY KEY (world, name)
) WITHOUT ROWID;
)sql";

/// The columns of `runs` before those of the metrics.
constexpr const char* kRuns =
    "CREATE TABLE runs (cell INTEGER PRIMARY KEY, key TEXT NOT NULL, scenario TEXT NOT NULL, strategy TEXT NOT NULL, "
    "game TEXT, seed NOT NULL, status TEXT NOT NULL, completed INTEGER NOT NULL, exit INTEGER NOT NULL, "
    "reason TEXT, world TEXT, journal_hash TEXT, cpu_s REAL, peak_rss_mb REAL, host TEXT, agent_commit TEXT, "
    "program TEXT NOT NULL, command TEXT NOT NULL, row TEXT NOT NULL";

using Value = std::variant<std::nullptr_t, std::int64_t, double, std::string>;

/// A database that is written from beginning to end. The first error stays, and later calls do nothing.
class IndexWriter {
 public:
  explicit IndexWriter(const fs::path& file) : file_(file) {
    note(sqlite3_open_v2(file.c_str(), &database_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr));
  }
  ~IndexWriter() {
    finalize();
    sqlite3_close_v2(database_);
  }
  IndexWriter(const IndexWriter&) = delete;
  IndexWriter& operator=(const IndexWriter&) = delete;

  void run(const std::string& sql) {
    if (status_) note(sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr));
  }
  void insert(const std::string& table, const std::vector<Value>& values) {
    if (!status_) return;
    sqlite3_stmt*& statement = inserts_[table];
    if (!statement) {
      std::string sql = "INSERT INTO " + table + " VALUES (";
      for (std::size_t i = 0; i < values.size(); ++i) sql += i == 0 ? "?" : ", ?";
      note(sqlite3_prepare_v2(database_, (sql + ')').c_str(), -1, &statement, nullptr));
    }
    for (std::size_t i = 0; status_ && i < values.size(); ++i) bind(statement, static_cast<int>(i) + 1, values[i]);
    if (status_ && sqlite3_step(statement) != SQLITE_DONE) note(sqlite3_errcode(database_));
    sqlite3_reset(statement);
    sqlite3_clear_bindings(statement);
  }
  Status close() {
    run("COMMIT; PRAGMA user_version = " + std::to_string(kIndexSchema));
    finalize();
    const int code = sqlite3_close(database_);
    database_ = nullptr;
    if (status_) note(code);
    return status_;
  }

 private:
  void finalize() {
    for (const auto& [table, statement] : inserts_) sqlite3_finalize(statement);
    inserts_.clear();
  }
  void note(int code) {
    if (code == SQLITE_OK) return;
    const char* said = database_ ? sqlite3_errmsg(database_) : sqlite3_errstr(code);
    status_ = resource_error(std::string("cannot be written: ") + said, file_.string());
  }
  void bind(sqlite3_stmt* statement, int place, const Value& value) {
    if (const auto* number = std::get_if<std::int64_t>(&value))
      note(sqlite3_bind_int64(statement, place, *number));
    else if (const auto* real = std::get_if<double>(&value))
      note(sqlite3_bind_double(statement, place, *real));
    else if (const auto* text = std::get_if<std::string>(&value))
      note(sqlite3_bind_text(statement, place, text->data(), static_cast<int>(text->size()), SQLITE_TRANSIENT));
  }

  fs::path file_;
  sqlite3* database_ = nullptr;
  std::map<std::string, sqlite3_stmt*> inserts_;  // by table
  Status status_;
};

std::string sql_name(std::string_view name) {
  std::string out = "\"";
  for (const char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

Value text_or_null(const std::string& text) { return text.empty() ? Value(nullptr) : Value(text); }

/// Seeds beyond 63 bits are text: SQLite has no such numbers.
Value seed_value(std::uint64_t seed) {
  return seed <= INT64_MAX ? Value(static_cast<std::int64_t>(seed)) : Value(std::to_string(seed));
}

void insert_row(const Row& row, const std::vector<std::string>& metrics, IndexWriter& out) {
  const auto cell = static_cast<std::int64_t>(row.cell.number);
  const bool measured = row.status != "crashed";
  const auto of_process = [measured](double value) { return measured ? Value(value) : Value(nullptr); };
  std::vector<Value> values{cell,
                            row.key,
                            row.cell.scenario,
                            row.cell.strategy,
                            text_or_null(row.cell.game),
                            seed_value(row.cell.seed),
                            row.status,
                            std::int64_t{row.counts()},
                            std::int64_t{row.exit_code},
                            row.errors.empty() ? Value(nullptr) : Value(row.errors.front()),
                            text_or_null(row.world),
                            text_or_null(row.journal_hash),
                            of_process(row.circumstances.cpu_s),
                            of_process(row.circumstances.peak_rss_mb),
                            text_or_null(row.circumstances.host),
                            text_or_null(row.circumstances.agent_commit),
                            row.program,
                            row.command(),
                            "rows/" + row_name(row.cell) + ".json"};
  for (const std::string& metric : metrics) {
    const auto value = row.journal_hash.empty() ? std::nullopt : row.figure(metric);
    values.push_back(value ? Value(*value) : Value(nullptr));
  }
  out.insert("runs", values);
  for (const Parameter& parameter : row.cell.parameters)
    out.insert("parameters", {cell, parameter.name, parameter.value});
  for (const std::string& tag : row.cell.tags) out.insert("tags", {cell, tag});
  std::int64_t number = 0;
  for (const auto& [kind, texts] : {std::pair("error", &row.errors), {"warning", &row.warnings}})
    for (const std::string& text : *texts) out.insert("messages", {cell, ++number, std::string(kind), text});
}

}  // namespace

Status write_index(const std::vector<Row>& rows, const Suite& suite, const fs::path& file) {
  std::vector<std::string> metrics;
  std::set<std::string> worlds;
  for (const Row& row : rows) {
    if (!row.world.empty()) worlds.insert(row.world);
    for (const Figure& figure : row.figures)
      if (std::ranges::find(metrics, figure.metric) == metrics.end()) metrics.emplace_back(figure.metric);
  }
  const fs::path part = file.string() + ".part-" + std::to_string(getpid());
  std::error_code error;
  fs::remove(part, error);
  IndexWriter out(part);
  out.run(kTables);
  std::string runs = kRuns;
  for (const std::string& metric : metrics) runs += ", " + sql_name(metric) + " REAL";
  out.run(runs + ")");
  for (const std::string& name : worlds)
    if (const WorldKind* world = suite.catalogue->find_world(name))
      for (const Metric* metric : metrics_of(*world))
        out.insert("metrics",
                   {name, std::string(metric->name), std::string(metric->what), formula_of(*metric),
                    std::string(metric->unit), std::int64_t{metric->more_is_better}, std::int64_t{metric->of_machine},
                    std::int64_t{!world->metrics.empty() && metric == &world->metrics.front()}});
  for (const Row& row : rows) insert_row(row, metrics, out);
  return put_in_place(out.close(), part, file);
}

namespace {

/// A database that is read. The first error stays, and later calls do nothing.
class IndexReader {
 public:
  explicit IndexReader(const fs::path& file) : file_(file) {
    note(sqlite3_open_v2(file.c_str(), &database_, SQLITE_OPEN_READONLY, nullptr));
  }
  ~IndexReader() { sqlite3_close_v2(database_); }
  IndexReader(const IndexReader&) = delete;
  IndexReader& operator=(const IndexReader&) = delete;

  using Result = sqlite3_stmt*;
  /// Calls `take` with each row of the answer.
  void each(const std::string& sql, const std::function<void(Result)>& take) {
    if (!status_) return;
    Result statement = nullptr;
    note(sqlite3_prepare_v2(database_, sql.c_str(), -1, &statement, nullptr));
    int code = SQLITE_DONE;
    while (status_ && (code = sqlite3_step(statement)) == SQLITE_ROW) take(statement);
    if (status_ && code != SQLITE_DONE) note(code);
    sqlite3_finalize(statement);
  }
  const Status& status() const { return status_; }

  static std::string text(Result row, int column) {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
    return bytes ? std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(row, column))) : std::string();
  }

 private:
  void note(int code) {
    if (code == SQLITE_OK) return;
    const char* said = database_ ? sqlite3_errmsg(database_) : sqlite3_errstr(code);
    status_ = input_error(std::string("is no index of a sweep: ") + said, file_.string());
  }

  fs::path file_;
  sqlite3* database_ = nullptr;
  Status status_;
};

}  // namespace

Expected<std::vector<IndexedRow>> read_index(const fs::path& file) {
  IndexReader in(file);
  int version = 0;
  in.each("PRAGMA user_version", [&version](auto row) { version = sqlite3_column_int(row, 0); });
  if (in.status() && version != kIndexSchema)
    return input_error("is an index of version " + std::to_string(version) + ", expected " +
                           std::to_string(kIndexSchema) + "; cxlab bench SUITE --collect DIR --out DIR rebuilds it",
                       file.string());
  std::map<std::string, std::string> compared;  // by world
  std::set<std::string> of_machine;
  in.each("SELECT world, name, of_machine, compared FROM metrics", [&](auto row) {
    if (sqlite3_column_int(row, 2) != 0) of_machine.insert(IndexReader::text(row, 1));
    if (sqlite3_column_int(row, 3) != 0) compared[IndexReader::text(row, 0)] = IndexReader::text(row, 1);
  });
  std::vector<IndexedRow> out;
  std::map<std::int64_t, std::size_t> places;  // by cell
  in.each(
      "SELECT cell, key, scenario, strategy, game, seed, status, exit, world, journal_hash, cpu_s, peak_rss_mb, host, "
      "agent_commit, program, command, row, * FROM runs ORDER BY cell",
      [&](auto found) {
        constexpr int kRow = 16;  // the column `row`
        const auto text = [found](int column) { return IndexReader::text(found, column); };
        places[sqlite3_column_int64(found, 0)] = out.size();
        IndexedRow& one = out.emplace_back();
        Row& row = one.row;
        row.cell.number = static_cast<std::size_t>(sqlite3_column_int64(found, 0));
        row.key = text(1);
        row.cell.scenario = text(2);
        row.cell.strategy = text(3);
        row.cell.game = text(4);
        row.cell.seed = read_number<std::uint64_t>(text(5)).value_or(0);
        row.status = text(6);
        row.exit_code = sqlite3_column_int(found, 7);
        row.world = text(8);
        if (const auto metric = compared.find(row.world); metric != compared.end()) row.compared = metric->second;
        row.journal_hash = text(9);
        row.circumstances = {sqlite3_column_double(found, 10), sqlite3_column_double(found, 11), text(12), text(13)};
        row.program = text(14);
        one.command = text(15);
        one.file = text(kRow);
        const int columns = sqlite3_column_count(found);
        bool is_metric = false;
        for (int i = kRow + 1; i < columns; ++i) {
          const std::string name = sqlite3_column_name(found, i);
          if (is_metric)
            row.figures.push_back({shared_name(name),
                                   sqlite3_column_type(found, i) == SQLITE_NULL
                                       ? std::nullopt
                                       : std::optional(sqlite3_column_double(found, i)),
                                   of_machine.contains(name)});
          is_metric |= name == "row";  // the last one before those of metrics
        }
      });
  in.each("SELECT cell, kind, text FROM messages ORDER BY cell, number", [&](auto found) {
    if (const auto place = places.find(sqlite3_column_int64(found, 0)); place != places.end()) {
      Row& row = out[place->second].row;
      (IndexReader::text(found, 1) == "error" ? row.errors : row.warnings).push_back(IndexReader::text(found, 2));
    }
  });
  in.each("SELECT cell, name, value FROM parameters ORDER BY cell", [&](auto found) {
    if (const auto place = places.find(sqlite3_column_int64(found, 0)); place != places.end())
      out[place->second].row.cell.parameters.push_back({IndexReader::text(found, 1), IndexReader::text(found, 2)});
  });
  if (!in.status()) return in.status().error();
  return out;
}

}  // namespace cxlab::lab
