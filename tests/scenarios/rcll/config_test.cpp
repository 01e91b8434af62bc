#include "scenarios/rcll/rules/config.h"

#include <gmock/gmock.h>

#include <utility>

#include "scenarios/rcll/rules/layout.h"

namespace cxlab::rcll {
namespace {

using testing::HasSubstr;

TEST(WorldConfig, TheDefaultsAreAGame) { EXPECT_TRUE(validate(WorldConfig{})); }

TEST(WorldConfig, AWrongWordIsAnsweredWithTheNearestOne) {
  WorldConfig config;
  config.team = "CYANE";
  const Status status = validate(config);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, ErrorKind::kInput);
  EXPECT_THAT(status.error().message, HasSubstr("world.team: found 'CYANE'"));
  EXPECT_THAT(status.error().message, HasSubstr("did you mean CYAN?"));
}

TEST(WorldConfig, ValuesOutOfRangeAreNamedWithTheirKey) {
  WorldConfig config;
  config.robots = 4;
  EXPECT_EQ(validate(config).error().message, "world.robots: found 4, expected 0 to 3");
  config = {};
  config.production_s = 0;
  EXPECT_THAT(validate(config).error().message, HasSubstr("world.production_s: found 0"));
  config = {};
  config.team = "BOHT";
  EXPECT_EQ(validate(config).error().message,
            "world.team: found 'BOHT', expected one of CYAN, MAGENTA, BOTH (did you mean BOTH?)");
}

TEST(WorldConfig, PausesAreInTheGameAndOneAfterAnother) {
  const auto error = [](std::vector<PauseConfig> pauses, double overtime_s = 300) {
    WorldConfig config;
    config.overtime_s = overtime_s;
    config.pauses = std::move(pauses);
    const Status status = validate(config);
    return status ? std::string() : status.error().message;
  };
  EXPECT_EQ(error({{330, 60}, {300, 60}, {0, 0.1}, {1499, 1e6}}), "");
  EXPECT_EQ(error({{-1, 10}}), "world.pauses[0].at: found -1, expected s of production, from 0 to before 1500");
  EXPECT_EQ(error({{1499, 10}, {1500, 10}}),
            "world.pauses[1].at: found 1500, expected s of production, from 0 to before 1500");
  EXPECT_THAT(error({{1200, 10}}, 0), HasSubstr("pauses[0].at: found 1200, expected s of production"));
  EXPECT_EQ(error({{10, 0}}), "world.pauses[0].for: found 0, expected s, more than 0 and at most 1000000");
  EXPECT_THAT(error({{10, -5}}), HasSubstr("pauses[0].for: found -5"));
  EXPECT_THAT(error({{10, 1000001}}), HasSubstr("pauses[0].for: found 1000001"));
  EXPECT_EQ(
      error({{300, 60}, {330, 60}, {300, 10}}),
      "world.pauses[2].at: found 300, expected another time than that of pauses[0]: the game's time stands in it");
}

TEST(WorldConfig, EachSettingHasItsLimits) {
  struct Case {
    const char* key;
    void (*change)(WorldConfig&);
  };
  for (const auto& [key, change] : {
           Case{"team", [](WorldConfig& c) { c.team = "GREEN"; }},
           {"rules", [](WorldConfig& c) { c.rules = "none"; }},
           {"robots", [](WorldConfig& c) { c.robots = -1; }},
           {"setup_s", [](WorldConfig& c) { c.setup_s = -1; }},
           {"production_s", [](WorldConfig& c) { c.production_s = 0.5; }},
           {"production_s", [](WorldConfig& c) { c.production_s = 1.1e6; }},
           {"overtime_s", [](WorldConfig& c) { c.overtime_s = -1; }},
           {"overtime_s", [](WorldConfig& c) { c.overtime_s = 1.1e6; }},
           {"post_game_s", [](WorldConfig& c) { c.post_game_s = -1; }},
           {"shelf_refill_s", [](WorldConfig& c) { c.shelf_refill_s = -0.1; }},
           {"repair_s", [](WorldConfig& c) { c.repair_s = -0.1; }},
           {"complexities",
            [](WorldConfig& c) {
              c.orders.clear();
              c.complexities = {"C0", "C4"};
            }},
           {"information", [](WorldConfig& c) { c.information = "some"; }},
           {"orders[0].complexity", [](WorldConfig& c) { c.orders[0].complexity = "C4"; }},
           {"orders[0].base_color", [](WorldConfig& c) { c.orders[0].base_color = "RED"; }},
           {"orders[1].ring_colors", [](WorldConfig& c) { c.orders[1].ring_colors[1] = "GREEN"; }},
           {"orders[1].ring_colors", [](WorldConfig& c) { c.orders[1].ring_colors.pop_back(); }},
           {"orders[1].ring_colors", [](WorldConfig& c) { c.orders[1].ring_colors.push_back("RING_BLUE"); }},
           {"orders[1].quantity", [](WorldConfig& c) { c.orders[1].quantity = 0; }},
           {"orders[1].cap_color", [](WorldConfig& c) { c.orders[1].cap_color = "CAP_RED"; }},
           {"orders[0].activate_at", [](WorldConfig& c) { c.orders[0].activate_at = -1; }},
           {"orders[0].delivery_begin", [](WorldConfig& c) { c.orders[0].delivery_begin = -1; }},
           {"orders[0].delivery_gate", [](WorldConfig& c) { c.orders[0].delivery_gate = 0; }},
           {"orders[0].delivery_gate", [](WorldConfig& c) { c.orders[0].delivery_gate = 4; }},
           {"orders[0].quantity", [](WorldConfig& c) { c.orders[0].quantity = 0; }},
           {"orders[0].delivery_end", [](WorldConfig& c) { c.orders[0].delivery_end = c.orders[0].delivery_begin; }},
           {"orders[0].activate_at", [](WorldConfig& c) { c.orders[0].activate_at = c.orders[0].delivery_end; }},
           {"orders[1].ring_colors", [](WorldConfig& c) { c.orders[1].ring_colors[1] = c.orders[1].ring_colors[0]; }},
           {"orders[1].delivery_begin",
            [](WorldConfig& c) {
              c.orders[1].delivery_begin = 1200;
              c.orders[1].delivery_end = 1300;
            }},
           {"orders[0].activate_at",
            [](WorldConfig& c) {
              c.orders[0].activate_at = 1200;
              c.orders[0].delivery_end = 1300;
            }},
       }) {
    WorldConfig config;
    config.orders.resize(2);
    config.orders[1].complexity = "C2";
    config.orders[1].ring_colors = {"RING_BLUE", "RING_GREEN"};
    ASSERT_TRUE(validate(config));
    change(config);
    const Status status = validate(config);
    ASSERT_FALSE(status) << key;
    EXPECT_THAT(status.error().message, testing::StartsWith("world." + std::string(key) + ": found ")) << key;
  }
}

TEST(WorldConfig, LimitsThemselvesAreAccepted) {
  WorldConfig config;
  config.orders.resize(1);
  OrderConfig& order = config.orders[0];
  for (const bool most : {false, true}) {
    config.robots = most ? 3 : 0;
    config.setup_s = config.post_game_s = config.shelf_refill_s = config.repair_s = most ? 1e6 : 0;
    config.production_s = most ? 1e6 : 1;
    order.activate_at = order.delivery_begin = most ? 1e6 - 1 : 0;
    order.delivery_end = order.delivery_begin + 1;
    order.delivery_gate = most ? 3 : 1;
    order.quantity = most ? 1000 : 1;
    const Status status = validate(config);
    EXPECT_TRUE(status) << status.error().message;
  }
  for (double* value : {&config.setup_s, &config.post_game_s, &config.shelf_refill_s, &config.repair_s,
                        &config.production_s, &order.activate_at, &order.delivery_begin}) {
    const double kept = std::exchange(*value, 1e6 + 1);
    EXPECT_FALSE(validate(config));
    *value = kept;
  }
  order.quantity = 1001;
  EXPECT_FALSE(validate(config));
}

TEST(WorldConfig, OrdersBeginBeforeProductionEndsOrWouldEndInTheLeague) {
  const auto begins_at = [](double begin, double production_s) {
    WorldConfig config;
    config.production_s = production_s;
    OrderConfig& order = config.orders.emplace_back();
    order.delivery_begin = begin;
    order.delivery_end = begin + 100;
    return static_cast<bool>(validate(config));
  };
  EXPECT_TRUE(begins_at(1199, 1200));
  EXPECT_FALSE(begins_at(1200, 1200));
  EXPECT_TRUE(begins_at(1199, 300)) << "a game that is cut short";
  EXPECT_FALSE(begins_at(1200, 300));
  EXPECT_TRUE(begins_at(1500, 2000));
  EXPECT_FALSE(begins_at(2000, 2000));
}

OrderConfig timed(double activate_at, double begin, double end) {
  OrderConfig order;
  order.activate_at = activate_at;
  order.delivery_begin = begin;
  order.delivery_end = end;
  return order;
}

GameFile drawn_file() {
  GameFile file;
  RandomStream random(3, "layout");
  file.layout = listed(draw_layout(random, false));
  file.orders.emplace().resize(2);
  file.down = {{"RS1", 10, 20}, {"CS1", 10, 20}, {"RS1", 20, 30}};
  file.overtime.emplace();
  file.overtime->delivery_begin = 1200;
  file.overtime->delivery_end = 1500;
  return file;
}

std::string error_of(const GameFile& file, const WorldConfig& config = {}) {
  const Status status = validate(file);
  if (!status) return status.error().message;
  const Status times = check_times(file, config);
  return times ? "" : times.error().message;
}

TEST(GameFile, IsAGameThatCanBePlayed) {
  EXPECT_EQ(error_of(drawn_file()), "");
  const auto with = [](auto change) {
    GameFile file = drawn_file();
    change(file);
    return error_of(file);
  };
  EXPECT_EQ(with([](GameFile& f) { f.orders->clear(); }),
            "orders: found an empty list, expected an order at least; without this key they are drawn");
  EXPECT_EQ(with([](GameFile& f) { f.down->push_back({"CS1", 19, 40}); }),
            "down[3].begin_s: found 19, expected a time at which CS1 is not down: down[1] is from 10 to 20");
  EXPECT_THAT(with([](GameFile& f) { f.down->push_back({"RS1", 5, 40}); }), HasSubstr("down[0] is from 10 to 20"));
  EXPECT_THAT(with([](GameFile& f) { f.down->push_back({"RS1", 12, 13}); }), HasSubstr("down[0] is from 10 to 20"));
  EXPECT_EQ(with([](GameFile& f) { f.down->push_back({"CS2", 19, 40}); }), "");
  EXPECT_EQ(with([](GameFile& f) { f.down->push_back({"CS2", 1500, 1540}); }),
            "down[3].begin_s: found 1500, expected a time before the end of the game at 1500");
  EXPECT_EQ(with([](GameFile& f) { (*f.orders)[1] = timed(0, 1200, 1300); }),
            "orders[1].delivery_begin: found 1200, expected a time before the end of the game at 1200");
  EXPECT_EQ(with([](GameFile& f) { (*f.orders)[1] = timed(1200, 0, 1300); }),
            "orders[1].activate_at: found 1200, expected a time before the end of the game at 1200");
  EXPECT_EQ(with([](GameFile& f) { (*f.orders)[0].activate_at = 1200; }),
            "orders[0].activate_at: found 1200, expected a time before delivery_end");
  EXPECT_EQ(with([](GameFile& f) { f.overtime->delivery_begin = 1500, f.overtime->delivery_end = 1501; }),
            "overtime.delivery_begin: found 1500, expected a time before the end of the game at 1500");
  EXPECT_EQ(with([](GameFile& f) {
              OrderConfig& order = f.orders->emplace_back();
              order.complexity = "C2";
              order.ring_colors = {"RING_BLUE", "RING_BLUE"};
            }),
            "orders[2].ring_colors: found RING_BLUE on RING_BLUE, expected another colour than that of the ring below");
}

TEST(GameFile, TimesFollowTheLengthOfTheGame) {
  GameFile file = drawn_file();
  (*file.orders)[0] = timed(0, 1300, 1400);
  file.overtime->delivery_begin = 1700;
  file.overtime->delivery_end = 1800;
  WorldConfig longer;
  longer.production_s = 1500;
  EXPECT_NE(error_of(file), "");
  EXPECT_EQ(error_of(file, longer), "");
  longer.production_s = 300;
  longer.overtime_s = 0;
  EXPECT_EQ(error_of(drawn_file(), longer), "") << "a game of the league that is cut short";
}

TEST(GameFile, HasTwoHalvesThatMirrorEachOther) {
  const auto with = [](auto change) {
    GameFile file = drawn_file();
    change(file);
    return error_of(file);
  };
  const auto find = [](GameFile& file, const char* name) -> PlacedMachine& {
    return *std::ranges::find(*file.layout, name, &PlacedMachine::machine);
  };
  const std::string said = with([&](GameFile& f) { find(f, "M-BS").zone = "M_Z11"; });
  EXPECT_THAT(said, testing::MatchesRegex("layout.7..zone: found M_Z11, expected M_Z.., opposite to C-BS; .*"));
  EXPECT_THAT(with([&](GameFile& f) { find(f, "C-SS").zone = "C_Z11"; }),
              testing::MatchesRegex("layout.[0-9]+..zone: found M_Z.., expected M_Z11, opposite to C-SS; .*"));
  EXPECT_THAT(with([&](GameFile& f) { std::swap(find(f, "C-BS").zone, find(f, "M-BS").zone); }),
              testing::Not(HasSubstr("zone")));
  EXPECT_THAT(with([&](GameFile& f) { find(f, "M-DS").rotation = (find(f, "M-DS").rotation + 45) % 360; }),
              HasSubstr(".rotation: found "));
  EXPECT_EQ(with([&](GameFile& f) {
              f.mirrored = false;
              find(f, "M-DS").rotation = (find(f, "M-DS").rotation + 45) % 360;
              find(f, "M-BS").zone = "M_Z11";
            }),
            "");
  EXPECT_NE(with([&](GameFile& f) {
              f.mirrored = true;
              find(f, "M-BS").zone = "M_Z11";
            }),
            "");
}

TEST(GameFile, TakesEachLayoutThatIsDrawn) {
  for (const bool shelf_faces_wall : {false, true})
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      RandomStream random(seed, "layout");
      GameFile file;
      file.layout = listed(draw_layout(random, shelf_faces_wall));
      EXPECT_EQ(error_of(file), "") << seed;
    }
}

TEST(WorldConfig, AnOrderMustHaveTheRingsOfItsComplexity) {
  WorldConfig config;
  config.orders.push_back({});
  EXPECT_TRUE(validate(config));
  config.orders[0].complexity = "C1";
  EXPECT_EQ(validate(config).error().message, "world.orders[0].ring_colors: found 0 rings, expected 1 for a C1");
  config.orders[0].ring_colors = {"RING_BLEU"};
  EXPECT_THAT(validate(config).error().message, HasSubstr("did you mean RING_BLUE?"));
  config.orders[0].ring_colors = {"RING_BLUE"};
  EXPECT_TRUE(validate(config));
  config.orders[0].base_color = "BASE_CLEAR";
  EXPECT_FALSE(validate(config)) << "clear bases only carry caps";
}

TEST(WorldConfig, ListedOrdersLeaveNothingToDrawComplexitiesFor) {
  WorldConfig config;
  config.orders.push_back({});
  config.complexities = {"C0"};
  EXPECT_THAT(validate(config).error().message, HasSubstr("world.complexities"));
}

}  // namespace
}  // namespace cxlab::rcll
