#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <thread>

#include "folder.h"
#include "lab/control/client.h"
#include "lab/control/server.h"
#include "lab/view/players.h"

namespace cxlab::lab {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using Line = ControlServer::Line;

TEST(ControlAddressTest, IsAPathOrAPortOfThisMachine) {
  EXPECT_EQ(ControlAddress::parse("/tmp/a.sock")->path, "/tmp/a.sock");
  EXPECT_EQ(ControlAddress::parse("127.0.0.1:80")->port, 80);
  EXPECT_EQ(ControlAddress::parse("localhost:65535")->text(), "127.0.0.1:65535");
  EXPECT_EQ(ControlAddress::parse("./0.0.0.0:80")->path, "./0.0.0.0:80");
  EXPECT_EQ(ControlAddress::parse("run:2x")->path, "run:2x");
  EXPECT_EQ(ControlAddress::parse(std::string(107, 'x'))->path.size(), 107u);
  const std::vector<std::string> all_wrong{"127.0.0.1:", "127.0.0.1:65536", "localhost:-1", "localhost:x",
                                           "0.0.0.0:80", "robot:80",        "[::1]:80",     std::string(108, 'x')};
  for (const std::string& wrong : all_wrong) EXPECT_FALSE(ControlAddress::parse(wrong)) << wrong;
}

class ControlServerTest : public FolderTest {
 protected:
  ControlAddress here() const { return {.path = path("c.sock").string()}; }
  std::unique_ptr<ControlServer> open(const ControlAddress& address) const {
    auto server = ControlServer::open(address);
    EXPECT_TRUE(server) << (server ? "" : server.error().text());
    return *std::move(server);
  }
  static Line next(ControlServer& server) {
    auto line = server.take(10s);
    EXPECT_TRUE(line) << "nothing came";
    return line ? *line : Line();
  }
  /// A client without any protocol.
  int connect() const {
    const int at = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path("c.sock").string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::connect(at, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return at;
  }
};

TEST_F(ControlServerTest, HandsOutWholeLinesInOrder) {
  const auto server = open(here());
  const int at = connect();
  EXPECT_TRUE(next(*server).came);
  ASSERT_EQ(::write(at, "first\nsec", 9), 9);
  EXPECT_EQ(next(*server).text, "first");
  EXPECT_FALSE(server->take(50ms));
  ASSERT_EQ(::write(at, "ond\r\nthird\n", 11), 11);
  EXPECT_EQ(next(*server).text, "second");
  EXPECT_EQ(next(*server).text, "third");
  ::close(at);
  EXPECT_TRUE(next(*server).went);
}

TEST_F(ControlServerTest, SendsToOneOrToAll) {
  const auto server = open(here());
  const int first = connect();
  const std::uint64_t id = next(*server).client;
  const int second = connect();
  EXPECT_NE(next(*server).client, id);
  server->send(id, "one");
  server->send_all("all");
  server->send(99, "nobody");
  char buffer[32];
  std::string got;
  while (got.size() < 8) got.append(buffer, static_cast<std::size_t>(::read(first, buffer, sizeof buffer)));
  EXPECT_EQ(got, "one\nall\n");
  EXPECT_EQ(::read(second, buffer, sizeof buffer), 4);
  ::close(first);
  ::close(second);
}

TEST_F(ControlServerTest, LetsEightInAndCutsOffALineWithoutAnEnd) {
  const auto server = open(here());
  std::vector<int> all;
  for (int i = 0; i < 8; ++i) {
    all.push_back(connect());
    EXPECT_TRUE(next(*server).came);
  }
  all.push_back(connect());
  char said[256] = {};
  EXPECT_GT(::read(all.back(), said, sizeof said - 1), 0);
  EXPECT_THAT(said, testing::HasSubstr("eight are attached to this run already"));
  EXPECT_EQ(::read(all.back(), said, sizeof said), 0);
  const std::string endless(1'100'000, 'x');
  std::size_t sent = 0;
  for (ssize_t n = 1; sent < endless.size() && n > 0; sent += n > 0 ? static_cast<std::size_t>(n) : 0)
    n = ::send(all[0], endless.data() + sent, endless.size() - sent, MSG_NOSIGNAL);
  EXPECT_TRUE(next(*server).went);
  for (const int at : all) ::close(at);
}

TEST_F(ControlServerTest, TakesTheTokenBeforeAnythingElse) {
  const auto server = open({.path = "", .port = 0});
  EXPECT_NE(server->address().port, 0);
  EXPECT_EQ(server->token().size(), 32u);
  EXPECT_NE(open({.path = "", .port = 0})->token(), server->token());
  std::thread answers([&] {
    while (const auto line = server->take(10s)) {
      if (line->came) server->send(line->client, R"({"event": "hello", "text": ""})");
      if (line->went) break;
    }
  });
  EXPECT_FALSE(ControlClient::connect(server->address(), "no"));
  EXPECT_FALSE(ControlClient::connect(server->address(), server->token() + "0"));
  EXPECT_TRUE(ControlClient::connect(server->address(), server->token()));
  answers.join();
}

TEST_F(ControlServerTest, StrangersWithoutATokenLockNobodyOut) {
  const auto server = open({.path = "", .port = 0});
  std::vector<std::unique_ptr<ControlClient>> attached;
  std::thread answers([&] {
    while (const auto line = server->take(10s)) {
      if (line->came) server->send(line->client, R"({"event": "hello", "text": ""})");
      if (line->went) break;
    }
  });
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(server->address().port);
  std::vector<int> strangers;
  for (int i = 0; i < 20; ++i) {
    strangers.push_back(socket(AF_INET, SOCK_STREAM, 0));
    ASSERT_EQ(::connect(strangers.back(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  for (int i = 0; i < 8; ++i) {
    auto client = ControlClient::connect(server->address(), server->token());
    ASSERT_TRUE(client) << i << ": " << client.error().text();
    attached.push_back(*std::move(client));
  }
  const auto ninth = ControlClient::connect(server->address(), server->token());
  ASSERT_FALSE(ninth);
  EXPECT_EQ(ninth.error().kind, ErrorKind::kResource);
  attached.clear();
  answers.join();
  for (const int at : strangers) ::close(at);
}

TEST_F(ControlServerTest, TakesThePlaceOfASocketThatNobodyHearsAndOfNothingElse) {
  {
    const auto server = open(here());
    EXPECT_FALSE(ControlServer::open(here())) << "another run listens there";
    EXPECT_TRUE(std::filesystem::exists(here().path));
  }
  EXPECT_FALSE(std::filesystem::exists(here().path));
  write("c.sock", "a file");
  EXPECT_FALSE(ControlServer::open(here()));
  EXPECT_EQ(read("c.sock"), "a file");
  std::filesystem::remove(here().path);
  const int left = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  here().path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(left, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ::close(left);
  EXPECT_TRUE(ControlServer::open(here()));
}

/// A run of two seconds that is played on a thread of its own, stopped before its first rule.
class ControlledRunTest : public FolderTest {
 protected:
  void begin(const std::string& rules) {
    scenario("game", rules);
    run_ = std::thread([this] {
      PlayOptions options{.control_at = path("c.sock").string(), .begin_stopped = true};
      options.spec.journal = JournalLevel::kFull;
      played_ = play("game", options);
    });
    for (int i = 0; i < 1000 && !client_; ++i) {
      std::this_thread::sleep_for(10ms);
      if (auto client = ControlClient::connect({.path = path("c.sock").string()}, "")) client_ = *std::move(client);
    }
    ASSERT_TRUE(client_);
  }
  void TearDown() override {
    client_.reset();
    if (run_.joinable()) run_.join();
  }
  /// Its text; of what lets the run go on, where it stopped then.
  std::string ask(const std::string& line) {
    const auto answer = client_->carry_out(line);
    if (!answer) return answer.error().text();
    if (!answer->goes_on) return (answer->ok ? "" : "no: ") + answer->text;
    const auto stop = client_->wait_for_stop();
    return stop ? stop->text : stop.error().text();
  }

  std::unique_ptr<ControlClient> client_;
  std::thread run_;
  std::optional<Played> played_;
};

TEST_F(ControlledRunTest, StepsTicksAndEnds) {
  begin(
      "(deffacts start (a) (b))\n(defrule first (a) => (assert (c)))\n(defrule last (declare (salience -1)) (c) =>)\n");
  EXPECT_EQ(ask("why-not frst"), "no: there is no rule 'frst', did you mean 'first'?");
  EXPECT_THAT(ask("where"), HasSubstr("before rule first fires"));
  EXPECT_EQ(ask("facts c"), "none");
  EXPECT_THAT(ask("step"), HasSubstr("before rule last fires"));
  EXPECT_THAT(ask("facts c"), HasSubstr("(c)"));
  EXPECT_THAT(ask("tick 2"), HasSubstr("at the beginning of a tick"));
  EXPECT_THAT(ask("until 1.5"), HasSubstr("main at 1.500 s"));
  EXPECT_EQ(ask("until 1.0"), "no: that time has passed");
  EXPECT_THAT(ask("continue"), HasSubstr("2.000 s"));
}

TEST_F(ControlledRunTest, AConditionThatActsIsNotLookedAt) {
  begin("(deffunction note (?x) (assert (noted ?x)) TRUE)\n(deffunction same (?x) (eq ?x ?x))\n");
  ask("(defrule acts (go ?x) (test (note ?x)) =>)");
  ask("(defrule looks (go ?x) (test (same ?x)) =>)");
  EXPECT_EQ(ask("why-not acts"),
            "no: its conditions call 'note', which acts: to look would change the run; cxlab why-not looks when it is "
            "over");
  EXPECT_THAT(ask("why-not looks"), HasSubstr("condition 1 does not hold"));
  ask("continue");
}

TEST_F(ControlledRunTest, CompletesNamesOfCommandsRulesAndFunctions) {
  begin("(defrule globe (a) =>)\n");
  EXPECT_THAT(*client_->completions("glob"), ElementsAre("globals", "globe"));
  EXPECT_THAT(*client_->completions("now-"), ElementsAre("now-systime"));
  EXPECT_THAT(*client_->completions("zzz"), ElementsAre());
  ask("continue");
}

TEST_F(ControlledRunTest, ARuleThatIsBuiltFires) {
  begin("(defrule nothing (never) =>)\n");
  EXPECT_EQ(ask("(defrule mine (go ?x) => (assert (gone ?x)))"), "");
  EXPECT_THAT(ask("assert (go 4)"), HasSubstr("Fact-"));
  EXPECT_THAT(ask("until fact (gone 4)"), HasSubstr("fact (gone 4)"));
  EXPECT_THAT(ask("facts gone"), HasSubstr("(gone 4)"));
  ask("continue");
  run_.join();
  ASSERT_TRUE(played_);
  EXPECT_FALSE(played_->result.deterministic);
}

TEST_F(ControlledRunTest, ABreakPointStopsWheneverItsFactHasComeAgain) {
  begin(
      "(deffacts start (left 3))\n"
      "(defrule ring ?l <- (left ?n&~0) (not (bell ?)) => (retract ?l) (assert (bell ?n) (left (- ?n 1))))\n"
      "(defrule still ?b <- (bell ?) => (retract ?b))\n");
  EXPECT_EQ(ask("break fact (bell ?)"), "break point 1");
  for (const char* bell : {"(bell 3)", "(bell 2)", "(bell 1)"}) {
    EXPECT_THAT(ask("continue"), HasSubstr("before rule still fires"));
    EXPECT_THAT(ask("facts bell"), HasSubstr(bell));
  }
  EXPECT_THAT(ask("continue"), HasSubstr("2.000 s"));
}

TEST_F(ControlledRunTest, ABreakPointStopsOnceWhileItsFactStays) {
  begin("(deffacts start (n 3))\n(defrule count ?f <- (n ?n&~0) => (retract ?f) (assert (n (- ?n 1)) (begun)))\n");
  EXPECT_EQ(ask("break fact (begun)"), "break point 1");
  EXPECT_THAT(ask("continue"), HasSubstr("before rule count fires"));
  EXPECT_THAT(ask("facts n"), HasSubstr("(n 2)"));
  EXPECT_THAT(ask("continue"), HasSubstr("2.000 s"));
}

class PlayersTest : public ControlServerTest {};

TEST_F(PlayersTest, ReachOnlyRunsOfTheirPlace) {
  for (const char* folder : {"runs/a", "other"}) std::filesystem::create_directories(path(folder));
  std::filesystem::create_directory_symlink(path("other"), path("runs/link"));
  auto players = Players::start(path("runs"), shipped(), false, {});  // before there are threads
  ASSERT_TRUE(players) << (players ? "" : players.error().text());
  EXPECT_FALSE(players->is_live(path("runs/a"))) << "nobody listens yet";
  const auto here = open({.path = path("runs/a/control.sock").string()});
  const auto elsewhere = open({.path = path("other/control.sock").string()});
  EXPECT_TRUE(players->is_live(path("runs/a")));
  EXPECT_THAT(players->play(path("runs/a")).error().text(), Not(HasSubstr("expected a run of")));
  for (const char* folder : {"other", "runs/link", "runs/../other", "runs/nothing", "nothing"}) {
    EXPECT_FALSE(players->is_live(path(folder))) << folder;
    EXPECT_THAT(players->play(path(folder)).error().text(), HasSubstr("expected a run of")) << folder;
    EXPECT_THAT(players->compare(path("runs/a"), path(folder)).error().text(), HasSubstr("expected a run of"));
  }
}

}  // namespace
}  // namespace cxlab::lab
