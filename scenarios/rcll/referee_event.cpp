#include "scenarios/rcll/referee_event.h"

#include <algorithm>

namespace cxlab::rcll {

namespace {

std::string text_of_event(const RecordValue& data, std::string_view key) { return std::string(data.text(key)); }

int whole(const RecordValue& data, std::string_view key) { return static_cast<int>(data.integer(key)); }

double number(const RecordValue& data, std::string_view key) {
  const RecordValue* found = data.find(key);
  if (!found) return 0;
  if (const auto* value = std::get_if<double>(&found->value)) return *value;
  return static_cast<double>(data.integer(key));
}

bool holds(const RecordValue& data, std::string_view key) {
  const RecordValue* found = data.find(key);
  return found && found->value == decltype(found->value)(true);
}

std::optional<WorkDone::Kind> kind_of_work(std::string_view event) {
  if (event == "cap_retrieved") return WorkDone::Kind::kCapRetrieved;
  if (event == "mounted") return WorkDone::Kind::kMounted;
  if (event == "stored") return WorkDone::Kind::kStored;
  if (event == "unstored") return WorkDone::Kind::kUnstored;
  return std::nullopt;
}

OrderPublished read_published(const RecordValue& data) {
  return {whole(data, "order"),
          text_of_event(data, "complexity"),
          text_of_event(data, "product"),
          number(data, "begin"),
          number(data, "end"),
          whole(data, "gate"),
          whole(data, "quantity"),
          holds(data, "competitive")};
}

DeliveryJudged read_judged(const RecordValue& data) {
  return {whole(data, "order"),           whole(data, "piece"),          named<Team>(data.text("team")),
          text_of_event(data, "product"), text_of_event(data, "reason"), holds(data, "correct"),
          number(data, "late_s"),         data.integer("points")};
}

}  // namespace

std::optional<RefereeEvent> read_referee_event(const RecordValue& data) {
  const std::string_view event = data.text("event");
  const auto text = [&data](std::string_view key) { return text_of_event(data, key); };
  if (event == "piece")
    return PieceMoved{whole(data, "piece"), text("from"), text("from_name"), text("to"), text("to_name")};
  if (event == "machine") return MachineChanged{text("machine"), text("state")};
  if (event == "score")
    return PointsGiven{named<Team>(data.text("team")), text("kind"), data.integer("points"), data.integer("total"),
                       whole(data, "order")};
  if (event == "instruction")
    return InstructionHeard{text("machine"),    text("operation"),    text("base_color"),
                            text("ring_color"), whole(data, "order"), whole(data, "code")};
  if (const auto kind = kind_of_work(event))
    return WorkDone{*kind, text("machine"), whole(data, "piece"), text("product"), whole(data, "payments")};
  if (event == "broken") return MachineBroke{text("machine"), text("reason")};
  if (event == "order") return read_published(data);
  if (event == "delivery") return read_judged(data);
  if (event == "discard") return Discarded{whole(data, "piece")};
  if (event == "maintenance") return DutyChanged{text("robot"), text("state"), text("cause")};
  if (event == "state") return PauseChanged{data.text("state") == "PAUSED"};
  if (event == "phase") return PhaseBegan{text("phase")};
  if (event == "set_phase") return PhaseWasSet{text("phase")};
  if (event == "overtime" || event == "sudden death") return Prolonged{number(data, "until")};
  return std::nullopt;
}

void RecordedClock::apply(SimTime t, const RefereeEvent& event) {
  std::visit(Cases{[&](const Prolonged& e) { game.production_end = game.at(e.until); },
                   [&](const PhaseBegan& e) {
                     if (e.phase == to_string(Phase::kPostGame)) game.production_end = floor.at(t);
                   },
                   [&](const PhaseWasSet&) {
                     if (phase(t) == Phase::kSetup) game.begin_production(floor.at(t));
                   },
                   [&](const PauseChanged& e) {
                     if (e.paused)
                       floor.halt(t);
                     else
                       floor.go_on(t);
                   },
                   [](const auto&) {}},
             event);
}

SimTime RecordedClock::when(double production_s) const {
  const SimTime at = floor.when(game.at(production_s));
  return at == kNever ? game.at(production_s) : at;
}

}  // namespace cxlab::rcll
