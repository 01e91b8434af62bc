// What the topics of the factory say, field by field, and the frames of the field.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "cx/bus/transforms.h"
#include "tests/support/game_story.h"

namespace cxlab::rcll {
namespace {

using Json = nlohmann::json;

struct Place {
  const char* machine;
  const char* zone;
  int rotation;
};
// All eight angles, on both halves.
constexpr Place kPlaces[]{{"C-BS", "C_Z13", 0},    {"C-CS1", "M_Z24", 45},  {"C-CS2", "C_Z35", 90},
                          {"C-RS1", "C_Z72", 135}, {"C-RS2", "M_Z63", 180}, {"C-SS", "C_Z77", 225},
                          {"C-DS", "C_Z48", 270},  {"M-BS", "M_Z13", 315},  {"M-CS1", "C_Z24", 0},
                          {"M-CS2", "M_Z35", 180}, {"M-RS1", "M_Z72", 45},  {"M-RS2", "C_Z63", 315},
                          {"M-SS", "M_Z77", 225},  {"M-DS", "M_Z48", 135}};

WorldConfig placed_game() {
  WorldConfig config = GameStory::quiet_game();
  for (const Place& place : kPlaces) config.layout.push_back({place.machine, place.zone, place.rotation});
  return config;
}

/// The last message of the topic, after a tick more than `seconds`.
Json last_message(GameStory& story, const std::string& topic, const std::string& type, double seconds = 3) {
  const auto kept = std::make_shared<bus::SharedMessage>();
  EXPECT_TRUE(story.bus().subscribe(story.agent(), topic, **story.registry().message("rcll_interfaces/msg/" + type),
                                    [kept](const bus::Delivery& d) { *kept = d.message; }));
  story.run_for(seconds);
  const bus::SharedMessage last = std::exchange(*kept, nullptr);
  if (!last) return {};
  RecordData data;
  data.begin().name("message");
  last->view().record(data);
  return Json::from_msgpack(data.bytes()).at("message");
}

TEST(Topics, PublishWhereEachMachineStands) {
  GameStory story(placed_game());
  const Json info = last_message(story, "/machine_info", "MachineInfo");
  EXPECT_EQ(info.at("team_color"), "CYAN");
  ASSERT_EQ(info.at("machines").size(), 14u);
  for (const Json& machine : info.at("machines")) {
    const std::string name = machine.at("name");
    const auto place = std::ranges::find(kPlaces, name, &Place::machine);
    ASSERT_NE(place, std::end(kPlaces)) << name;
    EXPECT_EQ(machine.at("zone"), place->zone) << name;
    EXPECT_EQ(machine.at("rotation"), place->rotation) << name;
    EXPECT_EQ(machine.at("type"), name.substr(2, 2));
    EXPECT_EQ(machine.at("team_color"), name[0] == 'C' ? "CYAN" : "MAGENTA");
    EXPECT_EQ(machine.at("state"), "IDLE");
    EXPECT_EQ(machine.at("correctly_reported"), true) << "there is no exploration";
    EXPECT_EQ(machine.at("loaded_with"), 0);
    EXPECT_EQ(machine.at("lights"),
              Json::parse(R"([{"color": "RED", "state": "OFF"}, {"color": "YELLOW", "state": "OFF"},
                                                    {"color": "GREEN", "state": "ON"}])"));
    const double side = place->zone[0] == 'C' ? 1 : -1;
    EXPECT_EQ(machine.at("pose").at("x"), side * (place->zone[3] - '0' - 0.5)) << name;
    EXPECT_EQ(machine.at("pose").at("y"), place->zone[4] - '0' - 0.5) << name;
    EXPECT_NEAR(machine.at("pose").at("theta"), sim::wrap_angle(place->rotation * std::numbers::pi / 180), 1e-12);
    EXPECT_EQ(machine.at("cap_color"), name.ends_with("CS1") ? "CAP_GREY" : name.ends_with("CS2") ? "CAP_BLACK" : "");
    EXPECT_EQ(machine.at("ring_colors"), name.ends_with("RS1")   ? Json({"RING_ORANGE", "RING_GREEN"})
                                         : name.ends_with("RS2") ? Json({"RING_BLUE", "RING_YELLOW"})
                                                                 : Json::array());
  }
}

TEST(Topics, PublishTheRobotsOfTheTeam) {
  for (const std::string team : {"CYAN", "MAGENTA"}) {
    WorldConfig config = placed_game();
    config.team = team;
    GameStory story(config);
    const Json robots = last_message(story, "/robot_info", "RobotInfo").at("robots");
    ASSERT_EQ(robots.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      const Json& robot = robots[static_cast<std::size_t>(i)];
      EXPECT_EQ(robot.at("name"), "robot" + std::to_string(i + 1));
      EXPECT_EQ(robot.at("number"), i + 1);
      EXPECT_EQ(robot.at("team_color"), team);
      EXPECT_EQ(robot.at("state"), "ACTIVE");
      EXPECT_EQ(robot.at("pose").at("x"), (team == "CYAN" ? 1 : -1) * (4.5 + i));
      EXPECT_EQ(robot.at("pose").at("y"), 0.5);
      EXPECT_EQ(robot.at("pose").at("theta"), std::numbers::pi / 2) << "faces the field";
    }
  }
}

TEST(Topics, OfBothTeamsHaveTheirChannels) {
  WorldConfig config = placed_game();
  config.team = "BOTH";
  config.information = "league";
  GameStory story(config);
  for (const std::string team : {"CYAN", "MAGENTA"}) {
    const std::string prefix = team == "CYAN" ? "/cyan" : "/magenta";
    const Json info = last_message(story, prefix + "/machine_info", "MachineInfo");
    EXPECT_EQ(info.at("team_color"), team);
    ASSERT_EQ(info.at("machines").size(), 7u);
    for (const Json& machine : info.at("machines")) EXPECT_EQ(machine.at("team_color"), team);
  }
  EXPECT_TRUE(last_message(story, "/machine_info", "MachineInfo").is_null());
  const Json state = last_message(story, "/game_state", "GameState");
  EXPECT_EQ(state.at("team_cyan"), "CYAN");
  EXPECT_EQ(state.at("team_magenta"), "MAGENTA");
  const Json robots = last_message(story, "/robot_info", "RobotInfo").at("robots");
  ASSERT_EQ(robots.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(robots[i].at("name"), "robot" + std::to_string(i + 1));
    EXPECT_EQ(robots[i].at("number"), static_cast<int>(i % 3) + 1);
    EXPECT_EQ(robots[i].at("team_color"), i < 3 ? "CYAN" : "MAGENTA");
  }
}

TEST(Instructions, OfBothTeamsGoToTheirOwnMachines) {
  WorldConfig config = placed_game();
  config.team = "BOTH";
  GameStory story(config);
  const bus::ActionType& type = **story.registry().action("rcll_interfaces/action/InstructMachine");
  std::vector<std::int64_t> codes;
  const auto instruct = [&](const std::string& prefix, const std::string& machine) {
    const bus::EndpointId client = *story.bus().create_action_client(
        story.agent(), prefix + "/factory/instruct_machine", type,
        {nullptr, nullptr, [&](const bus::Delivery& d) { codes.push_back(d.message->view().integer("error_code")); },
         nullptr});
    story.bus().send_goal(client, std::make_shared<bus::Message>(*bus::Message::from_yaml(
                                      *type.goal, "{machine: " + machine + ", operation: RESET}")));
    story.run_for(0.1);
  };
  for (const std::string prefix : {"/cyan", "/magenta"})
    for (const std::string machine : {"C-BS", "M-BS"}) instruct(prefix, machine);
  EXPECT_EQ(codes, (std::vector<std::int64_t>{0, 101, 101, 0}));
}

TEST(Topics, PublishTheStateOfTheGame) {
  for (const std::string team : {"CYAN", "MAGENTA"}) {
    WorldConfig config = placed_game();
    config.team = team;
    GameStory story(config);
    Json wanted = Json::parse(
        R"({"game_time": 3.0, "state": "RUNNING", "phase": "PRODUCTION", "production_s": 1200.0, "points_cyan": 0,
      "points_magenta": 0, "team_cyan": "", "team_magenta": "", "field_height": 8, "field_width": 7, "field_mirrored": true})");
    wanted[team == "CYAN" ? "team_cyan" : "team_magenta"] = team;
    EXPECT_EQ(last_message(story, "/game_state", "GameState"), wanted);
  }
}

TEST(Topics, TellTheGameToThoseWhoAreToKnowIt) {
  WorldConfig config = placed_game();
  config.orders = {
      {.complexity = "C0", .base_color = "BASE_RED", .ring_colors = {}, .cap_color = "CAP_GREY", .delivery_end = 100},
      {.complexity = "C1",
       .base_color = "BASE_BLACK",
       .ring_colors = {"RING_BLUE"},
       .cap_color = "CAP_BLACK",
       .activate_at = 500,
       .delivery_begin = 600,
       .delivery_end = 700}};
  config.down = true;
  GameStory closed(config);
  EXPECT_TRUE(last_message(closed, "/foresight", "Foresight").is_null());
  config.foresight = true;
  GameStory story(config);
  const Json told = last_message(story, "/foresight", "Foresight");
  const Json released = last_message(story, "/order_info", "OrderInfo").at("orders");
  ASSERT_EQ(told.at("orders").size(), 2u);
  ASSERT_EQ(released.size(), 1u);
  EXPECT_EQ(told.at("orders")[0], released[0]);
  EXPECT_EQ(told.at("orders")[1].at("id"), 2);
  EXPECT_EQ(told.at("orders")[1].at("ring_colors"), Json({"RING_BLUE"}));
  EXPECT_EQ(told.at("orders")[1].at("delivery_period_begin"), 600);
  const Game game = *game_of(config, 1);
  ASSERT_EQ(told.at("down").size(), game.down.size());
  ASSERT_EQ(game.down.size(), 2u);
  for (std::size_t i = 0; i < game.down.size(); ++i)
    EXPECT_EQ(
        told.at("down")[i],
        Json({{"machine", game.down[i].machine}, {"begin_s", game.down[i].begin_s}, {"end_s", game.down[i].end_s}}));
}

TEST(Topics, ComeWithTheirPeriods) {
  const std::tuple<const char*, const char*, int> topics[]{{"/game_state", "GameState", 20},
                                                           {"/order_info", "OrderInfo", 10},
                                                           {"/machine_info", "MachineInfo", 10},
                                                           {"/ring_info", "RingInfo", 10},
                                                           {"/robot_info", "RobotInfo", 8}};
  GameStory story;
  story.run_until(10.01);
  std::map<std::string, int> heard;
  for (const auto& [topic, type, count] : topics)
    ASSERT_TRUE(story.bus().subscribe(story.agent(), topic,
                                      **story.registry().message("rcll_interfaces/msg/" + std::string(type)),
                                      [&heard, name = std::string(topic)](const bus::Delivery&) { ++heard[name]; }));
  story.run_until(30.01);
  for (const auto& [topic, type, count] : topics) EXPECT_EQ(heard[topic], count) << topic;
}

TEST(Transforms, PlaceMachinesAndRobotsInTheMap) {
  WorldConfig config = placed_game();
  config.transforms = true;
  GameStory story(config);
  auto listener =
      bus::TransformListener::create(story.bus(), story.agent(), [](const std::string& why) { FAIL() << why; });
  ASSERT_TRUE(listener);
  story.run_for(1);
  const auto expect_at = [&](const std::string& frame, const sim::Pose2& pose) {
    const auto found = (*listener)->buffer().lookup("map", frame, story.world().now());
    ASSERT_TRUE(found) << frame << ": " << found.error().text();
    EXPECT_NEAR(found->pose.translation.x(), pose.x, 1e-9) << frame;
    EXPECT_NEAR(found->pose.translation.y(), pose.y, 1e-9) << frame;
    EXPECT_NEAR(found->pose.rotation.z(), std::sin(pose.yaw / 2), 1e-9) << frame;
  };
  for (const sim::Station& station : story.world().plan().stations) expect_at(station.name, station.pose_in_world);
  for (int i = 0; i < 3; ++i)
    expect_at("robot" + std::to_string(i + 1), story.world().robot(sim::RobotId{i}).pose_in_world);
  const sim::Pose2 moved{1, 2, 0.5};
  story.world().move_along(sim::RobotId{0}, std::span(&moved, 1), story.world().now(), story.world().now());
  story.run_for(0.1);
  expect_at("robot1", moved);
}

}  // namespace
}  // namespace cxlab::rcll
