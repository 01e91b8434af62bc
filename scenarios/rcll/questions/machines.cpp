// cxlab machines: what each machine did.

#include <algorithm>
#include <map>

#include "scenarios/rcll/questions/products.h"
#include "scenarios/rcll/questions/questions.h"
#include "scenarios/rcll/rules/machine.h"

namespace cxlab::rcll {

namespace {

using Counts = std::map<std::string, std::int64_t, std::less<>>;

/// What a column of shares shows, in the order of the life of a workpiece.
constexpr std::pair<std::string_view, std::string_view> kShares[]{{"IDLE", "idle"},
                                                                  {"PREPARED", "prep."},
                                                                  {"PROCESSING", "proc."},
                                                                  {"PROCESSED", "done"},
                                                                  {"READY-AT-OUTPUT", "ready"},
                                                                  {"WAIT-IDLE", "wait"},
                                                                  {"BROKEN", "broken"},
                                                                  {"DOWN", "down"}};

bool is_within(SimTime t, const Interval& asked) { return asked.from <= t && t <= asked.to; }

std::map<std::string, SimTime, std::less<>> time_in_states(const MachineStory& machine, const Interval& asked) {
  std::map<std::string, SimTime, std::less<>> out;
  SimTime since = asked.from;
  std::string state = machine.state_at(asked.from);
  for (const auto& [t, next] : machine.states) {
    if (t <= asked.from || t >= asked.to) continue;
    out[state] += t - since;
    since = t;
    state = next;
  }
  out[state] += asked.to - since;
  return out;
}

/// What it made, by kind.
Counts works_of(const GameStory& story, const MachineStory& machine) {
  Counts out;
  for (const auto& [t, work] : machine.works) {
    if (!is_within(t, story.asked())) continue;
    const std::string part = work.product.substr(work.product.rfind(' ') + 1);
    switch (work.kind) {
      case WorkDone::Kind::kMounted: ++out[part]; break;
      case WorkDone::Kind::kCapRetrieved: ++out["cap retrieved"]; break;
      case WorkDone::Kind::kStored: ++out["stored"]; break;
      case WorkDone::Kind::kUnstored: ++out["out of the storage"]; break;
    }
  }
  if (machine.kind == "BS")
    for (const auto& [t, number] : machine.dispensed)
      if (const PieceStory* piece = story.piece(number); is_within(t, story.asked()))
        ++out[piece->product.substr(0, piece->product.find(' '))];
  for (const PieceStory& piece : story.pieces) {
    const bool here = !piece.moves.empty() && piece.moves.back().value.to_name == machine.name;
    if (here && piece.delivery && is_within(piece.delivery->t, story.asked()))
      ++out[piece.delivery->value.correct ? "delivered" : "refused"];
    if (here && piece.discarded && is_within(*piece.discarded, story.asked())) ++out["thrown away"];
  }
  return out;
}

/// Workpieces on its input that it has not begun with, and robots that wait for it.
std::vector<Interval> queue_of(const GameStory& story, const MachineStory& machine,
                               const std::vector<std::vector<RobotWait>>& waits) {
  std::vector<Interval> out;
  const auto add = [&](const Interval& interval) {
    if (const Interval part = common(interval, story.asked()); !part.empty()) out.push_back(part);
  };
  for (const PieceStory& piece : story.pieces)
    for (const Visit& visit : visits_of(story, piece, nullptr))
      if (visit.machine == &machine && machine.kind != "BS")
        add({visit.arrived, visit.began.value_or(visit.done.value_or(visit.left.value_or(story.end)))});
  for (const auto& robot : waits)
    for (const RobotWait& wait : robot)
      if (wait.waiting.what == machine.name) add(wait.waiting.when);
  return out;
}

/// The most that overlap.
std::int64_t longest_queue(const std::vector<Interval>& waiting) {
  std::map<SimTime, int> changes;
  for (const Interval& one : waiting) {
    ++changes[one.from];
    --changes[one.to];
  }
  std::int64_t now = 0, most = 0;
  for (const auto& [t, change] : changes) most = std::max(most, now += change);
  return most;
}

SimTime longest_at_output(const GameStory& story, const MachineStory& machine) {
  SimTime longest{};
  for (std::size_t i = 0; i < machine.states.size(); ++i) {
    if (machine.states[i].value != "READY-AT-OUTPUT") continue;
    const Interval lay{machine.states[i].t, i + 1 < machine.states.size() ? machine.states[i + 1].t : story.end};
    if (const Interval part = common(lay, story.asked()); !part.empty()) longest = std::max(longest, part.length());
  }
  return longest;
}

/// "broken at 3:08.0: a fault of the scenario; 3 RING_GREEN".
std::string events_text(const GameStory& story, const MachineStory& machine, const Counts& works) {
  std::string out;
  const auto add = [&out](const std::string& text) { out += (out.empty() ? "" : "; ") + text; };
  for (const auto& [what, count] : works) add(std::to_string(count) + ' ' + what);
  for (const auto& [t, reason] : machine.breaks)
    if (is_within(t, story.asked())) add("broke at " + time_text(t) + ": " + reason);
  for (std::size_t i = 0; i < machine.states.size(); ++i) {
    const auto& [t, state] = machine.states[i];
    const SimTime until = i + 1 < machine.states.size() ? machine.states[i + 1].t : story.end;
    if (state == "DOWN" && !common({t, until}, story.asked()).empty())
      add("down from " + time_text(t) + " to " + time_text(until));
  }
  return out;
}

}  // namespace

Expected<WorldAnswer> answer_machines(const AskedRun& run) {
  const auto story = GameStory::read(run);
  if (!story) return story.error();
  if (!run.about.empty() && !story->machine(run.about)) {
    std::vector<std::string> known;
    for (const MachineStory& machine : story->machines) known.push_back(machine.name);
    return usage_error("there is no machine '" + std::string(run.about) + "' of a team that plays; there are " +
                       some_of_and_nearest(std::string(run.about), known));
  }
  Table table{"machines", "", {{"machine", "machine"}}, {}};
  for (const auto& [state, title] : kShares) {
    std::string key(title == "prep." ? "prepared" : title == "proc." ? "processing" : title);
    table.columns.push_back({key, std::string(title), Column::Kind::kShare});
  }
  table.columns.insert(table.columns.end(), {{"works", "works", Column::Kind::kNumber},
                                             {"breaks", "breaks", Column::Kind::kNumber},
                                             {"queue", "queue", Column::Kind::kNumber},
                                             {"longest_queued_s", "longest", Column::Kind::kSeconds},
                                             {"longest_at_output_s", "at output", Column::Kind::kSeconds},
                                             {"events", "what happened"}});
  std::vector<std::vector<RobotWait>> waits;
  for (const RobotStory& robot : story->robots) waits.push_back(waits_of(*story, robot));
  for (const MachineStory& machine : story->machines) {
    if (!run.about.empty() && machine.name != run.about) continue;
    const auto states = time_in_states(machine, story->asked());
    std::vector<TableCell>& row = table.rows.emplace_back();
    row.emplace_back(machine.name);
    for (const auto& [state, title] : kShares) {
      const auto found = states.find(state);
      const double length = std::max(1e-9, to_seconds(story->asked().length()));
      row.emplace_back(found == states.end() ? 0.0 : to_seconds(found->second) / length);
    }
    const Counts works = works_of(*story, machine);
    std::int64_t made = 0;
    for (const auto& [what, count] : works) made += count;
    const auto breaks =
        std::ranges::count_if(machine.breaks, [&](const auto& one) { return is_within(one.t, story->asked()); });
    const std::vector<Interval> queue = queue_of(*story, machine, waits);
    SimTime longest{};
    for (const Interval& one : queue) longest = std::max(longest, one.length());
    for (TableCell cell :
         {TableCell(made), TableCell(static_cast<std::int64_t>(breaks)), TableCell(longest_queue(queue)),
          TableCell(longest), TableCell(longest_at_output(*story, machine)),
          TableCell(events_text(*story, machine, works))})
      row.push_back(std::move(cell));
  }
  return WorldAnswer{{std::move(table)},
                     {"queue: most workpieces before the machine and robots that wait for it at one time; longest: the "
                      "longest wait of one of them; at output: the longest time that a workpiece lay there"}};
}

}  // namespace cxlab::rcll
