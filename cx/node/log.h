#pragma once
// Lines for people to read during a run, from environments, plugins and the manager, with simulated time.

#include <cstdint>
#include <string_view>

#include "cx/base/time.h"

namespace cxlab::cx {

enum class LogLevel : std::uint8_t { kDebug, kInfo, kWarn, kError };
/// "debug", "info", "warn", "error".
std::string_view to_string(LogLevel level);

/// One line, without its end of line. Views live as long as the call.
struct LogLine {
  SimTime t{};
  LogLevel level = LogLevel::kInfo;
  std::string_view logger;  ///< environment, plugin instance or node
  std::string_view text;
  std::string_view colour;  ///< ANSI sequence for terminals, empty = none; the reset is "\033[0m"
  bool of_rules = false;    ///< of a function that rules call, or printed by them, but not as "stderr", as CLIPS does
};

/// Takes the lines. The program prints them; log files take those of their environment.
class LogSink {
 public:
  virtual ~LogSink() = default;
  virtual void line(const LogLine& line) = 0;
};

}  // namespace cxlab::cx
