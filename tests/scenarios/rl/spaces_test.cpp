#include "scenarios/rl/spaces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cxlab::rl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

SpaceAnswers blocks() {
  SpaceAnswers answers;
  answers.observables = {"tower(done)"};
  answers.predicates = {{"on", {"block", "place"}}};
  answers.actions = {"wait()"};
  answers.action_schemas = {{"move", {"block"}}, {"stop", {}}};
  answers.objects = {{"block", {"b", "a"}}, {"place", {"table"}}};
  return answers;
}

TEST(Spaces, ArePredefinedOnesAndAllCombinationsSorted) {
  const Spaces spaces = *Spaces::make(blocks());
  EXPECT_THAT(spaces.observables(), ElementsAre("on(a#table)", "on(b#table)", "tower(done)"));
  EXPECT_THAT(spaces.actions(), ElementsAre("no-op", "move(a)", "move(b)", "stop()", "wait()"));
}

TEST(Spaces, NameEachOnlyOnce) {
  SpaceAnswers answers = blocks();
  answers.observables.push_back("on(a#table)");
  EXPECT_EQ(Spaces::make(answers)->observables().size(), 3U);
}

TEST(Spaces, HaveABitForEachObservableThatIsTrue) {
  const Spaces spaces = *Spaces::make(blocks());
  std::vector<std::string> unknown;
  EXPECT_THAT(spaces.observation({"tower(done)", "on(a#table)", "on(c#table)"}, &unknown), ElementsAre(1, 0, 1));
  EXPECT_THAT(unknown, ElementsAre("on(c#table)"));
  EXPECT_THAT(spaces.observation({}, nullptr), ElementsAre(0, 0, 0));
}

TEST(Spaces, KnowThePlaceOfAnAction) {
  const Spaces spaces = *Spaces::make(blocks());
  EXPECT_EQ(spaces.place_of("move(b)"), 2U);
  EXPECT_EQ(spaces.place_of("wait()"), 4U);
  EXPECT_EQ(spaces.place_of("move(c)"), 0U);
  EXPECT_EQ(spaces.place_of("no-op"), 0U);
}

TEST(Spaces, WithoutAnswersHaveOnlyNoOp) {
  const Spaces spaces = *Spaces::make({});
  EXPECT_THAT(spaces.observables(), IsEmpty());
  EXPECT_THAT(spaces.actions(), ElementsAre("no-op"));
}

TEST(Spaces, LeaveOutWhatHasAParameterWithoutObjects) {
  SpaceAnswers answers = blocks();
  answers.objects["place"].clear();
  EXPECT_THAT(Spaces::make(answers)->observables(), ElementsAre("tower(done)"));
  answers.objects.erase("block");
  EXPECT_THAT(Spaces::make(answers)->actions(), ElementsAre("no-op", "stop()", "wait()"));
}

TEST(Spaces, ThatAreTooLargeAreRefused) {
  SpaceAnswers answers = blocks();
  answers.predicates = {{"far", {"n", "n", "n"}}};
  for (int i = 0; i < 101; ++i) answers.objects["n"].push_back(std::to_string(i));
  const auto spaces = Spaces::make(answers);
  ASSERT_FALSE(spaces.ok());
  EXPECT_THAT(spaces.error().message, HasSubstr("far has more than 1000000 combinations"));
}

TEST(Spaces, SchemasTakeTheirTypesFromOneList) {
  const std::vector<Schema> schemas = schemas_of({"on", "clear", "tower"}, {2, 1, 0}, {"block", "place", "block"});
  ASSERT_EQ(schemas.size(), 3U);
  EXPECT_THAT(schemas[0].types, ElementsAre("block", "place"));
  EXPECT_THAT(schemas[1].types, ElementsAre("block"));
  EXPECT_THAT(schemas[2].types, IsEmpty());
}

}  // namespace
}  // namespace cxlab::rl
