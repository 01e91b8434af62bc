#include "cx/executive/files.h"

#include <sys/stat.h>

#include <fstream>
#include <map>

#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::HasSubstr;

class FilesTest : public ::testing::Test {
 protected:
  Files make(bool trust = false) {
    Files::Options options;
    options.packages = {{"agent", {lab_.folder / "agent", {}}},
                        {"moved", {lab_.folder / "copies", "/somewhere/share/moved"}}};
    options.run_folder = lab_.folder / "run";
    options.trust_rules = trust;
    return Files(std::move(options));
  }
  Lab lab_;
};

TEST_F(FilesTest, ResolvesInThePackagesInTheirOrder) {
  lab_.write("agent/x.clp", "");
  lab_.write("copies/x.clp", "");
  const Files files = make();
  auto found = files.resolve("x.clp", {"moved", "agent"});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->path, lab_.folder / "copies/x.clp");
  EXPECT_EQ(found->logical_name, "moved/x.clp");
}

TEST_F(FilesTest, APackageThatIsNotReachedMayBeMissing) {
  lab_.write("agent/x.clp", "");
  EXPECT_TRUE(make().resolve("x.clp", {"agent", "nothing"}).ok());
  auto missing = make().resolve("x.clp", {"agnt"});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().message, "Cannot resolve file x.clp: package 'agnt' not found, did you mean 'agent'?");
  EXPECT_EQ(make().resolve("y.clp", {"agent", "moved"}).error().message,
            "Cannot resolve file y.clp: not in " + (lab_.folder / "agent").string() + ", /somewhere/share/moved");
  EXPECT_EQ(make().resolve("y.clp", {}).error().message, "Cannot resolve file y.clp: no pkg_share_dirs to look in");
}

TEST_F(FilesTest, ASourceTreeIsSeenAsInstalled) {
  lab_.write("agent/clips/init.clp", "");
  auto found = make().resolve("clips/agent/init.clp", {"agent"});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->path, lab_.folder / "agent/clips/init.clp");
}

TEST_F(FilesTest, AShareDirectoryMayStandForAnotherFolder) {
  lab_.write("copies/a.yaml", "");
  Files files = make();
  EXPECT_EQ(*files.share_directory("moved"), "/somewhere/share/moved");
  EXPECT_EQ(*files.prefix("moved"), "/somewhere");
  auto read = files.for_reading("/somewhere/share/moved/a.yaml");
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(*read, (lab_.folder / "copies/a.yaml").string());
  EXPECT_EQ(files.journal_name("/somewhere/share/moved/a.yaml"), "moved/a.yaml");
}

TEST_F(FilesTest, PathsHaveTheirNamesInTheJournal) {
  const Files files = make();
  const std::string folder = lab_.folder.string();
  for (const auto& [path, name] : {std::pair<std::string, std::string>{"x/y.clp", "x/y.clp"},
                                   {"./y.clp", "./y.clp"},
                                   {folder + "/agent/clips/a.clp", "agent/clips/a.clp"},
                                   {folder + "/agent/../agent/a.clp", "agent/a.clp"},
                                   {folder + "/copies/a.clp", "moved/a.clp"},
                                   {"/somewhere/share/moved/a.clp", "moved/a.clp"},
                                   {folder + "/run/a.log", "run/a.log"},
                                   {folder + "/agents/a.clp", "a.clp"},
                                   {"/etc/a.clp", "a.clp"}})
    EXPECT_EQ(files.journal_name(path), name) << path;
}

TEST_F(FilesTest, AFileInFoldersThatLieInEachOtherIsOfTheInnermost) {
  Files::Options options;
  options.packages = {{"a_whole_tree", {lab_.folder, {}}}, {"rules", {lab_.folder / "agent/rules", {}}}};
  options.run_folder = lab_.folder / "agent/rules/run";
  const Files files(std::move(options));
  const std::string folder = lab_.folder.string();
  EXPECT_EQ(files.journal_name(folder + "/agent/a.clp"), "a_whole_tree/agent/a.clp");
  EXPECT_EQ(files.journal_name(folder + "/agent/rules/a.clp"), "rules/a.clp");
  EXPECT_EQ(files.journal_name(folder + "/agent/rules/run/a.log"), "run/a.log");
}

TEST_F(FilesTest, WhatIsNoFileCannotBeRead) {
  lab_.write("agent/a.clp", "(a)");
  const Files files = make();
  EXPECT_EQ(*files.read({lab_.folder / "agent/a.clp", "a.clp"}), "(a)");
  ASSERT_EQ(mkfifo((lab_.folder / "agent/pipe").c_str(), 0600), 0);
  for (const auto& [path, what] : std::map<std::string, std::string>{{"agent", "is a folder, expected a file"},
                                                                     {"agent/b.clp", "there is no such file"},
                                                                     {"agent/pipe", "is a pipe, expected a file"}}) {
    const auto read = files.read({lab_.folder / path, "x"});
    ASSERT_FALSE(read.ok()) << path;
    EXPECT_EQ(read.error().text(), (lab_.folder / path).string() + ": " + what);
  }
}

TEST_F(FilesTest, RulesReadPackagesOnly) {
  lab_.write("agent/a.txt", "");
  lab_.write("secret.txt", "");
  Files files = make();
  EXPECT_TRUE(files.for_reading((lab_.folder / "agent/a.txt").string()).ok());
  EXPECT_FALSE(files.for_reading((lab_.folder / "secret.txt").string()).ok());
  EXPECT_FALSE(files.for_reading((lab_.folder / "agent/../secret.txt").string()).ok());
  std::filesystem::create_symlink(lab_.folder / "secret.txt", lab_.folder / "agent/link.txt");
  EXPECT_FALSE(files.for_reading((lab_.folder / "agent/link.txt").string()).ok()) << "a link must not lead out";
  EXPECT_TRUE(make(true).for_reading((lab_.folder / "secret.txt").string()).ok()) << "unless rules are trusted";
}

TEST_F(FilesTest, RulesListFoldersOfPackagesOnly) {
  lab_.write("agent/proto/a.proto", "");
  lab_.write("secret/b.proto", "");
  std::filesystem::create_directory_symlink(lab_.folder / "secret", lab_.folder / "agent/link");
  const auto listed = [&](const std::string& folder, bool for_rules, bool trust = false) {
    const auto files = make(trust).list(folder, {"agent"}, ".proto", for_rules);
    return files ? files->size() : 0;
  };
  for (const std::string folder : {"link", "absolute"}) {
    const std::string path = folder == "absolute" ? (lab_.folder / "secret").string() : folder;
    EXPECT_EQ(listed(path, false), 1) << folder;
    EXPECT_EQ(listed(path, true), 0) << folder;
    EXPECT_EQ(listed(path, true, true), 1) << folder;
  }
  EXPECT_EQ(listed("proto", true), 1);
  EXPECT_EQ(listed((lab_.folder / "agent/proto").string(), true), 1);
  EXPECT_EQ(listed(".", true), 1) << "links below it are not followed";
}

TEST_F(FilesTest, WritingEndsUpInTheRunAndIsReadBackFromThere) {
  Files files = make();
  auto path = files.for_writing("/tmp/state/save.dat");
  ASSERT_TRUE(path.ok()) << path.error().text();
  EXPECT_EQ(*path, (lab_.folder / "run/written/tmp/state/save.dat").string());
  EXPECT_FALSE(files.for_reading("/tmp/state/save.dat").ok());
  std::ofstream(*path) << "kept";
  EXPECT_EQ(*files.for_reading("/tmp/state/save.dat"), *path);
  EXPECT_EQ(*files.for_writing(*path), *path) << "the place itself stands for itself";
  EXPECT_FALSE(files.for_writing("../../outside").ok());
  EXPECT_EQ(files.journal_name(*path), "run/written/tmp/state/save.dat");
}

TEST_F(FilesTest, WritingDoesNotFollowALinkOutOfTheRun) {
  lab_.write("run/written/kept.txt", "");
  lab_.write("outside/there.txt", "as it was");
  std::filesystem::create_symlink(lab_.folder / "outside", lab_.folder / "run/written/folder");
  std::filesystem::create_symlink(lab_.folder / "outside/there.txt", lab_.folder / "run/written/link.txt");
  Files files = make();
  EXPECT_TRUE(files.for_writing("kept.txt").ok());
  for (const char* path : {"folder/new.txt", "folder/there.txt", "link.txt"}) {
    const auto target = files.for_writing(path);
    ASSERT_FALSE(target.ok()) << path;
    EXPECT_THAT(target.error().message, HasSubstr("a link leads out of the run's folder")) << path;
  }
}

TEST_F(FilesTest, WithoutARunFolderWritingIsRefused) {
  Files files(Files::Options{});
  auto path = files.for_writing("x");
  ASSERT_FALSE(path.ok());
  EXPECT_THAT(path.error().message, HasSubstr("no folder"));
}

TEST_F(FilesTest, RulesReadBackNothingOutsideOfTheirFolder) {
  lab_.write("run/written/mine.txt", "");
  lab_.write("run/manifest.json", "");
  lab_.write("secret.txt", "");
  Files files = make();
  EXPECT_TRUE(files.for_reading((lab_.folder / "run/written/mine.txt").string()).ok()) << "of this run";
  EXPECT_FALSE(files.for_reading((lab_.folder / "run/manifest.json").string()).ok()) << "not by rules";
  EXPECT_FALSE(files.for_reading("../secret.txt").ok());
  EXPECT_FALSE(files.for_reading("../../secret.txt").ok());
  EXPECT_FALSE(files.for_reading("a/../../../secret.txt").ok());
}

TEST(FilesOfRules, AFileThatTheRunCannotKeepIsNotRead) {
  for (const char* refused : {"config/config.yaml", "agent/rules.clp", "agent/c.yaml"}) {
    Lab lab;
    lab.agent(
        "(defrule go (time ?) => (config-load (str-cat (ament-index-get-package-share-directory \"agent\") "
        "\"/c.yaml\") \"/\"))");
    lab.write("agent/c.yaml", "a: 1");
    lab.options.on_read = [&](const std::string& name, const std::filesystem::path&) {
      return name == refused ? Status(resource_error("the disk is full")) : Status();
    };
    Status played = lab.start();
    if (played) played = lab.tick();
    EXPECT_TRUE(!played || !lab.log.with("the disk is full").empty()) << refused;
    if (played) {
      EXPECT_THAT(lab.facts("confval"), ::testing::IsEmpty()) << refused;
    }
  }
}

TEST(FilesOfRules, AreToldToTheRun) {
  Lab lab;
  lab.agent(
      "(defrule go (time ?) => (config-load (str-cat (ament-index-get-package-share-directory \"agent\") \"/c.yaml\") "
      "\"/\"))");
  lab.write("agent/c.yaml", "a: 1");
  std::vector<std::string> told;
  lab.options.on_read = [&](const std::string& name, const std::filesystem::path&) {
    told.push_back(name);
    return Status();
  };
  lab.run_up();
  lab.ticks(1);
  EXPECT_THAT(told, ::testing::ElementsAre("config/config.yaml", "agent/rules.clp", "agent/c.yaml"));
}

}  // namespace
}  // namespace cxlab::cx
