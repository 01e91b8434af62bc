#include "scenarios/stimuli.h"

#include <algorithm>

#include "cx/base/json.h"
#include "cx/node/parameter_services.h"

namespace cxlab {

using bus::Delivery;
using bus::EndpointId;
using Verb = Stimulus::Verb;

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

void StimuliServer::say(const std::string& target, const std::string& what, const Delivery& delivery) {
  log_(target + ": " + what + (delivery.message ? ' ' + delivery.message->view().to_string() : std::string()));
  data_.begin().field("what", what).field("name", target);
  if (delivery.message) delivery.message->view().record(data_.name("message"));
  sink_.write(bus_.stream_of(self_), bus_.now(), RecordKind::kInput, data_, {&delivery.cause, 1});
}

Expected<Stimulus> StimuliServer::as_call(const Stimulus& asked) const {
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
    auto service = bus_.registry().service(call.type);
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
    if (managers_.size() != 1)
      return at_stimulus(asked,
                         input_error("there are " + std::to_string(managers_.size()) +
                                     " environment managers: say which with 'manager: /NAMESPACE/clips_manager'"));
    manager = managers_.front();
  }
  Json request{{"env_name", asked.target}};
  if (!asked.plugin.empty()) request["plugin_name"] = asked.plugin;
  call.content = json_text(request);
  const bool plugin = asked.verb == Verb::kLoadPlugin || asked.verb == Verb::kUnloadPlugin;
  const bool more = asked.verb == Verb::kLoadPlugin || asked.verb == Verb::kCreateEnv;
  call.target =
      manager + (plugin ? (more ? "/load_plugin" : "/unload_plugin") : (more ? "/create_env" : "/destroy_env"));
  call.type = std::string("cx_msgs/srv/") + (plugin ? (more ? "LoadClipsPlugin" : "UnloadClipsPlugin")
                                                    : (more ? "CreateClipsEnv" : "DestroyClipsEnv"));
  return call;
}

/// A lifecycle node receives the request to shut down; any other node leaves the bus at once.
Status StimuliServer::stop_node(const Stimulus& stimulus) {
  const std::string node = bus_.name_of(self_).expand(stimulus.target);
  const bool lives = std::ranges::any_of(
      bus_.services(), [&](const auto& s) { return s.name == node + "/change_state" && s.providers > 0; });
  if (lives) {
    Stimulus call = stimulus;
    call.verb = Verb::kCall;
    call.target = node + "/change_state";
    call.type = "lifecycle_msgs/srv/ChangeState";
    call.content = "{transition: {label: shutdown}}";
    if (Status s = prepare(call); !s) return s;
    const Prepared item = std::move(prepared_.back());
    prepared_.pop_back();
    return post(item);
  }
  const auto found = bus_.find_node(node);
  if (!found) {
    std::string known;
    for (const std::string& other : bus_.nodes()) known += (known.empty() ? "" : ", ") + other;
    return at_stimulus(stimulus, input_error("there is no such node; there are " + known));
  }
  bus_.leave(*found);
  log_(node + ": stopped");
  data_.begin().field("what", "stopped").field("name", std::string_view(node));
  sink_.write(bus_.stream_of(self_), bus_.now(), RecordKind::kInput, data_);
  return {};
}

Status StimuliServer::prepare(const Stimulus& stimulus) {
  if (stimulus.verb >= Verb::kSetParam && stimulus.verb != Verb::kStopNode) {
    auto call = as_call(stimulus);
    return call ? prepare(*call) : Status(call.error());
  }
  Prepared item;
  item.stimulus = stimulus;
  const bus::MessageType* type = nullptr;
  bus::Registry& registry = bus_.registry();
  switch (stimulus.verb) {
    case Verb::kPublish: {
      auto message = registry.message(stimulus.type);
      if (!message) return at_stimulus(stimulus, message.error());
      type = *message;
      break;
    }
    case Verb::kCall:
    case Verb::kServe: {
      auto service = registry.service(stimulus.type);
      if (!service) return at_stimulus(stimulus, service.error());
      item.service = *service;
      type = stimulus.verb == Verb::kCall ? (*service)->request : (*service)->response;
      break;
    }
    case Verb::kSendGoal: {
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
  prepared_.push_back(std::move(item));
  return {};
}

Expected<EndpointId> StimuliServer::open(const Prepared& item) {
  const std::string& target = item.stimulus.target;
  const auto saying = [this, target](const char* what) {
    return [=, this](const Delivery& d) { say(target, what, d); };
  };
  switch (item.stimulus.verb) {
    case Verb::kPublish: return bus_.advertise(self_, target, item.message->view().type());
    case Verb::kCall: return bus_.create_client(self_, target, *item.service, saying("response"));
    default: break;
  }
  bus::Bus::ActionClientHandlers handlers;
  handlers.goal_response = [this, target](const Delivery& d) {
    say(target, d.accepted ? "goal accepted" : "goal rejected", d);
  };
  handlers.feedback = saying("feedback");
  handlers.result = [this, target](const Delivery& d) { say(target, word(d.status), d); };
  handlers.cancel_response = [this, target](const Delivery& d) {
    say(target, d.return_code == 0 ? "cancel accepted" : "cancel refused", d);
  };
  return bus_.create_action_client(self_, target, *item.action, std::move(handlers));
}

Status StimuliServer::serve(const Prepared& item) {
  const std::string& target = item.stimulus.target;
  if (const auto it = services_.find(target); it != services_.end()) bus_.remove(it->second);
  const auto endpoint = std::make_shared<EndpointId>();
  auto service =
      bus_.serve(self_, target, *item.service, [this, endpoint, target, response = item.message](const Delivery& d) {
        say(target, "request", d);
        bus_.respond(*endpoint, d, response);
      });
  if (!service) return at_stimulus(item.stimulus, service.error());
  services_[target] = *endpoint = *service;
  return {};
}

Status StimuliServer::cancel_goal(const Stimulus& stimulus) {
  const auto sent = last_goal_.find(stimulus.target);
  if (sent == last_goal_.end())
    return input_error(stimulus.target + ": no goal was sent there before", stimulus.origin);
  bus_.cancel_goal(sent->second.first, sent->second.second);
  return {};
}

Status StimuliServer::post(const Prepared& item) {
  const Stimulus& stimulus = item.stimulus;
  const std::string& target = stimulus.target;
  if (stimulus.verb == Verb::kServe) return serve(item);
  if (stimulus.verb == Verb::kCancelGoal) return cancel_goal(stimulus);
  if (stimulus.verb == Verb::kStopNode) return stop_node(stimulus);
  const Channel channel{target, item.message->view().type().name()};
  auto at = endpoints_.find(channel);
  if (at == endpoints_.end()) {
    auto made = open(item);
    if (!made) return at_stimulus(stimulus, made.error());
    at = endpoints_.emplace(channel, *made).first;
  }
  const EndpointId endpoint = at->second;
  if (stimulus.verb == Verb::kPublish) {
    bus_.publish(endpoint, item.message);
  } else if (stimulus.verb == Verb::kCall) {
    if (!bus_.service_ready(endpoint)) log_(target + ": nobody serves it; the call waits");
    bus_.call(endpoint, item.message);
  } else {
    if (!bus_.action_ready(endpoint)) log_(target + ": nobody serves it; the goal waits");
    last_goal_[target] = {endpoint, bus_.send_goal(endpoint, item.message)};
  }
  return {};
}

StimuliServer::StimuliServer(const std::vector<std::string>& managers, bus::Bus& bus, RecordSink& sink, Log log)
    : bus_(bus), sink_(sink), log_(std::move(log)), managers_(managers) {
  self_ = bus.join(bus::ParticipantKind::kNode, bus::NodeName{"stimuli", "/", {}}, sink.open_stream("node/stimuli"));
}

Expected<std::unique_ptr<StimuliServer>> StimuliServer::create(const std::vector<Stimulus>& stimuli,
                                                               const std::vector<std::string>& managers, bus::Bus& bus,
                                                               RecordSink& sink, Log log) {
  std::unique_ptr<StimuliServer> server(new StimuliServer(managers, bus, sink, std::move(log)));
  for (const Stimulus& stimulus : stimuli)
    if (Status s = server->prepare(stimulus); !s) return s.error();
  return server;
}

Status StimuliServer::sense(SimTime now) {
  while (next_ < prepared_.size() && prepared_[next_].stimulus.at <= now)
    if (Status s = post(prepared_[next_++]); !s) return s;
  return {};
}

Status StimuliServer::act(SimTime) {
  bus_.deliver(self_);
  return {};
}

SimTime StimuliServer::next_due() const { return next_ < prepared_.size() ? prepared_[next_].stimulus.at : kNever; }

}  // namespace cxlab
