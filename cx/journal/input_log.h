#pragma once
// inputs.bin: everything that entered each environment, and every write to the physics, so that each replays alone.
//
// The file: 8 bytes of magic, then chunks of (length, checksum, payload). A payload is a run of whole entries; a name
// is spelt once and then a number. A chunk that is cut off or changed ends the reading there.

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cx/base/append_file.h"
#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"

namespace cxlab {

/// One delivery that an environment took. The log names participants and causes by their stream. It names an endpoint
/// by its number in the order in which its participant made them. Both are the same when the rules run again.
struct LoggedDelivery {
  bus::Delivery delivery;      ///< without sender, receiver, message and stream of its cause, which are named here
  std::string_view from;       ///< stream of the sender
  std::uint32_t endpoint = 0;  ///< the k-th that the receiver made, from 0
  std::string_view type;       ///< of the message; empty = there is none
  std::string_view message;    ///< as `bus::Message::serialize` writes it
  std::string_view cause_stream;
};

/// What one environment took at one tick.
struct LoggedTake {
  SimTime t{};
  std::string_view to;  ///< stream of the environment
  std::vector<LoggedDelivery> deliveries;
};

/// What a function that looks outside gave to an environment.
struct LoggedResult {
  SimTime t{};
  std::string_view environment;  ///< its stream
  std::string_view key;          ///< which function, for example "read-line"
  std::string_view bytes;
};

/// The `key` of a `LoggedResult` that is no result but what a person did (`environment` is its stream).
inline constexpr std::string_view kControlKey = "control";
/// The same for what a seat sent (scenarios/seat.h): `environment` is the stream of the seat, "seat/NAME".
inline constexpr std::string_view kSeatKey = "seat";
inline constexpr std::string_view kSeatStream = "seat/";

/// Controls, model writes or state writes of a world, in the world's own format.
struct LoggedWorld {
  SimTime t{};
  std::string_view world;
  std::string_view bytes;
};

/// The time of a log that has all inputs of the start, and none of the first tick.
inline constexpr SimTime kStarted{-1};

using LoggedInput = std::variant<LoggedTake, LoggedResult, LoggedWorld>;

/// Writes entries in the order in which they come.
class InputLogWriter {
 public:
  static Expected<InputLogWriter> create(const std::filesystem::path& path);

  /// Entries reach the file with `reach` and `flush`, or when 16 MiB have come together.
  void add(const LoggedTake& take);
  void add(const LoggedResult& result);
  void add(const LoggedWorld& world);
  /// All that entered up to `t` has been added (`kStarted`: until the first tick). Noted the first time, when the time
  /// has doubled, and every 10 s of simulated time; what was added then reaches the file.
  void reach(SimTime t);
  /// Whether `reach` writes at that time.
  bool writes_at(SimTime t) const { return t >= flush_due_; }

  /// Whether writing went well so far (kResource if not); ask once a tick.
  const Status& status() const { return file_.status(); }
  Status flush();
  /// The last mark: all that entered up to the end.
  Status close(SimTime end);

 private:
  explicit InputLogWriter(AppendFile file) : file_(std::move(file)) {}
  void begin(std::uint8_t entry, SimTime t);
  void finish();
  void put_name(std::string_view name);
  void end_chunk();

  AppendFile file_;
  std::string chunk_;                // entries that come together
  std::size_t begun_at_ = 0;         // where the last of them begins
  std::vector<std::string> framed_;  // whole chunks with their lengths and checksums, which wait for `flush`
  std::map<std::string, std::uint64_t, std::less<>> names_;
  SimTime last_t_{};
  SimTime flush_due_ = kStarted;
};

/// Reads them back. Views of an entry live as long as the reader.
class InputLogReader {
 public:
  /// kInput if the file cannot be read or is no input log.
  static Expected<InputLogReader> open(const std::filesystem::path& path);
  static Expected<InputLogReader> from_bytes(std::string bytes, std::string path);

  /// The next entry; nothing at the end, or where the log is broken.
  std::optional<LoggedInput> next();
  /// The last time up to which all inputs have been read; `kStarted` if that is only the start, less if not even that.
  SimTime reached() const { return reached_; }
  /// After the last entry: where and how the log is broken (cut off, changed), or success.
  const Status& status() const { return status_; }

 private:
  InputLogReader() = default;
  bool open_chunk();
  void fail(const std::string& what);

  std::string path_;
  std::shared_ptr<const std::string> bytes_;
  std::size_t position_ = 0;     // of the next chunk
  std::size_t chunk_start_ = 0;  // of the current one
  std::string_view chunk_;       // what is left of the current one
  std::shared_ptr<std::deque<std::string>> names_;
  SimTime last_t_{}, reached_ = kStarted - SimTime{1};
  Status status_;
};

}  // namespace cxlab
