// Runs with another CLIPS library than the engine was built with (other_clips.c).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cx/engine/engine.h"

namespace cxlab {
namespace {

TEST(OtherClips, IsRefusedWithBothVersions) {
  EngineOptions options;
  options.name = "main";
  const auto engine = RuleEngine::create(std::move(options));
  ASSERT_FALSE(engine.ok());
  EXPECT_EQ(engine.error().kind, ErrorKind::kResource);
  EXPECT_THAT(engine.error().message,
              testing::AllOf(testing::HasSubstr("found the CLIPS library 'CLIPS (6.41 1/1/23)'"),
                             testing::HasSubstr("expected 'CLIPS (")));
}

}  // namespace
}  // namespace cxlab
