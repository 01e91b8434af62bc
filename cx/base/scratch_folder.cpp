#include "cx/base/scratch_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <system_error>

namespace cxlab {

namespace fs = std::filesystem;

namespace {

constexpr const char* kPrefix = "cxlab-scratch-";

/// The folder, open and locked; -1 if it is another user's, or somebody's who lives.
int lock_folder(const fs::path& folder) {
  const int file = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) return -1;
  struct stat known{};
  if (fstat(file, &known) == 0 && known.st_uid == geteuid() && flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  close(file);
  return -1;
}

/// What processes left that were killed.
void remove_the_dead(const fs::path& where) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(where, error)) {
    if (!entry.path().filename().string().starts_with(kPrefix)) continue;
    const int file = lock_folder(entry.path());
    if (file < 0) continue;
    fs::remove_all(entry.path(), error);
    close(file);
  }
}

}  // namespace

Expected<std::unique_ptr<ScratchFolder>> ScratchFolder::create(RemovedBy remover) {
  std::error_code error;
  const fs::path where = fs::temp_directory_path(error);
  if (!error) remove_the_dead(where);
  for (int attempt = 0; !error && attempt < 10; ++attempt) {
    std::string name = (where / kPrefix).string() + "XXXXXX";
    if (!mkdtemp(name.data())) break;
    const int lock = lock_folder(name);
    if (lock >= 0 && fs::exists(name, error)) {
      std::unique_ptr<ScratchFolder> folder(new ScratchFolder(name, lock));
      if (remover == RemovedBy::kThisProcess) return folder;
      auto servant = Servant::start({}, [path = folder->path_] {
        std::error_code ignored;
        fs::remove_all(path, ignored);
      });
      if (!servant) return servant.error();
      folder->servant_ = *std::move(servant);
      return folder;
    }
    if (lock >= 0) close(lock);  // another process took the folder for a dead one before it was locked
  }
  return resource_error("cannot make a temporary folder in " + where.string());
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (!servant_) fs::remove_all(path_, ignored);
  servant_.reset();
  close(lock_);
}

}  // namespace cxlab
