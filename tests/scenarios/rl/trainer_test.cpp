// What the trainer says and when, with an agent that is not there, comes late or goes.

#include "scenarios/rl/trainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/number_text.h"
#include "tests/support/test_bus.h"

namespace cxlab::rl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr SimTime kTick = std::chrono::milliseconds(20);

/// Keeps the lines of the log, with their times: "5.000 warn: nobody ...".
class Said final : public cx::LogSink {
 public:
  void line(const cx::LogLine& line) override {
    if (line.level >= cx::LogLevel::kWarn)
      lines.push_back(fixed_text(to_seconds(line.t), 3) + ' ' + std::string(line.text));
  }
  std::vector<std::string> lines;
};

class TrainerTest : public testing::Test, protected bus::TestBus {
 protected:
  TrainerTest() {
    options_.log = &said_;
    options_.max_episodes = 1;
    options_.write = [this](const std::string& file, const std::string& text) {
      written_[file] = text;
      return Status();
    };
  }

  void begin() {
    trainer_ = *Trainer::create(options_, bus_, sink_);
    due_ = trainer_->next_due();
  }

  /// As the loop of a run does: a node acts where something waits for it, or its time has come.
  void run_until(double seconds) {
    for (const SimTime end = from_seconds(seconds); bus_.now() < end;) {
      bus_.begin_tick(bus_.now() + kTick);
      if (agent_) bus_.deliver(*agent_);
      if (bus_.now() < due_ && !bus_.any_waiting()) continue;
      const Status acted = trainer_->act(bus_.now());
      ASSERT_TRUE(acted.ok()) << acted.error().text();
      due_ = trainer_->next_due();
    }
  }

  /// An agent that has no robot to do anything with, and whose episode ends at once.
  void let_agent_come() {
    agent_ = join(bus::ParticipantKind::kNode, "agent");
    for (const char* name : {"get_predefined_observables", "get_observable_predicates", "get_predefined_actions",
                             "get_observable_actions", "get_current_observations", "get_episode_end", "end_training"})
      serve(name);
    serve_action("reset_env", "ResetEnv");
    serve_action("get_free_robot", "GetFreeRobot");
  }
  void let_agent_go() {
    bus_.leave(*agent_);
    agent_.reset();
  }

  Said said_;
  TrainerOptions options_;
  std::unique_ptr<Trainer> trainer_;
  SimTime due_{};
  std::optional<bus::ParticipantId> agent_;
  std::map<std::string, std::string> written_;

 private:
  static std::string type_of(std::string name) {
    if (name == "get_current_observations") return "GetObservations";
    std::string out;
    bool first = true;
    for (const char c : name) {
      if (c != '_') out += first ? static_cast<char>(std::toupper(c)) : c;
      first = c == '_';
    }
    return out;
  }
  void serve(const std::string& name) {
    const auto& type = **registry_.service("cx_rl_interfaces/srv/" + type_of(name));
    auto server = std::make_shared<bus::EndpointId>();
    *server = *bus_.serve(*agent_, "/cx_rl_node/" + name, type, [this, server, &type, name](const bus::Delivery& d) {
      auto response = std::make_shared<bus::Message>(*type.response);
      if (name == "get_episode_end") response->view().set("episode_end", true);
      bus_.respond(*server, d, std::move(response));
    });
  }
  void serve_action(const std::string& name, const std::string& of) {
    const auto& type = **registry_.action("cx_rl_interfaces/action/" + of);
    auto server = std::make_shared<bus::EndpointId>();
    *server = *bus_.serve_action(*agent_, "/cx_rl_node/" + name, type,
                                 {.goal =
                                      [this, server, &type](const bus::Delivery& d) {
                                        bus_.answer_goal(*server, d.goal, bus::GoalAnswer::kAccept);
                                        bus_.finish(*server, d.goal, bus::GoalStatus::kSucceeded,
                                                    std::make_shared<bus::Message>(*type.result));
                                      },
                                  .cancel = nullptr});
  }
};

TEST_F(TrainerTest, AMissingAgentIsReportedOnceAfterFiveSeconds) {
  begin();
  run_until(4.98);
  EXPECT_THAT(said_.lines, IsEmpty());
  run_until(30);
  EXPECT_THAT(said_.lines,
              ElementsAre(StartsWith("5.000 nobody serves the action /cx_rl_node/reset_env; the training begins"),
                          HasSubstr("it waits since 0.1 s for the service get_predefined_observables")));
}

TEST_F(TrainerTest, AnAgentThatComesLaterIsTrained) {
  begin();
  run_until(7);
  let_agent_come();
  run_until(12);
  EXPECT_EQ(written_["training.csv"], "episode,steps,reward,end\n1,0,0,end\n");
  EXPECT_THAT(said_.lines, ElementsAre(StartsWith("5.000 nobody serves")));
  EXPECT_EQ(trainer_->unfinished(), "");
}

TEST_F(TrainerTest, NobodyIsMissedOnceTheTrainingIsOver) {
  begin();
  let_agent_come();
  run_until(3);
  EXPECT_TRUE(written_.contains("model.json"));
  EXPECT_EQ(trainer_->unfinished(), "");
  EXPECT_TRUE(trainer_->hanging().ok());
  let_agent_go();
  EXPECT_EQ(trainer_->next_due(), kNever) << "nothing is left to do";
  // It is still asked for its status.
  bus_.begin_tick(from_seconds(6));
  ASSERT_TRUE(trainer_->act(bus_.now()).ok());
  EXPECT_THAT(said_.lines, IsEmpty());
}

TEST_F(TrainerTest, InTheModeForExecutionItWaitsForNobody) {
  options_.training = false;
  begin();
  EXPECT_EQ(trainer_->next_due(), kNever);
  run_until(20);
  bus_.begin_tick(from_seconds(21));
  ASSERT_TRUE(trainer_->act(bus_.now()).ok());
  EXPECT_THAT(said_.lines, IsEmpty());
  EXPECT_EQ(trainer_->unfinished(), "");
}

}  // namespace
}  // namespace cxlab::rl
