// Services: calls, who answers them, and when.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

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

TEST_F(ServiceTest, StandInAnswersOnlyWhileNobodyElseServes) {
  std::vector<std::string> rivals;
  bus_.on_rivals([&](const std::string& text) { rivals.push_back(text); });
  const auto stand_in = node("stand_in"), server = node("server"), late = node("late"), a = environment("a");
  EndpointId of_stand_in{}, of_server{};
  const auto answering = [&](EndpointId& service, const char* who) {
    return [&, who](const Delivery& d) { bus_.respond(service, d, answer(who)); };
  };
  of_stand_in = *bus_.serve(stand_in, "s", *set_bool_, answering(of_stand_in, "stand-in"), Bus::Rank::kStandIn);
  const auto client = *bus_.create_client(a, "s", *set_bool_, note_responses());
  EXPECT_TRUE(bus_.service_ready(client));
  const auto ask = [&] {
    tick();
    bus_.call(client, blank(*set_bool_->request));
    for (const auto p : {stand_in, server}) bus_.deliver(p);
    return deliver(a);
  };
  EXPECT_THAT(ask(), ElementsAre("1 stand-in"));
  of_server = *bus_.serve(server, "s", *set_bool_, answering(of_server, "server"));
  EXPECT_THAT(bus_.providers(NameKind::kService, "/s"), ElementsAre(server, stand_in));
  EXPECT_THAT(bus_.users(NameKind::kService, "/s"), ElementsAre(a));
  EXPECT_THAT(bus_.providers(NameKind::kService, "/"), IsEmpty()) << "the whole name counts";
  EXPECT_EQ(bus_.described(server), "/server");
  EXPECT_THAT(ask(), ElementsAre("2 server"));
  EXPECT_THAT(rivals, IsEmpty());
  ASSERT_TRUE(bus_.serve(late, "s", *set_bool_, {}));
  EXPECT_THAT(bus_.providers(NameKind::kService, "/s"), ElementsAre(server, late, stand_in));
  EXPECT_EQ(rivals.size(), 1U) << "two servers are rivals";
  bus_.leave(late);
  bus_.remove(of_server);
  EXPECT_THAT(ask(), ElementsAre("3 stand-in"));
  const auto second = bus_.serve(late, "t", *set_bool_, {});
  EXPECT_FALSE(second) << "it has left";
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

TEST_F(ServiceTest, AnswersToAClientThatLeftAreDropped) {
  const auto a = environment("a"), server = node("server");
  const auto client = *bus_.create_client(a, "s", *set_bool_, note_responses());
  const auto service = *bus_.serve(server, "s", *set_bool_, keep_requests());
  bus_.call(client, blank(*set_bool_->request));
  bus_.deliver(server);
  bus_.leave(a);
  EXPECT_TRUE(bus_.respond(service, requests_[0], answer("nobody")));
  EXPECT_FALSE(bus_.any_waiting());
}

}  // namespace
}  // namespace cxlab::bus
