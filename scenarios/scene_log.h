#pragma once
// scene.bin: what there was to see in a run, ten times in each second of simulated time; changes only.
//
//   auto scenes = SceneReader::open(run / "scene.bin");
//   if (auto scene = scenes->at(from_seconds(312.4)); scene) for (const Entity& entity : scene->entities) ...
//
// The file: 8 bytes of magic, then chunks of (length, checksum, payload), each of which stands alone: it begins with
// all entities. docs/reference/run-folder.md has the bytes.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/append_file.h"
#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "scenarios/scene.h"

namespace cxlab {

/// A frame shows the world after the last tick that is not after a multiple of this.
inline constexpr SimTime kScenePeriod = std::chrono::milliseconds(100);

class SceneWriter {
 public:
  static Expected<SceneWriter> create(const std::filesystem::path& path);

  /// After the tick at `now`, when it is known that the next one is at `next`: writes a frame if one is due in between.
  void look(SimTime now, SimTime next, std::span<const SceneLister> listers);
  /// Whether writing went well so far (kResource if not).
  const Status& status() const { return file_.status(); }
  /// Writes what was seen so far to the file.
  Status flush();
  Status close();

 private:
  explicit SceneWriter(AppendFile file) : file_(std::move(file)) {}
  void put_text(const std::string& text);
  void put(const SceneList::Track& track, bool whole);
  void end_chunk();

  AppendFile file_;
  SceneList list_;
  std::string chunk_;                                        // frames of the current chunk
  std::map<std::string, std::uint64_t, std::less<>> texts_;  // that it has spelt
  SimTime from_{}, last_frame_{}, last_look_{};              // of that chunk
};

class SceneReader {
 public:
  /// kInput if the file cannot be read or is no scene.
  static Expected<SceneReader> open(const std::filesystem::path& path);
  static Expected<SceneReader> from_bytes(std::string bytes, std::string path);

  /// The first and the last time that a frame shows; both 0 where there is none.
  SimTime begin() const { return chunks_.empty() ? SimTime{} : chunks_.front().from; }
  SimTime end() const { return chunks_.empty() ? SimTime{} : chunks_.back().to; }
  bool empty() const { return chunks_.empty(); }
  /// Where and how the file is broken (cut off, changed), or success. The part before can be read.
  const Status& status() const { return status_; }

  /// The last frame that is not after `t`; what is on its way is where it is at `t`. Before the first frame there are
  /// no entities. Times may come in any order; going on from the last one is quickest.
  Expected<Scene> at(SimTime t);
  /// The time of the first frame after `t` in which something has changed; nothing if there is none.
  Expected<std::optional<SimTime>> next_change(SimTime t);

 private:
  struct Chunk {
    SimTime from{}, to{};
    std::size_t start = 0;    // in the file
    std::string_view frames;  // what comes after the times
  };
  /// Where a chunk has been read to.
  struct Place {
    std::size_t chunk = 0, at = 0;
    SimTime frame{};  // the last that was read
    std::map<EntityId, SceneList::Track> tracks;
    std::vector<std::string_view> texts;
  };
  SceneReader() = default;
  Status seek(SimTime t);
  void begin_chunk(std::size_t chunk);
  /// The time of the next frame of the chunk; nothing at its end.
  std::optional<SimTime> next_frame() const;
  Status read_frame();
  Error broken(std::size_t chunk, const std::string& what) const;

  std::string path_;
  std::shared_ptr<const std::string> bytes_;
  std::vector<Chunk> chunks_;
  std::optional<Place> place_;
  Status status_;
};

}  // namespace cxlab
