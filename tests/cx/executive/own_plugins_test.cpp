// Plugins of users in libraries (tests/app/own_plugins), opened by this program. tests/app/own_plugins.py does the same
// with an installed cxlab.

#include <dlfcn.h>

#include <cmath>

#include "cx/base/remedy.h"
#include "cx/executive/plugin_library.h"
#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::filesystem::path built(const std::string& library) {
  return std::filesystem::path(OWN_PLUGINS) / ("lib" + library + ".so");
}

/// Instance "talk" of a class in a library, in environments "one" and "two"; "one" has a rule that calls it.
class OwnPlugins : public ::testing::Test {
 protected:
  void SetUp() override { lab_.options.packages["own"] = {lab_.folder / "own/share/own", {}}; }
  void manifest(const std::string& text) { lab_.write("own/share/own/cxlab_plugins.yaml", text); }
  /// One class of that library, in line 3.
  void library(const std::string& path, const std::string& name = "test::Chatty") {
    manifest("library: " + path + "\nplugins:\n  - class: " + name + "\n");
  }
  Status start(const std::string& parameters = "", const std::string& name = "test::Chatty") {
    lab_.config(R"(environments: ["one", "two"]
one: {plugins: ["talk", "files"]}
two: {plugins: ["talk"]}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]}
talk: {plugin: ")" +
                name + "\"" + parameters + "}");
    lab_.write("agent/rules.clp", "(deffacts start (begin))\n(defrule talk (begin) => (println \"chat \" (chat)))\n");
    return lab_.start();
  }
  Error error_of(const std::string& parameters = "", const std::string& name = "test::Chatty") {
    const Status status = start(parameters, name);
    EXPECT_FALSE(status.ok());
    return status ? Error{} : status.error();
  }
  std::vector<std::string> hooks() const { return lab_.log.with("info talk: "); }
  std::string place(int line) const {
    return (lab_.folder / "own/share/own/cxlab_plugins.yaml").string() + ':' + std::to_string(line) + ": ";
  }

  Lab lab_;
};

TEST_F(OwnPlugins, LibraryIsNotOpenedWhereNativePluginsMayNotBe) {
  library("libnone.so");  // not even looked for
  lab_.options.programs = false;
  for (const bool keep_going : {false, true}) {
    lab_.options.keep_going = keep_going;
    const Error error = error_of();
    EXPECT_EQ(error.kind, ErrorKind::kUsage);
    EXPECT_EQ(error.code, kUntrusted);
    EXPECT_THAT(error.message, HasSubstr("plugin 'talk' (test::Chatty of libnone.so) is native code"));
  }
}

TEST_F(OwnPlugins, FunctionsAreNotOfCx) {
  library(built("chatty").string());
  lab_.options.strict = true;
  lab_.options.keep_going = true;
  ASSERT_TRUE(start().ok());
  EXPECT_THAT(
      lab_.log.with("strict-cx"),
      ElementsAre(HasSubstr(
          "rules.clp:2: strict-cx: function: 'chat' is of plugin 'talk' (test::Chatty), which CX does not have")));
}

TEST_F(OwnPlugins, EachHookIsCalledInItsOrder) {
  library(built("chatty").string());
  ASSERT_TRUE(start().ok());
  EXPECT_THAT(hooks(),
              ElementsAre("info talk: initialize", "info talk: clips_env_init one", "info talk: clips_env_init two"));
  EXPECT_EQ(lab_.engine("one").eval("(chat)")->print(), "7");
  lab_.log.lines.clear();
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  ASSERT_TRUE(lab_.manager->cleanup().ok());
  EXPECT_THAT(hooks(), ElementsAre("info talk: clips_env_destroyed one", "info talk: clips_env_destroyed two",
                                   "info talk: finalize", "info talk: gone"));
}

TEST_F(OwnPlugins, ALibraryLiesBesideTheManifestOrInLib) {
  for (const char* place : {"own/share/own/libown.so", "own/lib/libown.so"}) {
    std::filesystem::create_directories((lab_.folder / place).parent_path());
    std::filesystem::copy_file(built("chatty"), lab_.folder / place);
    library("libown.so");
    EXPECT_TRUE(start().ok()) << place;
    EXPECT_FALSE(hooks().empty()) << place;
    lab_.manager.reset();
    lab_.log.lines.clear();
    std::filesystem::remove(lab_.folder / place);
  }
}

TEST_F(OwnPlugins, APluginThatCannotBeginIsNotFinalized) {
  library(built("chatty").string());
  for (const auto& [how, words] :
       {std::pair{"throw", "initialize threw: out of words"}, std::pair{"fail", "initialize: does not want to"}}) {
    lab_.log.lines.clear();
    const Error error = error_of(", " + std::string(how) + ": initialize");
    EXPECT_EQ(error.kind, ErrorKind::kRun) << how;
    EXPECT_THAT(error.message, HasSubstr("plugin 'talk' (test::Chatty of " + built("chatty").string() + "): " + words));
    lab_.manager.reset();
    EXPECT_THAT(hooks(), ElementsAre("info talk: initialize", "info talk: gone")) << how;
  }
}

TEST_F(OwnPlugins, APluginThatRefusesAnEnvironmentIsFinalizedAndNotDestroyedThere) {
  library(built("chatty").string());
  for (const auto& [how, words] : {std::pair{"throw", "clips_env_init threw: out of words"},
                                   std::pair{"fail", "clips_env_init: does not want to"}}) {
    lab_.log.lines.clear();
    EXPECT_THAT(error_of(", " + std::string(how) + ": clips_env_init").message, HasSubstr(words));
    (void)lab_.manager->deactivate();
    lab_.manager.reset();
    EXPECT_THAT(hooks(), ElementsAre("info talk: initialize", "info talk: clips_env_init one", "info talk: finalize",
                                     "info talk: gone"))
        << how;
  }
}

TEST_F(OwnPlugins, APluginThatThrowsAtItsEndGetsAllCallsOfItsEnd) {
  library(built("chatty").string());
  for (const std::string hook : {"clips_env_destroyed", "finalize"}) {
    ASSERT_TRUE(start(", throw: " + hook).ok());
    lab_.log.lines.clear();
    Status ended = lab_.manager->deactivate();
    if (ended) ended = lab_.manager->cleanup();
    if (ended) ended = lab_.tick();
    ASSERT_FALSE(ended.ok()) << hook;
    EXPECT_THAT(ended.error().message, HasSubstr("libchatty.so): " + hook + " threw: out of words"));
    lab_.manager.reset();
    EXPECT_THAT(hooks(), ElementsAre("info talk: clips_env_destroyed one", "info talk: clips_env_destroyed two",
                                     "info talk: finalize", "info talk: gone"))
        << hook;
  }
}

TEST_F(OwnPlugins, AFunctionThatThrowsIsAnErrorOfTheRule) {
  library(built("chatty").string());
  EXPECT_THAT(error_of(", throw: chat").text(),
              AllOf(HasSubstr("rules.clp:2: rule talk, RHS: "), HasSubstr("no words")));
}

TEST_F(OwnPlugins, WhatIsWrongWithALibraryHasThePlaceInItsManifest) {
  const std::string no_library = lab_.write("own/text.so", "no library").string();
  Dl_info math;
  ASSERT_NE(dladdr(reinterpret_cast<void*>(static_cast<double (*)(double)>(&std::cos)), &math), 0);
  struct Row {
    std::string library, name;
    int line;
    ErrorKind kind;
    std::vector<std::string> words;
  };
  const Row rows[] = {
      {"libnone.so",
       "test::Chatty",
       1,
       ErrorKind::kResource,
       {"library 'libnone.so' is not there (looked for " + (lab_.folder / "own/share/own/libnone.so").string() + ", " +
        (lab_.folder / "own/lib/libnone.so").string() + ")"}},
      {no_library, "test::Chatty", 1, ErrorKind::kResource, {"cannot open the library: ", "Build it again"}},
      {built("missing_symbol").string(),
       "test::Incomplete",
       1,
       ErrorKind::kResource,
       {"undefined symbol", "defined_nowhere"}},
      {built("no_exports").string(), "test::Chatty", 1, ErrorKind::kInput, {"exports no plugins", "CXLAB_PLUGINS"}},
      {built("other_abi").string(),
       "test::Old",
       1,
       ErrorKind::kInput,
       {"was built for cxlab 0.0.1 ", "build it again"}},
      {built("chatty").string(),
       "test::Broken",
       3,
       ErrorKind::kInput,
       {"no plugin class 'test::Broken', its CXLAB_PLUGINS names test::Chatty"}},
  };
  for (const Row& row : rows) {
    library(row.library, row.name);
    const Error error = error_of("", row.name);
    EXPECT_EQ(error.kind, row.kind) << row.library;
    EXPECT_THAT(error.text(), HasSubstr(place(row.line))) << row.library;
    for (const std::string& words : row.words) EXPECT_THAT(error.message, HasSubstr(words)) << row.library;
    lab_.manager.reset();
  }
}

TEST_F(OwnPlugins, AManifestThatIsWrongIsAnErrorWithItsLine) {
  struct Row {
    const char* manifest;
    int line;
    const char* words;
  };
  for (const Row& row :
       {Row{"library: libx.so\nplugin: []\n", 2, "key 'plugins' is missing"},
        Row{"library: libx.so\nplugins:\n  - class: test::Chatty\n    base: cx::ClipsPlugin\n", 4, ""},
        Row{"library: libx.so\nplugins:\n  - class: test::Chatty\n    colour: red\n", 4, "colour"},
        Row{"library: libx.so\nplugins: []\ncolour: red\n", 3, "colour"}, Row{"library: [\n", 2, ""},
        Row{"- library: libx.so\n  plugins:\n    - class: a::A\n- library: liby.so\n  plugins:\n    - class: a::A\n", 6,
            "found the plugin class 'a::A', which "},
        Row{"library: libx.so\nplugins:\n  - class: cx::ConfigPlugin\n", 3,
            "found the plugin class 'cx::ConfigPlugin', which cxlab has too"}}) {
    manifest(row.manifest);
    const Error error = error_of();
    EXPECT_THAT(error.text(), AllOf(HasSubstr(place(row.line)), HasSubstr(row.words))) << row.manifest;
  }
}

TEST_F(OwnPlugins, AManifestSaysWhichParametersAClassReads) {
  manifest("library: " + built("chatty").string() +
           "\nplugins:\n  - class: test::Chatty\n    description: Chats.\n    parameters: [fail, throw]\n"
           "  - class: test::Other\n");
  Files::Options options;
  options.packages = lab_.options.packages;
  Files files(options);
  const auto types = read_plugin_manifest("own", files);
  ASSERT_TRUE(types.ok());
  ASSERT_EQ(types->size(), 2U);
  const PluginType &chatty = (*types)[0], &other = (*types)[1];
  EXPECT_EQ(chatty.name, "test::Chatty");
  EXPECT_EQ(chatty.description, "Chats.");
  EXPECT_EQ(chatty.line, 3);
  EXPECT_THAT(chatty.parameters, ElementsAre("fail", "throw"));
  EXPECT_FALSE(chatty.any_parameter);
  EXPECT_TRUE(other.any_parameter);
  EXPECT_EQ(place_of(other) + ": ", place(6));
  EXPECT_THAT(*read_plugin_manifest("agent", files), IsEmpty()) << "it has none";
}

TEST_F(OwnPlugins, WhatTheRunCannotKeepIsNotOpened) {
  library(built("chatty").string());
  for (const std::string refused : {"cxlab_plugins.yaml", "libchatty.so"}) {
    lab_.options.on_read = [&](const std::string& name, const std::filesystem::path&) {
      return name.ends_with(refused) ? Status(resource_error("the disk is full")) : Status();
    };
    EXPECT_THAT(error_of().text(), HasSubstr("the disk is full")) << refused;
    EXPECT_THAT(hooks(), IsEmpty()) << refused;
    lab_.manager.reset();
  }
}

}  // namespace
}  // namespace cxlab::cx
