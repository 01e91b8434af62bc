#pragma once
// Facts out of records of the journal.

#include "cx/engine/engine.h"
#include "cx/journal/journal_record.h"

namespace cxlab::explain {

/// Sets what an assert, modify or decision record says: number, template, and the slots that it names.
void apply(const JournalRecord& record, FactCopy& fact);

}  // namespace cxlab::explain
