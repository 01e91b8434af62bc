#include "scenarios/rcll/config.h"

#include <gmock/gmock.h>

namespace cxlab::rcll {
namespace {

using testing::HasSubstr;

TEST(WorldConfig, TheDefaultsAreAGame) { EXPECT_TRUE(validate(WorldConfig{})); }

TEST(WorldConfig, AWrongWordIsAnsweredWithTheNearestOne) {
  WorldConfig config;
  config.team = "CYANE";
  const Status status = validate(config);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, ErrorKind::kInput);
  EXPECT_THAT(status.error().message, HasSubstr("world.team: found 'CYANE'"));
  EXPECT_THAT(status.error().message, HasSubstr("did you mean CYAN?"));
}

TEST(WorldConfig, ValuesOutOfRangeAreNamedWithTheirKey) {
  WorldConfig config;
  config.robots = 4;
  EXPECT_EQ(validate(config).error().message, "world.robots: found 4, expected 0 to 3");
  config = {};
  config.production_s = 0;
  EXPECT_THAT(validate(config).error().message, HasSubstr("world.production_s: found 0"));
  config = {};
  config.exploration = true;
  EXPECT_THAT(validate(config).error().message, HasSubstr("not supported in this release"));
}

TEST(WorldConfig, AnOrderMustHaveTheRingsOfItsComplexity) {
  WorldConfig config;
  config.orders.push_back({});
  EXPECT_TRUE(validate(config));
  config.orders[0].complexity = "C1";
  EXPECT_EQ(validate(config).error().message, "world.orders[0].ring_colors: found 0 rings, expected 1 for a C1");
  config.orders[0].ring_colors = {"RING_BLEU"};
  EXPECT_THAT(validate(config).error().message, HasSubstr("did you mean RING_BLUE?"));
  config.orders[0].ring_colors = {"RING_BLUE"};
  EXPECT_TRUE(validate(config));
  config.orders[0].base_color = "BASE_CLEAR";
  EXPECT_FALSE(validate(config)) << "clear bases only carry caps";
}

TEST(WorldConfig, ListedOrdersLeaveNothingToDrawComplexitiesFor) {
  WorldConfig config;
  config.orders.push_back({});
  config.complexities = {"C0"};
  EXPECT_THAT(validate(config).error().message, HasSubstr("world.complexities"));
}

}  // namespace
}  // namespace cxlab::rcll
