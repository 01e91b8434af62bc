#include "lab/story_filter.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>
#include <utility>

namespace cxlab::lab {

namespace {

using Test = std::function<bool(const std::string& lower)>;

std::string in_lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

class Parser {
 public:
  explicit Parser(const std::string& text) : text_(text) { next(); }

  Expected<Test> parse() {
    auto all = alternatives();
    if (!all) return all;
    if (kind_ == Kind::kWord) return wrong("`and` or `or`; words that belong together stand in quotes");
    if (kind_ != Kind::kEnd) return wrong("`and`, `or` or the end");
    return all;
  }

 private:
  enum class Kind { kWord, kAnd, kOr, kNot, kOpen, kClose, kEnd, kUnclosed };

  void next() {
    at_ = std::min(text_.find_first_not_of(" \t\n\r", end_), text_.size());
    end_ = at_;
    kind_ = Kind::kEnd;
    if (at_ == text_.size()) return;
    const char first = text_[at_];
    if (first == '(' || first == ')') {
      kind_ = first == '(' ? Kind::kOpen : Kind::kClose;
      end_ = at_ + 1;
    } else if (first == '"' || first == '\'') {
      const std::size_t close = text_.find(first, at_ + 1);
      kind_ = close == std::string::npos ? Kind::kUnclosed : Kind::kWord;
      end_ = close == std::string::npos ? text_.size() : close + 1;
      word_ = text_.substr(at_ + 1, end_ - at_ - 2);
    } else {
      end_ = std::min(text_.find_first_of(" \t\n\r()", at_), text_.size());
      word_ = text_.substr(at_, end_ - at_);
      kind_ = word_ == "and" ? Kind::kAnd : word_ == "or" ? Kind::kOr : word_ == "not" ? Kind::kNot : Kind::kWord;
    }
  }

  Error wrong(const std::string& expected) const {
    const std::string found = kind_ == Kind::kEnd        ? "the end"
                              : kind_ == Kind::kUnclosed ? "a quote without its end"
                                                         : text_.substr(at_, end_ - at_);
    return usage_error("-k '" + text_ +
                       "': " + found_expected(found + " at column " + std::to_string(at_ + 1), expected));
  }

  /// Parts with this word between them.
  template <class Part, class Combine>
  Expected<Test> joined(Kind word, Part part, Combine combine) {
    Expected<Test> all = part();
    while (all && kind_ == word) {
      next();
      auto more = part();
      if (!more) return more;
      all = combine(*std::move(all), *std::move(more));
    }
    return all;
  }
  Expected<Test> alternatives() {
    return joined(
        Kind::kOr, [this] { return together(); },
        [](Test a, Test b) -> Test {
          return [a = std::move(a), b = std::move(b)](const std::string& text) { return a(text) || b(text); };
        });
  }
  Expected<Test> together() {
    return joined(
        Kind::kAnd, [this] { return single(); },
        [](Test a, Test b) -> Test {
          return [a = std::move(a), b = std::move(b)](const std::string& text) { return a(text) && b(text); };
        });
  }
  Expected<Test> single() {
    constexpr int kDeepest = 200;
    if (depth_ >= kDeepest) return usage_error("-k: found more than 200 parentheses and `not` in each other");
    if (kind_ == Kind::kNot) {
      next();
      ++depth_;
      auto inner = single();
      --depth_;
      if (!inner) return inner;
      return Test([inner = *std::move(inner)](const std::string& text) { return !inner(text); });
    }
    if (kind_ == Kind::kOpen) {
      next();
      ++depth_;
      auto inner = alternatives();
      --depth_;
      if (!inner) return inner;
      if (kind_ == Kind::kWord) return wrong("`and` or `or`; words that belong together stand in quotes");
      if (kind_ != Kind::kClose) return wrong("`and`, `or` or `)`");
      next();
      return inner;
    }
    if (kind_ != Kind::kWord || word_.empty()) return wrong("a word, `not` or `(`");
    const std::string word = in_lower_case(word_);
    next();
    return Test([word](const std::string& text) { return text.find(word) != std::string::npos; });
  }

  const std::string& text_;
  std::size_t at_ = 0, end_ = 0;  // of the token
  Kind kind_ = Kind::kEnd;
  std::string word_;
  int depth_ = 0;
};

}  // namespace

Expected<StoryFilter> StoryFilter::parse(const std::string& expression) {
  auto test = Parser(expression).parse();
  if (!test) return test.error();
  StoryFilter filter;
  filter.holds_ = *std::move(test);
  return filter;
}

bool StoryFilter::takes(const std::string& text) const { return !holds_ || holds_(in_lower_case(text)); }

}  // namespace cxlab::lab
