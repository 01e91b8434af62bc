// MCAP files, and messages as CDR: what is read is the same again after a way through bytes.

#include <filesystem>

#include "cx/bus/cdr.h"
#include "cx/bus/interface.h"
#include "cx/mcap/mcap_reader.h"
#include "cx/mcap/records.h"
#include "tests/fuzz/fuzz.h"

namespace {

cxlab::bus::Registry& types() {
  static cxlab::bus::Registry packages = [] {
    cxlab::bus::Registry made;
    const std::filesystem::path source = CXLAB_SOURCE_DIR;
    cxlab::fuzz::promise(made.add_packages_in(source / "cx/interfaces").ok(), "the packages of cxlab are there");
    cxlab::fuzz::promise(made.add_package("every", source / "tests/fuzz/every").ok(),
                         "the package of this target is there");
    return made;
  }();
  return packages;
}

std::string cdr_of(const cxlab::bus::Message& message) {
  std::string bytes;
  cxlab::bus::CdrWriter(bytes).message(message);
  return bytes;
}

void read_message(const std::string& type_name, std::string_view bytes) {
  using namespace cxlab;
  const auto type = types().message(type_name);
  if (!type) return;
  const auto message = bus::read_cdr(**type, bytes);
  if (!message) return;
  const std::string written = cdr_of(*message);
  const auto again = bus::read_cdr(**type, written);
  fuzz::promise(again.ok() && cdr_of(*again) == written, "a message comes back from its CDR");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cxlab;
  if (size == 0) return 0;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  const char* names[] = {"every/msg/Kind", "rcll_interfaces/msg/MachineInfo", "visualization_msgs/msg/Marker",
                         "example_interfaces/msg/WString"};
  if (data[0] % 2 == 0) read_message(names[data[0] / 2 % 4], text);
  auto file = mcap::Reader::from_bytes(std::string(mcap::kMagic, mcap::kMagicSize) + text, "bag");
  fuzz::promise(file.ok(), "the magic is right");
  for (;;) {
    const auto message = file->next();
    if (!message || !*message) break;
    if ((*message)->channel->schema) read_message((*message)->channel->schema->name, (*message)->bytes);
  }
  const auto end = file->next();
  fuzz::promise(end.ok() && !*end, "there is nothing behind the end, or an error");
  return 0;
}
