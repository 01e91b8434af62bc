// Every function of the plugins is called with all kinds of arguments, many that make no sense: errors, never worse.

#include "cx/base/random.h"
#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

constexpr const char* kRules = R"((defglobal ?*a* = nil ?*b* = nil ?*c* = nil ?*d* = nil)
(deffunction std-srvs-set-bool-service-callback (?service ?request ?response)
  (bind ?*a* ?request) (std-srvs-set-bool-response-set-field ?response success TRUE))
(deffunction power-service-callback (?service ?request ?response) (bind ?*b* ?response))
(deffunction example-interfaces-fibonacci-handle-goal-callback (?server ?goal ?uuid) (bind ?*c* ?goal) 2)
(defrule hear (ros-msgs-message (msg-ptr ?m)) => (bind ?*a* ?m))
(defrule answered (ros-msgs-goal-response (client-goal-handle-ptr ?h)) => (bind ?*b* ?h))
(defrule answered-too (example-interfaces-fibonacci-goal-response (client-goal-handle-ptr ?h)) => (bind ?*c* ?h))
(defrule accepted (example-interfaces-fibonacci-accepted-goal (server-goal-handle-ptr ?h)) => (bind ?*d* ?h))
(defrule tracked (tf2-tracked-pose (timer ?t)) => (bind ?*d* ?t))
)";

class AnyArguments : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string names, sections;
    const auto add = [&](const std::string& type) {
      names += '"' + type.substr(4) + "\", ";
      sections += type.substr(4) + ": {plugin: \"" + type + "\"}\n";
    };
    for (const PluginType& type : builtin_plugins())
      if (!type.has && type.name != "cx::FileLoadPlugin") add(type.name);
    for (const char* type :
         {"cx::CXStdMsgsStringPlugin", "cx::CXStdSrvsSetBoolPlugin", "cx::CXExampleInterfacesFibonacciPlugin"})
      add(type);
    lab_.config(
        "environments: [\"main\"]\nmain: {plugins: [" + names +
        "\"files\"]}\nfiles: {plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [\"agent\"], load: [\"rules.clp\"]}\n" +
        sections);
    lab_.write("agent/rules.clp", kRules);
    lab_.options.stop_on_rule_error = false;
    lab_.run_up();
  }

  std::string one_of(std::initializer_list<const char*> choices) {
    return std::data(choices)[random_.below(choices.size())];
  }
  /// A value that the type's code allows; for the same names and handles again and again, so that calls meet each
  /// other.
  std::string argument(char code) {
    switch (code) {
      case 'e': return one_of({"?*a*", "?*b*", "?*c*", "?*d*"});
      case 'l': return one_of({"0", "1", "-1", "9223372036854775807"});
      case 'd': return one_of({"0.5", "10.0", "-1.0", "1e300"});
      case 'm': return one_of({"(create$)", "(create$ 1 2 ?*a*)", "(create$ 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16)"});
      case 's':
      case 'y':
        return one_of({"\"t\"", "\"/tf\"", "\"power\"", "\"count\"", "\"a b\"", "\"\"", "\"std_msgs/msg/String\"",
                       "\"tf2_msgs/msg/TFMessage\"", "\"std_srvs/srv/SetBool\"",
                       "\"example_interfaces/action/Fibonacci\"", "\"no/msg/Such\"", "\"data\"", "\"transforms\"",
                       "\"order\"", "\"sequence\"", "\"header\""});
      default: return argument("eldmsy"[random_.below(6)]);
    }
  }
  std::string call(const FunctionSpec& function) {
    std::vector<std::string> codes;  // of each argument
    for (const char c : function.arg_types) {
      if (c == ';')
        codes.emplace_back();
      else if (!codes.empty())
        codes.back() += c;
    }
    std::string text = '(' + function.name;
    for (std::size_t i = 0; i < function.min_args; ++i)
      text += ' ' + argument(i < codes.size() && !codes[i].empty() ? codes[i][random_.below(codes[i].size())] : '*');
    text += ')';
    return function.returns == "e" ? "(bind " + one_of({"?*a*", "?*b*", "?*c*", "?*d*"}) + ' ' + text + ')' : text;
  }

  Lab lab_;
  RandomStream random_{1, "any arguments"};
};

TEST_F(AnyArguments, AreAValueOrAnErrorAndTheEnvironmentGoesOn) {
  std::vector<FunctionSpec> functions;
  for (const FunctionSpec& f : lab_.engine().functions())
    if (!f.owner.empty() && f.owner != "clips") functions.push_back(f);
  ASSERT_GE(functions.size(), 100u);
  std::size_t went_well = 0, refused = 0;
  for (int i = 0; i < 6000; ++i) {
    const std::string text = call(functions[random_.below(functions.size())]);
    const auto value = lab_.engine().eval(text);
    const auto errors = lab_.engine().take_errors();
    if (value && errors.empty())
      ++went_well;
    else
      ++refused;
    for (const RuleError& error : errors) EXPECT_FALSE(error.message.empty()) << text;
    if (i % 20 == 19) lab_.ticks(1);
    if (i % 500 == 499) lab_.log.lines.clear();
  }
  EXPECT_GT(went_well, 1500u);
  EXPECT_GT(refused, 1500u);

  ASSERT_TRUE(lab_.engine().eval("(reset)").ok());
  for (const char* step :
       {"(ros-msgs-create-publisher \"end\" \"std_msgs/msg/String\")",
        "(ros-msgs-create-subscription \"end\" \"std_msgs/msg/String\")",
        "(bind ?*a* (ros-msgs-create-message \"std_msgs/msg/String\"))", "(ros-msgs-publish ?*a* \"end\")"})
    ASSERT_TRUE(lab_.engine().eval(step).ok()) << step;
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("ros-msgs-message"), ::testing::Contains(::testing::HasSubstr("(topic \"end\")")))
      << "it works as before";
  EXPECT_TRUE(lab_.manager->deactivate().ok());
}

}  // namespace
}  // namespace cxlab::cx
