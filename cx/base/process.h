#pragma once
// Another process, as a value: it is started without a shell and does not outlive the object or this process.

#include <csignal>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

/// Where a standard stream of the process comes from or goes to.
struct Stream {
  enum class Kind { kInherit, kNull, kPipe, kFile };
  Kind kind = Kind::kInherit;
  std::filesystem::path path;  ///< of kFile; a file that is written is emptied first

  static Stream null() { return {Kind::kNull, {}}; }
  static Stream pipe() { return {Kind::kPipe, {}}; }
  static Stream file(std::filesystem::path path) { return {Kind::kFile, std::move(path)}; }
};

struct ProcessOptions {
  std::vector<std::string> argv = {};  ///< the program first; one without '/' is looked up in $PATH
  /// Variables beside or instead of those of this process.
  std::vector<std::pair<std::string, std::string>> environment = {};
  std::filesystem::path folder = {};               ///< to work in; empty = that of this process
  Stream in = Stream::null(), out = {}, err = {};  ///< only `in` may be a pipe; `out` and `err` may be one file
};

/// The process and all that it starts form a process group. The group is killed when the process ends and when this
/// object is destroyed. The process itself is also killed when this process ends in any way.
class Process {
 public:
  /// Runs a program. kResource if it cannot be run.
  static Expected<Process> start(const ProcessOptions& options);
  /// Runs `work` in a copy of this process, which must have one thread only. `argv` and `environment` have no meaning.
  /// The copy has the standard streams and `kept`, and no other descriptor of this process. So rules that escape in it
  /// reach no other copy.
  static Expected<Process> fork(const ProcessOptions& options, const std::function<int()>& work, int kept = -1);

  Process(Process&& other) noexcept { *this = std::move(other); }
  Process& operator=(Process&& other) noexcept;
  ~Process();

  /// The exit code; 128 + the number of the signal that ended it.
  int wait();
  /// The same; nothing if it has not ended after so many seconds. 0 only looks.
  std::optional<int> wait_for(double seconds);
  /// Sends a signal to the group.
  void kill(int signal = SIGKILL) const;

  /// Into its standard input, a pipe.
  Status write(std::string_view bytes);
  void close_input();

  pid_t pid() const { return pid_; }

 private:
  Process() = default;
  template <class Work>
  static Expected<Process> fork_child(const ProcessOptions& options, const std::string& name, Work work);
  bool reap(bool block);

  pid_t pid_ = -1;  // -1: none, or it has been waited for
  int code_ = 0, in_ = -1;
};

/// Whether a program of this name is found in $PATH.
bool is_on_path(const std::string& program);

}  // namespace cxlab
