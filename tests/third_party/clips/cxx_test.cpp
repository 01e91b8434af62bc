#include <clips.h>
#include <gtest/gtest.h>

namespace {

// Compiled as C++, its functions have C++ names: this test does not link to the C library.
TEST(ClipsAsCxx, RuleFiresOnAnAssertedFact) {
  Environment* env = CreateEnvironment();
  ASSERT_NE(env, nullptr);
  ASSERT_EQ(Build(env, "(defrule answer (question) => (assert (answer 42)))"), BE_NO_ERROR);
  ASSERT_NE(AssertString(env, "(question)"), nullptr);

  EXPECT_EQ(::Run(env, -1), 1);

  CLIPSValue answers;
  ASSERT_EQ(Eval(env, "(find-all-facts ((?a answer)) TRUE)", &answers), EE_NO_ERROR);
  EXPECT_EQ(answers.multifieldValue->length, 1u);
  EXPECT_TRUE(DestroyEnvironment(env));
}

}  // namespace
