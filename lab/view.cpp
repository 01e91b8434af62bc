#include "lab/view.h"

#include <algorithm>

#include "scenarios/rcll/stage.h"
#include "scenarios/turtlesim/stage.h"
#include "sim/box2d/turtle_picture.h"
#include "sim/mujoco/render.h"

namespace cxlab::lab {

namespace {

const std::string kCanvas = "canvas";

class FactoryView final : public View {
 public:
  FactoryView(std::unique_ptr<sim::Renderer> renderer, const sim::PhysicsGate& world)
      : renderer_(std::move(renderer)), world_(world) {}
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
    if (camera != kCanvas) return input_error("found no camera '" + std::string(camera) + "', expected: " + kCanvas);
    picture_ = sim::draw_turtles(world_, side_);
    return &picture_;
  }
  std::vector<std::string> cameras() const override { return {kCanvas}; }

 private:
  const sim::TurtleWorld& world_;
  int side_;
  sim::Picture picture_;
};

/// A world and the canvases beside it: "canvas", "canvas2", ...; any other camera is the first view's.
class SeveralViews final : public View {
 public:
  explicit SeveralViews(std::vector<std::unique_ptr<View>> views) : views_(std::move(views)) {
    const bool canvas_first = views_.front()->cameras().front() == kCanvas;
    for (std::size_t i = canvas_first ? 0 : 1; i < views_.size(); ++i)
      canvases_.emplace_back(canvases_.empty() ? kCanvas : kCanvas + std::to_string(canvases_.size() + 1),
                             views_[i].get());
    if (!canvas_first) names_ = views_.front()->cameras();
    for (const auto& [name, view] : canvases_) names_.push_back(name);
  }
  Expected<const sim::Picture*> draw(std::string_view camera) override {
    for (const auto& [name, view] : canvases_)
      if (name == camera) return view->draw(kCanvas);
    return views_.front()->draw(camera);
  }
  std::vector<std::string> cameras() const override { return names_; }

 private:
  std::vector<std::unique_ptr<View>> views_;
  std::vector<std::pair<std::string, View*>> canvases_;
  std::vector<std::string> names_;
};

}  // namespace

Expected<std::unique_ptr<View>> view_of_factory(const sim::FloorPlan& plan, const sim::PhysicsGate& world, int width,
                                                int height) {
  auto renderer = sim::Renderer::create(plan, world, width, height);
  if (!renderer) return renderer.error();
  return std::unique_ptr<View>(std::make_unique<FactoryView>(*std::move(renderer), world));
}

std::unique_ptr<View> view_of_turtles(const sim::TurtleWorld& world, int width, int height) {
  return std::make_unique<TurtleView>(world, std::min(width, height));
}

Expected<std::unique_ptr<View>> view_of(const Stage& stage, int width, int height) {
  std::vector<std::unique_ptr<View>> views;
  const auto* game = dynamic_cast<const rcll::GameStage*>(&stage);
  if (game && game->physics()) {
    auto factory = view_of_factory(game->physics()->plan(), game->physics()->gate(), width, height);
    if (!factory) return factory.error();
    views.push_back(*std::move(factory));
  }
  for (const auto& server : stage.servers)
    if (const auto* turtles = dynamic_cast<const turtlesim::TurtlesimNode*>(server.get()))
      views.push_back(view_of_turtles(turtles->world(), width, height));
  if (views.size() > 1) return std::unique_ptr<View>(std::make_unique<SeveralViews>(std::move(views)));
  if (!views.empty()) return std::move(views.front());
  if (game) return input_error("the timed tier has no bodies to look at: --tier physics (render: --set tier=physics)");
  return input_error("the world is empty: there is nothing to look at");
}

}  // namespace cxlab::lab
