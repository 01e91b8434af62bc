#pragma once
// Why facts are there, as the records say.

#include <string>
#include <vector>

#include "tests/support/records.h"

namespace cxlab {

/// The data of the records that caused facts of this template.
inline std::vector<std::string> causes_of(const KeptRecords& records, const std::string& name) {
  std::vector<std::string> found;
  for (const KeptRecords::Record& record : records.of(RecordKind::kAssert)) {
    if (record.data.find(name) == std::string::npos) continue;
    for (const RecordRef& cause : record.causes) {
      const KeptRecords::Record by = records.of(cause.stream).at(cause.n);
      found.push_back(std::string(to_string(by.kind)) + ' ' + by.data);
    }
  }
  return found;
}

}  // namespace cxlab
