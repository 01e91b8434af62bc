#include "planner/happenings/happening_search.h"

#include <algorithm>
#include <bit>

namespace cxlab::planner {

namespace {

constexpr int kUnlikely = 1 << 12;        ///< estimate of what seems to be a dead end
constexpr std::int64_t kLooksOfZone = 8;  ///< of finding a zone that is known, in pieces of Work::kTimes
constexpr std::size_t kNodeWords = 60;    ///< of memory, beside the moment

}  // namespace

HappeningSearch::HappeningSearch(const GroundTask& task, const Simulator& simulator, Budget& budget,
                                 const Options& options)
    : task_(task),
      simulator_(simulator),
      budget_(budget),
      options_(options),
      moments_(task, simulator, budget, options.moments),
      loose_(task),
      heuristic_(loose_.heuristic()) {}

std::vector<Word> HappeningSearch::key(const Moment& moment) const {
  const int words = options_.all_numbers ? simulator_.words() : simulator_.significant_words();
  std::vector<Word> key(moment.state.begin(), moment.state.begin() + words);
  const auto add = [&key](std::integral auto value) {
    key.push_back(static_cast<Word>(static_cast<std::int64_t>(value)));
  };
  const auto add_number = [&](const TimedNumber& value) {
    key.push_back(std::bit_cast<Word>(value.constant));
    add(value.weights.size());
    for (const auto& [point, weight] : value.weights) {
      add(point);
      key.push_back(std::bit_cast<Word>(weight));
    }
  };
  add(moment.next_event);
  add(moment.origin);
  add(moment.now);
  add(moment.may_join ? moment.last : -1);
  add(moment.running.size());
  for (const Moment::Running& running : moment.running) {
    for (const int each : {running.action, running.start, running.end}) add(each);
    for (const char held : running.remembered) add(held);
  }
  add(moment.beyond.size());
  for (const int action : moment.beyond) add(action);
  add(moment.joining.size());
  for (const int action : moment.joining) add(action);
  for (const Moment::Recent& recent : moment.recent) {
    for (const int each : {recent.action, static_cast<int>(recent.at_end), recent.point}) add(each);
    add(recent.fired.size());
    for (const int effect : recent.fired) add(effect);
  }
  for (const auto& [number, value] : moment.varying) {
    add(number);
    add_number(value);
  }
  for (const TimedDemand& demand : moment.demands) {
    add(static_cast<int>(demand.kind));
    add_number(demand.value);
  }
  return key;
}

int HappeningSearch::estimate(const Moment& moment) {
  ById<double> numbers(simulator_.numbers(moment.state.data()),
                       simulator_.numbers(moment.state.data()) + task_.numbers.size());
  for (const auto& [number, value] : moment.varying) {
    numbers[number] = value.constant;
    for (const auto& [point, weight] : value.weights)
      numbers[number] += weight * in_seconds(moment.zone.least(moment.origin, point));
  }
  std::vector<LooseEstimate::Running> running;
  for (const Moment::Running& each : moment.running) {
    const Micros left = moment.zone.least(moment.now, each.end);
    const DurationRange range = constant_durations(task_.actions[each.action]);
    running.push_back({each.action, left, std::max(left, range.least)});
  }
  for (const auto* actions : {&moment.beyond, &moment.joining})
    for (const int action : *actions) running.push_back({action, {}, 0});
  const int found = loose_.evaluate(heuristic_, moment.state.data(), numbers.data(), moment.next_event, running);
  return found == RelaxedHeuristic::kDeadEnd ? kUnlikely : std::min(found, kUnlikely);
}

bool HappeningSearch::too_late(const Moment& moment, Micros before) const {
  if (before >= DurationRange::kForever || moment.origin < 0) return false;
  return moment.zone.least(moment.origin, moment.now) >= before ||
         std::ranges::any_of(moment.running, [&](const Moment::Running& running) {
           return moment.zone.least(moment.origin, running.end) >= before;
         });
}

/// Takes the same steps with all points kept.
std::optional<HappeningPlan> HappeningSearch::plan_of(const Node& node) const {
  std::vector<const Node*> path = {&node};
  for (int at = node.parent; at > 0; at = nodes_[at].parent) path.push_back(&nodes_[at]);
  if (node.parent < 0) path.clear();
  std::ranges::reverse(path);
  Moments::Options how = options_.moments;
  how.keep_everything = true;
  const Moments moments(task_, simulator_, budget_, how);
  Moment moment = moments.initial();
  bool orders_are_enough = true;
  Concurrent partial;
  std::vector<int> step_of;  // by place in Moment::running
  for (const Node* taken : path) {
    const Happening& happening = taken->happening;
    bool open = false;
    const std::size_t place = static_cast<std::size_t>(happening.index);
    if (happening.kind == Happening::Kind::kEnd) {
      partial.order.push_back({SplitPoint::Kind::kEnd, step_of[place]});
      step_of.erase(step_of.begin() + happening.index);
    } else if (happening.kind == Happening::Kind::kEvent) {
      partial.order.push_back({SplitPoint::Kind::kEvent, happening.index});
    }
    if (!moments.step(moment, happening, taken->signs, open)) return std::nullopt;
    orders_are_enough = orders_are_enough && !happening.at_once && taken->signs.empty() && moment.varying.empty();
    if (happening.kind != Happening::Kind::kStart) continue;
    const int step = static_cast<int>(moment.steps.size()) - 1;
    const Moment::Noted& noted = moment.steps.back();
    const GroundAction& action = task_.actions[noted.action];
    // What several others together must keep true all along depends on the times of all of them.
    const bool holds_facts = action.over_all.comparisons.empty() &&
                             std::ranges::none_of(action.over_all.facts, [&](int f) { return task_.facts[f].derived; });
    orders_are_enough =
        orders_are_enough && holds_facts && !moments.reads_duration(noted.action) && action.continuous.empty();
    DurationRange range = noted.range;
    if (action.durative && range.most < kSeparation) orders_are_enough = false;
    if (action.durative) range.least = std::max(range.least, kSeparation);
    partial.steps.push_back({noted.action, range});
    partial.order.push_back({SplitPoint::Kind::kBegin, step});
    if (!action.durative) {
      partial.order.push_back({SplitPoint::Kind::kEnd, step});
      continue;
    }
    const auto where = std::ranges::find(moment.running, noted.end, &Moment::Running::end) - moment.running.begin();
    step_of.insert(step_of.begin() + where, step);
  }
  const int last = moment.now;
  const std::optional<Moment> at_goal = moments.at_goal(moment);
  const std::optional<ById<Micros>> times = at_goal ? moments.times(*at_goal, last) : std::nullopt;
  if (!times) return std::nullopt;
  HappeningPlan plan;
  for (const Moment::Noted& noted : at_goal->steps)
    plan.steps.push_back({noted.action, (*times)[noted.start], (*times)[noted.end]});
  std::ranges::stable_sort(plan.steps, {}, &ClockStep::start);
  if (orders_are_enough) plan.partial = std::move(partial);
  return plan;
}

/// Whether it is a plan that was accepted.
bool HappeningSearch::add(Node node, Micros before, const std::function<bool(const HappeningPlan&)>& accept) {
  const Moment& moment = node.moment;
  if (too_late(moment, before)) return false;
  std::vector<Word> name = key(moment);
  const std::size_t size = 2 * name.size() + 2 * static_cast<std::size_t>(moment.zone.points() * moment.zone.points());
  std::vector<Zone>& zones = known_[std::move(name)];
  const std::int64_t pairs = std::int64_t{moment.zone.points()} * moment.zone.points();
  budget_.spend(Work::kTimes, static_cast<std::int64_t>(zones.size()) * (kLooksOfZone + pairs));
  if (std::ranges::any_of(zones, [&](const Zone& zone) { return zone.contains(moment.zone); })) return false;
  std::erase_if(zones, [&](const Zone& zone) { return moment.zone.contains(zone); });
  zones.push_back(moment.zone);
  words_ += size + kNodeWords;
  bool accepted = false;
  if (moment.running.empty() && moments_.at_goal(moment)) {
    if (options_.moments.relaxed) return accept({});
    const std::optional<HappeningPlan> plan = plan_of(node);
    accepted = plan && accept(*plan);
  }
  const int seems = estimate(moment);
  budget_.spend(Work::kReach, heuristic_.work() - reported_);
  reported_ = heuristic_.work();
  const int id = static_cast<int>(nodes_.size());
  near_.push(seems, id);
  short_.push(seems + node.starts, id);
  nodes_.push_back(std::move(node));
  return accepted;
}

SearchEnd HappeningSearch::run(Micros before, const std::function<bool(const HappeningPlan&)>& accept) {
  if (!begun_) {
    begun_ = true;
    if (add({moments_.initial(), -1, {}, {}, 0, false}, before, accept)) return SearchEnd::kFound;
  }
  for (;;) {
    if (budget_.slice_over()) return SearchEnd::kBudget;
    if (words_ > options_.most_words) return SearchEnd::kMemory;
    BucketQueue<int>& queue = turn_++ % 2 == 0 ? near_ : short_;
    if (queue.empty()) {
      if (near_.empty() && short_.empty()) return SearchEnd::kExhausted;
      continue;
    }
    const int id = queue.pop();
    if (nodes_[id].expanded) continue;
    nodes_[id].expanded = true;
    const Moment moment = std::move(nodes_[id].moment);
    if (too_late(moment, before)) continue;
    const int starts = nodes_[id].starts;
    bool accepted = false;
    for (const Happening& happening : moments_.happenings(moment)) {
      moments_.each_after(moment, happening, [&](Moment after, const Moments::Signs& signs) {
        const int more = happening.kind == Happening::Kind::kStart ? 1 : 0;
        accepted |= add({std::move(after), id, happening, signs, starts + more, false}, before, accept);
      });
    }
    if (accepted) return SearchEnd::kFound;
  }
}

}  // namespace cxlab::planner
