// Answers as people read them.

#include "cx/inspect/text.h"

#include <gtest/gtest.h>

#include "cx/inspect/layout.h"

namespace cxlab::inspect {
namespace {

TEST(TreeText, HasALineForEachBranchBelowWhatItBelongsTo) {
  const Tree tree{"(done 1)",
                  {{"rule end", {{"(work 1)", {{"rule begin", {}}}}, {"(job 1)", {}}}}, {"rule other", {}}}};
  EXPECT_EQ(text_of(tree),
            "(done 1)\n"
            "├─ rule end\n"
            "│  ├─ (work 1)\n"
            "│  │  └─ rule begin\n"
            "│  └─ (job 1)\n"
            "└─ rule other\n");
  EXPECT_EQ(text_of(Tree{"alone", {}}), "alone\n");
}

TEST(TreeText, BreaksLongLinesBesideItsBranches) {
  const std::string fact =
      "(job (id 13) (purpose MOVE) (from \"C-BS OUTPUT\") (to \"C-RS1-INPUT\") (robot \"robot1\") (step DONE))";
  EXPECT_EQ(
      text_of(Tree{"rule begin", {{fact + "  asserted at 1.000 s", {{"rule end", {}}}}, {fact + ", " + fact, {}}}}),
      "rule begin\n"
      "├─ (job (id 13) (purpose MOVE) (from \"C-BS OUTPUT\") (to \"C-RS1-INPUT\") (robot \"robot1\") (step DONE))\n"
      "│  │  asserted at 1.000 s\n"
      "│  └─ rule end\n"
      "└─ (job (id 13) (purpose MOVE) (from \"C-BS OUTPUT\") (to \"C-RS1-INPUT\") (robot \"robot1\")\n"
      "      (step DONE)), (job (id 13) (purpose MOVE) (from \"C-BS OUTPUT\") (to \"C-RS1-INPUT\")\n"
      "      (robot \"robot1\") (step DONE))\n");
}

std::string a(std::size_t n) { return std::string(n, 'a'); }

TEST(Layout, BreaksAtBlanksWhereALineIsFull) {
  EXPECT_EQ(laid_out("", "- ", "  "), "- \n");
  EXPECT_EQ(laid_out(a(98), "- ", "  "), "- " + a(98) + "\n");
  EXPECT_EQ(laid_out(a(49) + ' ' + a(48), "- ", "  "), "- " + a(49) + ' ' + a(48) + "\n");
  EXPECT_EQ(laid_out(a(49) + ' ' + a(49), "- ", "  "), "- " + a(49) + "\n  " + a(49) + "\n");
  EXPECT_EQ(laid_out(a(120) + " b", "- ", "  "), "- " + a(120) + "\n  b\n");
  EXPECT_EQ(laid_out("b  " + a(98), "", " "), "b\n " + a(98) + "\n") << "blanks of a break are left out";
  EXPECT_EQ(laid_out("ü " + a(98), "", " "), "ü " + a(98) + "\n") << "letters count, not bytes";
}

TEST(Layout, KeepsTogetherWhatBelongsTogether) {
  EXPECT_EQ(laid_out(a(90) + " ?id = 12 ?x = 3", "", " "), a(90) + " ?id = 12\n ?x = 3\n");
  EXPECT_EQ(laid_out("(f " + a(81) + " (at 1.0 2.0 3.0) (b 1))", "", " "),
            "(f " + a(81) + "\n (at 1.0 2.0 3.0) (b 1))\n");
  EXPECT_EQ(laid_out("(f " + a(90) + " \"one two\" b)", "", " "), "(f " + a(90) + "\n \"one two\" b)\n");
  EXPECT_EQ(laid_out(a(90) + " at 12.5 s, by", "", " "), a(90) + " at\n 12.5 s, by\n");
  EXPECT_EQ(laid_out(a(90) + " at 12.5 so", "", " "), a(90) + " at 12.5\n so\n");
  const std::string list = "(f (list " + a(60) + ' ' + a(60) + "))";
  EXPECT_EQ(laid_out(list, "", " "), "(f (list " + a(60) + "\n " + a(60) + "))\n") << "too long for a line by itself";
  EXPECT_EQ(laid_out("cut \"" + a(90) + " b " + a(20), "", " "), "cut \"" + a(90) + " b\n " + a(20) + "\n")
      << "the string has no end";
}

TEST(Layout, BreaksAMessageBehindCommas) {
  EXPECT_EQ(laid_out("{" + a(60) + "," + a(60) + "," + a(30) + "}", "", "  "),
            "{" + a(60) + ",\n  " + a(60) + "," + a(30) + "}\n");
}

TEST(Layout, LeavesRoomFarToTheRight) {
  const std::string far(90, ' ');
  EXPECT_EQ(laid_out(a(30) + ' ' + a(30), far, far), far + a(30) + '\n' + far + a(30) + '\n');
  EXPECT_EQ(laid_out(a(20) + ' ' + a(19), far, far), far + a(20) + ' ' + a(19) + '\n');
}

TEST(TimeText, IsReadWithAndWithoutMinutes) {
  for (const auto& [text, seconds] : std::vector<std::pair<std::string, std::string>>{{"312.4", "312.4"},
                                                                                      {"5:12", "312"},
                                                                                      {"5:12.4", "312.4"},
                                                                                      {"0:00", "0"},
                                                                                      {"100:59.125", "6059.125"},
                                                                                      {"0", "0"}})
    EXPECT_EQ(seconds_in(text), seconds) << text;
  for (const char* text :
       {"", "x", "-1", ":5", "5:", "5:1", "5:60", "5:123", "5:12.", "5:12x", "1:05:12", "nan", "inf", "5:1a"})
    EXPECT_EQ(seconds_in(text), std::nullopt) << text;
}

TEST(TimeText, IsInMilliseconds) {
  EXPECT_EQ(seconds_text(SimTime{}), "0.000 s");
  EXPECT_EQ(seconds_text(SimTime{312'400'000'000}), "312.400 s");
}

}  // namespace
}  // namespace cxlab::inspect
