#include "lab/sweep/sweep.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <list>
#include <map>
#include <set>
#include <thread>

#include "cx/base/append_file.h"
#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/process.h"
#include "cx/journal/file_store.h"
#include "cx/journal/run_folder.h"
#include "lab/confine.h"
#include "lab/session.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// One sweep at a time in a folder; given up when the process ends.
class FolderLock {
 public:
  static Expected<std::unique_ptr<FolderLock>> take(const fs::path& folder) {
    const int file = open((folder / ".lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file < 0) return resource_error("cannot be written", folder.string());
    std::unique_ptr<FolderLock> lock(new FolderLock(file));
    if (flock(file, LOCK_EX | LOCK_NB) != 0)
      return resource_error("another sweep works in this folder; wait for it or use another one", folder.string());
    return lock;
  }
  ~FolderLock() { release(); }
  void release() {
    if (file_ >= 0) close(file_);
    file_ = -1;
  }

 private:
  explicit FolderLock(int file) : file_(file) {}
  int file_;
};

/// Files that are mapped into this process to be executed: program and libraries.
std::set<std::string> libraries() {
  std::set<std::string> out;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (const std::size_t path = line.find('/'); path != line.npos && line.find("r-xp") != line.npos)
      out.insert(line.substr(path));
  return out;
}

/// Plays one episode; in a process of its own.
Row play(const Cell& cell, const Catalogue& catalogue, const std::string& program, const FileNames& names,
         const Host& host) {
  const std::set<std::string> before = libraries();
  Row row;
  row.cell = cell;
  row.program = program;
  row.status = "failed";
  const auto refused = [&row](const Error& error) {
    row.errors = {error.text()};
    row.exit_code = static_cast<int>(error.kind);
    return row;
  };
  const auto note = [&row, &names](const fs::path& file) {
    if (auto& hash = row.files[names.name_of(file)]; hash.empty()) hash = hash_of(file);
  };
  note(cell.file);
  auto scenario = Scenario::load(cell.file, catalogue, {cell.overrides.begin(), cell.overrides.end()});
  if (!scenario) return refused(scenario.error());
  const WorldKind& world = *scenario->world.kind;
  PlayOptions options;
  options.out = "none";
  options.file_read = note;
  auto played = play_scenario(options, *std::move(scenario), {.most = host.most, .confine = true});
  for (const std::string& library : libraries())
    if (!before.contains(library)) note(library);  // of plugins
  if (!played) return refused(played.error());
  row.status = to_string(played->result.status);
  row.exit_code = played->failure ? static_cast<int>(played->failure->kind) : 0;
  for (const Error& error : played->errors) row.errors.push_back(error.text());
  for (const std::string& warning : played->result.warnings)
    if (!warning.starts_with("skills failed: ")) row.errors.push_back(warning);  // of robots by name: no two are alike
  row.measure(world, played->result.to_json());
  row.journal_hash = played->result.journal_hash;
  return row;
}

std::optional<Row> read_row(const fs::path& file) {
  const auto text = read_file(file);
  auto row = text ? Row::parse(*text) : Expected<Row>(text.error());
  return row ? std::optional<Row>(*std::move(row)) : std::nullopt;
}

/// The row that a process has left beside the name that it gets.
std::optional<Row> take_row(const fs::path& file, const Cell& cell, const std::string& program) {
  const fs::path part = file.string() + ".part";
  auto row = read_row(part);
  std::error_code error;
  if (!row) {
    fs::remove(part, error);
    return row;
  }
  row->cell = cell;
  row->program = program;
  fs::rename(part, file, error);
  return row;
}

struct Running {
  std::size_t cell;
  fs::path file;
  Process process;
};

std::string line_of(const Row& row) {
  std::string errors;
  for (const std::string& error : row.errors) errors += "; " + error;
  const auto value = row.journal_hash.empty() ? std::nullopt : row.figure(row.compared);
  const std::string figure =
      row.compared.empty() ? "" : ", " + row.compared + ' ' + (value ? general_text(*value, 6) : "-");
  return row.cell.scenario + ' ' + row.cell.strategy + (row.cell.game.empty() ? "" : " game " + row.cell.game) +
         " seed " + std::to_string(row.cell.seed) + ": " + row.status + ", exit " + std::to_string(row.exit_code) +
         figure + errors;
}

/// How the files of a cell are called. A scenario that cannot be read has no packages.
FileNames names_of(const Cell& cell, const Catalogue& catalogue) {
  FileNames names(cell.file);
  if (const auto scenario = Scenario::load(cell.file, catalogue, {cell.overrides.begin(), cell.overrides.end()}))
    names.use_packages(*scenario);
  return names;
}

}  // namespace

std::string program_digest() {
  std::string digests;
  Dl_info library{};
  if (dladdr(reinterpret_cast<void*>(&program_digest), &library) != 0 && library.dli_fname)
    if (const auto content = read_file(library.dli_fname)) digests += content_hash(*content);
  if (const auto content = read_file("/proc/self/exe")) digests += content_hash(*content);
  return content_hash(digests);
}

Expected<std::vector<Row>> sweep(const Suite& suite, const SweepOptions& options, const Host& host) {
  const fs::path rows = options.folder / "rows";
  std::error_code error;
  fs::create_directories(rows, error);
  if (error) return resource_error(error.message(), options.folder.string());
  auto lock = FolderLock::take(options.folder);
  if (!lock) return lock.error();

  const std::string program = program_digest();
  const std::vector<Cell> cells = suite.cells();
  std::vector<std::optional<Row>> found(cells.size());
  std::vector<std::size_t> open;
  std::map<std::pair<std::string, std::string>, FileNames> names;  // by scenario and strategy
  const auto names_for = [&](const Cell& cell) -> const FileNames& {
    const auto known = names.find({cell.scenario, cell.strategy});
    if (known != names.end()) return known->second;
    return names.emplace(std::pair(cell.scenario, cell.strategy), names_of(cell, *suite.catalogue)).first->second;
  };
  for (std::size_t i = 0; i < cells.size(); ++i) {
    auto row = read_row(rows / (row_name(cells[i]) + ".json"));
    if (row && row->is_current(cells[i], program, names_for(cells[i])))
      found[i] = std::move(row);
    else
      open.push_back(i);
  }
  std::size_t done = cells.size() - open.size();
  if (done > 0) host.note(std::to_string(done) + " rows are current and kept");
  for (const std::optional<Row>& row : found)
    if (row && !row->errors.empty()) host.note("kept: " + line_of(*row));

  if (const auto warning = warning_without_wall()) host.note(*warning);
  std::list<Running> running;
  for (auto next = open.begin(); (next != open.end() || !running.empty()) && !host.stopped();) {
    while (next != open.end() && running.size() < static_cast<std::size_t>(options.jobs)) {
      const std::size_t i = *next++;
      const fs::path file = rows / (row_name(cells[i]) + ".json");
      const fs::path part = file.string() + ".part";
      fs::remove(file, error);
      fs::remove(part, error);
      ProcessOptions process;
      process.out = process.err = Stream::file(fs::path(file).replace_extension(".log"));
      const FileNames& of_cell = names_for(cells[i]);
      auto started = Process::fork(process, [&] {
        (*lock)->release();
        auto out = AppendFile::create(part);  // the process opens no file of the sweep once rules have run
        if (!out) return static_cast<int>(ErrorKind::kResource);
        const Row row = play(cells[i], *suite.catalogue, program, of_cell, host);
        return out->append(row.to_json()) && out->close() ? 0 : static_cast<int>(ErrorKind::kResource);
      });
      if (!started) return started.error();
      running.push_back({i, file, *std::move(started)});
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    for (auto it = running.begin(); it != running.end();) {
      const auto code = it->process.wait_for(0);
      if (!code) {
        ++it;
        continue;
      }
      std::optional<Row>& row = found[it->cell];
      row = take_row(it->file, cells[it->cell], program);
      if (!row) {
        row.emplace().cell = cells[it->cell];
        row->program = program;
        row->status = "crashed";
        row->exit_code = *code;
      }
      host.note('[' + std::to_string(++done) + '/' + std::to_string(cells.size()) + "] " + line_of(*row));
      it = running.erase(it);
    }
  }
  running.clear();  // ends those that still play

  std::vector<Row> out;
  for (std::optional<Row>& row : found)
    if (row) out.push_back(*std::move(row));
  if (Status s = replace_file(options.folder / "rows.csv", to_csv(out)); !s) return s.error();
  return out;
}

}  // namespace cxlab::lab
