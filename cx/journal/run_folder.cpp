#include "cx/journal/run_folder.h"

#include <cerrno>
#include <cstring>
#include <system_error>

#include <sys/stat.h>

#include "cx/base/append_file.h"

namespace cxlab {
namespace {

namespace fs = std::filesystem;

/// What a run writes; `--force` takes these away from a former one.
constexpr const char* kFilesOfARun[] = {"manifest.json", "result.json", "inputs.bin", "journal.jsonl",
                                        "scene.bin",     "index.html",  "game.yaml",  "report.json",
                                        "logs",          "snapshots",   "files"};

Status cannot_be_made(const fs::path& path, const std::string& why) {
  return resource_error("cannot be made: " + why, path.string());
}

bool holds_a_run(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "manifest.json", ignored) || fs::exists(folder / "result.json", ignored);
}

}  // namespace

Status put_in_place(Status written, const fs::path& unfinished, const fs::path& path) {
  std::error_code error;
  if (written) {
    fs::rename(unfinished, path, error);
    if (!error) return {};
    written = resource_error("cannot be written: " + error.message(), path.string());
  }
  fs::remove(unfinished, error);
  return written;
}

Status replace_file(const fs::path& path, std::string_view text, const fs::path& unfinished) {
  auto file = AppendFile::create(unfinished);
  if (!file) return file.error();
  Status written = file->append(text);
  if (written) written = file->close();
  return put_in_place(std::move(written), unfinished, path);
}

Status replace_file(const fs::path& path, std::string_view text) {
  return replace_file(path, text, path.string() + ".part");
}

Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return error ? cannot_be_made(folder, error.message()) : Status();
}

Expected<fs::path> make_numbered_folder(const fs::path& parent, const std::string& name) {
  if (Status s = make_folder(parent); !s) return s.error();
  for (int number = 1;; ++number) {
    const fs::path path = parent / (number == 1 ? name : name + "-" + std::to_string(number));
    if (::mkdir(path.c_str(), 0777) == 0) return path;
    if (errno != EEXIST) return cannot_be_made(path, std::strerror(errno)).error();
  }
}

Status make_output_folder(const fs::path& path, bool force) {
  std::error_code error;
  const fs::file_status found = fs::status(path, error);
  if (!fs::exists(found)) return make_folder(path);
  if (!fs::is_directory(found)) return usage_error("the output folder is a file", path.string());
  const bool empty = fs::is_empty(path, error);
  if (error) return cannot_be_made(path, error.message());
  if (!empty && !force)
    return usage_error("the output folder is not empty; --force writes into it all the same", path.string());
  if (empty || !holds_a_run(path)) return {};
  for (const char* name : kFilesOfARun) {
    fs::remove_all(path / name, error);
    if (error) return cannot_be_made(path / name, error.message());
  }
  return {};
}

}  // namespace cxlab
