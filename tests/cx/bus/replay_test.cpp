// What the bus records, and the same records from a log.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::ElementsAre;

TEST_F(BusTest, PostsAreRecordedInTheSendersStreamWithTheirCauses) {
  const auto env = environment("env");
  const auto out = advertise(env, "t");
  const StreamId stream = bus_.stream_of(env);
  const std::size_t before = sink_.of(stream).size();
  const RecordRef cause{stream, 0};
  tick();
  bus_.publish(out, text("x"), {&cause, 1});
  ASSERT_EQ(sink_.of(stream).size(), before + 1);
  const KeptRecords::Record record = sink_.of(stream).back();
  RecordData expected;
  expected.begin()
      .field("op", "publish")
      .field("name", "/t")
      .field("seq", 1)
      .name("msg")
      .open_map(1)
      .text_key("data")
      .value(std::string_view("x"));
  EXPECT_EQ(record.data, expected.bytes());
  EXPECT_EQ(record.t, now_);
  EXPECT_EQ(record.kind, RecordKind::kBus);
  ASSERT_EQ(record.causes.size(), 1u);
}

TEST_F(BusTest, ADeliveryNamesTheRecordOfItsPost) {
  const auto server = node("server"), env = environment("env");
  const auto out = advertise(server, "t");
  RecordRef cause;
  subscribe(env, "t", [&](const Delivery& d) { cause = d.cause; });
  bus_.publish(out, text("x"));
  bus_.deliver(env);
  EXPECT_EQ(cause.stream, bus_.stream_of(server));
  EXPECT_EQ(cause.n, sink_.of(bus_.stream_of(server)).size() - 1);
}

/// Writes down what each participant takes.
struct Tap : InputTap {
  std::vector<std::pair<ParticipantId, std::vector<Delivery>>> log;
  void delivered(ParticipantId to, const std::vector<Delivery>& deliveries) override {
    log.emplace_back(to, deliveries);
  }
};

TEST_F(BusTest, TheTapSeesWhatIsTakenBeforeTheHandlersDo) {
  const auto server = node("server"), env = environment("env");
  Tap tap;
  bus_.set_input_tap(&tap);
  const auto out = advertise(server, "t");
  subscribe(env, "t", [&](const Delivery&) { log_.push_back(std::to_string(tap.log.size())); });
  bus_.deliver(env);
  EXPECT_TRUE(tap.log.empty());
  bus_.publish(out, text("a"));
  bus_.publish(out, text("b"));
  EXPECT_THAT(deliver(env), ElementsAre("a", "1", "b", "1"));
  ASSERT_EQ(tap.log.size(), 1u);
  EXPECT_EQ(tap.log[0].first, env);
  EXPECT_EQ(tap.log[0].second.size(), 2u);
}

/// An environment that repeats what it hears, asks a service and serves one.
class Echo {
 public:
  Echo(Bus& bus, const Registry&, ParticipantId p, const MessageType& string, const ServiceType& service,
       const ActionType& action)
      : bus_(bus), service_type_(service), action_type_(action) {
    out_ = *bus.advertise(p, "out", string);
    if (!bus.subscribe(p, "in", string, [this](const Delivery& d) { hear(d); })) std::abort();
    client_ = *bus.create_client(p, "theirs", service, [](const Delivery&) {});
    service_ = *bus.serve(p, "own", service, [this](const Delivery& d) {
      bus_.respond(service_, d, std::make_shared<Message>(*service_type_.response));
    });
    server_ = *bus.serve_action(p, "act", action,
                                {[this](const Delivery& d) { bus_.answer_goal(server_, d.goal, GoalAnswer::kAccept); },
                                 [this](const Delivery& d) {
                                   bus_.answer_cancel(server_, d, true);
                                   bus_.finish(server_, d.goal, GoalStatus::kCanceled,
                                               std::make_shared<Message>(*action_type_.result));
                                 }});
    goals_ = *bus.create_action_client(p, "others", action, {});
  }

 private:
  void hear(const Delivery& d) {
    bus_.publish(out_, d.message, {&d.cause, 1});
    bus_.call(client_, std::make_shared<Message>(*service_type_.request));
    bus_.send_goal(goals_, std::make_shared<Message>(*action_type_.goal));
    bus_.cancel_all_goals(goals_);
  }
  Bus& bus_;
  const ServiceType& service_type_;
  const ActionType& action_type_;
  EndpointId out_{}, client_{}, service_{}, server_{}, goals_{};
};

TEST_F(BusTest, AMutedBusFedFromTheLogWritesTheSameRecords) {
  const auto server = node("server"), env = environment("env");
  Echo echo(bus_, registry_, env, *string_, *set_bool_, *fibonacci_);
  Tap tap;
  bus_.set_input_tap(&tap);
  const auto in = advertise(server, "in");
  const auto client = *bus_.create_client(server, "own", *set_bool_, nullptr);
  const auto goals = *bus_.create_action_client(server, "act", *fibonacci_, {});
  std::vector<std::pair<SimTime, std::size_t>> ticks;
  for (int i = 0; i < 4; ++i) {
    tick();
    bus_.publish(in, text("hello " + std::to_string(i)));
    bus_.call(client, blank(*set_bool_->request));
    bus_.send_goal(goals, blank(*fibonacci_->goal));
    if (i == 2) bus_.cancel_all_goals(goals);
    bus_.deliver(env);
    ticks.emplace_back(now_, tap.log.size());
  }

  KeptRecords sink;
  sink.open_stream("server");
  Bus replay(registry_, sink);
  replay.mute(true);
  const auto again = replay.join(ParticipantKind::kEnvironment, NodeName{"env", "/", {}},
                                 sink.open_stream("env"));  // other index: no server here
  Echo same(replay, registry_, again, *string_, *set_bool_, *fibonacci_);
  std::size_t next = 0;
  for (const auto& [t, end] : ticks) {
    replay.begin_tick(t);
    for (; next < end; ++next)
      if (tap.log[next].first == env) replay.inject(again, tap.log[next].second);
  }
  EXPECT_EQ(sink.text(replay.stream_of(again)), sink_.text(bus_.stream_of(env)));
  EXPECT_FALSE(replay.any_waiting());
}

TEST_F(BusTest, OthersDoNotMoveAParticipantsRecords) {
  const auto run = [&](bool with_others) {
    KeptRecords sink;
    Bus bus(registry_, sink);
    if (with_others) {
      const auto other = bus.join(ParticipantKind::kEnvironment, NodeName{"other", "/", {}}, sink.open_stream("other"));
      const auto out = *bus.advertise(other, "elsewhere", *string_);
      bus.publish(out, text("noise"));
      bus.call(*bus.create_client(other, "nobody", *set_bool_, nullptr), blank(*set_bool_->request));
    }
    const StreamId stream = sink.open_stream("env");
    const auto env = bus.join(ParticipantKind::kEnvironment, NodeName{"env", "/", {}}, stream);
    const auto out = *bus.advertise(env, "t", *string_);
    const auto goals = *bus.create_action_client(env, "a", *fibonacci_, {});
    for (int i = 0; i < 3; ++i) {
      bus.begin_tick(SimTime{i});
      bus.publish(out, text("x"));
      bus.send_goal(goals, blank(*fibonacci_->goal));
    }
    return sink.text(stream);
  };
  EXPECT_EQ(run(false), run(true));
}

TEST_F(BusTest, TwoBusesInterleavedDoNotNoticeEachOther) {
  const auto play = [&](Bus& bus, KeptRecords& sink, int step, std::vector<EndpointId>& ends) {
    if (step == 0) {
      const auto a = bus.join(ParticipantKind::kEnvironment, NodeName{"a", "/", {}}, sink.open_stream("a"));
      const auto b = bus.join(ParticipantKind::kNode, NodeName{"b", "/", {}}, sink.open_stream("b"));
      ends = {*bus.advertise(a, "t", *string_), *bus.advertise(b, "u", *string_)};
      if (!bus.subscribe(b, "t", *string_, [&bus, &ends](const Delivery& d) { bus.publish(ends[1], d.message); }))
        std::abort();
    }
    bus.begin_tick(SimTime{step});
    bus.publish(ends[0], text(std::to_string(step)));
    bus.deliver(ParticipantId{1});
  };
  KeptRecords alone, first, second;
  Bus bus_alone(registry_, alone), bus_first(registry_, first), bus_second(registry_, second);
  std::vector<EndpointId> ends_alone, ends_first, ends_second;
  for (int step = 0; step < 5; ++step) play(bus_alone, alone, step, ends_alone);
  for (int step = 0; step < 5; ++step) {
    play(bus_first, first, step, ends_first);
    play(bus_second, second, step, ends_second);
  }
  for (const StreamId stream : {StreamId{0}, StreamId{1}}) {
    EXPECT_EQ(first.text(stream), alone.text(stream));
    EXPECT_EQ(second.text(stream), alone.text(stream));
  }
}

}  // namespace
}  // namespace cxlab::bus
