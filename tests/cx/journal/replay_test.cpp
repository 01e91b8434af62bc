#include "cx/journal/replay.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <functional>
#include <utility>

#include "tests/support/files.h"

namespace cxlab {
namespace {

using bus::Delivery;
using bus::EndpointId;
using bus::Message;
using bus::ParticipantId;
using bus::ParticipantKind;
using std::chrono::milliseconds;
using testing::HasSubstr;

/// An environment that echoes what it hears, asks a service, sends a goal, and records all that it takes.
class Echo {
 public:
  Echo(bus::Bus& bus, Journal& journal, bool with_service = true)
      : bus_(bus), journal_(journal), stream_(journal.open_stream("env/echo")) {
    id = bus.join(ParticipantKind::kEnvironment, {"echo", "/", {}}, stream_);
    auto& types = bus.registry();
    const auto record = [this](const Delivery& d) { note(d); };
    const auto& text = **types.message("std_msgs/msg/String");
    out_ = *bus.advertise(id, "echo", text);
    (void)*bus.subscribe(id, "chatter", text, [this](const Delivery& d) {
      note(d);
      bus_.publish(out_, d.message, {&last_, 1});
    });
    if (with_service) client_ = *bus.create_client(id, "switch", **types.service("std_srvs/srv/SetBool"), record);
    actor_ = *bus.create_action_client(id, "count", **types.action("example_interfaces/action/Fibonacci"),
                                       {record, record, record, record});
  }

  void act() {
    Message request(*(*bus_.registry().service("std_srvs/srv/SetBool"))->request);
    request->set("data", true);
    if (client_) bus_.call(*client_, std::make_shared<Message>(request), {&last_, 1});
    Message goal(*(*bus_.registry().action("example_interfaces/action/Fibonacci"))->goal);
    goal->set("order", 3);
    bus_.send_goal(actor_, std::make_shared<Message>(goal), {&last_, 1});
  }

  ParticipantId id{};

 private:
  void note(const Delivery& d) {
    RecordData data;
    data.begin().field("kind", static_cast<int>(d.kind)).field("number", d.request_id).field("accepted", d.accepted);
    data.field("status", static_cast<int>(d.status))
        .field("stamp", d.stamp.count())
        .field("goal", bus::to_string(d.goal).c_str());
    data.field("goals", static_cast<std::uint64_t>(d.goals_canceling.size())).field("sequence", d.sequence);
    data.field("from", std::string_view(journal_.stream_name(bus_.stream_of(d.from))));
    if (d.message) d.message->view().record(data.name("message"));
    last_ = journal_.write(stream_, bus_.now(), RecordKind::kInput, data, {&d.cause, 1});
  }

  bus::Bus& bus_;
  Journal& journal_;
  StreamId stream_;
  EndpointId out_{}, actor_{};
  std::optional<EndpointId> client_;
  RecordRef last_;
};

/// A node with a topic, a service and an action.
class Server {
 public:
  Server(bus::Bus& bus, Journal& journal) : bus_(bus) {
    id = bus.join(ParticipantKind::kNode, {"server", "/", {}}, journal.open_stream("node/server"));
    auto& types = bus.registry();
    text_ = *types.message("std_msgs/msg/String");
    const auto& service = **types.service("std_srvs/srv/SetBool");
    const auto& action = **types.action("example_interfaces/action/Fibonacci");
    out_ = *bus.advertise(id, "chatter", *text_);
    service_ = *bus.serve(id, "switch", service, [this, &service](const Delivery& d) {
      bus_.respond(service_, d, std::make_shared<Message>(*service.response));
    });
    action_ = *bus.serve_action(id, "count", action,
                                {[this, &action](const Delivery& d) {
                                   bus_.answer_goal(action_, d.goal, bus::GoalAnswer::kAccept);
                                   bus_.publish_feedback(action_, d.goal, std::make_shared<Message>(*action.feedback));
                                   bus_.finish(action_, d.goal, bus::GoalStatus::kSucceeded,
                                               std::make_shared<Message>(*action.result));
                                 },
                                 nullptr});
  }

  void say(const std::string& word) {
    Message message(*text_);
    message->set("data", word);
    bus_.publish(out_, std::make_shared<Message>(message));
  }

  ParticipantId id{};

 private:
  bus::Bus& bus_;
  const bus::MessageType* text_ = nullptr;
  EndpointId out_{}, service_{}, action_{};
};

struct World {
  World() { EXPECT_TRUE(registry.add_packages_in(interfaces_dir()).ok()); }
  bus::Registry registry;
  Journal journal;
  bus::Bus bus{registry, journal};
};

constexpr int kTicks = 6;

/// Ticks of 20 ms: the server speaks at each but the last, the environment acts at the third.
std::string record_run(const std::filesystem::path& path) {
  World world;
  Server server(world.bus, world.journal);
  Echo echo(world.bus, world.journal);
  auto log = InputLogWriter::create(path);
  RecordingTap tap(world.bus, world.journal, *log);
  world.bus.set_input_tap(&tap);
  tap.watch(echo.id);
  for (int i = 0; i < kTicks; ++i) {
    world.bus.begin_tick(milliseconds(20) * i);
    if (i + 1 < kTicks) server.say("word " + std::to_string(i));
    world.bus.deliver(echo.id);
    log->add(LoggedResult{world.bus.now(), "env/echo", "read-line", std::to_string(i)});
    if (i == 2) echo.act();
    world.bus.deliver(server.id);
  }
  EXPECT_TRUE(log->close(SimTime{}).ok());
  return world.journal.stream_hash("env/echo");
}

class Replay : public testing::Test {
 protected:
  /// Replays `ticks` and returns the first difference.
  Status replay(World& world, Replayer& replayer, Echo& echo, int ticks = kTicks, bool ask = true) {
    world.bus.mute(true);
    for (int i = 0; i < ticks; ++i) {
      world.bus.begin_tick(milliseconds(20) * i);
      if (Status s = replayer.feed(echo.id); !s) return s;
      if (ask) {
        const auto line = replayer.next_result("env/echo", "read-line");
        if (!line) return line.error();
        EXPECT_EQ(*line, std::to_string(i));
      }
      if (i == 2) echo.act();
    }
    return replayer.all_used();
  }
  Replayer replayer_for(World& world) {
    return {*InputLogReader::open(temp_ / "inputs.bin"), world.bus, world.journal};
  }

  TempFolder temp_;
  std::string recorded_ = record_run(temp_ / "inputs.bin");
};

TEST_F(Replay, TheEnvironmentAloneEndsInTheSameHash) {
  World world;
  Echo echo(world.bus, world.journal);  // another index on the bus than with the server
  Replayer replayer = replayer_for(world);
  const Status status = replay(world, replayer, echo);
  EXPECT_TRUE(status.ok()) << status.error().text();
  EXPECT_EQ(world.journal.stream_hash("env/echo"), recorded_);
  EXPECT_EQ(replayer.end(), milliseconds(100) - SimTime{1}) << "the last tick may have had more";
  EXPECT_TRUE(replayer.log_status().ok());
}

TEST_F(Replay, AnEnvironmentIsKnownAsSenderBeforeItTakesAnything) {
  const auto play = [](World& world, ParticipantId late, const std::function<void()>& take) {
    const auto& text = **world.registry.message("std_msgs/msg/String");
    world.bus.publish(*world.bus.advertise(late, "chatter", text), std::make_shared<Message>(text));
    world.bus.begin_tick(SimTime{0});
    take();
    return world.journal.journal_hash();
  };
  const auto join = [](World& world) {
    return world.bus.join(ParticipantKind::kEnvironment, {"late", "/", {}}, world.journal.open_stream("env/late"));
  };
  World then;
  Echo first(then.bus, then.journal);
  const ParticipantId late = join(then);
  auto log = InputLogWriter::create(temp_ / "two.bin");
  RecordingTap tap(then.bus, then.journal, *log);
  then.bus.set_input_tap(&tap);
  tap.watch(first.id);
  const std::string recorded = play(then, late, [&] { EXPECT_EQ(then.bus.deliver(first.id), 1U); });
  ASSERT_TRUE(log->close(SimTime{}).ok());

  World now;
  Echo again(now.bus, now.journal);
  const ParticipantId late_again = join(now);
  Replayer replayer(*InputLogReader::open(temp_ / "two.bin"), now.bus, now.journal);
  now.bus.mute(true);
  replayer.watch(again.id);
  replayer.watch(late_again);
  EXPECT_EQ(play(now, late_again, [&] { EXPECT_TRUE(replayer.feed(again.id).ok()); }), recorded);
}

TEST_F(Replay, AnEndpointThatIsNotMadeIsADifference) {
  World world;
  Echo echo(world.bus, world.journal, /*with_service=*/false);
  Replayer replayer = replayer_for(world);
  const Status status = replay(world, replayer, echo);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().kind, ErrorKind::kNo);
  EXPECT_THAT(status.error().text(), HasSubstr("env/echo at 0.06 s: it has not made its endpoint 3"));
}

TEST_F(Replay, MessagesThatAreNotTakenAreADifference) {
  World world;
  Echo echo(world.bus, world.journal);
  Replayer replayer = replayer_for(world);
  world.bus.begin_tick(milliseconds(20));
  const Status status = replayer.feed(echo.id);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().text(), HasSubstr("env/echo at 0 s: then it took messages"));
}

TEST_F(Replay, AnEarlyEndIsADifference) {
  World world;
  Echo echo(world.bus, world.journal);
  Replayer replayer = replayer_for(world);
  const Status status = replay(world, replayer, echo, kTicks - 2);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().text(), HasSubstr("env/echo at 0.08 s: then it took messages"));
}

TEST_F(Replay, OtherQuestionsToTheOutsideAreADifference) {
  World world;
  Echo echo(world.bus, world.journal);
  Replayer replayer = replayer_for(world);
  EXPECT_THAT(replayer.next_result("env/echo", "mem-used").error().text(), HasSubstr("mem-used, then of read-line"));
  EXPECT_THAT(replayer.next_result("env/other", "read-line").error().text(), HasSubstr("then it did not"));
  const Status status = replay(world, replayer, echo, kTicks, /*ask=*/false);
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().text(), HasSubstr("then it asked for a result of read-line"));
}

TEST_F(Replay, ALogThatIsCutOffReplaysUpToThere) {
  const std::string bytes = content_of(temp_ / "inputs.bin");
  World world;
  Echo echo(world.bus, world.journal);
  auto reader = InputLogReader::from_bytes(bytes.substr(0, bytes.size() - 1), "inputs.bin");
  Replayer replayer(*reader, world.bus, world.journal);
  EXPECT_THAT(replayer.log_status().error().text(), HasSubstr("cut off"));
  EXPECT_LT(replayer.end(), kStarted) << "there was only one chunk";
}

}  // namespace
}  // namespace cxlab
