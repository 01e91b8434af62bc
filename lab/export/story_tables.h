#pragma once
// What robots did, and what was given for it, as tables: a row a skill, and a row for each time that points are given.

#include <cstddef>
#include <map>
#include <string>

#include "lab/export/run_pass.h"
#include "lab/export/table_file.h"

namespace cxlab::lab {

class StoryTables final : public PassListener {
 public:
  explicit StoryTables(const Stretch& stretch);

  bool wants(RecordKind kind) const override { return kind == RecordKind::kSkill || kind == RecordKind::kReferee; }
  Status hear(const JournalRecord& record) override;
  /// The skills that are not over before the stretch; one that has not ended `runs`.
  PlainTable skills() const;
  const PlainTable& points() const { return points_; }

 private:
  void hear_skill(const JournalRecord& record);

  Stretch stretch_;
  PlainTable skills_, points_;
  std::map<std::string, std::size_t> open_;  ///< row of the skill that each stream plays
};

}  // namespace cxlab::lab
