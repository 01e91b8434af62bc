// "Time and order" of docs/reference/contracts.md.

#include <algorithm>

#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

using TimeAndOrder = EpisodeTest;

constexpr const char* kClock = "(defrule clock (time ?t) => (println \"at \" ?t))\n";
constexpr const char* kOpen = "(deffacts start (open))\n";

/// Hears /word and prints it.
std::string hearer(const std::string& open = {}) {
  return kOpen +
         ("(defrule open (open) => (ros-msgs-create-subscription \"/word\" \"words/msg/Word\")" + open + ")\n") +
         "(defrule hear ?f <- (ros-msgs-message (msg-ptr ?m)) => (println \"heard \" (ros-msgs-get-field ?m \"text\"))"
         " (ros-msgs-destroy-message ?m) (retract ?f))\n";
}
/// Says a word at a time.
std::string speaker(const std::string& word, const std::string& t) {
  return "(defrule say (time " + t +
         ") => (bind ?m (ros-msgs-create-message \"words/msg/Word\"))"
         " (ros-msgs-set-field ?m \"text\" \"" +
         word + "\") (ros-msgs-publish ?m \"/word\") (println \"said " + word + "\"))\n";
}
const std::string kPublisher = "(ros-msgs-create-publisher \"/word\" \"words/msg/Word\")";

TEST_F(TimeAndOrder, RatesAreCountedNotAccumulated) {
  auto episode = load(scenario("rates", {{"ten", kClock, 10}, {"seven", kClock, 7}}, "duration_s: 20\n"));
  begin(*episode);
  EXPECT_THAT(log_.with("at "), IsEmpty()) << "no time before tick 0";
  play(*episode, 0.5);
  EXPECT_THAT(log_.with("ten: at "), ElementsAre("0.000 ten: at 0.0", "0.100 ten: at 0.1", "0.200 ten: at 0.2",
                                                 "0.300 ten: at 0.3", "0.400 ten: at 0.4", "0.500 ten: at 0.5"));
  EXPECT_THAT(log_.with("seven: at "),
              ElementsAre("0.000 seven: at 0.0", "0.160 seven: at 0.16", "0.300 seven: at 0.3", "0.440 seven: at 0.44"))
      << "k / 7, at the first tick not before";
  play(*episode, 20);
  EXPECT_THAT(log_.with("seven: at "), SizeIs(141));
  EXPECT_THAT(log_.with("seven: at 19.0"), ElementsAre("19.000 seven: at 19.0")) << "133 / 7 s is 19 s";
  EXPECT_THAT(log_.with("seven: at 20.0"), ElementsAre("20.000 seven: at 20.0"));
}

TEST_F(TimeAndOrder, ActivationComesBeforeTickZero) {
  auto episode =
      load(scenario("life", {{"a", "(deffacts f (go)) (defrule go (go) => (println \"first run at \" (now)))\n"}}));
  begin(*episode);
  EXPECT_THAT(log_.with("first run"), ElementsAre("0.000 a: first run at 0.0"));
  ASSERT_TRUE(episode->tick().ok());
  EXPECT_EQ(episode->now(), SimTime::zero()) << "tick 0 is at time 0";
}

TEST_F(TimeAndOrder, AllPerceiveThenAllDecideThenServersAct) {
  const std::string rules = hearer() + "(defrule clock (time 1.0) => (println \"decides\"))\n";
  const std::string service =
      "(deffunction /door-service-callback (?s ?q ?r) (println \"callback\") (ros-msgs-set-field ?r \"success\" "
      "TRUE))\n";
  auto episode = load(scenario("order",
                               {{"a", rules},
                                {"b", service + hearer("(ros-msgs-create-service \"/door\" \"std_srvs/srv/SetBool\")") +
                                          "(defrule clock (time 1.0) => (println \"decides\"))\n"}},
                               "stimuli:\n  - {at: 1, publish: /word, type: words/msg/Word, data: {text: w}}\n"
                               "  - {at: 1, call: /door, type: std_srvs/srv/SetBool}\n"));
  begin(*episode);
  play(*episode, 1);
  const auto lines = log_.with("1.000 ");
  ASSERT_THAT(lines, SizeIs(6)) << "what the stimuli post at 1 s arrives at 1 s, and so does the answer to them";
  EXPECT_EQ(lines.front(), "1.000 b: callback") << "b's callback comes before a's rules: first all perceive";
  EXPECT_THAT(std::vector(lines.begin() + 1, lines.begin() + 3),
              testing::UnorderedElementsAre("1.000 a: heard w", "1.000 a: decides"));
  EXPECT_THAT(std::vector(lines.begin() + 3, lines.begin() + 5),
              testing::UnorderedElementsAre("1.000 b: heard w", "1.000 b: decides"));
  EXPECT_EQ(lines.back().find("1.000 stimuli: /door: response"), 0u) << lines.back();
}

TEST_F(TimeAndOrder, EnvironmentsHearEachOtherAndThemselvesAtTheNextTick) {
  auto episode = load(scenario("talk", {{"a", hearer(kPublisher) + speaker("x", "1.0")}, {"b", hearer()}}));
  begin(*episode);
  play(*episode, 1.1);
  EXPECT_THAT(log_.with("1.0"), ElementsAre("1.000 a: said x", "1.020 a: heard x", "1.020 b: heard x"));
}

TEST_F(TimeAndOrder, SendersComeInTheirOrder) {
  auto episode =
      load(scenario("senders",
                    {{"c", hearer()},
                     {"a", kOpen + ("(defrule open (open) => " + kPublisher + ")\n") + speaker("from a", "1.0")},
                     {"b", kOpen + ("(defrule open (open) => " + kPublisher + ")\n") + speaker("from b", "1.0")}}),
           {}, "senders_run");
  begin(*episode);
  play(*episode, 1.1);
  (void)episode->close(RunStatus::kStopped);
  std::vector<std::string> heard;
  std::istringstream journal(read(folder_ / "senders_run/journal.jsonl"));
  for (std::string line; std::getline(journal, line);)
    if (line.find("\"stream\":\"env/c\"") != std::string::npos && line.find("\"kind\":\"input\"") != std::string::npos)
      heard.push_back(line.find("from a") != std::string::npos ? "a" : "b");
  EXPECT_THAT(heard, ElementsAre("a", "b"));
}

/// A node that uses what the environment offers and offers what the environment uses.
class Peer {
 public:
  Peer(Episode& episode, const std::string& name)
      : bus_(episode.bus()), word_(**bus_.registry().message("words/msg/Word")) {
    const bus::ServiceType& door = **bus_.registry().service("std_srvs/srv/SetBool");
    const bus::ActionType& count = **bus_.registry().action("example_interfaces/action/Fibonacci");
    const auto keep = [this](const bus::Delivery& d) { taken_.push_back(d); };
    node = bus_.join(bus::ParticipantKind::kNode, {name, "/", {}}, episode.journal().open_stream("node/" + name));
    topic_ = *bus_.advertise(node, "/word", word_);
    client_ = *bus_.create_client(node, "/own_door", door, nullptr);
    service_ = *bus_.serve(node, "/door_" + name, door, keep);
    action_client_ = *bus_.create_action_client(node, "/own_count", count, {});
    action_ = *bus_.serve_action(node, "/count_" + name, count, {keep, keep});
    request_ = blank(*door.request);
    response_ = blank(*door.response);
    goal_ = blank(*count.goal);
    feedback_ = blank(*count.feedback);
    result_ = blank(*count.result);
  }
  static bus::SharedMessage blank(const bus::MessageType& type) { return std::make_shared<const bus::Message>(type); }

  void send_goal() { goals_.push_back(bus_.send_goal(action_client_, goal_)); }
  void accept_goal() {
    take();
    bus_.answer_goal(action_, taken_.at(0).goal, bus::GoalAnswer::kAccept);
  }
  void take() {
    taken_.clear();
    bus_.deliver(node);
  }
  /// Posts one of each kind and two words, in the opposite of the order in which they are to come.
  void post_all() {
    take();  // the service's request, a goal, a cancel of the goal before it
    const auto of = [this](bus::DeliveryKind kind) { return *std::ranges::find(taken_, kind, &bus::Delivery::kind); };
    const bus::Delivery request = of(bus::DeliveryKind::kServiceRequest), goal = of(bus::DeliveryKind::kGoal),
                        cancel = of(bus::DeliveryKind::kCancel);
    for (int i = 1; i <= 2; ++i) {
      bus::Message word(word_);
      word->set("number", i);
      bus_.publish(topic_, std::make_shared<const bus::Message>(std::move(word)));
    }
    bus_.publish_feedback(action_, cancel.goal, feedback_);
    bus_.cancel_goal(action_client_, goals_.front());
    send_goal();
    bus_.call(client_, request_);
    bus_.answer_cancel(action_, cancel, true);
    bus_.finish(action_, cancel.goal, bus::GoalStatus::kCanceled, result_);
    bus_.answer_goal(action_, goal.goal, bus::GoalAnswer::kAccept);
    bus_.respond(service_, request, response_);
  }
  bus::ParticipantId node{};

 private:
  bus::Bus& bus_;
  const bus::MessageType& word_;
  bus::EndpointId topic_{}, client_{}, service_{}, action_client_{}, action_{};
  bus::SharedMessage request_, response_, goal_, feedback_, result_;
  std::vector<bus::GoalId> goals_;
  std::vector<bus::Delivery> taken_;
};

TEST_F(TimeAndOrder, AllNineKindsComeInTheirOrderThenBySenderThenByCount) {
  auto episode = load(scenario("nine", {{"a", kClock}}));
  begin(*episode);
  bus::Bus& bus = episode->bus();
  const bus::ParticipantId env = episode->agents()[0]->environment(0).participant();
  Peer x(*episode, "x"), y(*episode, "y");
  std::vector<std::string> heard;
  const auto note = [&](const std::string& what) {
    return [&heard, &bus, what](const bus::Delivery& d) { heard.push_back(what + ' ' + bus.name_of(d.from).name); };
  };
  const bus::ServiceType& door = **bus.registry().service("std_srvs/srv/SetBool");
  const bus::ActionType& count = **bus.registry().action("example_interfaces/action/Fibonacci");
  // The environment's own endpoints, with callbacks that log what the tick brings.
  bus::EndpointId own_count{};
  const auto take_goal = [&](const bus::Delivery& d) {
    note("goal")(d);
    bus.answer_goal(own_count, d.goal, bus::GoalAnswer::kAccept);
  };
  const auto hear_word = [&](const bus::Delivery& d) {
    heard.push_back("word " + bus.name_of(d.from).name + ' ' + std::to_string(d.message->view().integer("number")));
  };
  ASSERT_TRUE(bus.subscribe(env, "/word", **bus.registry().message("words/msg/Word"), hear_word).ok());
  ASSERT_TRUE(bus.serve(env, "/own_door", door, note("request")).ok());
  own_count = *bus.serve_action(env, "/own_count", count, {take_goal, note("cancel")});
  std::vector<bus::EndpointId> doors, counts;
  for (const char* name : {"x", "y"}) {
    doors.push_back(*bus.create_client(env, std::string("/door_") + name, door, note("response")));
    counts.push_back(
        *bus.create_action_client(env, std::string("/count_") + name, count,
                                  {note("goal response"), note("feedback"), note("result"), note("cancel response")}));
  }
  // Before: a goal of each peer to the environment, and of the environment to each peer.
  x.send_goal();
  y.send_goal();
  std::vector<bus::GoalId> sent;
  for (const bus::EndpointId client : counts) sent.push_back(bus.send_goal(client, Peer::blank(*count.goal)));
  ASSERT_TRUE(episode->tick().ok());
  x.accept_goal();
  y.accept_goal();
  ASSERT_TRUE(episode->tick().ok());
  for (std::size_t i = 0; i < 2; ++i) {
    bus.cancel_goal(counts[i], sent[i]);
    bus.send_goal(counts[i], Peer::blank(*count.goal));
    bus.call(doors[i], Peer::blank(*door.request));
  }
  y.post_all();  // first, though x is the first sender
  x.post_all();
  heard.clear();
  ASSERT_TRUE(episode->tick().ok());
  EXPECT_THAT(heard, ElementsAre("response x", "response y", "goal response x", "goal response y", "cancel response x",
                                 "cancel response y", "request x", "request y", "goal x", "goal y", "cancel x",
                                 "cancel y", "feedback x", "feedback y", "result x", "result y", "word x 1", "word x 2",
                                 "word y 1", "word y 2"));
}

TEST_F(TimeAndOrder, RequestsComeBeforeTopicsThatWereSentBefore) {
  const std::string service =
      "(deffunction /door-service-callback (?s ?q ?r)\n"
      " (println \"topics before: \" (length$ (find-all-facts ((?f ros-msgs-message)) TRUE))))\n";
  auto episode =
      load(scenario("kinds", {{"a", service + hearer("(ros-msgs-create-service \"/door\" \"std_srvs/srv/SetBool\")")}},
                    "stimuli:\n  - {at: 1, publish: /word, type: words/msg/Word, data: {text: w}}\n"
                    "  - {at: 1, call: /door, type: std_srvs/srv/SetBool}\n"));
  begin(*episode);
  play(*episode, 1.1);
  EXPECT_THAT(log_.with(" a: "), ElementsAre("1.000 a: topics before: 0", "1.000 a: heard w"));
}

TEST_F(TimeAndOrder, ServersHearEnvironmentsAtTheSameTicksEnd) {
  const std::string rules =
      kOpen + std::string(R"((defrule open (open) => (ros-msgs-create-client "/door" "std_srvs/srv/SetBool")
  (ros-msgs-create-client "/nobody" "std_srvs/srv/SetBool"))
(defrule ask (time 1.0) =>
  (bind ?q (ros-msgs-create-request "std_srvs/srv/SetBool"))
  (println "nobody: " (ros-msgs-async-send-request ?q "/nobody"))
  (println "sent " (neq FALSE (ros-msgs-async-send-request ?q "/door"))))
(defrule answer (ros-msgs-response (service "/door")) => (println "answered"))
)");
  auto episode =
      load(scenario("servers", {{"a", rules}},
                    "stimuli:\n  - {at: 0, serve: /door, type: std_srvs/srv/SetBool, response: {success: true}}\n"));
  begin(*episode);
  play(*episode, 1.1);
  const auto lines = log_.with("1.0");
  ASSERT_THAT(lines, SizeIs(testing::Ge(4u)));
  EXPECT_THAT(log_.with("nobody: "), ElementsAre("1.000 a: nobody: FALSE")) << "a service that nobody serves: at once";
  EXPECT_THAT(log_.with("sent"), ElementsAre("1.000 a: sent TRUE"));
  ASSERT_THAT(log_.with("/door: request"), SizeIs(1));
  EXPECT_EQ(log_.with("/door: request").front().find("1.000 stimuli"), 0u) << "at the same tick";
  EXPECT_THAT(log_.with("answered"), ElementsAre("1.020 a: answered"))
      << "what a server posts at a tick's end comes at the next";
}

TEST_F(TimeAndOrder, AGoalWaitsForItsServer) {
  const std::string rules =
      kOpen +
      std::string(
          R"((defrule open (open) => (ros-msgs-create-action-client "/count" "example_interfaces/action/Fibonacci"))
(defrule ask (time 1.0) => (ros-msgs-async-send-goal (ros-msgs-create-goal-request "example_interfaces/action/Fibonacci") "/count"))
(defrule answer (ros-msgs-goal-response (server "/count")) => (println "accepted"))
)");
  auto episode = load(scenario("goals", {{"a", rules}}));
  begin(*episode);
  play(*episode, 2);
  EXPECT_THAT(log_.with("accepted"), IsEmpty());
  bus::Bus& bus = episode->bus();
  const auto node =
      bus.join(bus::ParticipantKind::kNode, {"counter", "/", {}}, episode->journal().open_stream("node/counter"));
  const auto type = bus.registry().action("example_interfaces/action/Fibonacci");
  ASSERT_TRUE(type.ok());
  bus::EndpointId server{};
  int goals = 0;
  const auto served = bus.serve_action(
      node, "/count", **type,
      {[&](const bus::Delivery& d) { goals += bus.answer_goal(server, d.goal, bus::GoalAnswer::kAccept); }, {}});
  ASSERT_TRUE(served.ok());
  server = *served;
  bus.deliver(node);
  EXPECT_EQ(goals, 1);
  play(*episode, 2.1);
  EXPECT_THAT(log_.with("accepted"), ElementsAre("2.020 a: accepted"));
}

TEST_F(TimeAndOrder, TicksWithNothingDueAreSkippedWithoutATrace) {
  const Env a{"a", hearer(kPublisher) + speaker("x", "1.0") + kClock, 7};
  const std::string stimuli =
      "duration_s: 5\nstimuli:\n  - {at: 2.313, publish: /word, type: words/msg/Word, data: {text: w}}\n";
  const Result few = whole(scenario("few", {a}, stimuli));
  const auto lines = log_.with(" a: ");
  log_.all.clear();
  write("words/many/a.clp", a.rules);
  const Result many = whole(scenario("many", {a, {"b", "", 50}}, stimuli));
  EXPECT_EQ(log_.with(" a: "), lines);
  EXPECT_EQ(many.ticks, 251);
  EXPECT_LT(few.ticks, 60);
  EXPECT_EQ(streams(few).at("node/stimuli"), streams(many).at("node/stimuli"));
}

}  // namespace
}  // namespace cxlab
