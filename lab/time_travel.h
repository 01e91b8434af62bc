#pragma once
// A recorded run, played again forwards and backwards for one who is attached to it.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "cx/base/expected.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "cx/engine/rule_counts.h"
#include "lab/control/server.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

/// Plays in a process of its own, which is confined as each that plays rules.
class TimeTravel {
 public:
  struct Options {
    Counting counting = Counting::kNothing;  ///< kUse for how often rules were put on the agenda
    bool quiet = false;                      ///< errors of that process are kept for `said`
  };
  /// Errors of the run are reported by that process, on standard error; see `ended`.
  static Expected<std::unique_ptr<TimeTravel>> start(const Run& run, const Host& host, Options options);
  static Expected<std::unique_ptr<TimeTravel>> start(const Run& run, const Host& host) { return start(run, host, {}); }
  const ControlAddress& address() const { return address_; }
  /// The exit code, if the process has ended.
  std::optional<int> ended() { return process_.wait_for(0); }
  /// What the process has written on standard error, if it is quiet: at most the last 10,000 bytes.
  std::string said() const;

 private:
  TimeTravel(std::unique_ptr<ScratchFolder> folder, ControlAddress address, Process process)
      : folder_(std::move(folder)), address_(std::move(address)), process_(std::move(process)) {}

  std::unique_ptr<ScratchFolder> folder_;  // of the socket
  ControlAddress address_;
  Process process_;
};

}  // namespace cxlab::lab
