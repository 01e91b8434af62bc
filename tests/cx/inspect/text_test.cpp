// Answers as people read them.

#include "cx/inspect/text.h"

#include <gtest/gtest.h>

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

TEST(TimeText, IsInMilliseconds) {
  EXPECT_EQ(seconds_text(SimTime{}), "0.000 s");
  EXPECT_EQ(seconds_text(SimTime{312'400'000'000}), "312.400 s");
}

}  // namespace
}  // namespace cxlab::inspect
