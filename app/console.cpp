#include "app/console.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace cxlab::app {

Progress::Progress(bool quiet)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0), start_(Clock::now()), last_(start_) {}

Progress::~Progress() { clear(); }

void Progress::show(double done, double total, std::string_view note) {
  if (quiet_) return;
  const auto now = Clock::now();
  if (now - last_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000))) return;
  last_ = now;
  const double wall = std::chrono::duration<double>(now - start_).count();
  const double share = total > 0 ? done / total : 0;
  const double left = share > 0 ? wall / share - wall : 0;
  if (terminal_) {
    constexpr int kWidth = 30;
    std::string bar(static_cast<std::size_t>(std::lround(share * kWidth)), '#');
    bar.resize(kWidth, '.');
    std::fprintf(stderr, "\r\033[K[%s] %s of %s  %.0f x real time  %.0f s left  %.*s", bar.c_str(),
                 clock_text(done).c_str(), clock_text(total).c_str(), done / wall, left, static_cast<int>(note.size()),
                 note.data());
    std::fflush(stderr);
    drawn_ = true;
  } else {
    std::fprintf(stderr, "%s of %s, %.0f x real time, %.0f s left  %.*s\n", clock_text(done).c_str(),
                 clock_text(total).c_str(), done / wall, left, static_cast<int>(note.size()), note.data());
  }
}

void Progress::clear() {
  if (!drawn_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  drawn_ = false;
}

std::string clock_text(double seconds) {
  const long whole = std::lround(std::floor(seconds));
  char text[32];
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace cxlab::app
