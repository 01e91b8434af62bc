// Seats: agents that are programs, beside rules and alone.

#include "scenarios/seat.h"

#include <gmock/gmock.h>

#include "cx/journal/journal_reader.h"
#include "folder.h"
#include "lab/replay.h"
#include "lab/rerun.h"

namespace cxlab::lab {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

/// An agent of a test: what it does when it is made and in each turn.
struct Script {
  std::function<Status(SeatBus&)> made = [](SeatBus&) { return Status(); };
  std::function<Status(SeatBus&)> perceive = made, decide = made, act = made;
  SimTime period = 100ms;
};

class Scripted final : public Agent {
 public:
  Scripted(SeatBus& bus, Script script) : bus_(bus), script_(std::move(script)) {}
  Status perceive() override { return script_.perceive(bus_); }
  Status decide(SimTime now) override {
    if (now < due_) return {};
    due_ = now + script_.period;
    return script_.decide(bus_);
  }
  Status act() override { return script_.act(bus_); }
  SimTime next_due() const override { return due_; }

 private:
  SeatBus& bus_;
  Script script_;
  SimTime due_{};
};

Seat seat(const std::string& name, Script script) {
  return {name, [script = std::move(script)](SeatBus& bus) -> Expected<std::unique_ptr<Agent>> {
            if (Status s = script.made(bus); !s) return s.error();
            return std::unique_ptr<Agent>(std::make_unique<Scripted>(bus, script));
          }};
}

/// Hears numbers, answers each with its double, and serves the state of a switch.
constexpr const char* kDoubling = R"(
(defrule open
  (start)
  =>
  (ros-msgs-create-subscription "number" "std_msgs/msg/Int64")
  (ros-msgs-create-publisher "double" "std_msgs/msg/Int64")
  (ros-msgs-create-service "switch" "std_srvs/srv/SetBool"))
(deffacts start (start))
(defrule double
  ?heard <- (ros-msgs-message (topic "number") (msg-ptr ?msg))
  =>
  (bind ?number (ros-msgs-get-field ?msg "data"))
  (assert (heard ?number))
  (bind ?answer (ros-msgs-create-message "std_msgs/msg/Int64"))
  (ros-msgs-set-field ?answer "data" (* 2 ?number))
  (ros-msgs-publish ?answer "double")
  (ros-msgs-destroy-message ?answer)
  (ros-msgs-destroy-message ?msg)
  (retract ?heard))
)";

class SeatsTest : public FolderTest {
 protected:
  SeatsTest() {
    scenario("game", kDoubling, {"ros_msgs"});
    write("canvas.yaml", "schema: 1\nworld: {kind: turtlesim}\nduration_s: 3\n");
    write("timed.yaml", "schema: 1\nworld: {kind: rcll}\ntier: timed\nduration_s: 60\n");
  }

  PlayOptions options(const std::string& out, std::vector<Seat> seats) const {
    PlayOptions options{.out = path(out).string()};
    options.spec.journal = JournalLevel::kFull;
    options.seats = std::move(seats);
    return options;
  }
  Played play(const std::string& name, const std::string& out, std::vector<Seat> seats) const {
    return FolderTest::play(name, options(out, std::move(seats)));
  }
  std::string refusal(std::vector<Seat> seats) const {
    const Played played = play("game", "refused", std::move(seats));
    std::filesystem::remove_all(path("refused"));
    return played.failure ? played.failure->text() : "none";
  }
  /// Both halves play again without the program, and the whole run does.
  void plays_again(const std::string& folder, const std::vector<std::string>& streams) const {
    const lab::Run then = run(folder);
    const auto rules = replay_rules(then);
    ASSERT_TRUE(rules) << rules.error().text();
    EXPECT_TRUE(rules->agrees()) << rules->first_difference;
    EXPECT_EQ(rules->same, streams);
    if (then.physics_hash) {
      const auto physics = replay_physics(then);
      ASSERT_TRUE(physics) << physics.error().text();
      EXPECT_TRUE(physics->agrees()) << physics->first_difference;
    }
    const auto again = rerun(then, {.out = path(folder + "_again").string()});
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_THAT(again->differ, IsEmpty()) << (again->first.empty() ? "" : again->first.front());
    EXPECT_EQ(read(folder + "_again/journal.jsonl"), read(folder + "/journal.jsonl"));
    EXPECT_EQ(read(folder + "_again/inputs.bin"), read(folder + "/inputs.bin"));
  }

  /// What of the bus a stream has in the journal.
  std::vector<std::string> operations(const std::string& folder, const std::string& stream) const {
    std::vector<std::string> out;
    const auto records = read_journal(path(folder + "/journal.jsonl"), {.stream = stream});
    EXPECT_TRUE(records) << (records ? "" : records.error().text());
    for (const JournalRecord& record : *records)
      if (!record.data.text("op").empty()) out.emplace_back(record.data.text("op"));
    return out;
  }
  /// Publishes 1, 2, ... and remembers what comes back.
  Script counting() {
    Script script;
    script.made = [this](SeatBus& bus) {
      count_ = 0;
      doubles_.clear();
      return bus.read("double", "std_msgs/msg/Int64",
                      [this](const bus::MessageView& message) { doubles_.push_back(message.integer("data")); });
    };
    script.decide = [this](SeatBus& bus) {
      return bus.publish("number", "std_msgs/msg/Int64", "{data: " + std::to_string(++count_) + "}");
    };
    script.period = 300ms;
    return script;
  }
  int count_ = 0;
  std::vector<std::int64_t> doubles_;
};

TEST_F(SeatsTest, AProgramAndRulesTalk) {
  const Played played = play("game", "run", {seat("counter", counting())});
  ASSERT_FALSE(played.failure) << played.failure->text();
  EXPECT_THAT(doubles_, ElementsAre(2, 4, 6, 8, 10, 12, 14));
  EXPECT_FALSE(played.result.deterministic) << "a program took part";
  EXPECT_THAT(read("run/manifest.json"), HasSubstr("\"counter\""));
  plays_again("run", {"env/main"});
}

TEST_F(SeatsTest, TheSameProgramGivesTheSameBytes) {
  play("game", "one", {seat("counter", counting())});
  play("game", "two", {seat("counter", counting())});
  EXPECT_EQ(read("one/journal.jsonl"), read("two/journal.jsonl"));
  EXPECT_EQ(read("one/inputs.bin"), read("two/inputs.bin"));
  Script other = counting();
  other.period = 500ms;
  play("game", "three", {seat("counter", other)});
  EXPECT_NE(read("one/journal.jsonl"), read("three/journal.jsonl"));
}

TEST_F(SeatsTest, InStepsOfAnyLengthItIsTheSameRun) {
  play("game", "whole", {seat("counter", counting())});
  for (const SimTime length : {1ns, 7'000'001ns, 100'000'000ns, 333'333'333ns, 5'000'000'000ns}) {
    std::filesystem::remove_all(path("steps"));
    auto session = Session::load(options("steps", {seat("counter", counting())}), loaded("game"));
    ASSERT_TRUE(session) << session.error().text();
    std::int64_t ticks = 0;
    bool over = false;
    for (SimTime t = length; !over; t = std::max(t + length, length < 1ms ? (*session)->episode().next_tick() : t)) {
      const auto step = (*session)->step(t);
      ASSERT_TRUE(step) << step.error().text();
      EXPECT_LE(step->now, t);
      EXPECT_TRUE(step->over || (*session)->episode().next_tick() > t);
      ticks += step->ticks;
      over = step->over;
    }
    const Played played = (*session)->close();
    EXPECT_FALSE(played.failure);
    EXPECT_EQ(played.result.ticks, ticks);
    EXPECT_EQ(read("steps/journal.jsonl"), read("whole/journal.jsonl")) << length.count();
    EXPECT_EQ(read("steps/inputs.bin"), read("whole/inputs.bin")) << length.count();
  }
}

TEST_F(SeatsTest, WhatIsSentBetweenStepsGoesOutInTheNextTick) {
  SeatBus* outside = nullptr;
  Script script = counting();
  script.made = [&outside, made = script.made](SeatBus& bus) {
    outside = &bus;
    return made(bus);
  };
  script.decide = [](SeatBus&) { return Status(); };
  auto session = Session::load(options("run", {seat("hand", script)}), loaded("game"));
  ASSERT_TRUE(session) << session.error().text();
  for (const SimTime t : {500ms, 1000ms}) {
    ASSERT_TRUE((*session)->step(t));
    ASSERT_TRUE(outside->publish("number", "std_msgs/msg/Int64", "{data: " + std::to_string(t / 1ms) + "}"));
  }
  const auto step = (*session)->step(1500ms);
  ASSERT_TRUE(step);
  EXPECT_FALSE(step->over);
  EXPECT_EQ((*session)->close().result.status, RunStatus::kStopped);
  EXPECT_THAT(doubles_, ElementsAre(1000, 2000));
  plays_again("run", {"env/main"});
}

TEST_F(SeatsTest, ServicesAndActionsAnswerAProgram) {
  std::vector<std::string> heard;
  Script script;
  script.made = [&heard](SeatBus& bus) {
    heard.clear();
    auto request = bus.make("turtlesim/srv/Spawn");
    if (!request) return Status(request.error());
    request->view().set("x", 2.0).set("y", 3.0).set("name", "other");
    return bus.call("spawn", "turtlesim/srv/Spawn", *std::move(request),
                    [&heard](const bus::MessageView& response) { heard.push_back(response.text("name")); });
  };
  int turns = 0;
  script.period = 1s;
  script.decide = [&heard, &turns](SeatBus& bus) -> Status {
    if (++turns % 4 != 2) return {};
    const GoalReaders readers{
        .answer = [&heard](bool accepted) { heard.push_back(accepted ? "accepted" : "rejected"); },
        .result = [&heard](bool succeeded,
                           const bus::MessageView&) { heard.push_back(succeeded ? "succeeded" : "ended"); }};
    for (const char* turtle : {"turtle1", "other"}) {
      const auto goal = bus.send_goal(std::string(turtle) + "/rotate_absolute", "turtlesim/action/RotateAbsolute",
                                      turtle[0] == 't' ? "{theta: 0.5}" : "{theta: 3}", readers);
      if (!goal) return goal.error();
      if (turtle[0] == 'o')
        if (Status s = bus.cancel(*goal); !s) return s;
    }
    return {};
  };
  const Played played = play("canvas", "run", {seat("pilot", script)});
  ASSERT_FALSE(played.failure) << played.failure->text();
  EXPECT_THAT(heard, SizeIs(testing::Ge(5U)));
  EXPECT_EQ(heard.front(), "other");
  EXPECT_THAT(heard, AllOf(Contains("accepted").Times(2), Contains("succeeded").Times(1), Contains("ended").Times(1)));
  plays_again("run", {});
}

TEST_F(SeatsTest, AProgramPlaysATimedGameAlone) {
  bool arrived = false;
  Script script;
  script.made = [&arrived](SeatBus& bus) -> Status {
    arrived = false;
    const auto goal = bus.send_goal("/robot1/drive_to", "cxlab_skills/action/DriveTo", "{target: C_Z23}",
                                    {.result = [&arrived](bool succeeded, const auto&) { arrived = succeeded; }});
    return goal ? Status() : Status(goal.error());
  };
  script.period = kNever / 2;
  const Played played = play("timed", "run", {seat("driver", script)});
  ASSERT_FALSE(played.failure) << played.failure->text();
  EXPECT_TRUE(arrived);
  plays_again("run", {});
}

TEST_F(SeatsTest, SeveralSeatsActInTheirOrder) {
  const auto say = [](int number) {
    Script script;
    script.decide = [number](SeatBus& bus) {
      return bus.publish("number", "std_msgs/msg/Int64", "{data: " + std::to_string(number) + "}");
    };
    script.period = 1s;
    return script;
  };
  Script hears = counting();
  hears.decide = [](SeatBus&) { return Status(); };
  play("game", "run", {seat("b", say(7)), seat("a", say(3)), seat("ear", hears)});
  EXPECT_THAT(doubles_, ElementsAre(6, 14, 6, 14)) << "the fact that came last fires first";
  plays_again("run", {"env/main"});
}

TEST_F(SeatsTest, AnErrorOfTheProgramEndsTheRun) {
  for (const char* turn : {"perceive", "decide", "act"}) {
    Script script = counting();
    auto& failing = *turn == 'p' ? script.perceive : *turn == 'd' ? script.decide : script.act;
    failing = [before = failing, turn](SeatBus& bus) -> Status {
      if (bus.now() >= 1s) return input_error(std::string("no more in ") + turn);
      return before(bus);
    };
    const Played played = play("game", turn, {seat("counter", script)});
    ASSERT_TRUE(played.failure) << turn;
    EXPECT_EQ(played.failure->text(), std::string("seat counter: no more in ") + turn);
    const auto again = rerun(run(turn), {.out = path(std::string(turn) + "_again").string()});
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_THAT(again->differ, IsEmpty()) << turn;
    EXPECT_EQ(again->played.failure ? again->played.failure->text() : "none", played.failure->text());
    const auto rules = replay_rules(run(turn));
    ASSERT_TRUE(rules) << rules.error().text();
    EXPECT_TRUE(rules->agrees()) << turn << ": " << rules->first_difference;
  }
}

TEST_F(SeatsTest, AStepAfterAnErrorTellsItAgain) {
  Script script;
  script.decide = [](SeatBus& bus) { return bus.now() >= 1s ? Status(input_error("enough")) : Status(); };
  auto session = Session::load(options("run", {seat("s", script)}), loaded("game"));
  ASSERT_TRUE(session) << session.error().text();
  EXPECT_TRUE((*session)->step(500ms));
  for (int i = 0; i < 2; ++i) {
    const auto step = (*session)->step(2s);
    ASSERT_FALSE(step);
    EXPECT_EQ(step.error().text(), "seat s: enough");
  }
  EXPECT_EQ((*session)->close().result.status, RunStatus::kFailed);
}

TEST_F(SeatsTest, AWrongSeatIsRefused) {
  EXPECT_THAT(refusal({seat("", {})}), HasSubstr("expected letters, digits and '_'"));
  EXPECT_THAT(refusal({seat("a/b", {})}), HasSubstr("'a/b'"));
  EXPECT_THAT(refusal({seat("1a", {})}), HasSubstr("'1a'"));
  EXPECT_THAT(refusal({seat("twin", {}), seat("twin", {})}), HasSubstr("a node /twin already"));
  EXPECT_THAT(refusal({seat("clips_manager", {})}), HasSubstr("a node /clips_manager already"));
  EXPECT_THAT(refusal({{"empty", [](SeatBus&) { return std::unique_ptr<Agent>(); }}}), HasSubstr("found no agent"));
  EXPECT_THAT(refusal({{"none", nullptr}}), HasSubstr("found no agent"));
  Script script;
  script.made = [](SeatBus&) { return Status(input_error("no table is free")); };
  EXPECT_EQ(refusal({seat("late", script)}), "seat late: no table is free");
}

TEST_F(SeatsTest, AFaultOfAMessageIsReportedAtOnceAndNothingIsSent) {
  std::vector<std::string> errors;
  Script script;
  script.made = [&errors](SeatBus& bus) {
    const auto note = [&errors](const auto& done) { errors.push_back(done ? "none" : done.error().text()); };
    note(bus.publish("t", "no_such/msg/Type", ""));
    note(bus.publish("t", "std_msgs/msg/Int64", "{date: 1}"));
    note(bus.publish("t", "std_msgs/msg/Int64", "{data: x}"));
    note(bus.publish("", "std_msgs/msg/Int64", ""));
    note(bus.publish("t", "std_srvs/srv/Empty", ""));
    note(bus.publish("t", "std_msgs/msg/Int64", *bus.make("std_msgs/msg/String")));
    note(bus.publish("t", "std_msgs/msg/Int64", bus::Message()));
    note(bus.call("t", "std_msgs/msg/Int64", ""));
    note(bus.send_goal("t", "std_srvs/srv/Empty", ""));
    note(bus.cancel(SeatGoal{3}));
    note(bus.read("t", "std_msgs/msg/NoSuch", {}));
    return Status();
  };
  const Played played = play("game", "run", {seat("s", script)});
  EXPECT_FALSE(played.failure);
  EXPECT_THAT(errors,
              ElementsAre(HasSubstr("no_such"), HasSubstr("date"), HasSubstr("data"), HasSubstr("empty name"),
                          HasSubstr("expected that of a message"), HasSubstr("std_msgs/msg/String"),
                          HasSubstr("no type"), HasSubstr("expected that of a service"),
                          HasSubstr("expected that of an action"), HasSubstr("found goal 3"), HasSubstr("NoSuch")));
  EXPECT_THAT(errors, testing::Each(StartsWith("seat s: ")));
  EXPECT_THAT(operations("run", "seat/s"), ElementsAre("join"));
}

TEST_F(SeatsTest, ATypeThatTheTopicDoesNotHaveEndsTheRun) {
  Script script;
  script.decide = [](SeatBus& bus) { return bus.publish("number", "std_msgs/msg/String", "{data: a}"); };
  const Played played = play("game", "run", {seat("s", script)});
  ASSERT_TRUE(played.failure);
  EXPECT_THAT(played.failure->text(), AllOf(StartsWith("seat s: "), HasSubstr("number")));
}

TEST_F(SeatsTest, AnotherCourseOfARunWithAProgramIsRefused) {
  play("game", "run", {seat("counter", counting())});
  const auto again = rerun(run("run"), {.out = path("again").string(), .what_if = WhatIf{.at = 1, .facts = {"(a)"}}});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(again.error().text(), HasSubstr("seat counter"));
}

TEST_F(SeatsTest, ARunThatWasNotClosedCanBeAsked) {
  {
    auto session = Session::load(options("run", {seat("counter", counting())}), loaded("game"));
    ASSERT_TRUE(session);
    ASSERT_TRUE((*session)->step(1s));
    (*session)->episode().flush();
  }
  EXPECT_FALSE(run("run").finished);
  const auto seats = run("run").seats();
  ASSERT_TRUE(seats) << seats.error().text();
  ASSERT_THAT(*seats, SizeIs(1));
  EXPECT_EQ(seats->front().name, "counter");
}

}  // namespace
}  // namespace cxlab::lab
