#include "cx/testing/step_story.h"

#include <algorithm>

#include "cx/explain/pattern.h"
#include "cx/testing/judge.h"
#include "cx/testing/play.h"

namespace cxlab::testing {

struct Story::State {
  State(StorySpec given_spec, StorySetup given_setup, Report given_report)
      : spec(std::move(given_spec)), setup(std::move(given_setup)), report(std::move(given_report)) {}

  StorySpec spec;
  StorySetup setup;
  Report report;
  Play play{spec, setup, /*each_tick=*/true};
  Where begun;
  bool usable = false;
  SimTime patience = std::chrono::seconds(10);
  std::vector<bool> met;         // goals heard, by their place
  std::vector<FactCopy> looked;  // at last by `find`

  void check(const Status& status, const Where& where) {
    if (!status) report(where, status.error().text());
  }
  void open(const Where& where) {
    begun = where;
    Status s = play.prepare();
    if (s) s = play.begin();
    usable = s.ok();
    check(s, where);
  }
  /// Time of the tick that comes next.
  SimTime now() { return usable ? play.loop().next_tick() : SimTime::zero(); }
  /// Time goes on until `done`, at most until `until`.
  template <typename Done>
  bool wait(SimTime until, const Where& where, const Done& done) {
    while (usable) {
      if (done()) return true;
      if (now() > until) return false;
      const Status s = play.loop().tick();
      usable = s.ok();
      check(s, where);
    }
    return true;  // what is wrong has been reported
  }
  const FactCopy* find(const explain::Pattern& pattern) {
    looked = play.engine().facts(pattern.template_name());
    const auto at = std::find_if(looked.begin(), looked.end(), [&](const FactCopy& f) { return pattern.matches(f); });
    return at == looked.end() ? nullptr : &*at;
  }
  void end_goal(const std::string& action, Outcome::Kind kind, const std::string& result, const Where& where) {
    if (!usable) return;
    Outcome outcome;
    outcome.kind = kind;
    outcome.result = result;
    const auto ended = play.stand_ins().end_goal(action, outcome);
    if (!ended)
      report(where, ended.error().text());
    else if (!*ended)
      report(where, action + " has taken no goal that it could end");
  }
};

Story::Story(StorySpec spec, StorySetup setup, Report report, Where where)
    : state_(std::make_unique<State>(std::move(spec), std::move(setup), std::move(report))) {
  if (state_->spec.file.empty()) state_->spec.file = where.file_name();
  state_->open(where);
}

Story::~Story() {
  if (state_->usable) state_->check(state_->play.manager().deactivate(), state_->begun);
}

void Story::skill(const std::string& action, const std::string& type, Where where) {
  StandIn stand_in{true, action, type, {Outcome{}}, where.file_name(), static_cast<int>(where.line())};
  stand_in.outcomes.front().kind = Outcome::Kind::kNever;
  if (state_->usable) state_->check(state_->play.stand_ins().add(stand_in), where);
}

void Story::given(const std::string& fact, Where where) {
  if (!state_->usable) return;
  const Status s = state_->play.assert_fact(fact, static_cast<int>(where.line()));
  if (!s) state_->play.engine().take_errors();  // reported here, not by the next run
  state_->check(s, where);
}

void Story::pass(double seconds, Where where) {
  state_->wait(state_->now() + from_seconds(seconds) - kTick, where, [] { return false; });
}

void Story::expect_command(const std::string& robot, const std::string& skill, const std::string& target, Where where) {
  const std::string action = '/' + robot + '/' + skill;
  std::string others;
  const bool came = state_->wait(state_->now() + state_->patience, where, [&] {
    const std::vector<Heard>& heard = state_->play.stand_ins().heard();
    state_->met.resize(heard.size());
    others.clear();
    for (std::size_t i = 0; i < heard.size(); ++i) {
      if (heard[i].kind != Heard::Kind::kGoal || state_->met[i]) continue;
      if (heard[i].name == action && contains(heard[i].content, "{target: '" + target + "'}"))
        return static_cast<bool>(state_->met[i] = true);
      others += (others.empty() ? "" : ", ") + heard[i].name + ' ' + heard[i].content + " at " + seconds(heard[i].t);
    }
    return false;
  });
  if (!came)
    state_->report(where, "expected " + action + " for " + target + " by " + seconds(state_->now()) + "; " +
                              (others.empty() ? "no other goal came" : "there came " + others));
}

void Story::expect_fact(const std::string& text, Where where) {
  const auto pattern = explain::Pattern::parse_plain(text, where.file_name(), static_cast<int>(where.line()));
  if (!pattern) return state_->report(where, pattern.error().text());
  if (state_->wait(state_->now() + state_->patience, where, [&] { return state_->find(*pattern) != nullptr; })) return;
  std::string what = "expected fact " + text + " by " + seconds(state_->now());
  for (const FactCopy& copy : state_->looked)
    what += "\n  there is " + copy.print() + ": " + explain::print(pattern->mismatches(copy));
  state_->report(where, what);
}

void Story::expect_no_fact(const std::string& text, Where where) {
  const auto pattern = explain::Pattern::parse_plain(text, where.file_name(), static_cast<int>(where.line()));
  if (!pattern) return state_->report(where, pattern.error().text());
  if (!state_->usable) return;
  if (const FactCopy* fact = state_->find(*pattern))
    state_->report(where, "expected no fact " + text + "; there is " + fact->print());
  else if (!state_->play.engine().has("deftemplate", pattern->template_name()))
    state_->report(where, "there is no template '" + pattern->template_name() + "', so this says nothing");
}

void Story::skill_succeeds(const std::string& robot, const std::string& skill, Where where) {
  state_->end_goal('/' + robot + '/' + skill, Outcome::Kind::kSucceed, {}, where);
}

void Story::skill_fails(const std::string& robot, const std::string& skill, int error_code, Where where) {
  state_->end_goal('/' + robot + '/' + skill, Outcome::Kind::kFail, "{error_code: " + std::to_string(error_code) + '}',
                   where);
}

void Story::set_patience(double seconds) { state_->patience = from_seconds(seconds); }
double Story::now_s() const { return to_seconds(state_->now()); }

}  // namespace cxlab::testing
