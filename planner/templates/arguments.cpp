#include <algorithm>
#include <cmath>

#include "planner/templates/interpreter.h"
#include "planner/templates/library.h"

namespace cxlab::planner::templates {

Arguments::Arguments(Interpreter& interpreter, std::string_view what, const Call& call, std::string_view names)
    : interpreter_(interpreter) {
  std::vector<std::string_view> parameters;
  while (!names.empty()) {
    const std::size_t end = std::min(names.find(' '), names.size());
    parameters.push_back(names.substr(0, end));
    names.remove_prefix(std::min(end + 1, names.size()));
  }
  values_.resize(parameters.size(), nullptr);
  if (call.positional.size() > parameters.size())
    interpreter.fail("found " + std::to_string(call.positional.size()) + " arguments of " + std::string(what) +
                     ", expected at most " + std::to_string(parameters.size()));
  for (std::size_t i = 0; i < std::min(parameters.size(), call.positional.size()); ++i)
    values_[i] = &call.positional[i];
  for (const auto& [name, value] : call.named) {
    const auto found = std::find(parameters.begin(), parameters.end(), name);
    if (found == parameters.end()) {
      interpreter.fail("found the argument '" + name + "' of " + std::string(what) + ", which it does not have");
    } else {
      values_[static_cast<std::size_t>(found - parameters.begin())] = &value;
    }
  }
}

std::int64_t Arguments::integer(std::size_t index, std::int64_t otherwise) {
  if (!has(index)) return otherwise;
  if (values_[index]->is_number() && std::abs(values_[index]->as_float()) < 0x1p63) return values_[index]->as_int();
  interpreter_.fail("found " + values_[index]->repr() + ", expected a whole number");
  return otherwise;
}

}  // namespace cxlab::planner::templates
