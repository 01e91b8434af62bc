#include "lab/view/visit.h"

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "lab/control/server.h"

namespace cxlab::lab {

namespace {

using namespace std::chrono_literals;

constexpr auto kLongestTurn = 30s;  // that a question waits for another one
constexpr auto kLongestNews = 20s;  // that a request waits for events
constexpr auto kShortNews = 500ms;  // while the run goes on
constexpr auto kLongestStop = 20s;  // that a step of a live run is waited for
constexpr std::size_t kEventsKept = 5'000;

constexpr const char* kBusy = "another question about this run is at work; ask again when it has been answered";

/// As commands take a time.
std::string seconds_in_digits(double t) {
  char digits[64];
  std::snprintf(digits, sizeof digits, "%.9f", t);
  return digits;
}

/// The result is written a moment after the run ends.
constexpr int kTriesOfResult = 100;
bool is_unfinished(const std::filesystem::path& run) {
  const auto text = read_file(run / "result.json");
  const Json result = text ? parse_json(*text) : Json();
  return result.is_object() && result.contains("reason") && result["reason"].is_object() &&
         result["reason"].value("code", "") == "unfinished";
}

/// The command that a request of `go` stands for; an error where it stands for none.
Expected<std::string> command_of(const Json& request) {
  struct Verb {
    const char *key, *command;
    bool text;
  };
  static constexpr Verb kVerbs[] = {{"step", "step", false},   {"back", "back", false},
                                    {"tick", "tick", false},   {"speed", "speed", false},
                                    {"until", "until", true},  {"back_until", "back-until", true},
                                    {"pause", "pause", false}, {"continue", "continue", false}};
  for (const Verb& verb : kVerbs) {
    const auto found = request.find(verb.key);
    if (found == request.end()) continue;
    if (found->is_boolean() && *found && !verb.text) return std::string(verb.command);
    if (found->is_number() && !verb.text) return std::string(verb.command) + ' ' + json_text(*found);
    if (found->is_string() && verb.text) return std::string(verb.command) + ' ' + found->get<std::string>();
    return input_error("\"" + std::string(verb.key) +
                       "\": " + found_expected(json_text(*found), verb.text ? "a text" : "a number"));
  }
  return input_error(
      "expected where to go: {\"t\": S}, {\"step\": N}, {\"back\": N}, {\"until\": TEXT} or {\"back_until\": TEXT}; "
      "of a run in progress also {\"tick\": N}, {\"pause\": true}, {\"continue\": true} and {\"speed\": X}");
}

}  // namespace

Visit::~Visit() {
  leave();
  for (std::thread* thread : {&watch_, &begin_})
    if (thread->joinable()) thread->join();
  if (player_) players_.end(*player_);
}

void Visit::leave() {
  left_ = true;
  const std::lock_guard lock(news_);
  if (client_) client_->hang_up();
  has_news_.notify_all();
}

// --- Who answers

Expected<std::unique_ptr<ControlClient>> Visit::client_over(Expected<Descriptor> connection) const {
  if (!connection) return connection.error();
  return ControlClient::over(*std::move(connection), (run_ / "control.sock").string());
}

Status Visit::connect() {
  if (client_) return {};
  for (int tries = 0; over_ && !left_ && tries < kTriesOfResult && is_unfinished(run_); ++tries)
    std::this_thread::sleep_for(20ms);
  if (left_) return resource_error("cxlab view has ended");
  set_to_.reset();
  if (!over_ && path_exists(run_ / "control.sock")) {
    if (auto client = client_over(players_.connect_to_run(run_))) {
      live_ = true;
      listen(**client);
      const std::lock_guard lock(news_);
      client_ = *std::move(client);
      watch_ = std::thread([this, line = client_->descriptor()] { watch_events(line); });
      return {};
    }
  }
  return connect_to_player();
}

Status Visit::connect_to_player() {
  if (player_) players_.end(*std::exchange(player_, std::nullopt));
  auto player = players_.play(run_);
  if (!player) return player.error();
  player_ = player->number;
  end_ = player->end;
  just_opened_ = true;
  while (!left_) {
    if (auto client = client_over(players_.connect(player->number))) {
      const std::lock_guard lock(news_);
      client_ = *std::move(client);
      return {};
    }
    if (auto end = players_.end_of(*player_)) {
      player_.reset();
      return *end;
    }
    std::this_thread::sleep_for(5ms);
  }
  return resource_error("cxlab view has ended");
}

void Visit::hang_up() {
  std::unique_ptr<ControlClient> gone;
  {
    const std::lock_guard lock(news_);
    gone = std::move(client_);
  }
  set_to_.reset();
}

/// The process that plays the run has ended. Says why; the next question starts it again. No error for a live run that
/// ended.
Visit::Answer Visit::lost() {
  if (client_ && live_) {
    (void)client_->take_events();  // those that came before it ended
    if (!has_ended_) take({Event::Kind::kEnd, 0, {}, {}, "the run has ended"});
  }
  hang_up();
  if (left_) return {resource_error("cxlab view has ended"), true, {}};
  if (live_) {
    live_ = false;
    over_ = true;
    return {};
  }
  std::optional<Error> why;
  if (player_) {
    for (int i = 0; i < 200 && !why; ++i) {
      why = players_.end_of(*player_);
      if (!why) std::this_thread::sleep_for(5ms);
    }
    if (!why) players_.end(*player_);
  }
  player_.reset();
  return {
      run_error("what played the run has ended: " + (why ? why->text() : std::string("nobody knows why"))), true, {}};
}

// --- Events of a live run

void Visit::listen(ControlClient& client) {
  client.on_event([this](const Event& event) { take(event); });
}

void Visit::take(const Event& event) {
  static constexpr const char* kNames[] = {"hello", "stopped", "log", "end"};
  Json json{{"event", kNames[static_cast<std::size_t>(event.kind)]}, {"text", event.text}};
  if (event.kind == Event::Kind::kLog) {
    json["t"] = event.t;
    json["level"] = event.level;
    json["logger"] = event.logger;
  }
  const std::lock_guard lock(news_);
  if (event.kind == Event::Kind::kStopped || event.kind == Event::Kind::kEnd) ++stops_;
  has_ended_ = has_ended_ || event.kind == Event::Kind::kEnd;
  events_.push_back(std::move(json));
  if (events_.size() > kEventsKept) {
    events_.pop_front();
    ++first_event_;
  }
  has_news_.notify_all();
}

/// Takes events that come between questions.
void Visit::watch_events(int descriptor) {
  while (!left_ && live_) {
    // What came together with an answer waits in the client, not in the socket.
    pollfd line{descriptor, POLLIN, 0};
    (void)poll(&line, 1, 100);
    const std::unique_lock turn(turn_, 100ms);
    if (!turn || !client_ || !live_ || client_->take_events()) continue;
    lost();
    has_news_.notify_all();
  }
}

/// Where a live run is: its time, and whether it goes on.
Visit::Answer Visit::state() {
  const std::unique_lock turn(turn_, kLongestTurn);
  if (!turn) return {input_error(kBusy), false, {}};
  if (const Status there = connect(); !there) return {there.error(), true, {}};
  if (!live_) return {{}, false, {{"t", Json()}, {"running", false}}};
  return asked({{"ask", "where"}});
}

ViewReply Visit::events(std::uint64_t after) {
  Answer now = state();
  if (now.error && !over_) return reply(now);
  // While the run goes on its time is news.
  const auto longest = !now.error && now.json["running"] == true ? kShortNews : kLongestNews;
  Json json{{"next", after}, {"events", Json::array()}};
  {
    std::unique_lock lock(news_);
    const auto end = [&] { return first_event_ + events_.size(); };
    has_news_.wait_for(lock, longest, [&] { return left_ || !live_ || after != end(); });
    for (std::uint64_t n = std::max(after, first_event_); n < end(); ++n)
      json["events"].push_back(events_[static_cast<std::size_t>(n - first_event_)]);
    json["next"] = end();
  }
  if (live_) now = state();
  json["live"] = live_.load();
  json["t"] = now.error ? Json() : now.json["t"];
  json["running"] = !now.error && live_ && now.json["running"] == true;
  return {200, "application/json", json_text(json)};
}

// --- Questions

Visit::Answer Visit::asked(const Json& question) {
  const auto text = client_->ask(json_text(question));
  if (text) return {std::nullopt, false, parse_json(*text)};
  if (text.error().kind != ErrorKind::kResource) return {text.error(), false, {}};
  Answer gone = lost();
  // A live run ended meanwhile: the question goes to its folder.
  if (gone.error) return gone;
  if (const Status there = connect(); !there) return {there.error(), true, {}};
  return asked(question);
}

/// A command of `cxlab attach`. One that lets the run go on is waited for.
Visit::Answer Visit::carry_out(const std::string& line, bool wait) {
  std::uint64_t stops = 0;
  {
    const std::lock_guard lock(news_);
    stops = stops_;
  }
  const auto said = client_->carry_out(line);
  if (!said) return lost();
  if (!said->ok) return {input_error(said->text), false, {}};
  if (!said->goes_on || !wait) return {};
  if (!live_) return client_->wait_for_stop() ? Answer() : lost();
  // Events come by way of this thread, which has the turn.
  const auto until = std::chrono::steady_clock::now() + kLongestStop;
  while (!left_ && std::chrono::steady_clock::now() < until) {
    pollfd news{client_->descriptor(), POLLIN, 0};
    if (!client_->take_events()) return lost();
    {
      const std::lock_guard lock(news_);
      if (stops_ != stops) break;
    }
    (void)poll(&news, 1, 50);
  }
  return {};
}

/// Goes to the time that a request names, if it names one and the person is elsewhere; the error that this ends with.
/// Where this request opened the run again, that is the time at which the person stood before.
std::optional<Visit::Answer> Visit::set_time(const Json& request) {
  const bool just_opened = std::exchange(just_opened_, false);
  auto found = request.find("t");
  if (found == request.end() && just_opened) found = request.find("stood");
  if (found == request.end() || found->is_null()) return std::nullopt;
  const double t = found->is_number() ? found->get<double>() : -1;
  if (!(t >= 0 && t <= 1e9))
    return Answer{input_error('"' + found.key() + "\": " + found_expected(json_text(*found), "a time of the run in s")),
                  false,
                  {}};
  if (live_)
    return Answer{
        input_error("this run is still being played: it can be asked about now only, without \"t\""), false, {}};
  constexpr double kRounded = 0.001;  // pages have times to the millisecond
  if (end_ && t > *end_ + kRounded)
    return Answer{input_error("the run ends at " + general_text(*end_, 9) + " s"), false, {}};
  if (set_to_ == t) return std::nullopt;
  Answer answer = carry_out("after " + seconds_in_digits(t), true);
  if (answer.error) return answer;
  set_to_ = t;
  return std::nullopt;
}

ViewReply Visit::reply(const Answer& answer) const { return view_error(answer.died ? 500 : 400, answer.error->text()); }

ViewReply Visit::with_place(Json answer) {
  if (const Status there = connect(); !there) return view_error(500, there.error().text());
  const Answer place = asked({{"ask", "where"}});
  if (place.error) return reply(place);
  Json json{{"place", place.json}};
  if (!answer.is_null()) json["answer"] = std::move(answer);
  return {200, "application/json", json_text(json)};
}

ViewReply Visit::ask(const Json& request) {
  if (!request.is_object() || !request.contains("ask") || !request["ask"].is_string())
    return view_error(400, "expected {\"ask\": \"NAME\", ...}");
  const std::unique_lock turn(turn_, kLongestTurn);
  if (!turn) return view_error(409, kBusy);
  if (const Status there = connect(); !there) return view_error(500, there.error().text());
  if (const auto failed = set_time(request)) return reply(*failed);
  Json question = request;
  question.erase("t");
  question.erase("stood");
  question.erase("line");
  question.erase("complete");
  Answer answer = asked(question);
  if (answer.error) return reply(answer);
  return with_place(std::move(answer.json));
}

ViewReply Visit::go(const Json& request) {
  if (!request.is_object()) return view_error(400, "expected a JSON object, as {\"t\": 312.4}");
  const std::unique_lock turn(turn_, kLongestTurn);
  if (!turn) return view_error(409, kBusy);
  if (const Status there = connect(); !there) return view_error(500, there.error().text());
  if (const auto env = request.find("env"); env != request.end()) {
    if (!env->is_string())
      return view_error(400, "\"env\": " + found_expected(json_text(*env), "the name of an environment"));
    const std::string name = env->get<std::string>();
    if (const Answer used = carry_out("use " + (name.empty() ? "all" : name), true); used.error) return reply(used);
  }
  if (request.contains("t")) {
    if (const auto failed = set_time(request)) return reply(*failed);
    return with_place(nullptr);
  }
  const auto command = command_of(request);
  if (!command) return view_error(400, command.error().text());
  if (const auto failed = set_time(request)) return reply(*failed);
  set_to_.reset();
  if (!client_) return with_place(nullptr);
  if (const Answer gone = carry_out(*command, !request.contains("continue")); gone.error) return reply(gone);
  return with_place(nullptr);
}

void Visit::begin() {
  begin_ = std::thread([this] {
    const std::unique_lock turn(turn_);
    (void)connect();  // the first question reports an error
  });
}

}  // namespace cxlab::lab
