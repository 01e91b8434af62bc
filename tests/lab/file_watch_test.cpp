// Changes of files are noticed however an editor makes them, once each, and only when it has done.

#include "lab/file_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/files.h"

namespace cxlab::lab {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(FileWatch, TellsEachChangeOnceItRests) {
  const TempFolder temp;
  const fs::path a = temp.path() / "a.clp", b = temp.path() / "b.clp", late = temp.path() / "late.clp";
  const auto write = [](const fs::path& file, const std::string& text) { std::ofstream(file) << text; };
  write(a, "one");
  write(b, "one");
  FileWatch watch;
  watch.watch({a, b, late}, INT64_MAX);
  EXPECT_THAT(watch.changed(), IsEmpty());

  write(a, "longer");
  EXPECT_THAT(watch.changed(), IsEmpty()) << "it may still be written";
  EXPECT_THAT(watch.changed(), ElementsAre(a));
  EXPECT_THAT(watch.changed(), IsEmpty());

  write(temp.path() / "new", "two");  // as editors save: another file of the same size takes the name
  fs::rename(temp.path() / "new", b);
  watch.watch({a, b, late}, INT64_MAX);  // which forgets no change
  (void)watch.changed();
  EXPECT_THAT(watch.changed(), ElementsAre(b));

  fs::remove(a);
  write(late, "now");
  (void)watch.changed();
  EXPECT_THAT(watch.changed(), ElementsAre(a, late));
  EXPECT_THAT(watch.changed(), IsEmpty());

  write(a, "again");
  watch.watch({a}, 0);
  (void)watch.changed();
  EXPECT_THAT(watch.changed(), ElementsAre(a));
}

TEST(FileWatch, AFileThatWasWrittenAfterItWasReadHasChanged) {
  const TempFolder temp;
  const fs::path file = temp.path() / "a.clp";
  std::ofstream(file) << "one";
  FileWatch watch;
  watch.watch({file}, 0);
  EXPECT_THAT(watch.changed(), ElementsAre(file));
  EXPECT_THAT(watch.changed(), IsEmpty());
}

}  // namespace
}  // namespace cxlab::lab
