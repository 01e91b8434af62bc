#include "planner/pddl/model.h"

namespace cxlab::planner {

bool fits(const Domain& domain, const Object& object, const std::vector<TypeId>& types) {
  for (const TypeId own : object.types)
    for (const TypeId wanted : types)
      if (domain.is_a(own, wanted)) return true;
  return false;
}

std::vector<ObjectId> objects_of(const Domain& domain, const Problem& problem, const std::vector<TypeId>& types) {
  std::vector<ObjectId> found;
  for (std::size_t i = 0; i < problem.objects.size(); ++i)
    if (fits(domain, problem.objects[i], types)) found.push_back(static_cast<ObjectId>(i));
  return found;
}

int find(const NameTable& table, std::string_view name) {
  const auto entry = table.find(std::string(name));
  return entry == table.end() ? -1 : entry->second;
}

}  // namespace cxlab::planner
