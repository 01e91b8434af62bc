// scene.bin. The first byte says whether the rest is a file, or the payload of a chunk that gets its checksum here; the
// second, at which times it is asked.

#include <xxhash.h>

#include "cx/base/byte_codec.h"
#include "scenarios/scene_log.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_scene {

FUZZ_TARGET(scene) {
  using namespace cxlab;
  if (size < 2) return 0;
  std::string bytes = fuzz::text_of(data + 2, size - 2);
  if (data[0] % 2 == 0) {
    std::string framed("CXSCENE1");
    ByteWriter(framed)
        .fixed(static_cast<std::uint32_t>(bytes.size()))
        .fixed(static_cast<std::uint64_t>(XXH3_64bits(bytes.data(), bytes.size())))
        .raw(bytes);
    bytes = framed;
  }
  auto reader = SceneReader::from_bytes(std::move(bytes), "scene.bin");
  if (!reader) return 0;
  const auto look = [&](SimTime t) {
    const auto scene = reader->at(t);
    if (!scene) {
      fuzz::promise(scene.error().file == "scene.bin", "an error names the file");
      return false;
    }
    fuzz::promise(scene->entities.size() <= SceneList::kMostEntities, "no more entities than any writer lists");
    for (const Entity& entity : scene->entities) {
      fuzz::promise(entity.pose.position.allFinite() && entity.pose.rotation.allFinite(), "poses are finite");
      (void)scene->in_world(entity);
      (void)solids_of(entity.look);
    }
    return true;
  };
  const SimTime step = (reader->end() - reader->begin()) / 8 + SimTime{data[1]};
  for (SimTime t = reader->end(); t > reader->begin() && step > SimTime{}; t -= step) look(t);  // backwards
  int changes = 0;
  for (auto t = reader->next_change(SimTime{-1}); t.ok() && *t && changes < 50; t = reader->next_change(**t), ++changes)
    if (!look(**t)) break;
  fuzz::promise(!reader->empty() || changes == 0, "nothing changes in an empty file");
  return 0;
}

}  // namespace fuzz_scene
