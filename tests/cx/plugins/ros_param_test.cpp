#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class RosParam : public ::testing::Test {
 protected:
  void SetUp() override {
    lab_.options.stop_on_rule_error = false;
    lab_.config(R"(environments: ["main"]
main: {plugins: ["executive", "params"]}
executive: {plugin: "cx::ExecutivePlugin"}
params: {plugin: "cx::RosParamPlugin", gain: 2.5}
goal: {x: 3, name: "home", active: true, precise: 1.0, exact: 1.5, none: .nan, big: 9007199254740993}
lists: {ids: [1, 2], names: ["a", "b"], gains: [1.5, 2.0], flags: [true, false], none: []}
quoted: "7"
empty: ""
most: [9007199254740992.0, 9007199254740994.0, -9007199254740992.0])");
    lab_.run_up();
  }
  std::string get(const std::string& name, const std::string& fallback) {
    auto value = lab_.engine().eval("(ros-param-get-value " + name + " " + fallback + ")");
    return value ? value->print() : "failed";
  }
  /// What CLIPS said of a call that fails.
  std::string failure(const std::string& name, const std::string& fallback) {
    lab_.log.lines.clear();
    EXPECT_THAT(get(name, fallback), ::testing::AnyOf("failed", "FALSE", "void", ""));
    const auto lines = lab_.log.with("'ros-param-get-value': parameter");
    return lines.empty() ? std::string() : lines.front();
  }
  Lab lab_;
};

TEST_F(RosParam, TheTypeOfTheDefaultIsTheTypeOfTheValue) {
  EXPECT_EQ(get("goal.x", "0"), "3");
  EXPECT_EQ(get("\"goal.exact\"", "0.0"), "1.5");
  EXPECT_EQ(get("goal.name", "\"\""), "\"home\"");
  EXPECT_EQ(get("goal.name", "nothing"), "\"home\"") << "a STRING for symbols, too";
  EXPECT_EQ(get("goal.active", "FALSE"), "TRUE");
  EXPECT_EQ(get("quoted", "\"\""), "\"7\"");
}

TEST_F(RosParam, ListsAreMultifields) {
  EXPECT_EQ(get("lists.ids", "(create$ 0)"), "(1 2)");
  EXPECT_EQ(get("lists.gains", "(create$ 0.0)"), "(1.5 2.0)");
  EXPECT_EQ(get("lists.names", "(create$)"), "(\"a\" \"b\")");
  EXPECT_EQ(get("lists.flags", "(create$ TRUE)"), "(TRUE FALSE)");
  EXPECT_EQ(get("lists.none", "(create$ 4)"), "()");
  EXPECT_EQ(get("main.plugins", "(create$)"), "(\"executive\" \"params\")");
}

TEST_F(RosParam, WhatIsMissingIsDeclaredWithTheDefault) {
  EXPECT_EQ(get("new.number", "4"), "4");
  EXPECT_EQ(get("new.number", "5"), "4") << "it has been declared";
  EXPECT_EQ(get("new.real", "2.0"), "2.0");
  EXPECT_EQ(get("new.real", "3.0"), "2.0");
  EXPECT_EQ(get("new.word", "up"), "\"up\"");
  EXPECT_EQ(get("new.truth", "TRUE"), "TRUE");
  EXPECT_EQ(get("new.list", "(create$ 1 2 3)"), "(1 2 3)");
  EXPECT_EQ(get("new.list", "(create$ 0)"), "(1 2 3)");
  EXPECT_EQ(get("new.words", "(create$ TRUE up)"), "(\"TRUE\" \"up\")") << "not all of them are truths";
  EXPECT_EQ(get("new.none", "(create$)"), "()");
}

TEST_F(RosParam, NumbersAreConvertedWhereThatIsExact) {
  EXPECT_EQ(get("goal.x", "0.0"), "3.0");
  EXPECT_EQ(get("goal.precise", "0"), "1");
  EXPECT_EQ(failure("goal.exact", "0"),
            "error main: [CXLAB1] Function 'ros-param-get-value': parameter 'goal.exact': found '1.5' (a double), the "
            "default wants an integer (" +
                lab_.options.config.string() + ":7)");
  EXPECT_EQ(get("goal.none", "0.0"), "nan");
  EXPECT_THAT(failure("goal.big", "0.0"),
              HasSubstr("found '9007199254740993' (an integer), the default wants a double"));
}

TEST_F(RosParam, AnotherTypeIsAnErrorOfTheRule) {
  EXPECT_THAT(failure("goal.name", "1"),
              HasSubstr("parameter 'goal.name': found 'home' (a string), the default wants an integer"));
  EXPECT_THAT(failure("goal.x", "\"\""),
              HasSubstr("parameter 'goal.x': found '3' (an integer), the default wants a string"));
  EXPECT_THAT(failure("quoted", "1"), HasSubstr("found '7' (a string)"));
  EXPECT_THAT(failure("empty", "1"), HasSubstr("parameter 'empty': found a string, the default wants an integer"));
  EXPECT_THAT(failure("most", "(create$ 1)"), HasSubstr("found '9007199254740994' (a double), the default wants an"));
  EXPECT_THAT(failure("goal.x", "(create$ 1)"), HasSubstr("found an integer, the default wants a list"));
  EXPECT_THAT(failure("lists.ids", "1"), HasSubstr("found a list, the default wants an integer"));
  EXPECT_THAT(failure("fresh", "(create$ 1 up)"), HasSubstr("found 'up' (a string), the default wants an integer"));
  EXPECT_THAT(failure("goal.x", "(assert (a))"), HasSubstr("found a default <Fact-"));
}

TEST_F(RosParam, AnEmptyNameIsAnErrorOfTheRule) {
  EXPECT_THAT(failure("\"\"", "3"), HasSubstr("parameter '': found an empty name, expected that of a parameter"));
}

TEST_F(RosParam, ParametersOfPluginsAreParametersOfTheNode) {
  EXPECT_EQ(get("params.gain", "0.0"), "2.5");
  EXPECT_EQ(get("params.plugin", "\"\""), "\"cx::RosParamPlugin\"");
  EXPECT_THAT(lab_.log.with("unknown parameter 'params.gain'"), SizeIs(1)) << "legal, with an INFO line";
  EXPECT_THAT(lab_.log.with("warn "), IsEmpty());
}

TEST(RosParamInstances, ShareWhatTheyDeclare) {
  Lab lab;
  lab.config(R"(environments: ["one", "two"]
one: {plugins: ["a"]}
two: {plugins: ["b"]}
a: {plugin: "cx::RosParamPlugin"}
b: {plugin: "cx::RosParamPlugin"})");
  lab.run_up();
  EXPECT_EQ(lab.engine("one").eval("(ros-param-get-value shared 1)")->print(), "1");
  EXPECT_EQ(lab.engine("two").eval("(ros-param-get-value shared 2)")->print(), "1");
}

}  // namespace
}  // namespace cxlab::cx
