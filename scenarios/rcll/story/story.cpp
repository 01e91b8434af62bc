#include "scenarios/rcll/story/story.h"

#include <algorithm>
#include <cctype>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/journal/journal_reader.h"
#include "scenarios/floor/sections.h"
#include "scenarios/rcll/game/floor_plan.h"
#include "scenarios/rcll/rules/layout.h"
#include "scenarios/scenario.h"

namespace cxlab::rcll {

namespace {

/// The parts between blanks.
std::vector<std::string> words_in(std::string_view text) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t begin = text.find_first_not_of(' ', i);
    if (begin == text.npos) break;
    i = std::min(text.find(' ', begin), text.size());
    out.emplace_back(text.substr(begin, i - begin));
  }
  return out;
}

bool is_part_of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; }

/// Whether the text has that word, with nothing of a word before and after it.
bool has_word(std::string_view text, std::string_view word) {
  for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_part_of_word(text[at - 1])) && (end == text.size() || !is_part_of_word(text[end]))) return true;
  }
  return false;
}

std::vector<std::string> parts_of(const Order& order) { return words_in(describe(stack_of(order.product))); }

template <class Named>
auto find_named(Named& list, std::string_view name) -> decltype(list.data()) {
  for (auto& one : list)
    if (one.name == name) return &one;
  return nullptr;
}

/// The game from the run's own file, which stays even if the file that the scenario names is removed.
Expected<Game> recorded_game(const AskedRun& run) {
  WorldConfig config = run.scenario.world.get<WorldConfig>();
  const std::filesystem::path file = run.folder / "game.yaml";
  if (!is_file(file)) return input_error("there is no game.yaml in the folder of the run", run.folder.string());
  config.game = file.string();
  config.layout.clear();
  config.orders.clear();
  return game_of(config, run.scenario.seed);
}

}  // namespace

Interval common(const Interval& a, const Interval& b) { return {std::max(a.from, b.from), std::min(a.to, b.to)}; }

std::vector<Interval> without(const Interval& whole, const std::vector<Interval>& others) {
  std::vector<Interval> out;
  SimTime from = whole.from;
  for (const Interval& other : others) {
    if (const Interval before{from, std::min(other.from, whole.to)}; !before.empty()) out.push_back(before);
    from = std::max(from, other.to);
  }
  if (from < whole.to) out.push_back({from, whole.to});
  return out;
}

const SkillRun* RobotStory::skill_at(SimTime t) const {
  for (const SkillRun& one : skills)
    if (one.when.from <= t && t < one.when.to) return &one;
  return nullptr;
}

const RobotStory::Hold* RobotStory::hold_at(SimTime t) const {
  for (const Hold& one : holds)
    if (one.when.from <= t && t < one.when.to) return &one;
  return nullptr;
}

std::optional<SimTime> MachineStory::first(std::string_view state, const Interval& in) const {
  for (const auto& [t, value] : states)
    if (value == state && t >= in.from && t <= in.to) return t;
  return std::nullopt;
}

const InstructionHeard* MachineStory::instruction_at(SimTime t) const {
  const InstructionHeard* out = nullptr;
  for (const auto& one : instructions)
    if (one.t <= t && one.value.code == 0) out = &one.value;
  return out;
}

std::string Decision::text() const {
  std::string out;
  for (const std::string& slot : slots) out += out.empty() ? '\'' + slot + '\'' : ": " + slot;
  return out;
}

bool Decision::names(std::string_view word) const {
  return std::ranges::any_of(slots, [&](const std::string& slot) { return has_word(slot, word); });
}

/// "order 3", "orders 1 3", or the object "o3" of a plan.
bool Decision::names_order(int id) const {
  const std::string number = std::to_string(id);
  for (const std::string& slot : slots) {
    if (has_word(slot, 'o' + number)) return true;
    bool listed = false;
    for (const std::string& word : words_in(slot)) {
      const bool digits = !word.empty() && std::ranges::all_of(word, [](unsigned char c) { return std::isdigit(c); });
      if (listed && word == number) return true;
      listed = word == "order" || word == "orders" || (listed && digits);
    }
  }
  return false;
}

Expected<GameStory> GameStory::read(const AskedRun& run) {
  auto game = recorded_game(run);
  if (!game) return game.error();
  const WorldConfig& config = run.scenario.world.get<WorldConfig>();
  GameStory story;
  story.game = *std::move(game);
  story.teams = teams_of(config);
  story.plan = floor_plan_of(config, story.game.layout);
  story.clock = RecordedClock(config);
  story.from = run.from;
  story.end = run.to;
  story.run_ended = run.ended;
  story.planned_ = faults_of(run.scenario);
  for (const sim::RobotStart& robot : story.plan.robots)
    story.robots.push_back({.name = robot.name, .team = team_of(robot), .skills = {}, .off_field = {}, .holds = {}});
  for (const sim::Station& station : story.plan.stations)
    if (const Team team = team_of(station); std::ranges::find(story.teams, team) != story.teams.end()) {
      MachineStory& machine = story.machines.emplace_back();
      machine.name = station.name;
      machine.kind = station.kind;
      machine.team = team;
    }
  for (const JournalRecord& record : run.records) story.take(record);
  story.finish();
  return story;
}

void GameStory::take(const JournalRecord& record) {
  if (record.kind == RecordKind::kSkill) take_skill(record);
  if (record.kind == RecordKind::kDecision) take_decision(record);
  if (record.kind == RecordKind::kControl && !record.data.text("fault").empty()) take_fault(record);
  if (record.kind == RecordKind::kReferee)
    if (const auto event = read_event(record.data)) take_event(record.t, *event);
}

void GameStory::take_fault(const JournalRecord& record) {
  const std::string_view robot = record.data.text("robot");
  const auto number = static_cast<std::size_t>(record.data.integer("number"));
  const SimTime lasts = number < planned_.size() ? planned_[number].duration : SimTime{};
  faults.push_back({record.t, std::string(record.data.text("fault")),
                    std::string(robot.empty() ? record.data.text("machine") : robot), record.t + lasts});
  if (record.data.find("piece")) piece_of(static_cast<int>(record.data.integer("piece"))).taken = record.t;
}

void GameStory::take_skill(const JournalRecord& record) {
  RobotStory* robot = find_robot(record.data.text("robot"));
  if (!robot) return;
  const std::string_view event = record.data.text("event");
  if (event == "start") {
    SkillRun& skill = robot->skills.emplace_back();
    skill.skill = record.data.text("skill");
    skill.target = record.data.text("target");
    skill.when = {record.t, kNever};
    for (const std::string& word : words_in(skill.target))
      if (plan.find_spot(word)) skill.spots.push_back(word);
    for (const JournalRecord::Cause& cause : record.causes)
      if (cause.stream.starts_with("env/")) commanders_.try_emplace(cause.stream.substr(4), robot->team);
    return;
  }
  if (robot->skills.empty() || robot->skills.back().ended) return;
  SkillRun& skill = robot->skills.back();
  if (event != "phase" && event != "end") return;
  if (!skill.phases.empty()) skill.phases.back().when.to = record.t;
  if (event == "phase") {
    skill.phases.push_back(
        {{record.t, kNever}, std::string(record.data.text("phase")), std::string(record.data.text("for"))});
    return;
  }
  skill.when.to = record.t;
  skill.ended = true;
  skill.code = static_cast<int>(record.data.integer("code"));
  skill.error = record.data.text("error");
}

void GameStory::take_decision(const JournalRecord& record) {
  if (!record.stream.starts_with("env/")) return;
  decisions.push_back({record.t, record.stream.substr(4), std::nullopt, slot_texts(record.data)});
}

void GameStory::take_event(SimTime t, const Event& event) {
  clock.apply(t, event);
  std::visit(
      Cases{[&](const PieceMoved& e) { move(t, e); }, [&](const WorkDone& e) { note_work(t, e); },
            [&](const MachineChanged& e) {
              if (MachineStory* machine = find_machine(e.machine)) machine->states.push_back({t, e.state});
            },
            [&](const MachineBroke& e) {
              MachineStory* machine = find_machine(e.machine);
              if (!machine) return;
              machine->breaks.push_back({t, e.reason});
              machine->payments.push_back({t, 0});
              machine->cap.push_back({t, false});
            },
            [&](const InstructionHeard& e) {
              if (MachineStory* machine = find_machine(e.machine)) machine->instructions.push_back({t, e});
            },
            [&](const OrderPublished& e) { published.try_emplace(e.id, t); },
            [&](const PointsGiven& e) { points.push_back({t, e}); },
            [&](const PauseChanged& e) {
              if (e.state == GameState::kPaused)
                pauses.push_back({t, kNever});
              else if (!pauses.empty())
                pauses.back().to = t;
            },
            [&](const DutyChanged& e) {
              RobotStory* robot = find_robot(e.robot);
              if (!robot) return;
              auto& away = robot->off_field;
              if ((e.state == "end" || e.state == "disqualified") && !away.empty() && away.back().when.to == kNever)
                away.back().when.to = t;
              if (e.state == "begin" || e.state == "disqualified")
                away.push_back({{t, kNever}, e.cause, e.state == "disqualified"});
            },
            [&](const DeliveryJudged& e) {
              deliveries.push_back({t, e});
              piece_of(e.piece).delivery = {t, e};
              piece_of(e.piece).product = e.product;
            },
            [&](const Discarded& e) { piece_of(e.piece).discarded = t; }, [](const auto&) {}},
      event);
}

void GameStory::move(SimTime t, const PieceMoved& e) {
  PieceStory& piece = piece_of(e.piece);
  if (piece.moves.empty()) piece.origin = e.from_name;
  piece.moves.push_back({t, e});
  if (e.from == "dispenser") {
    const MachineStory* machine = machine_at(e.to_name);
    if (!machine) machine = this->machine(e.to_name);
    if (MachineStory* at = machine ? find_machine(machine->name) : nullptr) {
      at->dispensed.push_back({t, e.piece});
      const InstructionHeard* asked = at->kind == "BS" ? at->instruction_at(t) : nullptr;
      if (asked) piece.product = asked->base_color;
      if (at->kind == "CS")
        piece.product = "BASE_CLEAR " + std::string(to_string(shelf_cap(std::string_view(at->name).substr(2))));
    }
  }
  if (RobotStory* robot = e.from == "gripper" ? find_robot(e.from_name) : nullptr; robot && !robot->holds.empty())
    robot->holds.back().when.to = t;
  if (RobotStory* robot = e.to == "gripper" ? find_robot(e.to_name) : nullptr)
    robot->holds.push_back({{t, kNever}, e.piece});
  if (e.to != "slide") return;
  const MachineStory* station = machine_at(e.to_name);
  if (MachineStory* at = station ? find_machine(station->name) : nullptr; at && at->state_at(t) != "BROKEN")
    at->payments.push_back({t, value_at(at->payments, t, 0) + 1});
}

void GameStory::note_work(SimTime t, const WorkDone& e) {
  PieceStory& piece = piece_of(e.piece);
  piece.works.push_back({t, e});
  piece.product = e.product;
  if (e.kind == WorkDone::Kind::kUnstored && piece.origin.empty()) piece.origin = e.machine;
  MachineStory* machine = find_machine(e.machine);
  if (!machine) return;
  machine->works.push_back({t, e});
  if (machine->kind == "CS") machine->cap.push_back({t, e.kind == WorkDone::Kind::kCapRetrieved});
  const int payments_used = e.payments.value_or(0);
  if (payments_used == 0) return;
  // They were used when the mounting began.
  SimTime began = t;
  for (const auto& [since, state] : machine->states)
    if (state == "PROCESSING" && since <= t) began = since;
  auto& payments = machine->payments;
  const auto at = std::ranges::find_if(payments, [&](const Since<int>& one) { return one.t > began; });
  for (auto later = at; later != payments.end(); ++later) later->value = std::max(0, later->value - payments_used);
  payments.insert(at, {began, std::max(0, value_at(payments, began, 0) - payments_used)});
}

/// Ends what is still going on, and forgets what is not known before the end.
void GameStory::finish() {
  const auto close = [this](Interval& interval) { interval.to = std::min(interval.to, end); };
  for (RobotStory& robot : robots) {
    for (SkillRun& skill : robot.skills) {
      close(skill.when);
      for (SkillRun::PhaseOf& phase : skill.phases) close(phase.when);
    }
    for (RobotStory::Away& away : robot.off_field) close(away.when);
    for (RobotStory::Hold& hold : robot.holds) close(hold.when);
  }
  for (Interval& pause : pauses) close(pause);
  for (Decision& decision : decisions)
    if (const auto team = commanders_.find(decision.by); team != commanders_.end()) decision.team = team->second;
  std::ranges::sort(pieces, {}, &PieceStory::number);
}

std::vector<Order> GameStory::orders() const {
  std::vector<Order> out = game.schedule.orders;
  if (game.overtime && published.contains(game.overtime->id)) out.push_back(*game.overtime);
  return out;
}

RobotStory* GameStory::find_robot(std::string_view name) { return find_named(robots, name); }
MachineStory* GameStory::find_machine(std::string_view name) { return find_named(machines, name); }
const RobotStory* GameStory::robot(std::string_view name) const { return find_named(robots, name); }
const MachineStory* GameStory::machine(std::string_view name) const { return find_named(machines, name); }

const PieceStory* GameStory::piece(int number) const {
  const auto found = std::ranges::find(pieces, number, &PieceStory::number);
  return found == pieces.end() ? nullptr : &*found;
}

PieceStory& GameStory::piece_of(int number) {
  const auto found = std::ranges::find(pieces, number, &PieceStory::number);
  if (found != pieces.end()) return *found;
  PieceStory& piece = pieces.emplace_back();
  piece.number = number;
  return piece;
}

const MachineStory* GameStory::machine_at(std::string_view spot) const {
  const auto id = plan.find_spot(spot);
  return id ? machine(plan.station(plan.spot(*id).station).name) : nullptr;
}

const Decision* GameStory::last_decision_about(std::string_view robot, SimTime t) const {
  const Decision* last = nullptr;
  for (const Decision& decision : decisions)
    if (decision.t <= t && decision.names(robot)) last = &decision;
  return last;
}

std::vector<const RobotStory*> GameStory::robots_at(const MachineStory& machine, SimTime t,
                                                    std::string_view but) const {
  std::vector<const RobotStory*> out;
  for (const RobotStory& robot : robots) {
    if (robot.name == but) continue;
    const SkillRun* skill = robot.skill_at(t);
    if (!skill || skill->spots.empty()) continue;
    // A transport is at its first spot until it holds the piece.
    const std::string& spot = robot.hold_at(t) ? skill->spots.back() : skill->spots.front();
    if (machine_at(spot) == &machine) out.push_back(&robot);
  }
  return out;
}

std::string GameStory::about_times() const {
  if (clock.game.production_begin == SimTime{} && pauses.empty()) return {};
  return "windows are times of production, which began at " + time_text(clock.when(0)) +
         (pauses.empty() ? std::string() : " and stood in " + std::to_string(pauses.size()) + " pauses") +
         "; all other times are those of the run";
}

std::string product_text(std::string_view product) {
  std::string out, kind;
  for (const std::string& word : words_in(product)) {
    const std::size_t line = word.find('_');
    const std::string of = line == word.npos ? word : word.substr(0, line);
    std::string colour = line == word.npos ? std::string() : word.substr(line + 1);
    for (char& c : colour) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (!out.empty()) out += of == kind ? " " : ", ";
    out += colour;
    kind = of;
  }
  return out;
}

std::string next_part(std::string_view product, const Order& order) {
  const std::vector<std::string> whole = parts_of(order), there = words_in(product);
  return there.size() < whole.size() ? whole[there.size()] : "delivery";
}

bool could_become(std::string_view product, const Order& order) {
  const std::vector<std::string> whole = parts_of(order), there = words_in(product);
  return !there.empty() && there.size() <= whole.size() && std::equal(there.begin(), there.end(), whole.begin());
}

}  // namespace cxlab::rcll
