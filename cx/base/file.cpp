#include "cx/base/file.h"

#include <cstdint>
#include <fstream>
#include <system_error>
#include <vector>

#include "cx/base/charge.h"

namespace cxlab {

Expected<std::string> read_file(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMostOfADevice = 16 << 20, kMostOfAFile = std::uintmax_t{1} << 31;
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return input_error("is a folder, expected a file", path.string());
  const bool file = std::filesystem::is_regular_file(path, error);
  std::ifstream in(path, std::ios::binary);
  if (!in) return input_error("cannot be read", path.string());
  const std::uintmax_t most = file ? kMostOfAFile : kMostOfADevice;
  std::string text;
  std::vector<char> piece(1 << 16);
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())) || in.gcount() > 0) {
    text.append(piece.data(), static_cast<std::size_t>(in.gcount()));
    if (text.size() > most)
      return input_error("found more than " + std::to_string(most >> 20) + " MB, expected a file", path.string());
  }
  if (in.bad()) return input_error("cannot be read", path.string());
  return text;
}

Status write_file(const std::filesystem::path& path, std::string_view text) {
  if (Charge::is_on()) Charge::written(text.size());
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  return file ? Status() : resource_error("cannot be written", path.string());
}

}  // namespace cxlab
