#pragma once
// Text of a template to tokens.

#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "planner/templates/value.h"

namespace cxlab::planner::templates {

struct Token {
  enum class Kind {
    kText,         ///< text outside of tags
    kOutputBegin,  ///< {{
    kOutputEnd,
    kStatementBegin,  ///< {%
    kStatementEnd,
    kName,
    kString,
    kInteger,
    kFloat,
    kOperator,
    kEnd,
  };
  Kind kind = Kind::kEnd;
  int line = 0;
  std::string text;  ///< of text, names, operators; value of strings
  Value number;
};

Expected<std::vector<Token>> tokenize(std::string_view source, const std::string& file);

}  // namespace cxlab::planner::templates
