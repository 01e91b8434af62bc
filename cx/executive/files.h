#pragma once
// Packages and the run's folder: which files plugins and rules see, and where writing ends up.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/outside.h"

namespace cxlab::cx {

/// A ROS package: rules see `share` as its share directory, the files lie in `folder`. The two differ where a run is
/// replayed from copies.
struct Package {
  std::filesystem::path folder;
  std::string share;  ///< empty = `folder` as an absolute path
  std::filesystem::path rest =
      {};  ///< has the files that `folder` lacks: cxlab's own package of that name; may be empty
};

/// Called with each file before it is read: `logical_name` is "<package>/clips/a.clp" or the file's name.
using FileRead = std::function<Status(const std::string& logical_name, const std::filesystem::path& file)>;

/// Code of an error: rules may not read what is there.
inline constexpr const char* kRefused = "refused";

/// A file that was found.
struct FoundFile {
  std::filesystem::path path;
  std::string logical_name;  ///< the same on every machine: names the file in the journal and among the run's copies
};

/// A relative name for the copy of a file that lies in no package: its path, without a leading '/' and "..".
std::filesystem::path outside_name(const std::filesystem::path& path);

/// Whether the file, its links followed, lies in the folder or in what the folder itself links to.
bool really_below(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Whether a file of an install space links to the same file of its source, as `colcon build --symlink-install` makes
/// them: the package.xml does so, too.
bool links_to_source(const std::filesystem::path& file, const std::filesystem::path& package);

/// One environment manager's view of the disk. For rules (`FileAccess`): they read packages and what they wrote
/// themselves; what they write goes below `<run>/written`. With `trust_rules` they read and write anything, but for a
/// replay, which writes below the run's folder all the same.
class Files final : public FileAccess {
 public:
  struct Options {
    std::map<std::string, Package> packages;
    std::filesystem::path run_folder;  ///< empty = rules cannot write
    bool trust_rules = false;
    FileRead on_read;               ///< may be none
    std::filesystem::path outside;  ///< replay: copies of files outside of packages, under `outside_name`; else empty
    std::filesystem::path recorded_folder = {};  ///< replay: the run's folder then; paths below it mean this one's
    /// Files whose content is that of others. Both are absolute.
    std::map<std::filesystem::path, std::filesystem::path> instead = {};
  };
  explicit Files(Options options);

  /// Share directory of the package; an error names the nearest.
  Expected<std::string> share_directory(std::string_view package) const;
  /// As in ament: the path before `/share/<package>`, else the folder itself.
  Expected<std::string> prefix(std::string_view package) const;
  std::vector<std::string> packages() const;  ///< sorted
  /// The folders of all packages, and the folders with files that these lack.
  std::vector<std::filesystem::path> folders() const;

  /// Finds a file as CX does: absolute, else the first of the packages that has it, asked in order.
  Expected<FoundFile> resolve(const std::string& file, const std::vector<std::string>& packages) const;
  /// The files below a folder with that extension (".proto"), by their paths from it, sorted. The folder is found as a
  /// file is: absolute, else in the first of the packages that has it. For rules only folders of packages are looked
  /// at.
  Expected<std::map<std::string, FoundFile>> list(const std::string& folder, const std::vector<std::string>& packages,
                                                  std::string_view extension, bool for_rules = false) const;
  /// The content; calls `on_read` before it reads.
  Expected<std::string> read(const FoundFile& file) const;
  /// The file that `path` means to rules, if they may read it.
  Expected<FoundFile> find_for_rules(const std::string& path) const;

  Expected<std::string> for_reading(const std::string& path) override;
  Expected<std::string> for_writing(const std::string& path) override;
  std::string journal_name(const std::string& path) const override;

 private:
  Expected<FoundFile> find_where_rules_read(const std::string& path) const;
  /// The file in the package; also where `share/<p>/clips/<p>/x` comes from a source tree's `clips/x`.
  bool find_in(const std::string& package, const std::filesystem::path& relative, FoundFile& out) const;
  /// The file itself, or its copy.
  std::filesystem::path outside(const std::filesystem::path& path) const;
  /// The file that has its content.
  std::filesystem::path content_of(const std::filesystem::path& path) const;
  std::filesystem::path written(const std::filesystem::path& path) const;
  /// What rules ask for, without "." and "..", and in this run's folder where it was in that of the recorded run.
  std::filesystem::path asked_for(const std::string& path) const;

  Options options_;
};

}  // namespace cxlab::cx
