#include "lab/control/debugger.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <span>

#include "cx/base/json.h"
#include "cx/explain/fact_record.h"
#include "cx/inspect/text.h"

namespace cxlab::lab {

namespace {

using inspect::seconds_text;

constexpr std::size_t kLinesKept = 10'000;  // of the log, for those who come late

constexpr auto kSlice = std::chrono::milliseconds(50);  // of a wait, after which it looks around
constexpr std::uint32_t kNoEnvironment = static_cast<std::uint32_t>(-1);

bool names(const std::string& wanted, const ActivationInfo& activation) {
  return wanted == activation.rule || wanted == activation.module + "::" + activation.rule;
}

}  // namespace

std::string Debugger::Where::text() const {
  if (at_end) return "at the end of the run, " + seconds_text(place.t);
  if (place.fired == kAfterTick) return "after the tick at " + seconds_text(place.t);
  const std::string here = environment + " at " + seconds_text(place.t);
  if (place.fired < 0) return here + ", at the beginning of a tick";
  if (!rule) return here + ", no rule is on its agenda";
  std::string text = here + ", before rule " + *rule + " fires for";
  for (const std::int64_t fact : facts) text += fact < 0 ? " *" : " f-" + std::to_string(fact);
  return text;
}

std::optional<ActivationInfo> next_activation(const RuleEngine& engine) {
  std::vector<std::string> modules = engine.focus();
  if (modules.empty()) modules = {"MAIN"};
  const std::vector<ActivationInfo> agenda = engine.agenda();
  for (const std::string& module : modules)
    for (const ActivationInfo& activation : agenda)
      if (activation.module == module) return activation;
  return {};
}

bool Debugger::before_each_firing() const {
  if (target_) return *target_ != kEnd && place_.t >= visits_[target_->visit].place.t;
  return pause_ || steps_ > 0 || std::any_of(breaks_.begin(), breaks_.end(), [](const BreakPoint& b) {
           return b.kind != BreakPoint::Kind::kTime;
         });
}

Status Debugger::stop_at(cx::Environment& environment, const cx::ControlPlace& place) {
  if (gives_up_) return {};
  place_ = place;
  if (options_.recorded && passes_by(environment, place)) return {};
  here_ = &environment;
  if (!options_.recorded && place.fired < 0) keep_pace(place.t);
  if (const auto why = reason_to_stop(environment, place)) {
    stop(environment, *why);
  } else if (!options_.recorded) {
    while (auto line = lines_.take()) answer(*line);
  }
  here_ = nullptr;
  return {};
}

void Debugger::stop(cx::Environment& environment, const std::string& why) {
  std::erase_if(breaks_, [](const BreakPoint& point) { return point.once; });
  ticks_ = steps_ = 0;
  stopped_ = true;
  if (then_)
    answer(*std::exchange(then_, std::nullopt));
  else
    lines_.send_all(json_text(Json{{"event", "stopped"}, {"text", why + ": " + where()}}));
  if (!noted_ && !options_.recorded)
    options_.note("stopped at " + seconds_text(place_.t) + "; cxlab attach " + options_.address);
  noted_ = true;
  stay(environment);
  stopped_ = pause_ = false;
  pace_.reset();
}

/// Waits until the wall clock has come as far as `speed` says, and answers meanwhile.
void Debugger::keep_pace(SimTime t) {
  if (speed_ <= 0) return;
  using Clock = std::chrono::steady_clock;
  if (!pace_) pace_ = {t, Clock::now()};
  constexpr double kLongest = 1e8;  // s
  const auto due = [&] {
    return pace_->second + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                               std::min(to_seconds(t - pace_->first) / speed_, kLongest)));
  };
  options_.waits(true);
  while (speed_ > 0 && pace_ && !pause_ && !options_.over() && Clock::now() < due()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(due() - Clock::now());
    if (auto line = lines_.take(std::min(kSlice, left))) answer(*line);
  }
  options_.waits(false);
}

void Debugger::stay(cx::Environment&) {
  options_.waits(true);
  while (stopped_ && !options_.over())
    if (auto line = lines_.take(kSlice)) answer(*line);
  options_.waits(false);
}

std::optional<std::string> Debugger::reason_to_stop(cx::Environment& environment, const cx::ControlPlace& place) {
  if (target_) {
    target_.reset();
    settle_breaks();
    return "at";
  }
  if (!selected_.empty() && environment.unique_name() != selected_) return {};
  if (pause_) return "paused";
  if (place.fired < 0 && ticks_ > 0 && --ticks_ == 0) return "ticked";
  if (place.fired >= 0 && steps_ > 0 && next_activation(environment.engine()) && --steps_ == 0) return "stepped";
  for (BreakPoint& point : breaks_)
    if (is_met(point, environment, place))
      return point.once ? point.text : "break point " + std::to_string(point.number);
  return {};
}

bool Debugger::holds(const BreakPoint& fact, const cx::Environment& environment) {
  const auto facts = environment.engine().facts(fact.pattern->template_name());
  return std::any_of(facts.begin(), facts.end(), [&](const FactCopy& f) { return fact.pattern->matches(f); });
}

bool Debugger::is_met(BreakPoint& point, cx::Environment& environment, const cx::ControlPlace& place) {
  switch (point.kind) {
    case BreakPoint::Kind::kTime: return place.t >= point.time && !std::exchange(point.passed, true);
    case BreakPoint::Kind::kRule: {
      if (place.fired < 0) return false;
      const auto next = next_activation(environment.engine());
      return next && names(point.rule, *next);
    }
    case BreakPoint::Kind::kFact: break;
  }
  if (holds(point, environment)) return point.held.insert(&environment).second;
  point.held.erase(&environment);
  return false;
}

// --- A recorded run

void Debugger::begin_again() {
  passed_ = 0;
  log_.clear();
  here_ = nullptr;
  stopped_ = pause_ = changed_ = time_is_there_ = at_end_ = gives_up_ = false;
  for (BreakPoint& point : breaks_) {
    point.held.clear();
    point.passed = false;
  }
}

/// Notes the place. Whether there is nothing to be done there, because another one is wanted.
bool Debugger::passes_by(cx::Environment& environment, const cx::ControlPlace& place) {
  if (place.fired <= 0 && passed_++ == visits_.size()) {
    auto number = number_of(environment.unique_name());
    if (!number) {
      number = static_cast<std::uint32_t>(environment_names_.size());
      environment_names_.push_back(environment.unique_name());
    }
    visits_.push_back({place, *number, inspect(environment).timeline().end()});
  }
  if (!target_) return false;
  if (*target_ == kEnd || passed_ <= target_->visit) return true;
  return passed_ == target_->visit + 1 && place.fired < target_->fired;
}

void Debugger::tick_is_over(SimTime t) {
  if (gives_up_) return;
  const std::vector<cx::Environment*> all = environments();
  if (all.empty()) return;
  place_ = {t, 0, kAfterTick};
  if (passed_++ == visits_.size()) visits_.push_back({place_, kNoEnvironment, 0});
  if (!target_ || *target_ != Target{passed_ - 1, kAfterTick}) return;
  here_ = all.front();
  for (cx::Environment* one : all)
    if (one->unique_name() == selected_) here_ = one;
  target_.reset();
  settle_breaks();
  stop(*here_, "at");
  here_ = nullptr;
}

/// What of the break points holds here already gives no reason to stop.
void Debugger::settle_breaks() {
  for (BreakPoint& point : breaks_) {
    if (point.kind == BreakPoint::Kind::kTime) point.passed = place_.t >= point.time;
    if (point.kind != BreakPoint::Kind::kFact) continue;
    point.held.clear();
    for (const cx::Environment* environment : environments())
      if (holds(point, *environment)) point.held.insert(environment);
  }
}

void Debugger::go_to(Target target) {
  target_ = target;
  shown_.reset();
  gives_up_ = changed_ || time_is_there_ || !here_ || is_behind(target);
  stopped_ = false;
}

/// Whether the run came by, or is there.
bool Debugger::is_behind(Target target) const { return target <= played_to(); }

/// Tells where that is, and leaves the run where it is, if what was recorded tells enough; else plays it up to there.
Debugger::Answer Debugger::show(Target target) {
  if (target == played_to()) {
    shown_.reset();
    return {true, "at: " + where()};
  }
  const auto there = is_behind(target) ? seen(target) : std::nullopt;
  if (!there) {
    go_to(target);
    return {true, {}, true};
  }
  shown_ = target;
  return {true, "at: " + there->text()};
}

Debugger::Target Debugger::played_to() const { return at_end_ ? kEnd : Target{passed_ - 1, place_.fired}; }
Debugger::Target Debugger::here() const { return shown_.value_or(played_to()); }

/// The first record of the environment that is not yet written at the place where the person is.
std::uint64_t Debugger::end_here(cx::Environment& environment) const {
  const inspect::Timeline& timeline = inspect(environment).timeline();
  if (!shown_) return timeline.end();
  const auto number = number_of(environment.unique_name());
  const Visit& there = visits_[shown_->visit];
  if (number == there.environment) {
    if (shown_->fired <= 0) return there.next;
    const auto first = std::ranges::lower_bound(timeline.firings(), there.next);
    const auto next = first + std::min<std::ptrdiff_t>(shown_->fired, timeline.firings().end() - first);
    return next == timeline.firings().end() ? timeline.end() : *next;
  }
  for (std::size_t visit = shown_->visit + 1; visit < passed_; ++visit)
    if (visits_[visit].environment == number) return visits_[visit].next;
  return timeline.end();
}

void Debugger::stay_at_end(SimTime t, const Status& how) {
  const std::vector<cx::Environment*> all = environments();
  if (all.empty()) {
    lines_.send_all(json_text(Json{{"event", "end"}, {"text", "the run has no environment"}}));
    place_ = {t, 0, -1};
    at_end_ = stopped_ = true;
    while (!left_ && !options_.over())
      if (auto line = lines_.take(kSlice)) answer(*line);
    return;
  }
  here_ = all.front();
  for (cx::Environment* one : all)
    if (one->unique_name() == selected_) here_ = one;
  place_ = {t, 0, -1};
  at_end_ = stopped_ = true;
  ticks_ = steps_ = 0;
  target_.reset();
  settle_breaks();
  std::erase_if(breaks_, [](const BreakPoint& point) { return point.once; });
  if (then_)
    answer(*std::exchange(then_, std::nullopt));
  else
    lines_.send_all(json_text(Json{{"event", "stopped"}, {"text", where() + (how ? "" : ": " + how.error().text())}}));
  stay(*here_);
}

std::optional<std::uint32_t> Debugger::number_of(const std::string& environment) const {
  const auto known = std::ranges::find(environment_names_, environment);
  if (known == environment_names_.end()) return std::nullopt;
  return static_cast<std::uint32_t>(known - environment_names_.begin());
}

/// The place before the n-th last firing of those environments that count.
std::optional<Debugger::Target> Debugger::before_firing(std::int64_t n) const {
  std::map<std::uint32_t, std::span<const std::uint64_t>> firings;  // by environment, those still to be counted
  for (cx::Environment* environment : environments())
    if (const auto number = number_of(environment->unique_name());
        number && (selected_.empty() || selected_ == environment->unique_name())) {
      const std::vector<std::uint64_t>& all = inspect(*environment).timeline().firings();
      firings[*number] = {all.begin(), std::ranges::lower_bound(all, end_here(*environment))};
    }
  for (std::size_t visit = shown_ ? shown_->visit + 1 : passed_; visit-- > 0;) {
    const auto of = firings.find(visits_[visit].environment);
    if (of == firings.end()) continue;
    auto& left = of->second;
    const auto first = std::ranges::lower_bound(left, visits_[visit].next);
    const auto here = static_cast<std::int64_t>(left.end() - first);
    left = left.first(static_cast<std::size_t>(first - left.begin()));
    if (visits_[visit].place.fired < 0) continue;  // outside of a run of the rules
    if (here >= n) return Target{visit, here - n};
    n -= here;
  }
  return std::nullopt;
}

/// The last place before record `n` of the environment was written.
std::optional<Debugger::Target> Debugger::before_record(cx::Environment& environment, std::uint64_t n) const {
  const auto number = number_of(environment.unique_name());
  const std::vector<std::uint64_t>& firings = inspect(environment).timeline().firings();
  for (std::size_t visit = passed_; visit-- > 0;) {
    const Visit& there = visits_[visit];
    if (there.environment != number || there.next > n) continue;
    if (there.place.fired < 0) return Target{visit, there.place.fired};
    const auto first = std::ranges::lower_bound(firings, there.next), at = std::ranges::lower_bound(firings, n);
    const bool is_firing = at != firings.end() && *at == n;
    return Target{visit, std::max<std::int64_t>(0, at - first - (is_firing ? 0 : 1))};
  }
  return std::nullopt;
}

std::string Debugger::where() const {
  const auto there = place();
  return there ? there->text() : here_ ? "" : "running";
}

/// Where the person is; nothing while the run is between two places.
std::optional<Debugger::Where> Debugger::place() const {
  if (shown_) return seen(*shown_);
  if (!here_ && !at_end_) return std::nullopt;
  Where here{place_, here_ ? here_->unique_name() : "", at_end_};
  if (const auto next = place_.fired < 0 ? std::nullopt : next_activation(here_->engine())) {
    here.rule = next->rule;
    here.facts = next->facts;
  }
  return here;
}

/// The answer of `place` there; none if no recorded firing tells which rule comes next.
std::optional<Debugger::Where> Debugger::seen(Target target) const {
  const Visit& visit = visits_[target.visit];
  Where there{visit.place, visit.environment == kNoEnvironment ? selected_ : environment_names_[visit.environment]};
  if (there.environment.empty())
    if (const auto all = environments(); !all.empty()) there.environment = all.front()->unique_name();
  there.place.fired = target.fired;
  if (visit.place.fired < 0) return there;
  for (cx::Environment* environment : environments()) {
    if (environment->unique_name() != there.environment) continue;
    const inspect::Inspector inspector = inspect(*environment);
    const inspect::Timeline& timeline = inspector.timeline();
    const auto first = std::ranges::lower_bound(timeline.firings(), visit.next);
    if (timeline.firings().end() - first <= target.fired) return std::nullopt;
    const std::uint64_t n = first[target.fired];
    for (std::size_t later = target.visit + 1; later < passed_ && visits_[later].next <= n; ++later)
      if (visits_[later].environment == visit.environment) return std::nullopt;  // it fired in another run of the rules
    const JournalRecord firing = timeline.read(n);
    there.rule = std::string(firing.data.text("rule"));
    there.facts = explain::facts_of_firing(firing.data);
    return there;
  }
  return std::nullopt;
}

void Debugger::answer(const ControlLines::Line& line) {
  if (line.went) {
    if (options_.recorded) {
      left_ = gives_up_ = true;
      stopped_ = false;
    }
    return;
  }
  if (line.came) {
    lines_.send(line.client, json_text(Json{{"event", "hello"}, {"text", (stopped_ ? "stopped: " : "") + where()}}));
    return;
  }
  const Json request = parse_json(line.text);
  constexpr const char* kExpected =
      "expected {\"id\": N, \"line\": \"COMMAND\"}, {\"id\": N, \"complete\": \"BEGUN\"} or {\"id\": N, \"ask\": "
      "\"NAME\", ...}";
  const auto text_in = [&](const char* key) -> std::optional<std::string> {
    if (!request.is_object() || !request.contains(key) || !request[key].is_string()) return std::nullopt;
    return request[key].get<std::string>();
  };
  Json out{{"id", request.is_object() && request.contains("id") ? request["id"] : Json()}};
  const auto refuse = [&](const std::string& why) {
    out["ok"] = false;
    out["text"] = why;
    out["goes_on"] = false;
    lines_.send(line.client, json_text(out));
  };
  const auto play_up_to_here = [&] {
    then_ = line;
    go_to(here());
  };
  if (const auto name = text_in("ask"); name && request.contains("id")) {
    if (changed_) return play_up_to_here();
    const auto answer = ask(*name, request);
    if (!answer) return play_up_to_here();
    if (!*answer) return refuse(answer->error().text());
    out["ok"] = true;
    out["answer"] = **answer;
    return lines_.send(line.client, json_text(out));
  }
  const auto command = text_in("line"), begun = text_in("complete");
  // First undo what a person evaluated. A question about the person's place is asked at that place.
  if (changed_ || time_is_there_ || (shown_ && asks_about_place(command.value_or("")))) return play_up_to_here();
  if (!request.is_object() || !request.contains("id") || !(command || begun)) return refuse(kExpected);
  if (begun) {
    out["words"] = completions(*begun);
  } else {
    const Answer done = carry_out(*command);
    out["ok"] = done.ok;
    out["text"] = done.text;
    out["goes_on"] = done.goes_on;
  }
  lines_.send(line.client, json_text(out));
}

void Debugger::line(const cx::LogLine& line) {
  if (options_.log) options_.log->line(line);
  if (!options_.recorded)
    lines_.send_all(json_text(Json{{"event", "log"},
                                   {"t", to_seconds(line.t)},
                                   {"level", std::string(to_string(line.level))},
                                   {"logger", std::string(line.logger)},
                                   {"text", std::string(line.text)}}));
  char begin[40];
  std::snprintf(begin, sizeof begin, "[%9.3f] ", to_seconds(line.t));
  log_.push_back(begin + ('[' + std::string(to_string(line.level))) + "] [" + std::string(line.logger) + "] " +
                 std::string(line.text));
  if (log_.size() > kLinesKept) log_.pop_front();
}

void Debugger::end(std::string_view how) {
  lines_.send_all(json_text(Json{{"event", "end"}, {"text", std::string(how)}}));
}

}  // namespace cxlab::lab
