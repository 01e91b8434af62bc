#include "cx/testing/stand_ins.h"

#include <algorithm>

#include "cx/base/slip.h"

namespace cxlab::testing {

using bus::Delivery;

/// An outcome with its messages.
struct StandIns::Answer {
  Outcome outcome;
  bus::SharedMessage message;
  std::vector<bus::SharedMessage> feedback;
};

struct StandIns::Served {
  /// A fault that may strike here.
  struct Threat {
    std::size_t fault;
    Answer answer;
  };
  StandIn stand_in;
  const bus::ActionType* action = nullptr;
  const bus::ServiceType* service = nullptr;
  std::vector<Answer> answers;
  std::vector<Threat> threats;
  bus::EndpointId endpoint{};
  std::size_t taken = 0;
};

/// A goal or call that was taken and is answered later.
struct StandIns::Ending {
  bool is_canceling(const bus::Bus& bus) const {
    return action && bus.server_goal_status(endpoint, taken.goal) == bus::GoalStatus::kCanceling;
  }
  SimTime next_feedback() const { return next < feedback.size() ? feedback[next].first : kNever; }
  bool action = true;
  SimTime due{};
  bus::EndpointId endpoint{};
  Delivery taken;
  bus::GoalStatus status{};
  bus::SharedMessage message;
  /// Feedback and when it is due; that before `next` was given.
  std::vector<std::pair<SimTime, bus::SharedMessage>> feedback = {};
  std::size_t next = 0;
};

namespace {

Error at(const Error& error, const std::string& name, const std::string& file, int line) {
  return Error{error.kind, name + ": " + error.message, file, line, error.code};
}

/// The outcome's result; `success` as the outcome is, unless the story says otherwise.
Expected<bus::SharedMessage> result_of(const bus::MessageType& type, const Outcome& outcome) {
  auto read = bus::Message::from_yaml(type, outcome.result.empty() ? "{}" : outcome.result);
  if (!read) return read.error();
  bus::Message message(*std::move(read));
  const bool given = outcome.result.find("success:") != std::string::npos;
  if (!given && outcome.kind == Outcome::Kind::kSucceed &&
      std::any_of(type.fields().begin(), type.fields().end(), [](const bus::Field& f) { return f.name == "success"; }))
    message.view().set("success", true);
  return std::make_shared<const bus::Message>(std::move(message));
}

/// Two robots of one kind differ in digits.
std::string without_digits(std::string name) {
  std::erase_if(name, [](char c) { return c >= '0' && c <= '9'; });
  return name;
}

}  // namespace

StandIns::StandIns(bus::Bus& bus, RecordSink& sink, std::uint64_t seed, std::vector<Fault> faults)
    : bus_(bus),
      self_(bus.join(bus::ParticipantKind::kNode, bus::NodeName{"story", "/", {}}, sink.open_stream("node/story"))),
      seed_(seed),
      faults_(std::move(faults)),
      struck_(faults_.size()) {}

void StandIns::expect(std::vector<Fault> faults) {
  faults_ = std::move(faults);
  struck_.assign(faults_.size(), 0);
}

StandIns::~StandIns() { bus_.leave(self_); }

std::vector<Error> StandIns::read_types(Served& server) const {
  const StandIn& given = server.stand_in;
  if (given.action) {
    auto type = bus_.registry().action(given.type);
    if (!type) return {at(type.error(), given.name, given.file, given.line)};
    server.action = *type;
  } else {
    auto type = bus_.registry().service(given.type);
    if (!type) return {at(type.error(), given.name, given.file, given.line)};
    server.service = *type;
  }
  std::vector<Error> errors;
  server.answers = answers_of(server, given.outcomes, errors);
  for (std::size_t i = 0; i < faults_.size(); ++i) {
    const Fault& fault = faults_[i];
    if (fault.name.empty() ? !given.action : fault.name != given.name) continue;
    for (Answer& answer : answers_of(server, {fault.outcome}, errors)) server.threats.push_back({i, std::move(answer)});
  }
  return errors;
}

std::vector<StandIns::Answer> StandIns::answers_of(const Served& server, const std::vector<Outcome>& outcomes,
                                                   std::vector<Error>& errors) const {
  std::vector<Answer> out;
  const StandIn& given = server.stand_in;
  for (const Outcome& outcome : outcomes) {
    auto message = result_of(server.action ? *server.action->result : *server.service->response, outcome);
    if (message)
      out.push_back({outcome, *message, {}});
    else
      errors.push_back(at(message.error(), given.name, given.file, outcome.line));
    if (!server.action) continue;
    for (const Feedback& one : outcome.feedback) {
      auto feedback = bus::Message::from_yaml(*server.action->feedback, one.data.empty() ? "{}" : one.data);
      if (!feedback)
        errors.push_back(at(feedback.error(), given.name + ": feedback", given.file, one.line));
      else if (message)
        out.back().feedback.push_back(std::make_shared<const bus::Message>(*std::move(feedback)));
    }
  }
  return out;
}

/// The stream of that name goes on when a stand-in is replaced.
RandomStream& StandIns::chance(const std::string& name) {
  return chances_.try_emplace(name, seed_, "story/" + name).first->second;
}

SimTime StandIns::duration(const Served& server, const Outcome& outcome) {
  if (outcome.longest <= outcome.takes) return outcome.takes;
  const SimTime::rep more = (outcome.longest - outcome.takes).count();
  return outcome.takes + SimTime(chance("durations" + server.stand_in.name).between(0, more));
}

/// What meets the goal or call that comes now. Each threat draws at each of them, so that one fault more changes no
/// draw of another.
const StandIns::Answer& StandIns::answer(Served& server) {
  const Answer* struck = nullptr;
  for (const Served::Threat& threat : server.threats) {
    const Fault& fault = faults_[threat.fault];
    const std::string name = "faults/" + std::to_string(threat.fault) + server.stand_in.name;
    const bool strikes = chance(name).chance(fault.probability);
    if (struck || !strikes || (fault.most > 0 && struck_[threat.fault] >= fault.most)) continue;
    ++struck_[threat.fault];
    struck = &threat.answer;
  }
  const Answer& planned = server.answers[std::min(server.taken++, server.answers.size() - 1)];
  return struck ? *struck : planned;
}

bool StandIns::has_type(const std::string& type) const {
  bus::Registry& registry = bus_.registry();
  return registry.message(type).ok() || registry.service(type).ok() || registry.action(type).ok();
}

std::vector<Error> StandIns::check(const StandIn& stand_in) const {
  Served server;
  server.stand_in = stand_in;
  return read_types(server);
}

Status StandIns::check_goal(const StandIn& stand_in, const std::string& content, const std::string& file,
                            int line) const {
  auto action = bus_.registry().action(stand_in.type);
  if (!action) return {};
  auto goal = bus::Message::from_yaml(*(*action)->goal, content.empty() ? "{}" : content);
  return goal ? Status() : at(goal.error(), stand_in.name, file, line);
}

Expected<bus::Message> StandIns::read_message(const std::string& topic, const std::string& type,
                                              const std::string& content, const std::string& file, int line) const {
  auto known = bus_.registry().message(type);
  if (!known) return at(known.error(), topic, file, line);
  auto message = bus::Message::from_yaml(**known, content.empty() ? "{}" : content);
  if (!message) return at(message.error(), topic, file, line);
  return message;
}

Status StandIns::check_message(const std::string& topic, const std::string& type, const std::string& content,
                               const std::string& file, int line) const {
  const auto message = read_message(topic, type, content, file, line);
  return message ? Status() : Status(message.error());
}

Status StandIns::add(const StandIn& given) {
  auto server = std::make_unique<Served>();
  server->stand_in = given;
  Served* raw = server.get();
  if (const std::vector<Error> errors = read_types(*raw); !errors.empty()) return errors.front();
  if (const auto old = servers_.find(given.name); old != servers_.end()) {
    // The endpoint stays, so that running goals end well.
    if (old->second->stand_in.action != given.action || old->second->stand_in.type != given.type)
      return input_error(given.name + ": served as " + old->second->stand_in.type + " before, not as " + given.type,
                         given.file, given.line);
    server->endpoint = old->second->endpoint;
    *old->second = std::move(*server);
    return {};
  }
  auto endpoint =
      given.action
          ? bus_.serve_action(self_, given.name, *server->action,
                              {[this, raw](const Delivery& d) { on_goal(*raw, d); },
                               [this, raw](const Delivery& d) { bus_.answer_cancel(raw->endpoint, d, true); }})
          : bus_.serve(self_, given.name, *server->service, [this, raw](const Delivery& d) { on_call(*raw, d); });
  if (!endpoint) return at(endpoint.error(), given.name, given.file, given.line);
  server->endpoint = *endpoint;
  servers_[given.name] = std::move(server);
  return {};
}

Status StandIns::listen(const std::string& topic, const std::string& type, const std::string& file, int line) {
  if (ears_.contains(topic)) return {};
  auto message = bus_.registry().message(type);
  if (!message) return at(message.error(), topic, file, line);
  auto ear = bus_.subscribe(self_, topic, **message, [this, topic](const Delivery& d) {
    heard_.push_back({Heard::Kind::kTopic, bus_.now(), topic, d.message->view().to_string()});
  });
  if (!ear) return at(ear.error(), topic, file, line);
  ears_[topic] = *ear;
  return {};
}

Status StandIns::publish(const std::string& topic, const std::string& type, const std::string& data,
                         const std::string& file, int line) {
  auto message = read_message(topic, type, data, file, line);
  if (!message) return message.error();
  if (!publishers_.contains(topic)) {
    auto publisher = bus_.advertise(self_, topic, message->view().type());
    if (!publisher) return at(publisher.error(), topic, file, line);
    publishers_[topic] = *publisher;
  }
  bus_.publish(publishers_[topic], std::make_shared<const bus::Message>(*std::move(message)));
  return {};
}

void StandIns::on_goal(Served& server, const Delivery& goal) {
  heard_.push_back({Heard::Kind::kGoal, bus_.now(), server.stand_in.name, goal.message->view().to_string()});
  const auto& [outcome, message, feedback] = answer(server);
  if (outcome.kind == Outcome::Kind::kReject) {
    bus_.answer_goal(server.endpoint, goal.goal, bus::GoalAnswer::kReject);
    return;
  }
  bus_.answer_goal(server.endpoint, goal.goal, bus::GoalAnswer::kAccept);
  const bool never = outcome.kind == Outcome::Kind::kNever;
  endings_.push_back({true, never ? kNever : bus_.now() + duration(server, outcome), server.endpoint, goal,
                      outcome.kind == Outcome::Kind::kSucceed ? bus::GoalStatus::kSucceeded : bus::GoalStatus::kAborted,
                      message});
  for (std::size_t i = 0; i < feedback.size(); ++i)
    endings_.back().feedback.emplace_back(bus_.now() + outcome.feedback[i].after, feedback[i]);
}

void StandIns::on_call(Served& server, const Delivery& request) {
  heard_.push_back({Heard::Kind::kCall, bus_.now(), server.stand_in.name, request.message->view().to_string()});
  const Answer& met = answer(server);
  if (met.outcome.kind == Outcome::Kind::kNever) return;
  endings_.push_back({false, bus_.now() + duration(server, met.outcome), server.endpoint, request, {}, met.message});
}

Expected<bool> StandIns::end_goal(const std::string& action, const Outcome& outcome) {
  const auto server = servers_.find(action);
  if (server == servers_.end()) return false;
  const auto ending = std::find_if(endings_.begin(), endings_.end(),
                                   [&](const Ending& e) { return e.action && e.endpoint == server->second->endpoint; });
  if (ending == endings_.end()) return false;
  auto type = bus_.registry().action(server->second->stand_in.type);
  if (!type) return type.error();
  auto message = result_of(*(*type)->result, outcome);
  if (!message) return message.error();
  ending->due = bus_.now();
  ending->status = outcome.kind == Outcome::Kind::kSucceed ? bus::GoalStatus::kSucceeded : bus::GoalStatus::kAborted;
  ending->message = *message;
  return true;
}

Status StandIns::sense(SimTime now) {
  std::vector<Ending> open;
  for (Ending& ending : endings_) {
    const bool canceling = ending.is_canceling(bus_);
    for (; !canceling && ending.next_feedback() <= std::min(now, ending.due); ++ending.next)
      bus_.publish_feedback(ending.endpoint, ending.taken.goal, ending.feedback[ending.next].second);
    if (ending.due > now && !canceling) {
      open.push_back(std::move(ending));
    } else if (ending.action) {
      bus_.finish(ending.endpoint, ending.taken.goal, canceling ? bus::GoalStatus::kCanceled : ending.status,
                  ending.message);
    } else {
      bus_.respond(ending.endpoint, ending.taken, ending.message);
    }
  }
  endings_ = std::move(open);
  return {};
}

bool StandIns::has_other(const std::vector<bus::ParticipantId>& those) const {
  return std::ranges::any_of(those, [this](bus::ParticipantId p) { return p != self_; });
}

std::string StandIns::meant_by(bus::NameKind kind, const std::string& name, bool unserved) const {
  const std::string own = bus_.name_of(self_).resolve(name, kind);
  const bool was_asked = kind != bus::NameKind::kTopic && std::ranges::count(heard_, name, &Heard::name) > 0;
  if (was_asked || has_other(bus_.users(kind, own))) return {};
  const auto all = kind == bus::NameKind::kTopic     ? bus_.topics()
                   : kind == bus::NameKind::kService ? bus_.services()
                                                     : bus_.actions();
  for (const bus::Bus::Info& other : all)
    if (other.name != own && is_slip(own, other.name) && without_digits(own) != without_digits(other.name) &&
        has_other(bus_.users(kind, other.name)) && !(unserved && other.providers > 0))
      return other.name;
  return {};
}

std::vector<std::string> StandIns::published() const {
  std::vector<std::string> out;
  for (const bus::Bus::Info& topic : bus_.topics())
    if (std::ranges::any_of(bus_.providers(bus::NameKind::kTopic, topic.name),
                            [this](bus::ParticipantId p) { return bus_.is_environment(p); }))
      out.push_back(topic.name);
  return out;
}

Status StandIns::act(SimTime) {
  bus_.deliver(self_);
  return {};
}

SimTime StandIns::next_due() const {
  SimTime first = kNever;
  for (const Ending& ending : endings_)
    first = std::min({first, ending.is_canceling(bus_) ? SimTime::zero() : ending.due, ending.next_feedback()});
  return first;
}

}  // namespace cxlab::testing
