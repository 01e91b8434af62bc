#pragma once
// The stage of a canvas of turtles.

#include <memory>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "cx/node/log.h"
#include "scenarios/stage.h"
#include "scenarios/turtlesim/node.h"

namespace cxlab::turtlesim {

sim::TurtleWorldOptions world_options(const Config& config, SimTime step);

/// The world of a scenario of kind turtlesim: logged, and told in the result.
class TurtleStage final : public Stage {
 public:
  static Expected<std::unique_ptr<TurtleStage>> create(const Config& config, SimTime step, bus::Bus& bus,
                                                       RecordSink& sink, cx::LogSink* log);

  std::string take_inputs() override { return writes_.take(); }
  void report(Result& result) const override;

  const TurtlesimNode& node() const { return *node_; }

 private:
  sim::TurtleLog writes_;
  const TurtlesimNode* node_ = nullptr;  // owned as server
};

/// A canvas beside another world: on the stage, but neither logged nor told.
Status add_turtlesim(const Config& config, Stage& stage, bus::Bus& bus, RecordSink& sink, cx::LogSink* log);

}  // namespace cxlab::turtlesim
