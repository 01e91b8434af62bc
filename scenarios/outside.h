#pragma once
// What functions of rules found outside, kept in the input log, and given to them again in a replay.

#include <optional>
#include <string>

#include "cx/base/expected.h"
#include "cx/engine/outside.h"
#include "cx/journal/input_log.h"
#include "cx/journal/replay.h"

namespace cxlab {

/// A value as bytes, and back. Facts and instances are no values of the outside: they become void.
std::string to_bytes(const Value& value);
Expected<Value> value_from_bytes(std::string_view bytes);

/// Calls, and logs what came.
class RecordingOutside final : public LookOutside {
 public:
  RecordingOutside(const bus::Bus& bus, InputLogWriter& log, std::string stream)
      : bus_(bus), log_(log), stream_(std::move(stream)) {}
  Value look(std::string_view function, const std::function<Value()>& outside) override;

 private:
  const bus::Bus& bus_;
  InputLogWriter& log_;
  std::string stream_;
};

/// Answers from the log; the first thing that is missing there is its error.
class ReplayingOutside final : public LookOutside {
 public:
  ReplayingOutside(Replayer& replayer, std::string stream) : replayer_(replayer), stream_(std::move(stream)) {}
  Value look(std::string_view function, const std::function<Value()>& outside) override;
  const std::optional<Error>& error() const { return error_; }

 private:
  Replayer& replayer_;
  std::string stream_;
  std::optional<Error> error_;
};

}  // namespace cxlab
