#include "lab/export/story_tables.h"

#include <string_view>
#include <variant>

namespace cxlab::lab {

namespace {

/// Columns of the table of skills.
enum SkillColumn : std::size_t { kRobot, kSkill, kTarget, kBegin, kEnd, kState, kCode, kReason };

}  // namespace

StoryTables::StoryTables(const Stretch& stretch) : stretch_(stretch) {
  using Kind = TableColumn::Kind;
  skills_.columns = {{"robot"},
                     {"skill"},
                     {"target"},
                     {"begin_s", Kind::kReal},
                     {"end_s", Kind::kReal},
                     {"state"},
                     {"code", Kind::kWhole},
                     {"reason"}};
  points_.columns = {{"t_s", Kind::kReal},   {"team"}, {"kind"}, {"points", Kind::kWhole}, {"total", Kind::kWhole},
                     {"order", Kind::kWhole}};
}

Status StoryTables::hear(const JournalRecord& record) {
  if (record.kind == RecordKind::kSkill) hear_skill(record);
  const RecordValue& data = record.data;
  if (stretch_.has(record.t) && record.kind == RecordKind::kReferee && data.find("team") && data.find("total"))
    points_.rows.push_back({record.t, data.text("team"), data.text("kind"), data.integer("points"),
                            data.integer("total"),
                            data.find("order") ? TableCell(data.integer("order")) : TableCell()});
  return {};
}

void StoryTables::hear_skill(const JournalRecord& record) {
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

PlainTable StoryTables::skills() const {
  PlainTable out = skills_;
  std::erase_if(out.rows, [&](const auto& row) {
    const auto* end = std::get_if<double>(&row[kEnd].value);
    return end && *end < to_seconds(stretch_.from);
  });
  return out;
}

}  // namespace cxlab::lab
