#include "sim/mujoco/render.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace cxlab::sim {
namespace {

constexpr int kMostGeoms = 2000;
constexpr double kBlinkPeriod = 0.5;  ///< s; docs/models.md: lights blink at 2 Hz

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

  label_of_.resize(static_cast<std::size_t>(m->ngeom));
  light_of_.assign(static_cast<std::size_t>(m->ngeom), -1);
  const auto label = [&](const std::string& name, const char* geom) {
    const int id = mj_name2id(m, mjOBJ_GEOM, (name + "/" + geom).c_str());
    if (id >= 0) label_of_[static_cast<std::size_t>(id)] = name;
  };
  for (const std::string& robot : robots_) label(robot, "colour-deck");
  for (const std::string& station : stations_) label(station, "kind-portal");
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
  if (overview) add_labels();

  const mjrRect whole{0, 0, picture_.width, picture_.height};
  mjr_render(whole, &scene_, &gl_);
  mjr_readPixels(upside_down_.data(), nullptr, whole, &gl_);
  const std::size_t row = 3 * static_cast<std::size_t>(picture_.width);
  const auto rows = static_cast<std::size_t>(picture_.height);
  for (std::size_t y = 0; y < rows; ++y)
    std::memcpy(picture_.rgb.data() + y * row, upside_down_.data() + (rows - 1 - y) * row, row);
  return &picture_;
}

// Lights are the machines' state, not the model's: they are put on in the picture only.
void Renderer::shine(const PhysicsGate& world) {
  const bool lit_phase = std::fmod(world.time(), kBlinkPeriod) < kBlinkPeriod / 2;
  for (int g = 0; g < scene_.ngeom; ++g) {
    mjvGeom& geom = scene_.geoms[g];
    if (geom.objtype != mjOBJ_GEOM || geom.objid < 0) continue;
    const int light = light_of_[static_cast<std::size_t>(geom.objid)];
    if (light < 0) continue;
    const Lights& lights = world.lights(static_cast<StationId>(light / 3));
    const Light state = light % 3 == 0 ? lights.red : light % 3 == 1 ? lights.yellow : lights.green;
    const bool on = state == Light::kOn || (state == Light::kBlink && lit_phase);
    geom.emission = on ? 1.0f : 0.0f;
    if (!on)
      for (int i = 0; i < 3; ++i) geom.rgba[i] *= 0.3f;
  }
}

void Renderer::add_labels() {
  for (int g = 0; g < scene_.ngeom; ++g) {
    mjvGeom& geom = scene_.geoms[g];
    if (geom.objtype != mjOBJ_GEOM || geom.objid < 0) continue;
    const std::string& label = label_of_[static_cast<std::size_t>(geom.objid)];
    if (!label.empty()) std::snprintf(geom.label, sizeof geom.label, "%s", label.c_str());
  }
}

}  // namespace cxlab::sim
