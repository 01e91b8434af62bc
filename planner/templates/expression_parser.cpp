#include <algorithm>

#include "planner/templates/library.h"
#include "planner/templates/parser_base.h"

namespace cxlab::planner::templates {
namespace {

/// Counts one level of nesting while it lives.
struct Level {
  explicit Level(int& depth) : depth(++depth) {}
  ~Level() { --depth; }
  int& depth;
};

}  // namespace

ExpressionPtr ExpressionParser::fail_at(int line, const std::string& message) {
  if (!error_) error_ = input_error(message, file_, line);
  position_ = tokens_.size() - 1;
  return nullptr;
}

void ExpressionParser::fail_unsupported(int line, const std::string& message) {
  if (error_) return;
  fail_at(line, message);
  error_->code = "unsupported";
}

std::string ExpressionParser::found() const {
  switch (now().kind) {
    case Token::Kind::kEnd: return "the end of the template";
    case Token::Kind::kText: return "text";
    case Token::Kind::kOutputBegin: return "'{{'";
    case Token::Kind::kOutputEnd: return "'}}'";
    case Token::Kind::kStatementBegin: return "'{%'";
    case Token::Kind::kStatementEnd: return "'%}'";
    case Token::Kind::kString: return "a string";
    case Token::Kind::kInteger:
    case Token::Kind::kFloat: return "the number " + now().number.str();
    default: return "'" + now().text + "'";
  }
}

ExpressionPtr ExpressionParser::make(Expression::Kind kind) const {
  auto made = std::make_unique<Expression>();
  made->kind = kind;
  made->line = now().line;
  return made;
}

bool ExpressionParser::take_operator(std::string_view text) {
  if (!is_operator(text)) return false;
  next();
  return true;
}

bool ExpressionParser::take_name(std::string_view text) {
  if (!is_name(text)) return false;
  next();
  return true;
}

bool ExpressionParser::expect_operator(std::string_view text) {
  if (take_operator(text)) return true;
  fail("found " + found() + ", expected '" + std::string(text) + "'");
  return false;
}

std::string ExpressionParser::expect_name(const char* what) {
  if (now().kind != Token::Kind::kName) {
    fail("found " + found() + ", expected " + what);
    return {};
  }
  std::string name = now().text;
  next();
  return name;
}

ExpressionPtr ExpressionParser::binary(Expression::Kind kind, std::string name, ExpressionPtr left, ExpressionPtr right,
                                       int line) const {
  auto made = make(kind);
  made->line = line;
  made->name = std::move(name);
  made->operands.push_back(std::move(left));
  made->operands.push_back(std::move(right));
  return made;
}

ExpressionPtr ExpressionParser::expression(bool with_condition) {
  Level level(depth_);
  if (depth_ > kDeepest) return fail("expressions are nested more than " + std::to_string(kDeepest) + " deep");
  auto value = disjunction();
  for (int length = 0; with_condition && !failed() && is_name("if") && short_enough(length); ++length) {
    auto made = make(Expression::Kind::kCondition);
    next();
    made->operands.push_back(std::move(value));
    made->operands.push_back(disjunction());
    made->operands.push_back(take_name("else") ? expression() : nullptr);
    value = std::move(made);
  }
  return failed() ? nullptr : std::move(value);
}

ExpressionPtr ExpressionParser::tuple(bool with_condition) {
  auto first = expression(with_condition);
  if (failed() || !is_operator(",")) return first;
  auto made = make(Expression::Kind::kTuple);
  made->operands.push_back(std::move(first));
  while (!failed() && take_operator(",")) {
    const bool ends = now().kind == Token::Kind::kOutputEnd || now().kind == Token::Kind::kStatementEnd ||
                      is_operator(")") || is_operator("=") || is_name("in");
    if (ends) break;
    made->operands.push_back(expression(with_condition));
  }
  return failed() ? nullptr : std::move(made);
}

ExpressionPtr ExpressionParser::target(bool attributes) {
  Level level(depth_);
  if (depth_ > kDeepest) return fail("names are nested more than " + std::to_string(kDeepest) + " deep");
  const auto one = [&]() -> ExpressionPtr {
    if (take_operator("(")) {
      auto inner = target(attributes);
      return expect_operator(")") ? std::move(inner) : nullptr;
    }
    auto made = make(Expression::Kind::kName);
    made->name = expect_name("a name to assign to");
    for (const char* word : {"true", "false", "none", "True", "False", "None"})
      if (made->name == word) return fail("found '" + made->name + "', which cannot be assigned to");
    if (attributes && take_operator(".")) {
      auto attribute = make(Expression::Kind::kAttribute);
      attribute->name = expect_name("an attribute");
      attribute->operands.push_back(std::move(made));
      return attribute;
    }
    return made;
  };
  auto first = one();
  if (failed() || !is_operator(",")) return first;
  auto made = make(Expression::Kind::kTuple);
  made->operands.push_back(std::move(first));
  while (!failed() && take_operator(",")) {
    if (is_operator("=") || is_name("in") || is_operator(")")) break;
    made->operands.push_back(one());
  }
  return failed() ? nullptr : std::move(made);
}

bool ExpressionParser::short_enough(int length) {
  if (length >= kLongest) fail("more than " + std::to_string(kLongest) + " operators in a row in one expression");
  return length < kLongest;
}

ExpressionPtr ExpressionParser::disjunction() {
  auto left = conjunction();
  for (int length = 0; !failed() && is_name("or") && short_enough(length); ++length) {
    const int line = now().line;
    next();
    left = binary(Expression::Kind::kOr, "or", std::move(left), conjunction(), line);
  }
  return left;
}

ExpressionPtr ExpressionParser::conjunction() {
  auto left = negation();
  for (int length = 0; !failed() && is_name("and") && short_enough(length); ++length) {
    const int line = now().line;
    next();
    left = binary(Expression::Kind::kAnd, "and", std::move(left), negation(), line);
  }
  return left;
}

ExpressionPtr ExpressionParser::negation() {
  if (!is_name("not")) return comparison();
  Level level(depth_);
  if (depth_ > kDeepest) return fail("expressions are nested more than " + std::to_string(kDeepest) + " deep");
  auto made = make(Expression::Kind::kNot);
  next();
  made->operands.push_back(negation());
  return made;
}

ExpressionPtr ExpressionParser::comparison() {
  auto left = sum();
  ExpressionPtr made;
  while (!failed()) {
    std::string name;
    if (now().kind == Token::Kind::kOperator) {
      for (const char* each : {"==", "!=", "<", "<=", ">", ">="})
        if (now().text == each) name = each;
    } else if (is_name("in")) {
      name = "in";
    } else if (is_name("not") && ahead().kind == Token::Kind::kName && ahead().text == "in") {
      name = "not in";
      next();
    }
    if (name.empty()) break;
    if (!made) {
      made = make(Expression::Kind::kCompare);
      made->operands.push_back(std::move(left));
    }
    next();
    made->names.push_back(name);
    made->operands.push_back(sum());
  }
  return made ? std::move(made) : std::move(left);
}

ExpressionPtr ExpressionParser::sum() {
  auto left = concatenation();
  for (int length = 0; !failed() && (is_operator("+") || is_operator("-")) && short_enough(length); ++length) {
    const Token token = now();
    next();
    left = binary(Expression::Kind::kBinary, token.text, std::move(left), concatenation(), token.line);
  }
  return left;
}

ExpressionPtr ExpressionParser::concatenation() {
  auto first = product();
  if (failed() || !is_operator("~")) return first;
  auto made = make(Expression::Kind::kConcat);
  made->operands.push_back(std::move(first));
  while (!failed() && take_operator("~")) made->operands.push_back(product());
  return made;
}

ExpressionPtr ExpressionParser::product() {
  auto left = power();
  for (int length = 0; !failed() && (is_operator("*") || is_operator("/") || is_operator("//") || is_operator("%")) &&
                       short_enough(length);
       ++length) {
    const Token token = now();
    next();
    left = binary(Expression::Kind::kBinary, token.text, std::move(left), power(), token.line);
  }
  return left;
}

ExpressionPtr ExpressionParser::power() {
  auto left = unary(true);
  for (int length = 0; !failed() && is_operator("**") && short_enough(length); ++length) {
    const int line = now().line;
    next();
    left = binary(Expression::Kind::kBinary, "**", std::move(left), unary(true), line);
  }
  return left;
}

ExpressionPtr ExpressionParser::unary(bool with_filters) {
  Level level(depth_);
  if (depth_ > kDeepest) return fail("expressions are nested more than " + std::to_string(kDeepest) + " deep");
  ExpressionPtr value;
  if (is_operator("-") || is_operator("+")) {
    value = make(is_operator("-") ? Expression::Kind::kNegate : Expression::Kind::kPlus);
    next();
    value->operands.push_back(unary(false));
  } else {
    value = primary();
  }
  if (!failed()) value = postfix(std::move(value));
  if (!failed() && with_filters) value = filters(std::move(value));
  return failed() ? nullptr : std::move(value);
}

ExpressionPtr ExpressionParser::primary() {
  auto made = make(Expression::Kind::kLiteral);
  switch (now().kind) {
    case Token::Kind::kName: {
      const std::string name = now().text;
      if (name == "true" || name == "True")
        made->value = true;
      else if (name == "false" || name == "False")
        made->value = false;
      else if (name == "none" || name == "None")
        made->value = Value::none();
      else {
        made->kind = Expression::Kind::kName;
        made->name = name;
      }
      next();
      return made;
    }
    case Token::Kind::kString: {
      std::string text;
      for (; now().kind == Token::Kind::kString; next()) text += now().text;  // neighbours are joined
      made->value = std::move(text);
      return made;
    }
    case Token::Kind::kInteger:
    case Token::Kind::kFloat:
      made->value = now().number;
      next();
      return made;
    default: break;
  }
  if (is_operator("[")) return list_literal();
  if (is_operator("{")) return dict_literal();
  if (!take_operator("(")) return fail("found " + found() + ", expected an expression");
  if (take_operator(")")) {
    made->kind = Expression::Kind::kTuple;
    return made;
  }
  auto inner = tuple();
  if (failed() || !expect_operator(")")) return nullptr;
  return inner;
}

ExpressionPtr ExpressionParser::list_literal() {
  auto made = make(Expression::Kind::kList);
  next();
  while (!failed() && !is_operator("]")) {
    made->operands.push_back(expression());
    if (!is_operator("]") && !expect_operator(",")) break;
  }
  next();
  return made;
}

ExpressionPtr ExpressionParser::dict_literal() {
  auto made = make(Expression::Kind::kDict);
  next();
  while (!failed() && !is_operator("}")) {
    made->operands.push_back(expression());
    if (failed() || !expect_operator(":")) break;
    made->operands.push_back(expression());
    if (!is_operator("}") && !expect_operator(",")) break;
  }
  next();
  return made;
}

ExpressionPtr ExpressionParser::subscript(ExpressionPtr operand) {
  auto made = make(Expression::Kind::kSubscript);
  next();
  made->operands.push_back(std::move(operand));
  ExpressionPtr index;
  if (!is_operator(":")) index = expression();
  if (!failed() && is_operator(":")) {
    auto slice = make(Expression::Kind::kSlice);
    slice->operands.push_back(std::move(index));
    for (int part = 1; part < 3; ++part) {
      ExpressionPtr bound;
      if (take_operator(":") && !is_operator("]") && !is_operator(":")) bound = expression();
      slice->operands.push_back(std::move(bound));
    }
    index = std::move(slice);
  }
  if (failed() || !expect_operator("]")) return nullptr;
  made->operands.push_back(std::move(index));
  return made;
}

ExpressionPtr ExpressionParser::postfix(ExpressionPtr operand) {
  for (int length = 0; !failed() && short_enough(length); ++length) {
    if (take_operator(".")) {
      if (now().kind == Token::Kind::kInteger) {  // a.0
        auto made = make(Expression::Kind::kSubscript);
        auto index = make(Expression::Kind::kLiteral);
        index->value = now().number;
        next();
        made->operands.push_back(std::move(operand));
        made->operands.push_back(std::move(index));
        operand = std::move(made);
        continue;
      }
      auto made = make(Expression::Kind::kAttribute);
      made->name = expect_name("an attribute");
      made->operands.push_back(std::move(operand));
      operand = std::move(made);
    } else if (is_operator("[")) {
      operand = subscript(std::move(operand));
    } else if (is_operator("(")) {
      operand = call(std::move(operand));
    } else {
      return operand;
    }
  }
  return nullptr;
}

ExpressionPtr ExpressionParser::call(ExpressionPtr operand) {
  auto made = make(Expression::Kind::kCall);
  made->operands.push_back(std::move(operand));
  return call_arguments(*made) ? std::move(made) : nullptr;
}

bool ExpressionParser::call_arguments(Expression& call) {
  if (!expect_operator("(")) return false;
  while (!failed() && !is_operator(")")) {
    if (take_operator("*")) {
      call.star = expression();
    } else if (take_operator("**")) {
      call.double_star = expression();
    } else if (now().kind == Token::Kind::kName && ahead().kind == Token::Kind::kOperator && ahead().text == "=") {
      std::string name = now().text;
      next();
      next();
      call.named_arguments.emplace_back(std::move(name), expression());
    } else {
      if (!call.named_arguments.empty() || call.double_star)
        fail("found an argument without a name behind one with a name");
      call.arguments.push_back(expression());
    }
    if (!is_operator(")") && !expect_operator(",")) break;
  }
  next();
  return !failed();
}

ExpressionPtr ExpressionParser::filter(ExpressionPtr operand) {
  auto made = make(Expression::Kind::kFilter);
  made->name = expect_name("a filter");
  if (failed()) return nullptr;
  if (!is_filter(made->name)) {
    if (is_known_filter(made->name)) {
      fail_unsupported(made->line, "found the filter '" + made->name + "': not supported");
      return nullptr;
    }
    return fail_at(made->line, "found '" + made->name + "', expected a filter" + filter_hint(made->name));
  }
  made->operands.push_back(std::move(operand));
  if (is_operator("(") && !call_arguments(*made)) return nullptr;
  return made;
}

ExpressionPtr ExpressionParser::filters(ExpressionPtr operand) {
  for (int length = 0; !failed() && short_enough(length); ++length) {
    if (take_operator("|")) {
      operand = filter(std::move(operand));
    } else if (is_name("is")) {
      operand = test(std::move(operand));
    } else if (is_operator("(")) {
      operand = call(std::move(operand));
    } else {
      return operand;
    }
  }
  return nullptr;
}

ExpressionPtr ExpressionParser::test(ExpressionPtr operand) {
  auto made = make(Expression::Kind::kTest);
  next();
  ExpressionPtr negated;
  if (is_name("not")) {
    negated = make(Expression::Kind::kNot);
    next();
  }
  made->name = expect_name("a test");
  if (failed()) return nullptr;
  if (!is_test(made->name))
    return fail_at(made->line, "found '" + made->name + "', expected a test" + test_hint(made->name));
  made->operands.push_back(std::move(operand));
  const bool word = now().kind == Token::Kind::kName && now().text != "else" && now().text != "or" &&
                    now().text != "and" && now().text != "if" && now().text != "is" && now().text != "in" &&
                    now().text != "not";
  const bool literal =
      now().kind == Token::Kind::kString || now().kind == Token::Kind::kInteger || now().kind == Token::Kind::kFloat;
  if (is_operator("(")) {
    if (!call_arguments(*made)) return nullptr;
  } else if (word || literal || is_operator("[") || is_operator("{")) {
    auto argument = primary();
    if (!failed()) argument = postfix(std::move(argument));
    made->arguments.push_back(std::move(argument));
  }
  if (!negated) return made;
  negated->operands.push_back(std::move(made));
  return negated;
}

}  // namespace cxlab::planner::templates
