#include "lab/export/run_pass.h"

#include <algorithm>
#include <optional>

#include "cx/base/file.h"

namespace cxlab::lab {

namespace {

/// The scenes of the stretch, one after the other.
class SceneTimes {
 public:
  SceneTimes(SceneReader reader, const Stretch& stretch) : reader_(std::move(reader)) {
    if (reader_.empty()) return;
    next_ = tick_not_before(std::max(stretch.from, reader_.begin()), kScenePeriod);
    end_ = std::min(stretch.to, reader_.end());
  }
  /// Reports all scenes before `t`.
  Status before(SimTime t, const std::function<Status(const Scene&)>& see) {
    for (; next_ <= end_ && next_ < t; next_ += kScenePeriod) {
      const auto scene = reader_.at(next_);
      if (!scene) return scene.error();
      if (Status s = see(*scene); !s) return s;
    }
    return {};
  }

 private:
  SceneReader reader_;
  SimTime next_{}, end_ = SimTime::min();
};

}  // namespace

bool has_scenes(const Run& run) { return is_file(run.folder / "scene.bin"); }

Status pass_over_scenes(const Run& run, const Stretch& stretch, const std::function<Status(const Scene&)>& see) {
  auto reader = run.scenes();
  if (!reader) return reader.error();
  return SceneTimes(*std::move(reader), stretch).before(kNever, see);
}

Status pass_over(const Run& run, const Stretch& stretch, std::span<PassListener* const> listeners, const Host& host) {
  std::optional<SceneTimes> scenes;
  if (has_scenes(run) && std::ranges::any_of(listeners, [](const PassListener* one) { return one->wants_scenes(); })) {
    auto reader = run.scenes();
    if (!reader) return reader.error();
    scenes.emplace(*std::move(reader), stretch);
  }
  const auto see = [&](const Scene& scene) {
    for (PassListener* const listener : listeners)
      if (listener->wants_scenes())
        if (Status s = listener->see(scene); !s) return s;
    return Status();
  };
  RecordFilter filter{.to = stretch.to};
  for (int kind = 0; kind <= static_cast<int>(RecordKind::kError); ++kind)
    if (std::ranges::any_of(listeners, [&](const PassListener* one) {
          return one->wants(RecordKind{static_cast<std::uint8_t>(kind)});
        }))
      filter.kinds.push_back(RecordKind{static_cast<std::uint8_t>(kind)});
  auto journal = run.journal();
  if (!journal) return journal.error();
  const double end = to_seconds(std::min(stretch.to, run.sim_time));
  while (!filter.kinds.empty() && !host.stopped()) {
    const auto record = journal->next(filter);
    if (!record) return record.error();
    if (!*record) break;
    if (scenes)
      if (Status s = scenes->before((*record)->t, see); !s) return s;
    for (PassListener* const listener : listeners)
      if (listener->wants((*record)->kind))
        if (Status s = listener->hear(**record); !s) return s;
    host.show(to_seconds((*record)->t), end);
  }
  return scenes && !host.stopped() ? scenes->before(kNever, see) : Status();
}

}  // namespace cxlab::lab
