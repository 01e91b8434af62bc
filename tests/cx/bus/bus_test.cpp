#include "cx/bus/bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// --- Topics, and when they arrive

TEST_F(BusTest, WhatANodePostsReachesEnvironmentsAndNodesAtTheirNextTake) {
  const auto server = node("server"), other = node("other"), env = environment("env");
  const auto out = advertise(server, "chatter");
  subscribe(env, "/chatter");
  subscribe(other, "chatter");
  tick();
  bus_.publish(out, text("hello"));
  EXPECT_TRUE(bus_.has_waiting(env));
  EXPECT_THAT(deliver(env), ElementsAre("hello"));
  EXPECT_THAT(deliver(other), ElementsAre("hello"));
  EXPECT_THAT(deliver(env), IsEmpty());
}

TEST_F(BusTest, WhatAnEnvironmentPostsReachesNodesAtOnceAndEnvironmentsAtTheNextTick) {
  const auto a = environment("a"), b = environment("b"), server = node("server");
  const auto out = advertise(a, "chatter");
  for (const auto p : {a, b, server}) subscribe(p, "chatter");
  tick();
  bus_.publish(out, text("hello"));
  EXPECT_THAT(deliver(server), ElementsAre("hello"));
  EXPECT_FALSE(bus_.has_waiting(a));
  EXPECT_THAT(deliver(a), IsEmpty());
  EXPECT_THAT(deliver(b), IsEmpty());
  EXPECT_TRUE(bus_.any_waiting());
  tick();
  EXPECT_THAT(deliver(b), ElementsAre("hello"));
  EXPECT_THAT(deliver(a), ElementsAre("hello"));
  EXPECT_FALSE(bus_.any_waiting());
}

TEST_F(BusTest, WhatIsPostedBeforeTheFirstTickArrivesInIt) {
  const auto a = environment("a"), b = environment("b");
  const auto out = advertise(a, "chatter");
  subscribe(b, "chatter");
  bus_.publish(out, text("activation"));
  EXPECT_THAT(deliver(b), IsEmpty());
  bus_.begin_tick(SimTime{0});
  EXPECT_THAT(deliver(b), ElementsAre("activation"));
}

TEST_F(BusTest, WithinAKindTheSendersIndexThenItsSequenceDecides) {
  const auto first = node("first"), second = node("second"), env = environment("env");
  const auto first_a = advertise(first, "a"), first_b = advertise(first, "b"), second_a = advertise(second, "a");
  subscribe(env, "a");
  subscribe(env, "b");
  tick();
  bus_.publish(second_a, text("second 1"));
  bus_.publish(first_b, text("first 1"));
  bus_.publish(first_a, text("first 2"));
  bus_.publish(second_a, text("second 2"));
  EXPECT_THAT(deliver(env), ElementsAre("first 1", "first 2", "second 1", "second 2"));
}

TEST_F(BusTest, TwoSubscriptionsOfOneTopicTakeInTheOrderOfTheirCreation) {
  const auto server = node("server"), env = environment("env");
  const auto out = advertise(server, "t");
  subscribe(env, "t", [this](const Delivery&) { log_.push_back("first"); });
  subscribe(env, "t", [this](const Delivery&) { log_.push_back("second"); });
  bus_.publish(out, text("x"));
  EXPECT_THAT(deliver(env), ElementsAre("x", "first", "x", "second"));
}

TEST_F(BusTest, TheKindDecidesBeforeTheSender) {
  const auto first = node("first"), second = node("second"), env = environment("env");
  const auto out = advertise(first, "t");
  subscribe(env, "t");
  const auto service =
      *bus_.serve(env, "s", *set_bool_, [this](const Delivery&) { log_.push_back("request of the second"); });
  const auto client = *bus_.create_client(second, "s", *set_bool_, nullptr);
  static_cast<void>(service);
  tick();
  bus_.publish(out, text("topic of the first"));
  bus_.call(client, blank(*set_bool_->request));
  EXPECT_THAT(deliver(env), ElementsAre("request of the second", "topic of the first"));
}

TEST_F(BusTest, WhatAMutedBusTakesReachesNobody) {
  const auto server = node("server"), env = environment("env");
  const auto out = advertise(server, "t");
  subscribe(env, "t");
  bus_.mute(true);
  bus_.publish(out, text("unheard"));
  EXPECT_FALSE(bus_.any_waiting());
  bus_.mute(false);
  bus_.publish(out, text("heard"));
  EXPECT_THAT(deliver(env), ElementsAre("heard"));
}

TEST_F(BusTest, KindsComeInTheOrderOfDeliveryKind) {
  const auto env = environment("env"), peer = node("peer");
  const auto note = [this](const char* what) { return [this, what](const Delivery&) { log_.push_back(what); }; };
  // What env serves and what it uses, so that every kind can wait for it at once.
  const auto service = *bus_.serve(env, "own", *set_bool_, note("request"));
  const auto client = *bus_.create_client(env, "theirs", *set_bool_, note("response"));
  const auto server = *bus_.serve_action(env, "own_action", *fibonacci_, {note("goal"), note("cancel")});
  const auto action =
      *bus_.create_action_client(env, "their_action", *fibonacci_,
                                 {note("goal response"), note("feedback"), note("result"), note("cancel response")});
  subscribe(env, "topic");
  static_cast<void>(service);

  std::vector<Delivery> at_peer;
  const auto keep = [&](const Delivery& d) { at_peer.push_back(d); };
  const auto peer_topic = advertise(peer, "topic");
  const auto peer_client = *bus_.create_client(peer, "own", *set_bool_, nullptr);
  const auto peer_service = *bus_.serve(peer, "theirs", *set_bool_, keep);
  const auto peer_action = *bus_.create_action_client(peer, "own_action", *fibonacci_, {});
  const auto peer_server = *bus_.serve_action(peer, "their_action", *fibonacci_, {keep, keep});

  tick();
  const GoalId earlier = bus_.send_goal(peer_action, blank(*fibonacci_->goal));
  bus_.deliver(env);
  bus_.answer_goal(server, earlier, GoalAnswer::kAccept);
  taken();
  bus_.call(client, blank(*set_bool_->request));
  const GoalId mine = bus_.send_goal(action, blank(*fibonacci_->goal));
  bus_.deliver(peer);
  ASSERT_EQ(at_peer.size(), 2u);

  tick();
  bus_.publish(peer_topic, text("topic"));
  bus_.answer_goal(peer_server, mine, GoalAnswer::kAccept);
  bus_.publish_feedback(peer_server, mine, blank(*fibonacci_->feedback));
  bus_.cancel_goal(action, mine);
  bus_.deliver(peer);
  bus_.answer_cancel(peer_server, at_peer.back(), true);
  bus_.finish(peer_server, mine, GoalStatus::kCanceled, blank(*fibonacci_->result));
  bus_.cancel_goal(peer_action, earlier);
  bus_.send_goal(peer_action, blank(*fibonacci_->goal));
  bus_.call(peer_client, blank(*set_bool_->request));
  bus_.respond(peer_service, at_peer.front(), blank(*set_bool_->response));
  EXPECT_THAT(deliver(env), ElementsAre("response", "goal response", "cancel response", "request", "goal", "cancel",
                                        "feedback", "result", "topic"));
}

TEST_F(BusTest, WhatHandlersPostIsForALaterCall) {
  const auto server = node("server");
  const auto out = advertise(server, "t");
  subscribe(server, "t", [&](const Delivery& d) {
    if (d.sequence == 1) bus_.publish(out, text("again"));
  });
  bus_.publish(out, text("first"));
  EXPECT_THAT(deliver(server), ElementsAre("first"));
  EXPECT_THAT(deliver(server), ElementsAre("again"));
}

TEST_F(BusTest, AHandlerMayRemoveItselfAndOthers) {
  const auto server = node("server"), env = environment("env");
  const auto out = advertise(server, "t");
  EndpointId self{}, other{};
  self = subscribe(env, "t", [&](const Delivery&) {
    bus_.remove(self);
    bus_.remove(other);
    subscribe(env, "t", [this](const Delivery&) { log_.push_back("new"); });
  });
  other = subscribe(env, "t");
  bus_.publish(out, text("a"));
  bus_.publish(out, text("b"));
  EXPECT_THAT(deliver(env), ElementsAre("a"));
  bus_.publish(out, text("c"));
  EXPECT_THAT(deliver(env), ElementsAre("c", "new"));
}

TEST_F(BusTest, ARemovedSubscriptionLosesWhatWaited) {
  const auto server = node("server"), env = environment("env"), sender = environment("sender");
  const auto out = advertise(server, "t"), from_env = advertise(sender, "t");
  const auto in = subscribe(env, "t");
  bus_.publish(out, text("now"));
  bus_.publish(from_env, text("next"));
  bus_.remove(in);
  EXPECT_FALSE(bus_.any_waiting());
  bus_.remove(in);
  bus_.remove(out);
  bus_.publish(out, text("through a removed publisher"));
  EXPECT_FALSE(bus_.any_waiting());
}

TEST_F(BusTest, ALaterSubscriptionDoesNotSeeEarlierPosts) {
  const auto server = node("server"), env = environment("env");
  const auto out = advertise(server, "t");
  bus_.publish(out, text("early"));
  subscribe(env, "t");
  EXPECT_THAT(deliver(env), IsEmpty());
}

TEST_F(BusTest, AParticipantThatLeavesTakesItsEndpointsButNotItsPosts) {
  const auto server = node("server"), env = environment("env");
  const auto out = advertise(server, "t");
  subscribe(server, "u");
  subscribe(env, "t");
  bus_.publish(out, text("last words"));
  EXPECT_TRUE(bus_.is_there(server));
  EXPECT_EQ(bus_.find_node("/server"), server);
  bus_.leave(server);
  EXPECT_FALSE(bus_.is_there(server));
  EXPECT_EQ(bus_.find_node("/server"), std::nullopt);
  EXPECT_THAT(deliver(env), ElementsAre("last words"));
  ASSERT_EQ(bus_.topics().size(), 1u);
  EXPECT_EQ(bus_.topics()[0].name, "/t");
  EXPECT_EQ(bus_.topics()[0].providers, 0);
  EXPECT_EQ(bus_.topics()[0].users, 1);
}

TEST_F(BusTest, EndpointsAreNumberedInTheOrderOfMaking) {
  const auto a = node("a"), b = node("b");
  const auto first = advertise(a, "t"), second = subscribe(a, "t"), other = advertise(b, "t");
  EXPECT_EQ(bus_.number_of(first), 0u);
  EXPECT_EQ(bus_.number_of(second), 1u);
  EXPECT_EQ(bus_.number_of(other), 0u);
  bus_.remove(first);
  EXPECT_EQ(bus_.number_of(advertise(a, "u")), 2u);
  EXPECT_EQ(bus_.endpoint_of(a, 0), first);
  EXPECT_EQ(bus_.endpoint_of(a, 1), second);
  EXPECT_EQ(bus_.endpoint_of(b, 0), other);
  EXPECT_EQ(bus_.endpoint_of(a, 3), std::nullopt);
  EXPECT_EQ(bus_.endpoint_of(b, 1), std::nullopt);
}

TEST_F(BusTest, MessagesAreSharedNotCopied) {
  const auto server = node("server"), a = environment("a"), b = environment("b");
  const auto out = advertise(server, "t");
  std::vector<const Message*> seen;
  for (const auto p : {a, b}) subscribe(p, "t", [&](const Delivery& d) { seen.push_back(d.message.get()); });
  const SharedMessage message = text("x");
  bus_.publish(out, message);
  bus_.deliver(a);
  bus_.deliver(b);
  EXPECT_THAT(seen, ElementsAre(message.get(), message.get()));
}

// --- Names and types

TEST_F(BusTest, NamespacesKeepParticipantsApartAndRemapsJoinThem) {
  const auto cyan = join(ParticipantKind::kNode, "cyan", {"n", "/cyan", {}});
  const auto magenta = join(ParticipantKind::kNode, "magenta", {"n", "/magenta", {{"/all", "/cyan/chatter"}}});
  const auto out = advertise(cyan, "chatter");
  subscribe(magenta, "chatter");
  bus_.publish(out, text("for cyan"));
  EXPECT_THAT(deliver(magenta), IsEmpty());
  subscribe(magenta, "/all");
  bus_.publish(out, text("for all"));
  EXPECT_THAT(deliver(magenta), ElementsAre("for all"));
}

TEST_F(BusTest, TypesLiveSideBySideUnderANameThatAllowsIt) {
  const auto a = environment("a"), b = environment("b"), server = node("server");
  int for_a = 0, for_b = 0;
  const auto& empty = **registry_.service("std_srvs/srv/Empty");
  const auto client_a = bus_.create_client(a, "/s", *set_bool_, [&](const Delivery&) { ++for_a; });
  bus_.allow_types(server, "s");
  const auto client_b = bus_.create_client(b, "/s", empty, [&](const Delivery&) { ++for_b; });
  ASSERT_TRUE(client_a.ok() && client_b.ok());
  EndpointId served_bool{};
  served_bool = *bus_.serve(server, "s", *set_bool_, [&](const Delivery& d) {
    bus_.respond(served_bool, d, std::make_shared<Message>(*set_bool_->response));
  });
  EXPECT_TRUE(bus_.service_ready(*client_a));
  EXPECT_FALSE(bus_.service_ready(*client_b));
  EndpointId served_empty{};
  served_empty = *bus_.serve(server, "s", empty, [&](const Delivery& d) {
    bus_.respond(served_empty, d, std::make_shared<Message>(*empty.response));
  });
  bus_.call(*client_a, std::make_shared<Message>(*set_bool_->request));
  bus_.call(*client_b, std::make_shared<Message>(*empty.request));
  tick();
  bus_.deliver(server);
  bus_.deliver(a);
  bus_.deliver(b);
  EXPECT_EQ(for_a, 1);
  EXPECT_EQ(for_b, 1);
  ASSERT_EQ(bus_.services().size(), 2u);
  EXPECT_EQ(bus_.services()[0].name, "/s");
}

TEST_F(BusTest, ASecondTypeOfTheSameNameIsAnErrorWhileTheFirstIsThere) {
  const auto a = node("a"), b = node("b");
  const auto out = advertise(a, "t");
  const auto refused = bus_.subscribe(b, "/t", *number_, nullptr);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "topic '/t' has type std_msgs/msg/String, found a second type std_msgs/msg/Int32");
  EXPECT_TRUE(bus_.serve(b, "t", *set_bool_, nullptr).ok());  // services have names of their own
  bus_.remove(out);
  EXPECT_TRUE(bus_.subscribe(b, "/t", *number_, nullptr).ok());
}

TEST_F(BusTest, ABadNameIsAnError) {
  const auto a = node("a");
  EXPECT_THAT(bus_.advertise(a, "", *string_).error().message, HasSubstr("is empty"));
  EXPECT_THAT(bus_.create_client(a, "a b", *set_bool_, nullptr).error().message, HasSubstr("service 'a b' has a ' '"));
}

TEST_F(BusTest, IntrospectionIsSortedByName) {
  const auto a = node("a");
  advertise(a, "z");
  subscribe(a, "b");
  ASSERT_TRUE(bus_.serve(a, "~/s", *set_bool_, nullptr).ok());
  ASSERT_TRUE(bus_.create_action_client(a, "act", *fibonacci_, {}).ok());
  ASSERT_EQ(bus_.topics().size(), 2u);
  EXPECT_EQ(bus_.topics()[0].name, "/b");
  EXPECT_EQ(bus_.topics()[1].type, "std_msgs/msg/String");
  EXPECT_EQ(bus_.services()[0].name, "/a/s");
  EXPECT_EQ(bus_.services()[0].type, "std_srvs/srv/SetBool");
  EXPECT_EQ(bus_.actions()[0].users, 1);
}

// --- Services

class ServiceTest : public BusTest {
 protected:
  Handler keep_requests() {
    return [this](const Delivery& d) { requests_.push_back(d); };
  }
  Handler note_responses() {
    return [this](const Delivery& d) {
      log_.push_back(std::to_string(d.request_id) + " " + d.message->view().text("message"));
    };
  }
  SharedMessage answer(const std::string& message) const {
    Message response(*set_bool_->response);
    response->set("message", message);
    return std::make_shared<Message>(std::move(response));
  }
  std::vector<Delivery> requests_;
};

TEST_F(ServiceTest, AnswersGoToTheCallerUnderItsOwnNumber) {
  const auto server = node("server"), a = environment("a"), b = environment("b");
  const auto service = *bus_.serve(server, "s", *set_bool_, keep_requests());
  const auto of_a = *bus_.create_client(a, "s", *set_bool_, note_responses());
  const auto of_b = *bus_.create_client(b, "s", *set_bool_, note_responses());
  EXPECT_TRUE(bus_.service_ready(of_a));
  tick();
  EXPECT_EQ(bus_.call(of_b, blank(*set_bool_->request)), 1u);
  EXPECT_EQ(bus_.call(of_a, blank(*set_bool_->request)), 1u);
  EXPECT_EQ(bus_.call(of_a, blank(*set_bool_->request)), 2u);
  bus_.deliver(server);
  ASSERT_EQ(requests_.size(), 3u);
  EXPECT_TRUE(bus_.respond(service, requests_[0], answer("one")));
  EXPECT_TRUE(bus_.respond(service, requests_[2], answer("for b")));
  EXPECT_FALSE(bus_.respond(service, requests_[2], answer("again")));
  EXPECT_THAT(deliver(a), ElementsAre("1 one"));
  EXPECT_THAT(deliver(b), ElementsAre("1 for b"));
  tick();
  EXPECT_TRUE(bus_.respond(service, requests_[1], answer("late")));
  EXPECT_THAT(deliver(a), ElementsAre("2 late"));
}

TEST_F(ServiceTest, AnAnswerIsRecordedWithItsMessageAndNamesItsRequest) {
  const auto server = node("server"), a = environment("a");
  const auto service = *bus_.serve(server, "s", *set_bool_, keep_requests());
  const auto client = *bus_.create_client(a, "s", *set_bool_, note_responses());
  tick();
  bus_.call(client, blank(*set_bool_->request));
  const std::uint64_t asked = sink_.of(bus_.stream_of(a)).size() - 1;
  bus_.deliver(server);
  ASSERT_TRUE(bus_.respond(service, requests_[0], answer("done")));
  const KeptRecords::Record record = sink_.of(bus_.stream_of(server)).back();
  RecordData expected;
  expected.begin().field("op", "respond").field("name", "/s").field("seq", 1).field("id", requests_[0].request_id);
  expected.name("response")
      .open_map(2)
      .text_key("success")
      .value(false)
      .text_key("message")
      .value(std::string_view("done"));
  EXPECT_EQ(record.data, expected.bytes());
  ASSERT_EQ(record.causes.size(), 1u);
  EXPECT_EQ(record.causes[0].stream, bus_.stream_of(a));
  EXPECT_EQ(record.causes[0].n, asked);
}

TEST_F(ServiceTest, ACallWithoutServerWaitsForOne) {
  const auto a = environment("a"), server = node("server");
  const auto client = *bus_.create_client(a, "s", *set_bool_, note_responses());
  EXPECT_FALSE(bus_.service_ready(client));
  tick();
  bus_.call(client, blank(*set_bool_->request));
  EXPECT_FALSE(bus_.any_waiting());
  tick();
  const auto service = *bus_.serve(server, "s", *set_bool_, keep_requests());
  bus_.deliver(server);
  ASSERT_EQ(requests_.size(), 1u);
  bus_.respond(service, requests_[0], answer("at last"));
  EXPECT_THAT(deliver(a), ElementsAre("1 at last"));
  bus_.remove(service);
  ASSERT_TRUE(bus_.serve(server, "s", *set_bool_, keep_requests()).ok());
  bus_.deliver(server);
  EXPECT_EQ(requests_.size(), 1u) << "another server does not get it again";
}

TEST_F(ServiceTest, ACallThatWaitsIsForgottenWhenTheNameGetsAnotherType) {
  const auto a = environment("a"), server = node("server");
  const auto client = *bus_.create_client(a, "s", *set_bool_, nullptr);
  bus_.call(client, blank(*set_bool_->request));
  bus_.remove(client);
  ASSERT_TRUE(bus_.serve(server, "s", **registry_.service("std_srvs/srv/Empty"), keep_requests()).ok());
  bus_.deliver(server);
  EXPECT_THAT(requests_, IsEmpty());
}

TEST_F(ServiceTest, ARequestIsAnsweredOnlyAfterItWasTaken) {
  const auto a = environment("a"), server = node("server");
  const auto service = *bus_.serve(server, "s", *set_bool_, keep_requests());
  bus_.call(*bus_.create_client(a, "s", *set_bool_, note_responses()), blank(*set_bool_->request));
  Delivery guessed;
  guessed.request_id = 1;
  EXPECT_FALSE(bus_.respond(service, guessed, answer("too early")));
  bus_.deliver(server);
  ASSERT_EQ(requests_.size(), 1u);
  EXPECT_EQ(requests_[0].request_id, guessed.request_id);
  EXPECT_TRUE(bus_.respond(service, requests_[0], answer("now")));
  EXPECT_THAT(deliver(a), ElementsAre("1 now"));
}

TEST_F(ServiceTest, AnEnvironmentAnswersAnotherTwoTicksAfterTheCall) {
  const auto a = environment("a"), b = environment("b");
  const auto client = *bus_.create_client(a, "s", *set_bool_, note_responses());
  EndpointId service{};
  service = *bus_.serve(b, "s", *set_bool_, [&](const Delivery& d) { bus_.respond(service, d, answer("hi")); });
  tick();
  bus_.call(client, blank(*set_bool_->request));
  EXPECT_EQ(bus_.deliver(b), 0u);
  tick();
  EXPECT_THAT(deliver(a), IsEmpty());
  EXPECT_EQ(bus_.deliver(b), 1u);
  EXPECT_THAT(deliver(a), IsEmpty());
  tick();
  EXPECT_THAT(deliver(a), ElementsAre("1 hi"));
}

TEST_F(ServiceTest, RequestsToARemovedServerStayUnanswered) {
  const auto a = environment("a"), server = node("server");
  const auto client = *bus_.create_client(a, "s", *set_bool_, note_responses());
  const auto service = *bus_.serve(server, "s", *set_bool_, keep_requests());
  bus_.call(client, blank(*set_bool_->request));
  bus_.deliver(server);
  bus_.call(client, blank(*set_bool_->request));
  bus_.remove(service);
  EXPECT_FALSE(bus_.service_ready(client));
  EXPECT_FALSE(bus_.respond(service, requests_[0], answer("too late")));
  EXPECT_FALSE(bus_.any_waiting());
  EXPECT_TRUE(bus_.serve(server, "s", *set_bool_, keep_requests()).ok());
  EXPECT_FALSE(bus_.any_waiting());
}

TEST_F(ServiceTest, OfTwoServersTheFirstAnswersUntilItGoes) {
  const auto a = environment("a"), first = node("first"), second = node("second");
  const auto client = *bus_.create_client(a, "s", *set_bool_, nullptr);
  const auto service = *bus_.serve(first, "s", *set_bool_, nullptr);
  ASSERT_TRUE(bus_.serve(second, "s", *set_bool_, nullptr).ok());
  bus_.call(client, blank(*set_bool_->request));
  EXPECT_EQ(bus_.deliver(first), 1u);
  EXPECT_EQ(bus_.deliver(second), 0u);
  bus_.remove(service);
  bus_.call(client, blank(*set_bool_->request));
  EXPECT_EQ(bus_.deliver(second), 1u);
}

TEST_F(ServiceTest, ASecondServerIsToldWithBothOwners) {
  std::vector<std::string> told;
  bus_.on_rivals([&](const std::string& text) { told.push_back(text); });
  const auto first = node("first"), twin = node("first");
  const auto env =
      bus_.join(ParticipantKind::kEnvironment, {"second", "/", {}}, sink_.open_stream("second"), "environment main");
  ASSERT_TRUE(bus_.serve(first, "s", *set_bool_, nullptr).ok());
  ASSERT_TRUE(bus_.serve(twin, "s", *set_bool_, nullptr).ok());
  EXPECT_THAT(told, ElementsAre()) << "of two nodes of one name everything is double";
  ASSERT_TRUE(bus_.serve(env, "s", *set_bool_, nullptr).ok());
  ASSERT_TRUE(bus_.serve_action(first, "s", *fibonacci_, {}).ok());
  ASSERT_TRUE(bus_.serve_action(first, "s", *fibonacci_, {}).ok());
  advertise(first, "t");
  advertise(env, "t");
  EXPECT_THAT(
      told,
      ElementsAre(
          "service '/s' has more than one server: /first answers, /second (environment main) only once that is gone",
          "action '/s' has more than one server: /first answers, /first only once that is gone"));
}

TEST_F(ServiceTest, AnswersToAClientThatHasGoneAreDropped) {
  const auto a = environment("a"), server = node("server");
  const auto client = *bus_.create_client(a, "s", *set_bool_, note_responses());
  const auto service = *bus_.serve(server, "s", *set_bool_, keep_requests());
  bus_.call(client, blank(*set_bool_->request));
  bus_.deliver(server);
  bus_.leave(a);
  EXPECT_TRUE(bus_.respond(service, requests_[0], answer("nobody")));
  EXPECT_FALSE(bus_.any_waiting());
}

// --- Records and replay

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
