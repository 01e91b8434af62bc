#pragma once
// A recorded run, played again forwards and backwards for one who is attached to it.

#include <memory>

#include "cx/base/expected.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "lab/control/server.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

/// Plays in a process of its own, which is confined as each that plays rules.
class TimeTravel {
 public:
  /// Errors of the run are reported by that process, on standard error; see `ended`.
  static Expected<std::unique_ptr<TimeTravel>> start(const Run& run, const Host& host);
  const ControlAddress& address() const { return address_; }
  /// The exit code, if the process has ended.
  std::optional<int> ended() { return process_.wait_for(0); }

 private:
  TimeTravel(std::unique_ptr<ScratchFolder> folder, ControlAddress address, Process process)
      : folder_(std::move(folder)), address_(std::move(address)), process_(std::move(process)) {}

  std::unique_ptr<ScratchFolder> folder_;  // of the socket
  ControlAddress address_;
  Process process_;
};

}  // namespace cxlab::lab
