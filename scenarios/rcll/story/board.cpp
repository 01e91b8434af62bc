#include "scenarios/rcll/story/board.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cx/journal/journal_reader.h"

namespace cxlab::rcll {
namespace {

using Colour = sim::Legend::Colour;
constexpr Colour kPlain{1, 1, 1}, kWaiting{0.65f, 0.65f, 0.65f}, kLate{1, 0.45f, 0.4f};
constexpr std::array<Colour, 2> kTeamColours{{{0.2f, 0.95f, 1}, {1, 0.5f, 0.85f}}};

std::string clock_text(double seconds) {
  const long whole = std::lround(std::floor(seconds));
  char text[32];
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

}  // namespace

void BoardKeeper::apply(SimTime t, const Event& event) {
  clock_.apply(t, event);
  std::visit(
      Cases{[&](const PointsGiven& e) {
              if (e.team) board_.points[static_cast<std::size_t>(*e.team)] = e.total;
            },
            [&](const OrderPublished& e) {
              const auto after = std::ranges::upper_bound(board_.orders, e.id, {}, &BoardOrder::id);
              board_.orders.insert(
                  after,
                  {e.id, e.complexity, stack_of(e.product), e.begin, e.end, e.quantity, e.gate, e.competitive, {}});
            },
            [&](const DeliveryJudged& e) {
              const auto order = std::ranges::find(board_.orders, e.order, &BoardOrder::id);
              if (e.team && e.correct && order != board_.orders.end())
                ++order->delivered[static_cast<std::size_t>(*e.team)];
            },
            [](const auto&) {}},
      event);
}

Board BoardKeeper::at(SimTime now) const {
  Board board = board_;
  board.phase = to_string(clock_.phase(now));
  board.game_time = clock_.game_time(now);
  board.paused = clock_.floor.halted();
  return board;
}

Expected<RecordedBoard> RecordedBoard::load(const WorldConfig& config, const std::filesystem::path& journal) {
  auto records = read_journal(journal, {.kinds = {RecordKind::kReferee}});
  if (!records) return records.error();
  RecordedBoard board(config);
  for (const JournalRecord& record : *records)
    if (auto event = read_event(record.data)) board.take(record.t, *std::move(event));
  return board;
}

Board RecordedBoard::at(SimTime now) const {
  BoardKeeper board = begin_;
  for (const auto& [t, event] : events_)
    if (t <= now) board.apply(t, event);
  return board.at(now);
}

std::vector<sim::ColouredText> headline_of(const Board& board) {
  std::vector<sim::ColouredText> words;
  words.push_back({clock_text(board.game_time) + ' ' + board.phase + (board.paused ? " PAUSED" : ""), kPlain});
  for (const Team team : kTeams) {
    const auto index = static_cast<std::size_t>(team);
    if (std::ranges::find(board.teams, team) == board.teams.end() && board.points[index] == 0) continue;
    words.push_back({std::string(to_string(team)) + ' ' + std::to_string(board.points[index]), kTeamColours[index]});
  }
  return words;
}

sim::Legend legend_of(const Board& board) {
  sim::Legend legend;
  legend.rows = 1;
  for (const BoardOrder& order : board.orders) {
    const int delivered = std::ranges::max(order.delivered);
    const bool done = delivered >= order.quantity;
    const Colour colour = done || board.game_time < order.begin ? kWaiting
                          : board.game_time > order.end         ? kLate
                                                                : kPlain;
    std::string name = std::to_string(order.id) + ' ' + order.complexity + " G" + std::to_string(order.gate);
    if (order.competitive) name += " vs";
    if (order.quantity > 1) name += ' ' + std::to_string(delivered) + '/' + std::to_string(order.quantity);
    sim::Legend::Card& card = legend.cards.emplace_back();
    card.product = order.product;
    card.lines = {{{name, colour}, {clock_text(order.begin) + '-' + clock_text(order.end), colour}}};
    for (std::size_t team = order.delivered.size(); team-- > 0;)
      if (order.delivered[team] >= order.quantity) card.ticks.push_back(kTeamColours[team]);
  }
  return legend;
}

}  // namespace cxlab::rcll
