#include "app/view.h"

#include <algorithm>

#include "scenarios/rcll/stage.h"
#include "scenarios/turtlesim/stage.h"
#include "sim/box2d/turtle_picture.h"
#include "sim/mujoco/render.h"

namespace cxlab::app {

namespace {

class FactoryView final : public View {
 public:
  FactoryView(std::unique_ptr<sim::Renderer> renderer, const sim::PhysicsGate& world) : renderer_(std::move(renderer)), world_(world) {}
  Expected<const sim::Picture*> draw(std::string_view camera) override { return renderer_->draw(world_, camera); }
  std::vector<std::string> cameras() const override { return {"field", "top"}; }

 private:
  std::unique_ptr<sim::Renderer> renderer_;
  const sim::PhysicsGate& world_;
};

class TurtleView final : public View {
 public:
  TurtleView(const sim::TurtleWorld& world, int side) : world_(world), side_(side) {}
  Expected<const sim::Picture*> draw(std::string_view camera) override {
    if (camera != "canvas") return input_error("found no camera '" + std::string(camera) + "', expected: canvas");
    picture_ = sim::draw_turtles(world_, side_);
    return &picture_;
  }
  std::vector<std::string> cameras() const override { return {"canvas"}; }

 private:
  const sim::TurtleWorld& world_;
  int side_;
  sim::Picture picture_;
};

}  // namespace

Expected<std::unique_ptr<View>> view_of_factory(const sim::FloorPlan& plan, const sim::PhysicsGate& world, int width, int height) {
  auto renderer = sim::Renderer::create(plan, world, width, height);
  if (!renderer) return renderer.error();
  return std::unique_ptr<View>(std::make_unique<FactoryView>(*std::move(renderer), world));
}

std::unique_ptr<View> view_of_turtles(const sim::TurtleWorld& world, int width, int height) {
  return std::make_unique<TurtleView>(world, std::min(width, height));
}

Expected<std::unique_ptr<View>> view_of(const Stage& stage, int width, int height) {
  if (const auto* turtles = dynamic_cast<const turtlesim::TurtleStage*>(&stage)) return view_of_turtles(turtles->node().world(), width, height);
  const auto* game = dynamic_cast<const rcll::GameStage*>(&stage);
  if (!game) return input_error("the world is empty: there is nothing to look at");
  if (!game->physics()) return input_error("the timed tier has no bodies to look at: --tier physics (render: --set tier=physics)");
  return view_of_factory(game->physics()->plan(), game->physics()->gate(), width, height);
}

}  // namespace cxlab::app
