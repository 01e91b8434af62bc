// What a picture costs, beside the same scene drawn by MuJoCo alone: both are drawn, read back and written as PNG.

#include <benchmark/benchmark.h>

#include <filesystem>

#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/game/game.h"
#include "sim/mujoco/mujoco_world.h"
#include "sim/mujoco/render.h"

namespace cxlab {
namespace {

constexpr int kWidth = 640, kHeight = 480;
const std::filesystem::path kFile = std::filesystem::temp_directory_path() / "cxlab_bench.png";

std::unique_ptr<sim::MujocoWorld> world() {
  const rcll::WorldConfig config;
  auto made = sim::MujocoWorld::create(rcll::floor_plan_of(config, rcll::game_of(config, 1)->layout), {"models"});
  return made ? *std::move(made) : nullptr;
}

void bare(benchmark::State& state) {
  const auto floor = world();
  if (!floor) return state.SkipWithError("run it in the root of the sources");
  auto context = sim::GlContext::create(kWidth, kHeight);
  if (!context || !(*context)->make_current()) return state.SkipWithError("no OpenGL");
  mjModel model = floor->gate().model();
  model.vis.global.offwidth = kWidth;
  model.vis.global.offheight = kHeight;
  model.vis.quality.shadowsize = 0;
  const std::unique_ptr<mjData, sim::MjDeleter> data(mj_makeData(&model));
  mj_forward(&model, data.get());
  mjvScene scene;
  mjvOption option;
  mjvCamera camera;
  mjrContext gl;
  mjv_defaultScene(&scene);
  mjv_defaultOption(&option);
  mjv_defaultCamera(&camera);
  mjr_defaultContext(&gl);
  mjv_makeScene(&model, &scene, 2000);
  scene.flags[mjRND_SHADOW] = scene.flags[mjRND_REFLECTION] = 0;
  mjr_makeContext(&model, &gl, mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &gl);
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = mj_name2id(&model, mjOBJ_CAMERA, "field");
  mjv_updateScene(&model, data.get(), &option, nullptr, &camera, mjCAT_ALL, &scene);
  sim::Picture picture{kWidth, kHeight, std::vector<std::uint8_t>(3 * kWidth * kHeight)};
  for (auto _ : state) {
    mjr_render({0, 0, kWidth, kHeight}, &scene, &gl);
    mjr_readPixels(picture.rgb.data(), nullptr, {0, 0, kWidth, kHeight}, &gl);
    if (!sim::write_png(picture, kFile)) return state.SkipWithError("the disk is full");
  }
  mjr_freeContext(&gl);
  mjv_freeScene(&scene);
}

void snapshot(benchmark::State& state) {
  const auto floor = world();
  if (!floor) return state.SkipWithError("run it in the root of the sources");
  auto renderer = sim::Renderer::create(floor->plan(), floor->gate(), kWidth, kHeight);
  if (!renderer) return state.SkipWithError("no OpenGL");
  sim::Legend legend;
  for (int i = 0; i < 10; ++i) {
    sim::Legend::Card& card = legend.cards.emplace_back();
    card.product = sim::Stack{1, {1, 2, 3}, 1};
    card.lines = {{{"1 C3"}, {"10:00-12:00"}}};
    if (i % 2 == 0) card.ticks = {{0, 1, 1}};
  }
  for (auto _ : state) {
    const auto picture = (*renderer)->draw(floor->gate(), "field", legend);
    if (!picture || !sim::write_png(**picture, kFile)) return state.SkipWithError("the disk is full");
  }
}

BENCHMARK(bare)->Unit(benchmark::kMillisecond)->Iterations(100);
BENCHMARK(snapshot)->Unit(benchmark::kMillisecond)->Iterations(100);

}  // namespace
}  // namespace cxlab
