#include "sim/mujoco/factory_model.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string_view>

#include "sim/mujoco/geometry_check.h"

namespace cxlab::sim {
namespace {

struct SpecDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};
using SpecPtr = std::unique_ptr<mjSpec, SpecDeleter>;

/// MuJoCo's own messages have "line 12" or "Line number=12"; that becomes the error's line.
Error mjcf_error(std::string message, const std::filesystem::path& file) {
  int line = 0;
  for (const std::string_view before : {"line ", "Line number="})
    if (const auto at = message.rfind(before); at != std::string::npos)
      line = std::atoi(message.c_str() + at + before.size());
  for (char& c : message)
    if (c == '\n') c = ' ';
  return input_error(std::move(message), file.string(), line);
}

/// Composes the model; holds what is needed on the way.
class Builder {
 public:
  Builder(const FloorPlan& plan, const ModelOptions& options) : plan_(plan), options_(options) {}

  Expected<FactoryModel> build() {
    if (Status s = check_options(); !s) return s.error();
    auto root = parse("factory");
    if (!root) return root.error();
    root_ = std::move(*root);
    mjs_setDeepCopy(root_.get(), 1);
    root_->option.timestep = options_.step;
    if (Status s = add_floor(); !s) return s.error();
    add_walls();
    for (const Station& station : plan_.stations)
      if (Status s = add_station(station); !s) return s.error();
    for (std::size_t i = 0; i < plan_.robots.size(); ++i)
      if (Status s = add_robot(plan_.robots[i]); !s) return s.error();
    for (int i = 0; i < options_.pieces; ++i)
      if (Status s = add_piece(i); !s) return s.error();
    return compile();
  }

 private:
  Status check_options() const {
    if (!(options_.step > 0) || options_.step > 0.02)
      return input_error("physics step " + std::to_string(options_.step) + " s: expected more than 0 and at most 0.02");
    if (options_.pieces < 1) return input_error("a world needs at least one piece in its pool");
    return {};
  }

  std::filesystem::path part_file(const std::string& part) const { return options_.models / (part + ".xml"); }

  Expected<SpecPtr> parse(const std::string& part) {
    const auto file = part_file(part);
    std::error_code code;
    if (!std::filesystem::is_regular_file(file, code)) return input_error("no such model part", file.string());
    char error[1000] = "";
    SpecPtr spec(mj_parseXML(file.string().c_str(), nullptr, error, sizeof error));
    if (!spec) return mjcf_error(error, file);
    result_.files.push_back(file);
    return spec;
  }

  Expected<mjSpec*> part_spec(const std::string& part) {
    auto known = parts_.find(part);
    if (known == parts_.end()) {
      auto parsed = parse(part);
      if (!parsed) return parsed.error();
      known = parts_.emplace(part, std::move(*parsed)).first;
    }
    return known->second.get();
  }

  /// Adds a copy of the part's body to the world at that pose, all its names under `prefix`.
  Status attach(const std::string& part, const char* body, const std::string& prefix, const Pose2& pose) {
    auto spec = part_spec(part);
    if (!spec) return spec.error();
    mjsBody* child = mjs_findBody(*spec, body);
    if (!child) return lacks("body", body, part);
    mjsFrame* frame = mjs_addFrame(mjs_findBody(root_.get(), "world"), nullptr);
    frame->pos[0] = pose.x;
    frame->pos[1] = pose.y;
    frame->quat[0] = std::cos(pose.yaw / 2);
    frame->quat[3] = std::sin(pose.yaw / 2);
    if (!mjs_attach(frame->element, child->element, prefix.c_str(), ""))
      return mjcf_error(mjs_getError(root_.get()), part_file(part));
    return {};
  }

  /// Adds the geoms of the part's frame, which is named like the part, to the machine's own body: every static body
  /// more costs time in each step.
  Status equip(const std::string& part, const std::string& prefix) {
    auto spec = part_spec(part);
    if (!spec) return spec.error();
    mjsFrame* child = mjs_findFrame(*spec, part.c_str());
    if (!child) return lacks("frame", part, part);
    mjsBody* machine = mjs_findBody(root_.get(), (prefix + "machine").c_str());
    if (!mjs_attach(machine->element, child->element, prefix.c_str(), ""))
      return mjcf_error(mjs_getError(root_.get()), part_file(part));
    return {};
  }

  Error lacks(const char* kind, const std::string& name, const std::string& part) const {
    return input_error("expected a " + std::string(kind) + " named '" + name + "'", part_file(part).string());
  }

  mjsGeom* find_geom(const std::string& name) {
    return mjs_asGeom(mjs_findElement(root_.get(), mjOBJ_GEOM, name.c_str()));
  }

  /// Gives the geoms that a part left open the material of that name, if factory.xml has it.
  void paint(const std::string& prefix, std::initializer_list<const char*> geoms, const std::string& material) {
    if (!mjs_findElement(root_.get(), mjOBJ_MATERIAL, material.c_str())) return;
    for (const char* name : geoms)
      if (mjsGeom* geom = find_geom(prefix + name)) mjs_setString(geom->material, material.c_str());
  }

  Status add_floor() {
    mjsGeom* floor = find_geom("floor");
    if (!floor) return lacks("geom", "floor", "factory");
    floor->size[0] = (plan_.max_x - plan_.min_x) / 2;
    floor->size[1] = (plan_.max_y - plan_.min_y) / 2;
    floor->pos[0] = (plan_.max_x + plan_.min_x) / 2;
    floor->pos[1] = (plan_.max_y + plan_.min_y) / 2;
    return {};
  }

  void add_walls() {
    // Not in the world's own body, which every robot would then be tested against.
    mjsBody* walls = mjs_addBody(mjs_findBody(root_.get(), "world"), nullptr);
    const mjsDefault* style = mjs_findDefault(root_.get(), "wall");
    int n = 0;
    for (const Segment& wall : plan_.walls) {
      const Vec2 along = wall.b - wall.a, middle = (wall.a + wall.b) / 2;
      mjsGeom* geom = mjs_addGeom(walls, style);
      geom->type = mjGEOM_BOX;
      geom->pos[0] = middle.x();
      geom->pos[1] = middle.y();
      geom->pos[2] = kWall.half_height;
      const double yaw = std::atan2(along.y(), along.x());
      geom->quat[0] = std::cos(yaw / 2);
      geom->quat[3] = std::sin(yaw / 2);
      geom->size[0] = along.norm() / 2 + kWall.half_thickness;
      geom->size[1] = kWall.half_thickness;
      geom->size[2] = kWall.half_height;
      mjs_setName(geom->element, ("wall-" + std::to_string(n++)).c_str());
    }
  }

  Status add_station(const Station& station) {
    const std::string prefix = station.name + "/";
    const Pose2& pose = station.pose_in_world;
    if (Status s = attach("machine", "machine", prefix, pose); !s) return s;
    if (Status s = attach("lights", "lights", prefix, pose); !s) return s;
    if (station.has_belt)
      if (Status s = equip("belt", prefix); !s) return s;
    if (station.kind == "CS")
      if (Status s = equip("shelf", prefix); !s) return s;
    if (station.kind == "RS")
      if (Status s = equip("slide", prefix); !s) return s;
    if (Status s = attach("kind_" + station.kind, "look", prefix + "look/", pose); !s) return s;
    paint(prefix, {"team-plate"}, "team-" + station.name.substr(0, 1));
    paint(prefix, {"kind-input", "kind-output", "kind-deck", "kind-portal"}, "kind-" + station.kind);
    return {};
  }

  Status add_robot(const RobotStart& robot) {
    const std::string prefix = robot.name + "/";
    // The joints' axes are the world's: where a robot starts is a matter of state, not of the model.
    if (Status s = attach("robot", "base", prefix, {}); !s) return s;
    const bool left = robot.pose_in_world.x < 0;
    const std::size_t number = ++robots_on_half_[left ? 1 : 0];
    paint(prefix, {"colour-ring"}, left ? "team-M" : "team-C");
    paint(prefix, {"colour-tower", "colour-deck"}, (left ? "robot-M" : "robot-") + std::to_string(number));
    for (std::size_t mark = 1; mark <= 3; ++mark)
      if (mjsGeom* geom = find_geom(prefix + "mark-" + std::to_string(mark)); geom && mark > number) geom->rgba[3] = 0;
    return {};
  }

  Status add_piece(int index) { return attach("piece", "piece", "piece-" + std::to_string(index) + "/", {}); }

  Expected<FactoryModel> compile() {
    result_.model.reset(mj_compile(root_.get(), nullptr));
    if (!result_.model) return mjcf_error(mjs_getError(root_.get()), part_file("factory"));
    result_.geoms.resize(static_cast<std::size_t>(result_.model->ngeom));
    find_statics();
    find_robots();
    find_pieces();
    result_.base_materials = materials("base-");
    result_.ring_materials = materials("ring-");
    result_.cap_materials = materials("cap-");
    if (missing_) return *missing_;
    if (Status s = check_geometry(*result_.model, plan_, options_.models); !s) return s.error();
    return std::move(result_);
  }

  int need(mjtObj type, const std::string& name, const std::string& part) {
    const int id = mj_name2id(result_.model.get(), type, name.c_str());
    if (id < 0 && !missing_) {
      const auto slash = name.rfind('/');
      missing_ = lacks(mju_type2Str(type), name.substr(slash == std::string::npos ? 0 : slash + 1), part);
    }
    return id;
  }

  void use(int geom, GeomRole role, int index) {
    if (geom >= 0) result_.geoms[static_cast<std::size_t>(geom)] = {role, index};
  }

  void find_statics() {
    const mjModel* m = result_.model.get();
    use(need(mjOBJ_GEOM, "floor", "factory"), GeomRole::kFloor, -1);
    for (std::size_t i = 0; i < plan_.walls.size(); ++i)
      use(mj_name2id(m, mjOBJ_GEOM, ("wall-" + std::to_string(i)).c_str()), GeomRole::kFieldWall, static_cast<int>(i));
    for (std::size_t i = 0; i < plan_.stations.size(); ++i) {
      const Station& station = plan_.stations[i];
      const std::string prefix = station.name + "/";
      const int index = static_cast<int>(i);
      for (int g = 0; g < m->ngeom; ++g) {
        const char* name = mj_id2name(m, mjOBJ_GEOM, g);
        if (name && std::strncmp(name, prefix.c_str(), prefix.size()) == 0) use(g, GeomRole::kMachineBody, index);
      }
      StationIds ids;
      const char* colours[] = {"red", "yellow", "green"};
      for (std::size_t k = 0; k < 3; ++k) ids.lights[k] = need(mjOBJ_GEOM, prefix + colours[k], "lights");
      if (station.has_belt) use(ids.belt = need(mjOBJ_GEOM, prefix + "belt", "belt"), GeomRole::kBelt, index);
      if (station.kind == "CS") use(need(mjOBJ_GEOM, prefix + "shelf", "shelf"), GeomRole::kShelf, index);
      if (station.kind == "RS") use(need(mjOBJ_GEOM, prefix + "slide", "slide"), GeomRole::kSlide, index);
      result_.stations.push_back(ids);
    }
  }

  void find_robots() {
    const mjModel* m = result_.model.get();
    const char* axes[kRobotAxes] = {"x", "y", "yaw", "forward", "left", "up", "finger-left", "finger-right"};
    for (std::size_t i = 0; i < plan_.robots.size(); ++i) {
      const std::string prefix = plan_.robots[i].name + "/";
      const int index = static_cast<int>(i);
      RobotIds ids;
      for (std::size_t axis = 0; axis < kRobotAxes; ++axis) {
        const int joint = need(mjOBJ_JOINT, prefix + axes[axis], "robot");
        ids.actuator[axis] = need(mjOBJ_ACTUATOR, prefix + axes[axis], "robot");
        if (joint < 0) return;
        ids.qpos[axis] = m->jnt_qposadr[joint];
        ids.dof[axis] = m->jnt_dofadr[joint];
      }
      use(need(mjOBJ_GEOM, prefix + "hull", "robot"), GeomRole::kHull, index);
      for (const char* pad : {"pad-left-1", "pad-left-2"})
        use(need(mjOBJ_GEOM, prefix + pad, "robot"), GeomRole::kFingerLeft, index);
      for (const char* pad : {"pad-right-1", "pad-right-2"})
        use(need(mjOBJ_GEOM, prefix + pad, "robot"), GeomRole::kFingerRight, index);
      result_.robots.push_back(ids);
    }
  }

  void find_pieces() {
    const mjModel* m = result_.model.get();
    const char* slots[kPieceSlots] = {"base", "ring-1", "ring-2", "ring-3", "cap"};
    for (int i = 0; i < options_.pieces; ++i) {
      const std::string prefix = "piece-" + std::to_string(i) + "/";
      PieceIds ids;
      ids.body = need(mjOBJ_BODY, prefix + "piece", "piece");
      const int joint = need(mjOBJ_JOINT, prefix + "free", "piece");
      if (joint < 0) return;
      ids.qpos = m->jnt_qposadr[joint];
      ids.dof = m->jnt_dofadr[joint];
      for (std::size_t slot = 0; slot < kPieceSlots; ++slot) {
        ids.geoms[slot] = need(mjOBJ_GEOM, prefix + slots[slot], "piece");
        use(ids.geoms[slot], slot == kSlotBase ? GeomRole::kPieceBase : GeomRole::kPiecePart, i);
      }
      result_.pieces.push_back(ids);
    }
  }

  std::vector<int> materials(const char* stem) const {
    std::vector<int> found{-1};
    for (int colour = 1;; ++colour) {
      const int id = mj_name2id(result_.model.get(), mjOBJ_MATERIAL, (stem + std::to_string(colour)).c_str());
      if (id < 0) return found;
      found.push_back(id);
    }
  }

  const FloorPlan& plan_;
  const ModelOptions& options_;
  SpecPtr root_;
  std::map<std::string, SpecPtr> parts_;
  FactoryModel result_;
  std::optional<Error> missing_;
  std::array<std::size_t, 2> robots_on_half_{};  ///< right and left
};

}  // namespace

Expected<FactoryModel> build_factory(const FloorPlan& plan, const ModelOptions& options) {
  return Builder(plan, options).build();
}

}  // namespace cxlab::sim
