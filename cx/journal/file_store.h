#pragma once
// Copies of the files that a run read, by content, so that it replays elsewhere: RUN/files/<hash> and index.jsonl.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/append_file.h"
#include "cx/base/expected.h"

namespace cxlab {

/// 32 hex digits (XXH3, 128 bit).
std::string content_hash(std::string_view bytes);

/// Takes the copies while the run reads. Logical names are relative ("<package>/rules/dispatch.clp",
/// "scenario/game.yaml"): no drive, no "..", forward slashes. Each copy is in the index before its file is used, so
/// that the index is whole whenever the process ends.
class FileStore {
 public:
  /// Makes `run/files`.
  static Expected<FileStore> create(const std::filesystem::path& run);

  /// Copies the file as it is now. A name that comes again with other content keeps its first, later ones are listed.
  Status add(const std::string& logical_name, const std::filesystem::path& source);
  Status add_content(const std::string& logical_name, std::string_view bytes);

 private:
  FileStore(std::filesystem::path folder, AppendFile index) : folder_(std::move(folder)), index_(std::move(index)) {}
  std::filesystem::path folder_;
  AppendFile index_;
  std::map<std::string, std::vector<std::string>> hashes_;  // by name: each content in order of coming
};

/// Gives them back for a replay.
class StoredFiles {
 public:
  static Expected<StoredFiles> open(const std::filesystem::path& run);
  /// The hash of each name: of its first content.
  const std::map<std::string, std::string>& hashes() const { return hashes_; }

  /// In order of names.
  std::vector<std::string> names() const;
  bool contains(const std::string& logical_name) const { return hashes_.contains(logical_name); }
  /// The first content under that name, checked against its hash.
  Expected<std::string> read(const std::string& logical_name) const;
  /// Writes every file as `folder/<logical name>`, for loaders that need paths and neighbours.
  Status materialise(const std::filesystem::path& folder) const;

 private:
  explicit StoredFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
  std::map<std::string, std::string> hashes_;  // by name
};

}  // namespace cxlab
