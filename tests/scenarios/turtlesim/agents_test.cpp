// The agents that come with turtlesim, whole: what they do, that they leave nothing behind, and that it is the same
// again.

#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// Also remembers what was worse than information.
class Complaints final : public cx::LogSink {
 public:
  void line(const cx::LogLine& l) override {
    lines.line(l);
    if (l.level >= cx::LogLevel::kWarn) all.push_back(std::string(l.logger) + ": " + std::string(l.text));
  }
  Lines lines;
  std::vector<std::string> all;
};

class TurtleAgentsTest : public EpisodeTest {
 protected:
  Result run(const std::string& name, const std::vector<Override>& set = {}, const std::string& folder = {}) {
    auto scenario = Scenario::load(source_dir() / "scenarios/turtlesim" / (name + ".yaml"), shipped(), set);
    EXPECT_TRUE(scenario.ok()) << scenario.error().text();
    const auto episode = complained(*scenario, folder);
    begin(*episode);
    play(*episode, 1e9);
    const Result result = episode->close(RunStatus::kCompleted);
    EXPECT_FALSE(result.reason) << result.reason->text();
    const Status expected = check_expectations(scenario->expect, result.to_json());
    EXPECT_TRUE(expected.ok()) << expected.error().text();
    return result;
  }
  /// An episode whose complaints are kept.
  std::unique_ptr<Episode> complained(const Scenario& scenario, const std::string& folder = {}) {
    EpisodeOptions made = options(folder);
    made.spec = {};
    made.log = &complaints_;
    return load(scenario, std::move(made));
  }
  Complaints complaints_;
};

TEST_F(TurtleAgentsTest, AllMeetTheirExpectationsAndLeaveNothingBehind) {
  for (const char* name : {"boundary", "figures", "hypotheses"}) run(name);
  EXPECT_THAT(complaints_.all, IsEmpty());
}

TEST_F(TurtleAgentsTest, NothingIsLeftWhenFiguresEndInTheMidstOfIt) {
  for (const char* end : {"0.02", "0.05", "7"}) {
    auto scenario = Scenario::load(source_dir() / "scenarios/turtlesim/figures.yaml", shipped(),
                                   {std::string("duration_s=") + end});
    scenario->expect.clear();
    const auto episode = complained(*scenario);
    begin(*episode);
    play(*episode, 1e9);
    EXPECT_FALSE(episode->close(RunStatus::kCompleted).reason);
    EXPECT_THAT(complaints_.all, IsEmpty()) << "at " << end;
  }
}

TEST_F(TurtleAgentsTest, TheTurtleIsSentHomeAsSoonAsTurtlesimIsThere) {
  run("boundary_late");
  EXPECT_THAT(complaints_.lines.with("Starting turtlesim"), ElementsAre(testing::StartsWith("5.008")));
  EXPECT_THAT(complaints_.lines.with("is home again"), SizeIs(1));
  EXPECT_THAT(complaints_.all, ElementsAre(testing::HasSubstr("service turtle1/teleport_absolute not available")));
}

TEST_F(TurtleAgentsTest, TwoHypothesesAboutOneTurtle) {
  run("hypotheses");
  EXPECT_THAT(complaints_.lines.with("hypothesis '"),
              ElementsAre(testing::HasSubstr("'straight': SUPPORTED"), testing::HasSubstr("'turning': SUPPORTED"),
                          testing::HasSubstr("'straight': REFUTED")));
}

TEST_F(TurtleAgentsTest, TheSameAgainToTheLastBit) {
  for (const char* name : {"boundary", "figures", "hypotheses"}) {
    const Result first = run(name, {}, std::string(name) + "_1"), second = run(name);
    EXPECT_EQ(first.journal_hash, second.journal_hash) << name << ", with and without files";
    EXPECT_EQ(first.physics_hash, second.physics_hash) << name;
  }
}

}  // namespace
}  // namespace cxlab
