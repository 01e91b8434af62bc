#include "app/log_printer.h"

#include <unistd.h>

namespace cxlab::app {

LogPrinter::LogPrinter(Progress& progress, bool quiet)
    : progress_(progress), quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

void LogPrinter::line(const cx::LogLine& line) {
  if (quiet_ || line.level == cx::LogLevel::kDebug) return;
  progress_.clear();
  const bool coloured = terminal_ && !line.colour.empty();
  std::string out;
  if (coloured) out += line.colour;
  out += line.text;
  if (coloured) out += "\033[0m";
  std::fprintf(stderr, "[%9.3f] [%s] [%.*s] %s\n", to_seconds(line.t), std::string(cx::to_string(line.level)).c_str(),
               static_cast<int>(line.logger.size()), line.logger.data(), out.c_str());
}

}  // namespace cxlab::app
