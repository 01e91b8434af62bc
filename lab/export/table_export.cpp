#include "lab/export/table_export.h"

#include <algorithm>

#include "cx/journal/journal_reader.h"
#include "lab/export/ros_bag.h"

namespace cxlab::lab {

std::vector<TableColumn> record_columns() {
  using Kind = TableColumn::Kind;
  return {{"stream"}, {"n", Kind::kWhole}, {"t_ns", Kind::kWhole}, {"t_s", Kind::kReal}, {"kind"}, {"data"}, {"cause"}};
}

Expected<std::unique_ptr<TableExport>> TableExport::create(const Run& run, const Stretch& stretch, CreateTable create) {
  std::unique_ptr<TableExport> out(new TableExport(run, stretch, std::move(create)));
  auto records = out->create_("records", record_columns());
  if (!records) return records.error();
  out->records_ = *std::move(records);
  return out;
}

Status TableExport::hear(const JournalRecord& record) {
  if (Status s = story_.hear(record); !s) return s;
  if (!stretch_.has(record.t)) return {};
  std::string causes;
  for (const JournalRecord::Cause& cause : record.causes)
    causes += (causes.empty() ? "" : " ") + cause.stream + ':' + std::to_string(cause.n);
  const TableCell cells[]{record.stream,
                          static_cast<std::int64_t>(record.n),
                          record.t.count(),
                          record.t,
                          to_string(record.kind),
                          to_json(record.data),
                          causes};
  return records_->row(cells);
}

Status TableExport::put_table(const std::string& name, const PlainTable& table) {
  auto file = create_(name, table.columns);
  if (!file) return file.error();
  for (const auto& row : table.rows)
    if (Status s = (*file)->row(row); !s) return s;
  rows_[name] = (*file)->rows();
  return (*file)->close();
}

Status TableExport::put_world_tables() {
  const auto scenario = run_.scenario();
  if (!scenario) return scenario.error();
  const auto& questions = scenario->world.kind->questions;
  if (questions.empty()) return {};
  const bool whole = stretch_.to == SimTime::max();
  const auto recorded =
      run_.records_up_to(whole ? std::nullopt : std::optional(stretch_.to), {.kinds = kRecordsOfQuestions});
  if (!recorded) return recorded.error();
  const SimTime from = std::max(SimTime{}, stretch_.from);
  for (const WorldQuestion& question : questions) {
    const auto answer =
        question.ask({run_.folder, *scenario, recorded->records, from, recorded->t, recorded->ended, {}});
    if (!answer) return answer.error();
    for (const Table& table : answer->tables) {
      std::string name(question.name);
      if (table.key != question.name) name += '_' + table.key;
      if (Status s = put_table(topic_part(name), plain_table(table)); !s) return s;
    }
  }
  return {};
}

Status TableExport::close() {
  rows_["records"] = records_->rows();
  if (Status s = records_->close(); !s) return s;
  if (Status s = put_table("skills", story_.skills()); !s) return s;
  if (Status s = put_table("points", story_.points()); !s) return s;
  return put_world_tables();
}

}  // namespace cxlab::lab
