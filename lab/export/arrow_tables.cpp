#include "lab/export/arrow_tables.h"

#include <string>
#include <utility>

#include "lab/export/table_export.h"

namespace cxlab::lab {

namespace {

constexpr std::size_t kBatchBytes = std::size_t{1} << 22;

/// "a:1","b:2" as "a:1 b:2".
std::string causes_text(std::string_view causes) {
  std::string out;
  for (const char c : causes)
    if (c != '"') out += c == ',' ? ' ' : c;
  return out;
}

std::string causes_text(const std::vector<JournalRecord::Cause>& causes) {
  std::string out;
  for (const JournalRecord::Cause& cause : causes)
    out += (out.empty() ? "" : " ") + cause.stream + ':' + std::to_string(cause.n);
  return out;
}

void put_record(std::vector<ArrowColumn>& columns, const JournalLine& line, const std::string& causes) {
  columns[0].put(line.stream);
  columns[1].put(static_cast<std::int64_t>(line.n));
  columns[2].put(static_cast<std::int64_t>(line.t.count()));
  columns[3].put(to_seconds(line.t));
  columns[4].put(std::string_view(to_string(line.kind)));
  columns[5].put(line.data);
  columns[6].put(std::string_view(causes));
}

Status put_records(JournalReader& journal, const RecordFilter& filter, std::vector<ArrowColumn>& columns) {
  while (columns[5].bytes() < kBatchBytes && journal.next_line(filter)) {
    if (const auto line = split_journal_line(journal.line())) {
      if (filter.takes(line->kind, line->stream, line->t)) put_record(columns, *line, causes_text(line->causes));
      continue;
    }
    const auto record = journal.record();
    if (!record) return record.error();
    if (!filter.takes(*record)) continue;
    const std::string data = to_json(record->data);
    put_record(columns, {record->stream, record->n, record->t, record->kind, data, {}}, causes_text(record->causes));
  }
  return {};
}

}  // namespace

ArrowTable arrow_table(std::shared_ptr<const PlainTable> table) {
  return {.columns = table->columns, .begin = [table]() -> Expected<NextBatch> {
            return NextBatch([table, row = std::size_t{0}](std::vector<ArrowColumn>& columns) mutable -> Status {
              for (std::size_t bytes = 0; row < table->rows.size() && bytes < kBatchBytes; ++row) {
                bytes = 0;
                for (std::size_t i = 0; i < columns.size(); ++i) {
                  columns[i].put(table->rows[row][i]);
                  bytes += columns[i].bytes();
                }
              }
              return {};
            });
          }};
}

ArrowTable arrow_records(std::shared_ptr<const Run> run, RecordFilter filter) {
  return {.columns = record_columns(), .begin = [run, filter]() -> Expected<NextBatch> {
            auto opened = run->journal();
            if (!opened) return opened.error();
            auto journal = std::make_shared<JournalReader>(*std::move(opened));
            return NextBatch([journal, filter](std::vector<ArrowColumn>& columns) {
              return put_records(*journal, filter, columns);
            });
          }};
}

}  // namespace cxlab::lab
