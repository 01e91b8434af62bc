#pragma once
// The journal as topics of a bag: skills, events and points with cxlab's own messages, and lines of the log.

#include <string>
#include <vector>

#include "lab/export/ros_bag.h"
#include "lab/export/run_pass.h"

namespace cxlab::lab {

class StoryChannels final : public PassListener {
 public:
  /// Reads the lines of the run's logs.
  static Expected<StoryChannels> create(RosBag& bag, const Run& run, const Stretch& stretch);

  bool wants(RecordKind kind) const override;
  Status hear(const JournalRecord& record) override;
  /// Writes the lines of the log that are left.
  void finish() { put_lines_before(kNever); }

 private:
  struct Line {
    SimTime t{};
    std::string logger, text;
    std::uint8_t level = 0;
  };
  StoryChannels(RosBag& bag, const Stretch& stretch) : bag_(bag), stretch_(stretch) {}
  void put_lines_before(SimTime t);
  void put_skill(const JournalRecord& record);
  void put_event(const JournalRecord& record);
  void put_log(const Line& line, const RecordValue* place = nullptr);

  RosBag& bag_;
  Stretch stretch_;
  std::vector<Line> lines_;  ///< in order of time
  std::size_t next_line_ = 0;
};

/// "wait for robot2", "drive": of a record of a skill.
std::string phase_of(const RecordValue& skill);
/// What a robot does after a record of its skill: "transport drive C-RS1"; "idle" after the end.
std::string state_after(const RecordValue& skill);
/// What happened, in one word: the record's `event`, `fault`, `what`, `op` or `template`.
std::string event_of(const RecordValue& data);

}  // namespace cxlab::lab
