#pragma once
// Between the bus and the input log: what environments take is logged, and handed to them again.

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/journal/input_log.h"
#include "cx/journal/journal.h"

namespace cxlab {

/// Logs what the watched environments take. Register with `Bus::set_input_tap`.
class RecordingTap final : public bus::InputTap {
 public:
  RecordingTap(const bus::Bus& bus, const Journal& journal, InputLogWriter& log);
  /// Watches an environment from now on; each has its own stream, by which the log knows it.
  void watch(bus::ParticipantId environment);
  void delivered(bus::ParticipantId to, const std::vector<bus::Delivery>& deliveries) override;

 private:
  const bus::Bus& bus_;
  const Journal& journal_;
  InputLogWriter& log_;
  std::map<bus::ParticipantId, std::string> watched_;
};

/// Plays a log to the environments of a muted bus. What differs from the recorded run is an error (kNo).
class Replayer {
 public:
  /// Reads the whole log. Its damage, if any, is in `log_status`: the run then replays up to there.
  static Expected<Replayer> load(InputLogReader log);
  const Status& log_status() const { return log_status_; }
  /// Time of the last entry.
  SimTime end() const { return end_; }

  /// The environments of the replay, in place of those that were watched.
  void attach(bus::ParticipantId environment, const bus::Bus& bus, const Journal& journal);

  /// Once a tick, before the environments take: hands over what they took at `bus.now()`.
  Status inject_due(bus::Bus& bus, Journal& journal);
  /// The next result of a function that looked outside, for that environment (its stream).
  Expected<std::string> outside(std::string_view environment, std::string_view key);
  /// What was logged but not asked for, as an error, or success. After the last tick.
  Status all_used() const;
  /// Writes to the physics, in order.
  const std::vector<LoggedWorld>& world_writes() const { return world_writes_; }

 private:
  explicit Replayer(InputLogReader log) : log_(std::move(log)) {}

  InputLogReader log_;  // owns what the entries view
  Status log_status_;
  SimTime end_{};
  std::deque<LoggedTake> takes_;  // not yet handed over
  std::map<std::string_view, std::deque<LoggedResult>> results_;  // by environment, not yet asked for
  std::vector<LoggedWorld> world_writes_;
  std::map<std::string, bus::ParticipantId, std::less<>> participants_;  // by stream
};

}  // namespace cxlab
