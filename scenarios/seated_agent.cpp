#include "scenarios/seated_agent.h"

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <variant>

#include "cx/base/byte_codec.h"
#include "cx/bus/names.h"
#include "cx/journal/input_log.h"

namespace cxlab {

namespace {

/// Something that a seat does, as the log has it.
struct SeatAct {
  enum class Verb : std::uint8_t { kRead, kPublish, kCall, kGoal, kCancel, kFail };
  Verb verb{};
  std::string name, type;    ///< of a failure: its text and code
  std::string content;       ///< the message, serialized
  std::uint32_t number = 0;  ///< of a goal that is cancelled; of a failure: its kind
};

/// Where in a tick a seat does it.
enum class SeatTurn : std::uint8_t { kMade, kPerceive, kDecide, kAct, kJoined };

/// What a seat does in one turn.
struct SeatActs {
  SimTime t{};
  SeatTurn turn{};
  std::vector<SeatAct> acts;

  std::string bytes() const {
    std::string bytes;
    ByteWriter out(bytes);
    out.fixed(turn).varint(acts.size());
    for (const SeatAct& act : acts)
      out.fixed(act.verb).text(act.name).text(act.type).text(act.content).varint(act.number);
    return bytes;
  }
  static std::optional<SeatActs> parse(SimTime t, std::string_view bytes) {
    ByteReader in(bytes);
    SeatActs out{t, in.fixed<SeatTurn>(), {}};
    for (std::uint64_t left = in.varint(); left > 0 && in.ok(); --left) {
      SeatAct& act = out.acts.emplace_back();
      act.verb = in.fixed<SeatAct::Verb>();
      act.name = in.text();
      act.type = in.text();
      act.content = in.text();
      act.number = static_cast<std::uint32_t>(in.varint());
      const auto kind = static_cast<ErrorKind>(act.number);
      const bool known = (kind >= ErrorKind::kNo && kind <= ErrorKind::kResource) || kind == ErrorKind::kBug;
      if (act.verb > SeatAct::Verb::kFail || (act.verb == SeatAct::Verb::kFail && !known)) in.refuse();
    }
    if (!in.ok() || in.left() > 0 || out.turn > SeatTurn::kJoined) return {};
    return out;
  }
};

/// The types of a name of the bus.
struct SeatType {
  const bus::MessageType* sent = nullptr;  ///< message, request or goal
  const bus::ServiceType* service = nullptr;
  const bus::ActionType* action = nullptr;
};

Expected<SeatType> type_of(bus::Registry& registry, const std::string& name) {
  if (name.find("/srv/") != name.npos) {
    auto type = registry.service(name);
    return type ? Expected<SeatType>(SeatType{(*type)->request, *type, nullptr}) : type.error();
  }
  if (name.find("/action/") != name.npos) {
    auto type = registry.action(name);
    return type ? Expected<SeatType>(SeatType{(*type)->goal, nullptr, *type}) : type.error();
  }
  auto type = registry.message(name);
  return type ? Expected<SeatType>(SeatType{*type, nullptr, nullptr}) : type.error();
}

class SeatedAgent final : public Agent, private SeatBus {
 public:
  static Expected<std::unique_ptr<Agent>> create(const Seat& seat, bus::Bus& bus, RecordSink& sink, Inputs& inputs) {
    if (Status s = check_name(seat.name, bus); !s) return s.error();
    std::unique_ptr<SeatedAgent> self(new SeatedAgent(seat.name, bus, sink, inputs));
    Expected<std::unique_ptr<Agent>> agent = std::unique_ptr<Agent>();
    if (seat.make) agent = seat.make(*self);
    if (!agent) return self->named(agent.error());
    if (!*agent) return self->named(usage_error(found_expected("no agent", "`make` to give one")));
    self->agent_ = *std::move(agent);
    const Status sent =
        seat.joins_after ? self->send(SeatTurn::kJoined, *seat.joins_after) : self->send(SeatTurn::kMade);
    if (!sent) return sent.error();
    return std::unique_ptr<Agent>(std::move(self));
  }
  ~SeatedAgent() override { bus_.leave(self_); }

  // An error waits for the end of the turn: until then environments and managers do what they do in any tick, so that
  // the run replays up to there.
  Status perceive() override {
    bus_.deliver(self_);
    hear(SeatTurn::kPerceive, agent_->perceive());
    return {};
  }
  Status decide(SimTime now) override {
    if (failed_) return {};
    hear(SeatTurn::kDecide, agent_->decide(now));
    if (failed_ || waiting_.empty()) return {};
    if (Status s = send(SeatTurn::kDecide); !s) failed_ = s.error();
    return {};
  }
  Status act() override {
    if (!failed_) hear(SeatTurn::kAct, agent_->act());
    return failed_ ? Status(*failed_) : Status();
  }
  SimTime next_due() const override { return waiting_.empty() ? agent_->next_due() : bus_.now(); }

 private:
  using Verb = SeatAct::Verb;
  struct Waiting {
    SeatAct act;
    SeatType type = {};
    bus::SharedMessage message = {};
    SeatReader reader = {};
  };
  struct Goal {
    bus::EndpointId client{};
    bus::GoalId id{};
    GoalReaders readers = {};
  };

  SeatedAgent(const std::string& name, bus::Bus& bus, RecordSink& sink, Inputs& inputs)
      : bus_(bus), inputs_(inputs), stream_(std::string(kSeatStream) + name), name_(name) {
    self_ = bus.join(bus::ParticipantKind::kNode, bus::NodeName{name, "/", {}}, sink.open_stream(stream_));
  }
  static Status check_name(const std::string& name, const bus::Bus& bus) {
    const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    const auto fits_later = [&fits](char c) { return fits(c) || (c >= '0' && c <= '9'); };
    if (name.empty() || !fits(name.front()) || !std::ranges::all_of(name, fits_later))
      return usage_error(found_expected("a seat called '" + name + "'", "letters, digits and '_', a letter first"));
    if (bus.find_node('/' + name))
      return usage_error(found_expected("a node /" + name + " already", "another name of the seat"));
    return {};
  }
  Error named(Error error) const {
    const std::string who = "seat " + name_ + ": ";
    if (!error.message.starts_with(who)) error.message.insert(0, who);
    return error;
  }

  // --- SeatBus

  SimTime now() const override { return bus_.now(); }
  Expected<bus::Message> make(const std::string& type) const override {
    auto found = type_of(bus_.registry(), type);
    if (!found) return found.error();
    return bus::Message(*found->sent);
  }
  Status read(const std::string& topic, const std::string& type, SeatReader reader) override {
    return add({{Verb::kRead, topic, type, {}}, {}, {}, std::move(reader)}, {});
  }
  Status publish(const std::string& topic, const std::string& type, const SeatContent& message) override {
    return add({{Verb::kPublish, topic, type, {}}}, &message);
  }
  Status call(const std::string& service, const std::string& type, const SeatContent& request,
              SeatReader on_response) override {
    return add({{Verb::kCall, service, type, {}}, {}, {}, std::move(on_response)}, &request);
  }
  Expected<SeatGoal> send_goal(const std::string& action, const std::string& type, const SeatContent& goal,
                               GoalReaders readers) override {
    const auto number = static_cast<SeatGoal>(goals_.size());
    Waiting item{{Verb::kGoal, action, type, {}, static_cast<std::uint32_t>(number)}};
    if (Status s = add(std::move(item), &goal); !s) return s.error();
    goals_.push_back({.readers = std::move(readers)});
    return number;
  }
  Status cancel(SeatGoal goal) override {
    const auto number = static_cast<std::uint32_t>(goal);
    if (number >= goals_.size())
      return named(usage_error(found_expected("goal " + std::to_string(number),
                                              "one of the " + std::to_string(goals_.size()) + " that were sent")));
    waiting_.push_back({{Verb::kCancel, {}, {}, {}, number}});
    return {};
  }

  /// Checks what can be checked before its turn comes, and lets it wait.
  Status add(Waiting item, const SeatContent* content) {
    SeatAct& act = item.act;
    const auto wrong = [&](const Error& error) {
      return named({error.kind, act.name + ": " + error.message, {}, 0, {}});
    };
    if (act.name.empty())
      return named(usage_error(found_expected("an empty name", "that of a topic, service or action")));
    auto type = type_of(bus_.registry(), act.type);
    if (!type) return wrong(type.error());
    item.type = *type;
    const bool service = act.verb == Verb::kCall, action = act.verb == Verb::kGoal;
    if (service != (type->service != nullptr) || action != (type->action != nullptr))
      return wrong(
          usage_error(found_expected("the type " + act.type, std::string("that of ") + (service  ? "a service"
                                                                                        : action ? "an action"
                                                                                                 : "a message"))));
    if (content) {
      if (const auto* text = std::get_if<std::string>(content)) {
        auto message = bus::Message::from_yaml(*type->sent, text->empty() ? "{}" : *text);
        if (!message) return wrong(message.error());
        item.message = std::make_shared<const bus::Message>(*std::move(message));
      } else {
        const auto& message = std::get<bus::Message>(*content);
        if (!message || &message.view().type() != type->sent)
          return wrong(usage_error(
              found_expected("a message of " + (message ? message.view().type().name() : std::string("no type")),
                             "one of " + type->sent->name())));
        item.message = std::make_shared<const bus::Message>(message);
      }
      item.message->serialize(act.content);
    }
    if (Status s = check_first_use(act); !s) return wrong(s.error());
    waiting_.push_back(std::move(item));
    return {};
  }

  /// What speaks against an endpoint of this name and type, as the bus would say when the turn comes.
  Status check_first_use(const SeatAct& act) const {
    if (endpoints_.contains(std::tuple(act.verb, act.name, act.type))) return {};
    const bus::NameKind kind = name_kind_of(act.verb);
    if (const std::string fault = bus::name_fault(act.name); !fault.empty()) return usage_error("the name " + fault);
    const auto resolved = [&](const std::string& name) { return bus::NodeName{name_, "/", {}}.resolve(name, kind); };
    const std::string name = resolved(act.name);
    std::set<std::string> types;
    for (const bus::Bus::Info& info : kind == bus::NameKind::kTopic     ? bus_.topics()
                                      : kind == bus::NameKind::kService ? bus_.services()
                                                                        : bus_.actions())
      if (info.name == name) types.insert(info.type);
    for (const Waiting& other : waiting_)
      if (other.act.verb != Verb::kCancel && name_kind_of(other.act.verb) == kind && resolved(other.act.name) == name)
        types.insert(other.act.type);
    if (types.size() != 1 || types.contains(act.type)) return {};  // servers may speak several types under one name
    return usage_error(found_expected("the type " + act.type, *types.begin() + ", which is on the bus"));
  }
  static bus::NameKind name_kind_of(Verb verb) {
    return verb == Verb::kCall   ? bus::NameKind::kService
           : verb == Verb::kGoal ? bus::NameKind::kAction
                                 : bus::NameKind::kTopic;
  }

  // --- Its turn

  /// What the agent says of its turn; an error is in the log, too.
  void hear(SeatTurn turn, const Status& done) {
    if (done) return;
    const Error& error = done.error();
    SeatActs last{bus_.now(), turn, {}};
    last.acts.push_back({SeatAct::Verb::kFail, error.message, error.code, {}, static_cast<std::uint32_t>(error.kind)});
    inputs_.add_seat(stream_, last.t, last.bytes());
    failed_ = named(error);
  }
  Status send(SeatTurn turn) { return send(turn, bus_.now()); }
  Status send(SeatTurn turn, SimTime t) {
    SeatActs sent{t, turn, {}};
    std::vector<Waiting> items;
    items.swap(waiting_);
    for (const Waiting& item : items) sent.acts.push_back(item.act);
    inputs_.add_seat(stream_, t, sent.bytes());
    for (Waiting& item : items)
      if (Status s = post(std::move(item)); !s) return named(s.error());
    return {};
  }
  Status post(Waiting item) {
    if (item.act.verb == Verb::kCancel) {
      const Goal& goal = goals_[item.act.number];
      bus_.cancel_goal(goal.client, goal.id);
      return {};
    }
    if (item.act.verb == Verb::kRead) {
      auto made =
          bus_.subscribe(self_, item.act.name, *item.type.sent,
                         [reader = std::move(item.reader)](const bus::Delivery& delivery) { tell(reader, delivery); });
      return made ? Status() : Status(made.error());
    }
    auto endpoint = endpoint_for(item);
    if (!endpoint) return endpoint.error();
    switch (item.act.verb) {
      case Verb::kPublish: bus_.publish(*endpoint, std::move(item.message)); break;
      case Verb::kCall:
        calls_[{*endpoint, bus_.call(*endpoint, std::move(item.message))}] = std::move(item.reader);
        break;
      default: {
        Goal& goal = goals_[item.act.number];
        goal.client = *endpoint;
        goal.id = bus_.send_goal(*endpoint, std::move(item.message));
        goal_numbers_[goal.id] = item.act.number;
      }
    }
    return {};
  }

  Expected<bus::EndpointId> endpoint_for(const Waiting& item) {
    const auto key = std::tuple(item.act.verb, item.act.name, item.act.type);
    if (const auto known = endpoints_.find(key); known != endpoints_.end()) return known->second;
    auto made = item.type.service  ? client(item)
                : item.type.action ? action_client(item)
                                   : bus_.advertise(self_, item.act.name, *item.type.sent);
    if (made) endpoints_[key] = *made;
    return made;
  }
  Expected<bus::EndpointId> client(const Waiting& item) {
    return bus_.create_client(self_, item.act.name, *item.type.service, [this](const bus::Delivery& delivery) {
      const auto call = calls_.find({delivery.endpoint, delivery.request_id});
      if (call == calls_.end()) return;
      const SeatReader reader = std::move(call->second);
      calls_.erase(call);
      tell(reader, delivery);
    });
  }
  Expected<bus::EndpointId> action_client(const Waiting& item) {
    bus::Bus::ActionClientHandlers handlers;
    handlers.goal_response = [this](const bus::Delivery& delivery) {
      if (const GoalReaders* readers = readers_of(delivery); readers && readers->answer)
        readers->answer(delivery.accepted);
    };
    handlers.feedback = [this](const bus::Delivery& delivery) {
      if (const GoalReaders* readers = readers_of(delivery)) tell(readers->feedback, delivery);
    };
    handlers.result = [this](const bus::Delivery& delivery) {
      if (const GoalReaders* readers = readers_of(delivery); readers && readers->result)
        readers->result(delivery.status == bus::GoalStatus::kSucceeded, view_of(delivery));
      bus_.forget_goal(delivery.endpoint, delivery.goal);
    };
    return bus_.create_action_client(self_, item.act.name, *item.type.action, std::move(handlers));
  }
  static bus::MessageView view_of(const bus::Delivery& delivery) {
    return delivery.message ? delivery.message->view() : bus::MessageView();
  }
  static void tell(const SeatReader& reader, const bus::Delivery& delivery) {
    if (reader) reader(view_of(delivery));
  }
  const GoalReaders* readers_of(const bus::Delivery& delivery) const {
    const auto number = goal_numbers_.find(delivery.goal);
    return number == goal_numbers_.end() ? nullptr : &goals_[number->second].readers;
  }

  bus::Bus& bus_;
  Inputs& inputs_;
  std::string stream_, name_;
  bus::ParticipantId self_{};
  std::unique_ptr<Agent> agent_;
  std::vector<Waiting> waiting_;
  std::optional<Error> failed_;
  std::map<std::tuple<Verb, std::string, std::string>, bus::EndpointId> endpoints_;
  std::map<std::pair<bus::EndpointId, std::uint64_t>, SeatReader> calls_;  // that wait for an answer
  std::deque<Goal> goals_;                                                 // by number; readers may send more
  std::map<bus::GoalId, std::uint32_t> goal_numbers_;
};

// --- Again

/// Sends what a seat of a recorded run sent.
class RecordedSeat final : public Agent {
 public:
  static Expected<std::unique_ptr<Agent>> create(SeatBus& bus, std::deque<SeatActs> acts) {
    std::unique_ptr<RecordedSeat> seat(new RecordedSeat(bus, std::move(acts)));
    for (const SeatTurn turn : {SeatTurn::kMade, SeatTurn::kJoined})
      if (Status s = seat->repeat(turn); !s) return s.error();
    return std::unique_ptr<Agent>(std::move(seat));
  }
  Status perceive() override { return repeat(SeatTurn::kPerceive); }
  Status decide(SimTime) override { return repeat(SeatTurn::kDecide); }
  Status act() override { return repeat(SeatTurn::kAct); }
  SimTime next_due() const override { return left_.empty() ? kNever : left_.front().t; }

 private:
  RecordedSeat(SeatBus& bus, std::deque<SeatActs> acts) : bus_(bus), left_(std::move(acts)) {}

  Status repeat(SeatTurn turn) {
    for (; !left_.empty() && left_.front().t <= bus_.now() && left_.front().turn == turn; left_.pop_front())
      for (const SeatAct& act : left_.front().acts)
        if (Status s = repeat(act); !s) return s;
    return {};
  }
  Status repeat(const SeatAct& act) {
    using Verb = SeatAct::Verb;
    if (act.verb == Verb::kFail) return Error{static_cast<ErrorKind>(act.number), act.name, {}, 0, act.type};
    if (act.verb == Verb::kRead) return bus_.read(act.name, act.type, {});
    if (act.verb == Verb::kCancel) return bus_.cancel(static_cast<SeatGoal>(act.number));
    auto empty = bus_.make(act.type);
    if (!empty) return empty.error();
    std::size_t position = 0;
    auto message = bus::Message::deserialize(empty->view().type(), std::as_bytes(std::span(act.content)), position);
    if (!message) return message.error();
    switch (act.verb) {
      case Verb::kPublish: return bus_.publish(act.name, act.type, *std::move(message));
      case Verb::kCall: return bus_.call(act.name, act.type, *std::move(message));
      default: {
        const auto sent = bus_.send_goal(act.name, act.type, *std::move(message));
        return sent ? Status() : Status(sent.error());
      }
    }
  }

  SeatBus& bus_;
  std::deque<SeatActs> left_;
};

}  // namespace

Expected<std::unique_ptr<Agent>> seated_agent(const Seat& seat, bus::Bus& bus, RecordSink& sink, Inputs& inputs) {
  return SeatedAgent::create(seat, bus, sink, inputs);
}

Expected<std::vector<Seat>> recorded_seats(const std::filesystem::path& inputs) {
  auto log = InputLogReader::open(inputs);
  if (!log) return log.error();
  std::vector<std::pair<std::string, std::deque<SeatActs>>> seats;
  while (const auto entry = log->next()) {
    const auto* logged = std::get_if<LoggedResult>(&*entry);
    if (!logged || logged->key != kSeatKey) continue;
    const std::string name(logged->environment.substr(std::min(kSeatStream.size(), logged->environment.size())));
    auto seat = std::ranges::find(seats, name, &std::pair<std::string, std::deque<SeatActs>>::first);
    if (seat == seats.end()) seat = seats.insert(seat, {name, {}});
    auto acts = SeatActs::parse(logged->t, logged->bytes);
    if (!acts) return input_error("what the seat " + name + " sent is damaged in the input log", inputs.string());
    seat->second.push_back(*std::move(acts));
  }
  std::vector<Seat> out;
  for (auto& [name, acts] : seats) {
    const bool joined = acts.front().turn == SeatTurn::kJoined;
    const SimTime t = acts.front().t;
    out.push_back({name, [acts = std::move(acts)](SeatBus& bus) { return RecordedSeat::create(bus, acts); },
                   joined ? std::optional(t) : std::nullopt});
  }
  return out;
}

}  // namespace cxlab
