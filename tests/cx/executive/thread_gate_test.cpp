// Plugins with a thread of their own.

#include <atomic>

#include "cx/executive/thread_gate.h"
#include "tests/support/caller.h"
#include "tests/support/causes.h"

namespace cxlab::cx {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A thread that does what the test hands to it, until the plugin is unloaded.
class Worker final : public Plugin {
 public:
  using Job = std::function<void(ThreadGate&)>;
  Worker(PluginContext context, Job job) : Plugin(std::move(context)), job_(std::move(job)) {}

  Status clips_env_init(EnvironmentGuard environment) override {
    auto gate = environment->open_gate(name());
    if (!gate) return gate.error();
    gate_ = *gate;
    thread_ = std::thread([this] { job_(*gate_); });
    return {};
  }
  void clips_env_destroyed(EnvironmentGuard) override { thread_.join(); }

 private:
  Job job_;
  std::shared_ptr<ThreadGate> gate_;
  std::thread thread_;
};

struct ThreadGateTest : ::testing::Test {
  void start(Worker::Job job) {
    lab.config(R"(environments: ["main"]
main: {plugins: ["executive", "files", "worker"]}
executive: {plugin: "cx::ExecutivePlugin"}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]}
worker: {plugin: "test::Worker"})");
    lab.write("agent/rules.clp",
              "(deffunction double (?x) (* 2 ?x))\n(defrule scan (scan ?x) => (println \"scan \" ?x))");
    lab.options.plugin_types.push_back({"test::Worker", {}, [this, job](PluginContext c) {
                                          return std::make_unique<Worker>(std::move(c), [this, job](ThreadGate& gate) {
                                            job(gate);
                                            done = true;
                                          });
                                        }});
    lab.run_up();
  }
  /// Ticks until the thread has ended; it takes as many as it takes.
  void until_done() {
    for (int i = 0; i < 100'000 && !done; ++i) {
      const Status s = lab.tick();
      ASSERT_TRUE(s.ok()) << s.error().text();
    }
    ASSERT_TRUE(done);
    lab.ticks(6);
  }
  Lab lab;
  Caller caller{lab};
  std::atomic<bool> done = false;
};

TEST_F(ThreadGateTest, AThreadAssertsCallsRetractsAndPublishes) {
  std::string heard;
  ASSERT_TRUE(lab.bus
                  .subscribe(caller.node(), "/word", **lab.registry.message("std_msgs/msg/String"),
                             [&](const bus::Delivery& d) { heard = d.message->view().text("data"); })
                  .ok());
  std::vector<std::string> answers;
  start([&](ThreadGate& gate) {
    const auto index = gate.assert_fact("(scan 1.5)").get();
    answers.push_back(index ? index->print() : index.error().text());
    const auto doubled = gate.call("(double 21)").get();
    answers.push_back(doubled ? doubled->print() : doubled.error().text());
    const auto other = gate.assert_fact("(kept)").get();
    const auto gone = gate.retract(other->as_integer()).get();
    answers.push_back(gone->print());
    answers.push_back(gate.retract(4711).get()->print());
    answers.push_back(gate.publish("word", "std_msgs/msg/String", "{data: hello}").get() ? "published" : "refused");
  });
  until_done();
  caller.take();
  EXPECT_EQ(answers.size(), 5u);
  EXPECT_THAT(std::vector<std::string>(answers.begin() + 1, answers.end()),
              ElementsAre("42", "TRUE", "FALSE", "published"));
  EXPECT_EQ(heard, "hello");
  EXPECT_EQ(lab.log.with("main: scan 1.5").size(), 1u);
  EXPECT_FALSE(lab.manager->deterministic());
  EXPECT_THAT(causes_of(lab.records, "scan"), ElementsAre(AllOf(HasSubstr("input "), HasSubstr("thread"),
                                                                HasSubstr("worker"), HasSubstr("(scan 1.5)"))));
  ASSERT_TRUE(lab.manager->deactivate().ok());
}

TEST_F(ThreadGateTest, NothingHappensBetweenTicks) {
  start([](ThreadGate& gate) { (void)gate.assert_fact("(scan 2)"); });
  while (!done) std::this_thread::yield();
  EXPECT_TRUE(lab.facts("scan").empty());
  lab.ticks(1);
  EXPECT_EQ(lab.facts("scan").size(), 1u);
}

TEST_F(ThreadGateTest, AThreadThatNeverWaitsIsRefusedBeforeItFillsTheMemory) {
  std::string answer;
  start([&](ThreadGate& gate) {
    for (std::size_t i = 0; i < ThreadGate::kMostWaiting; ++i) (void)gate.retract(4711);
    answer = gate.assert_fact("(scan 2)").get().error().text();
  });
  while (!done) std::this_thread::yield();
  EXPECT_THAT(answer, HasSubstr("plugin 'worker': 10000 requests of its threads wait for a tick"));
  lab.ticks(2);
  EXPECT_TRUE(lab.facts("scan").empty());
}

TEST_F(ThreadGateTest, ABadRequestIsTheAnswerAndInTheLog) {
  std::string answer;
  start([&](ThreadGate& gate) { answer = gate.publish("word", "std_msgs/msg/Strin", "{}").get().error().text(); });
  until_done();
  EXPECT_THAT(answer, HasSubstr("std_msgs/msg/Strin"));
  EXPECT_EQ(lab.log.with("error worker: from a thread: ").size(), 1u);
}

TEST_F(ThreadGateTest, ThreadsHaveANodeBesideThatOfTheirEnvironment) {
  start([](ThreadGate&) {});
  until_done();
  const std::string node = lab.bus.name_of(lab.manager->find("main")->participant()).full_name();
  EXPECT_THAT(lab.bus.nodes(), testing::IsSupersetOf({node, node + "_threads"}));
}

TEST_F(ThreadGateTest, ATopicThatThreadsPublishKeepsItsType) {
  std::string answer;
  start([&](ThreadGate& gate) {
    EXPECT_TRUE(gate.publish("word", "std_msgs/msg/String", "{data: hello}").get().ok());
    answer = gate.publish("word", "std_msgs/msg/Int32", "{data: 1}").get().error().text();
    EXPECT_TRUE(gate.publish("word", "std_msgs/msg/String", "{data: again}").get().ok());
  });
  until_done();
  EXPECT_THAT(answer, HasSubstr("'/word' has type std_msgs/msg/String, found a second type std_msgs/msg/Int32"));
}

TEST_F(ThreadGateTest, AWaitingThreadIsFreedWhenItsPluginIsUnloaded) {
  std::string answer;
  start([&](ThreadGate& gate) {
    while (gate.assert_fact("(scan 3)").get()) continue;
    answer = gate.assert_fact("(scan 4)").get().error().text();
  });
  lab.ticks(3);
  EXPECT_EQ(caller.unload("main", "worker"), R"({success: true, error: ""})") << "though its thread waits for a tick";
  EXPECT_TRUE(done);
  EXPECT_THAT(answer, HasSubstr("plugin 'worker' is not loaded in the environment any more"));
}

TEST_F(ThreadGateTest, TheEpisodesThreadIsRefusedAndSoIsTheHandleOnOthers) {
  std::vector<std::string> thrown;
  Environment* environment = nullptr;
  std::unique_ptr<EnvironmentGuard> kept;
  std::atomic<bool> go = false;
  start([&](ThreadGate&) {
    while (!go) std::this_thread::yield();
    const auto attempt = [&](const std::function<void()>& use) {
      try {
        use();
        thrown.push_back("nothing");
      } catch (const std::logic_error& e) {
        thrown.push_back(e.what());
      }
    };
    attempt([&] { EnvironmentGuard made(*environment); });
    const EnvironmentGuard copy = *kept;
    attempt([&] { (void)copy->now(); });
    attempt([&] { (void)*copy; });
    attempt([&] { (void)copy.engine(); });
  });
  environment = lab.manager->find("main");
  kept = std::make_unique<EnvironmentGuard>(*environment);
  go = true;
  auto gate = environment->open_gate("here");
  ASSERT_TRUE(gate.ok());
  EXPECT_FALSE((*gate)->assert_fact("(scan 1)").get().ok());
  until_done();
  EXPECT_THAT(thrown, ElementsAre(HasSubstr("open_gate"), HasSubstr("open_gate"), HasSubstr("open_gate"),
                                  HasSubstr("open_gate")));
}

}  // namespace
}  // namespace cxlab::cx
