#pragma once
// Between the bus and the input log: what environments take is logged, and handed to them again. (The writes to a
// world are replayed straight from `InputLogReader`.)

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/journal/input_log.h"
#include "cx/journal/journal.h"

namespace cxlab {

/// Logs what the watched environments take. Hand it to `Bus::set_input_tap`.
class RecordingTap final : public bus::InputTap {
 public:
  RecordingTap(const bus::Bus& bus, const Journal& journal, InputLogWriter& log)
      : bus_(bus), journal_(journal), log_(log) {}

  /// Watches a participant from now on: an environment, or the node that manages environments. The log knows it by
  /// its stream, so each needs its own.
  void watch(bus::ParticipantId participant);
  void delivered(bus::ParticipantId to, const std::vector<bus::Delivery>& deliveries) override;

 private:
  const bus::Bus& bus_;
  const Journal& journal_;
  InputLogWriter& log_;
  std::map<bus::ParticipantId, std::string> watched_;  // their streams
  std::deque<std::string> messages_;                   // of the take being logged
};

/// Plays a log to environments on a muted bus, without those who once sent. The episode joins and activates the
/// environments as it did then, and feeds them from here where it else feeds them from the bus. What differs
/// from the recorded run is an error (kNo).
class Replayer final : public bus::Feed {
 public:
  /// Reads the whole log.
  Replayer(InputLogReader log, bus::Bus& bus, Journal& journal);

  /// How reading ended: a log that is cut off replays up to there.
  const Status& log_status() const { return log_.status(); }
  /// As `InputLogReader::reached`.
  SimTime end() const { return end_; }

  /// Names an environment before anything is delivered: a delivery of another one may come from it first.
  void watch(bus::ParticipantId participant);
  /// Hands over what this environment took at `Bus::now`, if anything.
  Status feed(bus::ParticipantId environment) override;
  /// When an environment takes next; kNever after the last.
  SimTime next_due() const override;
  /// What `key` (a function that looked outside) gave next to the environment of that stream.
  Expected<std::string_view> next_result(std::string_view environment, std::string_view key);
  /// What a person did next in that environment (its entry); none after the last.
  std::optional<LoggedResult> next_control(std::string_view environment) const;
  void take_control(std::string_view environment);
  /// After the last tick: success, or what the environments did not take or ask for.
  Status all_used() const;

 private:
  struct Inputs {
    std::deque<LoggedTake> takes;
    std::deque<LoggedResult> results, controls;
  };
  Expected<bus::Delivery> to_delivery(const LoggedDelivery& logged, bus::ParticipantId to, const std::string& name);
  bus::ParticipantId sender(std::string_view stream);

  InputLogReader log_;  // owns what the entries view
  bus::Bus& bus_;
  Journal& journal_;
  std::map<std::string, Inputs, std::less<>> inputs_;               // by stream of the environment
  std::map<std::string, bus::ParticipantId, std::less<>> senders_;  // by stream
  SimTime end_{};
};

}  // namespace cxlab
