#include "cx/base/append_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <utility>

#include "cx/base/charge.h"

namespace cxlab {
namespace {

constexpr std::size_t kBufferBytes = 64 * 1024;

}  // namespace

AppendFile::~AppendFile() { (void)close(); }

AppendFile::AppendFile(AppendFile&& other) noexcept { *this = std::move(other); }

AppendFile& AppendFile::operator=(AppendFile&& other) noexcept {
  if (this != &other) (void)close();
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  std::swap(buffer_, other.buffer_);
  std::swap(piece_ends_, other.piece_ends_);
  std::swap(written_, other.written_);
  std::swap(status_, other.status_);
  return *this;
}

Expected<AppendFile> AppendFile::create(const std::filesystem::path& path) {
  AppendFile file;
  file.path_ = path.string();
  file.descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file.descriptor_ < 0) {
    return resource_error(std::string("cannot be written: ") + std::strerror(errno), path.string());
  }
  return file;
}

Status AppendFile::append(std::string_view piece) {
  if (!status_ || !is_open()) return status_;
  if (Charge::is_on()) Charge::written(piece.size());
  buffer_.append(piece);
  piece_ends_.push_back(buffer_.size());
  return buffer_.size() >= kBufferBytes ? flush() : Status{};
}

Status AppendFile::flush() {
  if (!status_ || !is_open()) return status_;
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t n = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return fail(n < 0 ? errno : ENOSPC, done);
    done += static_cast<std::size_t>(n);
  }
  written_ += buffer_.size();
  buffer_.clear();
  piece_ends_.clear();
  return {};
}

Status AppendFile::close() {
  if (!is_open()) return status_;
  (void)flush();
  if (::close(std::exchange(descriptor_, -1)) != 0 && status_) return fail(errno, 0);
  return status_;
}

Status AppendFile::fail(int error_number, std::size_t buffered_bytes_written) {
  const auto first_lost = std::upper_bound(piece_ends_.begin(), piece_ends_.end(), buffered_bytes_written);
  if (first_lost != piece_ends_.begin()) written_ += *std::prev(first_lost);
  status_ = resource_error(std::string("writing stopped: ") + std::strerror(error_number), path_);
  if (is_open() && ::ftruncate(descriptor_, static_cast<off_t>(written_)) != 0) {
    status_ = resource_error(status_.error().message + "; the last line may be incomplete", path_);
  }
  buffer_.clear();
  piece_ends_.clear();
  return status_;
}

}  // namespace cxlab
