#include "planner/ground/formula.h"

#include <algorithm>
#include <iterator>

namespace cxlab::planner {

Formula join(Formula::Kind kind, std::vector<Formula> parts) {
  const Formula::Kind absorbing = kind == Formula::Kind::kAnd ? Formula::Kind::kFalse : Formula::Kind::kTrue;
  const Formula::Kind neutral = kind == Formula::Kind::kAnd ? Formula::Kind::kTrue : Formula::Kind::kFalse;
  Formula joined{kind, -1, {}};
  for (Formula& part : parts) {
    if (part.kind == absorbing) return {absorbing, -1, {}};
    if (part.kind == neutral) continue;
    if (part.kind == kind)
      std::ranges::move(part.parts, std::back_inserter(joined.parts));
    else
      joined.parts.push_back(std::move(part));
  }
  if (joined.parts.empty()) return {neutral, -1, {}};
  if (joined.parts.size() == 1) return Formula(std::move(joined.parts[0]));
  return joined;
}

std::vector<Formula> alternatives(const Formula& from, std::size_t most) {
  if (from.kind == Formula::Kind::kFalse) return {};
  std::vector<std::vector<Formula>> found = {{}};
  const std::vector<Formula> single = {from};
  const std::vector<Formula> none;
  const std::vector<Formula>& parts = from.kind == Formula::Kind::kAnd    ? from.parts
                                      : from.kind == Formula::Kind::kTrue ? none
                                                                          : single;
  std::size_t count = 1;
  for (const Formula& part : parts)
    if (part.kind == Formula::Kind::kOr) count *= std::min(part.parts.size(), most + 1);
  const bool split = count <= most;
  for (const Formula& part : parts) {
    if (part.kind != Formula::Kind::kOr || !split) {
      for (auto& one : found) one.push_back(part);
      continue;
    }
    std::vector<std::vector<Formula>> more;
    for (const auto& one : found)
      for (const Formula& choice : part.parts) {
        more.push_back(one);
        more.back().push_back(choice);
      }
    found = std::move(more);
  }
  std::vector<Formula> joined;
  for (auto& one : found) joined.push_back(join(Formula::Kind::kAnd, std::move(one)));
  return joined;
}

}  // namespace cxlab::planner
