// The parameter services of the manager's node.

#include "tests/support/caller.h"

namespace cxlab::cx {
namespace {

using ::testing::HasSubstr;

struct ParameterServices : ::testing::Test {
  ParameterServices() {
    lab.config(R"(environments: ["main"]
main: {plugins: ["executive"]}
executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 10}
late: {plugin: "cx::FileLoadPlugin", load: ["nothing.clp"], pkg_share_dirs: ["agent"]}
mine: {flag: true, ratio: 0.5, list: [1, 2], words: ["a", "b"], text: hello})");
    lab.run_up();
  }
  std::string call(const std::string& name, const std::string& type, const std::string& request) {
    return caller.call("/clips_manager/" + name, "rcl_interfaces/srv/" + type, request);
  }
  Lab lab;
  Caller caller{lab};
};

TEST_F(ParameterServices, ListNames) {
  EXPECT_EQ(
      call("list_parameters", "ListParameters", "{prefixes: [mine]}"),
      R"({result: {names: ["mine.flag", "mine.list", "mine.ratio", "mine.text", "mine.words"], prefixes: ["mine"]}})");
  EXPECT_THAT(call("list_parameters", "ListParameters", "{depth: 1}"),
              ::testing::AllOf(HasSubstr("bond_heartbeat_period"), HasSubstr("environments"),
                               ::testing::Not(HasSubstr("mine.flag"))));
}

TEST_F(ParameterServices, GiveValuesAndTypes) {
  const std::string values =
      call("get_parameters", "GetParameters",
           "{names: [mine.flag, executive.refresh_rate, mine.ratio, mine.text, mine.list, mine.words, nothing]}");
  for (const char* part :
       {"type: 1, bool_value: true", "integer_value: 10", "double_value: 0.5", "string_value: \"hello\"",
        "integer_array_value: [1, 2]", "string_array_value: [\"a\", \"b\"]", "type: 0"})
    EXPECT_THAT(values, HasSubstr(part));
  EXPECT_EQ(call("get_parameter_types", "GetParameterTypes", "{names: [mine.flag, mine.list, nothing]}"),
            "{types: [1, 7, 0]}");
  EXPECT_THAT(call("describe_parameters", "DescribeParameters", "{names: [mine.ratio]}"),
              HasSubstr("name: \"mine.ratio\", type: 3"));
}

TEST_F(ParameterServices, SetAValueOfItsType) {
  EXPECT_EQ(
      call("set_parameters", "SetParameters",
           "{parameters: [{name: mine.ratio, value: {type: 3, double_value: 0.25}}, {name: mine.flag, value: {type: 4, "
           "string_value: x}}]}"),
      R"({results: [{successful: true, reason: ""}, {successful: false, reason: "Wrong parameter type, parameter {mine.flag} is of type {bool}, setting it to {string} is not allowed."}]})");
  EXPECT_THAT(call("get_parameters", "GetParameters", "{names: [mine.ratio]}"), HasSubstr("double_value: 0.25"));
}

TEST_F(ParameterServices, SetAllOrNothing) {
  EXPECT_THAT(call("set_parameters_atomically", "SetParametersAtomically",
                   "{parameters: [{name: mine.ratio, value: {type: 3, double_value: 9.0}}, {name: mine.flag, value: "
                   "{type: 4, string_value: x}}]}"),
              HasSubstr("successful: false"));
  EXPECT_THAT(call("get_parameters", "GetParameters", "{names: [mine.ratio]}"), HasSubstr("double_value: 0.5"));
}

TEST_F(ParameterServices, ChangesAreToldToAll) {
  std::string heard;
  ASSERT_TRUE(lab.bus
                  .subscribe(caller.node(), "/parameter_events",
                             **lab.registry.message("rcl_interfaces/msg/ParameterEvent"),
                             [&](const bus::Delivery& d) { heard = d.message->view().to_string(); })
                  .ok());
  call("set_parameters", "SetParameters",
       "{parameters: [{name: mine.text, value: {type: 4, string_value: bye}}, {name: mine.ratio, value: {type: 3, "
       "double_value: 3.0}}]}");
  EXPECT_THAT(heard, ::testing::AllOf(HasSubstr("node: \"/clips_manager\""),
                                      HasSubstr("changed_parameters: [{name: \"mine.ratio\"")));
}

TEST_F(ParameterServices, OneThatWasNotDeclaredCannotBeSet) {
  EXPECT_EQ(
      call("set_parameters", "SetParameters", "{parameters: [{name: fresh, value: {type: 2, integer_value: 3}}]}"),
      R"({results: [{successful: false, reason: "parameter 'fresh' cannot be set because it was not declared"}]})");
  EXPECT_THAT(
      call("set_parameters_atomically", "SetParametersAtomically",
           "{parameters: [{name: mine.ratio, value: {type: 3, double_value: 9.0}}, {name: fresh, value: {type: 1}}]}"),
      HasSubstr("was not declared"));
  EXPECT_THAT(call("get_parameters", "GetParameters", "{names: [mine.ratio, fresh]}"), HasSubstr("double_value: 0.5"));
}

TEST_F(ParameterServices, WhatTheNodeAndItsPluginsReadIsDeclaredWithItsDefault) {
  EXPECT_THAT(
      call("list_parameters", "ListParameters", "{prefixes: [main, executive]}"),
      HasSubstr(
          R"(names: ["executive.assert_time", "executive.autostart", "executive.plugin", "executive.publish_on_refresh", "executive.refresh_rate", "main.focus_stack", "main.log_clips_to_file", "main.log_clips_to_topic", "main.plugins", "main.redirect_stdout_to_debug", "main.rule_limit", "main.watch"])"));
  EXPECT_EQ(call("get_parameter_types", "GetParameterTypes",
                 "{names: [main.watch, executive.assert_time, use_sim_time, bond_heartbeat_period]}"),
            "{types: [9, 1, 1, 3]}");
  EXPECT_THAT(call("set_parameters", "SetParameters",
                   "{parameters: [{name: main.watch, value: {type: 9, string_array_value: [facts]}}]}"),
              HasSubstr("successful: true"));
}

TEST_F(ParameterServices, APluginOfTheFileMayBeChangedBeforeItIsLoaded) {
  lab.write("agent/late.clp", "(defrule late (time ?t) => (println \"late rule\"))");
  call("set_parameters", "SetParameters",
       "{parameters: [{name: late.load, value: {type: 9, string_array_value: [late.clp]}}]}");
  EXPECT_EQ(caller.load("main", "late"), R"({success: true, error: ""})");
  lab.ticks(6);
  EXPECT_FALSE(lab.log.with("main: late rule").empty());
}

}  // namespace
}  // namespace cxlab::cx
