#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A server node and a client environment; what each takes is in the log, and the last cancel is kept for its answer.
class ActionTest : public BusTest {
 protected:
  void SetUp() override {
    BusTest::SetUp();
    env_ = environment("env");
    robot_ = node("robot");
    client_ = make_client(env_);
    tick();
  }

  EndpointId make_client(ParticipantId p) {
    return *bus_.create_action_client(
        p, "fib", *fibonacci_,
        {[this](const Delivery& d) { log_.push_back(d.accepted ? "accepted" : "rejected"); },
         [this](const Delivery& d) {
           log_.push_back("feedback of " + std::to_string(d.message->view().size("sequence")));
         },
         [this](const Delivery& d) { log_.push_back("result " + std::to_string(static_cast<int>(d.status))); },
         [this](const Delivery& d) {
           log_.push_back("cancel " + std::to_string(d.return_code) + " of " +
                          std::to_string(d.goals_canceling.size()));
           cancel_response_ = d;
         }});
  }
  EndpointId make_server(bool hear_cancels = true) {
    Handler cancel = [this](const Delivery& d) {
      log_.push_back("asked to cancel");
      cancels_.push_back(d);
    };
    return *bus_.serve_action(robot_, "fib", *fibonacci_,
                              {[this](const Delivery&) { log_.push_back("goal"); }, hear_cancels ? cancel : nullptr});
  }
  GoalId send() { return bus_.send_goal(client_, blank(*fibonacci_->goal)); }
  /// A goal that the server executes, known to the client.
  GoalId executing(EndpointId server) {
    const GoalId goal = send();
    bus_.deliver(robot_);
    EXPECT_TRUE(bus_.answer_goal(server, goal, GoalAnswer::kAccept));
    bus_.deliver(env_);
    taken();
    return goal;
  }
  bool finish(EndpointId server, const GoalId& goal, GoalStatus status) {
    return bus_.finish(server, goal, status, blank(*fibonacci_->result));
  }

  ParticipantId env_{}, robot_{};
  EndpointId client_{};
  std::vector<Delivery> cancels_;
  Delivery cancel_response_;
};

TEST_F(ActionTest, AGoalIsAcceptedGivesFeedbackAndSucceeds) {
  const auto server = make_server();
  EXPECT_TRUE(bus_.action_ready(client_));
  const GoalId goal = send();
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kUnknown);
  EXPECT_FALSE(bus_.answer_goal(server, goal, GoalAnswer::kAccept)) << "not taken yet";
  EXPECT_THAT(deliver(robot_), ElementsAre("goal"));
  EXPECT_TRUE(bus_.answer_goal(server, goal, GoalAnswer::kAccept));
  EXPECT_FALSE(bus_.answer_goal(server, goal, GoalAnswer::kReject)) << "answered already";
  EXPECT_EQ(bus_.server_goal_status(server, goal), GoalStatus::kExecuting);
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kUnknown) << "the client has not taken the answer";
  EXPECT_TRUE(bus_.publish_feedback(server, goal, blank(*fibonacci_->feedback)));
  EXPECT_THAT(deliver(env_), ElementsAre("accepted", "feedback of 0"));
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kExecuting);
  tick();
  EXPECT_TRUE(finish(server, goal, GoalStatus::kSucceeded));
  EXPECT_FALSE(finish(server, goal, GoalStatus::kAborted)) << "ended already";
  EXPECT_FALSE(bus_.publish_feedback(server, goal, blank(*fibonacci_->feedback)));
  EXPECT_THAT(deliver(env_), ElementsAre("result 4"));
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kSucceeded);
}

TEST_F(ActionTest, AllInOneTickArrivesInOrder) {
  const auto server = make_server();
  const GoalId goal = send();
  bus_.deliver(robot_);
  taken();
  bus_.answer_goal(server, goal, GoalAnswer::kAccept);
  bus_.publish_feedback(server, goal, blank(*fibonacci_->feedback));
  finish(server, goal, GoalStatus::kAborted);
  EXPECT_THAT(deliver(env_), ElementsAre("accepted", "feedback of 0", "result 6"));
}

TEST_F(ActionTest, AClientThatWasRemovedSendsNothing) {
  const auto server = make_server();
  const GoalId goal = executing(server);
  bus_.remove(client_);
  EXPECT_EQ(send(), GoalId{});
  bus_.cancel_goal(client_, goal);
  EXPECT_FALSE(bus_.action_ready(client_));
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kUnknown);
  EXPECT_THAT(deliver(robot_), IsEmpty());
}

TEST_F(ActionTest, ARejectedGoalIsOver) {
  const auto server = make_server();
  const GoalId goal = send();
  bus_.deliver(robot_);
  taken();
  EXPECT_TRUE(bus_.answer_goal(server, goal, GoalAnswer::kReject));
  EXPECT_FALSE(finish(server, goal, GoalStatus::kSucceeded));
  EXPECT_THAT(deliver(env_), ElementsAre("rejected"));
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kUnknown);
}

TEST_F(ActionTest, ADeferredGoalWaitsForExecute) {
  const auto server = make_server();
  const GoalId goal = send();
  bus_.deliver(robot_);
  EXPECT_FALSE(bus_.execute(server, goal));
  bus_.answer_goal(server, goal, GoalAnswer::kDefer);
  bus_.deliver(env_);
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kAccepted);
  EXPECT_FALSE(finish(server, goal, GoalStatus::kSucceeded));
  EXPECT_TRUE(bus_.execute(server, goal));
  EXPECT_FALSE(bus_.execute(server, goal));
  EXPECT_TRUE(finish(server, goal, GoalStatus::kSucceeded));
}

TEST_F(ActionTest, GoalsAndCancelsWaitForAServer) {
  EXPECT_FALSE(bus_.action_ready(client_));
  const GoalId goal = send();
  bus_.cancel_goal(client_, goal);
  EXPECT_FALSE(bus_.any_waiting());
  make_server();
  EXPECT_THAT(deliver(robot_), ElementsAre("goal"));  // not accepted, so there is nothing to cancel
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 2 of 0"));
}

TEST_F(ActionTest, ACancelIsAcceptedAndTheGoalEndsAsCanceled) {
  const auto server = make_server();
  const GoalId goal = executing(server);
  EXPECT_FALSE(finish(server, goal, GoalStatus::kCanceled)) << "nobody asked for it";
  bus_.cancel_goal(client_, goal);
  EXPECT_THAT(deliver(robot_), ElementsAre("asked to cancel"));
  EXPECT_EQ(cancels_[0].goal, goal);
  EXPECT_TRUE(bus_.answer_cancel(server, cancels_[0], true));
  EXPECT_FALSE(bus_.answer_cancel(server, cancels_[0], true));
  EXPECT_EQ(bus_.server_goal_status(server, goal), GoalStatus::kCanceling);
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 0 of 1"));
  EXPECT_EQ(cancel_response_.goal, goal);
  EXPECT_EQ(cancel_response_.goals_canceling[0].first, goal);
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kCanceling);
  EXPECT_TRUE(finish(server, goal, GoalStatus::kCanceled));
  EXPECT_THAT(deliver(env_), ElementsAre("result 5"));
}

TEST_F(ActionTest, ACancelMayBeRejectedLaterAndTheGoalGoesOn) {
  const auto server = make_server();
  const GoalId goal = executing(server);
  bus_.cancel_goal(client_, goal);
  bus_.deliver(robot_);
  tick();
  taken();
  EXPECT_TRUE(bus_.answer_cancel(server, cancels_[0], false));
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 1 of 0"));
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kExecuting);
  EXPECT_TRUE(finish(server, goal, GoalStatus::kSucceeded));
}

TEST_F(ActionTest, AGoalThatEndsWhileACancelIsOpenStaysEnded) {
  const auto server = make_server();
  const GoalId goal = executing(server);
  bus_.cancel_goal(client_, goal);
  bus_.deliver(robot_);
  taken();
  finish(server, goal, GoalStatus::kSucceeded);
  EXPECT_TRUE(bus_.answer_cancel(server, cancels_[0], true));
  EXPECT_EQ(bus_.server_goal_status(server, goal), GoalStatus::kSucceeded);
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 1 of 0", "result 4"));
}

TEST_F(ActionTest, AGoalThatHasEndedStaysEndedWhenTheCancelOfAllIsAnswered) {
  const auto server = make_server();
  const GoalId first = executing(server), second = executing(server);
  bus_.cancel_all_goals(client_);
  bus_.deliver(robot_);
  ASSERT_EQ(cancels_.size(), 2u);
  EXPECT_TRUE(bus_.answer_cancel(server, cancels_[0], true));
  EXPECT_TRUE(finish(server, first, GoalStatus::kCanceled));
  bus_.deliver(env_);
  EXPECT_EQ(bus_.goal_status(client_, first), GoalStatus::kCanceled);
  EXPECT_TRUE(bus_.answer_cancel(server, cancels_[1], true));
  bus_.deliver(env_);
  EXPECT_EQ(bus_.goal_status(client_, first), GoalStatus::kCanceled);
  EXPECT_EQ(bus_.goal_status(client_, second), GoalStatus::kCanceling);
}

TEST_F(ActionTest, AGoalThatEndedLongAgoIsForgotten) {
  const auto server = make_server();
  const GoalId first = executing(server);
  finish(server, first, GoalStatus::kSucceeded);
  bus_.begin_tick(kEndedGoalKept);
  const GoalId second = executing(server);
  finish(server, second, GoalStatus::kSucceeded);
  EXPECT_EQ(bus_.server_goal_status(server, first), GoalStatus::kSucceeded) << "just not yet";
  bus_.begin_tick(kEndedGoalKept + std::chrono::seconds(1));
  const GoalId third = executing(server);
  EXPECT_EQ(bus_.server_goal_status(server, first), GoalStatus::kSucceeded) << "until another one ends";
  finish(server, third, GoalStatus::kSucceeded);
  EXPECT_EQ(bus_.server_goal_status(server, first), GoalStatus::kUnknown);
  EXPECT_EQ(bus_.server_goal_status(server, second), GoalStatus::kSucceeded);
  bus_.cancel_goal(client_, first);
  bus_.deliver(robot_);
  EXPECT_THAT(deliver(env_), ::testing::Contains("cancel 2 of 0")) << "an unknown goal";
}

TEST_F(ActionTest, WhatTheClientForgetsIsDeliveredAllTheSame) {
  const auto server = make_server();
  const GoalId goal = executing(server);
  bus_.forget_goal(client_, goal);
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kUnknown);
  finish(server, goal, GoalStatus::kSucceeded);
  EXPECT_THAT(deliver(env_), ElementsAre("result 4"));
  EXPECT_EQ(bus_.goal_status(client_, goal), GoalStatus::kUnknown);
}

TEST_F(ActionTest, CancelsOfUnknownAndEndedGoalsAreAnsweredByTheBus) {
  const auto server = make_server();
  const GoalId ended = executing(server);
  finish(server, ended, GoalStatus::kSucceeded);
  bus_.cancel_goal(client_, ended);
  GoalId unknown{};
  unknown[0] = 1;
  bus_.cancel_goal(client_, unknown);
  EXPECT_THAT(deliver(robot_), IsEmpty());
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 3 of 0", "cancel 2 of 0", "result 4"));
}

TEST_F(ActionTest, CancelAllAsksForEachGoalAndAnswersOnce) {
  const auto server = make_server();
  std::vector<GoalId> goals;
  for (int i = 0; i < 5; ++i) goals.push_back(executing(server));
  finish(server, goals[1], GoalStatus::kSucceeded);
  bus_.deliver(env_);
  bus_.cancel_all_goals(client_);
  bus_.deliver(robot_);
  taken();
  ASSERT_EQ(cancels_.size(), 4u);
  const std::vector<GoalId> asked{cancels_[0].goal, cancels_[1].goal, cancels_[2].goal, cancels_[3].goal};
  EXPECT_EQ(asked, (std::vector<GoalId>{goals[0], goals[2], goals[3], goals[4]})) << "in the order in which they came";
  for (std::size_t i = 0; i < 3; ++i) bus_.answer_cancel(server, cancels_[i], i != 1);
  EXPECT_THAT(deliver(env_), IsEmpty()) << "one answer is missing";
  bus_.answer_cancel(server, cancels_[3], true);
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 0 of 3"));
  EXPECT_EQ(cancel_response_.goal, GoalId{});
  bus_.cancel_goals_before(client_, now_);
  EXPECT_THAT(deliver(robot_), ElementsAre("asked to cancel")) << "the others are canceling already";
}

TEST_F(ActionTest, CancelAllWithoutGoalsIsNoError) {
  make_server();
  bus_.cancel_all_goals(client_);
  bus_.deliver(robot_);
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 0 of 0"));
}

TEST_F(ActionTest, CancelBeforeLeavesLaterGoalsAlone) {
  const auto server = make_server();
  const GoalId early = executing(server);
  const SimTime between = now_;
  tick();
  executing(server);
  bus_.cancel_goals_before(client_, between);
  bus_.deliver(robot_);
  ASSERT_EQ(cancels_.size(), 1u);
  EXPECT_EQ(cancels_[0].goal, early);
}

TEST_F(ActionTest, AServerWithoutCancelHandlerRejects) {
  const auto server = make_server(false);
  const GoalId goal = executing(server);
  bus_.cancel_goal(client_, goal);
  bus_.deliver(robot_);
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 1 of 0"));
  EXPECT_EQ(bus_.server_goal_status(server, goal), GoalStatus::kExecuting);
}

TEST_F(ActionTest, AClientThatLeavesDoesNotStopItsGoals) {
  const auto server = make_server();
  const GoalId goal = executing(server);
  bus_.leave(env_);
  EXPECT_TRUE(bus_.publish_feedback(server, goal, blank(*fibonacci_->feedback)));
  EXPECT_TRUE(finish(server, goal, GoalStatus::kSucceeded));
  EXPECT_FALSE(bus_.any_waiting());
}

TEST_F(ActionTest, ARemovedServerLeavesItsGoalsUnanswered) {
  const auto server = make_server();
  const GoalId goal = executing(server);
  bus_.remove(server);
  EXPECT_FALSE(finish(server, goal, GoalStatus::kSucceeded));
  EXPECT_EQ(bus_.server_goal_status(server, goal), GoalStatus::kUnknown);
  EXPECT_FALSE(bus_.any_waiting());
  make_server();
  bus_.cancel_goal(client_, goal);
  bus_.deliver(robot_);
  EXPECT_THAT(deliver(env_), ElementsAre("cancel 2 of 0")) << "the new server does not know it";
}

TEST_F(ActionTest, AServerMayGoWhileItIsAskedToCancel) {
  EndpointId server{};
  server = *bus_.serve_action(robot_, "fib", *fibonacci_,
                              {[&](const Delivery& d) { bus_.answer_goal(server, d.goal, GoalAnswer::kAccept); },
                               [&](const Delivery&) {
                                 log_.push_back("asked");
                                 bus_.remove(server);
                               }});
  send();
  send();
  bus_.cancel_all_goals(client_);
  EXPECT_THAT(deliver(robot_), ElementsAre("asked"));
}

TEST_F(ActionTest, ResultsGoToTheClientThatSentTheGoal) {
  const auto other = environment("other");
  const auto other_client = make_client(other);
  const auto server = make_server();
  const GoalId mine = executing(server);
  bus_.cancel_all_goals(other_client);
  bus_.deliver(robot_);
  bus_.answer_cancel(server, cancels_[0], true);
  finish(server, mine, GoalStatus::kCanceled);
  taken();
  EXPECT_THAT(deliver(other), ElementsAre("cancel 0 of 1")) << "as in ROS, all goals of the server";
  EXPECT_THAT(deliver(env_), ElementsAre("result 5"));
}

TEST_F(ActionTest, GoalIdsDependOnNodeActionAndCountOnly) {
  const GoalId first = send(), second = send();
  EXPECT_NE(first, second);
  EXPECT_EQ(to_string(first), "1abed86fadab14632f471a328131d234") << "in every version";
  KeptRecords sink;
  Bus other(registry_, sink);
  other.join(ParticipantKind::kNode, NodeName{"somebody", "/", {}}, sink.open_stream("somebody"));
  const auto env = other.join(ParticipantKind::kEnvironment, NodeName{"env", "/", {}}, sink.open_stream("env"));
  const auto client = *other.create_action_client(env, "fib", *fibonacci_, {});
  EXPECT_EQ(other.send_goal(client, blank(*fibonacci_->goal)), first);
  const auto twin = other.join(ParticipantKind::kEnvironment, NodeName{"env", "/", {}}, sink.open_stream("twin"));
  const auto of_twin = *other.create_action_client(twin, "fib", *fibonacci_, {});
  const GoalId second_of_name = other.send_goal(of_twin, blank(*fibonacci_->goal));
  EXPECT_NE(second_of_name, first) << "two environments of one node";
  other.leave(env);
  const auto third = other.join(ParticipantKind::kEnvironment, NodeName{"env", "/", {}}, sink.open_stream("third"));
  const GoalId third_of_name =
      other.send_goal(*other.create_action_client(third, "fib", *fibonacci_, {}), blank(*fibonacci_->goal));
  EXPECT_NE(third_of_name, first) << "one that was made again";
  EXPECT_NE(third_of_name, second_of_name);
}

}  // namespace
}  // namespace cxlab::bus
