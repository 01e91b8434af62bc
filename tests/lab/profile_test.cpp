#include "lab/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cxlab::lab {
namespace {

using testing::HasSubstr;

TEST(Profile, NothingTakesMoreThanAllOfTheTime) {
  Profile profile;
  profile.plain_s = 0.100;
  profile.rules.resize(2);
  profile.rules[0].name = "long";
  profile.rules[0].s = profile.rules[0].acting_s = 0.102;
  profile.rules[1].name = "short";
  profile.rules[1].s = profile.rules[1].matching_s = 0.034;
  profile.functions.resize(1);
  profile.functions[0].name = "work";
  profile.functions[0].s = 0.119;
  const std::string text = text_of(profile, 10);
  EXPECT_THAT(text, HasSubstr(" 75.0%")) << "0.102 of 0.136 s";
  EXPECT_THAT(text, HasSubstr(" 25.0%"));
  EXPECT_THAT(text, HasSubstr(" 87.5%"));
  EXPECT_THAT(text, HasSubstr("0.00 ms (0.0%) outside of rules"));
  profile.functions[0].s = 0.170;
  EXPECT_THAT(text_of(profile, 10), HasSubstr("100.0%"));
  profile.plain_s = 0.340;
  EXPECT_THAT(text_of(profile, 10), HasSubstr(" 30.0%")) << "0.102 of 0.340 s";
}

}  // namespace
}  // namespace cxlab::lab
