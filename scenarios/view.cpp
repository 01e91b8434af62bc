#include "scenarios/view.h"

#include <algorithm>

#include "scenarios/stage.h"

namespace cxlab {

namespace {

class SeveralViews final : public View {
 public:
  explicit SeveralViews(std::vector<std::unique_ptr<View>> views) : views_(std::move(views)) {
    for (const auto& view : views_)
      for (const std::string& camera : view->cameras()) {
        std::string name = camera;
        for (int k = 2; find(name); ++k) name = camera + std::to_string(k);
        cameras_.push_back({name, camera, view.get()});
      }
  }
  /// A name that no view lists is the first one's, which may know more than it lists.
  Expected<const sim::Picture*> draw(std::string_view camera) override {
    const Camera* known = find(camera);
    return known ? known->view->draw(known->own_name) : views_.front()->draw(camera);
  }
  void set_time(SimTime t) override {
    for (const auto& view : views_) view->set_time(t);
  }
  /// The headline of the world, which comes first, or of a node beside it.
  std::vector<sim::ColouredText> headline() override {
    for (const auto& view : views_)
      if (auto words = view->headline(); !words.empty()) return words;
    return {};
  }
  std::vector<std::string> cameras() const override {
    std::vector<std::string> names;
    for (const Camera& camera : cameras_) names.push_back(camera.name);
    return names;
  }

 private:
  struct Camera {
    std::string name, own_name;
    View* view = nullptr;
  };
  const Camera* find(std::string_view name) const {
    const auto at = std::ranges::find(cameras_, name, &Camera::name);
    return at == cameras_.end() ? nullptr : &*at;
  }
  std::vector<std::unique_ptr<View>> views_;
  std::vector<Camera> cameras_;
};

}  // namespace

Expected<std::unique_ptr<View>> view_of(const Stage& stage, int width, int height) {
  std::vector<std::unique_ptr<View>> views;
  for (const ViewMaker& make : stage.views) {
    auto view = make(width, height);
    if (!view) return view.error();
    views.push_back(*std::move(view));
  }
  if (views.empty()) return input_error(stage.without_views);
  if (views.size() == 1) return std::move(views.front());
  return std::unique_ptr<View>(std::make_unique<SeveralViews>(std::move(views)));
}

}  // namespace cxlab
