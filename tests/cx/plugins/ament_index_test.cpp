#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;

TEST(AmentIndex, KnowsThePackages) {
  Lab lab;
  lab.options.packages["far"] = {lab.folder / "copies", "/opt/share/far"};
  lab.agent("");
  lab.run_up();
  const auto eval = [&](const std::string& expression) { return lab.engine().eval(expression)->print(); };
  const std::string agent = (lab.folder / "agent").string();
  EXPECT_EQ(eval("(ament-index-get-package-share-directory \"agent\")"), '"' + agent + '"');
  EXPECT_EQ(eval("(ament-index-get-package-share-directory far)"), "\"/opt/share/far\"");
  EXPECT_EQ(eval("(ament-index-get-package-prefix far)"), "\"/opt\"");
  EXPECT_EQ(eval("(ament-index-get-packages-with-prefixes)"), "(\"agent\" \"" + agent + "\" \"far\" \"/opt\")");
  EXPECT_EQ(eval("(ament-index-get-search-paths)"), "(\"" + agent + "\" \"/opt\")");
  EXPECT_EQ(eval("(ament-index-has-resource packages far)"), "TRUE");
  EXPECT_EQ(eval("(ament-index-get-resource packages far)"), "(\"\" \"/opt\")");
  EXPECT_EQ(eval("(ament-index-get-resource packages fa)"), "FALSE");
  EXPECT_EQ(eval("(ament-index-get-resources packages)"), "(\"agent\" \"" + agent + "\" \"far\" \"/opt\")");
  EXPECT_EQ(eval("(ament-index-get-resources nothing)"), "()");
}

TEST(AmentIndex, AnUnknownPackageIsFalseAndAnErrorLine) {
  Lab lab;
  lab.agent("");
  lab.run_up();
  EXPECT_EQ(lab.engine().eval("(ament-index-get-package-share-directory agnt)")->print(), "FALSE");
  EXPECT_THAT(lab.log.with("error "), ElementsAre("error ament_index: ament-index-get-package-share-directory: package "
                                                  "'agnt' not found, did you mean 'agent'?"));
}

TEST(AmentIndex, ResourcesComeFromTheIndexOfThePrefix) {
  Lab lab;
  lab.options.packages["robot"] = {lab.folder / "install/share/robot", {}};
  lab.write("install/share/ament_index/resource_index/cx_plugins/robot", "plugins.xml");
  lab.write("install/share/ament_index/resource_index/cx_plugins/arm", "");
  lab.agent("");
  lab.run_up();
  const auto eval = [&](const std::string& expression) { return lab.engine().eval(expression)->print(); };
  const std::string prefix = (lab.folder / "install").string();
  EXPECT_EQ(eval("(ament-index-get-package-prefix robot)"), '"' + prefix + '"');
  EXPECT_EQ(eval("(ament-index-get-resource cx_plugins robot)"), "(\"plugins.xml\" \"" + prefix + "\")");
  EXPECT_EQ(eval("(ament-index-get-resources cx_plugins)"),
            "(\"arm\" \"" + prefix + "\" \"robot\" \"" + prefix + "\")");
  EXPECT_EQ(eval("(ament-index-has-resource cx_plugins leg)"), "FALSE");
}

TEST(AmentIndex, TheNextCxGivesThePrefixOfAResource) {
  Lab lab;
  lab.options.packages["far"] = {lab.folder / "copies", "/opt/share/far"};
  lab.agent("", "compat: next\n");
  lab.run_up();
  EXPECT_EQ(lab.engine().eval("(ament-index-has-resource packages far)")->print(), "\"/opt\"");
  EXPECT_EQ(lab.engine().eval("(ament-index-has-resource packages fa)")->print(), "FALSE");
}

TEST(AmentIndex, NamesOfResourcesAreNoPaths) {
  Lab lab;
  lab.agent("");
  lab.write("secret", "s");
  lab.run_up();
  const auto eval = [&](const std::string& expression) { return lab.engine().eval(expression)->print(); };
  EXPECT_EQ(eval("(ament-index-get-resource \"../../../..\" secret)"), "FALSE");
  EXPECT_EQ(eval("(ament-index-has-resource \"..\" secret)"), "FALSE");
  EXPECT_EQ(eval("(ament-index-get-resources \"../..\")"), "FALSE");
  EXPECT_EQ(eval("(ament-index-get-resource packages \"\")"), "FALSE");
  EXPECT_THAT(lab.log.with("error "),
              ElementsAre("error ament_index: ament-index-get-resource: ament_index_cpp::get_resource() resource type "
                          "must be a word, found '../../../..'",
                          "error ament_index: ament-index-has-resource: ament_index_cpp::has_resource() resource type "
                          "must be a word, found '..'",
                          "error ament_index: ament-index-get-resources: ament_index_cpp::get_resources() resource "
                          "type must be a word, found '../..'",
                          "error ament_index: ament-index-get-resource: ament_index_cpp::get_resource() resource name "
                          "must not be empty"));
}

}  // namespace
}  // namespace cxlab::cx
