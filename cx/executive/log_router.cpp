#include "cx/executive/log_router.h"

#include <array>

namespace cxlab::cx {

namespace {

struct LogicalName {
  std::string_view name;
  LogLevel level;
  std::string_view colour;
};

constexpr std::array<LogicalName, 15> kNotPlainInfo{{
    {"debug", LogLevel::kDebug, ""},
    {"logdebug", LogLevel::kDebug, ""},
    {"warn", LogLevel::kWarn, ""},
    {"logwarn", LogLevel::kWarn, ""},
    {"stdwrn", LogLevel::kWarn, ""},
    {"error", LogLevel::kError, ""},
    {"logerror", LogLevel::kError, ""},
    {"stderr", LogLevel::kError, ""},
    {"red", LogLevel::kInfo, "\033[31m"},
    {"green", LogLevel::kInfo, "\033[32m"},
    {"yellow", LogLevel::kInfo, "\033[33m"},
    {"blue", LogLevel::kInfo, "\033[34m"},
    {"magenta", LogLevel::kInfo, "\033[35m"},
    {"cyan", LogLevel::kInfo, "\033[36m"},
    {"white", LogLevel::kInfo, "\033[37m"},
}};

LogicalName find(std::string_view name) {
  for (const LogicalName& known : kNotPlainInfo)
    if (known.name == name) return known;
  return {name, LogLevel::kInfo, name == "bold" ? "\033[1m" : ""};
}

}  // namespace

void LogRouter::write(std::string_view logical_name, std::string_view text) {
  while (true) {
    const std::size_t end = text.find('\n');
    buffer_ += text.substr(0, end);
    if (end == std::string_view::npos) return;
    LogicalName name = find(logical_name);
    if (redirect_ && logical_name == "stdout") name.level = LogLevel::kDebug;
    const std::string line = std::move(buffer_);
    buffer_.clear();
    emit_(name.level, name.colour, logical_name, line);
    text.remove_prefix(end + 1);
  }
}

}  // namespace cxlab::cx
