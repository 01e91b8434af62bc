#include "cx/base/expected.h"

#include <gtest/gtest.h>

#include <memory>

namespace cxlab {
namespace {

TEST(Errors, TextHasFileAndLineWhereThereAreSome) {
  EXPECT_EQ(input_error("found a").text(), "found a");
  EXPECT_EQ(input_error("found a", "f.yaml").text(), "f.yaml: found a");
  EXPECT_EQ(input_error("found a", "f.yaml", 7).text(), "f.yaml:7: found a");
  EXPECT_EQ(input_error("found a", "", 7).text(), "found a") << "a line of no file";
}

TEST(Errors, EachKindHasItsExitCode) {
  EXPECT_EQ(static_cast<int>(negative("").kind), 1);
  EXPECT_EQ(static_cast<int>(usage_error("").kind), 2);
  EXPECT_EQ(static_cast<int>(input_error("").kind), 3);
  EXPECT_EQ(static_cast<int>(run_error("").kind), 4);
  EXPECT_EQ(static_cast<int>(resource_error("").kind), 5);
  EXPECT_EQ(static_cast<int>(bug_error("").kind), 70);
}

TEST(Errors, AMachineWordIsAdded) {
  const Error error = run_error("too many firings", "a.clp", 3).with_code("rule_loop");
  EXPECT_EQ(error.code, "rule_loop");
  EXPECT_EQ(error.text(), "a.clp:3: too many firings");
}

TEST(Expected, HoldsAValueOrAnError) {
  Expected<std::string> value(std::string("abc"));
  EXPECT_TRUE(value);
  EXPECT_TRUE(value.ok());
  EXPECT_EQ(value->size(), 3u);
  EXPECT_EQ(*std::move(value), "abc");
  const Expected<std::string> error(input_error("no"));
  EXPECT_FALSE(error);
  EXPECT_FALSE(error.ok());
  EXPECT_EQ(error.error().message, "no");
}

TEST(Expected, MovesWhatCannotBeCopied) {
  Expected<std::unique_ptr<int>> value(std::make_unique<int>(3));
  const std::unique_ptr<int> taken = *std::move(value);
  EXPECT_EQ(*taken, 3);
}

TEST(Status, IsSuccessUntilItHasAnError) {
  EXPECT_TRUE(Status{});
  EXPECT_TRUE(Status{}.ok());
  const Status failed = run_error("x");
  EXPECT_FALSE(failed);
  EXPECT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "x");
}

TEST(NearestWord, FindsOneSlip) {
  const std::vector<std::string> words{"run", "env", "test", "bench", "replay"};
  EXPECT_EQ(nearest_word("tset", words), "test") << "two letters swapped";
  EXPECT_EQ(nearest_word("evn", words), "env") << "a swap is one slip, 'run' is two away";
  EXPECT_EQ(nearest_word("benhc", words), "bench");
  EXPECT_EQ(nearest_word("reply", words), "replay") << "a letter left out";
  EXPECT_EQ(nearest_word("sed", {"set", "seed"}), "seed") << "a letter left out is likelier than a wrong one";
  EXPECT_EQ(nearest_word("runn", words), "run") << "a letter too many";
  EXPECT_EQ(nearest_word("rup", {"rip", "run"}), "rip") << "of two as near, the first";
}

TEST(NearestWord, FindsWordsInAnotherOrder) {
  EXPECT_EQ(nearest_word("begin-order", {"order-late", "order-begin"}), "order-begin");
  EXPECT_EQ(nearest_word("begin_order", {"order-begin"}), "order-begin");
  EXPECT_EQ(nearest_word("state-of-machine-lost", {"lost-machine-of-state"}), "lost-machine-of-state");
  const std::string longest(200, 'x');
  EXPECT_EQ(nearest_word(longest, {longest.substr(1)}), longest.substr(1));
  EXPECT_EQ(nearest_word(longest + "x", {longest}), "") << "too long to compare";
  EXPECT_EQ(nearest_word("begin-odrer", {"order-late", "order-begin"}), "order-begin") << "and a slip";
  EXPECT_EQ(nearest_word("begin-order", {"order-begin", "begin-orders"}), "begin-orders") << "a letter left out";
  EXPECT_EQ(nearest_word("begin-order", {"order-end"}), "") << "only some of the words";
}

TEST(NearestWord, IsEmptyWhereNothingIsNear) {
  EXPECT_EQ(nearest_word("snapshot", {"run", "env"}), "");
  EXPECT_EQ(nearest_word("abc", {}), "");
  EXPECT_EQ(nearest_word("abcde", {"abcxy"}), "abcxy") << "two slips count as near";
  EXPECT_EQ(nearest_word("fish", {"bash", "zsh"}), "") << "not where half of the letters are others";
  EXPECT_EQ(nearest_word("abcd", {"axyz"}), "");
  EXPECT_EQ(nearest_word("delivery_gate", {"delivery_gxyzz"}), "delivery_gxyzz") << "in long words one letter in three";
}

TEST(DidYouMean, IsTheEndOfAMessage) {
  EXPECT_EQ(did_you_mean("tset", {"test"}), ", did you mean 'test'?");
  EXPECT_EQ(did_you_mean("tset", {"test"}, "; "), "; did you mean 'test'?");
  EXPECT_EQ(did_you_mean("tset", {"snapshot"}), "");
  EXPECT_EQ(some_of_and_nearest("tset", {"run", "test", "view"}), "run, test, view; did you mean 'test'?");
  EXPECT_EQ(some_of_and_nearest("tset", {"run", "view", "test"}, 1), "run and 2 more; did you mean 'test'?");
  EXPECT_EQ(some_of_and_nearest("bench", {"run", "test"}), "run, test");
}

TEST(Messages, SayWhatWasFoundAndWhatWasExpected) {
  EXPECT_EQ(found_expected("3 values", "2"), "found 3 values, expected 2");
  EXPECT_EQ(found_text("tset", "a tier"), "found 'tset', expected a tier");
  EXPECT_EQ(found_text("", "a tier"), "found '', expected a tier");
}

TEST(SomeOf, NamesTheFirstAndCountsTheRest) {
  EXPECT_EQ(some_of({}, 2), "");
  EXPECT_EQ(some_of({"a", "b"}, 2), "a, b");
  EXPECT_EQ(some_of({"a", "b", "c", "d", "e"}, 2), "a, b and 3 more");
}

}  // namespace
}  // namespace cxlab
