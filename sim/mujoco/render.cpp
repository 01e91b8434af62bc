#include "sim/mujoco/render.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "sim/mujoco/overlay.h"

namespace cxlab::sim {
namespace {

constexpr int kMostGeoms = 2000;
/// What an overview shows: the field, machines on its border and their tags, m on the floor.
constexpr double kSeenX = 7.6;
constexpr double kSeenY[] = {-0.3, 9.6};

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
      upside_down_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      picture_{width, height, std::vector<std::uint8_t>(upside_down_.size())} {
  for (const RobotStart& robot : plan.robots) robots_.push_back(robot.name);
  for (const Station& station : plan.stations) stations_.push_back(station.name);
}

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
  mjr_makeContext(&view, &gl_, mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &gl_);

  const auto geom = [&](const std::string& owner, const char* name) {
    return mj_name2id(m, mjOBJ_GEOM, (owner + "/" + name).c_str());
  };
  for (const std::string& robot : robots_) robot_geoms_.push_back(geom(robot, "colour-deck"));
  for (const std::string& station : stations_) station_geoms_.push_back(geom(station, "kind-portal"));
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
  std::vector<std::string> names{"field", "top"};
  names.insert(names.end(), robots_.begin(), robots_.end());
  names.insert(names.end(), stations_.begin(), stations_.end());
  return names;
}

Expected<const Picture*> Renderer::draw(const PhysicsGate& world, std::string_view name) {
  const mjModel* m = &world.model();
  int camera = mj_name2id(m, mjOBJ_CAMERA, std::string(name).c_str());
  const bool overview = camera >= 0;
  if (!overview) camera = mj_name2id(m, mjOBJ_CAMERA, (std::string(name) + "/view").c_str());
  if (camera < 0) {
    return input_error("no camera '" + std::string(name) + "'" + did_you_mean(std::string(name), cameras()));
  }
  if (!context_->make_current()) return resource_error("OpenGL context was lost").with_code("no_opengl");

  mj_copyData(copy_.get(), m, &world.data());
  mj_kinematics(m, copy_.get());
  mj_comPos(m, copy_.get());
  mj_camlight(m, copy_.get());
  camera_.type = mjCAMERA_FIXED;
  camera_.fixedcamid = camera;
  mjv_updateScene(m, copy_.get(), &option_, nullptr, &camera_, mjCAT_ALL, &scene_);
  shine(world);
  if (overview) fit();

  const mjrRect whole{0, 0, picture_.width, picture_.height};
  mjr_render(whole, &scene_, &gl_);
  if (overview)
    draw_overlay({world, *copy_, scene_, gl_, robot_geoms_, station_geoms_, robots_, stations_, world.time()},
                 {0, 0, picture_.width, picture_.height});
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

// Turns the view so that the whole floor, with what stands across its border, fills the picture.
void Renderer::fit() {
  mjvGLCamera& camera = scene_.camera[0];
  const auto vector = [](const float* v) -> Vec3 { return Eigen::Map<const Eigen::Vector3f>(v).cast<double>(); };
  const Vec3 forward = vector(camera.forward), upward = vector(camera.up), from = vector(camera.pos);
  double lowest = 0, highest = 0, widest = 0;  // at distance 1
  for (const double y : kSeenY) {
    const Vec3 offset(kSeenX, y - from.y(), -from.z());
    const double along = offset.dot(forward), up = offset.dot(upward) / along;
    lowest = std::min(lowest, up);
    highest = std::max(highest, up);
    widest = std::max(widest, kSeenX / along);
  }
  const double height = std::max(highest - lowest, 2 * widest * picture_.height / picture_.width);
  const double middle = (highest + lowest) / 2, near = static_cast<double>(camera.frustum_near);
  camera.frustum_top = static_cast<float>((middle + height / 2) * near);
  camera.frustum_bottom = static_cast<float>((middle - height / 2) * near);
}

}  // namespace cxlab::sim
