// Lines of journal.jsonl.

#include "cx/journal/journal_reader.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_journal {

FUZZ_TARGET(journal) {
  using namespace cxlab;
  const auto record = parse_journal_line(fuzz::text_of(data, size));
  if (record)
    fuzz::promise(!record->stream.empty(), "a record has a stream");
  else
    fuzz::promise(!record.error().message.empty(), "an error says what it is");
  return 0;
}

}  // namespace fuzz_journal
