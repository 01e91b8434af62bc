#pragma once
// A message that the journal has recorded, with its type again.

#include "cx/base/expected.h"
#include "cx/bus/message.h"
#include "cx/journal/journal_record.h"

namespace cxlab::lab {

/// Fills a message from the map that `MessageView::record` has written. A field that the map lacks, a value that does
/// not fit and a key that is no field are errors.
Status set_message(const bus::MessageView& message, const RecordValue& recorded);

}  // namespace cxlab::lab
