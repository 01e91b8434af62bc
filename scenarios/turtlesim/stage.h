#pragma once
// The stage of a canvas of turtles.

#include <memory>
#include <string>

#include "cx/base/expected.h"
#include "scenarios/catalogue.h"
#include "scenarios/turtlesim/node.h"

namespace cxlab::turtlesim {

/// The world of a scenario of kind turtlesim: its writes are logged, its turtles are in the result.
class TurtleStage final : public Stage {
 public:
  static Expected<std::unique_ptr<Stage>> create(const StageSetup& setup);

  std::string take_inputs() override { return writes_.take(); }
  void report(Result& result) const override;

  const TurtlesimNode& node() const { return *node_; }

 private:
  sim::TurtleLog writes_;
  const TurtlesimNode* node_ = nullptr;  // owned as server
};

/// A canvas beside another world: on the stage, but neither logged nor in the result.
Status add_turtlesim(const ServerSpec& spec, const StageSetup& setup, Stage& stage);

/// The physics of a recorded run of kind turtlesim.
Expected<std::unique_ptr<WorldReplay>> replay(const Scenario& scenario, const std::filesystem::path& models,
                                              const std::string& log);
/// A result with one turtle.
void add_sample(Result& sample);

}  // namespace cxlab::turtlesim
