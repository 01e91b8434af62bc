// Where two journals part, by their content.

#include "lab/journal_difference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "folder.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class JournalDifference : public FolderTest {
 protected:
  /// Writes a journal with a line for each record: stream, time in ms, data.
  struct Line {
    std::string stream;
    int ms;
    std::string data;
    std::string kind = "fire";
  };
  std::filesystem::path run(const std::string& name, const std::vector<Line>& lines) {
    std::string text;
    for (std::size_t n = 0; n < lines.size(); ++n)
      text += R"({"stream":")" + lines[n].stream + R"(","n":)" + std::to_string(n) + R"(,"t":)" +
              std::to_string(lines[n].ms) + R"(000000,"kind":")" + lines[n].kind + R"(","data":)" + lines[n].data +
              R"(,"cause":[]})" + "\n";
    write(name + "/journal.jsonl", text);
    return path(name);
  }
  std::vector<std::string> first(const std::vector<Line>& then, const std::vector<Line>& now) {
    std::vector<std::string> out;
    const auto found = first_differences(run("then", then), run("now", now));
    if (!found) return {found.error().text()};
    for (const Difference& difference : *found) out.push_back(difference.text());
    return out;
  }
};

TEST_F(JournalDifference, FirstOfEachStreamComesInOrderOfTime) {
  EXPECT_THAT(first({{"a", 1, R"({"x":1})"}, {"b", 2, R"({"x":1})"}, {"a", 3, R"({"x":2})"}, {"b", 4, R"({"x":3})"}},
                    {{"a", 1, R"({"x":1})"}, {"b", 2, R"({"x":2})"}, {"a", 3, R"({"x":9})"}, {"b", 4, R"({"x":4})"}}),
              ElementsAre(R"(b at 0.002 s: then fire {"x":1}, now fire {"x":2})",
                          R"(a at 0.003 s: then fire {"x":2}, now fire {"x":9})"));
}

TEST_F(JournalDifference, TheSameRecordsInAnotherOrderOfStreamsAreNoDifference) {
  EXPECT_THAT(first({{"a", 1, "{}"}, {"b", 1, "{}"}, {"a", 2, "{}"}}, {{"b", 1, "{}"}, {"a", 1, "{}"}, {"a", 2, "{}"}}),
              IsEmpty());
}

TEST_F(JournalDifference, ARecordAtAnotherTimeHasItsTime) {
  EXPECT_THAT(first({{"a", 1000, R"({"x":1})"}}, {{"a", 1250, R"({"x":1})"}}),
              ElementsAre(R"(a at 1.000 s: then fire {"x":1}, now fire {"x":1} at 1.250 s)"));
  EXPECT_THAT(first({{"a", 1250, R"({"x":1})"}}, {{"a", 1000, R"({"x":1})"}}),
              ElementsAre(R"(a at 1.000 s: then fire {"x":1} at 1.250 s, now fire {"x":1})"));
}

TEST_F(JournalDifference, ARecordThatOneRunDoesNotHaveHasNothingLikeIt) {
  EXPECT_THAT(first({{"a", 1, "{}"}}, {{"a", 1, "{}"}, {"a", 2, R"({"x":1})"}}),
              ElementsAre(R"(a at 0.002 s: then nothing like it, now fire {"x":1})"));
}

TEST_F(JournalDifference, RecordsAtTheEndCountAndLaterOnesDoNot) {
  const auto then = run("then", {{"a", 1, "{}"}, {"b", 2, "{}"}, {"c", 3, "{}"}}), now = run("now", {});
  const auto found = first_differences(then, now, std::chrono::milliseconds(2));
  ASSERT_TRUE(found) << found.error().text();
  std::vector<std::string> streams;
  for (const Difference& difference : *found) streams.push_back(difference.text().substr(0, 1));
  EXPECT_THAT(streams, ElementsAre("a", "b"));
}

TEST_F(JournalDifference, WhatWasPlannedIsNone) {
  EXPECT_THAT(first({{"env/a", 1, R"({"what":"start"})"}},
                    {{"env/a", 1, R"({"what":"load","text":""})", "control"}, {"env/a", 1, R"({"what":"start"})"}}),
              IsEmpty());
  EXPECT_THAT(first({}, {{"env/a", 1, R"({"what":"eval","text":"x"})", "control"}}), testing::SizeIs(1));
}

TEST_F(JournalDifference, ALineThatIsNoRecordHasItsPlace) {
  const auto then = run("then", {{"a", 1, "{}"}}), now = run("now", {{"a", 1, "{}"}});
  write("now/journal.jsonl", "{\n");
  const auto found = first_differences(then, now);
  ASSERT_FALSE(found.ok());
  EXPECT_THAT(found.error().text(), testing::StartsWith((now / "journal.jsonl").string() + ":1: "));
}

TEST_F(JournalDifference, ARunWithoutAJournalHasNoRecords) {
  const auto then = run("then", {{"a", 1, "{}"}});
  std::filesystem::create_directories(path("none"));
  EXPECT_EQ(first_differences(then, path("none"))->size(), 1u);
}

}  // namespace
}  // namespace cxlab::lab
