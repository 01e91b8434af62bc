#pragma once
// What enters the environments of an episode: logged while it plays, or taken from the log of a former run.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"
#include "cx/engine/outside.h"
#include "cx/executive/run_control.h"
#include "cx/journal/journal.h"

namespace cxlab {

/// This base class logs nothing and replays nothing.
class Inputs {
 public:
  virtual ~Inputs() = default;
  /// Called with each environment and each manager before anything is delivered to it.
  virtual void watch(bus::ParticipantId) {}
  /// How the environments of that stream look outside the run; none: directly.
  virtual LookOutside* outside(const std::string& /*stream*/) { return nullptr; }
  /// Where their deliveries come from; none: the bus.
  virtual bus::Feed* feed() { return nullptr; }
  /// What a person does in environments; none: nobody does.
  virtual cx::ControlLog* control_log() { return nullptr; }
  /// What the seat of that stream sends at this tick, as bytes of its own.
  virtual void add_seat(const std::string& /*stream*/, SimTime /*t*/, const std::string& /*bytes*/) {}
  /// Whether `ticked` writes into the log's file at that time.
  virtual bool writes_at(SimTime /*t*/) const { return false; }
  /// After the start (`t` is `kStarted`) and after each tick; `world` is what has entered the physics.
  virtual Status ticked(SimTime /*t*/, const std::string& /*world*/) { return {}; }
  /// Writes the inputs so far to the log's file: the process may end at any time.
  virtual void flush() {}
  /// After the last tick.
  virtual Status close() { return {}; }
  /// In a replay: how far the log goes, and whether it is whole.
  virtual SimTime end() const { return {}; }
  virtual Status log_status() const { return {}; }
};

/// An intervention in an environment, from its entry in the log; none if the entry is damaged.
std::optional<cx::ControlAct> read_act(SimTime t, std::string_view bytes);

/// Something that was done in an environment of a recorded run.
struct PastAct {
  std::string environment;  ///< as `Environment::unique_name`
  cx::ControlAct act;
};
/// All that was done in environments, in order.
Expected<std::vector<PastAct>> recorded_acts(const std::filesystem::path& inputs);

/// Writes a new log. Bus and journal outlive it.
Expected<std::unique_ptr<Inputs>> record_inputs(const std::filesystem::path& log, bus::Bus& bus, Journal& journal);
/// Reads a whole log. Bus, which is muted, and journal outlive it.
Expected<std::unique_ptr<Inputs>> replay_inputs(const std::filesystem::path& log, bus::Bus& bus, Journal& journal);

}  // namespace cxlab
