#include "sim/mujoco/render.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>

#include <Eigen/Geometry>

namespace cxlab::sim {
namespace {

constexpr int kMostGeoms = 2000;
constexpr double kSeenHeight = 1.15;  ///< m: of all that stands on the field
constexpr int kLargePicture = 1000;   ///< px high, from which texts are twice as large
constexpr double kOutside = 0.85;     ///< m below the field that are seen: where robots stand that were taken away
constexpr int kBorder = 4;            ///< px around the field
constexpr int kLowest = 35, kHighest = 65;  ///< degrees: how steeply "field" looks down
constexpr float kGround[4]{0.16f, 0.18f, 0.22f, 1};
constexpr double kGroundSize = 60;  ///< m
constexpr double kDistance = 2.4;   ///< of a camera that shows the whole field: half of the field's diagonals
constexpr std::string_view kFollow = "follow-", kFieldCamera = "field", kTopCamera = "top";
constexpr double kFollowDistance = 3.4, kFollowElevation = -48;  ///< m, degrees

}  // namespace

// --- renderer --------------------------------------------------------------------------------------------------

Expected<std::unique_ptr<Renderer>> Renderer::create(const FloorPlan& plan, const PhysicsGate& world, int width,
                                                     int height) {
  const auto& global = world.model().vis.global;
  if (width < 16 || height < 16 || width > global.offwidth || height > global.offheight)
    return input_error("picture of " + std::to_string(width) + " x " + std::to_string(height) +
                       ": expected 16 x 16 to " + std::to_string(global.offwidth) + " x " +
                       std::to_string(global.offheight));
  auto context = GlContext::create(width, height);
  if (!context) return context.error();
  std::unique_ptr<Renderer> made(new Renderer(plan, std::move(*context), width, height));
  made->set_up(world);
  return made;
}

Renderer::Renderer(const FloorPlan& plan, std::unique_ptr<GlContext> context, int width, int height)
    : context_(std::move(context)),
      plan_(plan),
      upside_down_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      picture_{width, height, std::vector<std::uint8_t>(upside_down_.size())} {}

void Renderer::set_up(const PhysicsGate& world) {
  const mjModel* m = &world.model();
  copy_.reset(mj_makeData(m));
  mjv_defaultScene(&scene_);
  mjv_defaultOption(&option_);
  mjv_defaultCamera(&camera_);
  mjr_defaultContext(&gl_);
  mjv_makeScene(m, &scene_, kMostGeoms);
  scene_.flags[mjRND_SHADOW] = scene_.flags[mjRND_REFLECTION] = 0;
  // Textures are the model's; the buffer is as large as the picture.
  mjModel view = *m;
  view.vis.global.offwidth = picture_.width;
  view.vis.global.offheight = picture_.height;
  view.vis.quality.shadowsize = 0;
  // Corners cost most where no graphics card draws: as few as one does not see.
  view.vis.quality.numquads = 1;
  view.vis.quality.numslices = 20;
  view.vis.quality.numstacks = 8;
  mjr_makeContext(&view, &gl_, picture_.height >= kLargePicture ? mjFONTSCALE_150 : mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &gl_);

  for (const RobotStart& robot : plan_.robots)
    robot_geoms_.push_back(mj_name2id(m, mjOBJ_GEOM, (robot.name + "/colour-deck").c_str()));
  light_of_.assign(static_cast<std::size_t>(m->ngeom), -1);
  const auto& stations = world.factory().stations;
  for (std::size_t s = 0; s < stations.size(); ++s)
    for (std::size_t k = 0; k < 3; ++k)
      light_of_[static_cast<std::size_t>(stations[s].lights[k])] = static_cast<int>(3 * s + k);
}

Renderer::~Renderer() {
  context_->make_current();
  mjr_freeContext(&gl_);
  mjv_freeScene(&scene_);
}

std::vector<std::string> Renderer::cameras() const {
  std::vector<std::string> names{std::string(kFieldCamera), std::string(kTopCamera)};
  for (const RobotStart& robot : plan_.robots) names.push_back(std::string(kFollow) + robot.name);
  for (const RobotStart& robot : plan_.robots) names.push_back(robot.name);
  for (const Station& station : plan_.stations) names.push_back(station.name);
  return names;
}

bool Renderer::shows_field(std::string_view camera) { return camera == kFieldCamera || camera == kTopCamera; }

Status Renderer::choose(const mjModel& model, std::string_view camera) {
  const std::string name(camera);
  for (std::size_t i = 0; i < plan_.robots.size() && camera.starts_with(kFollow); ++i) {
    if (camera.substr(kFollow.size()) != plan_.robots[i].name) continue;
    const double* at = copy_->geom_xpos + 3 * robot_geoms_[i];
    kind_ = Kind::kFollowing;
    camera_.type = mjCAMERA_FREE;
    std::copy_n(at, 3, camera_.lookat);
    camera_.distance = kFollowDistance;
    camera_.azimuth = 90;  // looking in +y, however the robot turns
    camera_.elevation = kFollowElevation;
    return {};
  }
  if (shows_field(camera)) {
    kind_ = Kind::kWhole;
    camera_.type = mjCAMERA_FREE;  // `fit` aims it
    return {};
  }
  kind_ = Kind::kMounted;
  camera_.type = mjCAMERA_FIXED;
  camera_.fixedcamid = mj_name2id(&model, mjOBJ_CAMERA, (name + "/view").c_str());
  if (camera_.fixedcamid >= 0) return {};
  const std::vector<std::string> known = cameras();
  return input_error("no camera '" + name + "', expected one of: " + some_of_and_nearest(name, known));
}

Expected<const Picture*> Renderer::draw(const PhysicsGate& world, std::string_view name, const Legend& legend) {
  const mjModel* m = &world.model();
  if (!context_->make_current()) return resource_error("OpenGL context was lost").with_code("no_opengl");

  mj_copyData(copy_.get(), m, &world.data());
  mj_kinematics(m, copy_.get());
  mj_comPos(m, copy_.get());
  mj_camlight(m, copy_.get());
  if (Status s = choose(*m, name); !s) return s.error();
  mjv_updateScene(m, copy_.get(), &option_, nullptr, &camera_, mjCAT_ALL, &scene_);
  scene_.camera[0] = scene_.camera[1] = mjv_averageCamera(&scene_.camera[0], &scene_.camera[1]);  // no stereo
  shine(world);
  lay_ground();

  const Box picture{0, 0, picture_.width, picture_.height};
  overlay_ = {};
  if (kind_ != Kind::kMounted) {
    Box free = picture;
    free.height -= place_legend(legend, world.factory(), gl_, picture, overlay_);
    if (kind_ == Kind::kWhole) fit(free, name == kTopCamera);
    const OverlayInput input{world, plan_, *copy_, robot_geoms_};
    if (kind_ == Kind::kWhole)
      place_pieces(input, projection(), gl_, free, overlay_);  // too small to be seen from afar
    place_names(input, projection(), gl_, free, overlay_);
  }

  const mjrRect whole{0, 0, picture_.width, picture_.height};
  mjr_render(whole, &scene_, &gl_);
  paint(overlay_, gl_);
  mjr_readPixels(upside_down_.data(), nullptr, whole, &gl_);
  const std::size_t row = 3 * static_cast<std::size_t>(picture_.width);
  const auto rows = static_cast<std::size_t>(picture_.height);
  for (std::size_t y = 0; y < rows; ++y)
    std::memcpy(picture_.rgb.data() + y * row, upside_down_.data() + (rows - 1 - y) * row, row);
  return &picture_;
}

// Lights are the machines' state, not the model's: they are put on in the picture only.
void Renderer::shine(const PhysicsGate& world) {
  for (int g = 0; g < scene_.ngeom; ++g) {
    mjvGeom& geom = scene_.geoms[g];
    if (geom.objtype != mjOBJ_GEOM || geom.objid < 0) continue;
    const int light = light_of_[static_cast<std::size_t>(geom.objid)];
    if (light < 0) continue;
    const bool on =
        shining(world.lights(static_cast<StationId>(light / 3)), world.time())[static_cast<std::size_t>(light % 3)];
    geom.emission = on ? 1.0f : 0.0f;
    if (!on)
      for (int i = 0; i < 3; ++i) geom.rgba[i] *= 0.3f;
  }
}

// What the field lies on; without it half of a picture is sky.
void Renderer::lay_ground() {
  if (scene_.ngeom >= scene_.maxgeom) return;
  mjvGeom& ground = scene_.geoms[scene_.ngeom++];
  const double size[3]{kGroundSize, kGroundSize, 0.01};
  const double at[3]{(plan_.min_x + plan_.max_x) / 2, (plan_.min_y + plan_.max_y) / 2, -0.03};
  mjv_initGeom(&ground, mjGEOM_BOX, size, at, nullptr, kGround);
  ground.category = mjCAT_DECOR;
  ground.objtype = mjOBJ_UNKNOWN;
  ground.objid = -1;
  ground.specular = 0;
}

namespace {

/// Where a camera looks, and what it sees of some points: tangents of angles, from the middle of its view.
struct Aim {
  Vec3 from, forward, up;
  double left = 0, right = 0, low = 0, high = 0;

  Aim(const Vec3& at, double distance, double azimuth, double elevation, std::span<const Vec3> points) {
    const double a = azimuth * M_PI / 180, e = elevation * M_PI / 180;
    const Vec3 ahead(std::cos(a), std::sin(a), 0);
    forward = std::cos(e) * ahead - std::sin(e) * Vec3::UnitZ();
    up = std::sin(e) * ahead + std::cos(e) * Vec3::UnitZ();
    from = at - distance * forward;
    const Vec3 rightward = forward.cross(up);
    for (const Vec3& point : points) {
      const Vec3 offset = point - from;
      const double along = offset.dot(forward), x = offset.dot(rightward) / along, y = offset.dot(up) / along;
      left = std::min(left, x);
      right = std::max(right, x);
      low = std::min(low, y);
      high = std::max(high, y);
    }
  }
  double pixels(const Box& free) const {
    return std::min((free.width - 2 * kBorder) / (right - left), (free.height - 2 * kBorder) / (high - low));
  }
  double area(const Box& free) const { return (right - left) * (high - low) * pixels(free) * pixels(free); }
};

}  // namespace

// Turns the view so that the whole field, with all that stands on it, fills as much of the free part of the picture as
// possible. The higher that part is, the more steeply the camera looks down. If the part is upright, the camera looks
// along the field.
void Renderer::fit(const Box& free, bool from_above) {
  const Pose2 middle{(plan_.min_x + plan_.max_x) / 2, (plan_.min_y + plan_.max_y) / 2, 0};
  const double half_length = (plan_.max_x - plan_.min_x) / 2, half_width = (plan_.max_y - plan_.min_y) / 2;
  const double wall = 2 * kWall.half_thickness;
  const auto field = corners(middle, half_length + wall, half_width + wall, kSeenHeight);
  std::vector<Vec3> seen(field.begin(), field.end());
  for (const double side : {-1.0, 1.0}) seen.emplace_back(middle.x + side * half_length, plan_.min_y - kOutside, 0);
  const Vec3 centre(middle.x, middle.y, 0);
  const double distance = kDistance * std::hypot(half_length, half_width);

  std::optional<Aim> best;
  for (const double azimuth : {90.0, 180.0}) {
    if (azimuth == 180 && free.width >= free.height) continue;
    for (int elevation = from_above ? 90 : kLowest; elevation <= (from_above ? 90 : kHighest); ++elevation) {
      const Aim aim(centre, distance, azimuth, elevation, seen);
      if (!best || aim.area(free) > best->area(free)) best = aim;
    }
  }

  mjvGLCamera& camera = scene_.camera[0];
  for (int i = 0; i < 3; ++i) {
    camera.pos[i] = static_cast<float>(best->from[i]);
    camera.forward[i] = static_cast<float>(best->forward[i]);
    camera.up[i] = static_cast<float>(best->up[i]);
  }
  const double pixels = best->pixels(free);
  // Three quarters of the space that is left are above, where legends are, so that the field stays as they grow.
  const double height = (best->high - best->low) * pixels;
  const double below =
      std::clamp((picture_.height - height) / 4, static_cast<double>(kBorder), free.height - kBorder - height);
  const double bottom = best->low - below / pixels;
  const double near = static_cast<double>(camera.frustum_near);
  camera.frustum_center = static_cast<float>((best->left + best->right) / 2 * near);
  camera.frustum_bottom = static_cast<float>(bottom * near);
  camera.frustum_top = static_cast<float>((bottom + picture_.height / pixels) * near);
  camera.frustum_width = static_cast<float>(picture_.width / pixels / 2 * near);
  scene_.camera[1] = camera;
}

}  // namespace cxlab::sim
