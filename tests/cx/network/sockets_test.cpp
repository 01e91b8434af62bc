#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "cx/network/socket_gateway.h"
#include "network_test.h"

namespace cxlab::net {
namespace {

/// A program outside: plain blocking sockets with a limit of time.
class Outside {
 public:
  explicit Outside(int type, std::uint16_t port = 0) : fd_(::socket(AF_INET, type, 0)) {
    sockaddr_in address = at(port);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    timeval limit{5, 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  }
  explicit Outside(const Outside& server) : fd_(::accept(server.fd_, nullptr, nullptr)) {}
  ~Outside() { ::close(fd_); }
  static sockaddr_in at(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }
  std::uint16_t port() const {
    sockaddr_in address{};
    socklen_t length = sizeof address;
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &length);
    return ntohs(address.sin_port);
  }
  bool connect(std::uint16_t port) {
    sockaddr_in address = at(port);
    return ::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  void listen() { ::listen(fd_, 5); }
  void send_to(std::uint16_t port, const std::string& text) {
    sockaddr_in address = at(port);
    ::sendto(fd_, text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&address), sizeof address);
  }
  void send(const std::string& text) { ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL); }
  /// Empty at the end of the stream.
  std::string receive() {
    std::string text(1000, '\0');
    const ssize_t size = ::recv(fd_, text.data(), text.size(), 0);
    text.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    return text;
  }

 private:
  int fd_;
};

class SocketsTest : public NetworkTest {
 protected:
  void SetUp() override {
    NetworkTest::SetUp();
    gateway_ =
        *SocketGateway::create(network_, sink_, [this](const std::string& line) { complaints_.push_back(line); });
  }
  void play() {
    tick();
    ASSERT_TRUE(gateway_->sense(now_).ok());
    for (auto& listener : listeners_)
      if (listener->host) bus_.deliver(listener->host->participant());
    ASSERT_TRUE(gateway_->act(now_).ok());
  }
  /// Ticks until that many lines have come; the kernel may need a moment.
  std::vector<std::string> wait_for(Listener& listener, std::size_t lines = 1) {
    for (int i = 0; i < 2000 && listener.log.size() < lines; ++i) {
      play();
      ::poll(nullptr, 0, 1);
    }
    return std::exchange(listener.log, {});
  }
  static std::uint16_t free_port(int type) { return Outside(type).port(); }

  std::vector<std::string> complaints_;
  std::unique_ptr<SocketGateway> gateway_;
};

TEST_F(SocketsTest, DatagramsGoBothWays) {
  Outside program(SOCK_DGRAM);
  Listener& agent = environment_host("agent");
  const std::uint16_t port = free_port(SOCK_DGRAM);
  const LinkId link = agent.host->open_datagrams(program.port(), port);
  program.send_to(port, "hello");
  EXPECT_THAT(wait_for(agent), ElementsAre("1 gets hello from 127.0.0.1:" + std::to_string(program.port())));
  agent.host->send(link, "answer");
  play();
  EXPECT_EQ(program.receive(), "answer");
  agent.host->close(link);
  program.send_to(port, "late");
  play();
  EXPECT_THAT(agent.log, IsEmpty());
}

TEST_F(SocketsTest, AFloodIsTakenInPieces) {
  Outside program(SOCK_DGRAM);
  Listener& agent = environment_host("agent");
  const std::uint16_t port = free_port(SOCK_DGRAM);
  agent.host->open_datagrams(program.port(), port);
  for (int i = 0; i < SocketGateway::kDatagramsPerTick + 100; ++i) program.send_to(port, "x");
  play();
  EXPECT_LE(agent.log.size(), static_cast<std::size_t>(SocketGateway::kDatagramsPerTick));
}

TEST_F(SocketsTest, WhatStaysInsideDoesNotTouchTheSockets) {
  Listener &a = environment_host("a"), &b = environment_host("b");
  const std::uint16_t one = free_port(SOCK_DGRAM), two = free_port(SOCK_DGRAM);
  const LinkId link = a.host->open_datagrams(two, one);
  b.host->open_datagrams(one, two);
  a.host->send(link, "hello");
  play();
  play();
  EXPECT_THAT(b.log, ElementsAre("1 gets hello from 127.0.0.1:" + std::to_string(one)));
}

TEST_F(SocketsTest, AProgramOutsideConnectsToAServerInside) {
  Listener& agent = environment_host("agent");
  const std::uint16_t port = free_port(SOCK_STREAM);
  const LinkId server = agent.host->listen(port);
  Outside program(SOCK_STREAM);
  ASSERT_TRUE(program.connect(port));
  program.send("early");
  EXPECT_THAT(wait_for(agent, 2),
              ElementsAre("2 of 1 is accepted from 127.0.0.1:" + std::to_string(program.port()), "2 reads early"));
  agent.host->send(agent.accepted, "hello");
  play();
  EXPECT_EQ(program.receive(), "hello");
  agent.host->close(server);
  play();
  EXPECT_EQ(program.receive(), "");
  EXPECT_FALSE(Outside(SOCK_STREAM).connect(port));
}

TEST_F(SocketsTest, AProgramOutsideThatEndsClosesItsStream) {
  Listener& agent = environment_host("agent");
  const std::uint16_t port = free_port(SOCK_STREAM);
  agent.host->listen(port);
  {
    Outside program(SOCK_STREAM);
    ASSERT_TRUE(program.connect(port));
    EXPECT_THAT(wait_for(agent, 1), ::testing::SizeIs(1));
    program.send("last words");
  }
  EXPECT_THAT(wait_for(agent, 2), ElementsAre("2 reads last words", "2 is closed: the program outside has closed it"));
}

TEST_F(SocketsTest, AClientInsideReachesAServerOutside) {
  Outside server(SOCK_STREAM);
  server.listen();
  Listener& agent = environment_host("agent");
  const LinkId link = agent.host->connect(server.port());
  EXPECT_THAT(wait_for(agent), ElementsAre("1 is connected"));
  {
    Outside program(server);
    EXPECT_TRUE(agent.host->send(link, "hello"));
    play();
    EXPECT_EQ(program.receive(), "hello");
    program.send("you");
    EXPECT_THAT(wait_for(agent), ElementsAre("1 reads you"));
  }
  EXPECT_THAT(wait_for(agent), ElementsAre("1 is closed: the program outside has closed it"));
}

TEST_F(SocketsTest, AClientInsideIsRefusedWhereNobodyListens) {
  Listener& agent = environment_host("agent");
  agent.host->connect(free_port(SOCK_STREAM));
  const auto log = wait_for(agent);
  ASSERT_EQ(log.size(), 1u);
  EXPECT_THAT(log[0], ::testing::StartsWith("1 is closed: "));
}

TEST_F(SocketsTest, APortThatIsTakenIsReported) {
  Outside other(SOCK_DGRAM);
  environment_host("agent").host->open_datagrams(1, other.port());
  EXPECT_THAT(complaints_, ElementsAre("UDP port " + std::to_string(other.port()) +
                                       " cannot be opened for programs outside: Address already in use"));
}

}  // namespace
}  // namespace cxlab::net
