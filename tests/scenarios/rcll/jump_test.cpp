#include <gmock/gmock.h>

#include "tests/support/game_story.h"

namespace cxlab::rcll::jump_test {
namespace {

using Deeds = void (*)(GameStory&);
struct Game {
  const char* what;
  Deeds deeds;
  double until;
  void (*change)(WorldConfig&) = [](WorldConfig&) {};
  std::vector<sim::Fault> faults = {};
};

sim::Fault fault_at(double at_s, sim::FaultKind kind, const char* whose, double duration_s) {
  sim::Fault fault;
  fault.kind = kind;
  fault.at = from_seconds(at_s);
  (kind == sim::FaultKind::kRobotMaintenance ? fault.robot : fault.machine) = whose;
  fault.duration = from_seconds(duration_s);
  return fault;
}

const Game kGames[]{
    {"a base, a carrier, and a station that nothing comes to",
     [](GameStory& story) {
       story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
       story.move("C-CS1-SHELF-LEFT", "C-CS1-INPUT");
       story.instruct("{machine: C-CS1, operation: RETRIEVE_CAP}");
       story.instruct("{machine: C-CS2, operation: RETRIEVE_CAP}");
     },
     70},
    {"a reset, and a base that is taken",
     [](GameStory& story) {
       story.instruct("{machine: C-DS, operation: RESET}");
       story.carry_out("{machine: C-BS, side: INPUT, base_color: BASE_RED}");
       story.take("C-BS-INPUT");
     },
     45},
    {"an order with a window, and one that is heard of late",
     [](GameStory& story) {
       story.lay_before_delivery("BASE_RED", CapColor::kGrey);
       story.instruct("{machine: C-DS, order_id: 1}");
     },
     70,
     [](WorldConfig& config) {
       config.orders[0].delivery_begin = 15.53;
       config.orders.push_back(config.orders[0]);
       config.orders[1].activate_at = 33.37;
     }},
    {"an empty shelf",
     [](GameStory& story) {
       for (const char* slot : {"C-CS2-SHELF-LEFT", "C-CS2-SHELF-MIDDLE", "C-CS2-SHELF-RIGHT"}) {
         story.take(slot);
         story.world().drop(sim::RobotId{0});
       }
     },
     40},
    {"a machine that is down twice, once while it works",
     [](GameStory& story) {
       for (const auto& machine : story.factory().machines())
         if (machine->name() == "C-BS") {
           machine->add_down({from_seconds(2.33), from_seconds(5.77)});
           machine->add_down({from_seconds(12.11), from_seconds(14.49)});
         }
       story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
     },
     20},
    {"a ring, and a workpiece that is stored behind another one",
     [](GameStory& story) {
       const auto lay = [&story](const char* machine) {
         EXPECT_TRUE(story.world().dispense(story.machine(machine).id(), sim::kMachine.belt_rest_x, {1, {}, 0}));
       };
       lay("C-RS1");
       story.instruct("{machine: C-RS1, ring_color: RING_ORANGE}");
       lay("C-SS");
       story.carry_out("{machine: C-SS, operation: STORE, shelf: 1, slot: 2}");
       story.run_for(6);
       lay("C-SS");
       story.instruct("{machine: C-SS, operation: STORE, shelf: 1, slot: 3}");
     },
     300},
    {"a down time that hides WAIT-IDLE, and one that hides BROKEN",
     [](GameStory& story) {
       story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
       story.take("C-BS-OUTPUT");
       story.instruct("{machine: C-DS, operation: RESET}");
       for (const auto& machine : story.factory().machines())
         if (machine->name() == "C-BS" || machine->name() == "C-DS")
           machine->add_down({from_seconds(5.33), from_seconds(45.77)});
     },
     60},
    {"overtime", [](GameStory&) {}, 60,
     [](WorldConfig& config) {
       config.production_s = 20.03;
       config.overtime_s = 30.11;
     }},
    {"set-up, a short production, and the end", [](GameStory&) {}, 30,
     [](WorldConfig& config) {
       config.setup_s = 7.31;
       config.production_s = 11.17;
     }},
    {"an instruction that comes late, and one that is lost",
     [](GameStory& story) {
       story.instruct("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}");
       story.instruct("{machine: C-DS, operation: RESET}");
     },
     40,
     [](WorldConfig&) {},
     {fault_at(0, sim::FaultKind::kInstructionLate, "C-BS", 6.47),
      fault_at(0, sim::FaultKind::kInstructionLost, "C-DS", 3.53)}},
    {"a machine that breaks, one that is down, a piece that is taken, and a robot in maintenance",
     [](GameStory& story) { story.carry_out("{machine: C-BS, side: OUTPUT, base_color: BASE_RED}"); },
     60,
     [](WorldConfig&) {},
     {fault_at(7.33, sim::FaultKind::kMachineBreaks, "C-DS", 0),
      fault_at(8.57, sim::FaultKind::kMachineDown, "C-CS1", 4.29),
      fault_at(9.71, sim::FaultKind::kPieceTaken, "C-BS", 0),
      fault_at(10.13, sim::FaultKind::kRobotMaintenance, "robot2", 11.83)}},
};

class JumpingTime : public testing::TestWithParam<Game> {};

struct Played {
  std::vector<std::string> events;  ///< with their times by the floor's clock
  std::vector<SimTime> states;      ///< when the game was paused and went on, in simulated time
  std::vector<std::string> said;    ///< what the factory put on the bus, with the times; without the messages
  std::int64_t ticks = 0;
};

Played play(const Game& game, bool jump, const std::vector<PauseConfig>& pauses = {}) {
  WorldConfig config = GameStory::quiet_game();
  game.change(config);
  config.pauses = pauses;
  GameStory story(config, 1, std::chrono::milliseconds(20), game.faults);
  game.deeds(story);
  story.run_for(0);
  story.set_jumping(jump);
  double until = game.until;
  for (const PauseConfig& pause : pauses) until += pause.seconds;
  story.run_until(until);
  const auto records_of = [&](const char* stream) {
    const auto& names = story.records().names();
    return story.records().of(static_cast<StreamId>(std::ranges::find(names, stream) - names.begin()));
  };
  Played played;  // positions of pieces may differ in their last bit
  for (const KeptRecords::Record& r : records_of("node/factory"))
    played.said.push_back(std::to_string(r.t.count()) + ' ' + r.data.substr(0, r.data.find("msg")));
  for (const KeptRecords::Record& r : records_of("referee"))
    if (r.data.find("PAUSED") != std::string::npos || r.data.find("RUNNING") != std::string::npos)
      played.states.push_back(r.t);
    else
      played.events.push_back(std::to_string(story.world().clock().at(r.t).count()) + ' ' +
                              r.data.substr(0, r.data.find("position")));
  played.ticks = story.ticks();
  return played;
}

/// Time moves by what `next_due` says; the records show when everything happened.
TEST_P(JumpingTime, FindsEverythingThatHappensAtTheTickAtWhichItIsDue) {
  const Played all = play(GetParam(), false), found = play(GetParam(), true);
  EXPECT_THAT(found.events, testing::ElementsAreArray(all.events));
  EXPECT_THAT(found.said, testing::ElementsAreArray(all.said));
  EXPECT_GT(all.events.size(), 3u);
  EXPECT_LT(found.ticks * 5, all.ticks);
}

TEST_P(JumpingTime, IsThatOfTheSameGameWithPauses) {
  const double third = 0.3 * GetParam().until;
  const std::vector<PauseConfig> pauses{{third + 0.13, 7.77}, {third + 1, 21.31}, {third + 1.5, 0.02}};
  const Played plain = play(GetParam(), false), paused = play(GetParam(), false, pauses);
  EXPECT_THAT(paused.events, testing::ElementsAreArray(plain.events));
  EXPECT_EQ(paused.states.size(), 2 * pauses.size());
  const Played jumping = play(GetParam(), true, pauses);
  EXPECT_THAT(jumping.events, testing::ElementsAreArray(plain.events));
  EXPECT_EQ(jumping.states, paused.states);
  EXPECT_LT(jumping.ticks * 5, plain.ticks);
}

INSTANTIATE_TEST_SUITE_P(Games, JumpingTime, testing::ValuesIn(kGames), [](const auto& game) {
  std::string name = game.param.what;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

}  // namespace
}  // namespace cxlab::rcll::jump_test
