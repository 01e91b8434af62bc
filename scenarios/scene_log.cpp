#include "scenarios/scene_log.h"

#include <algorithm>
#include <limits>

#include "cx/base/byte_codec.h"
#include "cx/base/file.h"
#include "cx/journal/chunk.h"

namespace cxlab {
namespace {

constexpr std::string_view kMagic = "CXSCENE1";
constexpr SimTime kChunkTime = std::chrono::seconds(20), kMilli = std::chrono::milliseconds(1);
constexpr std::size_t kChunkBytes = 64 * 1024;
constexpr EntityId kLastId = std::numeric_limits<EntityId>::max();

/// What follows in a change, in this order. X, Y and Yaw are what changes most.
enum Field : std::uint8_t {
  kX = 1,
  kY = 2,
  kYaw = 4,
  kRest = 8,  ///< z, and the rotation about x and y
  kState = 16,
  kCarrier = 32,
  kWay = 64,
  kMore = 128,  ///< at first a byte: kGone and nothing else, kNew, or kLook
};
enum More : std::uint8_t { kGone = 0, kNew = 1, kLook = 2 };

std::uint8_t pose_fields(const RoundedPose& before, const RoundedPose& pose) {
  const auto differs = [&](std::size_t i) { return before[i] != pose[i]; };
  return static_cast<std::uint8_t>((differs(0) ? kX : 0) | (differs(1) ? kY : 0) | (differs(5) ? kYaw : 0) |
                                   (differs(2) || differs(3) || differs(4) ? kRest : 0));
}

/// The numbers of a pose that each field stands for.
template <class Call>
void for_numbers(std::uint8_t fields, Call call) {
  if (fields & kX) call(0);
  if (fields & kY) call(1);
  if (fields & kYaw) call(5);
  if (fields & kRest)
    for (std::size_t i = 2; i < 5; ++i) call(i);
}

void put_pose(ByteWriter& out, std::uint8_t fields, const RoundedPose& before, const RoundedPose& pose) {
  for_numbers(fields, [&](std::size_t i) { out.zigzag(std::int64_t{pose[i]} - before[i]); });
}

void read_pose(ByteReader& in, std::uint8_t fields, RoundedPose& pose) {
  for_numbers(fields, [&](std::size_t i) {
    // Sums wrap in unsigned numbers: those of a broken file may be anything.
    const auto sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(std::int64_t{pose[i]}) +
                                               static_cast<std::uint64_t>(in.zigzag()));
    if (sum < std::numeric_limits<std::int32_t>::min() || sum > std::numeric_limits<std::int32_t>::max())
      in.refuse();
    else
      pose[i] = static_cast<std::int32_t>(sum);
  });
}

/// `t` plus a time that is not negative; refused where that is more than any run lasts.
SimTime later(ByteReader& in, SimTime t, std::uint64_t by, std::uint64_t unit) {
  const auto room =
      static_cast<std::uint64_t>(kNever.count()) - static_cast<std::uint64_t>(std::max(t, SimTime{}).count());
  if (t < SimTime{} || by > room / unit) {
    in.refuse();
    return t;
  }
  return t + SimTime{static_cast<std::int64_t>(by * unit)};
}

}  // namespace

// --- Writer

Expected<SceneWriter> SceneWriter::create(const std::filesystem::path& path) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  if (Status s = file->append(kMagic); !s) return s.error();
  SceneWriter writer(std::move(*file));
  if (Status s = writer.flush(); !s) return s.error();
  return writer;
}

void SceneWriter::put_text(const std::string& text) {
  ByteWriter out(chunk_);
  if (text.empty()) {
    out.varint(0);
    return;
  }
  const auto [at, is_new] = texts_.try_emplace(text, texts_.size() + 1);
  out.varint(at->second);
  if (is_new) out.text(text);
}

/// Writes the changes of an entity, or all of it.
void SceneWriter::put(const SceneList::Track& track, bool whole) {
  using Track = SceneList::Track;
  const bool is_new = whole || track.changed & Track::kNew;
  const RoundedPose before = is_new ? RoundedPose{} : track.before;
  std::uint8_t fields = pose_fields(before, track.pose);
  if (is_new ? !track.state.empty() : track.changed & Track::kState) fields |= kState;
  if (is_new ? track.carried_by != 0 : track.changed & Track::kCarrier) fields |= kCarrier;
  if (is_new ? !track.way.empty() : track.changed & Track::kWay) fields |= kWay;
  if (is_new || track.changed & Track::kLook) fields |= kMore;
  if (fields == 0) return;
  ByteWriter out(chunk_);
  out.varint(track.id).fixed(fields);
  if (fields & kMore) {
    out.fixed(is_new ? kNew : kLook);
    if (is_new) {
      put_text(track.kind);
      put_text(track.name);
    }
    put_text(track.look);
  }
  put_pose(out, fields, before, track.pose);
  if (fields & kState) put_text(track.state);
  if (fields & kCarrier) {
    out.varint(track.carried_by);
    put_text(track.place);
  }
  if (!(fields & kWay)) return;
  // The rest of the way: the last point that is not in the future, and those after it.
  const auto ahead = std::ranges::upper_bound(track.way, last_frame_, {}, &Track::Point::t);
  const auto first = ahead == track.way.begin() ? ahead : ahead - 1;
  out.varint(static_cast<std::uint64_t>(track.way.end() - first));
  SimTime t{};
  RoundedPose last{};
  for (auto point = first; point != track.way.end(); ++point) {
    const std::uint8_t moved = pose_fields(last, point->pose);
    out.varint(static_cast<std::uint64_t>(std::max(point->t - t, SimTime{}) / kMilli)).fixed(moved);
    put_pose(out, moved, last, point->pose);
    t = point->t;
    last = point->pose;
  }
}

void SceneWriter::look(SimTime now, SimTime next, std::span<const SceneLister> listers) {
  if (now < SimTime{} || tick_not_before(now, kScenePeriod) >= next || !file_.status()) return;
  list_.update(listers);
  const bool whole = chunk_.empty();
  const std::size_t begin = chunk_.size();
  ByteWriter out(chunk_);
  if (whole) from_ = last_frame_ = now;
  out.varint(static_cast<std::uint64_t>((now - last_frame_).count()));
  const std::size_t changes = chunk_.size();
  const SimTime frame_before = std::exchange(last_frame_, now);
  if (!whole)
    for (const EntityId id : list_.gone()) out.varint(id).fixed(kMore).fixed(kGone);
  for (const SceneList::Track& track : list_.tracks())
    if (whole || track.changed) put(track, whole);
  last_look_ = now;
  if (!whole && chunk_.size() == changes) {
    chunk_.resize(begin);
    last_frame_ = frame_before;
  } else {
    out.varint(0);
  }
  if (now - from_ >= kChunkTime || chunk_.size() >= kChunkBytes) (void)flush();
}

void SceneWriter::end_chunk() {
  if (chunk_.empty()) return;
  std::string payload;
  ByteWriter(payload)
      .varint(static_cast<std::uint64_t>(from_.count()))
      .varint(static_cast<std::uint64_t>((last_look_ - from_).count()))
      .raw(chunk_);
  (void)file_.append(framed_chunk(payload));
  chunk_.clear();
  texts_.clear();
}

Status SceneWriter::flush() {
  end_chunk();
  return file_.flush();
}

Status SceneWriter::close() {
  (void)flush();
  return file_.close();
}

// --- Reader

Expected<SceneReader> SceneReader::open(const std::filesystem::path& path) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return from_bytes(std::move(*bytes), path.string());
}

Error SceneReader::broken(std::size_t at, const std::string& what) const {
  return input_error("broken at byte " + std::to_string(at) + " of " + std::to_string(bytes_->size()) + ": " + what +
                         "; what comes before is whole",
                     path_);
}

Expected<SceneReader> SceneReader::from_bytes(std::string bytes, std::string path) {
  if (!bytes.starts_with(kMagic))
    return input_error("expected a scene, which begins with " + std::string(kMagic), path);
  SceneReader reader;
  reader.path_ = std::move(path);
  reader.bytes_ = std::make_shared<const std::string>(std::move(bytes));
  const std::string_view all = *reader.bytes_;
  for (std::size_t at = kMagic.size(); at < all.size() && reader.status_;) {
    ByteReader in(all.substr(at));
    const auto payload = read_chunk(in);
    if (!payload) {
      reader.status_ = reader.broken(at, payload.error().message);
      break;
    }
    ByteReader times(*payload);
    const SimTime from = later(times, {}, times.varint(), 1), to = later(times, from, times.varint(), 1);
    const SimTime before = reader.end();
    if (!times.ok() || times.left() == 0 || (!reader.empty() && from < before))
      reader.status_ = reader.broken(at, "a chunk that no writer makes");
    else
      reader.chunks_.push_back({from, to, at, payload->substr(times.position())});
    at += in.position();
  }
  return reader;
}

void SceneReader::begin_chunk(std::size_t chunk) {
  place_ = Place{};  // clang 16 cannot emplace a type of this class
  place_->chunk = chunk;
  place_->frame = chunks_[chunk].from;
}

std::optional<SimTime> SceneReader::next_frame() const {
  ByteReader in(chunks_[place_->chunk].frames.substr(place_->at));
  if (in.left() == 0) return std::nullopt;
  return later(in, place_->frame, in.varint(), 1);
}

Status SceneReader::read_frame() {
  Place& place = *place_;
  const Chunk& chunk = chunks_[place.chunk];
  ByteReader in(chunk.frames.substr(place.at));
  place.frame = later(in, place.frame, in.varint(), 1);
  const auto text = [&]() -> std::string_view {
    const std::uint64_t number = in.varint();
    if (!in.ok() || number == 0) return {};
    if (number <= place.texts.size()) return place.texts[number - 1];
    if (number != place.texts.size() + 1) {
      in.refuse();
      return {};
    }
    const std::string_view spelt = in.text();
    if (spelt.size() > SceneList::kLongestText) in.refuse();
    return in.ok() ? place.texts.emplace_back(spelt) : std::string_view();
  };
  const auto id = [&]() -> EntityId {
    const std::uint64_t number = in.varint();
    if (number > kLastId) in.refuse();
    return in.ok() ? static_cast<EntityId>(number) : 0;
  };
  for (EntityId number = id(); number != 0; number = id()) {
    const auto fields = in.fixed<std::uint8_t>();
    auto known = place.tracks.find(number);
    if (fields & kMore) {
      const auto more = in.fixed<More>();
      if (more == kGone) {
        if (known == place.tracks.end() || fields != kMore) in.refuse();
        if (!in.ok()) break;
        place.tracks.erase(known);
        continue;
      }
      if (more == kNew) {
        known = place.tracks.insert_or_assign(number, SceneList::Track{}).first;
        known->second.id = number;
        known->second.kind = text();
        known->second.name = text();
      }
      if (more > kLook || known == place.tracks.end() || place.tracks.size() > SceneList::kMostEntities) in.refuse();
      if (!in.ok()) break;
      known->second.look = text();
    }
    if (known == place.tracks.end()) in.refuse();
    if (!in.ok()) break;
    SceneList::Track& track = known->second;
    read_pose(in, fields, track.pose);
    if (fields & kState) track.state = text();
    if (fields & kCarrier) {
      track.carried_by = id();
      track.place = text();
    }
    if (!(fields & kWay)) continue;
    track.way.clear();
    SceneList::Track::Point point;
    for (std::uint64_t left = in.varint(); left > 0 && in.ok(); --left) {
      point.t = later(in, point.t, in.varint(), static_cast<std::uint64_t>(kMilli.count()));
      const auto moved = in.fixed<std::uint8_t>();
      if (moved > (kX | kY | kYaw | kRest)) in.refuse();
      read_pose(in, moved, point.pose);
      track.way.push_back(point);
    }
  }
  if (in.ok()) {
    place.at += in.position();
    return {};
  }
  const std::size_t start = chunk.start;
  place_.reset();
  return broken(start, "a frame that no writer makes");
}

Status SceneReader::seek(SimTime t) {
  const auto after = std::ranges::upper_bound(chunks_, t, {}, &Chunk::from);
  const auto chunk = static_cast<std::size_t>(after - chunks_.begin()) - 1;
  if (!place_ || place_->chunk != chunk || place_->frame > t) begin_chunk(chunk);
  for (auto next = next_frame(); next && *next <= t; next = next_frame())
    if (Status s = read_frame(); !s) return s;
  return {};
}

Expected<Scene> SceneReader::at(SimTime t) {
  if (chunks_.empty() || t < begin()) return Scene{t, {}};
  if (Status s = seek(t); !s) return s.error();
  Scene scene{t, {}};
  for (const auto& [id, track] : place_->tracks) scene.entities.push_back(track.at(t));
  return scene;
}

Expected<std::optional<SimTime>> SceneReader::next_change(SimTime t) {
  if (chunks_.empty()) return std::optional<SimTime>();
  if (t < begin()) return std::optional(begin());
  if (Status s = seek(t); !s) return s.error();
  if (const auto next = next_frame()) return next;
  // A chunk begins with all there is; whether that differs from before is not asked.
  if (place_->chunk + 1 < chunks_.size()) return std::optional(chunks_[place_->chunk + 1].from);
  return std::optional<SimTime>();
}

}  // namespace cxlab
