#include "lab/control/debugger.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "cx/base/json_text.h"

namespace cxlab::lab {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLinesKept = 10'000;  // of the log, for those who come late

std::string seconds(SimTime t) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", to_seconds(t));
  return text;
}

bool names(const std::string& wanted, const ActivationInfo& activation) {
  return wanted == activation.rule || wanted == activation.module + "::" + activation.rule;
}

}  // namespace

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
  return options_.recorded || pause_ || steps_ > 0 ||
         std::any_of(breaks_.begin(), breaks_.end(),
                     [](const BreakPoint& b) { return b.kind != BreakPoint::Kind::kTime; });
}

Status Debugger::stop_at(cx::Environment& environment, const cx::ControlPlace& place) {
  if (gives_up_) return {};
  here_ = &environment;
  place_ = place;
  if (options_.recorded)
    visits_.push_back({place.t, environment.name_in_log(), inspect_(environment).timeline().end()});
  if (const auto why = reason_to_stop(environment, place)) {
    std::erase_if(breaks_, [](const BreakPoint& point) { return point.once; });
    ticks_ = steps_ = 0;
    stopped_ = true;
    if (then_)
      answer(*std::exchange(then_, std::nullopt));
    else
      lines_.send_all(json_text(Json{{"event", "stopped"}, {"text", *why + ": " + where()}}));
    if (!noted_ && !options_.recorded)
      options_.note("stopped at " + seconds(place.t) + "; cxlab attach " + options_.address);
    noted_ = true;
    stay(environment);
    stopped_ = pause_ = false;
  } else if (!options_.recorded) {
    while (auto line = lines_.take()) answer(*line);
  }
  here_ = nullptr;
  return {};
}

void Debugger::stay(cx::Environment&) {
  options_.waits(true);
  constexpr auto kSlice = std::chrono::milliseconds(50);
  while (stopped_ && !options_.over())
    if (auto line = lines_.take(kSlice)) answer(*line);
  options_.waits(false);
}

std::optional<std::string> Debugger::reason_to_stop(cx::Environment& environment, const cx::ControlPlace& place) {
  if (target_) {
    if (visits_.size() - 1 != *target_) return {};
    target_.reset();
    return "at";
  }
  if (!selected_.empty() && environment.name_in_log() != selected_) return {};
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
  visits_.clear();
  log_.clear();
  here_ = nullptr;
  stopped_ = pause_ = changed_ = at_end_ = gives_up_ = false;
  for (BreakPoint& point : breaks_) {
    point.held.clear();
    point.passed = false;
  }
}

void Debugger::go_to(std::size_t visit) {
  target_ = visit;
  gives_up_ = true;
  stopped_ = false;
}

void Debugger::stay_at_end(SimTime t, const Status& how) {
  const std::vector<cx::Environment*> all = environments_();
  if (all.empty()) return lines_.send_all(json_text(Json{{"event", "end"}, {"text", "the run has no environment"}}));
  here_ = all.front();
  for (cx::Environment* one : all)
    if (one->name_in_log() == selected_) here_ = one;
  place_ = {t, 0, -1};
  at_end_ = stopped_ = true;
  ticks_ = steps_ = 0;
  target_.reset();
  std::erase_if(breaks_, [](const BreakPoint& point) { return point.once; });
  if (then_)
    answer(*std::exchange(then_, std::nullopt));
  else
    lines_.send_all(json_text(Json{{"event", "stopped"}, {"text", where() + (how ? "" : ": " + how.error().text())}}));
  stay(*here_);
}

bool Debugger::fires_at(std::size_t visit) const {
  for (cx::Environment* environment : environments_()) {
    if (environment->name_in_log() != visits_[visit].environment) continue;
    const inspect::Timeline& timeline = inspect_(*environment).timeline();
    return timeline.has(visits_[visit].next) && timeline.kind(visits_[visit].next) == RecordKind::kFire;
  }
  return false;
}

std::string Debugger::where() const {
  if (!here_) return "running";
  if (at_end_) return "at the end of the run, " + seconds(place_.t);
  std::string text = here_->name_in_log() + " at " + seconds(place_.t);
  if (place_.fired < 0) return text + ", at the beginning of a tick";
  const auto next = next_activation(here_->engine());
  if (!next) return text + ", no rule is on its agenda";
  text += ", before rule " + next->rule + " (salience " + std::to_string(next->salience) + ") fires for";
  for (const std::int64_t fact : next->facts) text += fact < 0 ? " *" : " f-" + std::to_string(fact);
  return text;
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
  if (changed_) {  // what was evaluated is undone first
    then_ = line;
    return go_to(here_ && !at_end_ ? visits_.size() - 1 : kEnd);
  }
  const Json request = Json::parse(line.text, nullptr, false);
  const auto refuse = [&](const std::string& why) {
    lines_.send(line.client,
                json_text(Json{{"id", request.is_object() && request.contains("id") ? request["id"] : Json()},
                               {"ok", false},
                               {"text", why},
                               {"goes_on", false}}));
  };
  if (!request.is_object() || !request.contains("id")) return refuse("expected {\"id\": N, \"line\": \"COMMAND\"}");
  Json out{{"id", request["id"]}};
  if (const auto begun = request.find("complete"); begun != request.end() && begun->is_string()) {
    out["words"] = completions(begun->get<std::string>());
  } else if (const auto command = request.find("line"); command != request.end() && command->is_string()) {
    const Answer done = carry_out(command->get<std::string>());
    out["ok"] = done.ok;
    out["text"] = done.text;
    out["goes_on"] = done.goes_on;
  } else {
    return refuse("expected {\"id\": N, \"line\": \"COMMAND\"}");
  }
  lines_.send(line.client, json_text(out));
}

void Debugger::line(const cx::LogLine& line) {
  if (options_.log) options_.log->line(line);
  const Json event{{"event", "log"},
                   {"t", to_seconds(line.t)},
                   {"level", std::string(to_string(line.level))},
                   {"logger", std::string(line.logger)},
                   {"text", std::string(line.text)}};
  if (!options_.recorded) lines_.send_all(json_text(event));
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
