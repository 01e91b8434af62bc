#include "lab/git_commit.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "cx/base/file.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// The first line of a file, without blanks at its end.
std::string line_of_file(const fs::path& file) {
  const auto text = is_file(file) ? read_file(file) : Expected<std::string>(input_error("no file"));
  if (!text) return {};
  const std::string line = text->substr(0, text->find('\n'));
  return line.substr(0, line.find_last_not_of(" \r\t") + 1);
}

bool is_commit(const std::string& text) {
  return (text.size() == 40 || text.size() == 64) &&
         std::ranges::all_of(text, [](char c) { return ('0' <= c && c <= '9') || ('a' <= c && c <= 'f'); });
}

/// `.git` of the nearest folder that has one: a folder, or a file that names one (a worktree, a submodule).
std::optional<fs::path> git_folder(fs::path folder) {
  for (;; folder = folder.parent_path()) {
    const fs::path git = folder / ".git";
    if (is_folder(git)) return git;
    if (const std::string line = line_of_file(git); line.starts_with("gitdir: "))
      return (folder / line.substr(8)).lexically_normal();
    if (folder == folder.parent_path()) return std::nullopt;
  }
}

std::string packed_reference(const fs::path& file, const std::string& name) {
  const auto text = is_file(file) ? read_file(file) : Expected<std::string>(input_error("no file"));
  if (!text) return {};
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t blank = line.find(' '); blank != line.npos && line.substr(blank + 1) == name)
      return line.substr(0, blank);
  return {};
}

}  // namespace

std::string git_commit_of(const fs::path& folder) {
  std::error_code error;
  const fs::path real = fs::canonical(folder, error);
  const auto git = error ? std::nullopt : git_folder(real);
  if (!git) return {};
  std::string commit = line_of_file(*git / "HEAD");
  if (commit.starts_with("ref: refs/") && commit.find("..") == commit.npos) {
    const std::string name = commit.substr(5);
    const std::string common = line_of_file(*git / "commondir");  // of a worktree
    const fs::path shared = common.empty() ? *git : (*git / common).lexically_normal();
    commit = line_of_file(*git / name);
    if (commit.empty()) commit = line_of_file(shared / name);
    if (commit.empty()) commit = packed_reference(shared / "packed-refs", name);
  }
  return is_commit(commit) ? commit : std::string();
}

}  // namespace cxlab::lab
