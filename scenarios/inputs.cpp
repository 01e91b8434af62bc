#include "scenarios/inputs.h"

#include <deque>

#include "cx/base/byte_codec.h"
#include "cx/journal/input_log.h"
#include "cx/journal/replay.h"

namespace cxlab {

namespace {

// A value as bytes, and back. Facts and instances are no values of the outside: they become void.

void write(const Value& value, ByteWriter& out) {
  switch (value.type()) {
    case ValueType::kInteger: out.fixed(value.type()).fixed(value.as_integer()); return;
    case ValueType::kFloat: out.fixed(value.type()).fixed(value.as_number()); return;
    case ValueType::kHandle: out.fixed(value.type()).fixed(value.as_handle()); return;
    case ValueType::kSymbol:
    case ValueType::kString:
    case ValueType::kInstanceName:
      out.fixed(value.type()).fixed(static_cast<std::uint32_t>(value.text().size())).raw(value.text());
      return;
    case ValueType::kMultifield:
      out.fixed(value.type()).fixed(static_cast<std::uint32_t>(value.items().size()));
      for (const Value& item : value.items()) write(item, out);
      return;
    default: out.fixed(ValueType::kVoid);
  }
}

/// Multifields hold no multifields.
Value read(ByteReader& in, bool inside = false) {
  const auto text = [&in] { return std::string(in.raw(in.fixed<std::uint32_t>())); };
  switch (in.fixed<ValueType>()) {
    case ValueType::kVoid: return {};
    case ValueType::kInteger: return Value::integer(in.fixed<std::int64_t>());
    case ValueType::kFloat: return Value::number(in.fixed<double>());
    case ValueType::kHandle: return Value::handle(in.fixed<Handle>());
    case ValueType::kSymbol: return Value::symbol(text());
    case ValueType::kString: return Value::string(text());
    case ValueType::kInstanceName: return Value::instance_name(text());
    case ValueType::kMultifield: {
      if (inside) in.refuse();
      const auto size = in.fixed<std::uint32_t>();
      std::vector<Value> items;
      for (std::uint32_t i = 0; i < size && in.ok(); ++i) items.push_back(read(in, true));
      return Value::multifield(std::move(items));
    }
    default: in.refuse(); return {};
  }
}

/// Calls a function of rules that looks outside, and logs what it returned.
class RecordingOutside final : public LookOutside {
 public:
  RecordingOutside(const bus::Bus& bus, InputLogWriter& log, std::string stream)
      : bus_(bus), log_(log), stream_(std::move(stream)) {}
  Value look(std::string_view function, const std::function<Value()>& outside) override {
    Value value = outside();
    std::string bytes;
    ByteWriter out(bytes);
    write(value, out);
    log_.add(LoggedResult{bus_.now(), stream_, function, bytes});
    return value;
  }

 private:
  const bus::Bus& bus_;
  InputLogWriter& log_;
  std::string stream_;
};

/// Answers from the log; the first result that is missing there is its error.
class ReplayingOutside final : public LookOutside {
 public:
  ReplayingOutside(Replayer& replayer, std::string stream) : replayer_(replayer), stream_(std::move(stream)) {}
  Value look(std::string_view function, const std::function<Value()>&) override {
    if (error_) return {};
    const auto bytes = replayer_.next_result(stream_, function);
    if (!bytes) {
      error_ = bytes.error();
      return {};
    }
    ByteReader in(*bytes);
    Value value = read(in);
    if (in.ok() && in.left() == 0) return value;
    error_ = input_error("a value in the input log is damaged");
    return {};
  }
  const std::optional<Error>& error() const { return error_; }

 private:
  Replayer& replayer_;
  std::string stream_;
  std::optional<Error> error_;
};

// An act of the control as bytes, and back.

std::string bytes_of(const cx::ControlAct& act) {
  std::string bytes;
  ByteWriter out(bytes);
  out.zigzag(act.place.run).zigzag(act.place.fired).fixed(act.verb);
  if (cx::is_planned(act.verb)) out.fixed(static_cast<std::uint32_t>(act.name.size())).raw(act.name);
  out.raw(act.text);
  return bytes;
}

class RecordedInputs final : public Inputs, private cx::ControlLog {
 public:
  RecordedInputs(InputLogWriter log, bus::Bus& bus, Journal& journal)
      : log_(std::move(log)), bus_(bus), tap_(bus, journal, log_) {
    bus.set_input_tap(&tap_);
  }
  ~RecordedInputs() override { bus_.set_input_tap(nullptr); }
  void watch(bus::ParticipantId participant) override { tap_.watch(participant); }
  LookOutside* outside(const std::string& stream) override { return &outside_.emplace_back(bus_, log_, stream); }
  cx::ControlLog* control_log() override { return this; }
  void add_seat(const std::string& stream, SimTime t, const std::string& bytes) override {
    log_.add(LoggedResult{t, stream, kSeatKey, bytes});
  }
  bool writes_at(SimTime t) const override { return log_.writes_at(t); }
  Status ticked(SimTime t, const std::string& world) override {
    if (!world.empty()) log_.add(LoggedWorld{bus_.now(), "world", world});
    log_.reach(ticked_ = t);
    return log_.status();
  }
  void flush() override { (void)log_.flush(); }
  Status close() override { return log_.close(ticked_); }

 private:
  void add(std::string_view environment, const cx::ControlAct& act) override {
    const std::string bytes = bytes_of(act);
    log_.add(LoggedResult{act.place.t, environment, kControlKey, bytes});
  }
  std::optional<cx::ControlAct> next(std::string_view) override { return {}; }
  void take(std::string_view) override {}

  InputLogWriter log_;
  SimTime ticked_ = kStarted - SimTime{1};
  bus::Bus& bus_;
  RecordingTap tap_;
  std::deque<RecordingOutside> outside_;
};

class ReplayedInputs final : public Inputs, private cx::ControlLog {
 public:
  ReplayedInputs(InputLogReader log, bus::Bus& bus, Journal& journal) : replayer_(std::move(log), bus, journal) {}
  void watch(bus::ParticipantId participant) override { replayer_.watch(participant); }
  LookOutside* outside(const std::string& stream) override { return &outside_.emplace_back(replayer_, stream); }
  bus::Feed* feed() override { return &replayer_; }
  cx::ControlLog* control_log() override { return this; }
  Status ticked(SimTime, const std::string&) override {
    for (const ReplayingOutside& outside : outside_)
      if (outside.error()) return *outside.error();
    return damaged_ ? Status(input_error("what a person did is damaged in the input log")) : Status();
  }
  Status close() override { return replayer_.log_status() ? replayer_.all_used() : Status(); }
  SimTime end() const override { return replayer_.end(); }
  Status log_status() const override { return replayer_.log_status(); }

 private:
  void add(std::string_view, const cx::ControlAct&) override {}
  std::optional<cx::ControlAct> next(std::string_view environment) override {
    const auto logged = replayer_.next_control(environment);
    if (!logged) return {};
    auto act = read_act(logged->t, logged->bytes);
    damaged_ = damaged_ || !act;
    return act;
  }
  void take(std::string_view environment) override { replayer_.take_control(environment); }

  Replayer replayer_;
  std::deque<ReplayingOutside> outside_;
  bool damaged_ = false;
};

}  // namespace

std::optional<cx::ControlAct> read_act(SimTime t, std::string_view bytes) {
  ByteReader in(bytes);
  cx::ControlAct act;
  act.place.t = t;
  act.place.run = in.zigzag();
  act.place.fired = in.zigzag();
  act.verb = in.fixed<cx::ControlAct::Verb>();
  if (cx::is_planned(act.verb)) act.name = in.raw(in.fixed<std::uint32_t>());
  act.text = in.raw(in.left());
  if (!in.ok() || act.verb > cx::ControlAct::Verb::kCount) return {};
  return act;
}

Expected<std::vector<PastAct>> recorded_acts(const std::filesystem::path& inputs) {
  auto log = InputLogReader::open(inputs);
  if (!log) return log.error();
  std::vector<PastAct> acts;
  while (const auto entry = log->next()) {
    const auto* logged = std::get_if<LoggedResult>(&*entry);
    if (!logged || logged->key != kControlKey) continue;
    auto act = read_act(logged->t, logged->bytes);
    if (!act) return input_error("what was done in an environment is damaged in the input log", inputs.string());
    acts.push_back({std::string(logged->environment), *std::move(act)});
  }
  return acts;
}

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
