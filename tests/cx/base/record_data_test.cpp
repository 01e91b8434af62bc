// What RecordData writes, read back by another implementation of MessagePack.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "cx/base/record_sink.h"

namespace cxlab {
namespace {

using nlohmann::json;

json decoded(const RecordData& data) { return json::from_msgpack(data.bytes()); }

TEST(RecordData, FieldsOfEachKindComeBack) {
  RecordData data;
  data.begin().field("order", 3).field("state", "OPEN").field("late", true).field("early", false).field("x", -0.125);
  EXPECT_EQ(decoded(data), json({{"order", 3}, {"state", "OPEN"}, {"late", true}, {"early", false}, {"x", -0.125}}));
}

TEST(RecordData, LiteralsAreTexts) {
  RecordData data;
  data.begin().name("state").value("OPEN").name("list").open_list(2).value("a").value(true);
  EXPECT_EQ(decoded(data), json({{"state", "OPEN"}, {"list", {"a", true}}}));
}

TEST(RecordData, IntegersOfEachLengthComeBack) {
  constexpr std::int64_t kSigned[]{0,         1,
                                   127,       128,
                                   255,       256,
                                   -1,        -32,
                                   -33,       -128,
                                   INT32_MAX, std::int64_t{INT32_MAX} + 1,
                                   INT32_MIN, std::int64_t{INT32_MIN} - 1,
                                   INT64_MAX, INT64_MIN};
  for (const std::int64_t n : kSigned) {
    RecordData data;
    data.begin().field("n", n);
    EXPECT_EQ(decoded(data)["n"].get<std::int64_t>(), n);
  }
  constexpr std::uint64_t kUnsigned[]{0, 127, 128, INT64_MAX, std::uint64_t{INT64_MAX} + 1, UINT64_MAX};
  for (const std::uint64_t n : kUnsigned) {
    RecordData data;
    data.begin().field("n", n);
    EXPECT_EQ(decoded(data)["n"].get<std::uint64_t>(), n);
  }
}

TEST(RecordData, SmallIntegersTakeOneByteAndOthersFiveOrNine) {
  const auto bytes = [](std::int64_t n) {
    RecordData data;
    data.begin();
    const std::size_t before = data.bytes().size();
    data.value(n);
    return data.bytes().size() - before;
  };
  EXPECT_EQ(bytes(0), 1u);
  EXPECT_EQ(bytes(127), 1u);
  EXPECT_EQ(bytes(128), 5u);
  EXPECT_EQ(bytes(-1), 5u);
  EXPECT_EQ(bytes(INT32_MAX), 5u);
  EXPECT_EQ(bytes(INT32_MIN), 5u);
  EXPECT_EQ(bytes(std::int64_t{INT32_MAX} + 1), 9u);
  EXPECT_EQ(bytes(std::int64_t{INT32_MIN} - 1), 9u);
}

TEST(RecordData, RealsComeBackBitByBit) {
  for (const double x : {0.0, 1.0, 0.1, -1e308, 5e-324, std::numeric_limits<double>::infinity()}) {
    RecordData data;
    data.begin().field("x", x);
    EXPECT_EQ(decoded(data)["x"].get<double>(), x);
  }
  RecordData data;
  data.begin().field("x", -0.0);
  EXPECT_TRUE(std::signbit(decoded(data)["x"].get<double>()));
}

TEST(RecordData, TextsOfEachLengthComeBack) {
  for (const std::size_t length : {0u, 1u, 31u, 32u, 33u, 255u, 256u, 70'000u}) {
    const std::string text(length, 'x');
    RecordData data;
    data.begin().field("text", text).field("after", 1);
    EXPECT_EQ(decoded(data), json({{"text", text}, {"after", 1}}));
  }
  RecordData data;
  data.begin().name("text").value_between("\"", "grün", "\"");
  EXPECT_EQ(decoded(data)["text"], "\"grün\"");
}

TEST(RecordData, ListsAndMapsAreNested) {
  RecordData data;
  data.begin().name("list").open_list(3).value(std::int64_t{1}).nil().value(std::string_view("a"));
  data.name("map").open_map(2).text_key("x").value(0.5).text_key("y").open_list(0);
  constexpr std::array kReals{1.5, -2.0};
  data.field("reals", std::span<const double>(kReals));
  EXPECT_EQ(decoded(data),
            json({{"list", {1, nullptr, "a"}}, {"map", {{"x", 0.5}, {"y", json::array()}}}, {"reals", {1.5, -2.0}}}));
}

TEST(RecordData, MoreFieldsThanAByteCountsAreCounted) {
  RecordData data;
  data.begin();
  for (int i = 0; i < 300; ++i) data.field("field " + std::to_string(i), i);
  const json read = decoded(data);
  ASSERT_EQ(read.size(), 300u);
  EXPECT_EQ(read["field 299"], 299);
}

TEST(RecordData, BeginForgetsTheFormerRecord) {
  RecordData data;
  data.begin().field("a", 1).field("b", 2);
  data.begin().field("c", 3);
  EXPECT_EQ(decoded(data), json({{"c", 3}}));
}

TEST(RecordData, ARecordGoesOnFromAnOpening) {
  RecordData opening, data;
  opening.begin().field("rule", "go").field("n", 300);
  data.begin(opening).field("more", true);
  EXPECT_EQ(decoded(data), json({{"rule", "go"}, {"n", 300}, {"more", true}}));
  EXPECT_EQ(decoded(opening), json({{"rule", "go"}, {"n", 300}}));
}

TEST(RecordKind, HasItsWordInTheJournal) {
  const std::vector<std::string> words{"input", "assert",  "retract",  "modify",  "fire", "bus",
                                       "skill", "referee", "decision", "control", "error"};
  for (std::size_t i = 0; i < words.size(); ++i) EXPECT_EQ(to_string(static_cast<RecordKind>(i)), words[i]);
}

}  // namespace
}  // namespace cxlab
