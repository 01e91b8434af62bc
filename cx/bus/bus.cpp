#include "cx/bus/bus.h"

#include <algorithm>
#include <cassert>
#include <tuple>

#include "cx/base/charge.h"
#include "cx/bus/bus_state.h"
#include "cx/bus/names.h"
#include "cx/bus/transforms.h"

namespace cxlab::bus {

namespace {

bool comes_before(const Delivery& a, const Delivery& b) {
  return std::tie(a.kind, a.from, a.sequence, a.endpoint) < std::tie(b.kind, b.from, b.sequence, b.endpoint);
}

std::string_view op_of(EndpointKind kind) {
  static constexpr std::array<std::string_view, 6> kOps{"advertise", "subscribe",    "serve",
                                                        "client",    "serve_action", "action_client"};
  return kOps[static_cast<std::size_t>(kind)];
}

std::string_view noun_of(EndpointKind kind) {
  static constexpr std::array<std::string_view, 3> kNouns{"topic", "service", "action"};
  return kNouns[static_cast<std::size_t>(name_kind(kind))];
}

std::vector<Bus::Info> info_of(const Channels& channels) {
  std::vector<Bus::Info> infos;
  for (const auto& [key, channel] : channels) {
    if (channel->providers.empty() && channel->users.empty()) continue;
    infos.push_back({channel->name, channel->type_name, static_cast<int>(channel->providers.size()),
                     static_cast<int>(channel->users.size())});
  }
  return infos;
}

}  // namespace

Bus::Bus(Registry& registry, RecordSink& sink) : registry_(registry), state_(std::make_unique<State>(sink)) {}
Bus::~Bus() = default;

// --- Participants

ParticipantId Bus::join(ParticipantKind kind, NodeName name, StreamId stream, std::string part) {
  auto participant = std::make_unique<Participant>();
  participant->kind = kind;
  participant->stream = stream;
  for (const auto& other : state_->participants) participant->twin += other->name.full_name() == name.full_name();
  participant->name = std::move(name);
  participant->part = std::move(part);
  state_->data.begin().field("op", "join").field("name", std::string_view(participant->name.full_name()));
  state_->sink.write(stream, now_, RecordKind::kBus, state_->data);
  state_->participants.push_back(std::move(participant));
  return static_cast<ParticipantId>(state_->participants.size() - 1);
}

const NodeName& Bus::name_of(ParticipantId p) const { return state_->participant(p).name; }
bool Bus::is_there(ParticipantId p) const { return !state_->participant(p).gone; }
bool Bus::is_environment(ParticipantId p) const { return state_->participant(p).kind == ParticipantKind::kEnvironment; }

std::optional<ParticipantId> Bus::find_node(std::string_view full_name) const {
  for (std::size_t i = 0; i < state_->participants.size(); ++i) {
    const Participant& p = *state_->participants[i];
    if (p.kind == ParticipantKind::kNode && !p.gone && p.name.full_name() == full_name)
      return static_cast<ParticipantId>(i);
  }
  return std::nullopt;
}

std::vector<std::string> Bus::nodes() const {
  std::vector<std::string> names;
  for (const auto& p : state_->participants)
    if (p->kind == ParticipantKind::kNode && !p->gone) names.push_back(p->name.full_name());
  std::ranges::sort(names);
  return names;
}

StreamId Bus::stream_of(ParticipantId p) const { return state_->participant(p).stream; }

void Bus::leave(ParticipantId p) {
  Participant& participant = state_->participant(p);
  if (participant.gone) return;
  for (std::size_t i = 0; i < participant.endpoints.size(); ++i)
    if (participant.endpoints[i]) remove(participant.endpoints[i]->id);
  participant.gone = true;
  if (!participant.delivering) participant.release();
  state_->data.begin().field("op", "leave").field("name", std::string_view(participant.name.full_name()));
  state_->sink.write(participant.stream, now_, RecordKind::kBus, state_->data);
}

void Bus::begin_tick(SimTime now) {
  now_ = now;
  ++state_->tick;
  for (auto& participant : state_->participants) {
    auto& next = participant->next_inbox;
    participant->inbox.insert(participant->inbox.end(), std::make_move_iterator(next.begin()),
                              std::make_move_iterator(next.end()));
    next.clear();
  }
}

// --- Endpoints

Expected<EndpointId> Bus::add(ParticipantId p, std::string_view written, std::unique_ptr<Endpoint> made,
                              std::string_view type_name, Rank rank) {
  Participant& owner = state_->participant(p);
  if (owner.gone) return run_error("node '" + owner.name.full_name() + "' has left the bus");
  const std::string noun(noun_of(made->kind));
  if (const std::string fault = name_fault(written); !fault.empty())
    return input_error("name of the " + noun + " '" + std::string(written) + "' " + fault);
  const NameKind kind = name_kind(made->kind);
  const std::string name = owner.name.resolve(written, kind);
  auto& channel = state_->channels_of(kind)[state_->key_of(made->kind, name, type_name)];
  if (!channel) {
    channel = std::make_unique<Channel>();
    channel->name = name;
  }
  if (channel->providers.empty() && channel->users.empty()) {
    if (channel->type != made->message) {
      channel->waiting.clear();
      channel->kept.clear();
    }
    channel->type_name = type_name;
    channel->type = made->message;
  } else if (channel->type != made->message) {
    return input_error(noun + " '" + name + "' has type " + channel->type_name + ", found a second type " +
                       std::string(type_name));
  }

  Endpoint& endpoint = *made;
  endpoint.id = static_cast<EndpointId>(static_cast<std::uint64_t>(p) << 32 | owner.endpoints.size());
  endpoint.owner = p;
  endpoint.channel = channel.get();
  endpoint.stands_in = rank == Rank::kStandIn;
  auto& siblings = endpoint.provides() ? channel->providers : channel->users;
  siblings.insert(endpoint.stands_in ? siblings.end() : std::ranges::find(siblings, true, &Endpoint::stands_in),
                  &endpoint);
  owner.endpoints.push_back(std::move(made));
  if (endpoint.kind == EndpointKind::kPublisher) endpoint.opening = state_->begin("publish", endpoint);
  state_->begin(op_of(endpoint.kind), endpoint).field("type", type_name);
  state_->write(now_, endpoint, {});

  if (endpoint.kind == EndpointKind::kSubscription)
    for (const auto& [what, message] : channel->kept)
      state_->enqueue(endpoint, Delivery(message.delivery), message.tick);
  const bool serves = endpoint.provides() && endpoint.kind != EndpointKind::kPublisher;
  if (serves && !endpoint.stands_in && channel->providers.front() != &endpoint && state_->report_rivals &&
      !state_->is_twin_of(*channel->providers.front(), owner))
    state_->report_rivals(noun + " '" + name +
                          "' has more than one server: " + state_->owner_of(*channel->providers.front()) +
                          " answers, " + state_->owner_of(endpoint) + " only once that is gone");
  if (serves && channel->providers.size() == 1) {
    for (Waiting& request : channel->waiting) state_->hand_to_server(endpoint, std::move(request));
    channel->waiting.clear();
  }
  return endpoint.id;
}

namespace {

/// `types`: message, answer, feedback; `handlers` by handler_index.
std::unique_ptr<Endpoint> make_endpoint(EndpointKind kind, std::array<const MessageType*, 3> types,
                                        std::array<Handler, 4> handlers = {}) {
  auto endpoint = std::make_unique<Endpoint>();
  endpoint->kind = kind;
  endpoint->message = types[0];
  endpoint->answer = types[1];
  endpoint->feedback = types[2];
  endpoint->handlers = std::move(handlers);
  return endpoint;
}

}  // namespace

Expected<EndpointId> Bus::advertise(ParticipantId p, std::string_view topic, const MessageType& type) {
  return add(p, topic, make_endpoint(EndpointKind::kPublisher, {&type}), type.name());
}

Expected<EndpointId> Bus::subscribe(ParticipantId p, std::string_view topic, const MessageType& type, Handler handler) {
  return add(p, topic, make_endpoint(EndpointKind::kSubscription, {&type}, {std::move(handler)}), type.name());
}

Expected<EndpointId> Bus::serve(ParticipantId p, std::string_view service, const ServiceType& type, Handler on_request,
                                Rank rank) {
  return add(p, service, make_endpoint(EndpointKind::kServer, {type.request, type.response}, {std::move(on_request)}),
             type.name, rank);
}

Expected<EndpointId> Bus::create_client(ParticipantId p, std::string_view service, const ServiceType& type,
                                        Handler on_response) {
  return add(p, service, make_endpoint(EndpointKind::kClient, {type.request, type.response}, {std::move(on_response)}),
             type.name);
}

Expected<EndpointId> Bus::serve_action(ParticipantId p, std::string_view action, const ActionType& type,
                                       ActionServerHandlers h, Rank rank) {
  return add(p, action,
             make_endpoint(EndpointKind::kActionServer, {type.goal, type.result, type.feedback},
                           {std::move(h.goal), std::move(h.cancel)}),
             type.name, rank);
}

Expected<EndpointId> Bus::create_action_client(ParticipantId p, std::string_view action, const ActionType& type,
                                               ActionClientHandlers h) {
  return add(p, action,
             make_endpoint(EndpointKind::kActionClient, {type.goal, type.result, type.feedback},
                           {std::move(h.goal_response), std::move(h.feedback), std::move(h.result),
                            std::move(h.cancel_response)}),
             type.name);
}

void Bus::allow_types(ParticipantId p, std::string_view name) {
  for (const NameKind kind : {NameKind::kService, NameKind::kAction}) {
    const std::string resolved = state_->participant(p).name.resolve(name, kind);
    state_->many_typed.insert(resolved);
    Channels& channels = state_->channels_of(kind);
    auto known = channels.extract(resolved);
    if (known.empty()) continue;
    known.key() += ' ' + known.mapped()->type_name;
    channels.insert(std::move(known));
  }
}

void Bus::on_rivals(std::function<void(const std::string&)> report) { state_->report_rivals = std::move(report); }

void Bus::remove(EndpointId id) {
  Endpoint* endpoint = state_->find(id);
  if (endpoint == nullptr) return;
  state_->begin("remove", *endpoint);
  state_->write(now_, *endpoint, {});
  std::erase(endpoint->provides() ? endpoint->channel->providers : endpoint->channel->users, endpoint);
  std::erase_if(endpoint->channel->kept, [id](const auto& item) { return item.second.client == id; });

  Participant& owner = state_->participant(endpoint->owner);
  const auto for_it = [id](const Delivery& delivery) { return delivery.endpoint == id; };
  std::erase_if(owner.inbox, for_it);
  std::erase_if(owner.next_inbox, for_it);
  auto& slot = owner.endpoints[static_cast<std::uint64_t>(id) & 0xffffffffU];
  if (state_->running > 0) state_->removed.push_back(std::move(slot));
  slot.reset();
}

// --- Topics and services

void Bus::publish(EndpointId publisher, SharedMessage message, Causes causes) {
  Endpoint* from = state_->find(publisher, EndpointKind::kPublisher);
  if (from == nullptr) return;
  assert(message && &message->view().type() == from->message);
  Delivery delivery = state_->begin_publish(*from);
  state_->add_message("msg", message);
  delivery.cause = state_->write(now_, *from, causes);
  if (state_->muted) return;
  delivery.message = std::move(message);
  if (is_kept_topic(from->channel->name, *from->message))
    from->channel->kept[placed_frames(delivery.message->view())] = {delivery, from->id, state_->tick};
  const auto& users = from->channel->users;
  for (std::size_t i = 0; i + 1 < users.size(); ++i) state_->enqueue(*users[i], Delivery(delivery), state_->tick);
  if (!users.empty()) state_->enqueue(*users.back(), std::move(delivery), state_->tick);
}

void Bus::publish_to(EndpointId publisher, std::span<const EndpointId> subscriptions, SharedMessage message,
                     Causes causes) {
  Endpoint* from = state_->find(publisher, EndpointKind::kPublisher);
  if (from == nullptr) return;
  assert(message && &message->view().type() == from->message);
  Delivery delivery = state_->begin_publish(*from);
  state_->add_message("msg", message);
  delivery.cause = state_->write(now_, *from, causes);
  if (state_->muted) return;
  delivery.message = std::move(message);
  for (const EndpointId subscription : subscriptions) {
    Endpoint* to = state_->find(subscription, EndpointKind::kSubscription);
    if (to == nullptr) continue;
    assert(to->channel == from->channel);
    state_->enqueue(*to, Delivery(delivery), state_->tick);
  }
}

bool Bus::service_ready(EndpointId client) const {
  const Endpoint* from = state_->find(client, EndpointKind::kClient);
  return from != nullptr && !from->channel->providers.empty();
}

std::uint64_t Bus::call(EndpointId client, SharedMessage request, Causes causes) {
  Endpoint* from = state_->find(client, EndpointKind::kClient);
  if (from == nullptr) return 0;
  assert(request && &request->view().type() == from->message);
  Delivery delivery = state_->begin_post(DeliveryKind::kServiceRequest, "call", *from);
  const std::uint64_t number = delivery.request_id = from->next_number++;
  state_->data.field("id", number);
  state_->add_message("request", request);
  delivery.cause = state_->write(now_, *from, causes);
  delivery.message = std::move(request);
  state_->send_to_server(*from, std::move(delivery));
  return number;
}

bool Bus::number_requests_from(ParticipantId p, std::string_view service_as_written, std::uint64_t number) {
  const Participant& owner = state_->participant(p);
  const std::string name = owner.name.resolve(service_as_written, NameKind::kService);
  bool any = false;
  for (const auto& endpoint : owner.endpoints) {
    if (!endpoint || endpoint->kind != EndpointKind::kClient || endpoint->channel->name != name) continue;
    endpoint->next_number = number;
    any = true;
  }
  return any;
}

bool Bus::respond(EndpointId service, const Delivery& request, SharedMessage response) {
  Endpoint* from = state_->find(service, EndpointKind::kServer);
  if (from == nullptr) return false;
  const auto open = from->requests.find(request.request_id);
  if (open == from->requests.end() || !open->second.taken) return false;
  assert(response && &response->view().type() == from->answer);
  Delivery delivery = state_->begin_post(DeliveryKind::kServiceResponse, "respond", *from);
  state_->data.field("id", request.request_id);
  state_->add_message("response", response);
  delivery.cause = state_->write(now_, *from, {&open->second.cause, 1});
  delivery.request_id = open->second.number;
  delivery.message = std::move(response);
  const EndpointId client = open->second.client;
  from->requests.erase(open);
  state_->reply(client, std::move(delivery));
  return true;
}

// --- Taking

bool Bus::has_waiting(ParticipantId p) const { return !state_->participant(p).inbox.empty(); }

bool Bus::any_waiting() const {
  return std::ranges::any_of(state_->participants,
                             [](const auto& p) { return !p->inbox.empty() || !p->next_inbox.empty(); });
}

void Bus::State::call_handler(Endpoint& endpoint, const Delivery& delivery) {
  const Handler& handler = endpoint.handlers[handler_index(delivery.kind)];
  if (!handler) return;
  const Charge charge(participant(delivery.from).kind == ParticipantKind::kEnvironment);
  ++running;
  handler(delivery);
  if (--running == 0) removed.clear();
}

void Bus::State::handle(SimTime now, const Delivery& delivery) {
  Endpoint* endpoint = find(delivery.endpoint);
  if (endpoint == nullptr) return;
  switch (delivery.kind) {
    case DeliveryKind::kServiceRequest: {
      OpenRequest& open = endpoint->requests[delivery.request_id];
      open.taken = true;
      open.cause = delivery.cause;
      break;
    }
    case DeliveryKind::kGoal: {
      ServedGoal& goal = endpoint->served_goal(delivery.goal);
      goal.taken = true;
      goal.cause = delivery.cause;
      break;
    }
    case DeliveryKind::kCancel: take_cancel(now, *endpoint, delivery); return;
    case DeliveryKind::kGoalResponse:
    case DeliveryKind::kFeedback:
    case DeliveryKind::kResult:
      if (const auto known = endpoint->sent.find(delivery.goal); known != endpoint->sent.end()) {
        known->second = delivery.status;
        if (delivery.kind == DeliveryKind::kGoalResponse && !delivery.accepted) endpoint->sent.erase(known);
      }
      break;
    case DeliveryKind::kCancelResponse:
      for (const auto& [goal, accepted_at] : delivery.goals_canceling)
        if (const auto known = endpoint->sent.find(goal);
            known != endpoint->sent.end() && known->second <= GoalStatus::kExecuting)
          known->second = GoalStatus::kCanceling;
      break;
    case DeliveryKind::kServiceResponse:
    case DeliveryKind::kTopic: break;
  }
  call_handler(*endpoint, delivery);
}

std::size_t Bus::deliver(ParticipantId p) {
  Participant& participant = state_->participant(p);
  if (participant.inbox.empty()) return 0;
  assert(!participant.delivering && "deliver() from a handler of the same participant");
  participant.delivering = true;
  auto& taken = participant.taken;
  taken.swap(participant.inbox);
  if (!std::is_sorted(taken.begin(), taken.end(), comes_before)) std::ranges::sort(taken, comes_before);
  if (state_->tap != nullptr) {
    const Charge charge(std::ranges::any_of(taken, [this](const Delivery& d) { return is_environment(d.from); }));
    state_->tap->delivered(p, taken);
  }
  for (const Delivery& delivery : taken) state_->handle(now_, delivery);
  const std::size_t count = taken.size();
  taken.clear();
  participant.delivering = false;
  return count;
}

void Bus::set_input_tap(InputTap* tap) { state_->tap = tap; }

std::uint32_t Bus::number_of(EndpointId endpoint) const {
  return static_cast<std::uint32_t>(static_cast<std::uint64_t>(endpoint) & 0xffffffffU);
}

std::optional<EndpointId> Bus::endpoint_of(ParticipantId p, std::uint32_t number) const {
  if (number >= state_->participant(p).endpoints.size()) return std::nullopt;
  return static_cast<EndpointId>(static_cast<std::uint64_t>(p) << 32 | number);
}

void Bus::mute(bool on) { state_->muted = on; }

void Bus::inject(ParticipantId to, const std::vector<Delivery>& deliveries) {
  for (Delivery delivery : deliveries) {
    const std::uint64_t number = static_cast<std::uint64_t>(delivery.endpoint) & 0xffffffffU;
    delivery.endpoint = static_cast<EndpointId>(static_cast<std::uint64_t>(to) << 32 | number);
    state_->handle(now_, delivery);
  }
}

std::vector<ParticipantId> Bus::owners(NameKind kind, std::string_view name, bool providing) const {
  std::vector<ParticipantId> all;
  const Channels& channels = state_->channels_of(kind);
  for (auto at = channels.lower_bound(name); at != channels.end() && at->first.starts_with(name); ++at) {
    if (at->second->name != name) continue;  // under its type the same name, or a longer one
    for (const Endpoint* endpoint : providing ? at->second->providers : at->second->users)
      if (std::ranges::find(all, endpoint->owner) == all.end()) all.push_back(endpoint->owner);
  }
  return all;
}

std::vector<ParticipantId> Bus::providers(NameKind kind, std::string_view name) const {
  return owners(kind, name, true);
}
std::vector<ParticipantId> Bus::users(NameKind kind, std::string_view name) const { return owners(kind, name, false); }
std::string Bus::described(ParticipantId p) const { return state_->described(p); }

std::vector<Bus::Info> Bus::topics() const { return info_of(state_->channels_of(NameKind::kTopic)); }
std::vector<Bus::Info> Bus::services() const { return info_of(state_->channels_of(NameKind::kService)); }
std::vector<Bus::Info> Bus::actions() const { return info_of(state_->channels_of(NameKind::kAction)); }

}  // namespace cxlab::bus
