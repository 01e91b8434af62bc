#pragma once
// A game written in lines of text: deeds and what must be seen after them. Time is in seconds of simulated time, a
// product is its parts from the base upwards. The first lines may set the game up:
//
//   order C1 BASE_RED RING_BLUE CAP_GREY [window 0 1200] [known 0] [gate 1] [quantity 1] [competitive]
//   setup 5 | production 1200 | overtime 300 | exploration | information league | team CYAN | refill 20 | repair 30
//   pause 10 5                                          the game is paused for 5 s when it has played for 10 s
//   fault 100 1 20                                       at 100 s a fault sends robot 1 to maintenance for 20 s
//
// Deeds:
//   C-BS {side: OUTPUT, base_color: BASE_RED}           instructs and goes on
//   C-BS {side: OUTPUT, ...} -> 0 [after 3.76]          instructs, waits for the end, checks its code and how long it
//   took ends 0 [after 3.76] | before ends 1                 the same for the instruction given last, or the one before
//   it cancel                                              the instruction given last rival M-DS {order_id: 1} an
//   instruction by the other team wait 5 | until 20                                   lets time pass lay PRODUCT at
//   C-DS-INPUT | lay PRODUCT in C-BS     on a belt, as if a robot had put it there; in its middle remove C-CS1 all that
//   lies on that machine's belt hold PRODUCT | take SPOT | put SPOT | drop          by robot R1 down C-CS1 50 out of
//   order for 50 s from now on
//
//   report C-CS1 RIGHT RIGHT | report C-CS1 WRONG - | report C-CS1 C_Z99 - | report - CS C_Z11 | report - CS C-CS2
//                                                       zone and rotation of a machine, or a type in a zone, or there
//                                                       where a machine stands; with `as MAGENTA` behind it in that
//                                                       colour
//   break C-RS1                                         it is BROKEN for a reason of its own
//   maintenance 1 | maintenance 1 ends | maintenance 1 of MAGENTA      the team asks for it, or for its end
//   robot 1 to 4.5 8.3                                   it stands there
//   state PAUSED | state RUNNING                        somebody asks for it on /set_game_state
//
// What must be seen:
//   C-BS is READY-AT-OUTPUT | lights C-BS RED YELLOW GREEN (each OFF, ON or BLINK) | loaded C-RS1 2
//   at SPOT PRODUCT | at SPOT nothing | belt C-CS1 nothing
//   feedback PREPARED PROCESSING ...                    of the instruction given last
//   points delivery 20 cap 10 | rival points ...        all that are not named are 0
//   given payment 2 payment -6                          scores of the team, one by one, since the last such line
//   verdict correct | verdict early | verdict none      of the last delivery
//   late 53.7                                           s, of the last delivery
//   phase PRODUCTION
//   message /order_info /orders/0/id 1                  in the last message: a JSON pointer and a JSON value
//   published /order_info 2                             how often since the last such line
//   robot 1 at 4.5 0.5 | robot 1 holds nothing
//   answer done | answer the game is over               to the last request for a state
//   told {"event": "maintenance", "state": "end"}        the referee's last record of that event has these values

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "scenarios/rcll/rules/layout.h"
#include "tests/support/game_story.h"

namespace cxlab::rcll {

class GameScript {
 public:
  /// Plays the lines; what is not as it must be is a failure of the test with the line.
  void play(const std::string& script, WorldConfig config) {
    std::vector<std::string> lines;
    std::istringstream in(script);
    for (std::string line; std::getline(in, line);) {
      line.erase(0, line.find_first_not_of(' '));
      if (!line.empty()) lines.push_back(line);
    }
    config.down = false;
    config.orders.clear();
    std::size_t next = 0;
    while (next < lines.size() && sets_up(lines[next], config)) ++next;
    if (config.orders.empty()) config.orders = GameStory::quiet_game().orders;
    team_ = *named<Team>(config.team);
    story_ = std::make_unique<GameStory>(config, 1, std::chrono::milliseconds(20), faults_);
    listen();
    for (; next < lines.size(); ++next) {
      SCOPED_TRACE(lines[next] + "   (" + std::to_string(story_->now()) + " s)");
      words_ = split(lines[next]);
      line_ = lines[next];
      act();
    }
  }

 private:
  static std::vector<std::string> split(const std::string& line) {
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    return words;
  }
  static double number(const std::string& word) { return std::stod(word); }
  const std::string& word(std::size_t i) const { return words_.at(i); }
  /// The words from `i` on, with a blank between them.
  std::string rest(std::size_t i) const {
    std::string text;
    for (; i < words_.size(); ++i) text += (text.empty() ? "" : " ") + words_[i];
    return text;
  }

  bool sets_up(const std::string& line, WorldConfig& config) {
    const std::vector<std::string> words = split(line);
    const auto after = [&](const std::string& key) -> const std::string* {
      const auto at = std::ranges::find(words, key);
      return at == words.end() ? nullptr : &at[1];
    };
    if (words[0] == "order") {
      OrderConfig order;
      order.complexity = words[1];
      for (const std::string& part : words) {
        if (part.starts_with("BASE_")) order.base_color = part;
        if (part.starts_with("RING_")) order.ring_colors.push_back(part);
        if (part.starts_with("CAP_")) order.cap_color = part;
      }
      if (const auto at = after("window")) order.delivery_begin = number(at[0]), order.delivery_end = number(at[1]);
      if (const auto at = after("known")) order.activate_at = number(*at);
      if (const auto at = after("gate")) order.delivery_gate = std::stoi(*at);
      if (const auto at = after("quantity")) order.quantity = std::stoi(*at);
      order.competitive = std::ranges::find(words, "competitive") != words.end();
      config.orders.push_back(order);
    } else if (words[0] == "setup") {
      config.setup_s = number(words[1]);
    } else if (words[0] == "production") {
      config.production_s = number(words[1]);
    } else if (words[0] == "exploration") {
      config.exploration = true;
    } else if (words[0] == "information") {
      config.information = words[1];
    } else if (words[0] == "overtime") {
      config.overtime_s = number(words[1]);
    } else if (words[0] == "team") {
      config.team = words[1];
    } else if (words[0] == "fault") {
      sim::Fault& fault = faults_.emplace_back();
      fault.kind = sim::FaultKind::kRobotMaintenance;
      fault.at = from_seconds(number(words[1]));
      fault.robot = "robot" + words[2];
      fault.duration = from_seconds(number(words[3]));
      fault.number = faults_.size() - 1;
    } else if (words[0] == "repair") {
      config.repair_s = number(words[1]);
    } else if (words[0] == "pause") {
      config.pauses.push_back({number(words[1]), number(words[2])});
    } else if (words[0] == "refill") {
      config.shelf_refill_s = number(words[1]);
    } else {
      return false;
    }
    return true;
  }

  void listen() {
    const std::pair<const char*, const char*> topics[] = {
        {"/game_state", "GameState"}, {"/order_info", "OrderInfo"}, {"/machine_info", "MachineInfo"},
        {"/ring_info", "RingInfo"},   {"/robot_info", "RobotInfo"}, {"/machine_report_info", "MachineReportInfo"}};
    for (const auto& [topic, type] : topics) {
      const bus::MessageType& known = **story_->registry().message("rcll_interfaces/msg/" + std::string(type));
      EXPECT_TRUE(story_->bus().subscribe(story_->agent(), topic, known,
                                          [this, name = std::string(topic)](const bus::Delivery& d) {
                                            messages_[name] = d.message;
                                            ++published_[name];
                                          }));
    }
  }

  void report() {
    const bus::MessageType& type = **story_->registry().message("rcll_interfaces/msg/MachineReport");
    const bus::EndpointId reports = *story_->bus().advertise(story_->agent(), "/machine_report", type);
    bus::Message message(type);
    const bus::MessageView entry = message->append("machines");
    if (words_.size() > 5 && word(4) == "as") message->set("team_color", word(5));
    if (word(1) == "-") {
      const auto there = story_->world().plan().find_station(word(3));
      entry.set("type", word(2))
          .set("zone", there                ? to_string(zone_of(story_->world().plan().station(*there)))
                       : word(3) == "RIGHT" ? zone_of_first(word(2))
                                            : word(3));
    } else {
      entry.set("name", word(1));
      const auto id = story_->world().plan().find_station(word(1));
      const sim::Station& station = story_->world().plan().station(id.value_or(sim::StationId{0}));
      if (word(2) != "-")
        entry.set("zone", word(2) == "RIGHT" ? to_string(zone_of(station)) : word(2) == "WRONG" ? "C_Z11" : word(2));
      if (word(3) != "-") entry.set("rotation", (rotation_of(station) + (word(3) == "RIGHT" ? 0 : 45)) % 360);
    }
    story_->bus().publish(reports, std::make_shared<bus::Message>(std::move(message)));
    story_->run_for(0);
    story_->run_for(0);
  }
  /// The zone of the team's first machine of that type.
  std::string zone_of_first(const std::string& type) const {
    for (const sim::Station& station : story_->world().plan().stations)
      if (station.kind == type && team_of(station) == team_) return to_string(zone_of(station));
    return "";
  }

  static sim::Stack product(const std::vector<std::string>& words, std::size_t from) {
    sim::Stack stack;
    std::size_t rings = 0;
    for (std::size_t i = from; i < words.size() && words[i] != "at" && words[i] != "in"; ++i) {
      if (const auto base = named<BaseColor>(words[i])) stack.base = static_cast<std::uint8_t>(*base);
      if (const auto ring = named<RingColor>(words[i])) stack.rings.at(rings++) = static_cast<std::uint8_t>(*ring);
      if (const auto cap = named<CapColor>(words[i])) stack.cap = static_cast<std::uint8_t>(*cap);
    }
    return stack;
  }
  Machine& machine(const std::string& name) const {
    for (const auto& m : story_->factory().machines())
      if (m->name() == name) return *m;
    ADD_FAILURE() << "no machine " << name;
    std::abort();
  }
  static std::string text_of(const sim::Piece* piece) { return piece ? describe(piece->stack) : "nothing"; }

  // --- Lines

  void act() {
    if (word(0).size() >= 4 && word(0)[1] == '-' && words_.size() > 1)
      return words_[1] == "is" ? check_state() : instruct();
    const std::string& verb = word(0);
    if (verb == "ends") return check_end(1);
    if (verb == "before") return expect_same(std::to_string(story_->outcome(goal_ - 1).code), word(2));
    if (verb == "cancel") return story_->cancel(goal_);
    if (verb == "rival") return word(1) == "points" ? check_points(other(team_), 2) : instruct_rival();
    if (verb == "wait") return story_->run_for(number(word(1)));
    if (verb == "until") return story_->run_until(number(word(1)));
    if (verb == "lay") return lay();
    if (verb == "remove") return remove();
    if (verb == "hold") return hold();
    if (verb == "take") return story_->take(word(1));
    if (verb == "put") return story_->put(word(1));
    if (verb == "drop") return story_->world().drop(sim::RobotId{0});
    if (verb == "down") {
      const SimTime now = story_->world().floor_time();
      return machine(word(1)).add_down({now, now + from_seconds(number(word(2)))});
    }
    if (verb == "break")
      return expect_same(
          machine(word(1)).fail(story_->world().floor_time(), story_->world(), "a fault") ? "" : "BROKEN", "");
    if (verb == "report") return report();
    if (verb == "maintenance") return ask_for_maintenance();
    if (verb == "robot") return use_robot();
    if (verb == "state") return ask_for_state();
    if (verb == "answer") return expect_same(answer_, rest(1));
    if (verb == "told") return check_told();
    if (verb == "lights") return check_lights();
    if (verb == "loaded") return expect_same(std::to_string(machine(word(1)).loaded_with()), word(2));
    if (verb == "at") return expect_same(text_of(story_->world().at(story_->spot(word(1)))), rest(2));
    if (verb == "belt") return expect_same(on_belt(word(1)), rest(2));
    if (verb == "feedback") return check_feedback();
    if (verb == "points") return check_points(team_, 1);
    if (verb == "given") return expect_same(scores(), rest(1));
    if (verb == "verdict") return check_verdict();
    if (verb == "late") return check_late();
    if (verb == "phase") return expect_same(to_string(story_->factory().referee().phase()), word(1));
    if (verb == "message") return check_message();
    if (verb == "published") return expect_same(std::to_string(std::exchange(published_[word(1)], 0)), word(2));
    ADD_FAILURE() << "not a line of a game";
  }
  static void expect_same(std::string_view found, std::string_view wanted) { EXPECT_EQ(found, wanted); }

  void instruct() {
    const std::size_t open = line_.find('{'), close = line_.find('}');
    ASSERT_NE(close, std::string::npos) << "an instruction in {}";
    heard_ = story_->feedback().size();
    given_at_ = story_->now();
    goal_ = story_->instruct("{machine: " + word(0) + ", " + line_.substr(open + 1, close - open));
    const auto arrow = std::ranges::find(words_, "->");
    if (arrow == words_.end())
      story_->run_for(0);
    else
      check_end(static_cast<std::size_t>(arrow - words_.begin()) + 1);
  }
  void check_end(std::size_t code_at) {
    for (int i = 0; i < 6000 && !story_->outcome(goal_).ended; ++i) story_->run_for(0);
    const Outcome& outcome = story_->outcome(goal_);
    ASSERT_TRUE(outcome.ended) << "still open after two minutes";
    if (word(code_at) == "cancelled") {
      EXPECT_EQ(outcome.status, bus::GoalStatus::kCanceled);
      EXPECT_EQ(outcome.error, "canceled");
    } else {
      EXPECT_EQ(std::to_string(outcome.code), word(code_at)) << outcome.error;
      EXPECT_EQ(outcome.status, outcome.code == 0 ? bus::GoalStatus::kSucceeded : bus::GoalStatus::kAborted);
    }
    // The instruction arrives with the end of the tick, its result one tick after the machine has done its work.
    if (words_.size() > code_at + 1) {
      EXPECT_NEAR(outcome.at - given_at_, number(word(code_at + 2)), 0.1);
    }
  }
  void instruct_rival() {
    Instruction instruction;
    instruction.order_id = std::stoi(line_.substr(line_.find("order_id: ") + 10));
    const auto answer = machine(word(1)).instruct(instruction, story_->world().floor_time(), story_->world());
    EXPECT_EQ(answer.error, InstructError::kNone) << answer.text;
  }
  void lay() {
    const std::string& where = words_.back();
    const bool at_a_spot = words_[words_.size() - 2] == "at";
    const double x = at_a_spot ? story_->world().plan().spot(story_->spot(where)).rest_in_station.x() : 0;
    const auto station = *story_->world().plan().find_station(where.substr(0, where.find('-', 2)));
    EXPECT_TRUE(story_->world().dispense(station, x, product(words_, 1)));
  }
  void hold() {
    const sim::SpotId spot = story_->spot(std::string(1, letter(team_)) + "-SS-OUTPUT");
    EXPECT_TRUE(story_->world().dispense(story_->world().plan().spot(spot).station,
                                         story_->world().plan().spot(spot).rest_in_station.x(), product(words_, 1)));
    story_->take(std::string(1, letter(team_)) + "-SS-OUTPUT");
  }
  std::vector<const sim::Piece*> pieces_on(const std::string& name) const {
    std::vector<const sim::Piece*> found;
    for (const sim::Piece& piece : story_->world().pieces())
      if (piece.holder == sim::Holder::kBelt && piece.holder_index == static_cast<int>(machine(name).id()))
        found.push_back(&piece);
    return found;
  }
  std::string on_belt(const std::string& name) const {
    const auto found = pieces_on(name);
    return text_of(found.empty() ? nullptr : found.front());
  }
  void remove() {
    for (const auto found = pieces_on(word(1)); const sim::Piece* piece : found)
      story_->world().retire(piece->id, sim::Holder::kFloor);
  }

  void check_late() { EXPECT_NEAR(story_->deliveries().back().late_s, number(word(1)), 0.05); }
  void check_state() { expect_same(to_string(machine(word(0)).state()), word(2)); }
  void check_lights() {
    const auto name = [](sim::Light light) {
      return light == sim::Light::kOff ? "OFF" : light == sim::Light::kOn ? "ON" : "BLINK";
    };
    const sim::Lights lights = story_->world().lights(machine(word(1)).id());
    expect_same(std::string(name(lights.red)) + ' ' + name(lights.yellow) + ' ' + name(lights.green), rest(2));
  }
  void check_feedback() {
    std::string all;
    for (std::size_t i = heard_; i < story_->feedback().size(); ++i)
      all += (all.empty() ? "" : " ") + story_->feedback()[i];
    expect_same(all, rest(1));
  }
  void check_points(Team team, std::size_t from) {
    std::string found;
    for (std::size_t kind = 0; kind < kPointKinds; ++kind)
      if (const auto points = story_->score(team).by_kind[kind]; points != 0)
        found += (found.empty() ? "" : " ") + std::string(to_string(static_cast<PointKind>(kind))) + ' ' +
                 std::to_string(points);
    expect_same(found, rest(from));
  }
  /// Kind and points of the score records since the last call.
  std::string scores() {
    std::string found;
    const auto records = story_->records().of(RecordKind::kReferee);
    for (; scores_seen_ < records.size(); ++scores_seen_) {
      const auto data = nlohmann::json::from_msgpack(records[scores_seen_].data);
      if (data.at("event") != "score") continue;
      found += (found.empty() ? "" : " ") + data.at("kind").get<std::string>() + ' ' + data.at("points").dump();
    }
    return found;
  }
  void check_verdict() {
    const auto& deliveries = story_->deliveries();
    if (deliveries.empty()) return expect_same("none", rest(1));
    expect_same(deliveries.back().correct ? "correct" : deliveries.back().reason, rest(1));
  }
  void check_message() {
    ASSERT_TRUE(messages_[word(1)]) << "nothing on that topic yet";
    RecordData data;
    data.begin().name("message");
    messages_[word(1)]->view().record(data);
    const auto message = nlohmann::json::from_msgpack(data.bytes());
    const auto found = message.at(nlohmann::json::json_pointer("/message" + word(2)));
    EXPECT_EQ(found, nlohmann::json::parse(rest(3)));
  }

  void ask_for_maintenance() {
    const bus::MessageType& type = **story_->registry().message("rcll_interfaces/msg/SetRobotMaintenance");
    if (!requests_) requests_ = *story_->bus().advertise(story_->agent(), "/set_robot_maintenance", type);
    bus::Message message(type);
    const std::string last = words_.size() > 2 ? word(2) : "";
    message->set("robot_number", std::stoi(word(1))).set("maintenance", last != "ends");
    message->set("team_color", last == "of" ? word(3) : to_string(team_));
    story_->bus().publish(*requests_, std::make_shared<bus::Message>(std::move(message)));
    story_->run_for(0.06);
  }
  void ask_for_state() {
    const bus::ServiceType& type = **story_->registry().service("rcll_interfaces/srv/SetGameState");
    if (!states_)
      states_ = *story_->bus().create_client(story_->agent(), "/set_game_state", type, [this](const bus::Delivery& d) {
        const bus::MessageView response = d.message->view();
        answer_ = response.integer("success") ? "done" : response.text("error");
      });
    bus::Message request(*type.request);
    request->set("state", word(1));
    answer_.clear();
    story_->bus().call(*states_, std::make_shared<const bus::Message>(std::move(request)));
    story_->run_for(0.06);
  }
  void use_robot() {
    const int index = std::stoi(word(1)) - 1;
    const sim::RobotState state = story_->world().robot(static_cast<sim::RobotId>(index));
    if (word(2) == "to") {
      story_->set_robot(index, {number(word(3)), number(word(4)), 0});
      return story_->run_for(0);
    }
    if (word(2) == "holds")
      return expect_same(text_of(state.held ? story_->world().find(*state.held) : nullptr), rest(3));
    EXPECT_NEAR(state.pose_in_world.x, number(word(3)), 1e-6);
    EXPECT_NEAR(state.pose_in_world.y, number(word(4)), 1e-6);
  }
  void check_told() {
    const auto wanted = nlohmann::json::parse(rest(1));
    nlohmann::json last;
    for (const auto& record : story_->records().of(RecordKind::kReferee))
      if (auto data = nlohmann::json::from_msgpack(record.data); data.at("event") == wanted.at("event"))
        last = std::move(data);
    for (const auto& [key, value] : wanted.items()) EXPECT_EQ(last.value(key, nlohmann::json()), value) << last.dump();
  }

  Team team_ = Team::kCyan;
  std::vector<sim::Fault> faults_;
  std::optional<bus::EndpointId> requests_, states_;
  std::string answer_;
  std::unique_ptr<GameStory> story_;
  std::map<std::string, bus::SharedMessage> messages_;
  std::map<std::string, int> published_;
  std::vector<std::string> words_;
  std::string line_;
  std::size_t goal_ = 0, heard_ = 0, scores_seen_ = 0;
  double given_at_ = 0;
};

}  // namespace cxlab::rcll
