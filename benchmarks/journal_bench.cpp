// What a record costs: built, hashed, and exported.

#include <benchmark/benchmark.h>

#include <filesystem>

#include "cx/journal/journal.h"

namespace cxlab {
namespace {

/// One record of two fields with a cause; `exported` writes each as a line.
void write_records(benchmark::State& state, bool exported) {
  Journal journal;
  const auto path = std::filesystem::temp_directory_path() / "cxlab_bench_journal.jsonl";
  if (exported && !journal.export_to(path, JournalLevel::kFull)) return state.SkipWithError("no file");
  const StreamId stream = journal.open_stream("env/bench");
  RecordData data;
  RecordRef last;
  std::int64_t i = 0;
  for (auto _ : state) {
    data.begin().field("order", i++).field("state", "OPEN");
    last = journal.write(stream, SimTime{i}, RecordKind::kAssert, data, {&last, 1});
  }
  state.SetItemsProcessed(state.iterations());
  if (!journal.close()) state.SkipWithError("the disk is full");
  if (exported) std::filesystem::remove(path);
}

void hashed(benchmark::State& state) { write_records(state, false); }
void exported(benchmark::State& state) { write_records(state, true); }

BENCHMARK(hashed);
BENCHMARK(exported);

}  // namespace
}  // namespace cxlab
