#pragma once
// Processes that play recorded runs for `cxlab view`, each behind its wall (lab/time_travel.h). They are started by a
// copy of this process that has one thread, because this one serves with many.

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "cx/base/servant.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

class Players {
 public:
  /// Before this process has a second thread.
  static Expected<Players> start(const Catalogue& catalogue, bool trust_programs, const Host& host);
  Players(Players&& other) noexcept : starter_(std::move(other.starter_)) {}

  struct Player {
    int number = 0;
    std::string socket;         ///< of its lines (lab/control/client.h)
    std::optional<double> end;  ///< of the run, in s; none: its log says when it ends
  };
  /// May be called from any thread, as all that follows.
  Expected<Player> play(const std::filesystem::path& run);
  /// Why the process has ended, if it has.
  std::optional<Error> end_of(int number);
  /// Ends the process.
  void end(int number);
  /// GET /api/two (docs/reference/view.md), as JSON: what `cxlab diff` says.
  Expected<std::string> compare(const std::filesystem::path& a, const std::filesystem::path& b);
  /// Ends all of them, and plays no other.
  void end_all();

 private:
  explicit Players(Servant starter) : starter_(std::in_place, std::move(starter)) {}
  std::string ask(const std::string& request);

  std::mutex mutex_;
  std::optional<Servant> starter_;
};

}  // namespace cxlab::lab
