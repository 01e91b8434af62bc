#include "lab/export/table_export.h"

#include <algorithm>

#include "cx/journal/journal_reader.h"
#include "lab/export/ros_bag.h"

namespace cxlab::lab {

namespace {

using Kind = TableColumn::Kind;

/// Columns of the table of skills.
enum SkillColumn : std::size_t { kRobot, kSkill, kTarget, kBegin, kEnd, kState, kCode, kReason };

}  // namespace

Expected<std::unique_ptr<TableExport>> TableExport::create(const Run& run, const Stretch& stretch, CreateTable create) {
  std::unique_ptr<TableExport> out(new TableExport(run, stretch, std::move(create)));
  auto records = out->create_(
      "records",
      {{"stream"}, {"n", Kind::kWhole}, {"t_ns", Kind::kWhole}, {"t_s", Kind::kReal}, {"kind"}, {"data"}, {"cause"}});
  if (!records) return records.error();
  out->records_ = *std::move(records);
  out->skills_.columns = {{"robot"},
                          {"skill"},
                          {"target"},
                          {"begin_s", Kind::kReal},
                          {"end_s", Kind::kReal},
                          {"state"},
                          {"code", Kind::kWhole},
                          {"reason"}};
  out->points_.columns = {{"t_s", Kind::kReal},   {"team"}, {"kind"}, {"points", Kind::kWhole}, {"total", Kind::kWhole},
                          {"order", Kind::kWhole}};
  return out;
}

Status TableExport::hear(const JournalRecord& record) {
  if (record.kind == RecordKind::kSkill) hear_skill(record);
  if (!stretch_.has(record.t)) return {};
  const RecordValue& data = record.data;
  if (record.kind == RecordKind::kReferee && data.find("team") && data.find("total"))
    points_.rows.push_back({record.t, data.text("team"), data.text("kind"), data.integer("points"),
                            data.integer("total"),
                            data.find("order") ? TableCell(data.integer("order")) : TableCell()});
  std::string causes;
  for (const JournalRecord::Cause& cause : record.causes)
    causes += (causes.empty() ? "" : " ") + cause.stream + ':' + std::to_string(cause.n);
  const TableCell cells[]{record.stream,
                          static_cast<std::int64_t>(record.n),
                          record.t.count(),
                          record.t,
                          to_string(record.kind),
                          to_json(data),
                          causes};
  return records_->row(cells);
}

void TableExport::hear_skill(const JournalRecord& record) {
  const RecordValue& data = record.data;
  const std::string_view event = data.text("event");
  if (event == "start" || event == "refused") {
    if (event == "start") open_[record.stream] = skills_.rows.size();
    const bool refused = event == "refused";
    skills_.rows.push_back({data.text("robot"), data.text("skill"), data.text("target"), record.t,
                            refused ? TableCell(record.t) : TableCell(), refused ? "refused" : "runs", TableCell(),
                            refused ? TableCell(data.text("reason")) : TableCell()});
  } else if (event == "end" && open_.contains(record.stream)) {
    auto& row = skills_.rows[open_[record.stream]];
    row[kEnd] = record.t;
    row[kCode] = data.integer("code");
    row[kState] = data.flag("cancelled") ? "cancelled" : data.integer("code") == 0 ? "succeeded" : "failed";
    row[kReason] = data.text("error").empty() ? TableCell() : TableCell(data.text("error"));
    open_.erase(record.stream);
  }
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
  // A skill belongs to the stretch if it is not over before it.
  std::erase_if(skills_.rows, [&](const auto& row) {
    const auto* end = std::get_if<double>(&row[kEnd].value);
    return end && *end < to_seconds(stretch_.from);
  });
  if (Status s = put_table("skills", skills_); !s) return s;
  if (Status s = put_table("points", points_); !s) return s;
  return put_world_tables();
}

}  // namespace cxlab::lab
