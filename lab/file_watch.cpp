#include "lab/file_watch.h"

#include <sys/stat.h>

namespace cxlab::lab {

FileWatch::State FileWatch::look(const std::filesystem::path& file) {
  struct stat found{};
  if (stat(file.c_str(), &found) != 0) return {};
  const auto ns = [](const timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; };
  return {static_cast<std::uint64_t>(found.st_dev), static_cast<std::uint64_t>(found.st_ino),
          static_cast<std::int64_t>(found.st_size), ns(found.st_mtim), ns(found.st_ctim)};
}

void FileWatch::watch(const std::set<std::filesystem::path>& files, std::int64_t since) {
  std::map<std::filesystem::path, Watched> now;
  for (const std::filesystem::path& file : files) {
    const auto known = files_.find(file);
    const State state = look(file);
    if (known != files_.end())
      now.insert(*known);
    else
      now[file] = {state.written_ns > since ? State() : state, state};
  }
  files_ = std::move(now);
}

std::set<std::filesystem::path> FileWatch::changed() {
  std::set<std::filesystem::path> out;
  for (auto& [file, watched] : files_) {
    const State now = look(file);
    const bool rests = now == watched.last;
    watched.last = now;
    if (!rests || now == watched.told) continue;
    watched.told = now;
    out.insert(file);
  }
  return out;
}

}  // namespace cxlab::lab
