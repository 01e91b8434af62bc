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

}  // namespace
}  // namespace cxlab::bus
