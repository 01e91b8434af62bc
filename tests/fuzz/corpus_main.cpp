// fuzz_corpus TARGET FOLDER...: plays the files of the folders through a fuzz target. Ends with 2 when there are none,
// or no such target.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/fuzz.h"

extern "C" [[gnu::weak]] void __lsan_disable();  // of LeakSanitizer, if this program has it

int main(int argc, char** argv) {
  const auto& targets = cxlab::fuzz::targets();
  const auto target =
      std::find_if(targets.begin(), targets.end(), [&](const auto& one) { return argc > 1 && one.name == argv[1]; });
  if (target == targets.end()) return 2;
  if (target->options.find("detect_leaks=0") != std::string_view::npos && __lsan_disable) __lsan_disable();
  std::vector<std::filesystem::path> files;
  for (int i = 2; i < argc; ++i)
    for (const auto& entry : std::filesystem::directory_iterator(argv[i]))
      if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::fprintf(stderr, "%s\n", file.c_str());
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    (void)target->play(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  return files.empty() ? 2 : 0;
}
