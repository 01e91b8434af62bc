#pragma once
// One run that somebody looks at: questions go to the process that plays it again (lab/view/players.h), or to the run
// itself while it is being played. Both speak the same lines (lab/control/debugger.h).

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "cx/base/json.h"
#include "lab/control/client.h"
#include "lab/view/players.h"
#include "lab/view/request.h"

namespace cxlab::lab {

/// May be used from any thread. One question is at work at a time; others wait for it.
class Visit {
 public:
  Visit(std::filesystem::path run, Players& players) : run_(std::move(run)), players_(players) {}
  ~Visit();
  Visit(const Visit&) = delete;
  Visit& operator=(const Visit&) = delete;

  /// POST /run/ID/ask and /run/ID/go, and GET /run/ID/events: docs/reference/view.md.
  ViewReply ask(const Json& request);
  ViewReply go(const Json& request);
  ViewReply events(std::uint64_t after);
  /// Begins to play the run, so that the first question does not wait for that. To be called once.
  void begin();
  /// A run in progress answers: it stops, steps and goes on as its visitor says.
  bool is_live() const { return live_; }
  /// Ends what waits; nothing is answered any more.
  void leave();

 private:
  using Event = ControlClient::Event;
  struct Answer {
    std::optional<Error> error;  // of the request, or of what plays the run
    bool died = false;           // the latter
    Json json;
  };

  Status connect();
  Status connect_to_player();
  Expected<std::unique_ptr<ControlClient>> client_over(Expected<Descriptor> connection) const;
  void listen(ControlClient& client);
  void take(const Event& event);
  void watch_events(int descriptor);
  void hang_up();
  Answer carry_out(const std::string& line, bool wait);
  Answer asked(const Json& question);
  Answer state();
  std::optional<Answer> set_time(const Json& request);
  ViewReply reply(const Answer& answer) const;
  ViewReply with_place(Json answer);
  Answer lost();

  const std::filesystem::path run_;
  Players& players_;

  std::timed_mutex turn_;  // of a question, and of all up to `news_`
  std::unique_ptr<ControlClient> client_;
  std::optional<int> player_;
  std::optional<double> end_;     // of the run, where it is known
  std::optional<double> set_to_;  // the time that the last question asked for, if the person is still there
  bool just_opened_ = false;      // the player stands at the beginning
  std::thread watch_, begin_;     // of a live run; of `begin`

  std::mutex news_;
  std::condition_variable has_news_;
  std::deque<Json> events_;
  std::uint64_t first_event_ = 0;        // number of the front
  std::uint64_t stops_ = 0;              // how often it stopped or ended
  std::atomic<bool> has_ended_ = false;  // and has said so
  std::atomic<bool> live_ = false, left_ = false;
  std::atomic<bool> over_ = false;  // it was live, and has ended
};

}  // namespace cxlab::lab
