#include "cx/journal/run_folder.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "cx/base/append_file.h"
#include "cx/journal/file_store.h"
#include "tests/support/files.h"

namespace cxlab {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(RunFolder, ANameThatIsThereGetsANumber) {
  TempFolder temp;
  EXPECT_EQ(*make_numbered_folder(temp / "runs", "game-1"), temp / "runs/game-1");
  EXPECT_EQ(*make_numbered_folder(temp / "runs", "game-1"), temp / "runs/game-1-2");
  EXPECT_EQ(*make_numbered_folder(temp / "runs", "game-1"), temp / "runs/game-1-3");
  EXPECT_EQ(*make_numbered_folder(temp / "runs", "game-2"), temp / "runs/game-2");
}

TEST(RunFolder, AFolderOfTheUserIsMadeOrUsedIfEmpty) {
  TempFolder temp;
  EXPECT_TRUE(make_output_folder(temp / "a/b", false).ok());
  EXPECT_TRUE(fs::is_directory(temp / "a/b"));
  EXPECT_TRUE(make_output_folder(temp / "a/b", false).ok());
}

TEST(RunFolder, AFolderInUseIsAUsageErrorAndStaysAsItWas) {
  TempFolder temp;
  put_file(temp / "out/result.json", "old");
  const auto folder = make_output_folder(temp / "out", false);
  ASSERT_FALSE(folder.ok());
  EXPECT_EQ(folder.error().kind, ErrorKind::kUsage);
  EXPECT_THAT(folder.error().text(), HasSubstr("--force"));
  EXPECT_EQ(content_of(temp / "out/result.json"), "old");

  put_file(temp / "file", "");
  EXPECT_EQ(make_output_folder(temp / "file", true).error().kind, ErrorKind::kUsage);
}

TEST(RunFolder, ForceTakesAwayAFormerRunAndNothingElse) {
  TempFolder temp;
  put_file(temp / "out/result.json", "old");
  put_file(temp / "out/snapshots/10.png", "old");
  put_file(temp / "out/notes.txt", "mine");
  ASSERT_TRUE(make_output_folder(temp / "out", true).ok());
  EXPECT_FALSE(fs::exists(temp / "out/result.json"));
  EXPECT_FALSE(fs::exists(temp / "out/snapshots"));
  EXPECT_EQ(content_of(temp / "out/notes.txt"), "mine");

  put_file(temp / "home/files/letter.txt", "mine");
  ASSERT_TRUE(make_output_folder(temp / "home", true).ok());
  EXPECT_EQ(content_of(temp / "home/files/letter.txt"), "mine") << "there was no run in this folder";
}

TEST(RunFolder, AFolderThatCannotBeMadeIsAResourceError) {
  TempFolder temp;
  put_file(temp / "file", "");
  EXPECT_EQ(make_output_folder(temp / "file/run", false).error().kind, ErrorKind::kResource);
  EXPECT_EQ(make_numbered_folder(temp / "file", "game-1").error().kind, ErrorKind::kResource);
}

TEST(RunFolder, AFileIsReplacedWhole) {
  TempFolder temp;
  ASSERT_TRUE(make_output_folder(temp / "run", false).ok());
  ASSERT_TRUE(replace_file(temp / "run/result.json", "{\"status\": \"failed\"}").ok());
  ASSERT_TRUE(replace_file(temp / "run/result.json", "{\"status\": \"completed\"}").ok());
  EXPECT_EQ(content_of(temp / "run/result.json"), "{\"status\": \"completed\"}");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp / "run"), {}), 1) << "nothing unfinished stays";
}

TEST(RunFolder, AFullDiskLeavesTheOldFile) {
  TempFolder temp;
  ASSERT_TRUE(make_output_folder(temp / "run", false).ok());
  ASSERT_TRUE(replace_file(temp / "run/result.json", "old").ok());
  Status status;
  {
    FileSizeLimit limit(1000);
    status = replace_file(temp / "run/result.json", std::string(5000, 'x'));
  }
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().kind, ErrorKind::kResource);
  EXPECT_EQ(content_of(temp / "run/result.json"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp / "run"), {}), 1);
}

TEST(AppendFile, AFullDiskCutsTheFileBackToWholePieces) {
  TempFolder temp;
  auto file = AppendFile::create(temp / "log");
  ASSERT_TRUE(file->append("one\n").ok());
  ASSERT_TRUE(file->flush().ok());
  {
    FileSizeLimit limit(14);
    ASSERT_TRUE(file->append("two\n").ok());
    ASSERT_TRUE(file->append("three\n").ok());
    ASSERT_TRUE(file->append("four\n").ok());
    EXPECT_FALSE(file->flush().ok());
  }
  EXPECT_EQ(content_of(temp / "log"), "one\ntwo\nthree\n");
  EXPECT_FALSE(file->append("five\n").ok()) << "an error stays";
  EXPECT_FALSE(file->close().ok());
  EXPECT_EQ(content_of(temp / "log"), "one\ntwo\nthree\n");
}

TEST(AppendFile, APieceAtTheBorderOfTheDiskIsKept) {
  TempFolder temp;
  auto file = AppendFile::create(temp / "log");
  FileSizeLimit limit(8);
  ASSERT_TRUE(file->append("one\n").ok());
  ASSERT_TRUE(file->append("two\n").ok());
  ASSERT_TRUE(file->flush().ok());
  ASSERT_TRUE(file->append("x").ok());
  EXPECT_FALSE(file->flush().ok());
  EXPECT_EQ(content_of(temp / "log"), "one\ntwo\n");
}

TEST(FileStore, ARunGivesBackTheFilesThatItRead) {
  TempFolder temp;
  put_file(temp / "source/rules.clp", "(defrule a => )");
  put_file(temp / "source/copy.clp", "(defrule a => )");
  put_file(temp / "source/model.bin", std::string("\0\xff\n", 3));
  auto store = FileStore::create(temp / "run");
  ASSERT_TRUE(store->add("pkg/rules/rules.clp", temp / "source/rules.clp").ok());
  ASSERT_TRUE(store->add("pkg/copy.clp", temp / "source/copy.clp").ok());
  ASSERT_TRUE(store->add("scenario/model.bin", temp / "source/model.bin").ok());
  fs::remove_all(temp / "source");
  fs::rename(temp / "run", temp / "elsewhere");

  const auto stored = StoredFiles::open(temp / "elsewhere");
  ASSERT_TRUE(stored.ok()) << stored.error().text();
  EXPECT_THAT(stored->names(), ElementsAre("pkg/copy.clp", "pkg/rules/rules.clp", "scenario/model.bin"));
  EXPECT_EQ(*stored->read("pkg/rules/rules.clp"), "(defrule a => )");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp / "elsewhere/files"), {}), 3) << "two contents and the index";
  ASSERT_TRUE(stored->materialise(temp / "work").ok());
  EXPECT_EQ(content_of(temp / "work/scenario/model.bin"), std::string("\0\xff\n", 3));
  EXPECT_EQ(content_of(temp / "work/pkg/copy.clp"), "(defrule a => )");
}

TEST(FileStore, ACopyIsReadByThoseWhoReadItsFile) {
  using fs::perms;
  const TempFolder temp;
  const fs::path source = temp / "a.clp", run = temp / "run";
  constexpr perms kOthers = perms::group_read | perms::others_read;
  put_file(temp / "usual", "");
  const perms usual = fs::status(temp / "usual").permissions();
  for (const perms open : {perms::none, perms::group_read, kOthers}) {
    const std::string text = "(a " + std::to_string(static_cast<unsigned>(open)) + ")";
    put_file(source, text);
    fs::permissions(source, perms::owner_read | perms::owner_write | open);
    auto store = FileStore::create(run);
    ASSERT_TRUE(store.ok());
    ASSERT_TRUE(store->add("agent/a.clp", source).ok());
    EXPECT_EQ(fs::status(run / "files" / content_hash(text)).permissions() & kOthers, open & usual);
  }
}

TEST(FileStore, AFileThatChangesKeepsItsFirstContent) {
  TempFolder temp;
  auto store = FileStore::create(temp.path());
  ASSERT_TRUE(store->add_content("a", "first").ok());
  ASSERT_TRUE(store->add_content("a", "second").ok());
  ASSERT_TRUE(store->add_content("a", "second").ok());
  EXPECT_EQ(*StoredFiles::open(temp.path())->read("a"), "first");
  EXPECT_EQ(content_of(temp / "files" / content_hash("second")), "second");
  const std::string index = content_of(temp / "files/index.jsonl");
  EXPECT_NE(index.find(content_hash("second")), std::string::npos);
  EXPECT_EQ(index.find(content_hash("second")), index.rfind(content_hash("second"))) << "each content once";
}

TEST(FileStore, ACopyThatWasChangedIsAnError) {
  TempFolder temp;
  auto store = FileStore::create(temp.path());
  ASSERT_TRUE(store->add_content("a", "first").ok());
  put_file(temp / "files" / content_hash("first"), "other");
  const auto stored = StoredFiles::open(temp.path());
  EXPECT_THAT(stored->read("a").error().text(), HasSubstr("was changed"));
  EXPECT_THAT(stored->read("b").error().text(), HasSubstr("no copy of 'b'"));
  const Status laid_out = stored->materialise(temp / "work");
  ASSERT_FALSE(laid_out.ok());
  EXPECT_EQ(laid_out.error().kind, ErrorKind::kInput);
  EXPECT_FALSE(fs::exists(temp / "work/a"));
}

TEST(FileStore, NoNameLeavesTheFolder) {
  TempFolder temp;
  auto store = FileStore::create(temp.path());
  for (const std::string& name :
       {std::string("a\0b", 3), std::string(), std::string("/etc/a"), std::string("../a"), std::string("a/../../b"),
        std::string("a//b"), std::string("a/."), std::string("a/"), std::string("."), std::string("..")}) {
    EXPECT_FALSE(store->add_content(name, "x").ok()) << name;
  }
  const auto error_of = [&](const std::string& index) {
    put_file(temp / "files/index.jsonl", index);
    return StoredFiles::open(temp.path()).error().text();
  };
  const std::string good = R"({"name":"a","hash":")" + content_hash("x") + "\"}\n";
  EXPECT_THAT(error_of(good + R"({"name":"../a","hash":")" + content_hash("x") + "\"}\n"),
              HasSubstr("index.jsonl:2: found '../a'"));
  for (const std::string& hash : {std::string("../../b"), std::string(31, 'a'), std::string(33, 'a'),
                                  std::string(32, 'g'), std::string(32, 'A'), std::string(31, '0') + '/'})
    EXPECT_THAT(error_of("{\"name\":\"a\",\"hash\":\"" + hash + "\"}\n"), HasSubstr("hash of 32")) << hash;
  EXPECT_THAT(error_of("{\"name\":\"a\",\"hash\":\"" + std::string(32, '/') + "\"}\n"), HasSubstr("hash of 32"));
  EXPECT_THAT(error_of("{\n"), HasSubstr("expected the name of a copy"));
}

TEST(FileStore, TheIndexIsWholeWheneverTheProcessEnds) {
  TempFolder temp;
  auto store = FileStore::create(temp.path());
  EXPECT_THAT(StoredFiles::open(temp.path())->names(), testing::IsEmpty());
  ASSERT_TRUE(store->add_content("a", "first").ok());
  const std::string index = content_of(temp / "files/index.jsonl");
  EXPECT_THAT(StoredFiles::open(temp.path())->names(), ElementsAre("a"));
  ASSERT_TRUE(store->add_content("b", "second").ok());
  const std::string longer = content_of(temp / "files/index.jsonl");
  for (std::size_t size = index.size(); size < longer.size(); ++size) {
    put_file(temp / "files/index.jsonl", longer.substr(0, size));
    EXPECT_THAT(StoredFiles::open(temp.path())->names(), ElementsAre("a")) << size;
  }
}

TEST(FileStore, WithoutItsIndexIsAnError) {
  TempFolder temp;
  fs::create_directories(temp / "files/index.jsonl");
  EXPECT_THAT(FileStore::create(temp.path()).error().text(), HasSubstr("index.jsonl"));
}

TEST(RunFolder, ANameThatNoFolderCanHaveIsAnError) {
  TempFolder temp;
  const auto made = make_numbered_folder(temp.path(), std::string(300, 'a'));
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(made.error().text(), HasSubstr("cannot be made: "));
}

TEST(FileStore, WhatCannotBeWrittenOutIsAnError) {
  TempFolder temp;
  auto store = FileStore::create(temp.path());
  ASSERT_TRUE(store->add_content("pkg/a.clp", "a").ok());
  const auto stored = StoredFiles::open(temp.path());
  put_file(temp / "file", "");
  EXPECT_THAT(stored->materialise(temp / "file").error().text(), HasSubstr("cannot be made"));
  fs::create_directories(temp / "work/pkg/a.clp/in_the_way");
  const Status written = stored->materialise(temp / "work");
  ASSERT_FALSE(written.ok());
  EXPECT_THAT(written.error().text(), HasSubstr("a.clp: cannot be written"));
  EXPECT_FALSE(fs::exists(temp / "work/pkg/a.clp.part"));
  fs::remove(temp / "files" / content_hash("a"));
  EXPECT_FALSE(stored->materialise(temp / "other").ok());
}

TEST(FileStore, AFileThatIsMissingIsAnError) {
  TempFolder temp;
  auto store = FileStore::create(temp.path());
  EXPECT_EQ(store->add("a", temp / "none").error().kind, ErrorKind::kInput);
  EXPECT_THAT(store->add("a", temp.path()).error().text(), HasSubstr("is a folder"));
  const auto no_index = StoredFiles::open(temp / "none");
  ASSERT_FALSE(no_index.ok());
  EXPECT_EQ(no_index.error().kind, ErrorKind::kInput);
}

TEST(ContentHash, IsXxh3Of128Bits) {
  EXPECT_EQ(content_hash(""), "99aa06d3014798d86001c324468d497f");  // xxHash's own value for the empty input
}

}  // namespace
}  // namespace cxlab
