#include "planner/validator/crossing.h"

#include <gmock/gmock.h>

namespace cxlab::planner {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Roots, OfLinearAndQuadraticPolynomials) {
  EXPECT_THAT(roots({-3, 2}, 10), ElementsAre(1.5));
  EXPECT_THAT(roots({-3, 2}, 1), IsEmpty()) << "outside the interval";
  EXPECT_THAT(roots({5}, 10), IsEmpty());
  EXPECT_THAT(roots({6, -5, 1}, 10), ElementsAre(2, 3));
  EXPECT_THAT(roots({4, -4, 1}, 10), ElementsAre(2)) << "touches 0";
  EXPECT_THAT(roots({4, 0, 1}, 10), IsEmpty());
  EXPECT_THAT(roots({0, -2, 1, 0}, 10), ElementsAre(2)) << "the interval is open at 0";
  EXPECT_THAT(roots({1, -1e8, 1}, 10), ElementsAre(DoubleNear(1e-8, 1e-20))) << "no cancellation";
}

TEST(Roots, OfHigherPolynomials) {
  EXPECT_THAT(roots({-6, 11, -6, 1}, 10), ElementsAre(DoubleNear(1, 1e-9), DoubleNear(2, 1e-9), DoubleNear(3, 1e-9)));
  EXPECT_THAT(roots({16, 0, -8, 0, 1}, 10), ElementsAre(DoubleNear(2, 1e-9))) << "(t^2 - 4)^2 touches 0";
}

}  // namespace
}  // namespace cxlab::planner
