#include "planner/happenings/moment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/ground/sorted.h"
#include "planner/search/split.h"

namespace cxlab::planner {

namespace {

constexpr double kMostFollowed = 5;    ///< copies of an action that are followed one by one where there are no more
constexpr std::int64_t kStepWork = 2;  ///< in pieces of Work::kNode
/// What a step spends for each pair of points, and for each action that may come next, in pieces of Work::kTimes.
constexpr std::int64_t kLooksOfPair = 20, kLooksOfCandidate = 4;

bool mentions_duration(const GroundAction& action, const GroundTask& task) {
  bool found = reads_duration(action);
  for (const GroundDuration& duration : action.duration) found = found || duration.at_end;
  for_each_condition(action, [&](const GroundCondition& condition) {
    for (const int c : condition.comparisons) found = found || task.comparisons[c].expression.mentions_duration();
  });
  for_each_effects(action, [&](const GroundEffects& effects) {
    for (const NumericEffect& effect : effects.numbers) found = found || effect.value.mentions_duration();
  });
  for (const ContinuousEffect& effect : action.continuous) found = found || effect.rate.mentions_duration();
  return found;
}

}  // namespace

Moments::Moments(const GroundTask& task, const Simulator& simulator, Budget& budget, Options options)
    : task_(task),
      simulator_(simulator),
      budget_(budget),
      touches_(task, Touches::kPointsOnly, options.relaxed || options.certain ? Touches::kCertain : Touches::kApart),
      options_(options) {
  ById<char> lasts(task.facts.size(), 1);  // nothing deletes it
  for (const GroundAction& action : task.actions)
    for_each_effects(action, [&](const GroundEffects& effects) {
      for (const int f : effects.remove) lasts[f] = 0;
    });
  for (const TimedEvent& event : task.events)
    for (const int f : event.effects.remove) lasts[f] = 0;
  ById<char> asked(task.facts.size(), 0);  // by an effect, which does not come about where the fact is gone
  for (const GroundAction& action : task.actions)
    for (const ConditionalEffects& conditional : action.conditional)
      for (const auto* condition : {&conditional.start, &conditional.over_all, &conditional.end})
        for (const int f : condition->facts) asked[f] = 1;
  for (std::size_t a = 0; a < task.actions.size(); ++a) {
    const GroundAction& action = task.actions[a];
    const bool chooses = action.stretch > 0 || action.aim >= 0;  // here all durations are open
    if (!chooses) candidates_.push_back(static_cast<int>(a));
    bool once = task.axioms.empty() && action.conditional.empty() && action.continuous.empty();
    for (const auto* effects : {&action.at_start, &action.at_end})
      once = once && effects->numbers.empty() &&
             std::ranges::all_of(effects->add, [&](int f) { return lasts[f] != 0; }) &&
             std::ranges::none_of(effects->remove, [&](int f) { return asked[f] != 0; });
    repeats_nothing_.push_back(once);
    reads_duration_.push_back(mentions_duration(action, task));
    most_at_once_.push_back(most_copies(action));
  }
  for (const Axiom& axiom : task.axioms) axioms_read_numbers_ |= !axiom.body.comparisons.empty();
}

namespace {

/// By how much effects change the gap of a comparison; none if that depends on more than the effects.
std::optional<double> change_of(const LinearForm& gap, const GroundEffects& effects) {
  double sum = 0;
  for (const NumericEffect& effect : effects.numbers) {
    const auto weight = std::ranges::find(gap.weights, effect.number, &std::pair<int, double>::first);
    if (weight == gap.weights.end()) continue;
    if (effect.kind != NumericEffect::Kind::kIncrease || !effect.value.is_constant()) return std::nullopt;
    sum += weight->second * effect.value.steps[0].value;
  }
  return sum;
}

}  // namespace

/// How many copies of `action` the gap of a comparison has room for at once, if each copy takes a part of the gap at
/// its start. Only the ends of actions may give back, and no more than they took; else the number is not known (none).
std::optional<double> Moments::room(const LinearForm& gap, const GroundAction& action) const {
  const auto touches = [&](int number) {
    return std::ranges::find(gap.weights, number, &std::pair<int, double>::first) != gap.weights.end();
  };
  for (const TimedEvent& event : task_.events)
    for (const NumericEffect& effect : event.effects.numbers)
      if (touches(effect.number)) return std::nullopt;
  for (const GroundAction& other : task_.actions) {
    for (const ContinuousEffect& effect : other.continuous)
      if (touches(effect.number)) return std::nullopt;
    for (const ConditionalEffects& conditional : other.conditional)
      for (const auto* effects : {&conditional.at_start, &conditional.at_end})
        for (const NumericEffect& effect : effects->numbers)
          if (touches(effect.number)) return std::nullopt;
    const std::optional<double> first = change_of(gap, other.at_start), last = change_of(gap, other.at_end);
    if (!first || !last || !(*first <= 0) || !(*first + *last <= 0)) return std::nullopt;
  }
  const double takes = -*change_of(gap, action.at_start);
  double all = gap.constant;
  for (const auto& [number, weight] : gap.weights) all += weight * task_.initial_numbers[number];
  return takes > 0 && std::isfinite(all) ? std::optional(std::max(0.0, std::floor(all / takes + kSlackInProofs)))
                                         : std::nullopt;
}

/// As many copies as its conditions over all leave room for may end at an instant at which as many begin. An action
/// that may take no time then has no conditions over all (ground.cpp).
int Moments::most_copies(const GroundAction& action) const {
  int most = std::numeric_limits<int>::max();
  for (const int c : action.over_all.comparisons) {
    const LinearForm& gap = task_.comparisons[c].linear;
    if (!gap.is_linear || gap.duration_weight != 0) continue;
    if (const std::optional<double> copies = room(gap, action); copies && *copies < kMostFollowed)
      most = std::min(most, 2 * static_cast<int>(*copies));
  }
  return most;
}

Moment Moments::initial() const {
  Moment moment;
  moment.state = simulator_.initial();
  moment.origin = moment.now = moment.zone.add_point();
  tidy(moment);
  return moment;
}

// ---- one step ------------------------------------------------------------------------------------------------------

bool Moments::conflict(const Moment::Recent& one, const Moment::Recent& other) const {
  const auto each = [this](const Moment::Recent& of, const auto& visit) {
    if (visit(touches_.of_happening(of.action))) return true;
    return std::ranges::any_of(of.fired, [&](int i) { return visit(touches_.of_conditional(of.action, i)); });
  };
  return each(one, [&](std::span<const Touch> mine) {
    return each(other, [&](std::span<const Touch> theirs) {
      return Touches::conflict_at_instant(mine, one.at_end, theirs, other.at_end);
    });
  });
}

bool Moments::keep_clear(Moment& moment, const Moment::Recent& happening) const {
  return std::ranges::all_of(moment.recent, [&](const Moment::Recent& recent) {
    return !conflict(happening, recent) ||
           (recent.point != happening.point && moment.zone.require(recent.point, happening.point, options_.separation));
  });
}

/// By number: whether it may change while time passes.
ById<char> Moments::changing_numbers(const Moment& moment) const {
  ById<char> changes(task_.numbers.size(), 0);
  for (const Moment::Running& running : moment.running)
    for (const ContinuousEffect& effect : task_.actions[running.action].continuous) changes[effect.number] = 1;
  return changes;
}

/// Whether a condition over all of a copy that is not followed holds now, or may: numbers that depend on times can do.
bool Moments::may_hold(const Moment& moment, const GroundCondition& over_all, const ById<char>& changes) const {
  for (const int f : over_all.facts)
    if (!is_set(moment.state.data(), f)) return false;
  for (const int c : over_all.comparisons) {
    const GroundExpression& expression = task_.comparisons[c].expression;
    bool moves = expression.mentions_duration();
    expression.for_each_number([&](int n) { moves = moves || changes[n] != 0; });
    if (moves) continue;
    const std::optional<TimedNumber> value = gap(moment, c, {});
    if (value && value->is_constant() && !accepts(c, value->constant)) return false;
  }
  return true;
}

/// Time passes: copies that are not followed run only where their conditions over all hold.
void Moments::let_beyond_pass(Moment& moment, const ById<char>& changes) const {
  moment.beyond.insert(moment.beyond.end(), moment.joining.begin(), moment.joining.end());
  moment.joining.clear();
  sort_unique(moment.beyond);
  std::erase_if(moment.beyond, [&](int action) { return !may_hold(moment, task_.actions[action].over_all, changes); });
}

/// Lets time pass until `point`; nothing happens in between. `ending`: the place of the step that ends then, or -1.
bool Moments::pass_to(Step& step, int point, int ending) const {
  Moment& moment = step.moment;
  if (!moment.zone.require(moment.now, point, 0)) return false;
  if (moment.next_event < static_cast<int>(task_.events.size()) &&  // which does not wait
      !moment.zone.require(point, moment.origin, -task_.events[moment.next_event].time))
    return false;
  for (std::size_t r = 0; r < moment.running.size(); ++r)
    if (static_cast<int>(r) != ending && !moment.zone.require(point, moment.running[r].end, 0)) return false;
  if (!moment.beyond.empty() || !moment.joining.empty()) let_beyond_pass(moment, changing_numbers(moment));
  std::vector<std::pair<int, TimedNumber>> rates;
  for (const Moment::Running& running : moment.running)
    for (const ContinuousEffect& effect : task_.actions[running.action].continuous) {
      const std::optional<TimedNumber> rate = evaluate(moment, effect.rate, duration(moment, running));
      if (!rate || !rate->is_constant()) return leave_out();
      if (std::isnan(rate->constant)) return false;
      if (rate->constant != 0) rates.emplace_back(effect.number, time_between(moment.now, point, rate->constant));
    }
  struct Held {
    const GroundCondition* condition;
    std::size_t running;
    std::vector<TimedNumber> before;
  };
  std::vector<Held> held;  // what counts while time passes
  const auto note = [&](const GroundCondition& condition, std::size_t running) {
    held.push_back({&condition, running, {}});
    for (const int c : condition.comparisons) {
      std::optional<TimedNumber> value = gap(moment, c, duration(moment, moment.running[running]));
      if (!value) return leave_out();
      held.back().before.push_back(*std::move(value));
    }
    return true;
  };
  for (std::size_t r = 0; r < moment.running.size(); ++r)
    if (!note(task_.actions[moment.running[r].action].over_all, r)) return false;
  std::vector<TimedNumber> of_axioms;
  if (axioms_read_numbers_ && !rates.empty())
    for (const Axiom& axiom : task_.axioms)
      for (const int c : axiom.body.comparisons) {
        const std::optional<TimedNumber> value = gap(moment, c, {});
        if (!value) return leave_out();
        of_axioms.push_back(*value);
      }
  for (Moment::Running& running : moment.running)  // effects whose condition over all is broken do not come about
    for (std::size_t i = 0; i < running.remembered.size(); ++i) {
      const GroundCondition& over_all = task_.actions[running.action].conditional[i].over_all;
      if (!running.remembered[i] || over_all.empty()) continue;
      const std::optional<bool> now = holds(step, over_all, duration(moment, running));
      if (!now) return false;
      running.remembered[i] = *now;
    }
  for (const auto& [number, change] : rates) set_number(moment, number, plus(this->number(moment, number), change, 1));
  if (!of_axioms.empty()) {
    std::size_t next = 0;
    for (const Axiom& axiom : task_.axioms)
      for (const int c : axiom.body.comparisons) {
        const std::optional<TimedNumber> after = gap(moment, c, {});
        if (!after) return leave_out();
        const TimedNumber& before = of_axioms[next++];
        if (before == *after) continue;
        const std::optional<int> first = sign(step, before), second = first ? sign(step, *after) : first;
        if (!second) return false;
        if (*first != *second) return leave_out();  // a derived fact may change while nothing happens
      }
    if (!derive(step)) return false;
  }
  for (const Held& each : held) {
    const TimedNumber lasts = duration(moment, moment.running[each.running]);
    for (std::size_t i = 0; i < each.condition->comparisons.size(); ++i) {
      const int c = each.condition->comparisons[i];
      const std::optional<TimedNumber> after = gap(moment, c, lasts);
      if (!after) return leave_out();
      const TimedNumber& before = each.before[i];
      if (before.is_constant() && after->is_constant()) {
        if (!accepts(c, before.constant) || !accepts(c, after->constant)) return false;
        continue;
      }
      // Linear in between, so that both ends decide; a value above 0 may begin or end at 0.
      const auto at_ends = task_.comparisons[c].kind == GroundComparison::Kind::kZero
                               ? GroundComparison::Kind::kZero
                               : GroundComparison::Kind::kNotNegative;
      if (!demand(moment, {before, at_ends}) || !demand(moment, {*after, at_ends})) return false;
      if (task_.comparisons[c].kind == GroundComparison::Kind::kPositive &&
          !demand(moment, {plus(before, *after, 1), GroundComparison::Kind::kPositive}))
        return false;
    }
    for (const int f : each.condition->facts)
      if (!is_set(moment.state.data(), f)) return false;
  }
  for (Moment::Running& running : moment.running)
    for (std::size_t i = 0; i < running.remembered.size(); ++i) {
      const GroundCondition& over_all = task_.actions[running.action].conditional[i].over_all;
      if (!running.remembered[i] || over_all.comparisons.empty()) continue;
      const std::optional<bool> still = holds(step, over_all, duration(moment, running));
      if (!still) return false;
      running.remembered[i] = *still;
    }
  moment.now = point;
  return true;
}

/// What the durations of an action allow, as far as it is known at its start or at its end.
bool Moments::limit_duration(Moment& moment, const Moment::Running& running, bool at_end) const {
  for (const GroundDuration& limit : task_.actions[running.action].duration) {
    if (limit.at_end != at_end) continue;
    const std::optional<TimedNumber> bound = evaluate(moment, limit.bound, {});
    if (!bound) return leave_out();
    if (std::isnan(bound->constant)) return false;
    if (limit.comparison == Comparison::kLessEqual && bound->constant >= kLongestTime) continue;  // none
    if (limit.comparison == Comparison::kGreaterEqual && bound->constant <= -kLongestTime) continue;
    if (!(std::abs(bound->constant) < kLongestTime)) return false;
    const TimedNumber length = time_between(running.start, running.end);
    const TimedNumber over = plus(length, *bound, -1);
    const auto not_negative = GroundComparison::Kind::kNotNegative;
    const bool exact = limit.comparison == Comparison::kEqual;
    if (limit.comparison != Comparison::kLessEqual && limit.comparison != Comparison::kGreaterEqual && !exact)
      return false;
    if (exact && bound->is_constant() && !options_.relaxed) {
      const Micros micros = in_micros(bound->constant);
      if (!moment.zone.require(running.start, running.end, micros) ||
          !moment.zone.require(running.end, running.start, -micros))
        return false;
    } else if (exact ? !demand(moment, {over, GroundComparison::Kind::kZero})
                     : !demand(moment,
                               {limit.comparison == Comparison::kLessEqual ? scaled(over, -1) : over, not_negative})) {
      return false;
    }
  }
  return true;
}

bool Moments::apply(Step& step, const GroundEffects& effects, const TimedNumber& duration) const {
  Moment& moment = step.moment;
  std::vector<TimedNumber> values;  // all are read before one is changed
  for (const NumericEffect& effect : effects.numbers) {
    const std::optional<TimedNumber> value = evaluate(moment, effect.value, duration);
    if (!value) return leave_out();
    if (std::isnan(value->constant)) return false;
    values.push_back(*value);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const NumericEffect& effect = effects.numbers[i];
    TimedNumber value = number(moment, effect.number);
    if (effect.kind == NumericEffect::Kind::kAssign) {
      value = values[i];
    } else if (effect.kind == NumericEffect::Kind::kIncrease) {
      value = plus(value, values[i], 1);
    } else if (value.is_constant() || values[i].is_constant()) {
      value = value.is_constant() ? scaled(values[i], value.constant) : scaled(value, values[i].constant);
    } else {
      return leave_out();
    }
    if (!std::isfinite(value.constant)) return false;
    set_number(moment, effect.number, std::move(value));
  }
  for (const int f : effects.remove) reset(moment.state.data(), f);
  for (const int f : effects.add) set(moment.state.data(), f);
  return true;
}

namespace {

void append(const GroundEffects& more, GroundEffects& to) {
  to.add.insert(to.add.end(), more.add.begin(), more.add.end());
  to.remove.insert(to.remove.end(), more.remove.begin(), more.remove.end());
  to.numbers.insert(to.numbers.end(), more.numbers.begin(), more.numbers.end());
}

/// Among several alike only the last one counts: a distance from it is also a distance from those before.
void note(Moment& moment, Moment::Recent happening) {
  std::erase_if(moment.recent, [&](const Moment::Recent& recent) {
    return recent.action == happening.action && recent.at_end == happening.at_end && recent.fired == happening.fired;
  });
  moment.recent.push_back(std::move(happening));
}

}  // namespace

bool Moments::start(Step& step, const Happening& happening) const {
  Moment& moment = step.moment;
  const GroundAction& action = task_.actions[happening.index];
  if (happening.beyond && (!action.continuous.empty() || reads_duration_[happening.index])) return leave_out();
  Moment::Running running{happening.index, moment.now, moment.now, {}};
  if (!happening.at_once) {
    running.start = moment.zone.add_point();
    if (!pass_to(step, running.start, -1)) return false;
  }
  Moment::Recent recent{happening.index, false, running.start, {}};
  if (!keep_clear(moment, recent)) return false;
  const bool lasts = action.durative && !happening.beyond;
  if (lasts) {
    running.end = moment.zone.add_point();
    if (!moment.zone.require(running.start, running.end, 0) || !limit_duration(moment, running, false)) return false;
  }
  const TimedNumber length = lasts ? duration(moment, running) : TimedNumber{};
  if (!demand(moment, action.start, length)) return false;
  GroundEffects all = action.at_start;
  for (const ConditionalEffects& conditional : action.conditional) {
    const std::optional<bool> fires = holds(step, conditional.start, length);
    if (!fires) return false;
    if (*fires && !conditional.at_start.empty()) recent.fired.push_back(static_cast<int>(running.remembered.size()));
    running.remembered.push_back(*fires);
    if (*fires) append(conditional.at_start, all);
  }
  if (!recent.fired.empty() && !keep_clear(moment, recent)) return false;
  if (options_.keep_everything) {
    DurationRange range{0, 0};
    if (lasts) range = {moment.zone.least(running.start, running.end), moment.zone.most(running.start, running.end)};
    moment.steps.push_back({happening.index, running.start, lasts ? running.end : running.start, range});
  }
  if (!apply(step, all, length)) return false;
  note(moment, std::move(recent));
  if (happening.beyond) {
    std::vector<int>& into = constant_durations(action).least > 0 ? moment.joining : moment.beyond;
    if (!contains(into, happening.index)) into.insert(std::ranges::lower_bound(into, happening.index), happening.index);
    return true;
  }
  if (lasts)
    moment.running.insert(std::ranges::upper_bound(moment.running, running.action, {}, &Moment::Running::action),
                          std::move(running));
  return true;
}

bool Moments::end(Step& step, const Happening& happening) const {
  Moment& moment = step.moment;
  if (happening.beyond) {
    const GroundAction& action = task_.actions[happening.index];
    if (!happening.at_once && !pass_to(step, moment.zone.add_point(), -1)) return false;
    if (!contains(moment.beyond, happening.index)) return false;  // none of them ran until now
    Moment::Recent recent{happening.index, true, moment.now, {}};
    if (!keep_clear(moment, recent) || !demand(moment, action.end, {})) return false;
    GroundEffects all = action.at_end;
    for (std::size_t i = 0; i < action.conditional.size(); ++i) {
      const ConditionalEffects& conditional = action.conditional[i];
      if (conditional.at_end.empty()) continue;
      if (!conditional.start.empty() || !conditional.over_all.empty()) return leave_out();
      const std::optional<bool> fires = holds(step, conditional.end, {});
      if (!fires) return false;
      if (!*fires) continue;
      recent.fired.push_back(static_cast<int>(i));
      append(conditional.at_end, all);
    }
    if (!recent.fired.empty() && !keep_clear(moment, recent)) return false;
    note(moment, std::move(recent));
    return apply(step, all, {});
  }
  const int point = moment.running[static_cast<std::size_t>(happening.index)].end;
  if (happening.at_once ? !moment.zone.require(point, moment.now, 0) : !pass_to(step, point, happening.index))
    return false;
  const Moment::Running running = moment.running[static_cast<std::size_t>(happening.index)];
  moment.running.erase(moment.running.begin() + happening.index);
  Moment::Recent recent{running.action, true, moment.now, {}};
  if (!keep_clear(moment, recent) || !limit_duration(moment, running, true)) return false;
  const GroundAction& action = task_.actions[running.action];
  const TimedNumber length = duration(moment, running);
  if (!demand(moment, action.end, length)) return false;
  GroundEffects all = action.at_end;
  for (std::size_t i = 0; i < action.conditional.size(); ++i) {
    if (!running.remembered[i] || action.conditional[i].at_end.empty()) continue;
    const std::optional<bool> fires = holds(step, action.conditional[i].end, length);
    if (!fires) return false;
    if (!*fires) continue;
    recent.fired.push_back(static_cast<int>(i));
    append(action.conditional[i].at_end, all);
  }
  if (!recent.fired.empty() && !keep_clear(moment, recent)) return false;
  note(moment, std::move(recent));
  return apply(step, all, length);
}

bool Moments::event(Step& step, const Happening& happening) const {
  Moment& moment = step.moment;
  const int point = happening.at_once ? moment.now : moment.zone.add_point();
  const TimedEvent& event = task_.events[happening.index];
  if (!moment.zone.require(moment.origin, point, event.time) || !moment.zone.require(point, moment.origin, -event.time))
    return false;
  if (!happening.at_once && !pass_to(step, point, -1)) return false;
  Moment::Recent recent{-2 - happening.index, false, point, {}};
  if (!keep_clear(moment, recent)) return false;
  note(moment, std::move(recent));
  ++moment.next_event;
  return apply(step, event.effects, {});
}

int Moments::rank(const Happening& happening, const Moment& moment) const {
  if (happening.kind == Happening::Kind::kEvent) return 0;
  if (happening.kind == Happening::Kind::kStart) return 1 + happening.index;
  const int action =
      happening.beyond ? happening.index : moment.running[static_cast<std::size_t>(happening.index)].action;
  return 1 + static_cast<int>(task_.actions.size()) + action;
}

bool Moments::step(Moment& moment, const Happening& happening, const Signs& signs, bool& open) const {
  budget_.spend(Work::kNode, kStepWork);
  budget_.spend(Work::kTimes, kLooksOfPair * moment.zone.points() * moment.zone.points());
  moment.last = rank(happening, moment);
  Step step{moment, signs, 0, false};
  bool taken = happening.kind == Happening::Kind::kStart ? start(step, happening)
               : happening.kind == Happening::Kind::kEnd ? end(step, happening)
                                                         : event(step, happening);
  taken = taken && derive(step);
  open = step.open;
  if (!taken || step.used < signs.size() || !tidy(moment)) return false;
  judge(moment);
  return true;
}

/// Whether time may pass after what has happened so far, or more must happen at this instant.
void Moments::judge(Moment& moment) const {
  moment.may_pass = true;
  moment.may_join = false;
  const ById<char> changes = changing_numbers(moment);
  for (std::size_t n = 0; n < changes.size(); ++n)
    if (changes[n] && std::isnan(number(moment, static_cast<int>(n)).constant)) moment.may_pass = false;
  for (const Moment::Running& running : moment.running) {
    const GroundCondition& over_all = task_.actions[running.action].over_all;
    for (const int f : over_all.facts)
      if (!is_set(moment.state.data(), f)) moment.may_pass = false;
    for (const int c : over_all.comparisons) {
      const std::optional<TimedNumber> value = gap(moment, c, duration(moment, running));
      bool moves = !value || !value->is_constant();
      task_.comparisons[c].expression.for_each_number([&](int n) { moves = moves || changes[n] != 0; });
      if (moves)
        moment.may_join = true;
      else if (!accepts(c, value->constant))
        moment.may_pass = false;
    }
  }
  // Copies that are not followed may end at the instant at which their conditions over all stop to hold, or begin at
  // the one at which these begin to hold.
  for (const auto* actions : {&moment.beyond, &moment.joining})
    for (const int action : *actions)
      if (!may_hold(moment, task_.actions[action].over_all, changes)) moment.may_join = true;
  if (!moment.may_pass) moment.may_join = true;
}

// ---- what may come next --------------------------------------------------------------------------------------------

/// Whether starting an action is needless: all lasting changes that it makes are made already or come from a running
/// action.
bool Moments::is_needless(const Moment& moment, int action) const {
  if (!repeats_nothing_[action]) return false;
  const GroundAction& each = task_.actions[action];
  const auto is_true = [&](int f) { return is_set(moment.state.data(), f); };
  if (!std::ranges::all_of(each.at_start.add, is_true)) return false;
  if (std::ranges::all_of(each.at_end.add, is_true)) return true;
  // Two copies of one fixed duration end in the order in which they began.
  const DurationRange range = constant_durations(each);
  return range.least == range.most &&
         std::ranges::find(moment.running, action, &Moment::Running::action) != moment.running.end();
}

std::vector<Happening> Moments::happenings(const Moment& moment) const {
  budget_.spend(Work::kTimes, kLooksOfCandidate * static_cast<std::int64_t>(candidates_.size()));
  std::vector<Happening> found;
  for (const bool at_once : {false, true}) {
    if (at_once ? !moment.may_join : !moment.may_pass) continue;
    const auto offer = [&](Happening happening) {
      happening.at_once = at_once;
      if (!at_once || rank(happening, moment) >= moment.last) found.push_back(happening);
    };
    for (std::size_t r = 0; r < moment.running.size(); ++r) offer({Happening::Kind::kEnd, static_cast<int>(r)});
    for (const int action : moment.beyond) offer({Happening::Kind::kEnd, action, false, true});
    if (moment.next_event < static_cast<int>(task_.events.size())) offer({Happening::Kind::kEvent, moment.next_event});
    for (const int action : candidates_) {
      const auto is_true = [&](int f) { return is_set(moment.state.data(), f); };
      if (!std::ranges::all_of(task_.actions[action].start.facts, is_true) || is_needless(moment, action)) continue;
      const auto copies = std::ranges::count(moment.running, action, &Moment::Running::action);
      if (copies >= most_at_once_[action]) continue;
      const bool few = most_at_once_[action] < std::numeric_limits<int>::max();
      if (copies < options_.copies || (options_.relaxed && few))
        offer({Happening::Kind::kStart, action});
      else if (options_.relaxed)
        offer({Happening::Kind::kStart, action, false, true});
      else
        capped_ = true;
    }
  }
  return found;
}

std::optional<Moment> Moments::at_goal(const Moment& moment) const {
  if (!moment.running.empty()) return std::nullopt;
  if (moment.next_event == static_cast<int>(task_.events.size())) {
    std::optional<Moment> last = moment;
    if (!demand(*last, task_.goal, {}) || (!last->demands.empty() && !solve(*last, -1))) last.reset();
    return last;
  }
  std::optional<Moment> reached;
  each_after(moment, {Happening::Kind::kEvent, moment.next_event}, [&](const Moment& after, const Signs&) {
    if (!reached) reached = at_goal(after);
  });
  return reached;
}

}  // namespace cxlab::planner
