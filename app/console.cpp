#include "app/console.h"

#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>

namespace cxlab::app {

namespace {

std::atomic<int> g_signal = 0;
std::atomic<bool> g_stop = false;
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

/// The first signal asks for an end in order; another one is obeyed at once.
void remember_signal(int number) {
  if (g_signal != 0) _exit(128 + number);
  g_signal = number;
  g_stop = true;
}

}  // namespace

int signal_that_came() { return g_signal; }

static bool colours_wanted() {
  static const bool wanted = [] {
    const char *no = std::getenv("NO_COLOR"), *terminal = std::getenv("TERM");
    return isatty(STDERR_FILENO) && !(no && *no) && !(terminal && std::string_view(terminal) == "dumb");
  }();
  return wanted;
}

std::string coloured(std::string_view text, std::string_view colour) {
  return colours_wanted() ? "\033[" + std::string(colour) + 'm' + std::string(text) + "\033[0m" : std::string(text);
}

Console::Console(bool quiet)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      last_(start_),
      log_(cx::console_log(colours_wanted())) {}

Console::~Console() { clear(); }

lab::Host Console::host() {
  std::signal(SIGINT, remember_signal);
  std::signal(SIGTERM, remember_signal);
  return {.log = this, .progress = this, .stop = &g_stop};
}

void Console::progress(double done, double total) {
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
    std::fprintf(stderr, "\r\033[K[%s] %s of %s  %.0f x real time  %.0f s left", bar.c_str(), clock_text(done).c_str(),
                 clock_text(total).c_str(), done / wall, left);
    std::fflush(stderr);
    drawn_ = true;
  } else {
    std::fprintf(stderr, "%s of %s, %.0f x real time, %.0f s left\n", clock_text(done).c_str(),
                 clock_text(total).c_str(), done / wall, left);
  }
}

void Console::note(std::string_view text) {
  if (quiet_) return;
  clear();
  std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

void Console::line(const cx::LogLine& line) {
  if (quiet_ || line.level == cx::LogLevel::kDebug) return;
  clear();
  if (line.level == cx::LogLevel::kError) errors_.emplace(line.text);
  log_->line(line);
}

void Console::clear() {
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

}  // namespace cxlab::app
