#pragma once
// Where lines of the log end: files of the run, the console.

#include <filesystem>
#include <memory>

#include "cx/base/expected.h"
#include "cx/node/log.h"

namespace cxlab::cx {

/// A file of lines like "[12.340] [main] [info] text". A write that fails cuts the file back to its last whole line;
/// its error (kResource) stays in `status`, and later lines are dropped.
class LogFile final : public LogSink {
 public:
  static Expected<std::unique_ptr<LogFile>> create(const std::filesystem::path& path);
  ~LogFile() override;
  void line(const LogLine& line) override;
  /// Writes out what is buffered.
  Status flush();
  const Status& status() const;

 private:
  class Sink;
  explicit LogFile(std::unique_ptr<Sink> sink);
  std::unique_ptr<Sink> sink_;
};

/// Prints lines like "[   12.340] [info] [main] text" on stderr, in their colours if `coloured`.
std::unique_ptr<LogSink> console_log(bool coloured);

}  // namespace cxlab::cx
