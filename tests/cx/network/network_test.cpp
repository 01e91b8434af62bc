#include "network_test.h"

namespace cxlab::net {
namespace {

TEST_F(NetworkTest, DatagramsReachAllThatReceiveOnThePort) {
  Listener &sender = environment_host("a"), &one = environment_host("b"), &two = environment_host("c"),
           &other = environment_host("d");
  const LinkId out = sender.host->open_datagrams(4444, 4445);
  one.host->open_datagrams(4445, 4444);
  two.host->open_datagrams(9, 4444);
  other.host->open_datagrams(4444, 4446);
  EXPECT_TRUE(sender.host->send(out, "hello"));
  EXPECT_THAT(take(one), IsEmpty());  // environments hear each other at the next tick
  tick();
  EXPECT_THAT(take(one), ElementsAre("1 gets hello from 127.0.0.1:4445"));
  EXPECT_THAT(take(two), ElementsAre("1 gets hello from 127.0.0.1:4445"));
  EXPECT_THAT(take(other), IsEmpty());
  EXPECT_THAT(take(sender), IsEmpty());
}

TEST_F(NetworkTest, NobodyHearsItselfOnAPortThatItSharesWithOthers) {
  Listener &a = environment_host("a"), &b = environment_host("b");
  const LinkId out = a.host->open_datagrams(4444, 4444);
  b.host->open_datagrams(4444, 4444);
  a.host->send(out, "hello");
  tick();
  EXPECT_THAT(take(a), IsEmpty());
  EXPECT_THAT(take(b), ElementsAre("1 gets hello from 127.0.0.1:4444"));
  a.host->open_datagrams(1, 4444);  // but another link of its own
  a.host->send(out, "you");
  EXPECT_THAT(next(a), ElementsAre("2 gets you from 127.0.0.1:4444"));
}

TEST_F(NetworkTest, WhatNodesSendArrivesInTheSameTick) {
  Listener &refbox = node_host("refbox"), &agent = environment_host("agent");
  const LinkId out = refbox.host->open_datagrams(4444, 4445);
  const LinkId back = agent.host->open_datagrams(4445, 4444);
  tick();
  refbox.host->send(out, "state");
  EXPECT_THAT(take(agent), ElementsAre("1 gets state from 127.0.0.1:4445"));
  agent.host->send(back, "beacon");
  EXPECT_THAT(take(refbox), ElementsAre("1 gets beacon from 127.0.0.1:4444"));
}

TEST_F(NetworkTest, PostsOfSeveralSendersComeInOrderOfTheirJoining) {
  Listener &first = environment_host("a"), &second = environment_host("b"), &receiver = environment_host("c");
  receiver.host->open_datagrams(1, 7);
  const LinkId from_first = first.host->open_datagrams(7, 11), from_second = second.host->open_datagrams(7, 12);
  second.host->send(from_second, "2a");
  first.host->send(from_first, "1a");
  second.host->send(from_second, "2b");
  first.host->send(from_first, "1b");
  EXPECT_THAT(next(receiver), ElementsAre("1 gets 1a from 127.0.0.1:11", "1 gets 1b from 127.0.0.1:11",
                                          "1 gets 2a from 127.0.0.1:12", "1 gets 2b from 127.0.0.1:12"));
}

TEST_F(NetworkTest, AClosedPortTakesNothing) {
  Listener &a = environment_host("a"), &b = environment_host("b");
  const LinkId out = a.host->open_datagrams(7, 8), in = b.host->open_datagrams(8, 7);
  a.host->send(out, "lost");
  b.host->close(in);
  EXPECT_THAT(next(b), IsEmpty());
  EXPECT_FALSE(b.host->send(in, "no"));
  a.host->close(out);
  EXPECT_FALSE(a.host->send(out, "no"));
}

TEST_F(NetworkTest, AClientTalksToAServer) {
  Listener &server = node_host("server"), &client = environment_host("client");
  server.host->listen(4444);
  const LinkId link = client.host->connect(4444);
  EXPECT_FALSE(client.host->send(link, "too early"));
  EXPECT_THAT(take(server), ElementsAre("2 of 1 is accepted from 127.0.0.1:49152"));
  EXPECT_THAT(take(client), ElementsAre("1 is connected"));
  EXPECT_TRUE(client.host->send(link, "ping"));
  EXPECT_THAT(take(server), ElementsAre("2 reads ping"));
  server.host->send(server.accepted, "pong");
  server.host->send(server.accepted, "pang");
  EXPECT_THAT(take(client), ElementsAre("1 reads pong", "1 reads pang"));
  server.host->close(server.accepted);
  EXPECT_THAT(take(client), ElementsAre("1 is closed: the other side has closed it"));
  EXPECT_FALSE(client.host->send(link, "gone"));
  EXPECT_THAT(take(server), IsEmpty());
}

TEST_F(NetworkTest, ServersHaveSeveralClientsAndCloseThem) {
  Listener &server = environment_host("server"), &one = environment_host("one"), &two = environment_host("two");
  const LinkId listening = server.host->listen(4444);
  one.host->connect(4444);
  const LinkId second = two.host->connect(4444);
  EXPECT_THAT(next(server),
              ElementsAre("2 of 1 is accepted from 127.0.0.1:49152", "3 of 1 is accepted from 127.0.0.1:49153"));
  tick();
  EXPECT_THAT(take(one), ElementsAre("1 is connected"));
  EXPECT_THAT(take(two), ElementsAre("1 is connected"));
  two.host->send(second, "from two");
  EXPECT_THAT(next(server), ElementsAre("3 reads from two"));
  server.host->close(listening);
  tick();
  EXPECT_THAT(take(one), ElementsAre("1 is closed: the other side has closed it"));
  EXPECT_THAT(take(two), ElementsAre("1 is closed: the other side has closed it"));
}

TEST_F(NetworkTest, AClientWithoutServerIsRefused) {
  Listener& client = environment_host("client");
  client.host->connect(4444);
  EXPECT_THAT(take(client), ElementsAre("1 is closed: nobody listens on port 4444"));
  Listener& server = environment_host("server");
  const LinkId listening = server.host->listen(4444);
  client.host->connect(4444);
  server.host->close(listening);  // before it has taken the request
  tick();
  EXPECT_THAT(take(server), IsEmpty());
  EXPECT_THAT(next(client), ElementsAre("2 is closed: nobody listens there any more"));
}

TEST_F(NetworkTest, AClientThatGivesUpBeforeItIsAcceptedIsGoneForTheServer) {
  Listener &server = environment_host("server"), &client = environment_host("client");
  server.host->listen(4444);
  client.host->close(client.host->connect(4444));
  EXPECT_THAT(next(server),
              ElementsAre("2 of 1 is accepted from 127.0.0.1:49152", "2 is closed: the other side has closed it"));
  EXPECT_THAT(next(client), IsEmpty());
}

TEST_F(NetworkTest, AHostThatGoesClosesItsLinks) {
  Listener &server = environment_host("server"), &client = environment_host("client");
  server.host->listen(4444);
  client.host->connect(4444);
  next(server);
  next(client);
  client.host.reset();
  EXPECT_THAT(next(server), ElementsAre("2 is closed: the other side has closed it"));
}

TEST_F(NetworkTest, TheRecordOfAPostDoesNotDependOnWhoIsThere) {
  const auto records = [](bool listened) {
    struct Run : NetworkTest {
      void TestBody() override {}
      std::string play(bool with_others) {
        SetUp();
        Listener& a = environment_host("a");
        if (with_others) {
          Listener& b = environment_host("b");
          b.host->open_datagrams(1, 7);
          b.host->listen(8);
        }
        a.host->send(a.host->open_datagrams(7, 9), "hello");
        a.host->close(a.host->connect(8));
        return sink_.text(sink_.open_stream("a"));
      }
    } run;
    return run.play(listened);
  };
  EXPECT_EQ(records(true), records(false));
}

TEST_F(NetworkTest, PacketsThatRulesMadeUpChangeNothing) {
  Listener& host = environment_host("a");
  host.host->listen(5);
  const bus::MessageType& type = **registry_.message("cxlab_msgs/msg/NetworkPacket");
  const auto stranger = environment("stranger");
  const auto publisher = *bus_.advertise(stranger, "/cxlab/network", type);
  for (const int kind : {0, 2, 3, 4, 5, 255}) {
    for (const int link : {0, 1, 77}) {
      auto message = std::make_shared<bus::Message>(type);
      message->view().set("kind", kind).set("to_link", link).set("from_link", link).set("to_port", 5);
      bus_.publish(publisher, message);
    }
  }
  EXPECT_THAT(next(host), IsEmpty());
  EXPECT_TRUE(host.host->has(LinkId{1}));
}

}  // namespace
}  // namespace cxlab::net
