// The functions of each plugin, as docs/plugins describes them.

#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

/// A line for each: "NAME TYPE least-most TYPES kind": what it returns, how many arguments of which types it takes, and
/// what it does.
std::string functions_of(const std::string& plugin) {
  Lab lab;
  lab.config("environments: [\"main\"]\nmain: {plugins: [\"p\"]}\np: {plugin: \"cx::" + plugin + "\"}");
  lab.run_up();
  std::string lines;
  for (const FunctionSpec& f : lab.engine().functions()) {
    if (f.owner != "p") continue;
    lines += f.name + ' ' + f.returns + ' ' + std::to_string(f.min_args) + '-' +
             (f.max_args == kAnyNumberOfArguments ? "any" : std::to_string(f.max_args)) + ' ' + f.arg_types +
             (f.kind == FunctionKind::kActing ? " acts\n" : "\n");
    EXPECT_FALSE(f.doc.empty()) << f.name;
  }
  return lines;
}

TEST(Functions, HaveTheirArguments) {
  EXPECT_EQ(functions_of("ExecutivePlugin"),
            "now d 0-0 \n"
            "now-systime d 0-0 \n");
  EXPECT_EQ(functions_of("ConfigPlugin"), "config-load v 2-2 ;sy;sy acts\n");
  EXPECT_EQ(functions_of("AmentIndexPlugin"),
            "ament-index-get-package-prefix sb 1-1 ;sy\n"
            "ament-index-get-package-share-directory sb 1-1 ;sy\n"
            "ament-index-get-packages-with-prefixes mb 0-0 \n"
            "ament-index-get-resource bm 2-2 ;sy;sy\n"
            "ament-index-get-resources mb 1-1 ;sy\n"
            "ament-index-get-search-paths m 0-0 \n"
            "ament-index-has-resource bs 2-2 ;sy;sy\n");
  EXPECT_EQ(functions_of("FileLoadPlugin"), "");
  EXPECT_EQ(functions_of("ProtobufPlugin"),
            "pb-add-list v 3-3 ;e;sy;* acts\n"
            "pb-broadcast v 2-2 ;l;e acts\n"
            "pb-connect l 2-2 ;sy;l acts\n"
            "pb-create e 1-1 ;sy acts\n"
            "pb-destroy v 1-1 ;e acts\n"
            "pb-disconnect v 1-1 ;l acts\n"
            "pb-field-is-list b 2-2 ;e;sy\n"
            "pb-field-label y 2-2 ;e;sy\n"
            "pb-field-list ym 2-2 ;e;sy\n"
            "pb-field-names mb 1-1 ;e\n"
            "pb-field-type y 2-2 ;e;sy\n"
            "pb-field-value * 2-2 ;e;sy\n"
            "pb-has-field b 2-2 ;e;sy\n"
            "pb-peer-create l 2-2 ;s;l acts\n"
            "pb-peer-create-crypto l 4-4 ;sy;l;sy;sy acts\n"
            "pb-peer-create-local l 3-3 ;sy;l;l acts\n"
            "pb-peer-create-local-crypto l 5-5 ;sy;l;l;sy;sy acts\n"
            "pb-peer-destroy v 1-1 ;l acts\n"
            "pb-peer-setup-crypto v 3-3 ;l;sy;sy acts\n"
            "pb-register-type b 1-1 ;sy acts\n"
            "pb-send v 2-2 ;l;e acts\n"
            "pb-server-disable v 0-0  acts\n"
            "pb-server-enable v 1-1 ;l acts\n"
            "pb-set-field v 3-3 ;e;sy;* acts\n"
            "pb-tostring sy 1-1 ;e\n");
  EXPECT_EQ(functions_of("RosParamPlugin"), "ros-param-get-value * 2-2 ;sy;*\n");
  EXPECT_EQ(functions_of("Tf2PoseTrackerPlugin"),
            "tf2-start-periodic-lookup b 3-3 ;sy;sy;d acts\n"
            "tf2-stop-periodic-lookup b 1-1 ;e acts\n");
  EXPECT_EQ(functions_of("RosMsgsPlugin"),
            "ros-msgs-async-cancel-goal v 2-2 ;sy;e acts\n"
            "ros-msgs-async-send-goal v 2-2 ;e;sy acts\n"
            "ros-msgs-async-send-request bl 2-2 ;e;sy acts\n"
            "ros-msgs-client-goal-handle-get-goal-id y 1-1 ;e\n"
            "ros-msgs-client-goal-handle-get-goal-stamp d 1-1 ;e\n"
            "ros-msgs-client-goal-handle-get-status y 1-1 ;e\n"
            "ros-msgs-client-goal-handle-is-feedback-aware b 1-1 ;e\n"
            "ros-msgs-client-goal-handle-is-result-aware b 1-1 ;e\n"
            "ros-msgs-create-action-client v 2-2 ;sy;sy acts\n"
            "ros-msgs-create-client v 2-2 ;sy;sy acts\n"
            "ros-msgs-create-goal-request e 1-1 ;sy acts\n"
            "ros-msgs-create-message e 1-1 ;sy acts\n"
            "ros-msgs-create-publisher v 2-2 ;sy;sy acts\n"
            "ros-msgs-create-request e 1-1 ;sy acts\n"
            "ros-msgs-create-service v 2-2 ;sy;sy acts\n"
            "ros-msgs-create-subscription v 2-2 ;sy;sy acts\n"
            "ros-msgs-destroy-action-client v 1-1 ;sy acts\n"
            "ros-msgs-destroy-client v 1-1 ;sy acts\n"
            "ros-msgs-destroy-client-goal-handle v 1-1 ;e acts\n"
            "ros-msgs-destroy-message v 1-1 ;e acts\n"
            "ros-msgs-destroy-publisher v 1-1 ;sy acts\n"
            "ros-msgs-destroy-service v 1-1 ;sy acts\n"
            "ros-msgs-destroy-subscription v 1-1 ;s acts\n"
            "ros-msgs-get-field * 2-2 ;e;sy\n"
            "ros-msgs-goal-uuid-to-string y 1-1 ;m\n"
            "ros-msgs-publish v 2-2 ;e;sy acts\n"
            "ros-msgs-set-field v 3-3 ;e;sy;* acts\n");
  EXPECT_EQ(functions_of("CXStdMsgsStringPlugin"),
            "std-msgs-string-create-message e 0-0  acts\n"
            "std-msgs-string-create-publisher v 1-1 ;sy acts\n"
            "std-msgs-string-create-subscription v 1-1 ;s acts\n"
            "std-msgs-string-destroy-message v 1-1 ;e acts\n"
            "std-msgs-string-destroy-publisher v 1-1 ;sy acts\n"
            "std-msgs-string-destroy-subscription v 1-1 ;s acts\n"
            "std-msgs-string-get-field * 2-2 ;e;sy\n"
            "std-msgs-string-publish v 2-2 ;e;sy acts\n"
            "std-msgs-string-set-field v 3-3 ;e;sy;* acts\n");
  EXPECT_EQ(functions_of("CXStdSrvsSetBoolPlugin"),
            "std-srvs-set-bool-create-client v 1-1 ;s acts\n"
            "std-srvs-set-bool-create-service v 1-1 ;sy acts\n"
            "std-srvs-set-bool-destroy-client v 1-1 ;s acts\n"
            "std-srvs-set-bool-destroy-service v 1-1 ;sy acts\n"
            "std-srvs-set-bool-request-create e 0-0  acts\n"
            "std-srvs-set-bool-request-destroy v 1-1 ;e acts\n"
            "std-srvs-set-bool-request-get-field * 2-2 ;e;sy\n"
            "std-srvs-set-bool-request-set-field v 3-3 ;e;sy;* acts\n"
            "std-srvs-set-bool-response-create e 0-0  acts\n"
            "std-srvs-set-bool-response-destroy v 1-1 ;e acts\n"
            "std-srvs-set-bool-response-get-field * 2-2 ;e;sy\n"
            "std-srvs-set-bool-response-set-field v 3-3 ;e;sy;* acts\n"
            "std-srvs-set-bool-send-request v 2-2 ;e;sy acts\n");
  EXPECT_EQ(functions_of("CXExampleInterfacesFibonacciPlugin"),
            "example-interfaces-fibonacci-client-cancel-all-goals v 1-1 ;sy acts\n"
            "example-interfaces-fibonacci-client-cancel-goal v 2-2 ;sy;e acts\n"
            "example-interfaces-fibonacci-client-cancel-goals-before v 2-2 ;sy;ld acts\n"
            "example-interfaces-fibonacci-client-goal-handle-destroy d 1-1 ;e acts\n"
            "example-interfaces-fibonacci-client-goal-handle-get-goal-id s 1-1 ;e\n"
            "example-interfaces-fibonacci-client-goal-handle-get-goal-stamp d 1-1 ;e\n"
            "example-interfaces-fibonacci-client-goal-handle-get-status l 1-1 ;e\n"
            "example-interfaces-fibonacci-client-goal-handle-is-feedback-aware b 1-1 ;e\n"
            "example-interfaces-fibonacci-client-goal-handle-is-result-aware b 1-1 ;e\n"
            "example-interfaces-fibonacci-create-client v 1-1 ;s acts\n"
            "example-interfaces-fibonacci-create-server v 1-1 ;sy acts\n"
            "example-interfaces-fibonacci-destroy-client v 1-1 ;s acts\n"
            "example-interfaces-fibonacci-destroy-server v 1-1 ;sy acts\n"
            "example-interfaces-fibonacci-feedback-create e 0-0  acts\n"
            "example-interfaces-fibonacci-feedback-destroy v 1-1 ;e acts\n"
            "example-interfaces-fibonacci-feedback-get-field * 2-2 ;e;sy\n"
            "example-interfaces-fibonacci-feedback-set-field v 3-3 ;e;sy;* acts\n"
            "example-interfaces-fibonacci-goal-create e 0-0  acts\n"
            "example-interfaces-fibonacci-goal-destroy v 1-1 ;e acts\n"
            "example-interfaces-fibonacci-goal-get-field * 2-2 ;e;sy\n"
            "example-interfaces-fibonacci-goal-set-field v 3-3 ;e;sy;* acts\n"
            "example-interfaces-fibonacci-result-create e 0-0  acts\n"
            "example-interfaces-fibonacci-result-destroy v 1-1 ;e acts\n"
            "example-interfaces-fibonacci-result-get-field * 2-2 ;e;sy\n"
            "example-interfaces-fibonacci-result-set-field v 3-3 ;e;sy;* acts\n"
            "example-interfaces-fibonacci-send-goal v 2-2 ;e;sy acts\n"
            "example-interfaces-fibonacci-server-goal-handle-abort v 2-2 ;e;e acts\n"
            "example-interfaces-fibonacci-server-goal-handle-canceled v 2-2 ;e;e acts\n"
            "example-interfaces-fibonacci-server-goal-handle-destroy d 1-1 ;e acts\n"
            "example-interfaces-fibonacci-server-goal-handle-execute v 1-1 ;e acts\n"
            "example-interfaces-fibonacci-server-goal-handle-get-goal e 1-1 ;e acts\n"
            "example-interfaces-fibonacci-server-goal-handle-get-goal-id s 1-1 ;e\n"
            "example-interfaces-fibonacci-server-goal-handle-is-active b 1-1 ;e\n"
            "example-interfaces-fibonacci-server-goal-handle-is-canceling b 1-1 ;e\n"
            "example-interfaces-fibonacci-server-goal-handle-is-executing b 1-1 ;e\n"
            "example-interfaces-fibonacci-server-goal-handle-publish-feedback v 2-2 ;e;e acts\n"
            "example-interfaces-fibonacci-server-goal-handle-succeed v 2-2 ;e;e acts\n");
}

constexpr const char* kPlugins[] = {
    "AmentIndexPlugin",      "ConfigPlugin",          "ExamplePlugin",  "ExecutivePlugin",
    "RosMsgsPlugin",         "Tf2PoseTrackerPlugin",  "RosParamPlugin", "CXExampleInterfacesFibonacciPlugin",
    "CXStdMsgsStringPlugin", "CXStdSrvsSetBoolPlugin"};

/// Starts the plugin "p" after these constructs.
Status start_after(Lab& lab, const std::string& plugin, const std::string& constructs) {
  lab.config(
      "environments: [\"main\"]\nmain: {plugins: [\"files\", \"p\"]}\nfiles: {plugin: \"cx::FileLoadPlugin\", "
      "pkg_share_dirs: [\"agent\"], load: [\"rules.clp\"]}\np: {plugin: \"cx::" +
      plugin + "\"}");
  lab.write("agent/rules.clp", constructs);
  return lab.start();
}

TEST(Functions, WhoseNamesAreTakenStopTheStart) {
  for (const std::string plugin : kPlugins) {
    Lab alone;
    ASSERT_TRUE(start_after(alone, plugin, "").ok()) << plugin;
    for (const FunctionSpec& f : alone.engine().functions()) {
      if (f.owner != "p") continue;
      Lab lab;
      const Status started = start_after(lab, plugin, "(deffunction " + f.name + " () 1)");
      ASSERT_FALSE(started.ok()) << plugin << ": " << f.name;
      EXPECT_THAT(started.error().text(), ::testing::HasSubstr(f.name)) << plugin;
    }
  }
}

TEST(Constructs, ThatDoNotFitThoseOfRulesStopTheStart) {
  Lab lab;
  const Status started = start_after(lab, "ExecutivePlugin", "(deftemplate time (slot seconds))");
  ASSERT_FALSE(started.ok());
  EXPECT_THAT(started.error().text(), ::testing::HasSubstr("cx_executive_plugin/time.clp"));
}

}  // namespace
}  // namespace cxlab::cx
