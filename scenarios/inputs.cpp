#include "scenarios/inputs.h"

#include <deque>

#include "cx/journal/input_log.h"
#include "cx/journal/replay.h"
#include "scenarios/outside.h"

namespace cxlab {

namespace {

class RecordedInputs final : public Inputs {
 public:
  RecordedInputs(InputLogWriter log, bus::Bus& bus, Journal& journal)
      : log_(std::move(log)), bus_(bus), tap_(bus, journal, log_) {
    bus.set_input_tap(&tap_);
  }
  ~RecordedInputs() override { bus_.set_input_tap(nullptr); }
  void watch(bus::ParticipantId participant) override { tap_.watch(participant); }
  LookOutside* outside(const std::string& stream) override { return &outside_.emplace_back(bus_, log_, stream); }
  Status ticked(const std::string& world) override {
    if (!world.empty()) log_.add(LoggedWorld{bus_.now(), "world", world});
    log_.reach(bus_.now());
    return log_.status();
  }
  Status close() override { return log_.close(); }

 private:
  InputLogWriter log_;
  bus::Bus& bus_;
  RecordingTap tap_;
  std::deque<RecordingOutside> outside_;
};

class ReplayedInputs final : public Inputs {
 public:
  ReplayedInputs(InputLogReader log, bus::Bus& bus, Journal& journal) : replayer_(std::move(log), bus, journal) {}
  void watch(bus::ParticipantId participant) override { replayer_.watch(participant); }
  LookOutside* outside(const std::string& stream) override { return &outside_.emplace_back(replayer_, stream); }
  bus::Feed* feed() override { return &replayer_; }
  Status ticked(const std::string&) override {
    for (const ReplayingOutside& outside : outside_)
      if (outside.error()) return *outside.error();
    return {};
  }
  Status close() override { return replayer_.log_status() ? replayer_.all_used() : Status(); }
  SimTime end() const override { return replayer_.end(); }
  Status log_status() const override { return replayer_.log_status(); }

 private:
  Replayer replayer_;
  std::deque<ReplayingOutside> outside_;
};

}  // namespace

Expected<std::unique_ptr<Inputs>> record_inputs(const std::filesystem::path& log, bus::Bus& bus, Journal& journal) {
  auto writer = InputLogWriter::create(log);
  if (!writer) return writer.error();
  return std::unique_ptr<Inputs>(std::make_unique<RecordedInputs>(*std::move(writer), bus, journal));
}

Expected<std::unique_ptr<Inputs>> replay_inputs(const std::filesystem::path& log, bus::Bus& bus, Journal& journal) {
  auto reader = InputLogReader::open(log);
  if (!reader) return reader.error();
  return std::unique_ptr<Inputs>(std::make_unique<ReplayedInputs>(*std::move(reader), bus, journal));
}

}  // namespace cxlab
