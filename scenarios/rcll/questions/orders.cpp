// cxlab orders: when each order was worked for, and why a product is late or missing.

#include "scenarios/rcll/questions/orders.h"

#include <algorithm>
#include <utility>

#include "cx/base/number_text.h"
#include "scenarios/rcll/questions/questions.h"

namespace cxlab::rcll {

namespace {

constexpr std::size_t kReasonsNamed = 3;

bool is_in_time(const OrderWork& work) {
  const auto first = std::ranges::find_if(work.deliveries, [](const auto& one) { return one.value.correct; });
  return first != work.deliveries.end() && first->value.late_s <= 0;
}

std::vector<Waiting> waits_for(const OrderWork& work) {
  std::vector<Waiting> sums;
  for (const Attempt& attempt : work.attempts)
    for (const Waiting& wait : attempt.waits) add_to(sums, wait);
  return sums;
}

SimTime total(const std::vector<Waiting>& sums) {
  SimTime out{};
  for (const Waiting& sum : sums) out += sum.when.length();
  return out;
}

std::string waits_sentence(const OrderWork& work) {
  const std::vector<Waiting> sums = waits_for(work);
  const std::string longest = sums_text(sums, kReasonsNamed);
  if (longest.empty()) return work.attempts.empty() ? "" : "; its product did not have to wait";
  return "; its product waited " + length_text(total(sums)) + ", most of it: " + longest;
}

/// What became of products that were not delivered.
std::string lost_products(const OrderWork& work) {
  std::string out;
  for (const Attempt& attempt : work.attempts) {
    const Fate& fate = attempt.fate;
    if (!fate.is_lost() && fate.kind != Fate::Kind::kRefused && fate.kind != Fate::Kind::kPayment) continue;
    out += (out.empty() ? "" : "; ") + std::string("product ") + std::to_string(attempt.piece->number) + " (" +
           product_text(attempt.piece->product) + ") was lost at " + time_text(fate.t) + ": " + fate.text;
  }
  return out;
}

/// "RING_BLUE at C-RS2" of a product that is still in play.
std::string step_reached(const OrderWork& work, const Attempt& attempt) {
  const Visit* last = attempt.visits.empty() ? nullptr : &attempt.visits.back();
  std::string next =
      last && !last->done && !last->part.empty() ? last->part : next_part(attempt.piece->product, work.order);
  std::string out = "the next step was " + next;
  if (last && !last->done)
    out += " at " + last->machine->name + (last->began ? ", which had begun at " + time_text(*last->began) : "");
  return out + "; the product had been " + attempt.fate.text + " since " + time_text(attempt.fate.t);
}

/// Whether the story goes on after what is asked about.
bool goes_on(const GameStory& story) { return !story.run_ended && story.clock.phase(story.end) != Phase::kPostGame; }

/// Whether an order that has not been begun is still to come: the story goes on, or the run was stopped before its
/// window.
bool is_to_come(const GameStory& story, const OrderWork& work) {
  return goes_on(story) ||
         (story.clock.phase(story.end) != Phase::kPostGame && story.end < story.clock.when(work.order.delivery_begin));
}

/// "begun 85.0 s after the end of its window".
std::string begun_text(const GameStory& story, const OrderWork& work) {
  const auto begun = work.begun();
  if (!begun) return {};
  const SimTime end = story.clock.when(work.order.delivery_end);
  return "begun " + (*begun <= end ? length_text(end - *begun) + " before" : length_text(*begun - end) + " after") +
         " the end of its window";
}

/// The orders that the team began while this one could have been.
std::string others_begun(const GameStory& story, const OrderWork& work, const std::vector<OrderWork>& all) {
  const SimTime from = story.published.at(work.order.id);
  const SimTime window_end = story.clock.when(work.order.delivery_end), to = std::min(story.end, window_end);
  std::vector<std::pair<SimTime, int>> begun;
  for (const OrderWork& other : all)
    if (const auto at = other.begun(); other.team == work.team && at && *at >= from && *at <= to)
      begun.emplace_back(*at, other.order.id);
  std::ranges::sort(begun);
  std::string out;
  for (const auto& [t, id] : begun) out += (out.empty() ? "" : ", ") + std::to_string(id) + " (" + time_text(t) + ")";
  return "from its publication at " + time_text(from) + " to " +
         (window_end <= story.end ? "the end of its window" : time_text(to)) + " the agent began " +
         (out.empty() ? "no other order either" : out);
}

std::string never_begun(const GameStory& story, const OrderWork& work, const std::vector<OrderWork>& all) {
  const Decision* last = nullptr;
  for (const Decision& decision : story.decisions)
    if (decision.team == work.team && decision.names_order(work.order.id) &&
        !(decision.slots.size() > 1 && decision.slots.front().find("points for") != std::string::npos))
      last = &decision;
  return std::string(is_to_come(story, work) ? "not begun yet: " : "never begun: ") +
         (last ? "the agent decided at " + time_text(last->t) + " " + last->text() + "; " : "") +
         others_begun(story, work, all);
}

std::string missing(const GameStory& story, const OrderWork& work, const std::vector<OrderWork>& all) {
  const auto released = story.published.find(work.order.id);
  if (released == story.published.end())
    return "not published before " + time_text(story.clock.when(work.order.activate_at));
  const std::string lost = lost_products(work);
  const Attempt* in_play = nullptr;
  for (const Attempt& attempt : work.attempts)
    if (!attempt.fate.is_over()) in_play = &attempt;
  const bool over = story.clock.phase(story.end) == Phase::kPostGame;
  const std::string begun = work.begun() ? "; it was " + begun_text(story, work) : std::string();
  if (in_play)
    return (over              ? "not finished when the game ended: "
            : story.run_ended ? "not finished when the run ended: "
                              : "being made: ") +
           step_reached(work, *in_play) + (lost.empty() ? "" : "; before, " + lost) + begun + waits_sentence(work);
  if (!lost.empty()) return lost + "; no other was made" + begun + waits_sentence(work);
  if (!work.decided) return never_begun(story, work, all);
  return "the agent decided at " + time_text(work.decided->t) + " " + work.decided->value->text() +
         "; no product is known that was made for it" + (goes_on(story) ? " up to then" : "") + begun;
}

std::string late(const GameStory& story, const OrderWork& work, double late_s) {
  const std::string begun = begun_text(story, work), lost = lost_products(work);
  return "late by " + length_text(late_s) + (begun.empty() ? "" : ": " + begun) + (lost.empty() ? "" : "; " + lost) +
         waits_sentence(work);
}

std::string outcome(const GameStory& story, const OrderWork& work, const std::vector<OrderWork>& all) {
  if (!work.correct()) return missing(story, work, all);
  const auto first = std::ranges::find_if(work.deliveries, [](const auto& one) { return one.value.correct; });
  if (!is_in_time(work)) return late(story, work, first->value.late_s);
  const std::string lost = lost_products(work);
  const auto count = std::ranges::count_if(work.deliveries, [](const auto& one) { return one.value.correct; });
  return "in time" +
         (work.order.quantity > 1 ? ", " + std::to_string(count) + " of " + std::to_string(work.order.quantity) : "") +
         (lost.empty() ? "" : "; " + lost);
}

std::string_view state_of(const GameStory& story, const OrderWork& work) {
  if (work.correct()) return is_in_time(work) ? "delivered" : "late";
  if (!story.published.contains(work.order.id)) return "not published";
  if (work.attempts.empty()) return work.decided ? "begun" : is_to_come(story, work) ? "not begun" : "never begun";
  return std::ranges::any_of(work.attempts, [](const Attempt& one) { return !one.fate.is_over(); }) ? "unfinished"
                                                                                                    : "lost";
}

TableCell optional_time(const std::optional<SimTime>& t) { return t ? TableCell(*t) : TableCell(); }

/// Whether something of the order's life is not over before what is asked about.
bool is_asked_for(const GameStory& story, const OrderWork& work) {
  if (story.from <= SimTime{}) return true;
  SimTime last = story.clock.when(work.order.delivery_end);
  for (const Attempt& attempt : work.attempts)
    last = std::max(last, attempt.fate.is_over() ? attempt.fate.t : story.end);
  const auto delivered = work.delivered_at();
  return (delivered && work.attempts.size() <= 1 ? *delivered : last) >= story.from;
}

/// The waits by step: a wait belongs to the first step that had not ended when it began, at last to the one that the
/// product did not come to.
std::vector<std::vector<Waiting>> waits_by_step(const Attempt& attempt) {
  std::vector<std::vector<Waiting>> out(attempt.visits.size() + 1);
  for (const Waiting& wait : attempt.waits) {
    std::size_t step = 0;
    for (; step < attempt.visits.size(); ++step) {
      const Visit& visit = attempt.visits[step];
      if (wait.when.from < visit.done.value_or(visit.left.value_or(kNever))) break;
    }
    add_to(out[step], wait);
  }
  return out;
}

std::vector<OrderStep> steps_of(const OrderWork& work) {
  std::vector<OrderStep> out;
  for (const Attempt& attempt : work.attempts) {
    const int piece = attempt.piece->number;
    const std::vector<std::vector<Waiting>> waits = waits_by_step(attempt);
    const auto add = [&](OrderStep step, const std::vector<Waiting>& sums) {
      step.waited = total(sums);
      step.waited_for = sums_text(sums, kReasonsNamed);
      out.push_back(std::move(step));
    };
    for (std::size_t i = 0; i < attempt.visits.size(); ++i) {
      const Visit& visit = attempt.visits[i];
      add({piece, visit.part, visit.machine->name, visit.arrived, visit.began, visit.done, {}, {}}, waits[i]);
    }
    if (const std::vector<Waiting>& rest = waits.back(); total(rest) > SimTime{})
      add({piece, next_part(attempt.piece->product, work.order), {}, {}, {}, {}, {}, {}}, rest);
    const Fate& fate = attempt.fate;
    if (fate.kind == Fate::Kind::kDelivered) continue;
    OrderStep& end = out.emplace_back();
    end.piece = piece;
    end.what = to_string(fate.kind);
    (fate.is_over() ? end.done : end.arrived) = fate.t;
    end.waited_for = fate.text;
  }
  return out;
}

TableCell text_or_nothing(const std::string& text) { return text.empty() ? TableCell() : TableCell(text); }

void add_rows(const OrderAccount& account, Table& steps) {
  for (const OrderStep& step : account.steps)
    steps.rows.push_back({account.work->order.id, TableCell(to_string(account.work->team)), step.piece,
                          step.what.empty() ? TableCell("?") : TableCell(step.what), text_or_nothing(step.machine),
                          optional_time(step.arrived), optional_time(step.began), optional_time(step.done), step.waited,
                          step.waited_for});
}

/// What to ask next of an order that the team has not begun: which rules made its decisions meanwhile; empty where none
/// are recorded.
std::vector<std::string> ask_next(const GameStory& story, const OrderWork& work, const std::string& folder) {
  const auto published = story.published.find(work.order.id);
  if (published == story.published.end() || work.begun() || work.correct()) return {};
  for (const Decision& decision : story.decisions) {
    if (decision.team != work.team || decision.t < published->second) continue;
    const std::string to = time_text(story.end);
    return {"ask: cxlab facts " + folder + " decision --from " + time_text(published->second) + " --to " + to +
                " (which rules decided meanwhile)",
            "then: cxlab why-not " + folder + " RULE --at " + to + " (what the rule that begins orders lacked)"};
  }
  return {};
}

/// Why a PDDL manager made no plan, each reason once: "no plan at 0:26.2 and 3 times more: the goal ...".
std::vector<std::string> missing_plans(const std::vector<JournalRecord>& records) {
  struct Missing {
    std::string reason;
    SimTime first{};
    int times = 0;
  };
  std::vector<Missing> missing;
  for (const JournalRecord& record : records) {
    if (record.kind != RecordKind::kDecision || record.data.text("op") != "plan") continue;
    const std::string_view reason = record.data.text("reason");
    if (reason.empty()) continue;
    const auto known = std::ranges::find(missing, reason, &Missing::reason);
    if (known == missing.end())
      missing.push_back({std::string(reason), record.t, 1});
    else
      ++known->times;
  }
  std::vector<std::string> texts;
  for (const Missing& one : missing) {
    if (texts.size() == kReasonsNamed) {
      texts.push_back(std::to_string(missing.size() - kReasonsNamed) + " more reasons why there was no plan");
      break;
    }
    texts.push_back("no plan at " + time_text(one.first) +
                    (one.times > 1 ? ", " + std::to_string(one.times) + " times" : "") + ": " + one.reason);
  }
  return texts;
}

}  // namespace

OrderAccount account_of(const GameStory& story, const OrderWork& work, const std::vector<OrderWork>& all) {
  const auto first = std::ranges::find_if(work.deliveries, [](const auto& one) { return one.value.correct; });
  return {&work,
          state_of(story, work),
          first == work.deliveries.end() ? 0 : first->value.late_s,
          total(waits_for(work)),
          outcome(story, work, all),
          steps_of(work)};
}

Expected<WorldAnswer> answer_orders(const AskedRun& run) {
  const auto story = GameStory::read(run);
  if (!story) return story.error();
  const std::vector<OrderWork> all = work_for_orders(*story);
  if (!run.about.empty()) {
    std::vector<std::string> known;
    for (const Order& order : story->orders()) known.push_back(std::to_string(order.id));
    if (std::ranges::find(known, run.about) == known.end())
      return usage_error("there is no order '" + std::string(run.about) + "' in this game; it has " +
                         some_of_and_nearest(std::string(run.about), known));
  }
  const bool two_teams = story->teams.size() > 1;
  Table orders{"orders",
               "",
               {{"order", "order", Column::Kind::kNumber},
                {"team", "team"},
                {"complexity", ""},
                {"product", "product"},
                {"window_s", "window", Column::Kind::kStretch},
                {"begun_s", "begun", Column::Kind::kTime},
                {"delivered_s", "delivered", Column::Kind::kTime},
                {"points", "points", Column::Kind::kNumber},
                {"state", "state"},
                {"waited_s", "waited", Column::Kind::kSeconds},
                {"outcome", "outcome"}},
               {}};
  Table steps{"steps",
              "steps",
              {{"order", "order", Column::Kind::kNumber},
               {"team", "team"},
               {"piece", "piece", Column::Kind::kNumber},
               {"step", "step"},
               {"machine", "machine"},
               {"arrived_s", "arrived", Column::Kind::kTime},
               {"began_s", "began", Column::Kind::kTime},
               {"done_s", "done", Column::Kind::kTime},
               {"waited_s", "waited", Column::Kind::kSeconds},
               {"waited_for", "what it waited for"}},
              {}};
  for (const OrderWork& work : all) {
    const Order& order = work.order;
    if (!run.about.empty() && run.about != std::to_string(order.id)) continue;
    if (!is_asked_for(*story, work)) continue;
    const OrderAccount account = account_of(*story, work, all);
    const std::string product = describe(stack_of(order.product));
    orders.rows.push_back({order.id, TableCell(to_string(work.team)), TableCell(to_string(order.complexity)),
                           TableCell(product, product_text(product)),
                           TableCell::Stretch(order.delivery_begin, order.delivery_end), optional_time(work.begun()),
                           optional_time(work.delivered_at()), work.points, TableCell(account.state), account.waited,
                           account.outcome});
    add_rows(account, steps);
  }
  if (!two_teams)
    for (Table* table : {&orders, &steps}) drop_column(*table, "team");
  WorldAnswer answer{{std::move(orders), std::move(steps)}, {}};
  for (const Team team : story->teams) {
    std::int64_t points = 0, delivered = 0, asked = 0;
    for (const auto& [t, given] : story->points)
      if (given.team == team) points = given.total;
    for (const OrderWork& work : all)
      if (work.team == team) {
        ++asked;
        delivered += work.correct() ? 1 : 0;
      }
    answer.notes.push_back(std::string(to_string(team)) + ": " + std::to_string(points) + " points, " +
                           std::to_string(delivered) + " of " + std::to_string(asked) + " orders delivered");
  }
  if (const std::string about = story->about_times(); !about.empty()) answer.notes.push_back(about);
  for (std::string& missing : missing_plans(run.records)) answer.notes.push_back(std::move(missing));
  for (const OrderWork& work : all)
    if (run.about == std::to_string(work.order.id))
      if (const auto ask = ask_next(*story, work, run.folder.empty() ? "RUN" : run.folder.string()); !ask.empty()) {
        answer.notes.insert(answer.notes.end(), ask.begin(), ask.end());
        break;  // the commands ask the agents of both teams
      }
  return answer;
}

}  // namespace cxlab::rcll
