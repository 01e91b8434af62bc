// cxlab pieces: the life of each workpiece.

#include <algorithm>

#include "scenarios/rcll/questions/products.h"
#include "scenarios/rcll/questions/questions.h"

namespace cxlab::rcll {

namespace {

/// One thing that happened to a workpiece.
struct LifeEvent {
  SimTime t{};
  std::string what, where, who;
};

std::string what_moved(const PieceMoved& e) {
  if (e.from == "dispenser") return "came out";
  if (e.to == "gripper") return "taken";
  if (e.from == "gripper" && e.to == "floor") return "dropped";
  if (e.to == "floor") return "fell";
  if (e.to == "crew") return "taken away";
  if (e.to == "slide") return "payment";
  if (e.to == "gate") return "through the gate";
  if (e.from == "gripper") return "put down";
  return "moved";
}

std::string what_done(const WorkDone& e) {
  const std::string part = e.product.substr(e.product.rfind(' ') + 1);
  switch (e.kind) {
    case WorkDone::Kind::kCapRetrieved: return "cap taken off";
    case WorkDone::Kind::kMounted: return part + " mounted";
    case WorkDone::Kind::kStored: return "stored";
    case WorkDone::Kind::kUnstored: return "out of the storage";
  }
  return {};
}

std::vector<LifeEvent> life_of(const PieceStory& piece) {
  std::vector<LifeEvent> out;
  for (const auto& [t, e] : piece.moves) {
    const std::string where = e.to == "gripper" ? e.from_name : e.to_name.empty() ? e.to : e.to_name;
    const std::string who = e.to == "gripper" ? e.to_name : e.from == "gripper" ? e.from_name : std::string();
    out.push_back({t, what_moved(e), where, who});
  }
  for (const auto& [t, e] : piece.works) out.push_back({t, what_done(e), e.machine, {}});
  if (piece.delivery) {
    const DeliveryJudged& judged = piece.delivery->value;
    out.push_back({piece.delivery->t,
                   (judged.correct ? "delivered for order " : "refused for order ") + std::to_string(judged.order) +
                       (judged.correct ? "" : ": " + judged.reason),
                   {},
                   {}});
  }
  if (piece.discarded) out.push_back({*piece.discarded, "thrown away", {}, {}});
  if (piece.taken) out.push_back({*piece.taken, "taken by a fault of the scenario", {}, {}});
  std::ranges::stable_sort(out, {}, &LifeEvent::t);
  return out;
}

/// "0:20.8 came out C-BS; 0:45.8 taken by robot2 ...".
std::string life_text(const std::vector<LifeEvent>& life) {
  std::string out;
  for (const LifeEvent& e : life)
    out += (out.empty() ? "" : "; ") + time_text(e.t) + ' ' + e.what + (e.who.empty() ? "" : " by " + e.who) +
           (e.where.empty() ? "" : " at " + e.where);
  return out;
}

std::string moved_by(const PieceStory& piece) {
  std::vector<std::string> robots;
  for (const auto& [t, e] : piece.moves)
    if (e.to == "gripper" && std::ranges::find(robots, e.to_name) == robots.end()) robots.push_back(e.to_name);
  std::string out;
  for (const std::string& robot : robots) out += (out.empty() ? "" : " ") + robot;
  return out;
}

/// The order that it was made for, of products.
TableCell order_of_piece(const std::vector<OrderWork>& works, const PieceStory& piece) {
  for (const OrderWork& work : works)
    for (const Attempt& attempt : work.attempts)
      if (attempt.piece == &piece) return work.order.id;
  return {};
}

}  // namespace

Expected<WorldAnswer> answer_pieces(const AskedRun& run) {
  const auto story = GameStory::read(run);
  if (!story) return story.error();
  if (!run.about.empty()) {
    std::vector<std::string> known;
    for (const PieceStory& piece : story->pieces) known.push_back(std::to_string(piece.number));
    if (std::ranges::find(known, run.about) == known.end())
      return usage_error("there is no workpiece '" + std::string(run.about) + "' up to that time" +
                         (known.empty() ? "" : "; they are numbered from " + known.front() + " to " + known.back()) +
                         did_you_mean(std::string(run.about), known, "; "));
  }
  const std::vector<OrderWork> works = work_for_orders(*story);
  Table pieces{"pieces",
               "",
               {{"piece", "piece", Column::Kind::kNumber},
                {"origin", "from"},
                {"begin_s", "since", Column::Kind::kTime},
                {"product", "product"},
                {"order", "order", Column::Kind::kNumber},
                {"end_s", "until", Column::Kind::kTime},
                {"fate", "fate"},
                {"moved_by", "moved by"},
                {"life", "life"}},
               {}};
  Table life{
      "life", "life", {{"t_s", "time", Column::Kind::kTime}, {"what", "what"}, {"where", "where"}, {"who", "who"}}, {}};
  std::vector<std::pair<Fate::Kind, std::int64_t>> fates;
  for (const PieceStory& piece : story->pieces) {
    if (!run.about.empty() && run.about != std::to_string(piece.number)) continue;
    const Fate fate = fate_of(*story, piece);
    if (fate.is_over() && fate.t < story->from) continue;
    const std::vector<LifeEvent> events = life_of(piece);
    pieces.rows.push_back({piece.number, piece.origin, events.empty() ? SimTime{} : events.front().t,
                           TableCell(piece.product, product_text(piece.product)), order_of_piece(works, piece),
                           fate.is_over() ? TableCell(fate.t) : TableCell(),
                           TableCell(std::string(to_string(fate.kind)), fate.text), moved_by(piece),
                           life_text(events)});
    if (!run.about.empty())
      for (const LifeEvent& e : events) life.rows.push_back({e.t, e.what, e.where, e.who});
    const auto counted = std::ranges::find(fates, fate.kind, &std::pair<Fate::Kind, std::int64_t>::first);
    if (counted == fates.end())
      fates.emplace_back(fate.kind, 1);
    else
      ++counted->second;
  }
  if (!run.about.empty()) {
    drop_column(pieces, "life");
    return WorldAnswer{{std::move(pieces), std::move(life)}, {}};
  }
  std::ranges::sort(fates);
  std::string note = std::to_string(pieces.rows.size()) + " workpieces";
  for (const auto& [kind, count] : fates)
    note += (&kind == &fates.front().first ? ": " : ", ") + std::to_string(count) + ' ' + std::string(to_string(kind));
  return WorldAnswer{{std::move(pieces)}, {std::move(note)}};
}

}  // namespace cxlab::rcll
