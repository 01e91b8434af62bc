#pragma once
// Makes lines of the log from the output of rules.

#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "cx/node/log.h"

namespace cxlab::cx {

/// Makes lines from the output of rules. All logical names share one buffer, as in CX: a line has level and colour of
/// the name that delivered its end.
class LogRouter {
 public:
  using Emit = std::function<void(LogLevel level, std::string_view colour, std::string_view logical_name,
                                  std::string_view text)>;
  LogRouter(bool redirect_stdout_to_debug, Emit emit) : redirect_(redirect_stdout_to_debug), emit_(std::move(emit)) {}

  void write(std::string_view logical_name, std::string_view text);
  /// Tells a line that was begun as it is, as if stdout ended it.
  void end_line() {
    if (!buffer_.empty()) write("stdout", "\n");
  }

 private:
  bool redirect_;
  Emit emit_;
  std::string buffer_;
};

}  // namespace cxlab::cx
