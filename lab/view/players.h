#pragma once
// What the server of `cxlab view` cannot do behind its wall: it starts processes that play recorded runs, and connects
// to them and to runs in progress. Each of these processes has a wall of its own (lab/time_travel.h). A copy of the
// server does this. It has one thread, and serves only the runs of the place that was named.

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "cx/base/json.h"
#include "cx/base/servant.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

class Players {
 public:
  /// Before this process has a second thread. `place`: the folder of a run, or of runs.
  static Expected<Players> start(const std::filesystem::path& place, const Catalogue& catalogue, bool trust_programs,
                                 const Host& host);
  Players(Players&& other) noexcept : starter_(std::move(other.starter_)) {}

  struct Player {
    int number = 0;
    std::optional<double> end;  ///< of the run, in s; none: its log says when it ends
  };
  /// May be called from any thread, as all that follows.
  Expected<Player> play(const std::filesystem::path& run);
  /// A connection for lines (lab/control/client.h); kResource while the process does not listen yet.
  Expected<Descriptor> connect(int number);
  /// The same to a run in progress; kResource if it does not listen.
  Expected<Descriptor> connect_to_run(const std::filesystem::path& run);
  bool is_live(const std::filesystem::path& run) { return connect_to_run(run).ok(); }
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
  Servant::Answer ask(const Json& request);
  Json answer_to(const Json& request);
  Expected<Descriptor> connection(const Json& request);

  std::mutex mutex_;
  std::optional<Servant> starter_;
};

}  // namespace cxlab::lab
