#pragma once
// Facts out of records of the journal.

#include <cstdint>
#include <vector>

#include "cx/engine/engine.h"
#include "cx/journal/journal_record.h"

namespace cxlab::explain {

/// Sets what an assert, modify or decision record says: number, template, and the slots that it names.
void apply(const JournalRecord& record, FactCopy& fact);

/// The numbers of the facts that a firing matched, by condition; -1 where a condition matched none.
std::vector<std::int64_t> facts_of_firing(const RecordValue& data);

}  // namespace cxlab::explain
