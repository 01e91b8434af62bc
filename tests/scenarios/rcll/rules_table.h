#pragma once
// The rules of the league, a row each. Rows of machines are about what they accept, their states, how long they work,
// payments, what breaks them, and lights. Rows of the game are about phases, orders, deliveries, points, maintenance,
// and pauses. Rows without a name of rules hold under all three; where referee box and rulebook differ there is a row
// for each. `league` follows the referee box here.
//
// Prices of rings at seed 1: ORANGE 0, YELLOW 0, BLUE 1, GREEN 2.

#include <span>

namespace cxlab::rcll {

struct Row {
  const char* rule;  ///< its place in the rules, and the rule
  const char* script;
  const char* under = "league refbox rulebook";
};

// A referee box that scores as the league does, and the rulebook.
inline constexpr const char* kBox = "league refbox";
inline constexpr const char* kBook = "rulebook";
// What the referee box does in rare cases is played so under `league`, too; the rulebook leaves them open.

std::span<const Row> instruction_rows();
std::span<const Row> work_rows();
std::span<const Row> piece_rows();
std::span<const Row> breaking_rows();
std::span<const Row> game_rows();
std::span<const Row> delivery_rows();
std::span<const Row> exploration_rows();
std::span<const Row> maintenance_rows();
std::span<const Row> pause_rows();

}  // namespace cxlab::rcll
