#pragma once
// The settings of a game of the Logistics League, a scenario's `world:`. The structs are their own schema: each field
// is a key of that name, with unit, default and meaning.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/origin.h"
#include "scenarios/rcll/rules/types.h"

namespace cxlab::rcll {

/// Where the rulebook and the referee box differ. `league`: scores and breaks as the referee box, machines turned as
/// the rulebook has them. `refbox` and `rulebook`: all as the one or the other.
enum class Rules : std::uint8_t { kLeague, kRefbox, kRulebook };
template <>
inline constexpr std::array<std::string_view, 3> kNames<Rules>{"league", "refbox", "rulebook"};

/// How much of the machines the team hears.
enum class Information : std::uint8_t {
  kLeague,  ///< what the referee box sends: its own machines; no lights, payments, caps, poses
  kAll,     ///< all there is, of both teams
};
template <>
inline constexpr std::array<std::string_view, 2> kNames<Information>{"league", "all"};

/// The differences one by one.
struct RuleChoices {
  bool shelf_faces_wall = false;  ///< refbox: shelf and slide of a machine at the outer side wall face that wall
  bool late_in_fifths = false;  ///< rulebook: 15 % of the delivery points a fifth of the window, else 18.75 % a quarter
  bool second_prepare_breaks = false;  ///< rulebook: instructing a busy machine breaks it, else it is ignored
  bool delivery_may_wait = false;      ///< rulebook: a DS waits for its window without limit, else 20 s
  bool down_stops_work = false;        ///< rulebook: a machine that is down stands still, else its hardware goes on
  bool second_keeps_points = false;    ///< rulebook: the second competitive delivery costs no more than it is worth
  /// Rulebook: points that a person gives, for a machine instructed without a workpiece, and for a workpiece dropped or
  /// put on the other team's machine.
  bool by_hand = false;
  bool overtime_at_nil = true;      ///< referee box: overtime also when no team has a point
  bool sudden_death = false;        ///< rulebook: an overtime that ends even goes on until a team leads
  bool storage_serves_one = false;  ///< rulebook: one C0 of the storage station counts, and none in overtime

  // What the referee box does and the rulebook does not say.
  bool down_hides_broken = true;    ///< a base on the slide of a station that is BROKEN and DOWN counts as a payment
  bool unpaid_again_waits = true;   ///< the second unpaid instruction in a row waits for payments, the first one breaks
  bool reports_by_type = true;      ///< reports are limited by type of machine, not to fourteen (exploration.h)
  bool surplus_cap_counts = true;   ///< the cap of a surplus product that was made after a stored one was delivered
  bool report_hides_broken = true;  ///< a machine that is not reported shows the lights of its report in each state
};
RuleChoices choices_of(Rules rules);

/// One machine of an explicit layout.
struct PlacedMachine {
  std::string machine;  ///< "C-BS", all fourteen of both teams
  std::string zone;     ///< "C_Z23": column 1..7 from the centre line, row 1..8
  int rotation = 0;     ///< degrees, a multiple of 45 in 0..315, counterclockwise: direction from output to input
  Origin origin{};

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("machine", machine);
    keys.required("zone", zone);
    keys("rotation", rotation);
  }
};

/// One order of an explicit list. Times are seconds of the production phase.
struct OrderConfig {
  std::string complexity = "C0";  ///< C0..C3, must agree with the number of rings
  std::string base_color = "BASE_RED";
  std::vector<std::string> ring_colors;  ///< from the base upwards
  std::string cap_color = "CAP_BLACK";
  double activate_at = 0;      ///< s, when it is published
  double delivery_begin = 0;   ///< s, start of the window
  double delivery_end = 1200;  ///< s, end of the window; later is late
  int delivery_gate = 1;       ///< 1..3
  int quantity = 1;            ///< products asked for
  bool competitive = false;    ///< +10 for the team that delivers it first

  template <class Keys>
  void fields(Keys& keys) {
    keys("complexity", complexity);
    keys("base_color", base_color);
    keys("ring_colors", ring_colors);
    keys("cap_color", cap_color);
    keys("activate_at", activate_at);
    keys("delivery_begin", delivery_begin);
    keys("delivery_end", delivery_end);
    keys("delivery_gate", delivery_gate);
    keys("quantity", quantity);
    keys("competitive", competitive);
  }
};

/// A time in which a machine is out of order.
struct DownPeriodConfig {
  std::string machine;  ///< "RS1": that of both teams
  double begin_s = 0;   ///< s of production
  double end_s = 0;

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("machine", machine);
    keys.required("begin_s", begin_s);
    keys.required("end_s", end_s);
  }
};

/// A time in which the game is paused. Times of the game stand meanwhile.
struct PauseConfig {
  double at = 0;       ///< s of production
  double seconds = 0;  ///< how long

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("at", at);
    keys.required("for", seconds);
  }
};

/// Payments that a ring of each colour costs.
struct RingPriceConfig {
  std::array<int, 4> prices{};  ///< 0..2, in the order of kRingColors

  template <class Keys>
  void fields(Keys& keys) {
    for (const RingColor color : kRingColors)
      keys.required(to_string(color), prices[static_cast<std::size_t>(color) - 1]);
  }
};

/// A game as a file (docs/reference/game-files.md). Missing parts are drawn from the seed.
struct GameFile {
  std::optional<bool> mirrored;                       ///< false: the halves of the field may differ
  std::optional<std::vector<PlacedMachine>> layout;   ///< all fourteen machines
  std::optional<RingPriceConfig> ring_prices;         ///< all four colours
  std::optional<std::vector<OrderConfig>> orders;     ///< numbered from 1
  std::optional<OrderConfig> overtime;                ///< the order of overtime
  std::optional<std::vector<DownPeriodConfig>> down;  ///< when machines are out of order

  template <class Keys>
  void fields(Keys& keys) {
    keys("mirrored", mirrored);
    keys("layout", layout);
    keys("ring_prices", ring_prices);
    keys("orders", orders);
    keys("overtime", overtime);
    keys("down", down);
  }
};

/// The referee box on the network (docs/reference/rcll-protocol.md).
struct RefboxConfig {
  std::string team_cyan;                  ///< name of the team; empty: CYAN, until a beacon of the team tells its name
  std::string team_magenta;               ///< the same
  std::string key_cyan = "randomkey";     ///< of the team's channel; empty: not encrypted
  std::string key_magenta = "randomkey";  ///< the same
  std::string cipher = "aes-128-cbc";
  int port_shift = 0;               ///< added to all ports: several games on one machine
  bool controllers = true;          ///< listens on TCP for controllers, who see all and command the game
  bool confirm_deliveries = false;  ///< a delivery counts when a controller says so, not when the product is seen

  template <class Keys>
  void fields(Keys& keys) {
    keys("team_cyan", team_cyan);
    keys("team_magenta", team_magenta);
    keys("key_cyan", key_cyan);
    keys("key_magenta", key_magenta);
    keys.word("cipher", cipher, {"aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc"});
    keys("port_shift", port_shift);
    keys("controllers", controllers);
    keys("confirm_deliveries", confirm_deliveries);
  }
};

/// `world:` of a scenario whose kind is rcll.
struct WorldConfig {
  std::string team = "CYAN";     ///< CYAN, MAGENTA, or BOTH: whose robots and machines play; those of others stand idle
  int robots = 3;                ///< of a team, 0..3
  std::string rules = "league";  ///< league, refbox, rulebook
  std::string game;              ///< a file with all or parts of what is drawn (GameFile)
  std::vector<PlacedMachine> layout;      ///< empty: generated from the seed
  std::vector<OrderConfig> orders;        ///< empty: ten orders drawn from the seed, numbered from 1
  std::vector<std::string> complexities;  ///< of drawn orders; empty: all four, as the referee box draws them
  bool exploration = false;               ///< teams must find and report their machines in the first 180 s
  std::string information = "all";        ///< what a team hears: league (as the referee box sends it), all
  double setup_s = 0;                     ///< s, set-up phase before production
  double production_s = 1200;             ///< s, length of the production phase
  double overtime_s = 300;                ///< s more when the teams are even, with one more order; 0 = none
  double post_game_s = 0;                 ///< s that the run goes on after the game, for agents that report its end
  bool down = true;                       ///< machines are out of order: as drawn or as the file of the game says
  std::vector<PauseConfig> pauses;        ///< when the game is paused, and how long
  bool foresight = false;                 ///< /foresight tells what the game will be
  bool transforms = false;                ///< /tf has where robots are in "map", /tf_static where machines are
  double shelf_refill_s = 20;             ///< s after which a completely empty shelf is filled again
  double repair_s = 30;                   ///< s that people need at least for a robot in maintenance
  RefboxConfig refbox;                    ///< the protocol of the league on the network

  template <class Keys>
  void fields(Keys& keys) {
    keys("team", team);
    keys("robots", robots);
    keys("rules", rules);
    keys("game", game);
    keys("layout", layout);
    keys("orders", orders);
    keys("complexities", complexities);
    keys("exploration", exploration);
    keys("information", information);
    keys("setup_s", setup_s);
    keys("production_s", production_s);
    keys("overtime_s", overtime_s);
    keys("post_game_s", post_game_s);
    keys("down", down);
    keys("pauses", pauses);
    keys("foresight", foresight);
    keys("transforms", transforms);
    keys("shelf_refill_s", shelf_refill_s);
    keys("repair_s", repair_s);
    keys("refbox", refbox);
  }
};

/// The teams that play.
std::vector<Team> teams_of(const WorldConfig& config);
/// Every value in its range and every name known; errors name the key and what was expected.
Status validate(const WorldConfig& config);
Status validate(const GameFile& file);
/// Orders and down periods of the file begin before the end of the game.
Status check_times(const GameFile& file, const WorldConfig& config);

}  // namespace cxlab::rcll
