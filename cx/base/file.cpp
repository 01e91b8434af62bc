#include "cx/base/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <system_error>
#include <vector>

#include "cx/base/charge.h"

namespace cxlab {

static Error cannot_be_read(const std::filesystem::path& path) {
  const bool is_short = errno == EMFILE || errno == ENFILE || errno == ENOMEM;
  Error error = input_error("cannot be read: " + std::generic_category().message(errno), path.string());
  if (is_short) error.kind = ErrorKind::kResource;
  return error;
}

Expected<std::string> read_file(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMostOfADevice = 16 << 20, kMostOfAFile = std::uintmax_t{1} << 31;
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return input_error("is a folder, expected a file", path.string());
  const std::uintmax_t most = std::filesystem::is_regular_file(path, error) ? kMostOfAFile : kMostOfADevice;
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0 && errno == ENOENT) return input_error("there is no such file", path.string());
  if (file < 0) return cannot_be_read(path);
  struct Closing {
    int file;
    ~Closing() { close(file); }
  } closing{file};
  std::string text;
  std::vector<char> piece(1 << 16);
  while (true) {
    const ssize_t got = read(file, piece.data(), piece.size());
    if (got < 0 && errno == EAGAIN) {  // a pipe whose writer has nothing to say yet
      fcntl(file, F_SETFL, 0);
      continue;
    }
    if (got < 0) return cannot_be_read(path);
    if (got == 0) break;
    text.append(piece.data(), static_cast<std::size_t>(got));
    if (text.size() > most)
      return input_error(found_expected("more than " + std::to_string(most >> 20) + " MB", "a file"), path.string());
  }
  if (text.empty() && std::filesystem::is_fifo(path, error))
    return input_error("is a pipe into which nobody writes, expected a file", path.string());
  return text;
}

Status write_file(const std::filesystem::path& path, std::string_view text) {
  if (Charge::is_on()) Charge::written(text.size());
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
  if (file < 0)
    return resource_error(errno == ENXIO ? "is a pipe from which nobody reads" : "cannot be written", path.string());
  fcntl(file, F_SETFL, O_WRONLY);
  ssize_t written = 1;
  for (; !text.empty() && written > 0; text.remove_prefix(static_cast<std::size_t>(written))) do
      written = write(file, text.data(), text.size());
    while (written < 0 && errno == EINTR);
  return close(file) == 0 && written > 0 ? Status() : resource_error("cannot be written", path.string());
}

Status write_output(const std::filesystem::path& path, std::string_view text) {
  if (Status s = make_folder_of(path); !s) return s;
  return write_file(path, text);
}

Status make_folder_of(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.parent_path();
  std::error_code error;
  if (!folder.empty() && !is_folder(folder)) std::filesystem::create_directories(folder, error);
  return error ? resource_error("the folder cannot be made: " + error.message(), folder.string()) : Status();
}

bool path_exists(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

bool is_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

bool is_file(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

}  // namespace cxlab
