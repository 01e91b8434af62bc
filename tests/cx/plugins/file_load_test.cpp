#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(FileLoad, LoadsThenRunsBatchesThenCleansUp) {
  Lab lab;
  lab.config(R"(environments: ["main"]
main: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], batch: ["b.clp"], load: ["a.clp"], cleanup_batch: ["c.clp"]})");
  lab.write("agent/a.clp", "(deffunction hello () (println \"hello\"))");
  lab.write("agent/b.clp", "(hello)\n(watch facts)\n");
  lab.write("agent/c.clp", "(println \"bye\")");
  lab.run_up();
  EXPECT_THAT(lab.log.with("hello"), SizeIs(1));
  EXPECT_THAT(lab.log.with("bye"), SizeIs(0));
  ASSERT_TRUE(lab.manager->deactivate().ok());
  EXPECT_THAT(lab.log.with("bye"), SizeIs(1));
}

/// The error of an agent with these rules.
Error error_of(const std::string& rules) {
  Lab lab;
  lab.agent(rules);
  const Status s = lab.start();
  EXPECT_FALSE(s.ok());
  if (s.ok()) return {};
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_EQ(s.error().file, (lab.folder / "agent/rules.clp").string());
  return s.error();
}

TEST(FileLoad, ErrorsHaveTheirLine) {
  EXPECT_EQ(error_of("(defrule a =>)\n\n(defrule b\n  (x)\n  =>\n  (println \"y\")").line, 3)
      << "unbalanced: where its form begins";
  EXPECT_EQ(error_of("(deftemplate order (slot id))\n(defrule a\n  (order (name ?x))\n  =>)").line, 3);
  EXPECT_EQ(error_of("(defrule a\n  (x)\n  =>\n  (nothing-such 1))").line, 4);
}

TEST(FileLoad, ErrorsInBatchFilesHaveTheirLine) {
  Lab lab;
  lab.config(R"(environments: ["main"]
main: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], batch: ["b.clp"]})");
  lab.write("agent/b.clp", "(println \"fine\")\n(println (/ 1 0))\n");
  const Status s = lab.start();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_EQ(s.error().line, 2);
}

TEST(FileLoad, AMissingFileHasTheLineOfItsList) {
  Lab lab;
  lab.agent("");
  lab.options.params = {};
  std::filesystem::remove(lab.folder / "agent/rules.clp");
  const Status s = lab.start();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_THAT(s.error().message, HasSubstr("Cannot resolve file rules.clp"));
  EXPECT_EQ(s.error().file, (lab.folder / "config.yaml").string());
  EXPECT_EQ(s.error().line, 9);
}

TEST(FileLoad, WhenItKeepsGoingAllErrorsAreReportedAndTheRestIsLoaded) {
  Lab lab;
  lab.options.keep_going = true;
  lab.options.stop_on_rule_error = false;
  lab.agent(
      "(defrule bad (x) => (nothing-such))\n(defrule good (time ?) => (println \"good\"))\n(defrule worse (x) => "
      "(nothing-such))");
  lab.run_up();
  EXPECT_THAT(lab.manager->load_errors(), SizeIs(2));
  ASSERT_THAT(lab.manager->rule_errors(), SizeIs(2));
  EXPECT_EQ(lab.manager->rule_errors()[1].error.line, 3);
  lab.ticks(1);
  EXPECT_THAT(lab.log.with("good"), SizeIs(1));
}

TEST(FileLoad, SeveralEnvironmentsShareOneInstance) {
  Lab lab;
  lab.config(R"(environments: ["one", "two"]
one: {plugins: ["files"]}
two: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["a.clp"]})");
  lab.write("agent/a.clp", "(defrule go => (println \"up\"))");
  lab.run_up();
  EXPECT_THAT(lab.log.with("up"), ElementsAre("info one: up", "info two: up"));
  EXPECT_THAT(lab.log.with("Created plugin"), SizeIs(1));
}

TEST(FileLoad, PackagesAreAskedInOrderAndOnlyWhenTheyAreReached) {
  Lab lab;
  lab.options.packages["other"] = {lab.folder / "other", {}};
  lab.config(R"(environments: ["main"]
main: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent", "other", "nowhere"], load: ["a.clp", "b.clp"]})");
  lab.write("agent/a.clp", "(defrule a => (println \"a of agent\"))");
  lab.write("other/a.clp", "(defrule a => (println \"a of other\"))");
  lab.write("other/b.clp", "(defrule b => (println \"b of other\"))");
  lab.run_up();
  EXPECT_THAT(lab.log.with("info main: "),
              ::testing::UnorderedElementsAre("info main: a of agent", "info main: b of other"));
}

TEST(FileLoad, TheNextCxBeginsEachFileInMain) {
  for (const bool next : {false, true}) {
    Lab lab;
    lab.config(std::string(next ? "compat: next\n" : "") + R"(environments: ["main"]
main: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["a.clp", "b.clp"], batch: ["c.clp"]})");
    lab.write("agent/a.clp", "(defmodule MAIN (export ?ALL)) (defmodule OTHER (import MAIN ?ALL))");
    lab.write("agent/b.clp", "(deftemplate here)");
    lab.write("agent/c.clp", "(println (get-current-module))");
    lab.run_up();
    const char* module = next ? "MAIN" : "OTHER";
    EXPECT_THAT(lab.log.with("info main: "), ::testing::ElementsAre(std::string("info main: ") + module));
    EXPECT_EQ(lab.engine().eval(std::string("(deftemplate-module ") + module + "::here)")->print(), module);
  }
}

TEST(FileLoad, TheNextCxSkipsPackagesThatAreNotThereWhereAnotherMayHaveTheFile) {
  Lab lab;
  const auto config = [&](const std::string& packages) {
    lab.config(
        "compat: next\nenvironments: [\"main\"]\nmain: {plugins: [\"files\"]}\nfiles: {plugin: "
        "\"cx::FileLoadPlugin\", pkg_share_dirs: [" +
        packages + "], load: [\"a.clp\"]}");
  };
  config("\"nowhere\", \"agent\"");
  lab.write("agent/a.clp", "(defrule go => (println \"up\"))");
  lab.run_up();
  EXPECT_THAT(lab.log.with("main: up"), SizeIs(1));
  EXPECT_THAT(lab.log.with("warn "),
              ::testing::ElementsAre("warn files: Share directory lookup skipped: package 'nowhere' not found in ament "
                                     "index"));
  config("\"nowhere\"");
  EXPECT_FALSE(lab.start().ok());
}

TEST(FileLoad, AFileThatIsNowhereDropsAllThatFollowWhenItKeepsGoing) {
  Lab lab;
  lab.options.keep_going = true;
  lab.config(R"(environments: ["main"]
main: {plugins: ["files"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["a.clp", "none.clp", "b.clp"], batch: ["c.clp"], cleanup_batch: ["c.clp"]})");
  lab.write("agent/a.clp", "(defrule a => (println \"a\"))");
  lab.write("agent/b.clp", "(defrule b => (println \"b\"))");
  lab.write("agent/c.clp", "(println \"c\")");
  lab.run_up();
  ASSERT_TRUE(lab.manager->deactivate().ok());
  EXPECT_THAT(lab.log.with("info main: "), ElementsAre("info main: a"));
  EXPECT_THAT(lab.log.with("error "), ElementsAre(HasSubstr("Cannot resolve file none.clp")));
}

TEST(FileLoad, APathThatRulesSetIsOneThatRulesMayRead) {
  Lab lab;
  const auto file = lab.write("elsewhere/a.clp", "(defrule a => (println \"absolute\"))");
  lab.config(R"(environments: ["main"]
main: {plugins: ["params"]}
params: {plugin: "cx::RosParamPlugin"}
files: {plugin: "cx::FileLoadPlugin"})");
  lab.run_up();
  ASSERT_TRUE(lab.engine().eval("(ros-param-get-value files.load (create$ \"" + file.string() + "\"))").ok());
  EXPECT_FALSE(lab.manager->load_plugin("main", "files").ok());
  EXPECT_THAT(lab.log.with("absolute"), SizeIs(0));
}

TEST(FileLoad, RulesOfAnAbsolutePathAreTakenAsTheyAre) {
  Lab lab;
  const auto file = lab.write("elsewhere/a.clp", "(defrule a => (println \"absolute\"))");
  lab.config(
      "environments: [\"main\"]\nmain: {plugins: [\"files\"]}\nfiles: {plugin: \"cx::FileLoadPlugin\", load: [\"" +
      file.string() + "\"]}");
  lab.run_up();
  EXPECT_THAT(lab.log.with("absolute"), SizeIs(1));
}

}  // namespace
}  // namespace cxlab::cx
