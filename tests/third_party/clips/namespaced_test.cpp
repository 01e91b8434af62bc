#include <clips_ns/clips.h>
#include <gtest/gtest.h>

// The enumerators and functions of CLIPS are no names of ours.
enum Ours { ALL, RULES, FACTS };

namespace {

void add_numbers(clips::Environment* env, clips::UDFContext* context, clips::UDFValue* result) {
  clips::UDFValue left, right;
  ASSERT_TRUE(clips::UDFFirstArgument(context, clips::INTEGER_BIT, &left));
  ASSERT_TRUE(clips::UDFNextArgument(context, clips::INTEGER_BIT, &right));
  result->integerValue = clips::CreateInteger(env, left.integerValue->contents + right.integerValue->contents);
}

TEST(NamespacedClips, RuleFiresOnAnAssertedFactAndCallsOurFunction) {
  clips::Environment* env = clips::CreateEnvironment();
  ASSERT_NE(env, nullptr);
  ASSERT_EQ(clips::AddUDF(env, "add-numbers", "l", 2, 2, "l", add_numbers, "add_numbers", nullptr),
            clips::AUE_NO_ERROR);
  ASSERT_EQ(clips::Build(env, "(defrule add (pair ?a ?b) => (assert (sum (add-numbers ?a ?b))))"), clips::BE_NO_ERROR);
  ASSERT_NE(clips::AssertString(env, "(pair 20 22)"), nullptr);

  EXPECT_EQ(clips::Run(env, -1), 1);

  clips::CLIPSValue sums;
  ASSERT_EQ(clips::Eval(env, "(find-all-facts ((?s sum)) (= (nth$ 1 ?s:implied) 42))", &sums), clips::EE_NO_ERROR);
  EXPECT_EQ(sums.multifieldValue->length, 1u);
  EXPECT_TRUE(clips::DestroyEnvironment(env));
}

TEST(NamespacedClips, SyntaxErrorIsAValue) {
  clips::Environment* env = clips::CreateEnvironment();
  clips::DeleteRouter(env, "fileio");
  EXPECT_EQ(clips::Build(env, "(defrule broken (fact ?x) => (assert (other ?y)))"), clips::BE_PARSING_ERROR);
  EXPECT_TRUE(clips::DestroyEnvironment(env));
}

}  // namespace
