#include "cx/base/file.h"

#include <fstream>
#include <iterator>
#include <system_error>

namespace cxlab {

Expected<std::string> read_file(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return input_error("is a folder, expected a file", path.string());
  std::ifstream file(path, std::ios::binary);
  if (!file) return input_error("cannot be read", path.string());
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) return input_error("cannot be read", path.string());
  return text;
}

Status write_file(const std::filesystem::path& path, std::string_view text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  return file ? Status() : resource_error("cannot be written", path.string());
}

}  // namespace cxlab
