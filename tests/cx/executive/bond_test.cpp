#include "tests/support/caller.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct BondTest : ::testing::Test {
  BondTest() {
    lab.agent("");
    lab.options.params = {{"clips_manager.bond_heartbeat_period", "0.1"}};
  }
  Bond::Options options() const {
    Bond::Options o;
    o.id = "clips_manager";
    o.instance = "watcher";
    o.period = from_seconds(0.1);
    o.timeout = from_seconds(0.5);
    o.connect_timeout = from_seconds(1);
    return o;
  }
  /// A node that keeps something for each peer, until the peer is lost.
  void play(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      lab.ticks(1);
      lab.bus.deliver(caller.node());
      watcher.act();
    }
  }
  Lab lab;
  Caller caller{lab};
  std::vector<std::string> kept{"clips_manager"}, told;
  BondWatcher watcher{lab.bus, caller.node(), [this](const std::string& id, Bond::Loss loss) {
                        std::erase(kept, id);
                        told.push_back(id + ' ' + std::string(to_string(loss)));
                      }};
};

TEST_F(BondTest, HoldsWhileBothLive) {
  lab.run_up();
  ASSERT_TRUE(watcher.watch(options()).ok());
  play(200);
  EXPECT_THAT(watcher.watched(), ElementsAre("clips_manager"));
  EXPECT_THAT(told, IsEmpty());
}

TEST_F(BondTest, BeatsInItsPeriodOfSimulatedTime) {
  int beats = 0;
  lab.run_up();
  ASSERT_TRUE(lab.bus
                  .subscribe(caller.node(), "/bond", **lab.registry.message("bond/msg/Status"),
                             [&](const bus::Delivery& d) {
                               EXPECT_EQ(d.message->view().text("id"), "clips_manager");
                               EXPECT_NEAR(d.message->view().real("heartbeat_period"), 0.1, 1e-6);
                               EXPECT_NEAR(d.message->view().real("heartbeat_timeout"), 4, 1e-6);
                               ++beats;
                             })
                  .ok());
  play(51);  // 0 .. 1 s
  EXPECT_EQ(beats, 11);
}

TEST_F(BondTest, AManagerThatDeactivatesSaysGoodBye) {
  lab.run_up();
  ASSERT_TRUE(watcher.watch(options()).ok());
  play(20);
  ASSERT_TRUE(lab.manager->deactivate().ok());
  play(1);
  EXPECT_THAT(told, ElementsAre("clips_manager said good-bye"));
  EXPECT_THAT(kept, IsEmpty()) << "what was kept for it is cleaned up";
  EXPECT_THAT(watcher.watched(), IsEmpty());
}

TEST_F(BondTest, AManagerThatIsLostIsNoticedAfterTheTimeout) {
  lab.run_up();
  ASSERT_TRUE(watcher.watch(options()).ok());
  play(20);
  lab.bus.leave(*lab.bus.find_node("/clips_manager"));
  play(20);
  EXPECT_THAT(told, IsEmpty());
  play(10);
  EXPECT_THAT(told, ElementsAre("clips_manager is silent"));
  EXPECT_THAT(kept, IsEmpty());
  play(50);
  EXPECT_EQ(told.size(), 1u) << "once";
}

TEST_F(BondTest, APeerThatNeverComesIsNoticed) {
  lab.options.params.clear();
  lab.run_up();
  ASSERT_TRUE(watcher.watch(options()).ok());
  play(60);
  EXPECT_THAT(told, ElementsAre("clips_manager never came"));
}

TEST_F(BondTest, TheManagerNoticesThatItsWatcherIsLost) {
  lab.run_up();
  Bond::Options patient = options();
  ASSERT_TRUE(watcher.watch(patient).ok());
  play(20);
  watcher.forget("clips_manager");
  play(2);
  EXPECT_EQ(lab.log.with("warn clips_manager: the peer of its bond said good-bye").size(), 1u);
}

TEST_F(BondTest, NeedsAPeriod) {
  Bond::Options o = options();
  o.period = {};
  EXPECT_FALSE(watcher.watch(o).ok());
}

}  // namespace
}  // namespace cxlab::cx
