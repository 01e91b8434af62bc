#include "scenarios/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "cx/base/number_text.h"

namespace cxlab {
namespace {

constexpr double kUnits = 1000;  // of a metre, of a radian

std::int32_t rounded(double value) {
  constexpr double kMost = 2e9;
  return static_cast<std::int32_t>(std::lround(std::isfinite(value) ? std::clamp(value * kUnits, -kMost, kMost) : 0));
}

sim::Pose3 pose_of(const RoundedPose& rounded) {
  const auto vector = [&](std::size_t at) {
    return sim::Vec3(rounded[at] / kUnits, rounded[at + 1] / kUnits, rounded[at + 2] / kUnits);
  };
  return {vector(0), vector(3)};
}

std::string_view cut(std::string_view text) {
  if (text.size() <= SceneList::kLongestText) return text;
  std::size_t end = SceneList::kLongestText;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // amid a character
  return text.substr(0, end);
}

/// Takes the text over; whether it is another one.
bool take(std::string& kept, std::string_view text) {
  text = cut(text);
  if (kept == text) return false;
  kept = text;
  return true;
}

constexpr std::array<std::string_view, 2> kShapes{"box", "cylinder"};

/// The next word of a text, which is then taken off it.
std::string_view next_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  const std::string_view word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(word.size());
  return word;
}

}  // namespace

// --- Scene

bool operator==(const Entity& a, const Entity& b) {
  return a.id == b.id && a.kind == b.kind && a.name == b.name && a.state == b.state && a.look == b.look &&
         a.pose.position == b.pose.position && a.pose.rotation == b.pose.rotation && a.carried_by == b.carried_by &&
         a.place == b.place;
}

const Entity* Scene::find(EntityId id) const {
  const auto found = std::ranges::lower_bound(entities, id, {}, &Entity::id);
  return found != entities.end() && found->id == id ? &*found : nullptr;
}

const Entity* Scene::find(std::string_view name) const {
  const auto found = std::ranges::find(entities, name, &Entity::name);
  return found != entities.end() ? &*found : nullptr;
}

sim::Pose3 Scene::in_world(const Entity& entity) const {
  sim::Pose3 pose = entity.pose;
  const Entity* carrier = entity.carried_by ? find(*entity.carried_by) : nullptr;
  for (std::size_t deep = 0; carrier && deep < entities.size(); ++deep) {  // a broken file may go round
    pose = sim::compose(carrier->pose, pose);
    carrier = carrier->carried_by ? find(*carrier->carried_by) : nullptr;
  }
  return pose;
}

// --- Looks

std::string look_of(std::span<const Solid> solids) {
  std::string out;
  for (const Solid& solid : solids) {
    if (!out.empty()) out += "; ";
    out += kShapes[static_cast<std::size_t>(solid.shape)];
    for (const auto& numbers : {solid.size, solid.at})
      for (const double number : numbers) (out += ' ') += shortest_text(number);
    char colour[9];
    std::snprintf(colour, sizeof colour, " #%06x", static_cast<unsigned>(solid.colour & 0xFFFFFF));
    out += colour;
    if (solid.blinks) out += " blinks";
  }
  return out;
}

Expected<std::vector<Solid>> solids_of(std::string_view look) {
  std::vector<Solid> out;
  while (!look.empty()) {
    const std::string_view part = look.substr(0, look.find(';'));
    look.remove_prefix(std::min(part.size() + 1, look.size()));
    const auto wrong = [&](std::string_view word, const char* expected) {
      return input_error("look '" + std::string(part) + "': " + found_text(std::string(word), expected));
    };
    std::string_view rest = part;
    Solid solid;
    const std::string_view shape = next_word(rest);
    const auto known = std::ranges::find(kShapes, shape);
    if (known == kShapes.end()) return wrong(shape, "box or cylinder");
    solid.shape = static_cast<Solid::Shape>(known - kShapes.begin());
    for (auto* numbers : {&solid.size, &solid.at})
      for (double& number : *numbers) {
        const std::string_view word = next_word(rest);
        const auto value = read_number<double>(word);
        if (!value || !std::isfinite(*value)) return wrong(word, "a number in metres");
        number = *value;
      }
    const std::string_view colour = next_word(rest);
    if (colour.size() != 7 || colour[0] != '#' ||
        colour.find_first_not_of("0123456789abcdef", 1) != std::string_view::npos)
      return wrong(colour, "a colour such as #ccced4");
    solid.colour = static_cast<std::uint32_t>(std::stoul(std::string(colour.substr(1)), nullptr, 16));
    const std::string_view blinks = next_word(rest);
    if (!blinks.empty() && blinks != "blinks") return wrong(blinks, "nothing or 'blinks'");
    solid.blinks = !blinks.empty();
    if (const std::string_view more = next_word(rest); !more.empty()) return wrong(more, "';' or the end");
    out.push_back(solid);
  }
  return out;
}

// --- Lists

RoundedPose rounded(const sim::Pose3& pose) {
  const sim::Vec3& p = pose.position;
  constexpr double kHalfTurn = 3.141;  // 3.142 would be a turn to the other side
  const sim::Vec3 r = pose.rotation.cwiseMax(-kHalfTurn).cwiseMin(kHalfTurn);
  return {rounded(p.x()), rounded(p.y()), rounded(p.z()), rounded(r.x()), rounded(r.y()), rounded(r.z())};
}

sim::Pose3 SceneList::Track::pose_at(SimTime t) const {
  if (way.empty()) return pose_of(pose);
  const auto next = std::ranges::upper_bound(way, t, {}, &Point::t);
  if (next == way.begin()) return pose_of(way.front().pose);
  if (next == way.end()) return pose_of(way.back().pose);
  const Point& last = *(next - 1);
  const double part = to_seconds(t - last.t) / to_seconds(next->t - last.t);
  const sim::Pose3 from = pose_of(last.pose), to = pose_of(next->pose);
  const sim::Pose3 moved = sim::relative_to(from, to);
  const sim::Pose3 turned = sim::compose(from, {sim::Vec3::Zero(), part * moved.rotation});
  return {from.position + part * (to.position - from.position), turned.rotation};
}

Entity SceneList::Track::at(SimTime t) const {
  return {id, kind, name, state, look, pose_at(t), carried_by == 0 ? std::nullopt : std::optional(carried_by), place};
}

std::size_t SceneList::position_of(EntityId id) const {
  if (next_ < tracks_.size() && tracks_[next_].id == id) return next_;
  const auto found = std::ranges::find(tracks_, id, &Track::id);
  return static_cast<std::size_t>(found - tracks_.begin());
}

bool SceneList::knows_way(EntityId number, std::uint64_t way_number) const {
  const std::size_t at = position_of(layer_ + number);
  return at < tracks_.size() && tracks_[at].way_number == way_number;
}

bool SceneList::keep(EntityId number, std::uint32_t revision, std::size_t count) {
  const std::size_t at = position_of(layer_ + number);
  if (at == tracks_.size() || revision == 0 || tracks_[at].revision != revision) return false;
  next_ = std::min(at + count, tracks_.size());
  for (std::size_t i = at; i < next_; ++i) tracks_[i].seen = round_;
  return true;
}

void SceneList::put(const EntityView& entity) {
  if (entity.number == 0 || entity.number >= kMostEntityNumbers) return;
  const EntityId id = layer_ + entity.number;
  std::size_t at = position_of(id);
  const bool is_new = at == tracks_.size();
  if (is_new) {
    if (tracks_.size() >= kMostEntities) return;
    at = std::min(next_, tracks_.size());
    Track& track = *tracks_.emplace(tracks_.begin() + static_cast<std::ptrdiff_t>(at));
    track.id = id;
    track.kind = cut(entity.kind);
    track.name = cut(entity.name);
    track.changed = Track::kNew;
  }
  next_ = at + 1;
  Track& track = tracks_[at];
  track.seen = round_;
  track.revision = entity.revision;
  if (take(track.state, entity.state)) track.changed |= Track::kState;
  if (take(track.look, entity.look)) track.changed |= Track::kLook;
  const EntityId carrier = entity.carried_by == 0 ? 0 : layer_ + entity.carried_by;
  if (take(track.place, entity.place) || carrier != track.carried_by) track.changed |= Track::kCarrier;
  track.carried_by = carrier;
  if (entity.way_number != track.way_number) {
    track.changed |= Track::kWay;
    track.way_number = entity.way_number;
    track.way.clear();
    for (const sim::WayPoint& point : entity.way) {
      const SimTime t = std::chrono::round<std::chrono::milliseconds>(point.t);
      track.way.push_back({track.way.empty() ? t : std::max(t, track.way.back().t), rounded(point.pose)});
    }
  }
  if (entity.way_number != 0 || (entity.fixed && !is_new)) return;
  if (const RoundedPose pose = rounded(entity.pose); pose != track.pose) {
    track.changed |= Track::kPose;
    track.pose = pose;
  }
}

void SceneList::update(std::span<const SceneLister> listers) {
  ++round_;
  next_ = 0;
  layer_ = 0;
  gone_.clear();
  for (Track& track : tracks_) {
    track.changed = 0;
    track.before = track.pose;
  }
  for (const SceneLister& list : listers) {
    list(*this);
    layer_ += kMostEntityNumbers;
  }
  std::erase_if(tracks_, [this](const Track& track) {
    if (track.seen == round_) return false;
    gone_.push_back(track.id);
    return true;
  });
}

Scene SceneList::at(SimTime t) const {
  Scene scene{t, {}};
  for (const Track& track : tracks_) scene.entities.push_back(track.at(t));
  std::ranges::sort(scene.entities, {}, &Entity::id);
  return scene;
}

}  // namespace cxlab
