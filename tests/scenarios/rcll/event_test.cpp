// How events of a game are spelt in a journal, and that they come back from there as they were.

#include "scenarios/rcll/rules/event.h"

#include <gmock/gmock.h>

#include "cx/journal/journal_reader.h"
#include "scenarios/rcll/story/board.h"
#include "tests/support/game_story.h"

namespace cxlab::rcll {
namespace {

RecordValue data_of(const Event& event) {
  RecordData data;
  return *decode_record_data(write(event, data).bytes());
}

TEST(Event, IsSpeltAsTheJournalSays) {
  const std::pair<Event, const char*> table[]{
      {PhaseBegan{Phase::kProduction}, R"({"event":"phase","phase":"PRODUCTION"})"},
      {PhaseWasSet{Phase::kPostGame}, R"({"event":"set_phase","phase":"POST_GAME"})"},
      {Prolonged{Prolonged::Kind::kOvertime, 1500}, R"({"event":"overtime","until":1500.0})"},
      {Prolonged{Prolonged::Kind::kSuddenDeath, 1800}, R"({"event":"sudden death","until":1800.0})"},
      {PauseChanged{GameState::kPaused, "scenario", {}, 5.5},
       R"({"event":"state","state":"PAUSED","cause":"scenario","game_time":5.5})"},
      {PauseChanged{GameState::kRunning, "request", "", 7},
       R"({"event":"state","state":"RUNNING","cause":"request","by":"","game_time":7.0})"},
      {OrderPublished{3, "C1", "BASE_RED RING_BLUE CAP_GREY", 60, 120.5, 2, 1, true},
       R"({"event":"order","order":3,"complexity":"C1","product":"BASE_RED RING_BLUE CAP_GREY","begin":60.0,"end":120.5,"gate":2,"quantity":1,"competitive":true})"},
      {MachineReported{Team::kCyan, "C-CS1", "CS", "", -1, true, ""},
       R"({"event":"report","team":"CYAN","machine":"C-CS1","type":"CS","zone":"","rotation":-1,"judged":true})"},
      {MachineReported{Team::kMagenta, {}, {}, {}, {}, false, "no"},
       R"({"event":"report","team":"MAGENTA","judged":false,"reason":"no"})"},
      {MachineChanged{"C-BS", "PROCESSING"}, R"({"event":"machine","machine":"C-BS","state":"PROCESSING"})"},
      {MachineBroke{"C-RS1", "empty"}, R"({"event":"broken","machine":"C-RS1","reason":"empty"})"},
      {InstructionHeard{"C-BS", "", "OUTPUT", "BASE_RED", "", {}, {}, {}, 0},
       R"({"event":"instruction","machine":"C-BS","side":"OUTPUT","base_color":"BASE_RED","code":0})"},
      {InstructionHeard{"C-DS", "", "", "", "", 0, {}, {}, 100},
       R"({"event":"instruction","machine":"C-DS","order":0,"code":100})"},
      {InstructionHeard{"C-SS", "STORE", "", "", "", {}, 0, 7, 0},
       R"({"event":"instruction","machine":"C-SS","operation":"STORE","shelf":0,"slot":7,"code":0})"},
      {InstructionHeard{"C-RS1", "", "", "", "RING_BLUE", {}, {}, {}, 0},
       R"({"event":"instruction","machine":"C-RS1","ring_color":"RING_BLUE","code":0})"},
      {WorkDone{WorkDone::Kind::kCapRetrieved, "C-CS1", 4, "BASE_CLEAR", {}, {}, {}},
       R"({"event":"cap_retrieved","machine":"C-CS1","piece":4,"product":"BASE_CLEAR"})"},
      {WorkDone{WorkDone::Kind::kMounted, "C-RS1", 4, "BASE_RED RING_BLUE", 0, {}, {}},
       R"({"event":"mounted","machine":"C-RS1","piece":4,"product":"BASE_RED RING_BLUE","payments":0})"},
      {WorkDone{WorkDone::Kind::kStored, "C-SS", 4, "BASE_RED", {}, 1, 2},
       R"({"event":"stored","machine":"C-SS","piece":4,"product":"BASE_RED","shelf":1,"slot":2})"},
      {WorkDone{WorkDone::Kind::kUnstored, "C-SS", 4, "BASE_RED", {}, 1, 2},
       R"({"event":"unstored","machine":"C-SS","piece":4,"product":"BASE_RED","shelf":1,"slot":2})"},
      {Relocated{"C-SS", "BASE_RED", 1, 2, 3, 4},
       R"({"event":"relocated","machine":"C-SS","product":"BASE_RED","from_shelf":1,"from_slot":2,"shelf":3,"slot":4})"},
      {NoSparePiece{"C-BS"}, R"({"event":"no_spare_piece","machine":"C-BS"})"},
      {PieceMoved{7, "gripper", "robot1", "floor", "", {1, -2.5, 0}},
       R"({"event":"piece","piece":7,"from":"gripper","from_name":"robot1","to":"floor","position":[1.0,-2.5,0.0]})"},
      {PieceMoved{8, "floor", "", "slot", "C-CS1-INPUT", {}},
       R"({"event":"piece","piece":8,"from":"floor","to":"slot","to_name":"C-CS1-INPUT","position":[0.0,0.0,0.0]})"},
      {PointsGiven{Team::kMagenta, "ring", 5, 12, 0},
       R"({"event":"score","team":"MAGENTA","kind":"ring","points":5,"total":12})"},
      {PointsGiven{Team::kCyan, "late", -5, -3, 4},
       R"({"event":"score","team":"CYAN","kind":"late","points":-5,"total":-3,"order":4})"},
      {DutyChanged{"begin", Team::kCyan, "robot1", "fault", 1, {}, {}, {}, ""},
       R"({"event":"maintenance","state":"begin","team":"CYAN","robot":"robot1","cause":"fault","cycle":1})"},
      {DutyChanged{"warning", Team::kCyan, "robot1", "", {}, 15, {}, {}, ""},
       R"({"event":"maintenance","state":"warning","team":"CYAN","robot":"robot1","remaining_s":15.0})"},
      {DutyChanged{"end", Team::kCyan, "robot1", "", {}, {}, 30, {}, ""},
       R"({"event":"maintenance","state":"end","team":"CYAN","robot":"robot1","duration_s":30.0})"},
      {DutyChanged{"refused", Team::kCyan, "", "", {}, {}, {}, 4, "no such robot"},
       R"({"event":"maintenance","state":"refused","team":"CYAN","number":4,"reason":"no such robot"})"},
      {DeliveryUnconfirmed{1, 2, Team::kCyan, 3, "BASE_RED"},
       R"({"event":"unconfirmed","delivery":1,"order":2,"team":"CYAN","piece":3,"product":"BASE_RED"})"},
      {DeliveryJudged{2, Team::kCyan, 3, "BASE_RED", true, 20, 0, ""},
       R"({"event":"delivery","order":2,"team":"CYAN","piece":3,"product":"BASE_RED","correct":true,"points":20,"late_s":0.0})"},
      {DeliveryJudged{2, Team::kCyan, 3, "BASE_RED", false, 0, 9, "early"},
       R"({"event":"delivery","order":2,"team":"CYAN","piece":3,"product":"BASE_RED","correct":false,"points":0,"reason":"early"})"},
      {Discarded{3, "BASE_RED"}, R"({"event":"discard","piece":3,"product":"BASE_RED"})"},
  };
  std::set<std::size_t> kinds;
  for (const auto& [event, json] : table) {
    EXPECT_EQ(to_json(data_of(event)), json);
    const auto again = read_event(data_of(event));
    ASSERT_TRUE(again) << json;
    EXPECT_EQ(again->index(), event.index()) << json;
    EXPECT_EQ(to_json(data_of(*again)), json);
    kinds.insert(event.index());
  }
  EXPECT_EQ(kinds.size(), std::variant_size_v<Event>) << "an event is missing in the table";
}

TEST(Event, WhatIsNoneIsNotRead) {
  for (const char* event : {"", "Phase", "phases", "score "}) {
    RecordData data;
    data.begin().field("event", event).field("phase", "SETUP");
    EXPECT_FALSE(read_event(*decode_record_data(data.bytes()))) << event;
  }
  EXPECT_FALSE(read_event({}));
}

TEST(Event, AFieldThatIsMissingOrOfAnotherTypeHasItsDefault) {
  RecordData data;
  data.begin().field("event", "order").field("order", "three").field("begin", 5).field("competitive", 1);
  const auto order = std::get<OrderPublished>(*read_event(*decode_record_data(data.bytes())));
  EXPECT_EQ(order.id, 0);
  EXPECT_EQ(order.begin, 5) << "a whole number is a number";
  EXPECT_EQ(order.gate, 1);
  EXPECT_FALSE(order.competitive);
  data.begin().field("event", "score").field("team", "RED");
  EXPECT_EQ(std::get<PointsGiven>(*read_event(*decode_record_data(data.bytes()))).team, std::nullopt);
}

/// A game with products, a late and a wrong delivery, and a pause; `at_each_second` is called as it goes on.
template <class Look>
void play_game(GameStory& story, const Look& at_each_second) {
  const auto until = [&](double seconds) {
    while (story.now() < seconds) {
      story.run_until(std::floor(story.now()) + 1);
      at_each_second();
    }
  };
  until(20);
  story.make_product("BASE_RED", "CS1");
  at_each_second();
  story.put("C-DS-INPUT");
  EXPECT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  at_each_second();
  until(story.now() + 30);
}

WorldConfig game_with_a_pause() {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].delivery_begin = 0;
  config.orders[0].delivery_end = 20;
  config.setup_s = 3;
  config.pauses = {{2, 10}, {100, 7}};
  return config;
}

TEST(Event, EachRecordOfTheRefereeIsOne) {
  GameStory story(game_with_a_pause());
  play_game(story, [] {});
  std::set<std::string> words;
  for (const KeptRecords::Record& record : story.records().of(RecordKind::kReferee)) {
    const auto data = decode_record_data(record.data);
    ASSERT_TRUE(data);
    const auto event = read_event(*data);
    ASSERT_TRUE(event) << to_json(*data);
    EXPECT_EQ(data_of(*event), *data) << to_json(*data);
    words.emplace(data->text("event"));
  }
  for (const char* word :
       {"phase", "order", "instruction", "machine", "piece", "cap_retrieved", "mounted", "delivery", "score", "state"})
    EXPECT_TRUE(words.contains(word)) << word;
}

/// What the board must tell, as referee and floor have it.
Board truth(const Factory& game, const WorldConfig& config) {
  const SimTime now = game.floor().floor_time();
  Board board;
  board.phase = to_string(game.clock().phase(now));
  board.game_time = game.clock().game_time(now);
  board.paused = game.state() == GameState::kPaused;
  board.teams = teams_of(config);
  for (const Team team : kTeams) board.points[static_cast<std::size_t>(team)] = game.referee().score(team).total();
  for (const OrderState& state : game.referee().orders()) {
    if (!state.released) continue;
    const Order& order = state.order;
    board.orders.push_back({order.id, std::string(to_string(order.complexity)), stack_of(order.product),
                            order.delivery_begin, order.delivery_end, order.quantity, order.delivery_gate,
                            order.competitive, state.delivered});
  }
  return board;
}

TEST(Event, TheBoardOfThemIsThatOfTheRefereeWhileTheGameIsPlayedAndAfterwards) {
  const WorldConfig config = game_with_a_pause();
  GameStory story(config);
  BoardKeeper keeper(config);
  RecordedBoard recorded(config);
  for (const KeptRecords::Record& record : story.records().of(RecordKind::kReferee))
    keeper.apply(record.t, *read_event(*decode_record_data(record.data)));
  story.factory().events().listen([&](SimTime t, const Event& event) { keeper.apply(t, event); });
  std::vector<std::pair<SimTime, Board>> live;
  play_game(story, [&] {
    live.emplace_back(story.world().now(), truth(story.factory(), config));
    EXPECT_EQ(keeper.at(story.world().now()), live.back().second) << story.now();
  });
  for (const KeptRecords::Record& record : story.records().of(RecordKind::kReferee))
    recorded.take(record.t, *read_event(*decode_record_data(record.data)));
  ASSERT_GT(live.size(), 30u);
  bool paused = false, points = false;
  for (const auto& [t, board] : live) {
    const Board then = recorded.at(t);
    EXPECT_EQ(then, board) << to_seconds(t) << " s: " << then.phase << ' ' << then.game_time << ", live " << board.phase
                           << ' ' << board.game_time;
    paused = paused || board.paused;
    points = points || board.points[0] != 0;
  }
  EXPECT_TRUE(paused && points);
}

}  // namespace
}  // namespace cxlab::rcll
