#pragma once
// The socket at which a run is controlled: lines of JSON come in and go out. It has a thread of its own; the run takes
// what has come where it stops.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "cx/base/expected.h"

namespace cxlab::lab {

/// Where a run is controlled.
struct ControlAddress {
  std::string path;        ///< of a Unix socket; empty: `port`
  std::uint16_t port = 0;  ///< on 127.0.0.1; 0: any that is free
  std::string text() const;

  /// "127.0.0.1:PORT", "localhost:PORT", or the path of a socket.
  static Expected<ControlAddress> parse(const std::string& text);
};

/// Lines of those who are attached to a run.
class ControlLines {
 public:
  virtual ~ControlLines() = default;
  struct Line {
    std::uint64_t client = 0;         ///< counted from 1
    std::string text;                 ///< at most 1 MB
    bool came = false, went = false;  ///< no line: the client has come, or gone
  };
  /// The next line, where there is one; it waits for it so long at the most. Cheap where there is none.
  virtual std::optional<Line> take(std::chrono::milliseconds wait = {}) = 0;
  virtual void send(std::uint64_t client, const std::string& line) = 0;
  virtual void send_all(const std::string& line) = 0;
};

class ControlServer final : public ControlLines {
 public:
  /// Only the user can open the Unix socket; at a port the first line must be the token.
  static Expected<std::unique_ptr<ControlServer>> open(const ControlAddress& address);
  /// Lines that wait are sent first, for at most a second.
  ~ControlServer() override;
  ControlServer(const ControlServer&) = delete;
  ControlServer& operator=(const ControlServer&) = delete;

  const ControlAddress& address() const;
  const std::string& token() const;  ///< empty for a Unix socket

  std::optional<Line> take(std::chrono::milliseconds wait = {}) override;
  /// A client that does not read its lines is cut off.
  void send(std::uint64_t client, const std::string& line) override;
  void send_all(const std::string& line) override;

 private:
  struct State;
  explicit ControlServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cxlab::lab
