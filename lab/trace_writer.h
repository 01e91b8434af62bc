#pragma once
// Traces as Perfetto (ui.perfetto.dev) and chrome://tracing read them: processes have threads, and threads have spans
// and marks. Times are in microseconds.

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "cx/base/json.h"

namespace cxlab::lab {

class TraceWriter {
 public:
  /// Appends to `out`, one event a line; who calls may take away what it has written so far.
  explicit TraceWriter(std::string& out);

  struct Thread {
    int process = 0, thread = 0;
  };
  /// The thread of that name in the process of that name; the first use names both.
  Thread thread(const std::string& process, const std::string& thread);
  void span(Thread thread, const std::string& name, const std::string& category, double begin, double duration,
            Json args = Json::object());
  void mark(Thread thread, const std::string& name, const std::string& category, double t, Json args = Json::object());
  /// A figure of the process from `t` on.
  void figure(Thread thread, const std::string& name, double t, Json value);
  /// Ends the text; `more` has further keys of the file.
  void end(const Json& more);

  std::uint64_t events() const { return events_; }

 private:
  struct Process {
    int number = 0;
    std::map<std::string, int> threads;
  };
  void put(const Json& event);

  std::string& out_;
  std::map<std::string, Process> processes_;
  std::uint64_t events_ = 0;
};

}  // namespace cxlab::lab
