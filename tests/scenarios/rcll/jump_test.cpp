#include <gmock/gmock.h>

#include "tests/support/game_story.h"

namespace cxlab::rcll {
namespace {

/// A base goes from the base station through the payment slide, a carrier through the cap station. Time moves by what
/// `next` says; the records show when everything happened.
TEST(JumpingTime, FindsEverythingThatHappensAtTheTickAtWhichItIsDue) {
  const auto play = [](bool jump) {
    GameStory story;
    story.set_jumping(jump);
    const std::size_t base = story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
    story.move("C-CS1-SHELF-LEFT", "C-CS1-INPUT");
    const std::size_t cap = story.instruct("{machine: C-CS1, operation: RETRIEVE_CAP}");
    const std::size_t stuck = story.instruct("{machine: C-CS2, operation: RETRIEVE_CAP}");
    story.run_until(70);
    EXPECT_EQ(story.outcome(base).code, 0);
    EXPECT_EQ(story.outcome(cap).code, 0);
    EXPECT_EQ(story.outcome(stuck).code, 202);
    EXPECT_EQ(story.state("C-CS2"), "IDLE") << "30 s after it broke";
    return std::tuple{story.outcome(base).at, story.outcome(cap).at, story.outcome(stuck).at, story.ticks()};
  };
  const auto [base, cap, stuck, all_ticks] = play(false);
  const auto [base_jump, cap_jump, stuck_jump, few_ticks] = play(true);
  EXPECT_NEAR(base, base_jump, 0.041);
  EXPECT_NEAR(cap, cap_jump, 0.041);
  EXPECT_NEAR(stuck, stuck_jump, 0.041);
  EXPECT_LT(few_ticks * 10, all_ticks);
}

}  // namespace
}  // namespace cxlab::rcll
