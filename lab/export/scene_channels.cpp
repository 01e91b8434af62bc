#include "lab/export/scene_channels.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "cx/base/byte_codec.h"

namespace cxlab::lab {

namespace {

constexpr SimTime kPosesAgain = std::chrono::seconds(1);
constexpr double kTextHeight = 0.12;  // m

// Of visualization_msgs/msg/Marker.
enum MarkerType : int { kCube = 1, kCylinder = 3, kText = 9 };
constexpr int kDeleteAll = 3;

void set_point(const bus::MessageView& point, const sim::Vec3& value) {
  point.set("x", value.x()).set("y", value.y()).set("z", value.z());
}

void set_rotation(const bus::MessageView& quaternion, const sim::Vec3& rotation) {
  const double angle = rotation.norm();
  const sim::Vec3 part = angle > 0 ? sim::Vec3(rotation * (std::sin(angle / 2) / angle)) : sim::Vec3::Zero();
  quaternion.set("x", part.x()).set("y", part.y()).set("z", part.z()).set("w", std::cos(angle / 2));
}

void set_colour(const bus::MessageView& colour, std::uint32_t rgb) {
  const auto part = [&](int shift) { return static_cast<double>(rgb >> shift & 0xffU) / 255; };
  colour.set("r", part(16)).set("g", part(8)).set("b", part(0)).set("a", 1.0);
}

const Entity* carrier_of(const Scene& scene, const Entity& entity) {
  return entity.carried_by ? scene.find(*entity.carried_by) : nullptr;
}

/// What a pose says, for comparisons.
void put_pose(const Entity& entity, ByteWriter& out) {
  out.fixed(entity.id).fixed(entity.carried_by.value_or(0));
  for (int i = 0; i < 3; ++i) out.fixed(entity.pose.position[i]).fixed(entity.pose.rotation[i]);
}

}  // namespace

const std::string& FrameNames::of(const Entity& entity) {
  const auto [known, is_new] = names_.try_emplace(entity.id);
  if (is_new) {
    std::string name = entity.name.empty() ? entity.kind : entity.name;
    if (used_.contains(name)) name += '_' + std::to_string(entity.id);
    while (!used_.insert(name).second) name += '_';
    known->second = name;
  }
  return known->second;
}

Expected<SceneChannels> SceneChannels::create(RosBag& bag, const Run& run, const Stretch& stretch) {
  SceneChannels out(bag);
  std::map<EntityId, std::string> first;
  bool begun = false;
  const Status looked = pass_over_scenes(run, stretch, [&](const Scene& scene) {
    std::set<EntityId> there;
    for (const Entity& entity : scene.entities) {
      std::string pose;
      ByteWriter writer(pose);
      put_pose(entity, writer);
      if (!begun) {
        first.emplace(entity.id, pose);
        out.fixed_.insert(entity.id);
      }
      const auto known = first.find(entity.id);
      if (known != first.end() && known->second == pose) there.insert(entity.id);
    }
    begun = true;
    std::erase_if(out.fixed_, [&](EntityId id) { return !there.contains(id); });
    return Status();
  });
  if (!looked) return looked.error();
  return out;
}

Status SceneChannels::see(const Scene& scene) {
  put_poses(scene);
  first_ = false;
  return put_markers(scene);
}

void SceneChannels::put_poses(const Scene& scene) {
  std::string poses;
  ByteWriter writer(poses);
  for (const Entity& entity : scene.entities)
    if (!fixed_.contains(entity.id)) put_pose(entity, writer);
  const auto put = [&](const std::string& topic, bool fixed) {
    bus::Message message = bag_.make("tf2_msgs/msg/TFMessage");
    for (const Entity& entity : scene.entities) {
      if (fixed_.contains(entity.id) != fixed) continue;
      const bus::MessageView one = message->append("transforms");
      const bus::MessageView header = one.nested("header"), transform = one.nested("transform");
      set_stamp(header.nested("stamp"), scene.t);
      const Entity* const carrier = carrier_of(scene, entity);
      header.set("frame_id", carrier ? frames_.of(*carrier) : "map");
      one.set("child_frame_id", frames_.of(entity));
      set_point(transform.nested("translation"), entity.pose.position);
      set_rotation(transform.nested("rotation"), entity.pose.rotation);
    }
    if (message->size("transforms") > 0) bag_.put(topic, scene.t, message);
  };
  if (first_) put("/tf_static", true);
  // Those who look at a time in the middle find all poses within a second before it.
  if (!first_ && poses == last_poses_ && scene.t - poses_put_ < kPosesAgain) return;
  put("/tf", false);
  poses_put_ = scene.t;
  last_poses_ = std::move(poses);
}

Status SceneChannels::put_markers(const Scene& scene) {
  std::map<std::string, std::vector<const Entity*>> kinds;
  for (const auto& [kind, _] : last_markers_) kinds[kind];  // a kind whose last entity was removed is reported, too
  for (const Entity& entity : scene.entities) kinds[entity.kind].push_back(&entity);
  for (const auto& [kind, entities] : kinds) {
    std::string made_of;
    ByteWriter writer(made_of);
    for (const Entity* entity : entities) writer.fixed(entity->id).text(entity->look).text(entity->state);
    const auto [last, is_new] = last_markers_.try_emplace(kind);
    if (!is_new && last->second == made_of) continue;
    last->second = std::move(made_of);

    bus::Message message = bag_.make("visualization_msgs/msg/MarkerArray");
    message->append("markers").set("action", kDeleteAll).nested("header").set("frame_id", "map");
    for (const Entity* entity : entities) {
      const std::string& frame = frames_.of(*entity);
      int id = 0;
      double top = 0;
      const auto add = [&](MarkerType type) {
        const bus::MessageView marker = message->append("markers");
        set_stamp(marker.nested("header").nested("stamp"), scene.t);
        marker.nested("header").set("frame_id", frame);
        marker.set("ns", frame).set("id", id++).set("type", static_cast<int>(type)).set("frame_locked", true);
        marker.nested("pose").nested("orientation").set("w", 1.0);
        return marker;
      };
      const auto solids = solids_of(entity->look);
      if (!solids) return input_error("the look of " + entity->name + ": " + solids.error().message);
      for (const Solid& solid : *solids) {
        const bus::MessageView marker = add(solid.shape == Solid::Shape::kBox ? kCube : kCylinder);
        const double height = solid.size[2];
        set_point(marker.nested("pose").nested("position"), {solid.at[0], solid.at[1], solid.at[2] + height / 2});
        set_point(marker.nested("scale"), {solid.size[0], solid.size[1], height});
        set_colour(marker.nested("color"), solid.colour);
        top = std::max(top, solid.at[2] + height);
      }
      if (entity->state.empty()) continue;
      const bus::MessageView marker = add(kText);
      set_point(marker.nested("pose").nested("position"), {0, 0, top + kTextHeight});
      marker.nested("scale").set("z", kTextHeight);
      set_colour(marker.nested("color"), 0xffffff);
      marker.set("text", entity->name + '\n' + entity->state);
    }
    bag_.put("/cxlab/scene/" + topic_part(kind), scene.t, message);
  }
  return {};
}

}  // namespace cxlab::lab
