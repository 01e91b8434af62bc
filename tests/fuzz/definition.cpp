// Interface definitions: the first byte says which kind, the rest is the file. One that is read makes messages that
// keep their values through bytes.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <span>

#include "cx/bus/definition.h"
#include "cx/bus/message.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_definition {
namespace {

namespace fs = std::filesystem;

/// The package `p` with the one definition `T`, in a folder of this process.
fs::path package_with(const char* kind, const std::string& text) {
  static const fs::path folder = fs::temp_directory_path() / ("cxlab-fuzz-" + std::to_string(getpid()));
  static const bool once = [] {
    std::atexit([] {
      std::error_code ignored;
      fs::remove_all(folder, ignored);
    });
    return true;
  }();
  (void)once;
  for (const char* other : {"msg", "srv", "action"}) fs::remove_all(folder / other);
  fs::create_directories(folder / kind);
  std::ofstream(folder / kind / (std::string("T.") + kind), std::ios::binary) << text;
  return folder;
}

void use(const cxlab::bus::MessageType& type) {
  using namespace cxlab;
  const bus::Message message(type);
  std::string bytes;
  message.serialize(bytes);
  std::size_t position = 0;
  const auto again = bus::Message::deserialize(type, std::as_bytes(std::span(bytes)), position);
  fuzz::promise(again.ok() && position == bytes.size(), "a message of a type that was read comes back from its bytes");
  (void)message->to_string();
}

}  // namespace

FUZZ_TARGET(definition) {
  using namespace cxlab;
  if (size == 0 || size > 4096) return 0;
  const char* kinds[] = {"msg", "srv", "action"};
  const std::size_t kind = data[0] % 3;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  if (!bus::parse_definition(text, "T", kind + 1)) return 0;
  bus::Registry registry;
  if (!registry.add_package("p", package_with(kinds[kind], text))) return 0;
  if (kind == 0) {
    if (const auto type = registry.message("p/msg/T")) use(**type);
  } else if (kind == 1) {
    if (const auto type = registry.service("p/srv/T")) {
      use(*(*type)->request);
      use(*(*type)->response);
    }
  } else if (const auto type = registry.action("p/action/T")) {
    use(*(*type)->goal);
    use(*(*type)->result);
    use(*(*type)->feedback);
  }
  return 0;
}

}  // namespace fuzz_definition
