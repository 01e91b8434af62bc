#pragma once
// A template after parsing.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "planner/templates/value.h"

namespace cxlab::planner::templates {

struct Expression;
using ExpressionPtr = std::unique_ptr<Expression>;

struct Expression {
  enum class Kind {
    kLiteral,  ///< value
    kName,     ///< name
    kList,     ///< operands
    kTuple,    ///< operands
    kDict,     ///< operands: key, value, key, value ...
    kNegate,
    kPlus,
    kNot,
    kAnd,
    kOr,
    kBinary,     ///< name is the operator: + - * / // % **
    kConcat,     ///< operands joined as text
    kCompare,    ///< operands[0] names[0] operands[1] names[1] operands[2] ...
    kCondition,  ///< operands: then, condition, else (may be null)
    kAttribute,  ///< operands[0] . name
    kSubscript,  ///< operands[0] [ operands[1] ]
    kSlice,      ///< operands: start, stop, step; each may be null
    kCall,       ///< operands[0] ( arguments )
    kFilter,     ///< operands[0] (null inside {% filter %}) | name ( arguments )
    kTest,       ///< operands[0] is name ( arguments )
  };
  Kind kind = Kind::kLiteral;
  int line = 0;
  std::string name;
  Value value;
  std::vector<ExpressionPtr> operands;
  std::vector<std::string> names;
  std::vector<ExpressionPtr> arguments;
  std::vector<std::pair<std::string, ExpressionPtr>> named_arguments;
  ExpressionPtr star, double_star;  ///< *args, **kwargs
};

struct Node;
using Body = std::vector<std::unique_ptr<Node>>;

struct Node {
  enum class Kind {
    kText,         ///< text
    kOutput,       ///< expression
    kFor,          ///< target, expression, filter, body, otherwise; recursive
    kIf,           ///< expression, body, otherwise
    kSet,          ///< target, expression
    kSetBlock,     ///< target, body, filter chain in expression (may be null)
    kBlock,        ///< text is its name; body
    kExtends,      ///< expression
    kInclude,      ///< expression
    kImport,       ///< expression as text
    kFromImport,   ///< expression import names
    kMacro,        ///< text, parameters, body
    kCallBlock,    ///< expression is a call; parameters, body
    kFilterBlock,  ///< expression is a filter chain; body
    kWith,         ///< parameters, body
    kDo,           ///< expression
  };
  Kind kind = Kind::kText;
  int line = 0;
  std::string text;
  ExpressionPtr target;
  ExpressionPtr expression;
  ExpressionPtr filter;
  std::vector<std::pair<std::string, ExpressionPtr>> parameters;  ///< with their defaults, which may be null
  std::vector<std::pair<std::string, std::string>> names;         ///< of from ... import: name, alias
  Body body;
  Body otherwise;
  bool recursive = false;       ///< for
  bool scoped = false;          ///< block
  bool required = false;        ///< block
  bool ignore_missing = false;  ///< include
  bool with_context = true;     ///< include, import

  // By resolve_scopes (scopes.h).
  std::vector<std::string> hidden;  ///< names that the body assigns to before it reads them: undefined until then
  std::vector<std::string> otherwise_hidden;  ///< for: the same of its else
  bool top_level = false;     ///< block: in no loop, macro or other block; not shown where it stands in a child
  bool captured = false;      ///< text, output: inside a macro, block or set; shown in a child, too
  bool uses_loop = false;     ///< for
  bool uses_super = false;    ///< block
  bool uses_caller = false;   ///< macro, call
  bool uses_kwargs = false;   ///< macro, call
  bool uses_varargs = false;  ///< macro, call
};

struct Template {
  std::string name;
  Body body;
  std::map<std::string, const Node*> blocks;  ///< all, also those in others

  // By resolve_scopes (scopes.h), of the top level.
  std::vector<std::string> hidden;  ///< names that it assigns to before it reads them
  std::vector<std::string> reads;   ///< names that it reads first
};

}  // namespace cxlab::planner::templates
