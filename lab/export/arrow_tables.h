#pragma once
// The tables of a run for programs in this process: read as Arrow streams, any number of times.

#include <functional>
#include <memory>
#include <vector>

#include "cx/base/expected.h"
#include "cx/journal/journal_reader.h"
#include "lab/export/arrow_stream.h"
#include "lab/run.h"

namespace cxlab::lab {

struct ArrowTable {
  std::vector<TableColumn> columns;
  /// Begins at the first row.
  std::function<Expected<NextBatch>()> begin;
};

ArrowTable arrow_table(std::shared_ptr<const PlainTable> table);
/// The records of a run (`record_columns`): read while the stream is read, some MB at a time, and not decoded, so that
/// `data` has the bytes of the journal. An error of the stream names the damaged line.
ArrowTable arrow_records(std::shared_ptr<const Run> run, RecordFilter filter);

}  // namespace cxlab::lab
