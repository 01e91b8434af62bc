#pragma once
// A run as a trace: who did what along simulated time.

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "cx/base/append_file.h"
#include "lab/export/run_pass.h"
#include "lab/trace_writer.h"

namespace cxlab::lab {

/// Its processes are: skills (a thread for each robot), orders, referee, points, and each environment (a thread for
/// each rule). Each kind of entities with a state is a process too (a thread for each entity).
class TraceExport final : public PassListener {
 public:
  static Expected<std::unique_ptr<TraceExport>> create(const Run& run, const Stretch& stretch,
                                                       const std::filesystem::path& file);
  bool wants(RecordKind kind) const override;
  Status hear(const JournalRecord& record) override;
  bool wants_scenes() const override { return true; }
  Status see(const Scene& scene) override;
  /// Ends what has not ended, and the file.
  Status close();
  std::uint64_t events() const { return trace_.events(); }

 private:
  struct Open {
    std::string name;
    SimTime begin{};
    Json args = Json::object();
  };
  TraceExport(const Run& run, const Stretch& stretch, AppendFile file);
  void hear_skill(const JournalRecord& record);
  void hear_referee(const JournalRecord& record);
  /// The window in which an order is wanted, also of one that is published before the stretch.
  void put_window(const JournalRecord& record);
  /// Writes what has been so since `open.begin`, as far as it lies in the stretch.
  void put_span(const std::string& process, const std::string& thread, const Open& open, const std::string& category,
                SimTime end);
  void end_phase(const std::string& stream, const std::string& robot, SimTime t);
  Status flush();
  /// A run that was killed does not say when it ended: at the last time that is known of it.
  void reaches(SimTime t) { end_ = std::max(end_, std::min(t, stretch_.to)); }

  Stretch stretch_;
  SimTime end_;           ///< of what has not ended
  SimTime production_{};  ///< its begin: windows count from there
  AppendFile file_;
  std::string text_;
  TraceWriter trace_;
  std::map<std::string, std::pair<std::string, Open>> skills_, phases_;  ///< by stream: robot, and what it does
  struct State {
    std::string kind, name;
    Open open;
  };
  std::map<EntityId, State> states_;
};

}  // namespace cxlab::lab
