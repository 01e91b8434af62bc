#pragma once
// Tokens to expressions; the part that statements build upon.

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "planner/templates/lexer.h"
#include "planner/templates/tree.h"

namespace cxlab::planner::templates {

/// Recursive descent with the precedences of Jinja. After an error `failed()` is true, tokens end, and results are
/// null.
class ExpressionParser {
 public:
  ExpressionParser(std::vector<Token> tokens, const std::string& file) : tokens_(std::move(tokens)), file_(file) {}

  bool failed() const { return error_.has_value(); }
  const Error& error() const { return *error_; }

 protected:
  ExpressionPtr expression(bool with_condition = true);
  /// `a, b`: a tuple if there is a comma.
  ExpressionPtr tuple(bool with_condition = true);
  /// A name, or names in a tuple; `ns.x` where attributes are allowed.
  ExpressionPtr target(bool attributes);
  /// `|a|b(1)` behind what is given; null stands for the body of a block.
  ExpressionPtr filters(ExpressionPtr operand);
  /// A filter name and its arguments, without the bar.
  ExpressionPtr filter(ExpressionPtr operand);
  ExpressionPtr call(ExpressionPtr operand);
  bool call_arguments(Expression& call);

  const Token& now() const { return tokens_[position_]; }
  const Token& ahead() const { return tokens_[std::min(position_ + 1, tokens_.size() - 1)]; }
  void next() {
    if (position_ + 1 < tokens_.size()) ++position_;
  }
  bool is_operator(std::string_view text) const { return now().kind == Token::Kind::kOperator && now().text == text; }
  bool is_name(std::string_view text) const { return now().kind == Token::Kind::kName && now().text == text; }
  bool take_operator(std::string_view text);
  bool take_name(std::string_view text);
  bool expect_operator(std::string_view text);
  std::string expect_name(const char* what);
  ExpressionPtr fail(const std::string& message) { return fail_at(now().line, message); }
  ExpressionPtr fail_at(int line, const std::string& message);
  void fail_unsupported(int line, const std::string& message);
  std::string found() const;
  ExpressionPtr make(Expression::Kind kind) const;

  /// Nesting of expressions and statements.
  static constexpr int kDeepest = 100;
  int depth_ = 0;

 private:
  /// Operators in a row, which nest in the tree.
  static constexpr int kLongest = 200;
  bool short_enough(int length);
  ExpressionPtr disjunction();
  ExpressionPtr conjunction();
  ExpressionPtr negation();
  ExpressionPtr comparison();
  ExpressionPtr sum();
  ExpressionPtr concatenation();
  ExpressionPtr product();
  ExpressionPtr power();
  ExpressionPtr unary(bool with_filters);
  ExpressionPtr primary();
  ExpressionPtr postfix(ExpressionPtr operand);
  ExpressionPtr subscript(ExpressionPtr operand);
  ExpressionPtr test(ExpressionPtr operand);
  ExpressionPtr list_literal();
  ExpressionPtr dict_literal();
  ExpressionPtr binary(Expression::Kind kind, std::string name, ExpressionPtr left, ExpressionPtr right,
                       int line) const;

  std::vector<Token> tokens_;
  const std::string& file_;
  std::size_t position_ = 0;
  std::optional<Error> error_;
};

}  // namespace cxlab::planner::templates
