#include "lab/sweep/sweep.h"

#include <dlfcn.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <list>
#include <map>
#include <set>

#include "cx/base/append_file.h"
#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/base/process.h"
#include "cx/journal/file_store.h"
#include "lab/confine.h"
#include "lab/session.h"
#include "lab/sweep/remaining_time.h"
#include "lab/sweep/row_folder.h"
#include "lab/table_text.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

double wall_seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Files that are mapped into this process to be executed: program and libraries.
std::set<std::string> libraries() {
  std::set<std::string> out;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (const std::size_t path = line.find('/'); path != line.npos && line.find("r-xp") != line.npos)
      out.insert(line.substr(path));
  return out;
}

/// What this process has used so far.
Circumstances circumstances_now(const std::string& agent_commit) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return {seconds(usage.ru_utime) + seconds(usage.ru_stime), static_cast<double>(usage.ru_maxrss) / 1024, host_name(),
          agent_commit};
}

/// Plays one episode; in a process of its own.
Row play(const Cell& cell, const Catalogue& catalogue, const std::string& program, const FileNames& names,
         const std::string& agent_commit, const Host& host) {
  const std::set<std::string> before = libraries();
  Row row;
  row.cell = cell;
  row.program = program;
  row.file = names.name_of(cell.file);
  row.allowance = Allowance(host.most);
  row.status = "failed";
  const auto completed = [&]() -> Row& {
    row.key = row.digest();
    row.circumstances = circumstances_now(agent_commit);
    return row;
  };
  const auto refused = [&](const Error& error) {
    row.errors = {error.text()};
    row.exit_code = static_cast<int>(error.kind);
    return completed();
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
  row.warnings = played->result.warnings;
  row.measure(world, played->result.to_json());
  row.journal_hash = played->result.journal_hash;
  return completed();
}

/// Exit code of a process that could not write its row: the disk is full, and all others would fail as well.
constexpr int kRowNotWritten = 74;

struct Running {
  std::size_t cell;
  fs::path part;
  Process process;
  Clock::time_point begin = Clock::now();
  bool over_time = false;
};

/// Returns when one of them has ended, or after so many milliseconds.
void wait_for_any(const std::list<Running>& running, int milliseconds) {
  std::vector<pollfd> ends;
  for (const Running& one : running)
    ends.push_back({static_cast<int>(syscall(SYS_pidfd_open, one.process.pid(), 0)), POLLIN, 0});
  poll(ends.data(), ends.size(), milliseconds);
  for (const pollfd& end : ends)
    if (end.fd >= 0) close(end.fd);
}

/// The last line of a log that says something.
std::string last_line(const fs::path& log) {
  constexpr std::size_t kLongest = 500;
  auto text = read_file(log);
  if (!text) return {};
  text->erase(text->find_last_not_of(" \n\r\t") + 1);
  const std::string line = text->substr(text->rfind('\n') + 1);
  return line.size() <= kLongest ? line : line.substr(0, kLongest) + " ...";
}

/// Why a process ended without a row.
std::string reason_of(const Running& ended, int code, const fs::path& log, double time_limit_s) {
  std::string out;
  if (ended.over_time) {
    out = "ended after " + general_text(time_limit_s, 6) + " s of wall time, its limit";
  } else if (const char* name = code > 128 ? sigabbrev_np(code - 128) : nullptr) {
    out = std::string("killed by SIG") + name;
    if (code == 128 + SIGKILL) out += ": the machine had no memory left, or somebody ended it";
  } else {
    out = "the process ended with exit code " + std::to_string(code) + " and left no row";
  }
  const std::string said = last_line(log);
  return said.empty() ? out : out + "; it printed last: " + said;
}

std::string line_of(const Row& row) {
  std::string messages;
  for (const auto* texts : {&row.errors, &row.warnings})
    for (const std::string& text : *texts) messages += "; " + text;
  const auto value = row.journal_hash.empty() ? std::nullopt : row.figure(row.compared);
  const std::string figure =
      row.compared.empty() ? "" : ", " + row.compared + ' ' + (value ? general_text(*value, 6) : "-");
  return title_of(row.cell) + ": " + row.status + ", exit " + std::to_string(row.exit_code) + figure + messages;
}

std::string kind_of(const Cell& cell) { return cell.scenario + '\0' + cell.strategy; }

/// Plays the cells of a sweep whose rows are not there.
class CellPlayer {
 public:
  CellPlayer(const Suite& suite, const std::vector<Cell>& cells, const SweepOptions& options, const Host& host,
             RowFolder& folder)
      : suite_(suite),
        cells_(cells),
        options_(options),
        host_(host),
        folder_(folder),
        matcher_(*suite.catalogue, program_digest(), host.most) {}

  /// The rows of all cells, or those that existed before a stop: for a job of one machine, which writes no tables.
  Expected<std::vector<Row>> rows() {
    find_rows();
    if (Status s = play_open(suite_.planned_games()); !s) return s.error();
    return std::move(rows_);
  }
  /// The same of a whole sweep, whose tables grow with it.
  Expected<std::vector<Row>> rows_with_tables(const SweepStages* stages) {
    find_rows();
    if (Status s = folder_.take_tables_over(folder_.lost_rows(cells_, rows_, suite_), suite_, host_); !s)
      return s.error();
    tables_grow_ = !open_.empty();
    if (progress_.done > 0)
      if (Status s = grow_tables(); !s) return s.error();
    if (!stages) {
      if (Status s = play_open(suite_.planned_games()); !s) return s.error();
      return std::move(rows_);
    }
    progress_.may_end_early = stages->games.size() > 1;
    bool answered = false;
    for (const std::size_t games : stages->games) {
      if (answered && std::ranges::any_of(open_, [&](std::size_t i) { return game_of(cells_[i]) < games; })) break;
      if (Status s = play_open(games); !s) return s.error();
      if (host_.stopped()) break;
      std::vector<Row> rows;
      for (const Row& row : rows_)
        if (game_of(row.cell) < games) rows.push_back(row);
      const auto told = stages->is_answered(games, rows);
      if (!told) return told.error();
      answered = *told;
    }
    return std::move(rows_);
  }

 private:
  /// Which of the games of its strategy and scenario this cell is, from 0.
  std::size_t game_of(const Cell& cell) const { return (cell.number - 1) % suite_.planned_games(); }

  /// Plays the open cells of the first so many games of each strategy and scenario.
  Status play_open(std::size_t games) {
    if (!open_.empty() && !std::exchange(warned_, true))
      if (const auto warning = warning_without_wall()) host_.note(*warning);
    const auto later =
        std::ranges::stable_partition(open_, [&](std::size_t i) { return game_of(cells_[i]) < games; }).begin();
    const std::vector<std::size_t> now(open_.begin(), later);
    open_.erase(open_.begin(), later);
    auto next = now.begin();
    while ((next != now.end() || !running_.empty()) && !host_.stopped()) {
      for (; next != now.end() && running_.size() < static_cast<std::size_t>(options_.jobs); ++next)
        if (Status s = begin(*next); !s) return s;
      report();
      wait_for_any(running_, 100);
      if (Status s = take_ended(); !s) return s;
    }
    running_.clear();  // ends those that still play
    order_rows();
    return {};
  }

  /// Finds the rows that are there, and what is to be played.
  void find_rows() {
    for (std::size_t i = 0; i < cells_.size() && !host_.stopped(); ++i) {
      if (auto row = folder_.find(cells_[i], matcher_)) {
        if (!row->counts()) ++progress_.incomplete;
        keep(*std::move(row));
      } else {
        open_.push_back(i);
        remaining_.add(kind_of(cells_[i]));
      }
    }
    progress_.total = cells_.size();
    if (progress_.done > 0)
      host_.note(count_text(progress_.done, "row") + (progress_.done == 1 ? " is" : " are") + " current and kept");
    for (const Row& row : rows_)
      if (!(row.errors.empty() && row.warnings.empty())) host_.note("kept: " + line_of(row));
  }

  /// Keeps a row without what no table shows.
  void keep(Row row) {
    row.files.clear();
    rows_.push_back(std::move(row));
    ++progress_.done;
  }

  void order_rows() {
    std::ranges::sort(rows_, {}, [](const Row& row) { return row.cell.number; });
  }

  Status begin(std::size_t i) {
    const Cell& cell = cells_[i];
    const fs::path file = folder_.file_of(cell), part = folder_.unfinished(file);
    std::error_code error;
    fs::remove(file, error);
    ProcessOptions process;
    process.out = process.err = Stream::file(folder_.log_of(cell));
    const FileNames& names = matcher_.names_of(cell);
    const std::string& commit = matcher_.agent_commit_of(cell);
    auto started = Process::fork(process, [&] {
      auto out = AppendFile::create(part);  // the process opens no file of the sweep once rules have run
      if (!out) return kRowNotWritten;
      const Row row = play(cell, *suite_.catalogue, matcher_.program(), names, commit, host_);
      return out->append(row.to_json()) && out->close() ? 0 : kRowNotWritten;
    });
    if (!started) return started.error();
    remaining_.begun(kind_of(cell));
    running_.push_back({i, part, *std::move(started)});
    return {};
  }

  Status take_ended() {
    bool has_new_rows = false;
    for (auto it = running_.begin(); it != running_.end();) {
      const double seconds = wall_seconds_since(it->begin);
      auto code = it->process.wait_for(0);
      if (!code && options_.time_limit_s > 0 && seconds > options_.time_limit_s) {
        it->over_time = true;
        it->process.kill();
        code = it->process.wait();
      }
      if (!code) {
        ++it;
        continue;
      }
      remaining_.ended(kind_of(cells_[it->cell]), seconds);
      if (Status s = take(*it, *code); !s) return s;
      it = running_.erase(it);
      has_new_rows = true;
    }
    return has_new_rows ? grow_tables() : Status();
  }

  /// Writes the tables of the rows so far, unless they were written a short while ago. After a write that takes a
  /// second, the next hundred seconds have none, so all writes take at most a hundredth of the sweep. Tables are
  /// replaced as a whole, so the index is complete at any time, even after a kill.
  Status grow_tables() {
    constexpr double kShare = 0.01;
    if (!tables_grow_ || progress_.done == progress_.total) return {};  // the whole tables come next
    if (wall_seconds_since(tables_written_) * kShare < tables_take_s_) return {};
    const Clock::time_point begin = Clock::now();
    order_rows();
    if (Status s = folder_.write_tables(rows_, suite_); !s) return s;
    tables_written_ = Clock::now();
    tables_take_s_ = wall_seconds_since(begin);
    return {};
  }

  /// Takes the row that a process has left, or makes one that says why it left none.
  Status take(const Running& ended, int code) {
    const Cell& cell = cells_[ended.cell];
    const fs::path file = folder_.file_of(cell), log = folder_.log_of(cell);
    std::error_code error;
    std::optional<Row> row = read_row(ended.part);
    if (row) {
      row->cell = cell;
      fs::rename(ended.part, file, error);
      if (error) return resource_error("cannot be written: " + error.message(), file.string());
    } else {
      fs::remove(ended.part, error);
      if (code == kRowNotWritten)
        return resource_error(
            "the row cannot be written; is the disk full? Rows that are there are kept, and the same "
            "command goes on",
            file.string());
      row = crashed(cell, code, reason_of(ended, code, log, options_.time_limit_s));
      if (Status s = folder_.write(*row); !s) return s;
    }
    if (fs::file_size(log, error) == 0 && !error) fs::remove(log, error);
    const bool counts = row->counts();
    if (!counts) ++progress_.incomplete;
    keep(*std::move(row));
    progress_.playing = running_.size() - 1;
    if (host_.progress) {
      const std::string line =
          '[' + std::to_string(progress_.done) + '/' + std::to_string(progress_.total) + "] " + line_of(rows_.back());
      estimate();
      host_.progress->game_ended(line, progress_, !counts || warns_of_something_new(rows_.back()));
    }
    return {};
  }

  /// Whether it has a warning that no other game of its strategy had so far; the table counts them all.
  bool warns_of_something_new(const Row& row) {
    bool is_new = false;
    for (const std::string& text : row.warnings) is_new |= warnings_.insert(kind_of(row.cell) + '\0' + text).second;
    return is_new;
  }

  Row crashed(const Cell& cell, int code, const std::string& reason) {
    Row row;
    row.cell = cell;
    row.program = matcher_.program();
    row.allowance = matcher_.allowance();
    row.file = matcher_.names_of(cell).name_of(cell.file);
    row.files[row.file] = matcher_.hash(cell.file);
    if (!cell.game_file.empty())
      row.files[matcher_.names_of(cell).name_of(cell.game_file)] = matcher_.hash(cell.game_file);
    row.key = row.digest();
    row.status = "crashed";
    row.exit_code = code;
    row.errors = {reason};
    row.circumstances.host = host_name();
    row.circumstances.agent_commit = matcher_.agent_commit_of(cell);
    const std::vector<Override> overrides(cell.overrides.begin(), cell.overrides.end());
    if (const auto scenario = Scenario::load(cell.file, *suite_.catalogue, overrides))
      row.measure(*scenario->world.kind, "{}");
    return row;
  }

  void estimate() {
    double playing_s = 0;
    for (const Running& one : running_) playing_s += wall_seconds_since(one.begin);
    progress_.seconds_left = remaining_.estimate(options_.jobs, playing_s);
  }

  void report() {
    if (!host_.progress) return;
    progress_.playing = running_.size();
    estimate();
    host_.progress->sweep_progress(progress_);
  }

  const Suite& suite_;
  const std::vector<Cell>& cells_;
  const SweepOptions& options_;
  const Host& host_;
  RowFolder& folder_;
  RowMatcher matcher_;
  std::vector<Row> rows_;          // so far
  std::vector<std::size_t> open_;  // cells, in their order
  std::list<Running> running_;
  RemainingTime remaining_;
  std::set<std::string> warnings_;  // that were printed
  GamesProgress progress_;
  bool tables_grow_ = false, warned_ = false;
  Clock::time_point tables_written_{};
  double tables_take_s_ = 0;  // the last time
};

/// What a row says of its game, without where and when it was played and how the suite calls it.
std::string outcome_of(Row row) {
  row.cell = {};
  row.circumstances = {};
  for (Figure& figure : row.figures)
    if (figure.of_machine) figure.value.reset();
  return row.to_json();
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

Expected<std::vector<Row>> sweep(const Suite& suite, const SweepOptions& options, const Host& host,
                                 const SweepStages* stages) {
  auto folder = RowFolder::open(options.folder, FolderUse::kAlone);
  if (!folder) return folder.error();
  folder->remove_unfinished();
  const std::vector<Cell> cells = suite.cells();
  auto rows = CellPlayer(suite, cells, options, host, *folder).rows_with_tables(stages);
  if (!rows) return rows.error();
  if (Status s = folder->write_tables(*rows, suite); !s) return s.error();
  return rows;
}

Expected<std::vector<Row>> play_cells(const Suite& suite, const std::vector<Cell>& cells, const SweepOptions& options,
                                      const Host& host) {
  auto folder = RowFolder::open(options.folder, FolderUse::kTogether);
  if (!folder) return folder.error();
  return CellPlayer(suite, cells, options, host, *folder).rows();
}

Expected<std::vector<Cell>> missing_cells(const Suite& suite, const fs::path& folder, const Limits& limits) {
  auto rows = RowFolder::open(folder, FolderUse::kTogether);
  if (!rows) return rows.error();
  RowMatcher matcher(*suite.catalogue, program_digest(), limits);
  std::vector<Cell> out;
  for (const Cell& cell : suite.cells())
    if (!rows->find(cell, matcher)) out.push_back(cell);
  return out;
}

namespace {

/// Tables do not lose rows because the games of these rows would be played otherwise now. `changed` is a file that
/// differs now, if one is known.
Status check_tables(const RowFolder& out, const Collected& collected, const Suite& suite, const fs::path& folder,
                    const std::string& changed, const Host& host) {
  const std::vector<Row> of_others = out.lost_rows(suite.cells(), collected.rows, suite);
  if (Status s = out.take_tables_over(of_others, suite, host); !s) return s;
  std::vector<Cell> cells;
  for (const Row& row : collected.rows) cells.push_back(row.cell);
  const std::size_t lost = out.lost_rows(cells, collected.rows, suite).size() - of_others.size();
  if (lost == 0) return {};
  const std::string why = !changed.empty() ? changed + " has changed since they were played"
                          : collected.of_other_programs > 0
                              ? "another build of cxlab played them"
                              : "no file in rows/*.json tells how their games are played now";
  return input_error("would lose " + count_text(lost, "row") + ", because " + why +
                         "; it stays as it is. To play these games again: cxlab bench " +
                         shell_word(suite.file.string()) + " --out " + shell_word(folder.string()) +
                         "; to collect only what is current: --out with another folder",
                     (folder / "rows.csv").string());
}

}  // namespace

Expected<Collected> collect(const Suite& suite, const std::vector<fs::path>& from, const fs::path& folder,
                            const Host& host) {
  for (const fs::path& source : from)
    if (!is_folder(source / "rows"))
      return input_error("expected a folder with the rows of a sweep, rows/*.json", source.string());
  auto out = RowFolder::open(folder, FolderUse::kTogether);
  if (!out) return out.error();
  RowMatcher matcher(*suite.catalogue, program_digest(), host.most);
  Collected collected;

  std::vector<fs::path> sources{folder};
  for (const fs::path& source : from)
    if (std::error_code error; !fs::equivalent(source, folder, error)) sources.push_back(source);
  std::multimap<std::string, fs::path> known;  // by identity
  for (const fs::path& source : sources)
    for (const fs::path& file : row_files(source)) {
      if (host.stopped()) return collected;
      const auto row = read_row(file);
      if (!row)
        ++collected.broken;
      else if (row->program != matcher.program())
        ++collected.of_other_programs;
      else
        known.emplace(identity_of(row->cell), file);
    }

  std::set<fs::path> used;
  std::string changed;  // a file of the games without a row
  for (const Cell& cell : suite.cells()) {
    std::optional<Row> best;
    fs::path place;
    bool contradictory = false;
    const auto [first, last] = known.equal_range(identity_of(cell));
    for (auto it = first; it != last; ++it) {
      auto row = read_row(it->second);
      if (!row || !matcher.tells_of(*row, cell)) continue;
      used.insert(it->second);
      const auto worth = [](const Row& one) { return one.counts() ? 2 : one.journal_hash.empty() ? 0 : 1; };
      const bool better = !best || worth(*row) > worth(*best);
      if (best && !row->journal_hash.empty() && !best->journal_hash.empty() && row->allowance == best->allowance &&
          outcome_of(*row) != outcome_of(*best)) {
        contradictory = true;
        if (collected.differ.first.empty()) collected.differ = {place, it->second};
      }
      if (!better) continue;
      best = std::move(row);
      place = it->second;
    }
    if (contradictory) collected.contradictory.push_back(cell.number);
    if (!best) {
      collected.missing.push_back(cell.number);
      for (auto it = first; it != last && changed.empty(); ++it)
        if (const auto row = read_row(it->second)) changed = matcher.changed_file(*row, cell);
      continue;
    }
    best->cell = cell;
    if (place != out->file_of(cell)) {
      if (Status s = out->write(*best); !s) return s.error();
      ++collected.taken;
    }
    best->files.clear();
    collected.rows.push_back(*std::move(best));
  }
  collected.outdated = known.size() - used.size();
  if (Status s = check_tables(*out, collected, suite, folder, changed, host); !s) return s.error();
  if (Status s = out->write_tables(collected.rows, suite); !s) return s.error();
  return collected;
}

}  // namespace cxlab::lab
