// .proto files: what is wrong has a place, what is right has types of which messages can be made.

#include <google/protobuf/message.h>

#include <optional>

#include "cx/protobuf/types.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_proto {

FUZZ_TARGET(proto) {
  using namespace cxlab;
  const std::string text = fuzz::text_of(data, size);
  pb::Types types([&](const std::string& file) -> Expected<std::optional<pb::Types::Source>> {
    if (file != "a.proto") return std::optional<pb::Types::Source>();
    return std::optional(pb::Types::Source{text, file});
  });
  if (const Status added = types.add_file("a.proto"); !added) {
    fuzz::promise(!added.error().file.empty() && !added.error().message.empty(), "an error says where and what");
    return 0;
  }
  for (const std::string& name : types.names())
    fuzz::promise(types.make(name) != nullptr, "there is a message of each type");
  return 0;
}

}  // namespace fuzz_proto
