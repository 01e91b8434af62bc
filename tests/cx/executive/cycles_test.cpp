// Environments that come and go a thousand times: what they leave behind. Long: ctest -L long -R cx_executive_cycles.

#include <malloc.h>

#include <functional>

#include "cx/plugins/bindings/names.h"
#include "tests/support/caller.h"

namespace cxlab::cx {
namespace {

/// Bytes that the program holds, by the allocator's own count.
std::size_t held() {
#if defined(__SANITIZE_ADDRESS__)
  return 0;  // its allocator is another; leaks are its own business
#else
  malloc_trim(0);
  return mallinfo2().uordblks;
#endif
}

/// What the rules of an environment do with the plugins in each cycle.
constexpr const char* kRules = R"((deftemplate thing (slot a))
(deffunction std-srvs-set-bool-service-callback (?service ?request ?response)
  (std-srvs-set-bool-response-set-field ?response "success" (std-srvs-set-bool-request-get-field ?request "data")))
(defrule open (time ?) (not (opened)) =>
  (assert (opened))
  (ros-msgs-create-publisher "out" "std_msgs/msg/String") (ros-msgs-create-subscription "out" "std_msgs/msg/String")
  (std-msgs-string-create-subscription "out")
  (std-srvs-set-bool-create-service "power") (std-srvs-set-bool-create-client "power")
  (example-interfaces-fibonacci-create-server "count") (example-interfaces-fibonacci-create-client "count")
  (tf2-start-periodic-lookup map robot 50.0))
(defrule say (time ?t) =>
  (bind ?m (ros-msgs-create-message "std_msgs/msg/String")) (ros-msgs-set-field ?m "data" (str-cat ?t))
  (ros-msgs-publish ?m "out") (ros-msgs-destroy-message ?m) (assert (thing (a ?t))))
(defrule hear ?f <- (ros-msgs-message (msg-ptr ?m)) => (ros-msgs-destroy-message ?m) (retract ?f))
(defrule hear-too ?f <- (std-msgs-string-message (msg-ptr ?m)) => (std-msgs-string-destroy-message ?m) (retract ?f))
(defrule ask (std-srvs-set-bool-client (service ?s)) =>
  (bind ?r (std-srvs-set-bool-request-create)) (std-srvs-set-bool-request-set-field ?r "data" TRUE)
  (std-srvs-set-bool-send-request ?r ?s) (std-srvs-set-bool-request-destroy ?r))
(defrule answered ?f <- (std-srvs-set-bool-response (msg-ptr ?m)) =>
  (assert (powered (std-srvs-set-bool-response-get-field ?m "success"))) (std-srvs-set-bool-response-destroy ?m) (retract ?f))
(defrule send (example-interfaces-fibonacci-client (server ?s)) =>
  (bind ?g (example-interfaces-fibonacci-goal-create)) (example-interfaces-fibonacci-goal-set-field ?g "order" 3)
  (example-interfaces-fibonacci-send-goal ?g ?s) (example-interfaces-fibonacci-goal-destroy ?g))
(defrule count ?f <- (example-interfaces-fibonacci-accepted-goal (server-goal-handle-ptr ?h)) =>
  (bind ?b (example-interfaces-fibonacci-feedback-create)) (example-interfaces-fibonacci-feedback-set-field ?b "sequence" (create$ 0 1))
  (example-interfaces-fibonacci-server-goal-handle-publish-feedback ?h ?b) (example-interfaces-fibonacci-feedback-destroy ?b)
  (bind ?r (example-interfaces-fibonacci-result-create)) (example-interfaces-fibonacci-result-set-field ?r "sequence" (create$ 0 1 1))
  (example-interfaces-fibonacci-server-goal-handle-succeed ?h ?r) (example-interfaces-fibonacci-result-destroy ?r)
  (example-interfaces-fibonacci-server-goal-handle-destroy ?h) (retract ?f))
(defrule told ?f <- (example-interfaces-fibonacci-goal-feedback (feedback-ptr ?m)) => (example-interfaces-fibonacci-feedback-destroy ?m) (retract ?f))
(defrule counted ?f <- (example-interfaces-fibonacci-goal-response (client-goal-handle-ptr ?h)) ?g <- (example-interfaces-fibonacci-wrapped-result (code ?c) (result-ptr ?m)) =>
  (assert (counted ?c)) (example-interfaces-fibonacci-result-destroy ?m) (example-interfaces-fibonacci-client-goal-handle-destroy ?h) (retract ?f ?g))
)";

class Cycles : public ::testing::Test {
 protected:
  /// An environment "extra" of all plugins and the classes of bindings, which the manager makes when it is asked to.
  void configure(const std::vector<std::string>& bindings, const std::string& rules) {
    std::string names, sections;
    const auto add = [&](const std::string& name, const std::string& type) {
      names += '"' + name + "\", ";
      sections += name + ": {plugin: \"" + type + "\"}\n";
    };
    for (const PluginType& type : builtin_plugins())
      if (!type.has && type.name != "cx::FileLoadPlugin") add(type.name.substr(4), type.name);
    for (const std::string& type : bindings) add(type.substr(4), type);
    lab_.config(
        "environments: []\nextra: {plugins: [" + names +
        "\"files\"]}\nfiles: {plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [\"agent\"], load: [\"rules.clp\"]}\n" +
        sections);
    lab_.write("agent/rules.clp", rules);
    lab_.run_up();
  }

  /// Bytes that are left behind by a cycle: the environment comes, `run` plays in it, and it goes.
  double left_by_each(int cycles, const std::function<void()>& run) {
    const auto cycle = [&] {
      const Status made = lab_.manager->create_environment("extra");
      ASSERT_TRUE(made.ok()) << made.error().text();
      run();
      ASSERT_TRUE(lab_.manager->destroy_environment("extra").ok());
      lab_.log.lines.clear();
      lab_.records.forget();
    };
    for (int i = 0; i < cycles / 10 && !HasFatalFailure(); ++i) cycle();
    const std::size_t before = held();
    for (int i = 0; i < cycles && !HasFatalFailure(); ++i) cycle();
    const std::size_t after = held();
    const double each = (static_cast<double>(after) - static_cast<double>(before)) / cycles;
    RecordProperty("bytes_per_cycle", std::to_string(each));
    std::printf("%.1f MB held, %.0f bytes more a cycle\n", static_cast<double>(after) / 1e6, each);
    return each;
  }
  Lab lab_;
};

TEST_F(Cycles, AThousandEnvironmentsWithAllPluginsLeaveTheMemoryFlat) {
  configure({"cx::CXStdMsgsStringPlugin", "cx::CXStdSrvsSetBoolPlugin", "cx::CXExampleInterfacesFibonacciPlugin"},
            kRules);
  const double each = left_by_each(1000, [&] {
    lab_.ticks(26);
    ASSERT_GT(lab_.facts("thing", "extra").size(), 0u) << "it ran";
    ASSERT_THAT(lab_.facts("powered", "extra"), ::testing::SizeIs(1)) << "the service answered";
    ASSERT_THAT(lab_.facts("counted", "extra"), ::testing::ElementsAre(::testing::HasSubstr("SUCCEEDED")))
        << "the goal was reached";
    ASSERT_THAT(lab_.log.with("TF lookup failed"), ::testing::Not(::testing::IsEmpty())) << "the tracker looked";
  });
  EXPECT_LT(each, 1024) << "a place on the bus keeps its name and number";
}

TEST_F(Cycles, TheBindingsOfEveryInterfaceLeaveTheMemoryFlat) {
  configure(binding_classes(lab_.registry),
            "(deftemplate thing (slot a))\n(defrule count (time ?t) => (assert (thing (a ?t))))");
  const double each = left_by_each(200, [&] {
    lab_.ticks(6);
    ASSERT_GT(lab_.facts("thing", "extra").size(), 0u) << "it ran";
  });
  EXPECT_LT(each, 1024);
}

}  // namespace
}  // namespace cxlab::cx
