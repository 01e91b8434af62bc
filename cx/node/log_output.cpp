#include "cx/node/log_output.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <string>

#include "cx/base/append_file.h"
#include "cx/base/number_text.h"

namespace cxlab::cx {

namespace {

using spdlog::details::log_msg;

/// Seconds of simulated time, which a message carries as its time, right-justified in `width`.
class SimulatedTime final : public spdlog::custom_flag_formatter {
 public:
  explicit SimulatedTime(std::size_t width) : width_(width) {}
  void format(const log_msg& message, const std::tm&, spdlog::memory_buf_t& out) override {
    const std::string text = fixed_text(to_seconds(SimTime(message.time.time_since_epoch())), 3);
    const std::string blanks(width_ - std::min(width_, text.size()), ' ');
    out.append(blanks);
    out.append(text);
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<SimulatedTime>(width_); }

 private:
  std::size_t width_;
};

std::string in_colour(std::string_view text, std::string_view colour) {
  return std::string(colour) + std::string(text) + "\033[0m";
}

/// Our names of the levels; if `coloured`, warnings are yellow and errors red.
class Level final : public spdlog::custom_flag_formatter {
 public:
  explicit Level(bool coloured) : coloured_(coloured) {}
  void format(const log_msg& message, const std::tm&, spdlog::memory_buf_t& out) override {
    const LogLevel level = message.level <= spdlog::level::debug  ? LogLevel::kDebug
                           : message.level == spdlog::level::info ? LogLevel::kInfo
                           : message.level == spdlog::level::warn ? LogLevel::kWarn
                                                                  : LogLevel::kError;
    if (coloured_ && level >= LogLevel::kWarn)
      out.append(in_colour(to_string(level), level == LogLevel::kWarn ? "\033[33m" : "\033[1;31m"));
    else
      out.append(to_string(level));
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<Level>(coloured_); }

 private:
  bool coloured_;
};

/// In a pattern `%*` is the simulated time and `%k` the level.
std::unique_ptr<spdlog::formatter> formatter(std::string pattern, std::size_t time_width, bool coloured) {
  auto made = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc, "\n");
  made->add_flag<SimulatedTime>('*', time_width).add_flag<Level>('k', coloured).set_pattern(std::move(pattern));
  return made;
}

log_msg message_of(const LogLine& line, std::string_view text) {
  constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info, spdlog::level::warn,
                                                   spdlog::level::err};
  return log_msg(spdlog::log_clock::time_point(line.t), {}, line.logger, kLevels[static_cast<std::size_t>(line.level)],
                 text);
}

class Console final : public LogSink {
 public:
  explicit Console(bool coloured) : coloured_(coloured) {
    sink_.set_formatter(formatter("[%*] [%k] [%n] %v", 9, coloured));
  }
  void line(const LogLine& line) override {
    if (!coloured_ || line.colour.empty()) return sink_.log(message_of(line, line.text));
    sink_.log(message_of(line, in_colour(line.text, line.colour)));
  }

 private:
  bool coloured_;
  spdlog::sinks::stderr_sink_st sink_;
};

}  // namespace

class LogFile::Sink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  explicit Sink(AppendFile file) : file_(std::move(file)) { set_formatter(formatter("[%*] [%n] [%k] %v", 0, false)); }
  const Status& status() const { return file_.status(); }

 protected:
  void sink_it_(const log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    (void)file_.append({line.data(), line.size()});
  }
  void flush_() override { (void)file_.flush(); }

 private:
  AppendFile file_;
};

LogFile::LogFile(std::unique_ptr<Sink> sink) : sink_(std::move(sink)) {}
LogFile::~LogFile() = default;

Expected<std::unique_ptr<LogFile>> LogFile::create(const std::filesystem::path& path) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<LogFile>(new LogFile(std::make_unique<Sink>(*std::move(file))));
}

void LogFile::line(const LogLine& line) { sink_->log(message_of(line, line.text)); }

Status LogFile::flush() {
  sink_->flush();
  return status();
}

const Status& LogFile::status() const { return sink_->status(); }

std::unique_ptr<LogSink> console_log(bool coloured) { return std::make_unique<Console>(coloured); }

}  // namespace cxlab::cx
