// Environments in the loop: when their executives run, and what chance gives them.

#include <chrono>

#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

class AgentsInTheLoop : public testing::Test {
 protected:
  /// An executive at 10 Hz that notes its times.
  void begin() {
    lab_.agent("(defrule note (time ?t) => (assert (ran ?t)))");
    lab_.run_up();
    loop_.emplace(lab_.bus, kTick, Parts{.agents = {lab_.manager.get()}});
    loop_->set_end(std::chrono::seconds(100));
  }
  Lab lab_;
  std::optional<Loop> loop_;
};

TEST_F(AgentsInTheLoop, TimeJumpsFromDueToDue) {
  begin();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(loop_->tick());
  EXPECT_THAT(lab_.facts("ran"), ElementsAre("(ran 0.0)", "(ran 0.1)", "(ran 0.2)"));
  EXPECT_EQ(loop_->ticks(), 3) << "nothing is due between";
}

TEST_F(AgentsInTheLoop, DuesThatALongStepMissedAreOneRun) {
  begin();
  ASSERT_TRUE(loop_->tick());
  ASSERT_TRUE(loop_->tick_at(milliseconds(1040)));
  EXPECT_THAT(lab_.facts("ran"), ElementsAre("(ran 0.0)", "(ran 1.04)"));
  EXPECT_EQ(loop_->next_tick(), milliseconds(1100)) << "the beat goes on where it would have been";
  ASSERT_TRUE(loop_->tick());
  EXPECT_THAT(lab_.facts("ran"), ElementsAre("(ran 0.0)", "(ran 1.04)", "(ran 1.1)"));
}

TEST_F(AgentsInTheLoop, WhatAnAgentSendsToItselfComesAtTheFollowingTick) {
  lab_.agent(R"((defrule open (time ?) (not (open)) => (assert (open))
  (ros-msgs-create-subscription "t" "std_msgs/msg/Empty") (ros-msgs-create-publisher "t" "std_msgs/msg/Empty")
  (bind ?m (ros-msgs-create-message "std_msgs/msg/Empty")) (ros-msgs-publish ?m "t") (ros-msgs-destroy-message ?m))
(defrule take (ros-msgs-message (topic "t")) => (assert (taken (now)))))");
  lab_.run_up();
  Loop loop(lab_.bus, kTick, {.agents = {lab_.manager.get()}});
  ASSERT_TRUE(loop.tick());
  ASSERT_TRUE(loop.tick());
  EXPECT_EQ(loop.now(), kTick) << "a message waits: the following tick comes, before the next due";
}

TEST(Chance, OfTwoEnvironmentsWithOneSeedIsNotTheSame) {
  Lab lab;
  lab.config(R"(environments: ["a", "b"]
a: {plugins: []}
b: {plugins: []})");
  lab.run_up();
  const auto draws = [&](const std::string& environment, const std::string& before) {
    RuleEngine& engine = lab.engine(environment);
    EXPECT_TRUE(before.empty() || engine.eval(before).ok());
    std::vector<std::int64_t> numbers;
    for (int i = 0; i < 8; ++i) numbers.push_back(engine.eval("(random 1 1000000)")->as_integer());
    return numbers;
  };
  EXPECT_NE(draws("a", ""), draws("b", "")) << "with the seed of the run";
  const auto a = draws("a", "(seed 7)"), b = draws("b", "(seed 7)");
  EXPECT_NE(a, b) << "with a seed of the rules";
  EXPECT_EQ(draws("a", "(seed 7)"), a) << "which begins it again";
  EXPECT_NE(draws("a", "(seed 8)"), a);
}

}  // namespace
}  // namespace cxlab::cx
