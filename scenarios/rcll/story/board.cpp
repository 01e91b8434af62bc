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

void set_time(Board& board, const GameClock& clock, SimTime now) {
  board.phase = to_string(clock.phase(now));
  board.game_time = clock.game_time(now);
}

}  // namespace

Board board_of(const Factory& game) {
  const GameReferee& referee = game.referee();
  Board board;
  set_time(board, game.clock(), game.floor().floor_time());
  board.paused = game.state() == GameState::kPaused;
  board.teams = game.teams();
  for (const Team team : kTeams) board.points[static_cast<std::size_t>(team)] = referee.score(team).total();
  for (const OrderState& state : referee.orders()) {
    if (!state.released) continue;
    const Order& order = state.order;
    board.orders.push_back({order.id, std::string(to_string(order.complexity)), stack_of(order.product),
                            order.delivery_begin, order.delivery_end, order.quantity, order.delivery_gate,
                            order.competitive, state.delivered});
  }
  return board;
}

Expected<RecordedBoard> RecordedBoard::load(const GameClock& clock, std::vector<Team> teams,
                                            const std::filesystem::path& journal) {
  auto records = read_journal(journal, {.kinds = {RecordKind::kReferee}});
  if (!records) return records.error();
  RecordedBoard board(clock, std::move(teams));
  for (const JournalRecord& record : *records)
    if (auto event = read_event(record.data)) board.take(record.t, *std::move(event));
  return board;
}

Board RecordedBoard::at(SimTime now) const {
  RecordedClock clock{clock_, {}};
  Board board;
  for (const auto& [t, event] : events_) {
    if (t > now) continue;
    clock.apply(t, event);
    std::visit(
        Cases{[&](const PointsGiven& e) {
                if (e.team) board.points[static_cast<std::size_t>(*e.team)] = e.total;
              },
              [&](const OrderPublished& e) {
                board.orders.push_back(
                    {e.id, e.complexity, stack_of(e.product), e.begin, e.end, e.quantity, e.gate, e.competitive, {}});
              },
              [&](const DeliveryJudged& e) {
                const auto order = std::ranges::find(board.orders, e.order, &BoardOrder::id);
                if (e.team && e.correct && order != board.orders.end())
                  ++order->delivered[static_cast<std::size_t>(*e.team)];
              },
              [](const auto&) {}},
        event);
  }
  std::ranges::stable_sort(board.orders, {}, &BoardOrder::id);
  set_time(board, clock.game, clock.floor.at(now));
  board.paused = clock.floor.halted();
  board.teams = teams_;
  return board;
}

sim::Legend legend_of(const Board& board) {
  sim::Legend legend;
  legend.title.push_back({clock_text(board.game_time) + ' ' + board.phase + (board.paused ? " PAUSED" : ""), kPlain});
  for (const Team team : kTeams) {
    const auto index = static_cast<std::size_t>(team);
    if (std::ranges::find(board.teams, team) == board.teams.end() && board.points[index] == 0) continue;
    legend.title.push_back(
        {std::string(to_string(team)) + ' ' + std::to_string(board.points[index]), kTeamColours[index]});
  }
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
