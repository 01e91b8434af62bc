#pragma once
// A file that grows by whole pieces (lines, chunks) and ends with a whole one, also when the disk is full.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

/// Buffers whole pieces and writes them through one descriptor. When a write fails, the file is cut back to its last
/// whole piece. The error (kResource) stays: every later call returns it and writes nothing.
/// The program must ignore SIGXFSZ; else a limit of the file size ends the process.
class AppendFile {
 public:
  AppendFile() = default;
  ~AppendFile();  ///< closes; call `close` before to see errors
  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&& other) noexcept;

  /// Creates the file, or empties it.
  static Expected<AppendFile> create(const std::filesystem::path& path);

  bool is_open() const { return descriptor_ >= 0; }
  /// Adds one piece. It is written by `flush`, or when 64 KiB are buffered.
  Status append(std::string_view piece);
  Status flush();
  Status close();

  /// The first error, or success.
  const Status& status() const { return status_; }
  /// Bytes of whole pieces taken so far, those in the buffer included.
  std::uint64_t size() const { return written_ + buffer_.size(); }

 private:
  Status fail(int error_number, std::size_t buffered_bytes_written);

  int descriptor_ = -1;
  std::string path_;
  std::string buffer_;
  std::vector<std::size_t> piece_ends_;  // in the buffer
  std::uint64_t written_ = 0;
  Status status_;
};

}  // namespace cxlab
