#include "lab/sweep/row_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <set>
#include <tuple>

#include "cx/base/file.h"
#include "cx/journal/run_folder.h"
#include "lab/git_commit.h"
#include "lab/sweep/index.h"
#include "lab/sweep/read_rows.h"
#include "lab/table_text.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUnfinished = ".part";

/// The commit of the first agent whose configuration or package lies in a repository; if none does, that of the
/// scenario.
std::string commit_of_agent(const Scenario& scenario) {
  const fs::path home = scenario.file.parent_path();
  std::vector<fs::path> folders;
  for (const AgentSpec& agent : scenario.agents) {
    if (agent.config.find("://") == std::string::npos) folders.push_back((home / agent.config).parent_path());
    for (const auto& [name, folder] : scenario.shares(agent)) folders.emplace_back(folder);
  }
  folders.push_back(home);
  for (const fs::path& folder : folders)
    if (std::string commit = git_commit_of(folder); !commit.empty()) return commit;
  return {};
}

std::string path_of(const Suite& suite) { return fs::absolute(suite.file).lexically_normal().string(); }

/// How the tables name a game.
using Named = std::tuple<std::string, std::string, std::string, std::uint64_t>;
Named name_in_table(const Cell& cell) { return {cell.scenario, cell.strategy, cell.game, cell.seed}; }

/// The rows of the tables that are there. Those of rows.csv, which count if there is no index, have no keys.
std::vector<Row> rows_in_tables(const fs::path& folder, const Catalogue& catalogue) {
  std::vector<Row> out;
  if (auto index = read_index(folder / "runs.sqlite")) {
    for (IndexedRow& one : *index) out.push_back(std::move(one.row));
  } else if (const fs::path csv = folder / "rows.csv"; path_exists(csv)) {
    if (auto rows = read_rows(csv, catalogue)) out = *std::move(rows);  // else nobody could read the table
  }
  return out;
}

}  // namespace

std::string identity_of(const Cell& cell) {
  std::string out = cell.game + '\0' + std::to_string(cell.seed);
  for (const std::string& part : portable_overrides(cell)) out += '\0' + part;
  return out;
}

std::string RowMatcher::hash(const fs::path& file) {
  const auto [known, is_new] = hashes_.try_emplace(file);
  if (is_new) known->second = hash_of(file);
  return known->second;
}

bool RowMatcher::is_current(const Row& row, const Cell& cell) {
  return row.is_current(
      cell, program_, names_of(cell), [this](const fs::path& file) { return hash(file); }, allowance_);
}

bool RowMatcher::tells_of(const Row& row, const Cell& cell) {
  return row.tells_of(cell, program_, names_of(cell), [this](const fs::path& file) { return hash(file); });
}

std::string RowMatcher::changed_file(const Row& row, const Cell& cell) {
  for (const auto& [name, then] : row.files) {
    const fs::path path = names_of(cell).path_of(name);
    if (path.empty() || hash(path) != then) return name;
  }
  return {};
}

const RowMatcher::Place& RowMatcher::place_of(const Cell& cell) {
  const auto known = places_.find({cell.scenario, cell.strategy});
  if (known != places_.end()) return known->second;
  Place place{FileNames(cell.file), {}};
  // A scenario that cannot be read has no packages.
  if (const auto scenario = Scenario::load(cell.file, catalogue_, {cell.overrides.begin(), cell.overrides.end()})) {
    place.names.use_packages(*scenario);
    place.agent_commit = commit_of_agent(*scenario);
  }
  return places_.emplace(std::pair(cell.scenario, cell.strategy), std::move(place)).first->second;
}

Expected<RowFolder> RowFolder::open(const fs::path& folder, FolderUse use) {
  std::error_code error;
  fs::create_directories(folder / "rows", error);
  if (error) return resource_error(error.message(), folder.string());
  Descriptor lock(::open((folder / ".lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644));
  if (!lock) return resource_error("cannot be written", folder.string());
  // Some file systems of clusters have no locks; rows replace each other whole there as well.
  if (flock(lock.number(), (use == FolderUse::kAlone ? LOCK_EX : LOCK_SH) | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return resource_error("another sweep works in this folder; wait for it or use another one", folder.string());
  return RowFolder(folder, std::move(lock));
}

RowFolder::RowFolder(fs::path folder, Descriptor lock)
    : folder_(std::move(folder)), rows_(folder_ / "rows"), lock_(std::move(lock)) {}

std::string host_name() {
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  return host;
}

fs::path RowFolder::unfinished(const fs::path& file) const {
  return file.string() + std::string(kUnfinished) + '-' + host_name() + '-' + std::to_string(getpid());
}

void RowFolder::remove_unfinished() const {
  std::error_code error;
  std::vector<fs::path> left;
  for (const auto& [folder, name] : {std::pair(rows_, ".json"), {folder_, "runs.sqlite"}})
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
      if (it->path().filename().string().find(name + std::string(kUnfinished)) != std::string::npos)
        left.push_back(it->path());
  for (const fs::path& file : left) fs::remove(file, error);
}

std::optional<Row> RowFolder::find(const Cell& cell, RowMatcher& matcher) {
  auto row = read_row(file_of(cell));
  if (row && matcher.is_current(*row, cell)) {
    row->cell = cell;
    return row;
  }
  if (!known_) {
    known_ = std::make_unique<Known>();
    for (const fs::path& file : row_files(folder_))
      if (const auto other = read_row(file); other && !other->journal_hash.empty())
        known_->emplace(identity_of(other->cell), file);
  }
  const auto [first, last] = known_->equal_range(identity_of(cell));
  for (auto it = first; it != last; ++it) {
    row = read_row(it->second);
    if (!row || !matcher.is_current(*row, cell)) continue;
    row->cell = cell;
    if (!write(*row)) return std::nullopt;  // then it is played, and says why there is no row
    return row;
  }
  return std::nullopt;
}

Status RowFolder::write(const Row& row) const {
  const fs::path file = file_of(row.cell);
  return replace_file(file, row.to_json(), unfinished(file));
}

Status RowFolder::write_tables(const std::vector<Row>& rows, const Suite& suite) const {
  if (!suite.file.empty())
    if (Status s = replace_file(folder_ / kSuiteFile, path_of(suite) + '\n'); !s) return s;
  if (Status s = replace_file(folder_ / "rows.csv", to_csv(rows)); !s) return s;
  return write_index(rows, suite, folder_ / "runs.sqlite");
}

std::vector<Row> RowFolder::lost_rows(const std::vector<Cell>& cells, const std::vector<Row>& rows,
                                      const Suite& suite) const {
  std::vector<Row> out = rows_in_tables(folder_, *suite.catalogue);
  std::set<Named> names, before;
  for (const Cell& cell : cells) names.insert(name_in_table(cell));
  for (const Row& row : out) before.insert(name_in_table(row.cell));
  std::map<std::string, std::size_t> renamed;  // rows with a name that is new, by key
  for (const Row& row : rows) renamed[row.key] += !before.contains(name_in_table(row.cell));
  std::erase_if(out, [&](const Row& row) {
    if (names.contains(name_in_table(row.cell))) return true;
    const auto found = renamed.find(row.key);
    return found != renamed.end() && found->second > 0 && found->second-- > 0;
  });
  return out;
}

Status RowFolder::take_tables_over(const std::vector<Row>& lost, const Suite& suite, const Host& host) const {
  if (lost.empty()) return {};
  auto other = read_file(folder_ / kSuiteFile);
  if (other && other->ends_with('\n')) other->pop_back();
  const std::string what = count_text(lost.size(), "row") + " of games that " + suite.file.string() +
                           " does not play, as " + title_of(lost.front().cell);
  const std::string csv = (folder_ / "rows.csv").string();
  if (other && *other != path_of(suite) && path_exists(*other))  // else it was moved, or is of a program that wrote it
    return input_error(
        "has " + what + ": it is a table of the suite " + *other + "; expected --out with a folder of this suite's own",
        csv);
  host.warn(csv + " loses " + what + "; rows/*.json keeps them");
  return {};
}

std::optional<Row> read_row(const fs::path& file) {
  const auto text = read_file(file);
  auto row = text ? Row::parse(*text) : Expected<Row>(text.error());
  return row ? std::optional<Row>(*std::move(row)) : std::nullopt;
}

std::vector<fs::path> row_files(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (fs::directory_iterator it(folder / "rows", error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".json") out.push_back(it->path());
  std::ranges::sort(out);
  return out;
}

}  // namespace cxlab::lab
