// The order of a tick, and which tick comes next.

#include "cx/run/loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "cx/bus/bus.h"
#include "cx/journal/journal.h"

namespace cxlab {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr SimTime kTick = milliseconds(20);

/// Notes each call with the bus's time in ms; a call named in `fails` fails.
struct Calls {
  Status note(const std::string& call) {
    list.push_back(std::to_string(bus->now() / milliseconds(1)) + ' ' + call);
    return call == fails ? Status(run_error(call)) : Status();
  }
  std::vector<std::string> take() { return std::exchange(list, {}); }

  bus::Bus* bus = nullptr;
  std::string fails;
  std::vector<std::string> list;
};

struct TestWorld final : Simulation {
  explicit TestWorld(Calls& c) : calls(c) {}
  Status advance(SimTime duration) override {
    return calls.note("world moves " + std::to_string(duration / milliseconds(1)));
  }
  SimTime next_event() const override { return due; }
  Calls& calls;
  SimTime due = kNever;
};

struct TestServer final : Server {
  TestServer(Calls& c, std::string n) : calls(c), name(std::move(n)) {}
  Status sense(SimTime) override { return calls.note(name + " senses"); }
  Status act(SimTime) override { return calls.note(name + " acts"); }
  SimTime next_due() const override { return due; }
  Calls& calls;
  std::string name;
  SimTime due = kNever;
};

struct TestReferee final : Referee {
  explicit TestReferee(Calls& c) : calls(c) {}
  Status judge(SimTime) override { return calls.note("referee judges"); }
  SimTime next_due() const override { return due; }
  bool over() const override { return false; }
  Calls& calls;
  SimTime due = kNever;
};

/// Has something to decide at each multiple of a period, in ms, that has not been decided yet.
struct TestAgent final : Agent {
  TestAgent(Calls& c, std::string n) : calls(c), name(std::move(n)) {}
  Status perceive() override { return calls.note(name + " perceives"); }
  Status decide(SimTime now) override { return calls.note(name + " decides " + std::to_string(now / milliseconds(1))); }
  Status act() override { return calls.note(name + " acts"); }
  SimTime next_due() const override { return due; }
  Calls& calls;
  std::string name;
  SimTime due = kNever;
};

class LoopTest : public testing::Test {
 protected:
  LoopTest() { calls_.bus = &bus_; }
  Loop loop() {
    return {bus_,
            kTick,
            {.worlds = {&world_}, .servers = {&robot_, &factory_}, .referee = &referee_, .agents = {&a_, &b_}}};
  }

  Journal journal_;
  bus::Registry registry_;
  bus::Bus bus_{registry_, journal_};
  Calls calls_;
  TestWorld world_{calls_};
  TestServer robot_{calls_, "robot"}, factory_{calls_, "factory"};
  TestReferee referee_{calls_};
  TestAgent a_{calls_, "a"}, b_{calls_, "b"};
};

TEST_F(LoopTest, ATickHasItsOrder) {
  Loop played = loop();
  ASSERT_TRUE(played.tick());
  EXPECT_THAT(calls_.take(),
              ElementsAre("0 robot senses", "0 factory senses", "0 referee judges", "0 a perceives", "0 b perceives",
                          "0 a decides 0", "0 b decides 0", "0 a acts", "0 b acts", "0 robot acts", "0 factory acts"))
      << "at time 0 the world has not moved";
  a_.due = kTick;
  ASSERT_TRUE(played.tick());
  EXPECT_THAT(calls_.take(),
              ElementsAre("0 world moves 20", "20 robot senses", "20 factory senses", "20 referee judges",
                          "20 a perceives", "20 b perceives", "20 a decides 20", "20 b decides 20", "20 a acts",
                          "20 b acts", "20 robot acts", "20 factory acts"))
      << "the world moves before the bus has the new time";
  EXPECT_EQ(played.now(), kTick);
  EXPECT_EQ(played.ticks(), 2);
}

TEST_F(LoopTest, AFailureEndsTheTick) {
  const std::vector<std::pair<std::string, std::size_t>> cases = {
      {"world moves 20", 1}, {"robot senses", 2}, {"factory senses", 3}, {"referee judges", 4}, {"a perceives", 5},
      {"b decides 20", 8},   {"a acts", 9},       {"b acts", 10},        {"robot acts", 11},    {"factory acts", 12}};
  for (const auto& [call, calls] : cases) {
    Loop played = loop();
    ASSERT_TRUE(played.tick());
    calls_.take();
    calls_.fails = call;
    const Status status = played.tick_at(kTick);
    calls_.fails.clear();
    ASSERT_FALSE(status.ok()) << call;
    EXPECT_EQ(status.error().message, call);
    EXPECT_EQ(calls_.take().size(), calls) << call;
  }
}

TEST_F(LoopTest, BeforeTheFirstTickTimeIsNegative) {
  Loop played = loop();
  EXPECT_LT(played.now(), SimTime::zero()) << "so that a loop until 0 plays the tick at 0";
  EXPECT_EQ(played.ticks(), 0);
  EXPECT_EQ(played.next_tick(), SimTime::zero()) << "whatever is due";
}

TEST_F(LoopTest, AWorldThatBeginsLateHasMovedFromZero) {
  Loop played = loop();
  ASSERT_TRUE(played.tick_at(3 * kTick));
  EXPECT_EQ(calls_.take().front(), "0 world moves 60");
}

TEST_F(LoopTest, TimeJumpsToTheFirstTickAtWhichAnythingIsDue) {
  Loop played = loop();
  played.set_end(milliseconds(1005));
  ASSERT_TRUE(played.tick());
  EXPECT_EQ(played.next_tick(), milliseconds(1020)) << "nothing is due: the tick at which the end falls";
  b_.due = milliseconds(801);
  EXPECT_EQ(played.next_tick(), milliseconds(820)) << "at the first tick not before it";
  referee_.due = milliseconds(700);
  EXPECT_EQ(played.next_tick(), milliseconds(700)) << "on a tick";
  factory_.due = milliseconds(559);
  EXPECT_EQ(played.next_tick(), milliseconds(560));
  world_.due = milliseconds(400);
  EXPECT_EQ(played.next_tick(), milliseconds(400));
  a_.due = SimTime::zero();
  EXPECT_EQ(played.next_tick(), kTick) << "what is late is due at the following tick, not at this one again";
}

TEST_F(LoopTest, AFunctionOfEachPartIsAskedOfAllOfThem) {
  Loop played = loop();
  ASSERT_TRUE(played.tick());
  EXPECT_EQ(played.next_tick(), kNever) << "there is no end, and nothing is due";
  robot_.due = milliseconds(300);
  EXPECT_EQ(played.next_tick(), milliseconds(300));
  b_.due = milliseconds(200);
  EXPECT_EQ(played.next_tick(), milliseconds(200));
  b_.due = kNever - SimTime{1};
  robot_.due = kNever;
  EXPECT_EQ(played.next_tick(), kNever) << "no overflow near the end of time";
}

TEST_F(LoopTest, WhatIsDueAtSeveralTimesBetweenTicksIsDecidedOnce) {
  Loop played = loop();
  ASSERT_TRUE(played.tick());
  calls_.take();
  a_.due = milliseconds(5);  // of a rate of 200 Hz: 5, 10, 15 and 20 ms have passed at the next tick
  ASSERT_TRUE(played.tick());
  a_.due = kNever;
  const auto list = calls_.take();
  EXPECT_EQ(std::count(list.begin(), list.end(), "20 a decides 20"), 1);
}

TEST_F(LoopTest, WhereMessagesWaitTheFollowingTickComes) {
  ASSERT_TRUE(registry_.add_packages_in(std::filesystem::path(std::getenv("CXLAB_SOURCE_DIR")) / "cx" / "interfaces"));
  const bus::MessageType& text = **registry_.message("std_msgs/msg/String");
  const auto join = [&](const char* name) {
    return bus_.join(bus::ParticipantKind::kNode, {name, "/", {}}, journal_.open_stream(name));
  };
  const bus::ParticipantId from = join("from"), to = join("to");
  const bus::EndpointId out = *bus_.advertise(from, "/text", text);
  ASSERT_TRUE(bus_.subscribe(to, "/text", text, [](const bus::Delivery&) {}));
  Loop played = loop();
  played.set_end(milliseconds(1000));
  ASSERT_TRUE(played.tick());
  ASSERT_EQ(played.next_tick(), milliseconds(1000));
  bus_.publish(out, std::make_shared<bus::Message>(text));
  EXPECT_EQ(played.next_tick(), kTick) << "the message waits";
  bus_.deliver(to);
  EXPECT_EQ(played.next_tick(), milliseconds(1000));
}

TEST_F(LoopTest, ALoopOfNothingCountsItsTicks) {
  Loop played(bus_, kTick, {});
  played.set_end(milliseconds(30));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(played.tick());
  EXPECT_EQ(played.now(), milliseconds(60)) << "0, 40 (where the end falls), and the one after";
  EXPECT_EQ(played.ticks(), 3);
  EXPECT_EQ(bus_.now(), milliseconds(60));
  EXPECT_THAT(calls_.take(), IsEmpty());
}

}  // namespace
}  // namespace cxlab
