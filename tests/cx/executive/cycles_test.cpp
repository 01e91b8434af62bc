// Environments that come and go a thousand times: what they leave behind. Long: ctest -L long -R cx_executive_cycles.

#include <malloc.h>

#include "tests/cx/executive/caller.h"

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

TEST(Cycles, AThousandEnvironmentsWithAllPluginsLeaveTheMemoryFlat) {
  Lab lab;
  std::string names, sections;
  for (const PluginType& type : builtin_plugins()) {
    if (type.has || type.name == "cx::FileLoadPlugin") continue;
    const std::string name = type.name.substr(4);
    names += '"' + name + "\", ";
    sections += name + ": {plugin: \"" + type.name + "\"}\n";
  }
  lab.config("environments: []\nextra: {plugins: [" + names + "\"files\"]}\nfiles: {plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [\"agent\"], load: [\"rules.clp\"]}\n" + sections);
  lab.write("agent/rules.clp", R"((deftemplate thing (slot a))
(defrule open (time ?) (not (opened)) => (assert (opened)) (ros-msgs-create-publisher "out" "std_msgs/msg/String") (ros-msgs-create-subscription "out" "std_msgs/msg/String"))
(defrule say (time ?t) => (bind ?m (ros-msgs-create-message "std_msgs/msg/String")) (ros-msgs-set-field ?m "data" (str-cat ?t))
  (ros-msgs-publish ?m "out") (ros-msgs-destroy-message ?m) (assert (thing (a ?t))))
(defrule hear ?f <- (ros-msgs-message (msg-ptr ?m)) => (ros-msgs-destroy-message ?m) (retract ?f)))");
  lab.run_up();
  const auto cycle = [&] {
    const Status made = lab.manager->create_environment("extra");
    ASSERT_TRUE(made.ok()) << made.error().text();
    lab.ticks(6);
    ASSERT_GT(lab.facts("thing", "extra").size(), 0u) << "it ran";
    ASSERT_TRUE(lab.manager->destroy_environment("extra").ok());
    lab.log.lines.clear();
    lab.records.forget();
  };
  for (int i = 0; i < 100 && !HasFatalFailure(); ++i) cycle();
  const std::size_t before = held();
  constexpr int kCycles = 1000;
  for (int i = 0; i < kCycles && !HasFatalFailure(); ++i) cycle();
  const std::size_t after = held();
  const double per_cycle = (static_cast<double>(after) - static_cast<double>(before)) / kCycles;
  RecordProperty("bytes_per_cycle", std::to_string(per_cycle));
  std::printf("%.1f MB held, %.0f bytes more a cycle\n", static_cast<double>(after) / 1e6, per_cycle);
  EXPECT_LT(per_cycle, 1024) << "a place on the bus keeps its name and number";
}

}  // namespace
}  // namespace cxlab::cx
