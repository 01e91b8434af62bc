#pragma once

#include <string>

namespace cxlab {

/// Where a construct was defined. `line` is that of its opening parenthesis; forms built without a file have none.
struct ConstructInfo {
  std::string kind;  ///< "defrule", "deftemplate", ...
  std::string module;
  std::string name;
  std::string file;
  int line = 0;
  std::string text;  ///< as written
};

}  // namespace cxlab
