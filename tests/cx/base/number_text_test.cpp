#include "cx/base/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>

namespace cxlab {
namespace {

std::string printed(const char* format, int digits, double value) {
  char text[400];
  std::snprintf(text, sizeof text, format, digits, value);
  return text;
}

TEST(NumberText, IsThatOfPrintf) {
  constexpr double kNumbers[] = {
      0.0,  -0.0,   1.0,     1.5,   -2.25,  0.1,  1e-7,    123456789.125,
      1e15, 1e16,   2.5e-05, 0.125, 1e300,  0.35, 2.675,   std::numeric_limits<double>::max(),
      1e99, 1e-300, 1.0 / 3, 1e5,   999999, 1e6,  9.5e-324};
  for (const double value : kNumbers) {
    EXPECT_EQ(general_text(value, 15), printed("%.*g", 15, value));
    EXPECT_EQ(general_text(value, 6), printed("%.*g", 6, value));
    EXPECT_EQ(fixed_text(value, 3), printed("%.*f", 3, value));
    EXPECT_EQ(fixed_text(value, 0), printed("%.*f", 0, value));
  }
  EXPECT_EQ(general_text(INFINITY, 15), "inf");
  EXPECT_EQ(fixed_text(-INFINITY, 3), "-inf");
}

TEST(NumberText, ShortestReadsBackAsTheSameNumber) {
  for (const double value : {0.1, 1.0 / 3, 1e-300, 123456.789, -5.0})
    EXPECT_EQ(read_number<double>(shortest_text(value)), value);
  EXPECT_EQ(shortest_text(0.1), "0.1");
  EXPECT_EQ(shortest_text(5), "5");
}

TEST(NumberText, TakesTheWholeTextOrNothing) {
  EXPECT_EQ(read_number<int>("12"), 12);
  EXPECT_EQ(read_number<int>("+12"), 12);
  EXPECT_EQ(read_number<double>("-1.5e3"), -1500);
  EXPECT_EQ(read_number<std::uint64_t>("18446744073709551615"), UINT64_MAX);
  for (const char* wrong : {"", "+", "+-1", "1 ", " 1", "1x", "1,5", "x"}) {
    EXPECT_EQ(read_number<double>(wrong), std::nullopt) << wrong;
    EXPECT_EQ(read_number<int>(wrong), std::nullopt) << wrong;
  }
  EXPECT_EQ(read_number<int>("99999999999"), std::nullopt);
  EXPECT_EQ(read_number<std::uint64_t>("-1"), std::nullopt);
}

}  // namespace
}  // namespace cxlab
