#include "cx/journal/file_store.h"

#include <fcntl.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <system_error>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/hash_text.h"
#include "cx/journal/run_folder.h"

namespace cxlab {
namespace {

namespace fs = std::filesystem;

/// A name stays inside the folder under which it is laid out.
bool is_logical_name(const std::string& name) {
  const fs::path path(name);
  return path.has_filename() && path.is_relative() && path.lexically_normal().string() == name && name != "." &&
         *path.begin() != ".." && name.find('\0') == std::string::npos;
}

/// What `replace_file` writes first; it keeps the rights of a file that is there.
constexpr const char* kUnfinished = ".part";

void make_empty(const std::string& path, mode_t mode) {
  if (const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode); file >= 0) close(file);
}

bool is_hash(const std::string& text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace

std::string content_hash(std::string_view bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return hash_text(hash.high64) + hash_text(hash.low64);
}

Expected<FileStore> FileStore::create(const fs::path& run) {
  const fs::path folder = run / "files";
  if (Status s = make_folder(folder); !s) return s.error();
  auto index = AppendFile::create(folder / "index.jsonl");
  if (!index) return index.error();
  return FileStore(folder, *std::move(index));
}

Status FileStore::add(const std::string& logical_name, const fs::path& source) {
  auto bytes = read_file(source);
  if (!bytes) return bytes.error();
  // Whom the source is closed to, the copy is closed to from the beginning: behind a wall no rights are changed.
  std::error_code ignored;
  const fs::perms open_to =
      (fs::perms::group_read | fs::perms::others_read) & fs::status(source, ignored).permissions();
  const fs::path copy = folder_ / content_hash(*bytes);
  if (!fs::exists(copy, ignored)) make_empty(copy.string() + kUnfinished, 0600 | static_cast<mode_t>(open_to));
  return add_content(logical_name, *bytes);
}

Status FileStore::add_content(const std::string& logical_name, std::string_view bytes) {
  if (!is_logical_name(logical_name)) {
    return bug_error("'" + logical_name + "' is no relative name for a copy");
  }
  const std::string hash = content_hash(bytes);
  auto& hashes = hashes_[logical_name];
  if (std::ranges::find(hashes, hash) != hashes.end()) return {};
  std::error_code ignored;
  if (!fs::exists(folder_ / hash, ignored)) {
    if (Status s = replace_file(folder_ / hash, bytes); !s) return s;
  }
  hashes.push_back(hash);
  const Json line = {{"name", logical_name}, {"hash", hash}};
  if (Status s = index_.append(json_text(line) + '\n'); !s) return s;
  return index_.flush();
}

Expected<StoredFiles> StoredFiles::open(const fs::path& run) {
  StoredFiles store(run / "files");
  const std::string index_path = (store.folder_ / "index.jsonl").string();
  auto text = read_file(index_path);
  if (!text) return text.error();
  std::size_t begin = 0;
  int number = 1;
  // A last line without its end is that of a process that was killed.
  for (std::size_t end = text->find('\n'); end != text->npos; end = text->find('\n', begin = end + 1), ++number) {
    const Json line = parse_json(text->substr(begin, end - begin));
    const auto word = [&line](const char* key) {
      const auto known = line.is_object() ? line.find(key) : line.end();
      return known != line.end() && known->is_string() ? known->get<std::string>() : std::string();
    };
    const std::string name = word("name"), hash = word("hash");
    if (!is_logical_name(name))
      return input_error(found_text(name, "the name of a copy in the folder of the run"), index_path, number);
    if (!is_hash(hash)) return input_error("expected a hash of 32 hex digits for '" + name + "'", index_path, number);
    store.hashes_.emplace(name, hash);
  }
  return store;
}

std::vector<std::string> StoredFiles::names() const {
  std::vector<std::string> names;
  for (const auto& [name, hash] : hashes_) names.push_back(name);
  return names;
}

Expected<std::string> StoredFiles::read(const std::string& logical_name) const {
  const auto found = hashes_.find(logical_name);
  if (found == hashes_.end()) return input_error("the run kept no copy of '" + logical_name + "'", folder_.string());
  const fs::path path = folder_ / found->second;
  auto bytes = read_file(path);
  if (bytes && content_hash(*bytes) != found->second) {
    return input_error("the copy of '" + logical_name + "' was changed: its content does not have this hash",
                       path.string());
  }
  return bytes;
}

Status StoredFiles::materialise(const fs::path& folder) const {
  for (const auto& [name, hash] : hashes_) {
    auto bytes = read(name);
    if (!bytes) return bytes.error();
    const fs::path path = folder / name;
    if (Status s = make_folder(path.parent_path()); !s) return s;
    if (Status s = replace_file(path, *bytes); !s) return s;
  }
  return {};
}

}  // namespace cxlab
