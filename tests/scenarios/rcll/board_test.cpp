#include "scenarios/rcll/story/board.h"

#include <gmock/gmock.h>

#include "cx/journal/journal_reader.h"
#include "tests/support/game_story.h"

namespace cxlab::rcll {
namespace {

using testing::ElementsAre;

/// An order for a red base with a grey cap that is open from 100 s to 200 s.
WorldConfig one_order(int quantity) {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].delivery_begin = 0;
  config.orders[0].delivery_end = 200;
  config.orders[0].quantity = quantity;
  OrderConfig later;
  later.complexity = "C3";
  later.base_color = "BASE_SILVER";
  later.ring_colors = {"RING_BLUE", "RING_ORANGE", "RING_YELLOW"};
  later.cap_color = "CAP_BLACK";
  later.activate_at = 10;
  later.delivery_begin = 400;
  later.delivery_end = 500;
  config.orders.push_back(later);
  return config;
}

/// The board of a game so far.
Board board_of(const GameStory& story, const WorldConfig& config) {
  BoardKeeper keeper(config);
  for (const KeptRecords::Record& record : story.records().of(RecordKind::kReferee))
    keeper.apply(record.t, *read_event(*decode_record_data(record.data)));
  return keeper.at(from_seconds(story.now()));
}

/// What the cards say: name, window, ticked.
std::vector<std::string> cards(const sim::Legend& legend) {
  std::vector<std::string> out;
  for (const auto& card : legend.cards)
    out.push_back(card.lines[0].text + ", " + card.lines[1].text + (card.ticks.empty() ? "" : ", done"));
  return out;
}

TEST(Board, TellsTimePointsAndPublishedOrders) {
  const WorldConfig config = one_order(2);
  GameStory story(config);
  Board board = board_of(story, config);
  EXPECT_THAT(cards(legend_of(board)), ElementsAre("1 C0 G1 0/2, 0:00-3:20"));
  story.run_until(12);
  board = board_of(story, config);
  EXPECT_THAT(cards(legend_of(board)), ElementsAre("1 C0 G1 0/2, 0:00-3:20", "2 C3 G1, 6:40-8:20"));
  EXPECT_EQ(board.orders[1].product, (sim::Stack{3, {1, 3, 4}, 1}));
  ASSERT_EQ(headline_of(board).size(), 2u);
  EXPECT_EQ(headline_of(board)[0].text, "0:12 PRODUCTION");
  EXPECT_EQ(headline_of(board)[1].text, "CYAN 0");
}

TEST(Board, SaysThatTheGameIsPaused) {
  WorldConfig config = one_order(2);
  config.pauses = {{5, 100}};
  GameStory story(config);
  story.run_until(12);
  EXPECT_EQ(headline_of(board_of(story, config))[0].text, "0:05 PRODUCTION PAUSED");
}

TEST(Board, TicksWhatHasBeenDelivered) {
  const WorldConfig config = one_order(1);
  GameStory story(config);
  story.make_product("BASE_RED", "CS1");
  story.put("C-DS-INPUT");
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  const sim::Legend legend = legend_of(board_of(story, config));
  EXPECT_THAT(cards(legend), ElementsAre("1 C0 G1, 0:00-3:20, done", "2 C3 G1, 6:40-8:20"));
  EXPECT_EQ(headline_of(board_of(story, config))[1].text, "CYAN " + std::to_string(story.score().total()));
  EXPECT_GT(story.score().total(), 0);
}

TEST(Board, ACardHasGateAndCompetitionAndTheTicksOfTheTeams) {
  Board board{{Team::kCyan, Team::kMagenta}, "PRODUCTION", 50, {}, {{4, "C0", {1, {}, 1}, 0, 200, 1, 3, true, {}}}};
  EXPECT_THAT(cards(legend_of(board)), ElementsAre("4 C0 G3 vs, 0:00-3:20"));
  const sim::Legend::Colour cyan = headline_of(board)[1].colour, magenta = headline_of(board)[2].colour;
  board.orders[0].delivered = {0, 1};
  EXPECT_THAT(legend_of(board).cards[0].ticks, ElementsAre(magenta));
  board.orders[0].delivered = {1, 1};
  EXPECT_THAT(legend_of(board).cards[0].ticks, ElementsAre(magenta, cyan));
}

TEST(Board, ColoursSayWhetherTheWindowIsOpen) {
  Board board{{Team::kCyan}, "PRODUCTION", 50, {}, {{1, "C0", {1, {}, 1}, 100, 200, 1, 1, false, {}}}};
  const auto before = legend_of(board).cards[0].lines[0].colour;
  board.game_time = 150;
  const auto open = legend_of(board).cards[0].lines[0].colour;
  board.game_time = 201;
  const auto late = legend_of(board).cards[0].lines[0].colour;
  EXPECT_EQ(open, (sim::Legend::Colour{1, 1, 1}));
  EXPECT_LT(before[0], 1);
  EXPECT_LT(late[1], open[1]);
  EXPECT_EQ(late[0], 1);
}

TEST(Board, OfARecordedGameFollowsAControllerWhoEndsSetUp) {
  const TempFolder folder;
  std::string text;
  auto record = [&text, n = 0](int at_ms, const std::string& data) mutable {
    text += R"({"stream":"referee","n":)" + std::to_string(n++) + R"(,"t":)" + std::to_string(at_ms) +
            R"(000000,"kind":"referee","data":)" + data + ",\"cause\":[]}\n";
  };
  record(10000, R"({"event":"set_phase","phase":"PRODUCTION"})");
  record(10020, R"({"event":"phase","phase":"PRODUCTION"})");
  record(30000, R"({"event":"set_phase","phase":"POST_GAME"})");
  record(30020, R"({"event":"phase","phase":"POST_GAME"})");
  const auto journal = folder.write("journal.jsonl", text);
  WorldConfig config;
  config.setup_s = 100;
  const auto board = RecordedBoard::load(config, journal);
  ASSERT_TRUE(board) << board.error().text();
  for (const auto& [at, title] : {std::pair{9, "0:09 SETUP"}, {12, "0:02 PRODUCTION"}, {29, "0:19 PRODUCTION"}})
    EXPECT_EQ(headline_of(board->at(std::chrono::seconds(at)))[0].text, title) << at;
  EXPECT_EQ(board->at(std::chrono::seconds(31)).phase, "POST_GAME");
}

}  // namespace
}  // namespace cxlab::rcll
