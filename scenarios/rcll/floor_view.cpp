#include "scenarios/rcll/floor_view.h"

#include "scenarios/rcll/game/scene.h"
#include "sim/mujoco/posed_floor.h"
#include "sim/mujoco/render.h"

namespace cxlab::rcll {
namespace {

class FloorView final : public View {
 public:
  FloorView(std::unique_ptr<sim::Renderer> renderer, const sim::PhysicsGate& floor, BoardAt board)
      : renderer_(std::move(renderer)), floor_(floor), board_(std::move(board)) {}

  Expected<const sim::Picture*> draw(std::string_view camera) override {
    if (!board_ || !sim::Renderer::shows_field(camera)) return renderer_->draw(floor_, camera);
    return renderer_->draw(floor_, camera, legend_of(board_(now_)));
  }
  std::vector<std::string> cameras() const override { return {"field", "top"}; }
  void set_time(SimTime t) override { now_ = t; }
  std::vector<sim::ColouredText> headline() override {
    return board_ ? headline_of(board_(now_)) : std::vector<sim::ColouredText>();
  }

 private:
  std::unique_ptr<sim::Renderer> renderer_;
  const sim::PhysicsGate& floor_;
  BoardAt board_;
  SimTime now_{};
};

/// Poses the floor before each picture.
class PosedView final : public View {
 public:
  PosedView(const sim::FloorPlan& plan, std::unique_ptr<sim::PosedFloor> floor, std::function<Scene(SimTime)> scene,
            std::unique_ptr<View> view)
      : plan_(plan), floor_(std::move(floor)), scene_(std::move(scene)), view_(std::move(view)) {}

  Expected<const sim::Picture*> draw(std::string_view camera) override {
    floor_->pose(floor_pose_of(scene_(now_), plan_), to_seconds(now_));
    return view_->draw(camera);
  }
  std::vector<std::string> cameras() const override { return view_->cameras(); }
  void set_time(SimTime t) override { view_->set_time(now_ = t); }
  std::vector<sim::ColouredText> headline() override { return view_->headline(); }

 private:
  const sim::FloorPlan& plan_;
  std::unique_ptr<sim::PosedFloor> floor_;
  std::function<Scene(SimTime)> scene_;
  std::unique_ptr<View> view_;
  SimTime now_{};
};

}  // namespace

Expected<std::unique_ptr<View>> view_of_physics(const sim::FloorPlan& plan, const sim::PhysicsGate& floor,
                                                BoardAt board, int width, int height) {
  auto renderer = sim::Renderer::create(plan, floor, width, height);
  if (!renderer) return renderer.error();
  return std::unique_ptr<View>(std::make_unique<FloorView>(*std::move(renderer), floor, std::move(board)));
}

Expected<std::unique_ptr<View>> view_of_scene(const sim::FloorPlan& plan, const sim::ModelOptions& options,
                                              std::function<Scene(SimTime)> scene, BoardAt board, int width,
                                              int height) {
  auto floor = sim::PosedFloor::create(plan, options);
  if (!floor) return floor.error();
  auto view = view_of_physics(plan, (*floor)->gate(), std::move(board), width, height);
  if (!view) return view.error();
  return std::unique_ptr<View>(
      std::make_unique<PosedView>(plan, *std::move(floor), std::move(scene), *std::move(view)));
}

}  // namespace cxlab::rcll
