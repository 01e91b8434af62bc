#pragma once
// The runs that `cxlab view` was given: one, or those below a folder. Whoever asks names one by its id, which comes
// from this list alone and is no path.

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "lab/run.h"
#include "lab/view/players.h"

namespace cxlab::lab {

class ViewedRuns {
 public:
  /// `place`: the folder of a run, or one with runs in it or below, such as that of a sweep. kInput if it has none.
  static Expected<ViewedRuns> open(const std::filesystem::path& place, const Catalogue& catalogue);
  ViewedRuns(ViewedRuns&& other) noexcept;

  /// The id of the one run; nothing for a folder of runs.
  const std::optional<std::string>& only() const { return only_; }
  /// The folder of a run; nothing for an id that is none.
  std::optional<std::filesystem::path> find(const std::string& id);
  /// The folder that was named, as a real path.
  const std::filesystem::path& place() const { return place_; }
  /// GET /api/runs (docs/reference/view.md). Looks into the folder again.
  Json table(Players& players);

 private:
  ViewedRuns(std::filesystem::path place, const Catalogue& catalogue)
      : place_(std::move(place)), catalogue_(&catalogue) {}
  void look();
  Json row_of(const std::string& id, const std::filesystem::path& folder, Players& players);

  std::filesystem::path place_;
  const Catalogue* catalogue_;
  std::optional<std::string> only_;
  std::mutex mutex_;
  std::map<std::string, std::filesystem::path> folders_;      // by id; none goes while this lives
  std::map<std::string, std::pair<std::string, Json>> rows_;  // by id: result.json as it was, and what was made of it
};

}  // namespace cxlab::lab
