#include <gmock/gmock.h>

#include "cx/journal/record_bytes.h"
#include "scenarios/rcll/game/result.h"
#include "tests/support/game_story.h"

namespace cxlab::rcll {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Game, AC0IsMadeAndDeliveredAndEarnsItsPoints) {
  GameStory story;
  story.make_product("BASE_RED", "CS1");
  EXPECT_EQ(story.score().of(PointKind::kBuffer), 2);
  story.put("C-DS-INPUT");
  const Outcome outcome = story.carry_out("{machine: C-DS, order_id: 1}");
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  ASSERT_EQ(story.deliveries().size(), 1u);
  EXPECT_TRUE(story.deliveries()[0].correct) << story.deliveries()[0].reason;
  EXPECT_EQ(story.deliveries()[0].points, 30);
  EXPECT_EQ(story.score().of(PointKind::kDelivery), 20);
  EXPECT_EQ(story.score().of(PointKind::kCap), 10);
  EXPECT_EQ(story.score().total(), 32);
  EXPECT_EQ(story.score(Team::kMagenta).total(), 0);
  EXPECT_THAT(story.records().text(), HasSubstr("gate"));
}

TEST(BaseStation, ABaseIsReadyAfterDispensingAndTheBelt) {
  GameStory story;
  const double begin = story.now();
  EXPECT_EQ(story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_BLACK}").code, 0);
  EXPECT_NEAR(story.now() - begin, 1.1 + 2.656, 0.1);
  EXPECT_EQ(story.state("C-BS"), "READY-AT-OUTPUT");
  story.run_for(60);
  EXPECT_EQ(story.state("C-BS"), "READY-AT-OUTPUT") << "it waits without limit";
  story.take("C-BS-OUTPUT");
  story.run_for(0.1);
  EXPECT_EQ(story.state("C-BS"), "WAIT-IDLE");
  story.run_for(4.7);
  EXPECT_EQ(story.state("C-BS"), "WAIT-IDLE");
  story.run_for(0.4);
  EXPECT_EQ(story.state("C-BS"), "IDLE");
}

TEST(Game, WhatLastsForATimeLastsForItToTheTick) {
  struct Wait {
    const char* what;
    void (*deeds)(GameStory&);
    bool (*lasts)(const GameStory&);
    double seconds;
  };
  const Wait kWaits[]{
      {"an empty shelf",
       [](GameStory& story) {
         for (const char* slot : {"C-CS1-SHELF-LEFT", "C-CS1-SHELF-MIDDLE", "C-CS1-SHELF-RIGHT"}) {
           story.take(slot);
           story.world().drop(sim::RobotId{0});
         }
       },
       [](const GameStory& story) { return story.nothing_at("C-CS1-SHELF-LEFT"); }, 20.02},  // the next tick sees it
      {"BROKEN", [](GameStory& story) { story.instruct("{machine: C-DS, operation: RESET}"); },
       [](const GameStory& story) { return story.state("C-DS") == "BROKEN"; }, 30},
      {"WAIT-IDLE",
       [](GameStory& story) {
         story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
         story.take("C-BS-OUTPUT");
       },
       [](const GameStory& story) { return story.state("C-BS") == "WAIT-IDLE"; }, 5},
      {"DOWN",
       [](GameStory& story) {
         for (const auto& machine : story.factory().machines())
           if (machine->name() == "C-BS") machine->add_down({from_seconds(3), from_seconds(7.5)});
       },
       [](const GameStory& story) { return story.state("C-BS") == "DOWN"; }, 4.5},
      {"a station that nothing comes to",
       [](GameStory& story) { story.instruct("{machine: C-CS1, operation: RETRIEVE_CAP}"); },
       [](const GameStory& story) { return story.state("C-CS1") == "PREPARED"; }, 20.02},
  };
  for (const Wait& wait : kWaits) {
    WorldConfig config = GameStory::quiet_game();
    config.shelf_refill_s = 20;
    GameStory story(config);
    wait.deeds(story);
    const auto tick_until = [&](bool lasts) {
      for (int i = 0; i < 3000 && wait.lasts(story) != lasts; ++i) story.run_for(0);
      return story.now();
    };
    const double begin = tick_until(true);
    EXPECT_NEAR(tick_until(false) - begin, wait.seconds, 1e-6) << wait.what;
  }
}

TEST(BaseStation, CanGiveAtItsInput) {
  GameStory story;
  EXPECT_EQ(story.carry_out("{machine: C-BS, side: INPUT, base_color: BASE_SILVER}").code, 0);
  ASSERT_NE(story.world().at(story.spot("C-BS-INPUT")), nullptr);
  EXPECT_EQ(story.world().at(story.spot("C-BS-INPUT"))->stack.base, 3);
}

TEST(BaseStation, WithoutAColourItBreaksForHalfAMinute) {
  GameStory story;
  const Outcome outcome = story.carry_out("{machine: C-BS, side: OUTPUT}");
  EXPECT_EQ(outcome.code, 103);
  EXPECT_THAT(outcome.error, HasSubstr("base_color"));
  EXPECT_EQ(story.state("C-BS"), "BROKEN");
  story.run_for(29.5);
  EXPECT_EQ(story.state("C-BS"), "BROKEN");
  story.run_for(0.6);
  EXPECT_EQ(story.state("C-BS"), "IDLE");
}

TEST(CapStation, RetrievingTakes21SecondsAndPassesThroughItsStates) {
  GameStory story;
  story.move("C-CS1-SHELF-MIDDLE", "C-CS1-INPUT");
  const double begin = story.now();
  EXPECT_EQ(story.carry_out("{machine: C-CS1, operation: RETRIEVE_CAP}").code, 0);
  EXPECT_NEAR(story.now() - begin, 1.538 + 17.5 + 2.656, 0.15);
  EXPECT_THAT(story.feedback(), ElementsAre("PREPARED", "PROCESSING", "PROCESSED", "READY-AT-OUTPUT"));
  EXPECT_EQ(story.machine("C-CS1").loaded_with(), 1);
  const sim::Piece* carrier = story.world().at(story.spot("C-CS1-OUTPUT"));
  ASSERT_NE(carrier, nullptr);
  EXPECT_EQ(carrier->stack, (sim::Stack{4, {}, 0}));
}

TEST(CapStation, WithoutAWorkpieceItIsStuckAndBreaksAfter20Seconds) {
  GameStory story;
  const double begin = story.now();
  const Outcome outcome = story.carry_out("{machine: C-CS2, operation: RETRIEVE_CAP}");
  EXPECT_EQ(outcome.code, 202);
  EXPECT_EQ(outcome.status, bus::GoalStatus::kAborted);
  EXPECT_NEAR(story.now() - begin, 20, 0.2);
  EXPECT_EQ(story.state("C-CS2"), "BROKEN");
}

TEST(CapStation, MountingWithoutABufferedCapBreaksIt) {
  GameStory story;
  const Outcome outcome = story.carry_out("{machine: C-CS1, operation: MOUNT_CAP}");
  EXPECT_EQ(outcome.code, 103);
  EXPECT_EQ(story.state("C-CS1"), "BROKEN");
}

TEST(CapStation, RetrievingWithABufferedCapBreaksItAndTakesThePointsBack) {
  GameStory story;
  story.move("C-CS1-SHELF-LEFT", "C-CS1-INPUT");
  ASSERT_EQ(story.carry_out("{machine: C-CS1, operation: RETRIEVE_CAP}").code, 0);
  EXPECT_EQ(story.score().of(PointKind::kBuffer), 2);
  story.take("C-CS1-OUTPUT");
  story.run_for(6);
  EXPECT_EQ(story.carry_out("{machine: C-CS1, operation: RETRIEVE_CAP}").code, 103);
  story.run_for(0.1);
  EXPECT_EQ(story.score().of(PointKind::kBuffer), 0);
  EXPECT_EQ(story.machine("C-CS1").loaded_with(), 1);
  story.run_for(30);
  EXPECT_EQ(story.machine("C-CS1").loaded_with(), 0);
}

TEST(CapStation, FillsItsShelfAgain20SecondsAfterTheLastCarrierWasTaken) {
  GameStory story;
  for (const std::string slot : {"LEFT", "MIDDLE", "RIGHT"}) {
    ASSERT_NE(story.world().at(story.spot("C-CS2-SHELF-" + slot)), nullptr);
    EXPECT_EQ(story.world().at(story.spot("C-CS2-SHELF-" + slot))->stack, (sim::Stack{4, {}, 1})) << "black caps";
    story.take("C-CS2-SHELF-" + slot);
    story.world().drop(sim::RobotId{0});
    story.run_for(1);
  }
  story.run_for(18.5);
  EXPECT_EQ(story.world().at(story.spot("C-CS2-SHELF-LEFT")), nullptr);
  story.run_for(1);
  for (const std::string slot : {"LEFT", "MIDDLE", "RIGHT"})
    EXPECT_NE(story.world().at(story.spot("C-CS2-SHELF-" + slot)), nullptr) << slot;
}

TEST(RingStation, ThreePaymentsScoreAndTheFourthBreaksIt) {
  GameStory story;
  for (int payment = 1; payment <= 4; ++payment) {
    ASSERT_EQ(story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}").code, 0);
    story.move("C-BS-OUTPUT", "C-RS1-SLIDE");
    story.run_for(6);
    EXPECT_EQ(story.score().of(PointKind::kPayment), payment < 4 ? 2 * payment : 0);
    EXPECT_EQ(story.machine("C-RS1").loaded_with(), std::min(payment, 3));
  }
  EXPECT_EQ(story.state("C-RS1"), "BROKEN");
}

TEST(Instructions, ThatCannotBeGivenSayWhy) {
  GameStory story;
  EXPECT_EQ(story.carry_out("{machine: M-BS, side: OUTPUT, base_color: BASE_RED}").code, 101);
  const Outcome unknown = story.carry_out("{machine: C-CS3}");
  EXPECT_EQ(unknown.code, 203);
  EXPECT_THAT(unknown.error, HasSubstr("did you mean 'C-CS"));
  const Outcome colour = story.carry_out("{machine: C-RS1, ring_color: RING_BLUE}");
  EXPECT_EQ(colour.code, 103);
  EXPECT_EQ(colour.error, "ring_color: found 'RING_BLUE', expected RING_ORANGE or RING_GREEN");
  EXPECT_EQ(story.carry_out("{machine: C-SS, operation: RETRIEVE, slot: 8}").error,
            "shelf 0, slot 8: shelves are 0 to 5, slots 0 to 7");
}

TEST(Instructions, ASecondOneIsIgnoredOrByTheRulebookBreaksTheMachine) {
  for (const std::string rules : {"league", "rulebook"}) {
    WorldConfig config = GameStory::quiet_game();
    config.rules = rules;
    GameStory story(config);
    const std::size_t first = story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
    story.run_for(0.5);
    EXPECT_EQ(story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}").code, 209);
    story.run_for(5);
    EXPECT_EQ(story.outcome(first).code, rules == "league" ? 0 : 1);
    EXPECT_EQ(story.state("C-BS"), rules == "league" ? "READY-AT-OUTPUT" : "BROKEN");
  }
}

TEST(Instructions, CancellingEndsTheWaitingNotTheWork) {
  GameStory story;
  const std::size_t goal = story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  story.run_for(1);
  story.cancel(goal);
  story.run_for(0.1);
  EXPECT_EQ(story.outcome(goal).status, bus::GoalStatus::kCanceled);
  story.run_for(5);
  EXPECT_EQ(story.state("C-BS"), "READY-AT-OUTPUT");
}

TEST(Instructions, AMachineThatBreaksIsRecordedWithItsReason) {
  GameStory story;
  EXPECT_EQ(story.carry_out("{machine: C-BS, operation: RESET}").code, 0);
  story.run_for(0.1);
  RecordData expected;
  expected.begin().field("event", "broken").field("machine", "C-BS").field("reason", "reset by its team");
  const std::string wanted(expected.bytes());
  EXPECT_EQ(std::ranges::count(story.records().all(), wanted, &KeptRecords::Record::data), 1);
}

TEST(Instructions, AResetBreaksTheMachineAndWhatItDid) {
  GameStory story;
  const std::size_t goal = story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  story.run_for(2);
  EXPECT_EQ(story.carry_out("{machine: C-BS, operation: RESET}").code, 0);
  EXPECT_EQ(story.state("C-BS"), "BROKEN");
  story.run_for(0.1);
  EXPECT_EQ(story.outcome(goal).code, 1);
  EXPECT_EQ(story.world().on_belt(story.machine("C-BS").id(), 0), nullptr) << "the base was removed";
}

TEST(Records, OfAPieceSayWhereItIs) {
  GameStory story;
  story.move("C-CS1-SHELF-LEFT", "C-CS1-INPUT");
  story.run_for(0.1);
  const sim::Piece& piece = *story.world().at(story.spot("C-CS1-INPUT"));
  RecordData expected;
  expected.begin().field("event", "piece").field("piece", static_cast<std::int64_t>(piece.id));
  expected.field("from", "gripper").field("from_name", "robot1").field("to", "belt").field("to_name", "C-CS1");
  expected.field("position", std::span<const double>(piece.position_in_world.data(), 3));
  const std::string wanted(expected.bytes());
  EXPECT_EQ(std::ranges::count(story.records().all(), wanted, &KeptRecords::Record::data), 1);
  RecordData shelf;
  shelf.begin().field("from_name", "C-CS1-SHELF-LEFT");
  const std::string from_shelf(shelf.bytes().substr(shelf.bytes().find("from_name")));
  EXPECT_TRUE(std::ranges::any_of(story.records().all(), [&](const KeptRecords::Record& record) {
    return record.data.find(from_shelf) != std::string::npos;
  }));
}

TEST(Records, OfAnOrderSayAllAboutIt) {
  WorldConfig config = GameStory::quiet_game();
  OrderConfig& order = config.orders[0];
  order.complexity = "C2";
  order.ring_colors = {"RING_BLUE", "RING_GREEN"};
  order.activate_at = 1;
  order.delivery_begin = 5;
  order.delivery_end = 25;
  order.delivery_gate = 3;
  order.quantity = 2;
  order.competitive = true;
  GameStory story(config);
  story.run_for(2);
  RecordData expected;
  expected.begin().field("event", "order").field("order", 1).field("complexity", "C2");
  expected.field("product", "BASE_RED RING_BLUE RING_GREEN CAP_GREY").field("begin", 5.0).field("end", 25.0);
  expected.field("gate", 3).field("quantity", 2).field("competitive", true);
  const std::string wanted(expected.bytes());
  EXPECT_EQ(std::ranges::count(story.records().all(), wanted, &KeptRecords::Record::data), 1);
}

/// The records of a stream, in JSON.
std::vector<std::string> told(const GameStory& story, std::string_view stream) {
  std::vector<std::string> texts;
  for (const KeptRecords::Record& record : story.records().all()) {
    if (story.records().names()[static_cast<std::size_t>(record.stream)] != stream) continue;
    EXPECT_TRUE(append_json(record.data, texts.emplace_back()).ok());
  }
  return texts;
}

TEST(Records, OfTheRefereeSayWhatItDecided) {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].delivery_end = 5;
  GameStory story(config);
  const auto deliver = [&story](const std::string& base, int order) {
    story.lay_before_delivery(base, CapColor::kGrey);
    EXPECT_EQ(story.carry_out("{machine: C-DS, order_id: " + std::to_string(order) + "}").code, 0);
    story.run_for(6);
  };
  deliver("BASE_BLACK", 1);
  deliver("BASE_RED", 1);
  deliver("BASE_SILVER", 0);
  story.move("C-CS1-SHELF-LEFT", "C-CS1-INPUT");
  EXPECT_EQ(story.carry_out("{machine: C-CS1, operation: RETRIEVE_CAP}").code, 0);
  EXPECT_EQ(story.carry_out("{machine: C-CS1, operation: RESET}").code, 0);
  story.run_for(0.1);
  std::vector<std::string> decided = told(story, "referee");
  std::erase_if(decided, [](const std::string& json) {
    return json.starts_with(R"({"event":"piece",)") || json.starts_with(R"({"event":"machine",)");
  });
  EXPECT_THAT(
      decided,
      ElementsAre(R"({"event":"phase","phase":"PRODUCTION"})",
                  R"({"event":"order","order":1,"complexity":"C0","product":"BASE_RED CAP_GREY","begin":0.0,"end":5.0,)"
                  R"("gate":1,"quantity":1,"competitive":false})",
                  R"({"event":"instruction","machine":"C-DS","order":1,"code":0})",
                  R"({"event":"delivery","order":1,"team":"CYAN","piece":13,"product":"BASE_BLACK CAP_GREY",)"
                  R"("correct":false,"points":0,"reason":"wrong product"})",
                  R"({"event":"instruction","machine":"C-DS","order":1,"code":0})",
                  R"({"event":"score","team":"CYAN","kind":"delivery","points":20,"total":20,"order":1})",
                  R"({"event":"score","team":"CYAN","kind":"late","points":-15,"total":5,"order":1})",
                  R"({"event":"score","team":"CYAN","kind":"cap","points":10,"total":15,"order":1})",
                  R"({"event":"delivery","order":1,"team":"CYAN","piece":14,"product":"BASE_RED CAP_GREY",)"
                  R"("correct":true,"points":15,"late_s":8.58})",
                  R"({"event":"instruction","machine":"C-DS","order":0,"code":0})",
                  R"({"event":"discard","piece":15,"product":"BASE_SILVER CAP_GREY"})",
                  R"({"event":"instruction","machine":"C-CS1","operation":"RETRIEVE_CAP","code":0})",
                  R"({"event":"cap_retrieved","machine":"C-CS1","piece":1,"product":"BASE_CLEAR"})",
                  R"({"event":"score","team":"CYAN","kind":"buffer","points":2,"total":17})",
                  R"({"event":"instruction","machine":"C-CS1","operation":"RESET","code":0})",
                  R"({"event":"broken","machine":"C-CS1","reason":"reset by its team"})",
                  R"({"event":"score","team":"CYAN","kind":"buffer","points":-2,"total":15})"));
}

TEST(Records, OfTheStorageSayWhatWasMovedWhere) {
  GameStory story;
  story.move("C-CS1-SHELF-LEFT", "C-SS-INPUT");
  EXPECT_EQ(story.carry_out("{machine: C-SS, operation: STORE, shelf: 0, slot: 0}").code, 0);
  story.run_for(6);
  EXPECT_EQ(story.carry_out("{machine: C-SS, operation: RETRIEVE, shelf: 0, slot: 1}").code, 0);
  std::vector<std::string> moved = told(story, "referee");
  std::erase_if(moved, [](const std::string& json) {
    return json.find("stored") == json.npos && json.find("relocated") == json.npos;
  });
  ASSERT_EQ(moved.size(), 3u);
  EXPECT_EQ(moved[0],
            R"({"event":"stored","machine":"C-SS","piece":1,"product":"BASE_CLEAR CAP_GREY","shelf":0,"slot":0})");
  EXPECT_THAT(moved[1], testing::StartsWith(R"({"event":"relocated","machine":"C-SS","product":"BASE_CLEAR CAP_GREY",)"
                                            R"("from_shelf":0,"from_slot":0,"shelf":)"));
  EXPECT_THAT(moved[2], testing::HasSubstr(R"("unstored","machine":"C-SS")"));
}

TEST(Records, OfAStoredPieceHaveOneTrack) {
  GameStory story;
  story.move("C-CS1-SHELF-LEFT", "C-SS-INPUT");
  EXPECT_EQ(story.carry_out("{machine: C-SS, operation: STORE, shelf: 0, slot: 0}").code, 0);
  story.run_for(6);
  EXPECT_EQ(story.carry_out("{machine: C-SS, operation: RETRIEVE, shelf: 0, slot: 0}").code, 0);
  std::vector<std::string> steps = told(story, "referee");
  std::erase_if(steps, [](const std::string& json) { return !json.starts_with(R"({"event":"piece","piece":1,)"); });
  for (std::string& step : steps) step.resize(step.find(R"(,"position")"));
  ASSERT_GE(steps.size(), 3u);
  EXPECT_EQ(steps[steps.size() - 2],
            R"({"event":"piece","piece":1,"from":"belt","from_name":"C-SS","to":"storage","to_name":"C-SS")");
  EXPECT_EQ(steps.back(),
            R"({"event":"piece","piece":1,"from":"storage","from_name":"C-SS","to":"belt","to_name":"C-SS")");
}

// --- Deliveries

WorldConfig game_with_window(double begin, double end, double activate = 0) {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].activate_at = activate;
  config.orders[0].delivery_begin = begin;
  config.orders[0].delivery_end = end;
  return config;
}

TEST(Delivery, OfTheWrongProductOrASurplusCountsNothing) {
  GameStory story;
  story.lay_before_delivery("BASE_BLACK", CapColor::kGrey);
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  story.run_for(6);
  for (int i = 0; i < 2; ++i) {
    story.lay_before_delivery("BASE_RED", CapColor::kGrey);
    ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
    story.run_for(6);
  }
  ASSERT_EQ(story.deliveries().size(), 3u);
  EXPECT_EQ(story.deliveries()[0].reason, "wrong product");
  EXPECT_TRUE(story.deliveries()[1].correct);
  EXPECT_EQ(story.deliveries()[2].reason, "surplus");
  EXPECT_EQ(story.score().total(), 30);
}

TEST(Delivery, QuantityTwoTakesTwo) {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].quantity = 2;
  GameStory story(config);
  for (int i = 0; i < 2; ++i) {
    story.lay_before_delivery("BASE_RED", CapColor::kGrey);
    ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
    story.run_for(6);
  }
  EXPECT_EQ(story.score().total(), 60);
}

TEST(Delivery, WaitsForItsWindow) {
  GameStory story(game_with_window(15, 100));
  story.lay_before_delivery("BASE_RED", CapColor::kGrey);
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  EXPECT_NEAR(story.now(), 15 + 3.746, 0.1);
  EXPECT_TRUE(story.deliveries()[0].correct);
}

TEST(Delivery, TimeJumpsToTheBeginOfItsWindow) {
  GameStory story(game_with_window(15.5, 100));
  story.run_until(3.3);
  story.set_jumping(true);
  story.lay_before_delivery("BASE_RED", CapColor::kGrey);
  const std::size_t goal = story.instruct("{machine: C-DS, order_id: 1}");
  story.run_until(40);
  ASSERT_EQ(story.outcome(goal).code, 0);
  EXPECT_NEAR(story.outcome(goal).at, 15.5 + 3.746, 0.06);
}

TEST(Delivery, MoreThan20SecondsBeforeTheWindowBreaksTheStationExceptByTheRulebook) {
  for (const std::string rules : {"league", "rulebook"}) {
    WorldConfig config = game_with_window(40, 100);
    config.rules = rules;
    GameStory story(config);
    story.lay_before_delivery("BASE_RED", CapColor::kGrey);
    EXPECT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, rules == "league" ? 202 : 0);
    EXPECT_EQ(story.deliveries().size(), rules == "league" ? 0u : 1u);
  }
}

TEST(Delivery, LateLosesPartOfItsPoints) {
  GameStory story(game_with_window(0, 100));
  story.run_until(150);
  story.lay_before_delivery("BASE_RED", CapColor::kGrey);
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  ASSERT_TRUE(story.deliveries()[0].correct);
  EXPECT_NEAR(story.deliveries()[0].late_s, 53.8, 0.2);
  EXPECT_EQ(story.score().of(PointKind::kLate), -11);
  EXPECT_EQ(story.score().total(), 19);
}

TEST(Delivery, OfAnOrderThatNobodyHasHeardOfCountsNothing) {
  GameStory story(game_with_window(0, 100, 50));
  story.lay_before_delivery("BASE_RED", CapColor::kGrey);
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  EXPECT_EQ(story.deliveries()[0].reason, "inactive");
  EXPECT_EQ(story.score().total(), 0);
}

TEST(Delivery, OrderZeroDiscardsAndAnUnknownOrderBreaks) {
  GameStory story;
  story.lay_before_delivery("BASE_CLEAR", std::nullopt);
  EXPECT_EQ(story.carry_out("{machine: C-DS, order_id: 0}").code, 0);
  EXPECT_TRUE(story.deliveries().empty());
  story.run_for(6);
  EXPECT_EQ(story.carry_out("{machine: C-DS, order_id: 7}").code, 103);
  EXPECT_EQ(story.state("C-DS"), "BROKEN");
}

TEST(Delivery, TheFirstOfACompetitiveOrderEarnsTenMore) {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].competitive = true;
  GameStory story(config);
  story.lay_before_delivery("BASE_RED", CapColor::kGrey);
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  EXPECT_EQ(story.score().of(PointKind::kCompetitive), 10);
  EXPECT_EQ(story.score().total(), 40);
}

// --- The result

TEST(Result, SaysWhatWasOrderedDeliveredAndEarned) {
  WorldConfig config = game_with_window(5, 20);
  OrderConfig late = config.orders[0], never = config.orders[0];
  late.complexity = "C1";
  late.ring_colors = {"RING_ORANGE"};
  late.activate_at = 10;
  never.activate_at = never.delivery_begin = 500;
  never.delivery_end = 600;
  config.orders.insert(config.orders.end(), {late, never});
  GameStory story(config);
  story.run_until(20);
  story.lay_before_delivery("BASE_RED", CapColor::kGrey);
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
  story.run_for(6);
  story.lay_before_delivery("BASE_RED", CapColor::kGrey);
  ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 2}").code, 0);
  Result result;
  report_teams(story.factory(), result);
  report_orders(story.factory(), result);
  EXPECT_EQ(result.at("teams"),
            R"({"CYAN":{"points":23,"by_kind":{"delivery":20,"ring":0,"cap":10,"buffer":0,"payment":0,"late":-7,)"
            R"("competitive":0,"exploration":0,"penalty":0}},)"
            R"("MAGENTA":{"points":0,"by_kind":{"delivery":0,"ring":0,"cap":0,"buffer":0,"payment":0,"late":0,)"
            R"("competitive":0,"exploration":0,"penalty":0}}})");
  EXPECT_EQ(result.at("orders"),
            R"([{"id":1,"complexity":"C0","ordered":0.0,"delivered_at":23.78,"correct":true,"points":23},)"
            R"({"id":2,"complexity":"C1","ordered":10.0,"delivered_at":null,"correct":false,"points":0},)"
            R"({"id":3,"complexity":"C0","ordered":500.0,"delivered_at":null,"correct":false,"points":0}])");
  EXPECT_EQ(result.at("deliveries"),
            R"([{"order":1,"team":"CYAN","time":23.78,"correct":true,"late_s":3.78,"points":23},)"
            R"({"order":2,"team":"CYAN","time":33.58,"correct":false,"late_s":0.0,"points":0}])");
  EXPECT_EQ(result.score_board,
            "CYAN       23 points   delivery 20  cap 10  late -7\nMAGENTA     0 points \n1 of 3 orders delivered\n");
}

TEST(Result, AnOrderIsDeliveredWhenItsFirstProductIs) {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].quantity = 2;
  GameStory story(config);
  for (int i = 0; i < 2; ++i) {
    story.lay_before_delivery("BASE_RED", CapColor::kGrey);
    ASSERT_EQ(story.carry_out("{machine: C-DS, order_id: 1}").code, 0);
    story.run_for(6);
  }
  Result result;
  report_orders(story.factory(), result);
  EXPECT_EQ(result.at("orders"),
            R"([{"id":1,"complexity":"C0","ordered":0.0,"delivered_at":3.78,"correct":true,"points":60}])");
}

TEST(Result, EachRobotHasItsOwnWorkAndItsOwnDuty) {
  GameStory story;
  story.run_until(100);
  const sim::RobotStats stats[]{{"robot1", 50, 20, 5, 7, 2}, {"robot2", 0, 0, 0, 0, 0}, {"robot3", 99, 1, 0, 9, 4}};
  Maintenance::Robot duties[3];
  duties[1].duty = RobotDuty::kDisqualified;
  duties[2].cycles = 2;
  Result result;
  report_robots(stats, duties, story.world(), result);
  const auto entry = [](const char* work, const char* duty) {
    return std::string(work) + R"(,"contacts":0,"state":")" + duty;
  };
  EXPECT_EQ(result.at("robots"),
            "[" +
                entry(R"({"name":"robot1","busy_s":50.0,"drive_s":20.0,"wait_s":5.0,"skills":7,"failures":2)",
                      R"(ACTIVE","maintenances":0},)") +
                entry(R"({"name":"robot2","busy_s":0.0,"drive_s":0.0,"wait_s":0.0,"skills":0,"failures":0)",
                      R"(DISQUALIFIED","maintenances":0},)") +
                entry(R"({"name":"robot3","busy_s":99.0,"drive_s":1.0,"wait_s":0.0,"skills":9,"failures":4)",
                      R"(ACTIVE","maintenances":2}])"));
  EXPECT_EQ(result.score_board,
            "robot1   at work  50 %, driving  20 %, 7 skills, 2 failed, 0 contacts\n"
            "robot2   at work   0 %, driving   0 %, 0 skills, 0 failed, 0 contacts, disqualified\n"
            "robot3   at work  99 %, driving   1 %, 9 skills, 4 failed, 0 contacts, 2 in maintenance\n");
  EXPECT_THAT(result.tallies, ElementsAre("skills failed: robot1 2 of 7, robot3 4 of 9"));
  EXPECT_THAT(result.warnings, testing::IsEmpty());
  Result idle;
  report_robots({&stats[1], 1}, {&duties[1], 1}, story.world(), idle);
  EXPECT_THAT(idle.tallies, testing::IsEmpty());
  EXPECT_THAT(idle.warnings, ElementsAre("no robot was given a skill in the whole game"));
}

// --- The referee alone

MachineEvent delivered(const sim::FloorPlan& plan, const std::string& machine, double at, const sim::Stack& stack) {
  MachineEvent event;
  event.kind = MachineEvent::Kind::kDelivery;
  event.machine = *plan.find_station(machine);
  event.at = from_seconds(at);
  event.order_id = 1;
  event.stack = stack;
  return event;
}

TEST(Referee, ATeamThatIsSecondWithACompetitiveOrderLosesTen) {
  WorldConfig config = GameStory::quiet_game();
  config.orders[0].competitive = true;
  const sim::FloorPlan plan = floor_plan_of(config, game_of(config, 1)->layout);
  KeptRecords sink;
  EventLog log(sink);
  GameReferee referee(GameClock{}, {}, game_of(config, 1)->schedule, plan, log);
  referee.judge(SimTime{}, {}, {});
  const sim::Stack product{1, {}, 2};
  const std::vector events{delivered(plan, "M-DS", 10, product), delivered(plan, "C-DS", 20, product)};
  referee.judge(from_seconds(20), {}, events);
  EXPECT_EQ(referee.score(Team::kMagenta).of(PointKind::kCompetitive), 10);
  EXPECT_EQ(referee.score(Team::kCyan).of(PointKind::kCompetitive), -10);
}

TEST(Referee, BeforeTheWindowCountsNothingAtItsStartItCounts) {
  const WorldConfig config = game_with_window(100, 200);
  const sim::FloorPlan plan = floor_plan_of(config, game_of(config, 1)->layout);
  KeptRecords sink;
  EventLog log(sink);
  GameReferee referee(GameClock{}, {}, game_of(config, 1)->schedule, plan, log);
  referee.judge(SimTime{}, {}, {});
  const sim::Stack product{1, {}, 2};
  referee.judge(from_seconds(99.98), {}, std::vector{delivered(plan, "C-DS", 99.98, product)});
  EXPECT_EQ(referee.deliveries()[0].reason, "early");
  referee.judge(from_seconds(100), {}, std::vector{delivered(plan, "C-DS", 100, product)});
  EXPECT_TRUE(referee.deliveries()[1].correct) << "the early one has used nothing up";
}

TEST(Referee, DeliveriesThatAreToBeConfirmedCountWhenTheyAre) {
  const WorldConfig config = game_with_window(100, 200);
  const sim::FloorPlan plan = floor_plan_of(config, game_of(config, 1)->layout);
  KeptRecords sink;
  EventLog log(sink);
  GameReferee referee(GameClock{}, {}, game_of(config, 1)->schedule, plan, log);
  EXPECT_EQ(referee.confirm(1, true, from_seconds(1)), "what lies under a gate is seen");
  referee.wait_for_confirmation();
  referee.judge(SimTime{}, {}, {});
  const sim::Stack right{1, {}, 2}, wrong{2, {}, 2};
  const std::vector events{delivered(plan, "C-DS", 99, right), delivered(plan, "C-DS", 210, right),
                           delivered(plan, "C-DS", 220, wrong), delivered(plan, "M-DS", 230, wrong)};
  referee.judge(from_seconds(230), {}, events);
  EXPECT_TRUE(referee.deliveries().empty());
  ASSERT_EQ(referee.unconfirmed().size(), 4u);
  EXPECT_EQ(referee.unconfirmed()[3].id, 4);
  EXPECT_EQ(referee.unconfirmed()[3].team, Team::kMagenta);

  struct Row {
    std::int64_t id;
    bool word;
    std::string problem, reason;
  };
  for (const Row& row :
       {Row{5, true, "no delivery 5 waits for it", "-"}, Row{2, false, "", "not confirmed"},
        Row{2, true, "no delivery 2 waits for it", "-"}, Row{1, true, "", "early"}, Row{3, true, "", ""}}) {
    const std::size_t judged = referee.deliveries().size();
    EXPECT_EQ(referee.confirm(row.id, row.word, from_seconds(400)), row.problem);
    ASSERT_EQ(referee.deliveries().size(), judged + (row.reason == "-" ? 0 : 1)) << row.id;
    if (row.reason != "-") {
      EXPECT_EQ(referee.deliveries().back().reason, row.reason) << row.id;
    }
  }
  EXPECT_EQ(referee.deliveries().back().late_s, 20) << "late is what the delivery is, not the word";
  EXPECT_EQ(referee.score(Team::kCyan).of(PointKind::kLate), -3);
  EXPECT_EQ(referee.score(Team::kCyan).of(PointKind::kCap), 10);
  EXPECT_EQ(sink.all().back().t, from_seconds(400));
}

TEST(Referee, AControllerEndsSetUpAndTheGame) {
  WorldConfig config = game_with_window(100, 200, 30);
  config.exploration = true;
  const sim::FloorPlan plan = floor_plan_of(config, game_of(config, 1)->layout);
  KeptRecords sink;
  EventLog log(sink);
  GameReferee referee(GameClock::of(50, 300), {}, game_of(config, 1)->schedule, plan, log, true);
  referee.judge(SimTime{}, {}, {});
  EXPECT_EQ(referee.set_phase(Phase::kSetup, from_seconds(10)), "");
  referee.judge(from_seconds(10), {}, {});
  EXPECT_EQ(referee.next_due(), from_seconds(50));
  EXPECT_EQ(referee.set_phase(Phase::kProduction, from_seconds(10)), "");
  EXPECT_LE(referee.next_due(), from_seconds(10)) << "the next tick sees it";
  referee.judge(from_seconds(11), {}, {});
  EXPECT_EQ(referee.phase(), Phase::kProduction);
  EXPECT_EQ(referee.clock().game_time(from_seconds(11)), 1);
  EXPECT_EQ(referee.clock().production_end, from_seconds(310)) << "production is as long as ever";
  EXPECT_EQ(referee.next_due(), from_seconds(40)) << "an order of 30 s of production";
  EXPECT_EQ(referee.exploration().end(), from_seconds(190) + SimTime{1});
  EXPECT_NE(referee.set_phase(Phase::kSetup, from_seconds(20)), "");
  EXPECT_EQ(referee.set_phase(Phase::kPostGame, from_seconds(20)), "");
  referee.judge(from_seconds(21), {}, {});
  EXPECT_EQ(referee.phase(), Phase::kPostGame) << "no overtime, though the teams are even";
  EXPECT_NE(referee.set_phase(Phase::kProduction, from_seconds(22)), "");
}

TEST(Referee, WhatIsDeliveredForNoOrderIsDiscarded) {
  const WorldConfig config = GameStory::quiet_game();
  const sim::FloorPlan plan = floor_plan_of(config, game_of(config, 1)->layout);
  KeptRecords sink;
  EventLog log(sink);
  GameReferee referee(GameClock{}, {}, game_of(config, 1)->schedule, plan, log);
  referee.judge(SimTime{}, {}, {});
  for (const int order : {0, 2, 99, -1}) {
    MachineEvent event = delivered(plan, "C-DS", 10, {1, {}, 2});
    event.order_id = order;
    referee.judge(from_seconds(10), {}, std::vector{event});
    std::string json;
    EXPECT_TRUE(append_json(sink.all().back().data, json).ok());
    EXPECT_THAT(json, HasSubstr("\"event\":\"discard\"")) << order;
  }
  EXPECT_TRUE(referee.deliveries().empty());
  EXPECT_EQ(referee.score(Team::kCyan).total(), 0);
}

TEST(Referee, IsNextDueAtTheNextPhaseOrOrder) {
  WorldConfig config = game_with_window(100, 200, 30);
  config.orders.push_back(config.orders[0]);
  config.orders[1].activate_at = 70;
  const sim::FloorPlan plan = floor_plan_of(config, game_of(config, 1)->layout);
  KeptRecords sink;
  EventLog log(sink);
  GameReferee referee(GameClock::of(10, 300, 0), {}, game_of(config, 1)->schedule, plan, log);
  EXPECT_EQ(referee.next_due(), SimTime{});
  for (const auto& [at, next] : {std::pair{0.0, 10.0}, {10.0, 40.0}, {39.99, 40.0}, {40.0, 80.0}, {80.0, 310.0}}) {
    referee.judge(from_seconds(at), {}, {});
    EXPECT_EQ(referee.next_due(), from_seconds(next)) << at;
  }
  referee.judge(from_seconds(310), {}, {});
  EXPECT_EQ(referee.next_due(), kNever);
}

TEST(Referee, DeductsForLatenessAsTheRefereeBoxAndAsTheRulebook) {
  // Figures of the referee box.
  EXPECT_EQ(late_deduction(30, 0.05 * 120, 120, false), 5);
  EXPECT_EQ(late_deduction(100, 0.33 * 200, 200, false), 37);
  EXPECT_EQ(late_deduction(20, 0.64 * 100, 100, false), 11);
  EXPECT_EQ(late_deduction(50, 0.93 * 150, 150, false), 37);
  EXPECT_EQ(late_deduction(20, 5000, 100, false), 15) << "never more than 75 %";
  EXPECT_EQ(late_deduction(20, 0, 100, false), 0);
  EXPECT_EQ(late_deduction(100, 19, 100, true), 15);
  EXPECT_EQ(late_deduction(100, 21, 100, true), 30);
}

// --- Down periods, phases, topics

TEST(Game, OneRingAndOneCapStationOfBothTeamsAreDownOnce) {
  WorldConfig config = GameStory::quiet_game();
  config.down = true;
  GameStory story(config);
  std::map<std::string, int> down;
  for (int second = 0; second < 1200; ++second) {
    story.run_for(1);
    for (const auto& machine : story.factory().machines())
      if (machine->state() == MachineState::kDown) ++down[machine->name()];
  }
  ASSERT_EQ(down.size(), 4u);
  for (const auto& [name, seconds] : down) {
    EXPECT_THAT(name, testing::AnyOf(HasSubstr("-RS"), HasSubstr("-CS")));
    EXPECT_GE(seconds, 29);
    EXPECT_LE(seconds, 61);
  }
}

TEST(Instructions, CancellingOneLeavesTheOthers) {
  GameStory story;
  story.move("C-CS1-SHELF-LEFT", "C-CS1-INPUT");
  const std::size_t base = story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  const std::size_t cap = story.instruct("{machine: C-CS1, operation: RETRIEVE_CAP}");
  const std::size_t broken = story.instruct("{machine: C-CS2, operation: RETRIEVE_CAP}");
  story.run_for(1);
  const auto told = story.feedback().size();
  story.cancel(cap);
  story.run_for(0.1);
  EXPECT_EQ(story.outcome(cap).status, bus::GoalStatus::kCanceled);
  EXPECT_FALSE(story.outcome(base).ended);
  story.run_for(30);
  EXPECT_EQ(story.outcome(base).status, bus::GoalStatus::kSucceeded);
  EXPECT_EQ(story.outcome(broken).status, bus::GoalStatus::kAborted);
  EXPECT_THAT(std::vector(story.feedback().begin() + static_cast<std::ptrdiff_t>(told), story.feedback().end()),
              ElementsAre("PROCESSED", "READY-AT-OUTPUT", "BROKEN"));
}

TEST(Game, AMachineFailsInProductionOnlyAndOnce) {
  WorldConfig config = GameStory::quiet_game();
  config.setup_s = 5;
  config.production_s = 20;
  GameStory story(config);
  Machine& machine = *story.factory().machines().front();
  struct Row {
    double at;
    bool fails;
    MachineState state;
  };
  for (const Row& row : {Row{4, false, MachineState::kIdle}, Row{6, true, MachineState::kBroken},
                         Row{7, false, MachineState::kBroken}, Row{26, false, MachineState::kBroken}}) {
    story.run_until(row.at);
    EXPECT_EQ(machine.fail(story.world().now(), story.world(), "a test"), row.fails) << row.at;
    EXPECT_EQ(machine.state(), row.state) << row.at;
  }
}

TEST(Game, AControllerBreaksAMachineAndRepairsIt) {
  WorldConfig config = GameStory::quiet_game();
  config.setup_s = 5;
  GameStory story(config);
  Factory& factory = story.factory();
  EXPECT_EQ(factory.reset_machine("C-CS1"), "C-CS1 is IDLE in SETUP");
  EXPECT_EQ(factory.set_phase(Phase::kProduction), "");
  story.run_for(1);
  story.move("C-CS1-SHELF-LEFT", "C-CS1-INPUT");
  ASSERT_EQ(story.carry_out("{machine: C-CS1, operation: RETRIEVE_CAP}").code, 0);
  EXPECT_EQ(factory.repair_machine("C-CS1"), "C-CS1 is READY-AT-OUTPUT, not BROKEN");
  EXPECT_EQ(story.machine("C-CS1").loaded_with(), 1);
  EXPECT_EQ(factory.reset_machine("C-CS1"), "");
  EXPECT_EQ(story.state("C-CS1"), "BROKEN");
  EXPECT_NE(factory.reset_machine("C-CS1"), "");
  EXPECT_EQ(factory.repair_machine("C-CS1"), "");
  EXPECT_EQ(story.state("C-CS1"), "IDLE");
  EXPECT_EQ(story.machine("C-CS1").loaded_with(), 0);
  story.run_for(1);
  EXPECT_EQ(story.score().of(PointKind::kBuffer), 0) << "the points for the cap are gone";
  EXPECT_EQ(factory.reset_machine("C-CS3").find("no machine"), 0u) << factory.reset_machine("C-CS3");
}

TEST(Game, DownTimesFollowTheBeginningOfProduction) {
  WorldConfig config;
  config.setup_s = 100;
  const TempFolder folder;
  config.game = put_file(folder / "down.yaml", "down: [{machine: CS1, begin_s: 3, end_s: 5}]").string();
  GameStory story(config);
  story.run_until(10);
  EXPECT_EQ(story.factory().set_phase(Phase::kProduction), "");
  for (const auto& [at, state] : {std::pair{12.9, "IDLE"}, {13.1, "DOWN"}, {14.9, "DOWN"}, {15.1, "IDLE"}}) {
    story.run_until(at);
    EXPECT_EQ(story.state("C-CS1"), state) << at;
  }
}

TEST(Game, AMachineIsDownFromTheFirstTickOfItsTimeToTheLastBeforeItsEnd) {
  GameStory story;
  Machine& machine = *story.factory().machines().front();
  constexpr SimTime kTick = std::chrono::milliseconds(20);
  const SimTime begin = story.world().now();
  machine.add_down({begin + 2 * kTick, begin + 4 * kTick});
  std::vector<MachineState> states;
  for (int tick = 1; tick <= 5; ++tick) {
    story.run_for(0);
    EXPECT_EQ(story.world().now(), begin + tick * kTick);
    states.push_back(machine.state());
  }
  using enum MachineState;
  EXPECT_THAT(states, testing::ElementsAre(kIdle, kDown, kDown, kIdle, kIdle));
}

TEST(Game, MachinesChangeTheirStatesAtTheMillisecond) {
  struct Row {
    const char *machine, *instruction;
    bool with_piece;
    int gate;
    double until;
    const char* wanted;  ///< states, with the milliseconds since the one before
  };
  const Row rows[] = {
      {"C-BS", "side: OUTPUT, base_color: BASE_RED", false, 1, 4, "PROCESSING 1100 PROCESSED 2656 READY-AT-OUTPUT"},
      {"C-CS1", "operation: RETRIEVE_CAP", true, 1, 22,
       "PREPARED 1538 PROCESSING 17500 PROCESSED 2656 READY-AT-OUTPUT"},
      {"C-CS1", "operation: RETRIEVE_CAP", false, 1, 51, "PREPARED 20001 BROKEN 30000 IDLE"},
      {"C-DS", "order_id: 1", true, 1, 9, "PROCESSING 3746 PROCESSED 1 WAIT-IDLE 5000 IDLE"},
      {"C-DS", "order_id: 1", true, 2, 5, "PROCESSING 4746 PROCESSED 1 WAIT-IDLE"},
      {"C-DS", "order_id: 1", true, 3, 5, "PROCESSING 3983 PROCESSED 1 WAIT-IDLE"},
  };
  for (const Row& row : rows) {
    WorldConfig config = GameStory::quiet_game();
    config.orders[0].delivery_gate = row.gate;
    GameStory story(config, 1, std::chrono::milliseconds(1));
    const Machine& machine = story.machine(row.machine);
    if (row.with_piece) {
      ASSERT_TRUE(story.world().dispense(machine.id(), 0, {1, {}, 2}));
    }
    story.instruct("{machine: " + std::string(row.machine) + ", " + row.instruction + "}");
    std::string states;
    MachineState last = machine.state();
    for (double since = story.now(); story.now() < row.until;) {
      story.run_for(0);
      if (machine.state() == last) continue;
      last = machine.state();
      states += (states.empty() ? "" : " " + std::to_string(std::lround(1000 * (story.now() - since))) + " ") +
                std::string(to_string(last));
      since = story.now();
    }
    EXPECT_EQ(states, row.wanted) << row.machine << ' ' << row.instruction << ", gate " << row.gate;
  }
}

TEST(Game, MachinesAreDownAsAWholeWithinProductionOrNotAtAll) {
  const auto seconds_down = [](double production_s, std::uint64_t seed) {
    WorldConfig config = GameStory::quiet_game();
    config.down = true;
    config.production_s = production_s;
    GameStory story(config, seed);
    std::map<std::string, int> down;
    for (int second = 0; second < 240; ++second) {
      story.run_for(1);
      for (const auto& machine : story.factory().machines())
        if (machine->state() == MachineState::kDown) ++down[machine->name()];
    }
    return down;
  };
  EXPECT_THAT(seconds_down(239, 1), testing::IsEmpty());
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const auto down = seconds_down(240, seed);
    EXPECT_EQ(down.size(), 4u);
    for (const auto& [name, seconds] : down) EXPECT_GE(seconds, 29) << name << ", seed " << seed;
  }
}

TEST(Game, AMachineThatWasDownWhileIdleLeavesItsBeltStill) {
  WorldConfig config = GameStory::quiet_game();
  config.down = true;
  GameStory story(config);
  ASSERT_EQ(story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}").code, 0);  // belts have run before
  for (int second = 0; second < 1200; ++second) {
    story.run_for(1);
    for (const auto& machine : story.factory().machines()) {
      if (machine->state() != MachineState::kIdle) continue;
      ASSERT_FALSE(story.world().belt_running(machine->id())) << machine->name();
    }
  }
}

TEST(Game, ABeltThatHasDoneItsWorkStaysStillAfterTheMachineWasDown) {
  GameStory story;
  ASSERT_EQ(story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}").code, 0);
  story.take("C-BS-OUTPUT");
  story.run_for(6);
  Machine& machine = *story.factory().machines().front();
  ASSERT_EQ(machine.name(), "C-BS");
  ASSERT_EQ(machine.state(), MachineState::kIdle);
  machine.add_down({story.world().now(), story.world().now() + from_seconds(1)});
  for (const MachineState state : {MachineState::kDown, MachineState::kIdle}) {
    story.run_for(0.9);
    EXPECT_EQ(machine.state(), state);
    EXPECT_FALSE(story.world().belt_running(machine.id()));
  }
}

TEST(Game, BeforeProductionMachinesTakeNoInstructionsAndAfterItIsOver) {
  WorldConfig config = GameStory::quiet_game();
  config.setup_s = 5;
  config.production_s = 20;
  config.overtime_s = 0;
  GameStory story(config);
  EXPECT_EQ(story.factory().referee().phase(), Phase::kSetup);
  EXPECT_EQ(story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}").code, 209);
  story.run_until(5.1);
  EXPECT_EQ(story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}").code, 0);
  EXPECT_FALSE(story.factory().over());
  story.run_until(25.1);
  EXPECT_EQ(story.factory().referee().phase(), Phase::kPostGame);
  EXPECT_TRUE(story.factory().over());
}

TEST(Game, TheRunMayGoOnAfterTheGame) {
  WorldConfig config = GameStory::quiet_game();
  config.production_s = 20;
  config.overtime_s = 0;
  config.post_game_s = 3;
  GameStory story(config);
  story.run_until(22.9);
  EXPECT_EQ(story.factory().referee().phase(), Phase::kPostGame);
  EXPECT_FALSE(story.factory().over());
  story.run_until(23.1);
  EXPECT_TRUE(story.factory().over());
}

TEST(Game, TheSameSeedAndDeedsGiveTheSameRecords) {
  const auto play = [] {
    GameStory story;
    story.make_product("BASE_RED", "CS1");
    return story.records().text();
  };
  EXPECT_EQ(play(), play());
}

TEST(Topics, PublishTheOrdersOnceTheyAreReleased) {
  GameStory story(game_with_window(60, 100, 30));
  std::size_t orders = 99;
  const bus::MessageType& type = **story.registry().message("rcll_interfaces/msg/OrderInfo");
  ASSERT_TRUE(story.bus().subscribe(story.agent(), "/order_info", type,
                                    [&](const bus::Delivery& d) { orders = d.message->view().size("orders"); }));
  story.run_until(29.9);
  EXPECT_EQ(orders, 0u);
  story.run_until(30.02);
  EXPECT_EQ(orders, 1u) << "at once, not with the next period";
}

TEST(Topics, PublishMachinesOnChange) {
  GameStory story;
  std::string state;
  const bus::MessageType& type = **story.registry().message("rcll_interfaces/msg/MachineInfo");
  ASSERT_TRUE(story.bus().subscribe(story.agent(), "/machine_info", type, [&](const bus::Delivery& d) {
    const bus::MessageView info = d.message->view();
    EXPECT_EQ(info.size("machines"), 14u);
    state = info.nested("machines", 0).text("state");
  }));
  story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
  EXPECT_EQ(state, "READY-AT-OUTPUT");
}

}  // namespace
}  // namespace cxlab::rcll
