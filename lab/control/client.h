#pragma once
// One who is attached to a run: sends commands, gets answers and events (lab/control/debugger.h has their form).

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/servant.h"
#include "lab/control/server.h"

namespace cxlab::lab {

/// A connection to that Unix socket. kResource where nobody listens: a process that was killed leaves the file.
Expected<Descriptor> connect_to_socket(const std::string& path);

class ControlClient {
 public:
  /// kResource where nobody answers there. `token`: of a port; a Unix socket has none.
  static Expected<std::unique_ptr<ControlClient>> connect(const ControlAddress& address, const std::string& token);
  /// Speaks over a connection to the Unix socket at `path`, which another process may have opened.
  static Expected<std::unique_ptr<ControlClient>> over(Descriptor connection, const std::string& path);
  ~ControlClient();
  ControlClient(const ControlClient&) = delete;
  ControlClient& operator=(const ControlClient&) = delete;

  struct Event {
    enum class Kind { kHello, kStopped, kLog, kEnd };
    Kind kind{};
    double t = 0;                 ///< s; of a line of the log
    std::string level, logger{};  ///< of a line of the log
    std::string text;
  };
  struct Answer {
    bool ok = true;
    std::string text;
    bool goes_on = false;  ///< the run goes on; the next event of kind kStopped says to where
  };
  /// Called with each event, while one of the calls below waits.
  void on_event(std::function<void(const Event&)> call);

  Expected<Answer> carry_out(const std::string& line);
  /// A question of a program: a JSON object with "ask" and its arguments, without an id. Gives the answer's text, also
  /// JSON. Fails with kInput if the run refuses the question, and with kResource if the run has ended.
  Expected<std::string> ask(const std::string& question);
  /// Words that begin so.
  Expected<std::vector<std::string>> completions(const std::string& begun);
  /// Waits until the run stops or ends.
  Expected<Event> wait_for_stop();
  /// Takes the events that have come; an error when the run has ended.
  Status take_events();
  /// To wait for input, as with poll.
  int descriptor() const;
  /// Ends the conversation: whatever waits for the run, in any thread, gets an error.
  void hang_up();

 private:
  struct State;
  explicit ControlClient(std::unique_ptr<State> state);
  static Expected<std::unique_ptr<ControlClient>> greeted(std::unique_ptr<State> state, const ControlAddress& address);
  std::unique_ptr<State> state_;
};

}  // namespace cxlab::lab
