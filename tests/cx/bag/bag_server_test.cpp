// A bag on the bus: what comes when, what is left out, and how calls and goals of agents are answered.

#include "cx/bag/bag_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cx/base/number_text.h"
#include "tests/support/bag_writer.h"
#include "tests/support/bus_test.h"

namespace cxlab::bag {

namespace {

using bus::Delivery;
using bus::EndpointId;
using bus::ParticipantId;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kString = "std_msgs/msg/String";
constexpr const char* kSetBool = "std_srvs/srv/SetBool";
constexpr const char* kFibonacci = "example_interfaces/action/Fibonacci";

class BagServerTest : public bus::BusTest {
 protected:
  void SetUp() override {
    BusTest::SetUp();
    world_ = node("world");
  }
  BagWriter& bag() {
    if (!writer_) writer_.emplace(folder_.path() / "floor.mcap", registry_);
    return *writer_;
  }
  Status create(BagSpec spec = {}) {
    if (writer_) writer_->close();
    auto recording = Recording::open(folder_.path() / "floor.mcap");
    if (!recording) return recording.error();
    BagSetup setup{
        .spec = std::move(spec), .recording = *std::move(recording), .managers = {"/clips_manager"}, .log = {}};
    if (beside_) setup.beside = {*beside_};
    setup.log = [this](bool warning, const std::string& text) { (warning ? warnings_ : lines_).push_back(text); };
    auto server = BagServer::create(std::move(setup), bus_, sink_);
    if (!server) return server.error();
    server_ = *std::move(server);
    agent_ = environment("agent");
    return {};
  }
  void open(BagSpec spec = {}) {
    const Status created = create(std::move(spec));
    ASSERT_TRUE(created) << created.error().text();
  }
  /// Plays the ticks up to that time; what the agent takes is logged with its time.
  void play(double until) {
    for (; now_ <= from_seconds(until); now_ += kTick) {
      bus_.begin_tick(now_);
      const Status s = server_->sense(now_);
      ASSERT_TRUE(s) << s.error().text();
      bus_.deliver(agent_);
      ASSERT_TRUE(server_->act(now_));
    }
  }
  void note(const std::string& text) { log_.push_back(general_text(to_seconds(bus_.now()), 6) + ' ' + text); }
  void hear(const std::string& topic) {
    const auto made = bus_.subscribe(agent_, topic, *string_, [this, topic](const Delivery& d) {
      note(topic + ' ' + d.message->view().text("data"));
    });
    ASSERT_TRUE(made) << made.error().text();
  }
  void texts(const std::string& topic, std::initializer_list<double> times) {
    for (const double t : times) bag().message(t, topic, kString, "{data: '" + general_text(t, 6) + "'}");
  }

  static constexpr SimTime kTick = std::chrono::milliseconds(100);
  TempFolder folder_;
  std::optional<BagWriter> writer_;
  std::unique_ptr<BagServer> server_;
  ParticipantId world_{}, agent_{};
  std::optional<ParticipantId> beside_;
  std::vector<std::string> lines_, warnings_;
};

// --- When

TEST_F(BagServerTest, MessagesComeAtTheFirstTickThatIsNotBeforeTheirTime) {
  texts("/a", {0, 0.1, 0.15, 0.151, 3});
  open();
  hear("/a");
  play(4);
  EXPECT_THAT(taken(), ElementsAre("0 /a 0", "0.1 /a 0.1", "0.2 /a 0.15", "0.2 /a 0.151", "3 /a 3"));
  EXPECT_EQ(server_->next_due(), kNever);
}

TEST_F(BagServerTest, StartOffsetAndRateMoveTheTimes) {
  texts("/a", {0, 10, 11, 14});
  open({.start_s = 10, .offset_s = 2, .rate = 2});
  EXPECT_EQ(server_->next_due(), from_seconds(2));
  hear("/a");
  play(5);
  EXPECT_THAT(taken(), ElementsAre("2 /a 10", "2.5 /a 11", "4 /a 14"));
  EXPECT_EQ(end_of(*Recording::open(folder_.path() / "floor.mcap"), {.start_s = 10, .offset_s = 2, .rate = 2}),
            from_seconds(4));
}

TEST_F(BagServerTest, StartBehindTheEndIsAWarning) {
  texts("/a", {0, 1});
  open({.start_s = 5});
  play(1);
  EXPECT_THAT(warnings_, ElementsAre("floor.mcap: the bag has no message after its start at 5 s"));
  const auto recording = Recording::open(folder_.path() / "floor.mcap");
  ASSERT_TRUE(recording);
  EXPECT_EQ(end_of(*recording, {.start_s = 5, .offset_s = 2}), from_seconds(2)) << "nothing comes";
  EXPECT_EQ(end_of(*recording, {.start_s = 0.25, .offset_s = 2}), from_seconds(2.75));
}

TEST_F(BagServerTest, TopicsOfAManagerAreLeftOutButNotThoseOfOneWithALongerName) {
  texts("/clips_manager/state", {0});
  texts("/clips_manager2/state", {0});
  open();
  hear("/clips_manager/state");
  hear("/clips_manager2/state");
  play(0.2);
  ASSERT_EQ(log_.size(), 1U);
  EXPECT_THAT(log_[0], HasSubstr("/clips_manager2/state 0"));
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("left out: /clips_manager/state (it belongs to /clips_manager)")));
}

TEST_F(BagServerTest, MessageThatWasKeptComesToWhoSubscribesLate) {
  bag().message(0, "/map", kString, "{data: old}", kTransientLocal);
  bag().message(1, "/map", kString, "{data: new}", kTransientLocal);
  bag().message(1, "/other", kString, "{data: lost}");
  bag().message(9, "/map", kString, "{data: last}", kTransientLocal);
  open({.start_s = 2, .offset_s = 1});
  EXPECT_EQ(server_->next_due(), from_seconds(1));
  play(3);
  hear("/map");
  hear("/other");
  play(8);
  EXPECT_THAT(taken(), ElementsAre("3.1 /map new", "8 /map last"));
}

// --- What is left out

TEST_F(BagServerTest, TopicThatTheRunPublishesIsLeftOut) {
  texts("/a", {0, 1, 2});
  texts("/of_world", {0, 1, 2});
  open();
  hear("/a");
  hear("/of_world");
  ASSERT_TRUE(bus_.advertise(world_, "/of_world", *string_));
  play(0.9);
  EXPECT_THAT(taken(), ElementsAre("0 /a 0"));
  ASSERT_EQ(lines_.size(), 1U);
  EXPECT_THAT(lines_[0], HasSubstr("; 1 topic is played; left out: /of_world (/world publishes it in this run)"));
  ASSERT_TRUE(bus_.advertise(agent_, "/a", *string_));  // its rules open it only now
  play(3);
  EXPECT_THAT(taken(), IsEmpty());
  EXPECT_THAT(lines_, Contains("/a is left out from now on: /agent publishes it in this run"));
}

TEST_F(BagServerTest, OwnPlaysItAllTheSame) {
  texts("/a", {0, 1});
  open({.own = true});
  hear("/a");
  ASSERT_TRUE(bus_.advertise(agent_, "/a", *string_));
  play(2);
  EXPECT_THAT(taken(), ElementsAre("0 /a 0", "1 /a 1"));
}

TEST_F(BagServerTest, StimuliComeBesideTheBag) {
  texts("/a", {0, 1});
  beside_ = node("stimuli");
  open();
  hear("/a");
  const auto publisher = bus_.advertise(*beside_, "/a", *string_);
  play(0.5);
  bus_.publish(*publisher, text("by hand"));
  play(2);
  EXPECT_THAT(taken(), ElementsAre("0 /a 0", "0.6 /a by hand", "1 /a 1"));
}

TEST_F(BagServerTest, FiltersLookForTheExpressionAnywhereInTheName) {
  for (const char* topic : {"/robot1/a", "/robot1/b", "/robot2/a", "/rosout", "/clips_manager/x"}) texts(topic, {0});
  open({.topics = "a$|rosout|clips", .exclude = "2/"});
  for (const char* topic : {"/robot1/a", "/robot1/b", "/robot2/a", "/rosout", "/clips_manager/x"}) hear(topic);
  play(1);
  EXPECT_THAT(taken(), ElementsAre("0 /robot1/a 0"));
  ASSERT_EQ(lines_.size(), 1U);
  EXPECT_THAT(lines_[0], HasSubstr("1 topic is played; left out: /rosout (every run has its own), "
                                   "/clips_manager/x (it belongs to /clips_manager); 2 by the filters"));
}

TEST_F(BagServerTest, RemapsGiveOtherNames) {
  texts("/a", {0});
  texts("/b", {1});
  bag().service(0, "/s", kSetBool, Event::kResponseSent, 1, "{message: there}");
  open({.remap = {{"/a", "/x"}, {"/s", "/t"}}});
  for (const char* topic : {"/a", "/b", "/x"}) hear(topic);
  const auto client = *bus_.create_client(agent_, "/t", *set_bool_,
                                          [this](const Delivery& d) { note(d.message->view().text("message")); });
  bus_.call(client, blank(*set_bool_->request));
  play(2);
  EXPECT_THAT(taken(), ElementsAre("0 /x 0", "0.1 there", "1 /b 1"));
}

TEST_F(BagServerTest, TypesThatNobodyKnowsAreNamed) {
  bag().bytes(0, "/new", "my_msgs/msg/New", "int8 a\n", std::string("\0\1\0\0\5", 5));
  bag().bytes(0, "/ask/_service_event", "my_msgs/srv/Ask_Event", "", std::string(60, '\0'));
  bag().bytes(0, "/do/_action/feedback", "my_msgs/action/Do_FeedbackMessage", "", std::string(60, '\0'));
  open();
  play(1);
  EXPECT_THAT(warnings_,
              ElementsAre("floor.mcap: left out, because no package of this run has the type: /new "
                          "(my_msgs/msg/New), /ask/_service_event (my_msgs/srv/Ask), /do (my_msgs/action/Do)"));
  EXPECT_EQ(server_->warnings(), warnings_);
}

TEST_F(BagServerTest, TypeThatDiffersIsAnErrorThatNamesTheField) {
  bag().bytes(0, "/a", kString, "wstring data\n", std::string("\0\1\0\0\0\0\0\0", 8));
  const Status created = create();
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error().kind, ErrorKind::kInput);
  EXPECT_THAT(
      created.error().text(),
      HasSubstr("floor.mcap: /a has type std_msgs/msg/String, and field 1 of std_msgs/String is 'wstring data' in "
                "the bag and 'string data' in the workspace; "));
  writer_.reset();
  bag().bytes(0, "/a", kString, "wstring data\n", std::string("\0\1\0\0\0\0\0\0", 8));
  open({.exclude = "^/a$"});
}

TEST_F(BagServerTest, BytesThatAreNotOfTheTypeEndTheRun) {
  texts("/a", {0});
  bag().bytes(1.5, "/b", kString, "string data\n", std::string("\0\1\0\0\xff\xff\xff\xff", 8));
  open();
  hear("/a");
  hear("/b");
  play(1);
  bus_.begin_tick(from_seconds(1.5));
  const Status s = server_->sense(from_seconds(1.5));
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_THAT(s.error().text(),
              ::testing::MatchesRegex(".*floor.mcap: the message of /b at 1.5 s \\(byte [0-9]+\\): field "
                                      "'data': found the end of the bytes, at byte 8"));
}

TEST_F(BagServerTest, NothingIsDecodedThatNobodyHears) {
  bag().bytes(0, "/a", kString, "string data\n", "no CDR");
  open();
  play(1);
}

TEST(BagSpecTest, ValuesThatNobodyCanPlayAreErrors) {
  const auto error = [](const BagSpec& spec) {
    const Status s = validate(spec);
    return s ? std::string("none") : s.error().message;
  };
  EXPECT_EQ(error({}), "none");
  EXPECT_EQ(error({.start_s = -1}), "start_s: found -1, expected s from 0 to 1e9");
  EXPECT_EQ(error({.offset_s = 1e10}), "offset_s: found 1e+10, expected s from 0 to 1e9");
  EXPECT_EQ(error({.rate = 0}), "rate: found 0, expected a number from 0.001 to 1000");
  EXPECT_THAT(error({.topics = "("}), HasSubstr("topics: found '(', expected a regular expression (ECMAScript)"));
  EXPECT_THAT(error({.exclude = "["}), HasSubstr("exclude: found '['"));
  EXPECT_THAT(error({.remap = {{"/a b", "/c"}}}), HasSubstr("remap: "));
}

// --- Services

class BagServices : public BagServerTest {
 protected:
  void call(bool data = false) {
    if (!client_)
      client_ = *bus_.create_client(agent_, "/s", *set_bool_, [this](const Delivery& d) {
        note(std::to_string(d.request_id) + ' ' + d.message->view().text("message"));
      });
    bus::Message request(*set_bool_->request);
    request->set("data", data);
    bus_.call(*client_, std::make_shared<bus::Message>(std::move(request)));
  }
  void exchange(double asked, double answered, std::int64_t number, const std::string& message, Event request,
                Event response) {
    bag().service(asked, "/s", kSetBool, request, number, "{data: false}");
    bag().service(answered, "/s", kSetBool, response, number, "{message: " + message + "}");
  }
  void serve(ParticipantId p) {
    service_ = *bus_.serve(p, "/s", *set_bool_, [this](const Delivery& d) {
      note(d.message->view().integer("data") ? "asked true" : "asked false");
      bus_.respond(service_, d, blank(*set_bool_->response));
    });
  }
  std::optional<EndpointId> client_;
  EndpointId service_{};
};

TEST_F(BagServices, TheKthCallGetsTheKthResponseWhenItCame) {
  exchange(1, 1.5, 1, "one", Event::kRequestReceived, Event::kResponseSent);
  exchange(3, 3.5, 2, "two", Event::kRequestReceived, Event::kResponseSent);
  texts("/begin", {0});
  open();
  play(0.5);
  call();  // before its time: the answer comes when it came
  call();
  play(3);
  EXPECT_THAT(taken(), ElementsAre("1.5 1 one"));
  play(9);
  EXPECT_THAT(taken(), ElementsAre("3.5 2 two"));
  call();
  play(10);
  EXPECT_THAT(taken(), IsEmpty());
  EXPECT_THAT(server_->warnings(), ElementsAre("/s: 1 call of this run has no response in the bag"));
}

TEST_F(BagServices, LateCallIsAnsweredAtOnce) {
  exchange(0, 0.5, 1, "one", Event::kRequestSent, Event::kResponseReceived);
  exchange(0.6, 0.7, 2, "two", Event::kRequestSent, Event::kResponseReceived);
  open();
  play(2);
  call();
  play(2.2);
  EXPECT_THAT(taken(), ElementsAre("2.2 1 one"));
  call();
  play(3);
  EXPECT_THAT(taken(), ElementsAre("2.4 2 two"));
  EXPECT_THAT(server_->warnings(), IsEmpty());
}

TEST_F(BagServices, ResponsesBelongToTheirRequests) {
  // Two clients whose answers come in the other order.
  bag().service(0, "/s", kSetBool, Event::kRequestReceived, 1, "{data: false}", "one");
  bag().service(0.1, "/s", kSetBool, Event::kRequestReceived, 1, "{data: false}", "two");
  bag().service(1, "/s", kSetBool, Event::kResponseSent, 1, "{message: for two}", "two");
  bag().service(2, "/s", kSetBool, Event::kResponseSent, 1, "{message: for one}", "one");
  open();
  call();
  call();
  play(3);
  EXPECT_THAT(taken(), ElementsAre("1 2 for two", "2 1 for one"));
}

TEST_F(BagServices, EventsOfClientAndServerAreOneExchange) {
  for (const Event event : {Event::kRequestSent, Event::kRequestReceived})
    bag().service(0, "/s", kSetBool, event, 1, "{data: false}", event == Event::kRequestSent ? "client" : "other id");
  for (const Event event : {Event::kResponseSent, Event::kResponseReceived})
    bag().service(1, "/s", kSetBool, event, 1, "{message: one}",
                  event == Event::kResponseReceived ? "client" : "other id");
  open();
  call();
  call();
  play(3);
  EXPECT_THAT(taken(), ElementsAre("1 1 one")) << "one response, not two";
}

TEST_F(BagServices, RequestsOfTheClientAndResponsesOfTheServerAreMatchedInTheirOrder) {
  bag().service(0, "/s", kSetBool, Event::kRequestSent, 5, "{data: false}", "client");
  bag().service(1, "/s", kSetBool, Event::kResponseSent, 9, "{message: one}", "other id");
  bag().service(2, "/s", kSetBool, Event::kRequestSent, 6, "{data: false}", "client");
  bag().service(3, "/s", kSetBool, Event::kResponseSent, 10, "{message: two}", "other id");
  open();
  call();
  call();
  play(4);
  EXPECT_THAT(taken(), ElementsAre("1 1 one", "3 2 two"));
}

TEST_F(BagServices, AnotherRequestThanRecordedIsAWarning) {
  exchange(0, 1, 1, "one", Event::kRequestReceived, Event::kResponseSent);
  open();
  call(true);
  play(2);
  EXPECT_THAT(taken(), ElementsAre("1 1 one"));
  EXPECT_THAT(warnings_,
              ElementsAre("/s: call 1 of this run is not that of the recording: found {data: true}, recorded "
                          "{data: false}; it gets the recorded response"));
}

TEST_F(BagServices, AgentThatServesIsAsked) {
  exchange(1, 1.5, 1, "one", Event::kRequestReceived, Event::kResponseSent);
  texts("/begin", {0});
  open();
  serve(agent_);
  play(3);
  EXPECT_THAT(taken(), ElementsAre("1 asked false"));
  EXPECT_THAT(warnings_, IsEmpty()) << "the stand-in is no rival";
}

TEST_F(BagServices, ServiceOfTheWorldIsLeftOut) {
  exchange(1, 1.5, 1, "one", Event::kRequestReceived, Event::kResponseSent);
  texts("/begin", {0});
  serve(world_);
  open();
  call();
  play(0);
  bus_.deliver(world_);
  EXPECT_THAT(taken(), ElementsAre("0 asked false"));
  play(3);
  EXPECT_THAT(taken(), ElementsAre("0.1 1 "));
  EXPECT_THAT(lines_[0], HasSubstr("left out: /s (/world serves it in this run)"));
}

TEST_F(BagServices, ServiceThatAnAgentServesAndCallsIsLeftOut) {
  exchange(1, 1.5, 1, "one", Event::kRequestReceived, Event::kResponseSent);
  open();
  serve(agent_);
  call();
  play(3);
  EXPECT_THAT(lines_[0], HasSubstr("left out: /s (/agent serves it in this run, and /agent asks for it)"));
  EXPECT_THAT(taken(), ElementsAre("0 asked false", "0.1 1 "));
}

TEST_F(BagServices, EventsWithoutContentAreLeftOut) {
  bag().service_metadata(0, "/s", kSetBool, Event::kResponseSent);
  open();
  play(1);
  EXPECT_THAT(lines_[0], HasSubstr("left out: /s/_service_event (its events are without what was sent: service "
                                   "introspection was 'metadata', expected 'contents')"));
}

// --- Actions

class BagActions : public BagServerTest {
 protected:
  void send(int order = 3) {
    if (!client_) {
      bus::Bus::ActionClientHandlers handlers;
      handlers.goal_response = [this](const Delivery& d) { note(d.accepted ? "accepted" : "rejected"); };
      handlers.feedback = [this](const Delivery& d) { note("feedback " + d.message->view().to_string()); };
      handlers.result = [this](const Delivery& d) {
        note("result " + std::to_string(static_cast<int>(d.status)) + ' ' + d.message->view().to_string());
      };
      handlers.cancel_response = [this](const Delivery& d) { note("cancel " + std::to_string(d.return_code)); };
      client_ = *bus_.create_action_client(agent_, "/f", *fibonacci_, std::move(handlers));
    }
    bus::Message goal(*fibonacci_->goal);
    goal->set("order", order);
    goal_ = bus_.send_goal(*client_, std::make_shared<bus::Message>(std::move(goal)));
  }
  /// A whole goal with introspection: taken a tenth of a second later, feedback after a second, its result after two.
  void whole_goal(double s, char id, std::int64_t number, int status = 4) {
    bag().goal(s, "/f", kFibonacci, number, id, "{order: 3}");
    bag().goal_answer(s + 0.1, "/f", kFibonacci, number, true);
    bag().result_asked(s + 0.2, "/f", kFibonacci, 100 + number, id);
    bag().status(s + 0.2, "/f", {{id, 2}}, s);
    bag().feedback(s + 1, "/f", kFibonacci, id, "{sequence: [1]}");
    bag().status(s + 2, "/f", {{id, status}}, s);
    bag().result(s + 2, "/f", kFibonacci, 100 + number, status, "{sequence: [1, " + std::to_string(number) + "]}");
  }
  std::optional<EndpointId> client_;
  bus::GoalId goal_{};
};

TEST_F(BagActions, TheKthGoalMeetsWhatTheKthMet) {
  whole_goal(1, 'a', 1);
  whole_goal(5, 'b', 2, 6);
  texts("/begin", {0});
  open();
  play(0.5);
  send();
  play(4);
  EXPECT_THAT(taken(), ElementsAre("1.1 accepted", "2 feedback {sequence: [1]}", "3 result 4 {sequence: [1, 1]}"));
  play(6.5);
  send();  // when feedback has come already: it comes at once
  play(9);
  EXPECT_THAT(taken(), ElementsAre("6.7 accepted", "6.7 feedback {sequence: [1]}", "7 result 6 {sequence: [1, 2]}"));
  send();
  play(10);
  EXPECT_THAT(taken(), IsEmpty());
  EXPECT_THAT(server_->warnings(), ElementsAre("/f: 1 goal of this run has no answer in the bag"));
}

TEST_F(BagActions, LateGoalGetsTheLastFeedback) {
  bag().status(0, "/f", {{'a', 2}});
  bag().feedback(1, "/f", kFibonacci, 'a', "{sequence: [1]}");
  bag().feedback(2, "/f", kFibonacci, 'a', "{sequence: [2]}");
  bag().feedback(4, "/f", kFibonacci, 'a', "{sequence: [3]}");
  open();
  play(3);
  send();
  play(5);
  EXPECT_THAT(taken(), ElementsAre("3.2 accepted", "3.2 feedback {sequence: [2]}", "4 feedback {sequence: [3]}"));
}

TEST_F(BagActions, RejectedGoalIsRejected) {
  bag().goal(0, "/f", kFibonacci, 1, 'a', "{order: 3}");
  bag().goal_answer(1, "/f", kFibonacci, 1, false);
  whole_goal(2, 'b', 2);
  open();
  send();
  play(1.5);
  EXPECT_THAT(taken(), ElementsAre("1 rejected"));
  send();
  play(3);
  EXPECT_THAT(taken(), ElementsAre("2.1 accepted", "3 feedback {sequence: [1]}"));
}

TEST_F(BagActions, WithoutIntrospectionStatusTellsHowItWent) {
  bag().status(0, "/f", {});
  bag().status(1, "/f", {{'a', 2}}, 1);
  bag().feedback(2, "/f", kFibonacci, 'a', "{sequence: [1]}");
  bag().status(3, "/f", {{'a', 4}}, 1);
  bag().status(4, "/f", {{'a', 4}, {'b', 1}}, 4);
  bag().status(5, "/f", {{'a', 4}, {'b', 6}}, 4);
  open();
  send();
  send();
  play(6);
  EXPECT_THAT(taken(), ElementsAre("1 accepted", "2 feedback {sequence: [1]}", "3 result 4 {sequence: []}",
                                   "4 accepted", "5 result 6 {sequence: []}"));
  EXPECT_THAT(server_->warnings(),
              ElementsAre(HasSubstr("/f: the bag has no results of it, because service introspection")));
}

TEST_F(BagActions, GoalsFromBeforeTheBagAreLeftOut) {
  bag().feedback(0, "/g", kFibonacci, 'x', "{sequence: []}");
  bag().status(0.5, "/f", {{'o', 2}, {'d', 4}}, -3);
  bag().feedback(1, "/f", kFibonacci, 'o', "{sequence: [7]}");
  bag().status(2, "/f", {{'o', 4}, {'d', 4}, {'a', 2}}, 2);
  open();
  send();
  play(3);
  EXPECT_THAT(taken(), ElementsAre("2 accepted"));
}

TEST_F(BagActions, CanceledGoalEndsAsRecorded) {
  whole_goal(0, 'a', 1, 5);
  whole_goal(4, 'b', 2, 5);
  open();
  send();
  play(0.5);
  bus_.cancel_goal(*client_, goal_);
  play(3);
  EXPECT_THAT(taken(), ElementsAre("0.1 accepted", "0.7 cancel 0", "1 feedback {sequence: [1]}",
                                   "2 result 5 {sequence: [1, 1]}"));
  send();  // nobody cancels this one
  play(7);
  EXPECT_THAT(taken(), ElementsAre("4.1 accepted", "5 feedback {sequence: [1]}", "6 result 6 {sequence: [1, 2]}"));
  EXPECT_THAT(server_->warnings(),
              ElementsAre("/f: a goal that was canceled in the recording, and not in this run, is aborted"));
}

TEST_F(BagActions, AnotherGoalThanRecordedIsAWarning) {
  whole_goal(0, 'a', 1);
  open();
  send(8);
  play(3);
  EXPECT_THAT(warnings_, ElementsAre("/f: goal 1 of this run is not that of the recording: found {order: 8}, recorded "
                                     "{order: 3}; the bag answers it like the recorded one"));
}

TEST_F(BagActions, AgentThatServesGetsGoalsAndCancels) {
  whole_goal(1, 'a', 1);
  bag().cancel(1.5, "/f", 'a');
  texts("/begin", {0});
  open();
  EndpointId server{};
  server = *bus_.serve_action(agent_, "/f", *fibonacci_,
                              {[&](const Delivery& d) {
                                 note("goal " + d.message->view().to_string());
                                 bus_.answer_goal(server, d.goal, bus::GoalAnswer::kAccept);
                               },
                               [&](const Delivery& d) {
                                 note("cancel");
                                 bus_.answer_cancel(server, d, true);
                               }});
  play(4);
  EXPECT_THAT(taken(), ElementsAre("1 goal {order: 3}", "1.5 cancel"));
}

TEST_F(BagActions, ActionWhoseTypeTheBagDoesNotTellIsLeftOut) {
  bag().status(0, "/f", {{'a', 2}});
  open();
  play(1);
  EXPECT_THAT(lines_[0], HasSubstr("left out: /f/_action/status (the bag does not tell the type of the action"));
}

}  // namespace

}  // namespace cxlab::bag
