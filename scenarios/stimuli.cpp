#include "scenarios/stimuli.h"

#include <algorithm>
#include <map>

#include "cx/node/parameter_services.h"

namespace cxlab {

using bus::Delivery;
using bus::EndpointId;

struct StimuliServer::State {
  /// A stimulus with its message compiled.
  struct Prepared {
    Stimulus stimulus;
    bus::SharedMessage message;
    const bus::ServiceType* service = nullptr;
    const bus::ActionType* action = nullptr;
  };

  bus::Bus& bus;
  RecordSink& sink;
  Log log;
  RecordData data;
  bus::ParticipantId self{};
  std::vector<Prepared> prepared;
  std::size_t next = 0;
  using Channel = std::pair<std::string, std::string>;  // name and type: one name may be served under several
  static Channel channel(const Prepared& item) { return {item.stimulus.target, item.message->view().type().name()}; }
  std::map<Channel, EndpointId> publishers, clients, action_clients;
  std::map<std::string, EndpointId> services;
  std::map<std::string, std::pair<EndpointId, bus::GoalId>> last_goal;

  std::vector<std::string> managers;

  Status prepare(const Stimulus& stimulus);
  /// What is asked of a node at run time, as the call of its service that it is.
  Expected<Stimulus> as_call(const Stimulus& stimulus) const;
  Status stop_node(const Stimulus& stimulus);
  Status post(const Prepared& item);
  Expected<EndpointId> client(const Prepared& item);
  Expected<EndpointId> action_client(const Prepared& item);
  /// What came back, for the log and for the journal.
  void say(const std::string& target, const std::string& what, const Delivery& delivery) {
    log(target + ": " + what + (delivery.message ? ' ' + delivery.message->view().to_string() : std::string()));
    data.begin().field("what", what).field("name", target);
    if (delivery.message) delivery.message->view().record(data.name("message"));
    sink.write(bus.stream_of(self), bus.now(), RecordKind::kInput, data, {&delivery.cause, 1});
  }
};

namespace {

Error at_stimulus(const Stimulus& stimulus, const Error& error) {
  return Error{error.kind, stimulus.target + ": " + error.message, stimulus.origin.source, stimulus.origin.line,
               error.code};
}

const char* word(bus::GoalStatus status) {
  switch (status) {
    case bus::GoalStatus::kSucceeded: return "goal succeeded";
    case bus::GoalStatus::kCanceled: return "goal canceled";
    case bus::GoalStatus::kAborted: return "goal aborted";
    default: return "goal ended";
  }
}

}  // namespace

Expected<Stimulus> StimuliServer::State::as_call(const Stimulus& asked) const {
  using Verb = Stimulus::Verb;
  Stimulus call = asked;
  call.verb = Verb::kCall;
  if (asked.verb == Verb::kSetParam) {
    const std::size_t dot = asked.target.find('.');
    if (dot == 0 || dot == std::string::npos || dot + 1 == asked.target.size())
      return at_stimulus(asked, input_error("expected NODE.NAME of a parameter, as in clips_manager.main.watch"));
    call.target = asked.target.substr(0, dot) + "/set_parameters";
    call.type = "rcl_interfaces/srv/SetParameters";
    cx::Parameters values;
    if (Status s = values.set(asked.target.substr(dot + 1), asked.content, asked.origin); !s)
      return at_stimulus(asked, s.error());
    auto service = bus.registry().service(call.type);
    if (!service) return at_stimulus(asked, service.error());
    bus::Message request(*(*service)->request);
    for (const std::string& name : values.names()) {
      const bus::MessageView parameter = request.view().append("parameters");
      parameter.set("name", name);
      cx::put_parameter(*values.find(name), parameter.nested("value"));
    }
    call.content = request.view().to_string();
    return call;
  }
  std::string manager = asked.manager;
  if (manager.empty()) {
    if (managers.size() != 1)
      return at_stimulus(asked,
                         input_error("there are " + std::to_string(managers.size()) +
                                     " environment managers: say which with 'manager: /NAMESPACE/clips_manager'"));
    manager = managers.front();
  }
  const auto quoted = [](const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
    return out + '"';
  };
  call.content = "{env_name: " + quoted(asked.target) +
                 (asked.plugin.empty() ? "" : ", plugin_name: " + quoted(asked.plugin)) + '}';
  const bool plugin = asked.verb == Verb::kLoadPlugin || asked.verb == Verb::kUnloadPlugin;
  const bool more = asked.verb == Verb::kLoadPlugin || asked.verb == Verb::kCreateEnv;
  call.target =
      manager + (plugin ? (more ? "/load_plugin" : "/unload_plugin") : (more ? "/create_env" : "/destroy_env"));
  call.type = std::string("cx_msgs/srv/") + (plugin ? (more ? "LoadClipsPlugin" : "UnloadClipsPlugin")
                                                    : (more ? "CreateClipsEnv" : "DestroyClipsEnv"));
  return call;
}

/// A lifecycle node is asked to shut down; any other leaves the bus without a word.
Status StimuliServer::State::stop_node(const Stimulus& stimulus) {
  const std::string node = bus.name_of(self).expand(stimulus.target);
  const bool lives = std::ranges::any_of(
      bus.services(), [&](const auto& s) { return s.name == node + "/change_state" && s.providers > 0; });
  if (lives) {
    Stimulus call = stimulus;
    call.verb = Stimulus::Verb::kCall;
    call.target = node + "/change_state";
    call.type = "lifecycle_msgs/srv/ChangeState";
    call.content = "{transition: {label: shutdown}}";
    if (Status s = prepare(call); !s) return s;
    const Prepared item = std::move(prepared.back());
    prepared.pop_back();
    return post(item);
  }
  const auto found = bus.find_node(node);
  if (!found) {
    std::string known;
    for (const std::string& other : bus.nodes()) known += (known.empty() ? "" : ", ") + other;
    return at_stimulus(stimulus, input_error("there is no such node; there are " + known));
  }
  bus.leave(*found);
  log(node + ": stopped");
  data.begin().field("what", "stopped").field("name", std::string_view(node));
  sink.write(bus.stream_of(self), bus.now(), RecordKind::kInput, data);
  return {};
}

Status StimuliServer::State::prepare(const Stimulus& stimulus) {
  if (stimulus.verb >= Stimulus::Verb::kSetParam && stimulus.verb != Stimulus::Verb::kStopNode) {
    auto call = as_call(stimulus);
    return call ? prepare(*call) : Status(call.error());
  }
  Prepared item;
  item.stimulus = stimulus;
  const bus::MessageType* type = nullptr;
  bus::Registry& registry = bus.registry();
  switch (stimulus.verb) {
    case Stimulus::Verb::kPublish: {
      auto message = registry.message(stimulus.type);
      if (!message) return at_stimulus(stimulus, message.error());
      type = *message;
      break;
    }
    case Stimulus::Verb::kCall:
    case Stimulus::Verb::kServe: {
      auto service = registry.service(stimulus.type);
      if (!service) return at_stimulus(stimulus, service.error());
      item.service = *service;
      type = stimulus.verb == Stimulus::Verb::kCall ? (*service)->request : (*service)->response;
      break;
    }
    case Stimulus::Verb::kSendGoal: {
      auto action = registry.action(stimulus.type);
      if (!action) return at_stimulus(stimulus, action.error());
      item.action = *action;
      type = (*action)->goal;
      break;
    }
    default: break;
  }
  if (type) {
    auto message = bus::Message::from_yaml(*type, stimulus.content.empty() ? "{}" : stimulus.content);
    if (!message) return at_stimulus(stimulus, message.error());
    item.message = std::make_shared<const bus::Message>(*std::move(message));
  }
  prepared.push_back(std::move(item));
  return {};
}

Expected<EndpointId> StimuliServer::State::client(const Prepared& item) {
  const std::string& target = item.stimulus.target;
  if (const auto it = clients.find(channel(item)); it != clients.end()) return it->second;
  auto made =
      bus.create_client(self, target, *item.service, [this, target](const Delivery& d) { say(target, "response", d); });
  if (made) clients[channel(item)] = *made;
  return made;
}

Expected<EndpointId> StimuliServer::State::action_client(const Prepared& item) {
  const std::string& target = item.stimulus.target;
  if (const auto it = action_clients.find(channel(item)); it != action_clients.end()) return it->second;
  bus::Bus::ActionClientHandlers handlers;
  handlers.goal_response = [this, target](const Delivery& d) {
    say(target, d.accepted ? "goal accepted" : "goal rejected", d);
  };
  handlers.feedback = [this, target](const Delivery& d) { say(target, "feedback", d); };
  handlers.result = [this, target](const Delivery& d) { say(target, word(d.status), d); };
  handlers.cancel_response = [this, target](const Delivery& d) {
    say(target, d.return_code == 0 ? "cancel accepted" : "cancel refused", d);
  };
  auto made = bus.create_action_client(self, target, *item.action, std::move(handlers));
  if (made) action_clients[channel(item)] = *made;
  return made;
}

Status StimuliServer::State::post(const Prepared& item) {
  const Stimulus& stimulus = item.stimulus;
  const std::string& target = stimulus.target;
  switch (stimulus.verb) {
    case Stimulus::Verb::kPublish: {
      auto it = publishers.find(channel(item));
      if (it == publishers.end()) {
        auto publisher = bus.advertise(self, target, item.message->view().type());
        if (!publisher) return at_stimulus(stimulus, publisher.error());
        it = publishers.emplace(channel(item), *publisher).first;
      }
      bus.publish(it->second, item.message);
      return {};
    }
    case Stimulus::Verb::kCall: {
      auto made = client(item);
      if (!made) return at_stimulus(stimulus, made.error());
      if (!bus.service_ready(*made)) log(target + ": nobody serves it; the call waits");
      bus.call(*made, item.message);
      return {};
    }
    case Stimulus::Verb::kServe: {
      if (const auto it = services.find(target); it != services.end()) bus.remove(it->second);
      const auto endpoint = std::make_shared<EndpointId>();
      auto service =
          bus.serve(self, target, *item.service, [this, endpoint, target, response = item.message](const Delivery& d) {
            say(target, "request", d);
            bus.respond(*endpoint, d, response);
          });
      if (!service) return at_stimulus(stimulus, service.error());
      *endpoint = *service;
      services[target] = *service;
      return {};
    }
    case Stimulus::Verb::kSendGoal: {
      auto made = action_client(item);
      if (!made) return at_stimulus(stimulus, made.error());
      if (!bus.action_ready(*made)) log(target + ": nobody serves it; the goal waits");
      last_goal[target] = {*made, bus.send_goal(*made, item.message)};
      return {};
    }
    case Stimulus::Verb::kCancelGoal: {
      const auto it = last_goal.find(target);
      if (it == last_goal.end()) return input_error(target + ": no goal was sent there before", stimulus.origin);
      bus.cancel_goal(it->second.first, it->second.second);
      return {};
    }
    case Stimulus::Verb::kStopNode: return stop_node(stimulus);
    default: break;  // calls, since `prepare`
  }
  return {};
}

StimuliServer::StimuliServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
StimuliServer::~StimuliServer() = default;

Expected<std::unique_ptr<StimuliServer>> StimuliServer::create(std::vector<Stimulus> stimuli,
                                                               const std::vector<std::string>& managers, bus::Bus& bus,
                                                               RecordSink& sink, Log log) {
  auto state =
      std::unique_ptr<State>(new State{bus, sink, std::move(log), {}, {}, {}, 0, {}, {}, {}, {}, {}, managers});
  state->self =
      bus.join(bus::ParticipantKind::kNode, bus::NodeName{"stimuli", "/", {}}, sink.open_stream("node/stimuli"));
  for (const Stimulus& stimulus : stimuli)
    if (Status s = state->prepare(stimulus); !s) return s.error();
  return std::unique_ptr<StimuliServer>(new StimuliServer(std::move(state)));
}

Status StimuliServer::sense(SimTime now) {
  State& s = *state_;
  while (s.next < s.prepared.size() && s.prepared[s.next].stimulus.at <= now)
    if (Status status = s.post(s.prepared[s.next++]); !status) return status;
  return {};
}

Status StimuliServer::act(SimTime) {
  state_->bus.deliver(state_->self);
  return {};
}

SimTime StimuliServer::next_due() const {
  return state_->next < state_->prepared.size() ? state_->prepared[state_->next].stimulus.at : kNever;
}

}  // namespace cxlab
