// Several robots at once, and choices that somebody else makes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/json.h"
#include "scenarios/rl/trainer.h"
#include "tests/support/test_bus.h"

namespace cxlab::rl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

constexpr SimTime kTeamTick = std::chrono::milliseconds(20);
constexpr SimTime kWork = std::chrono::seconds(1);

/// Two robots, each of which can do `dig(ROBOT)`, which takes a second and gives 1. After four of them the episode ends
/// and gives
/// 10. `get_free_robot` waits until a robot is free.
class TeamTest : public testing::Test, protected bus::TestBus {
 protected:
  struct Work {
    bus::GoalId goal;
    std::string robot;
    SimTime ends;
  };

  TeamTest() {
    options_.max_episodes = 1;
    options_.write = [this](const std::string& file, const std::string& text) {
      written_[file] = text;
      return Status();
    };
  }

  void begin() {
    agent_ = join(bus::ParticipantKind::kNode, "agent");
    serve("get_predefined_observables", "GetPredefinedObservables", [](bus::MessageView response) {
      for (const char* robot : {"r1", "r2"}) {
        const bus::MessageView item = response.append("observables");
        item.set("name", "idle");
        item.append_text("params", robot);
      }
    });
    serve("get_observable_predicates", "GetObservablePredicates", [](bus::MessageView) {});
    serve("get_predefined_actions", "GetPredefinedActions", [](bus::MessageView) {});
    serve("get_observable_actions", "GetObservableActions", [](bus::MessageView response) {
      response.append_text("action_names", "dig").append_text("param_names", "who").append_text("param_types", "robot");
      const bus::Field& counts = *response.type().find("param_counts");
      (void)response.resize(counts, 1);
      (void)response.set_integer(counts, 1);
    });
    serve("get_observable_objects", "GetObservableObjects",
          [](bus::MessageView response) { response.append_text("objects", "r1").append_text("objects", "r2"); });
    serve("get_current_observations", "GetObservations", [this](bus::MessageView response) {
      for (const char* robot : {"r1", "r2"})
        if (!works(robot)) {
          const bus::MessageView item = response.append("observations");
          item.set("name", "idle");
          item.append_text("params", robot);
        }
    });
    serve("get_action_list_executable_for_robot", "GetActionListRobot", [this](bus::MessageView response) {
      const bus::MessageView item = response.append("actions");
      item.set("name", "dig");
      item.append_text("params", asked_);
      response.append_text("action_ids", asked_);
    });
    serve("get_episode_end", "GetEpisodeEnd",
          [this](bus::MessageView response) { response.set("episode_end", dug_ >= 4).set("reward", 10); });
    serve("end_training", "EndTraining", [](bus::MessageView) {});
    serve_action("reset_env", "ResetEnv", [this](const bus::Delivery& d, bus::EndpointId server, const auto& type) {
      ++resets_;
      dug_ = 0;
      work_.clear();
      finish(server, d.goal, std::make_shared<bus::Message>(*type.result));
    });
    serve_action("get_free_robot", "GetFreeRobot",
                 [this](const bus::Delivery& d, bus::EndpointId server, const auto& type) {
                   asking_ = {d.goal, server, &type};
                 });
    serve_action("action_selection", "ActionSelection",
                 [this](const bus::Delivery& d, bus::EndpointId server, const auto& type) {
                   const std::string robot = d.message->view().text("action_id");
                   selection_ = {server, &type};
                   work_.push_back({d.goal, robot, bus_.now() + kWork});
                   begun_.push_back(robot);
                   most_ = std::max(most_, work_.size());
                 });
    if (options_.external) listen();
    trainer_ = *Trainer::create(options_, bus_, sink_);
    due_ = trainer_->next_due();
  }

  void run_until(double seconds) {
    for (const SimTime end = from_seconds(seconds); bus_.now() < end;) {
      bus_.begin_tick(bus_.now() + kTeamTick);
      bus_.deliver(*agent_);
      work();
      if (bus_.now() < due_ && !bus_.any_waiting()) continue;
      const Status acted = trainer_->act(bus_.now());
      if (!acted.ok()) {
        failure_ = acted.error().text();
        return;
      }
      due_ = trainer_->next_due();
    }
  }

  bool works(const std::string& robot) const {
    return std::ranges::any_of(work_, [&](const Work& one) { return one.robot == robot; });
  }

  /// What ends now, and a robot for who waits for one.
  void work() {
    for (auto one = work_.begin(); one != work_.end();) {
      if (one->ends > bus_.now()) {
        ++one;
        continue;
      }
      ++dug_;
      auto result = std::make_shared<bus::Message>(*selection_.second->result);
      result->view().set("action_id", one->robot).set("reward", 1);
      const bus::GoalId goal = one->goal;
      one = work_.erase(one);
      finish(selection_.first, goal, std::move(result));
    }
    if (!asking_) return;
    for (const char* robot : {"r1", "r2"}) {
      if (works(robot)) continue;
      auto result = std::make_shared<bus::Message>(*asking_->type->result);
      result->view().set("success", true).set("robot", robot);
      asked_ = robot;
      const Asking asking = *std::exchange(asking_, std::nullopt);
      finish(asking.server, asking.goal, std::move(result));
      return;
    }
  }

  void finish(bus::EndpointId server, const bus::GoalId& goal, bus::SharedMessage result) {
    bus_.finish(server, goal, bus::GoalStatus::kSucceeded, std::move(result));
  }

  // --- Who chooses with the policy `external`

  void listen() {
    chooser_ = join(bus::ParticipantKind::kNode, "chooser");
    made_type_ = *registry_.message("cxlab_msgs/msg/RlDecisionMade");
    made_ = *bus_.advertise(*chooser_, "/cx_rl_node/decisions/made", *made_type_);
    (void)*bus_.subscribe(*chooser_, "/cx_rl_node/decisions", **registry_.message("cxlab_msgs/msg/RlDecision"),
                          [this](const bus::Delivery& d) {
                            const bus::MessageView message = *d.message;
                            std::string text = message.text("robot") + message.text("outcome") + " ";
                            for (const char* bits : {"observation", "mask"}) {
                              const bus::Field& field = *message.type().find(bits);
                              for (std::size_t i = 0; i < message.size(field); ++i)
                                text += std::to_string(message.integer(field, i));
                              text += ' ';
                            }
                            told_.push_back(text + std::to_string(static_cast<int>(message.real("reward"))));
                            last_ = message.integer("id");
                            is_end_ = message.text("robot").empty();
                          });
  }
  void answer(std::int64_t action) {
    auto message = std::make_shared<bus::Message>(*made_type_);
    message->view().set("id", last_).set("action", action);
    bus_.publish(made_, std::move(message));
  }
  /// Runs until there are so many decisions; each but the last is answered.
  void run_to(std::size_t decisions, const std::vector<std::int64_t>& answers) {
    std::size_t answered = told_.size();
    for (int i = 0; i < 2000 && told_.size() < decisions && failure_.empty(); ++i) {
      run_until(to_seconds(bus_.now() + kTeamTick));
      bus_.deliver(*chooser_);
      if (told_.size() > answered && told_.size() < decisions) {
        answer(answers.at(answered));
        answered = told_.size();
      }
    }
  }

  struct Asking {
    bus::GoalId goal;
    bus::EndpointId server;
    const bus::ActionType* type;
  };
  TrainerOptions options_;
  std::unique_ptr<Trainer> trainer_;
  SimTime due_{};
  std::optional<bus::ParticipantId> agent_, chooser_;
  std::map<std::string, std::string> written_;
  std::optional<Asking> asking_;
  std::pair<bus::EndpointId, const bus::ActionType*> selection_;
  std::vector<Work> work_;
  std::vector<std::string> begun_, told_;
  std::string asked_, failure_;
  int dug_ = 0, resets_ = 0;
  std::size_t most_ = 0;
  const bus::MessageType* made_type_ = nullptr;
  bus::EndpointId made_{};
  std::int64_t last_ = 0;
  bool is_end_ = false;

 private:
  template <class Fill>
  void serve(const std::string& name, const std::string& of, Fill fill) {
    const auto& type = **registry_.service("cx_rl_interfaces/srv/" + of);
    auto server = std::make_shared<bus::EndpointId>();
    *server = *bus_.serve(*agent_, "/cx_rl_node/" + name, type, [this, server, &type, fill](const bus::Delivery& d) {
      auto response = std::make_shared<bus::Message>(*type.response);
      fill(response->view());
      bus_.respond(*server, d, std::move(response));
    });
  }
  template <class Begin>
  void serve_action(const std::string& name, const std::string& of, Begin begin) {
    const auto& type = **registry_.action("cx_rl_interfaces/action/" + of);
    auto server = std::make_shared<bus::EndpointId>();
    *server = *bus_.serve_action(*agent_, "/cx_rl_node/" + name, type,
                                 {.goal =
                                      [this, server, &type, begin](const bus::Delivery& d) {
                                        bus_.answer_goal(*server, d.goal, bus::GoalAnswer::kAccept);
                                        begin(d, *server, type);
                                      },
                                  .cancel = nullptr});
  }
};

TEST_F(TeamTest, OneRobotIsAtWorkAtATime) {
  begin();
  run_until(10);
  EXPECT_EQ(most_, 1U);
  EXPECT_EQ(written_["training.csv"], "episode,steps,reward,end\n1,4,14,end\n");
}

TEST_F(TeamTest, SeveralRobotsWorkAtOnce) {
  options_.robots = 2;
  begin();
  run_until(10);
  EXPECT_EQ(most_, 2U);
  EXPECT_THAT(std::vector(begun_.begin(), begun_.begin() + 4), ElementsAre("r1", "r2", "r1", "r2"));
  EXPECT_THAT(written_["training.csv"], HasSubstr("reward,end\n1,"));
  EXPECT_THAT(written_["training.csv"], HasSubstr(",14,end\n"));
  EXPECT_EQ(resets_, 1);
}

TEST_F(TeamTest, NoMoreThanThereAreWorkAtOnce) {
  options_.robots = 5;
  options_.max_episodes = 3;
  begin();
  run_until(30);
  EXPECT_EQ(most_, 2U);
  EXPECT_EQ(resets_, 3);
  EXPECT_EQ(std::ranges::count(written_["training.csv"], '\n'), 4);
  EXPECT_EQ(trainer_->unfinished(), "");
}

TEST_F(TeamTest, TheSpacesAreWritten) {
  begin();
  run_until(10);
  const Json spaces = parse_json(written_["spaces.json"]);
  EXPECT_EQ(spaces["observables"], Json({"idle(r1)", "idle(r2)"}));
  EXPECT_EQ(spaces["actions"], Json({"no-op", "dig(r1)", "dig(r2)"}));
}

TEST_F(TeamTest, SomebodyElseChooses) {
  options_.external = true;
  options_.max_episodes = 2;
  begin();
  run_to(5, {1, 1, 1, 1});
  EXPECT_EQ(failure_, "");
  EXPECT_THAT(told_, ElementsAre("r1 11 010 0", "r1 11 010 1", "r1 11 010 1", "r1 11 010 1", "end 11  11"));
  EXPECT_FALSE(written_.contains("model.json"));
  EXPECT_EQ(resets_, 1) << "the next episode waits for an answer";
  answer(0);
  run_to(6, {});
  EXPECT_EQ(resets_, 2);
  EXPECT_EQ(told_.back(), "r1 11 010 0");
}

TEST_F(TeamTest, AnObservationIsOfTheTimeWhenTheRobotIsFree) {
  options_.external = true;
  options_.robots = 3;
  begin();
  run_to(3, {1, 2});
  EXPECT_THAT(told_, ElementsAre("r1 11 010 0", "r2 01 101 0", "r1 10 110 1"));
}

TEST_F(TeamTest, ARobotMayBeLeftIdleWhileAnotherWorks) {
  options_.external = true;
  options_.robots = 2;
  begin();
  run_to(3, {1, 0});
  EXPECT_EQ(failure_, "");
  EXPECT_THAT(told_, ElementsAre("r1 11 010 0", "r2 01 101 0", "r1 11 010 1"));
  EXPECT_THAT(begun_, ElementsAre("r1"));
}

TEST_F(TeamTest, TheOnlyRobotMayBeLeftIdleWhereThatIsAllowed) {
  options_.external = true;
  options_.no_op = true;
  begin();
  run_to(2, {0});
  EXPECT_THAT(told_, ElementsAre("r1 11 110 0", "r1 11 110 0"));
  EXPECT_THAT(begun_, SizeIs(0));
}

TEST_F(TeamTest, AnEpisodeIsGivenUpOnDemand) {
  options_.external = true;
  options_.max_episodes = 2;
  begin();
  run_to(3, {1, -1});
  EXPECT_EQ(told_.back(), "given up 11  0");
  EXPECT_EQ(written_["training.csv"], "episode,steps,reward,end\n1,1,1,given up\n");
}

TEST_F(TeamTest, AChoiceThatTheMaskForbidsEndsTheRun) {
  options_.external = true;
  begin();
  run_to(1, {});
  answer(2);
  run_until(to_seconds(bus_.now()) + 0.1);
  EXPECT_THAT(failure_, HasSubstr("action 2 of decision 1 cannot be chosen"));
  EXPECT_THAT(begun_, SizeIs(0));
}

}  // namespace
}  // namespace cxlab::rl
