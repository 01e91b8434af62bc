#include "app/console.h"

#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <new>
#include <utility>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "cx/base/number_text.h"
#include "cx/base/sanitized.h"
#include "cx/engine/engine.h"
#include "lab/table_text.h"

namespace cxlab::app {

namespace {

std::atomic<int> g_signal = 0;
std::atomic<bool> g_stop = false, g_stop_now = false, g_completing = false;
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);
Limits g_most;

constexpr suseconds_t kToEndOfTick = 400'000, kToEndOfRules = 500'000;  // us
constexpr rlim_t kBesideRules = 1'000'000'000;                          // bytes

void ring_in(suseconds_t microseconds) {
  itimerval timer{};
  timer.it_value.tv_usec = microseconds;
  setitimer(ITIMER_REAL, &timer, nullptr);
}

/// Whether this is the first time, or soon after: `timeout` sends its signal to the process and to its group.
bool is_first_signal() {
  static timespec first{};
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (g_signal == 0) first = now;
  return (now.tv_sec - first.tv_sec) * 1'000'000'000 + now.tv_nsec - first.tv_nsec < 100'000'000;
}

/// The first signal asks for an end in order; another one is obeyed at once.
void on_signal(int number) {
  if (!is_first_signal()) {
    constexpr char kMessage[] = "\ninterrupted: by a second signal, wherever it was\n";
    if (write(STDERR_FILENO, kMessage, sizeof kMessage - 1) < 0) _exit(static_cast<int>(ErrorKind::kResource));
    _exit(128 + number);
  }
  if (g_signal != 0) return;
  g_signal = number;
  g_stop = true;
  ring_in(kToEndOfTick);
}

/// A command that has nothing to end in order, or does not come to its end.
void end_at_once(int number) {
  constexpr char kInt[] = "\ninterrupted: by SIGINT, in the middle of its work\n";
  constexpr char kTerm[] = "\ninterrupted: by SIGTERM, in the middle of its work\n";
  const ssize_t written =
      number == SIGINT ? write(STDERR_FILENO, kInt, sizeof kInt - 1) : write(STDERR_FILENO, kTerm, sizeof kTerm - 1);
  _exit(written < 0 ? static_cast<int>(ErrorKind::kResource) : 128 + number);
}

/// What the program is doing, for a signal handler: nothing here allocates or locks.
struct Activity {
  static constexpr std::int64_t kFirst = 3, kMost = 30;  // s
  std::array<std::array<char, 160>, 2> texts{};
  std::atomic<int> text = -1;                      ///< the one that holds
  std::atomic<std::int64_t> done = -1, total = 0;  ///< s of simulated time
  std::atomic<std::int64_t> said = 0;              ///< when something was printed last, s
  std::atomic<std::int64_t> wait = kFirst;
  bool never = false;
  std::atomic<bool> drawn = false;  ///< a line of progress that is drawn in place of the last one
};
Activity g_activity;
Shown g_shown;

std::int64_t seconds_now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec;
}

void has_said() { g_activity.said = seconds_now(); }

void ring_after(std::int64_t seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_REAL, &timer, nullptr);
}

/// One line, put together for a signal handler.
class SignalLine {
 public:
  SignalLine& operator<<(const char* text) {
    while (*text != 0 && size_ < sizeof text_ - 1) text_[size_++] = *text++;
    return *this;
  }
  SignalLine& operator<<(std::int64_t number) {
    char digits[24];
    std::size_t n = sizeof digits;
    digits[--n] = 0;
    do digits[--n] = static_cast<char>('0' + number % 10);
    while ((number /= 10) > 0);
    return *this << digits + n;
  }
  void print() {
    text_[size_++] = '\n';
    if (write(STDERR_FILENO, text_, size_) < 0) return;
  }

 private:
  char text_[512];
  std::size_t size_ = 0;
};

void report_activity() {
  Activity& now = g_activity;
  if (now.text < 0) return;
  const std::int64_t silent = seconds_now() - now.said;
  if (silent < now.wait) return ring_after(now.wait - silent);
  SignalLine line;
  if (now.drawn.exchange(false)) line << "\r\033[K";
  line << "working: " << now.texts[static_cast<std::size_t>(now.text.load())].data();
  if (now.done >= 0) line << ", at " << now.done << " s of " << now.total << " s";
  if (const RuleEngine* engine = RuleEngine::at_work())
    line << "; rules of environment '" << engine->name().c_str() << "' are at work";
  line.print();
  now.wait = std::min(2 * now.wait, Activity::kMost);
  ring_after(now.wait);
}

void on_alarm(int) {
  if (g_signal == 0) return report_activity();
  if (g_completing) return ring_in(kToEndOfRules);
  if (!g_stop_now.exchange(true)) return ring_in(kToEndOfRules);
  end_at_once(g_signal);
}

void handle(int number, void (*handler)(int)) {
  struct sigaction action{};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

/// That this process uses now, bytes.
rlim_t address_space() {
  std::ifstream in("/proc/self/statm");
  rlim_t pages = 0;
  in >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

void set_address_space(rlim_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0) return;
  limit.rlim_cur = std::min(bytes, limit.rlim_max);
  setrlimit(RLIMIT_AS, &limit);
}

/// Called where no memory is left. The first time the rules at work end, with memory enough for an end in order.
void on_no_memory() {
  static bool before = false;
  set_address_space(RLIM_INFINITY);
  RuleEngine* engine = RuleEngine::at_work();
  const Error error = resource_error("no memory is left: " + std::to_string(g_most.memory / 1'000'000) +
                                     " MB for rules and 1000 MB for all else are full; --memory allows more");
  if (engine) engine->exceed_limits(error);
  if (engine && !std::exchange(before, true)) return set_address_space(address_space() + kBesideRules);
  const LimitsInUse* limits = engine ? engine->options().limits : nullptr;
  (void)fail(limits && limits->exceeded ? *limits->exceeded : error);
  _exit(static_cast<int>(ErrorKind::kResource));
}

}  // namespace

void doing(std::string_view what) {
  Activity& now = g_activity;
  if (what.empty()) now.text = -1;
  if (what.empty() || now.never) return;
  const int next = now.text == 0 ? 1 : 0;
  auto& text = now.texts[static_cast<std::size_t>(next)];
  const std::string shown = printable(what);
  text[shown.copy(text.data(), text.size() - 1)] = 0;
  if (now.text < 0) {
    has_said();
    handle(SIGALRM, on_alarm);
    ring_after(Activity::kFirst);
  }
  now.text = next;
}

void stop_reporting() {
  doing({});
  g_activity.never = true;
}

void show_debug_lines(Shown shown) { g_shown = shown; }

void end_at_signals() {
  for (const int number : {SIGINT, SIGTERM}) {
    struct sigaction now{};
    if (sigaction(number, nullptr, &now) == 0 && now.sa_handler == SIG_DFL) handle(number, end_at_once);
  }
}

/// Bytes: a whole number and its unit, if any.
static std::optional<std::int64_t> size_of(const std::string& text) {
  static constexpr std::pair<std::string_view, std::int64_t> kUnits[] = {
      {"", 1},          {"b", 1},         {"kb", 1'000},    {"mb", 1'000'000},         {"gb", 1'000'000'000},
      {"kib", 1 << 10}, {"mib", 1 << 20}, {"gib", 1 << 30}, {"tb", 1'000'000'000'000}, {"tib", std::int64_t{1} << 40}};
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  const auto number = read_number<std::int64_t>(text.substr(0, digits));
  std::string unit = text.substr(std::min(text.find_first_not_of(' ', digits), text.size()));
  std::transform(unit.begin(), unit.end(), unit.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const auto& [name, bytes] : kUnits) {
    if (!number || unit != name || *number > INT64_MAX / bytes) continue;
    const std::int64_t size = *number * bytes;
    if (size == 0 || size >= 1'000'000) return size;
  }
  return std::nullopt;
}

static void add_size(CLI::App& command, const std::string& name, std::int64_t& bytes, const std::string& help,
                     const std::string& most) {
  command.add_option(name, bytes, help)
      ->transform(CLI::Validator(
          [](std::string& text) {
            const auto size = size_of(text);
            if (!size) return found_text(text, "a size of at least 1MB as 500MB or 4GB, or 0");
            text = std::to_string(*size);
            return std::string();
          },
          ""))
      ->type_name("SIZE")
      ->default_str(most);
}

void add_limit_options(CLI::App& command) {
  add_size(command, "--memory", g_most.memory, "Memory that rules may hold, such as 500MB or 4GB; 0 = no limit", "2GB");
  add_size(command, "--disk", g_most.disk, "Bytes that rules may write to the disk, such as 500MB or 4GB; 0 = no limit",
           "5GB");
  whole_number(
      command.add_option(
          "--steps", g_most.steps,
          "Steps (docs/reference/limits.md) that the rules of an environment may take in a tick; 0 = no limit"),
      0)
      ->type_name("N")
      ->default_str(std::to_string(g_most.steps));
}

int signal_that_came() { return g_signal; }

int interrupted(const std::string& what_there_is) {
  if (g_signal == 0) return 0;
  const std::string name = g_signal == SIGINT ? "SIGINT" : "SIGTERM";
  std::fprintf(stderr, "%s %s\n", coloured("interrupted:", kRed).c_str(),
               printable("by " + name + "; " + what_there_is).c_str());
  return 128 + g_signal;
}

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

/// How many bytes a character of UTF-8 has that begins so.
static std::size_t bytes_of(unsigned char first) {
  return first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 1;
}

/// Marks that are not seen and change how others are: directions, joiners, widths of zero, tags.
static bool is_format(char32_t c) {
  static constexpr std::pair<char32_t, char32_t> kFormat[] = {{0xad, 0xad},     {0x61c, 0x61c},   {0x180e, 0x180e},
                                                              {0x200b, 0x200f}, {0x2028, 0x202e}, {0x2060, 0x206f},
                                                              {0xfeff, 0xfeff}, {0xfff9, 0xfffb}, {0xe0000, 0xe007f}};
  return std::ranges::any_of(kFormat, [c](const auto& range) { return range.first <= c && c <= range.second; });
}

static std::string escaped_byte(unsigned char byte) {
  char escaped[5];
  std::snprintf(escaped, sizeof escaped, "\\x%02x", byte);
  return escaped;
}

/// As JSON writes it, so that JSON stays what it was.
static std::string escaped_character(char32_t c) {
  char escaped[24];
  if (c < 0x10000)
    std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned>(c));
  else
    std::snprintf(escaped, sizeof escaped, "\\u%04x\\u%04x", static_cast<unsigned>(0xd800 + ((c - 0x10000) >> 10)),
                  static_cast<unsigned>(0xdc00 + (c & 0x3ff)));
  return escaped;
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t i = 0, size = 1; i < text.size(); i += size) {
    const auto first = static_cast<unsigned char>(text[i]);
    size = 1;
    if (text.substr(i, 2) == "\r\n") continue;
    if (first < 0x80) {
      if (first == 0x7f)  // JSON has it as it is
        out += escaped_character(first);
      else
        out += first >= 0x20 || first == '\n' || first == '\t' ? std::string(1, text[i]) : escaped_byte(first);
      continue;
    }
    const std::size_t length = bytes_of(first);
    char32_t c = first & (0xffu >> (length + 1));
    while (size < length && i + size < text.size() && (static_cast<unsigned char>(text[i + size]) & 0xc0) == 0x80)
      c = (c << 6) | (static_cast<unsigned char>(text[i + size++]) & 0x3f);
    const std::string_view character = text.substr(i, size);
    const bool control = length == 2 && c < 0xa0;  // U+0080 to U+009F
    if (length > 1 && size == length && (control || is_format(c)))
      out += escaped_character(c);
    else
      out += character;
  }
  return out;
}

/// Bytes at the end that begin a character and do not end it.
static std::size_t cut_off(std::string_view text) {
  for (std::size_t back = 1; back <= std::min<std::size_t>(3, text.size()); ++back) {
    const auto byte = static_cast<unsigned char>(text[text.size() - back]);
    if ((byte & 0xc0) == 0x80) continue;
    return bytes_of(byte) > back ? back : 0;
  }
  return 0;
}

bool make_answers_printable() {
  cookie_io_functions_t functions{};
  functions.write = [](void*, const char* bytes, std::size_t size) -> ssize_t {
    static std::string cut;  // the beginning of a character
    const std::string given = std::exchange(cut, "") + std::string(bytes, size);
    cut = given.substr(given.size() - cut_off(given));
    const std::string text = printable(std::string_view(given).substr(0, given.size() - cut.size()));
    has_said();
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t written = write(STDOUT_FILENO, text.data() + done, text.size() - done);
      if (written < 0 && errno != EINTR) return 0;
      if (written > 0) done += static_cast<std::size_t>(written);
    }
    return static_cast<ssize_t>(size);
  };
  FILE* file = fopencookie(nullptr, "w", functions);
  if (file == nullptr) return false;
  std::setvbuf(file, nullptr, isatty(STDOUT_FILENO) ? _IOLBF : _IOFBF, BUFSIZ);
  stdout = file;
  return true;
}

Console::Console(bool quiet)
    : quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(Clock::now()),
      last_(start_),
      log_(cx::console_log(colours_wanted())) {}

Console::~Console() { clear(); }

lab::Host Console::host() {
  handle(SIGINT, on_signal);
  handle(SIGTERM, on_signal);
  handle(SIGALRM, on_alarm);
  if (g_most.memory > 0 && !kSanitized) {
    std::set_new_handler(on_no_memory);
    set_address_space(address_space() + static_cast<rlim_t>(g_most.memory) + kBesideRules);
  }
  return {.log = this,
          .progress = this,
          .stop = &g_stop,
          .stop_now = &g_stop_now,
          .completing = &g_completing,
          .most = g_most,
          .confine = true};
}

void Console::progress(double done, double total) {
  if (g_activity.done < 0 && g_activity.text >= 0) doing("playing");
  g_activity.done = static_cast<std::int64_t>(done);
  g_activity.total = static_cast<std::int64_t>(total);
  if (quiet_ || !is_due()) return;
  const double wall = std::chrono::duration<double>(last_ - start_).count();
  const double share = total > 0 ? done / total : 0;
  const double left = share > 0 ? wall / share - wall : 0;
  if (terminal_) {
    char text[128];
    std::snprintf(text, sizeof text, "%s of %s  %.0f x real time  %.0f s left", clock_text(done).c_str(),
                  clock_text(total).c_str(), done / wall, left);
    draw(share, text);
  } else {
    std::fprintf(stderr, "%s of %s, %.0f x real time, %.0f s left\n", clock_text(done).c_str(),
                 clock_text(total).c_str(), done / wall, left);
  }
}

bool Console::is_due() {
  const auto now = Clock::now();
  if (now - last_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000))) return false;
  last_ = now;
  has_said();
  return true;
}

void Console::draw(double share, const std::string& text) {
  constexpr int kWidth = 30;
  std::string bar(static_cast<std::size_t>(std::lround(share * kWidth)), '#');
  bar.resize(kWidth, '.');
  std::fprintf(stderr, "\r\033[K[%s] %s", bar.c_str(), text.c_str());
  std::fflush(stderr);
  drawn_ = g_activity.drawn = true;
}

/// "4:10 left", "2 h 05 min left"; empty while nobody knows.
static std::string left_text(const lab::GamesProgress& games) {
  if (!games.seconds_left || games.done == games.total) return {};
  const long seconds = std::lround(*games.seconds_left);
  if (seconds < 3600) return clock_text(static_cast<double>(seconds)) + " left";
  char text[64];
  std::snprintf(text, sizeof text, "%ld h %02ld min left", seconds / 3600, seconds / 60 % 60);
  return text;
}

void Console::sweep_progress(const lab::GamesProgress& games) {
  std::string text = std::to_string(games.done) + " of " + std::to_string(games.total) + " games";
  if (games.incomplete > 0) text += ", " + std::to_string(games.incomplete) + " not completed";
  text += ", " + std::to_string(games.playing) + " at play";
  if (const std::string left = left_text(games); !left.empty()) text += ", " + left;
  if (games.may_end_early) text += "; may end early";
  if (quiet_ && g_activity.text >= 0) doing("playing, " + text);
  share_done(games.total > 0 ? static_cast<double>(games.done) / static_cast<double>(games.total) : 0, text);
}

void Console::share_done(double share, const std::string& text) {
  if (quiet_ || !is_due()) return;
  if (terminal_)
    draw(share, text);
  else
    std::fprintf(stderr, "%s\n", text.c_str());
}

void Console::game_ended(std::string_view line, const lab::GamesProgress& games, bool remarkable) {
  if (quiet_) return;
  if (!remarkable && !all_games_ && (terminal_ || !is_due())) return;
  const std::string left = left_text(games);
  note(std::string(line) + (left.empty() ? "" : " (" + left + ')'));
}

void Console::note(std::string_view text) {
  if (!quiet_) warn(text);
}

void Console::warn(std::string_view text) {
  has_said();
  clear();
  std::fprintf(stderr, "%s\n", printable(text).c_str());
}

void Console::line(const cx::LogLine& line) {
  const bool is_error = line.level == cx::LogLevel::kError;
  const bool hidden = line.level == cx::LogLevel::kDebug && !(line.of_rules ? g_shown.others : g_shown.lives);
  if (quiet_ ? !(is_error && line.of_rules) : hidden) return;
  has_said();
  clear();
  if (is_error) errors_.emplace(line.text);
  const std::string text = printable(line.text), logger = printable(line.logger);
  cx::LogLine shown = line;
  shown.text = text;
  shown.logger = logger;
  log_->line(shown);
}

void Console::clear() {
  if (!drawn_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  drawn_ = g_activity.drawn = false;
}

std::size_t line_width() {
  winsize size{};
  if (isatty(STDOUT_FILENO) && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return lab::kTableWidth;
}

std::string clock_text(double seconds) {
  const long whole = std::lround(std::floor(seconds));
  char text[32];
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

}  // namespace cxlab::app
