#pragma once
// The state of the bus. Only for bus.cpp and actions.cpp.

#include <array>
#include <cassert>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cx/bus/bus.h"

namespace cxlab::bus {

enum class EndpointKind : std::uint8_t { kPublisher, kSubscription, kServer, kClient, kActionServer, kActionClient };

/// Two kinds of endpoints each.
inline NameKind name_kind(EndpointKind kind) { return static_cast<NameKind>(static_cast<int>(kind) / 2); }

struct Endpoint;

/// A call, goal or cancel that waits for a server.
struct Waiting {
  Delivery delivery;
  EndpointId client{};
  std::uint64_t tick = 0;  ///< of the post
};

/// One topic, service or action under its absolute name.
struct Channel {
  std::string name;
  std::string type_name;
  const MessageType* type = nullptr;  ///< the message, request or goal: identifies the type
  std::vector<Endpoint*> providers;   ///< publishers, servers
  std::vector<Endpoint*> users;       ///< subscriptions, clients
  std::vector<Waiting> waiting;
  std::map<std::string, Waiting> kept;  ///< of a kept topic (`is_kept_topic`): what later subscriptions get
};
using Channels = std::map<std::string, std::unique_ptr<Channel>, std::less<>>;

/// The server's view of a goal that reached it.
struct ServedGoal {
  EndpointId client{};
  bool taken = false;                        ///< the server has seen it
  std::size_t order = 0;                     ///< among those that reached the server
  GoalStatus status = GoalStatus::kUnknown;  ///< unknown until it is answered
  SimTime accepted_at{};
  RecordRef cause;

  bool cancelable() const { return status == GoalStatus::kAccepted || status == GoalStatus::kExecuting; }
  bool ended() const { return status > GoalStatus::kCanceling; }
};

/// A call or cancel that a server has not answered yet.
struct OpenRequest {
  EndpointId client{};
  std::uint64_t number = 0;  ///< the client's
  bool taken = false;
  // Cancels: the goals that the server has not answered yet, and those that it cancels.
  GoalId goal{};
  RecordRef cause;
  std::vector<GoalId> undecided;
  std::vector<std::pair<GoalId, SimTime>> canceling;
};

struct Endpoint {
  EndpointId id{};
  ParticipantId owner{};
  EndpointKind kind{};
  Channel* channel = nullptr;
  /// Topic, request, response or goal; and the other messages of an action.
  const MessageType* message = nullptr;
  const MessageType* answer = nullptr;  ///< response, result
  const MessageType* feedback = nullptr;
  RecordData opening;               ///< publishers: how the record of each post begins
  std::array<Handler, 4> handlers;  ///< by handler_index
  std::uint64_t next_number = 1;    ///< of a client's calls, or of the requests to a server
  std::map<std::uint64_t, OpenRequest> requests;
  std::map<GoalId, GoalStatus> sent;  ///< the client's view of its goals
  std::map<GoalId, ServedGoal> served;
  std::deque<std::pair<SimTime, GoalId>> ended;  ///< of `served`, with their ends
  std::size_t next_order = 0;
  bool stands_in = false;

  bool provides() const {
    return kind == EndpointKind::kPublisher || kind == EndpointKind::kServer || kind == EndpointKind::kActionServer;
  }
  ServedGoal& served_goal(const GoalId& goal) {
    const auto [at, added] = served.try_emplace(goal);
    if (added) at->second.order = next_order++;
    return at->second;
  }
};

/// Which of an endpoint's handlers takes deliveries of that kind.
inline std::size_t handler_index(DeliveryKind kind) {
  switch (kind) {
    case DeliveryKind::kCancel:
    case DeliveryKind::kFeedback: return 1;
    case DeliveryKind::kResult: return 2;
    case DeliveryKind::kCancelResponse: return 3;
    default: return 0;
  }
}

struct Participant {
  ParticipantKind kind{};
  NodeName name;
  std::string part;  ///< of the node, for example "environment main"; may be empty
  StreamId stream{};
  std::uint64_t twin = 0;  ///< participants of the same full name that joined before
  std::uint64_t posts = 0;
  bool delivering = false;
  bool gone = false;                                 ///< it has left; its name and stream stay, for what it had posted
  std::vector<std::unique_ptr<Endpoint>> endpoints;  ///< by number; null once removed
  std::vector<Delivery> inbox;                       ///< may be taken now
  std::vector<Delivery> next_inbox;                  ///< from environments to this one: after the next begin_tick
  std::vector<Delivery> taken;                       ///< what deliver() works on; keeps its memory

  /// Frees the memory of a participant that left: environments may be made and destroyed many times.
  void release() {
    std::vector<std::unique_ptr<Endpoint>>().swap(endpoints);
    for (auto* box : {&inbox, &next_inbox, &taken}) std::vector<Delivery>().swap(*box);
  }
};

struct Bus::State {
  RecordSink& sink;
  std::vector<std::unique_ptr<Participant>> participants;
  std::array<Channels, 3> channels;               // by NameKind
  std::set<std::string, std::less<>> many_typed;  ///< names of services and actions under which types live side by side
  std::vector<std::unique_ptr<Endpoint>> removed;  ///< whose handler may be running
  int running = 0;                                 ///< handlers, nested
  std::uint64_t tick = 0;
  InputTap* tap = nullptr;
  bool muted = false;
  RecordData data;
  std::function<void(const std::string&)> report_rivals;

  explicit State(RecordSink& to) : sink(to) {}

  Participant& participant(ParticipantId p) { return *participants[static_cast<std::size_t>(p)]; }
  /// Null for one that was removed or never was.
  Endpoint* find(EndpointId id) const {
    const auto number = static_cast<std::uint64_t>(id);
    const std::uint64_t owner = number >> 32, index = number & 0xffffffffU;
    if (owner >= participants.size() || index >= participants[owner]->endpoints.size()) return nullptr;
    return participants[owner]->endpoints[index].get();
  }
  Endpoint* find(EndpointId id, EndpointKind kind) const {
    Endpoint* endpoint = find(id);
    assert(endpoint == nullptr || endpoint->kind == kind);
    return endpoint;
  }
  Channels& channels_of(NameKind kind) { return channels[static_cast<std::size_t>(kind)]; }

  /// "/clips_manager (environment main)".
  std::string described(ParticipantId p) {
    const Participant& owner = participant(p);
    return owner.name.full_name() + (owner.part.empty() ? "" : " (" + owner.part + ')');
  }
  std::string owner_of(const Endpoint& endpoint) { return described(endpoint.owner); }

  /// Whether it belongs to a node of the same full name, which is reported elsewhere.
  bool is_twin_of(const Endpoint& endpoint, const Participant& other) {
    const Participant& owner = participant(endpoint.owner);
    return &owner != &other && owner.kind == ParticipantKind::kNode && other.kind == ParticipantKind::kNode &&
           owner.name.full_name() == other.name.full_name();
  }

  /// The key of a service or action in `channels`: its name, with its type where several types share the name.
  std::string key_of(EndpointKind kind, const std::string& name, std::string_view type) const {
    const bool many = name_kind(kind) != NameKind::kTopic && (muted || many_typed.contains(name));
    return many ? name + ' ' + std::string(type) : name;
  }

  /// Begins the record of something that `endpoint` does: data {op, name}.
  RecordData& begin(std::string_view op, const Endpoint& endpoint) {
    return data.begin().field("op", op).field("name", std::string_view(endpoint.channel->name));
  }
  RecordRef write(SimTime now, const Endpoint& endpoint, Causes causes) {
    return sink.write(participant(endpoint.owner).stream, now, RecordKind::kBus, data, causes);
  }
  /// Begins a post: the next number of its sender, and its record up to there.
  Delivery begin_post(DeliveryKind kind, std::string_view op, const Endpoint& from) {
    begin(op, from);
    return number_post(kind, from);
  }
  Delivery begin_publish(const Endpoint& from) {
    data.begin(from.opening);
    return number_post(DeliveryKind::kTopic, from);
  }
  Delivery number_post(DeliveryKind kind, const Endpoint& from) {
    Delivery delivery;
    delivery.kind = kind;
    delivery.from = from.owner;
    delivery.sequence = ++participant(from.owner).posts;
    data.field("seq", delivery.sequence);
    return delivery;
  }
  void add_message(std::string_view key, const SharedMessage& message) {
    data.name(key);
    message->view().record(data);
  }

  /// Into the inbox of the endpoint's owner; `tick` is that of the post.
  void enqueue(Endpoint& to, Delivery&& delivery, std::uint64_t posted) {
    delivery.endpoint = to.id;
    Participant& receiver = participant(to.owner);
    const bool between_environments = receiver.kind == ParticipantKind::kEnvironment &&
                                      participant(delivery.from).kind == ParticipantKind::kEnvironment;
    (between_environments && posted == tick ? receiver.next_inbox : receiver.inbox).push_back(std::move(delivery));
  }
  /// To a client, if it is still there.
  void reply(EndpointId client, Delivery delivery) {
    if (muted) return;
    if (Endpoint* to = find(client)) enqueue(*to, std::move(delivery), tick);
  }
  /// To the channel's server, or into its waiting list.
  void send_to_server(Endpoint& client, Delivery delivery) {
    if (muted) return;
    Channel& channel = *client.channel;
    if (channel.providers.empty())
      channel.waiting.push_back({std::move(delivery), client.id, tick});
    else
      hand_to_server(*channel.providers.front(), {std::move(delivery), client.id, tick});
  }
  void hand_to_server(Endpoint& server, Waiting request) {
    Delivery& delivery = request.delivery;
    if (delivery.kind == DeliveryKind::kGoal) {
      server.served_goal(delivery.goal).client = request.client;
    } else {
      OpenRequest& open = server.requests[server.next_number];
      open.client = request.client;
      open.number = delivery.request_id;
      delivery.request_id = server.next_number++;
    }
    enqueue(server, std::move(delivery), request.tick);
  }

  // Taking (bus.cpp), and what it means for goals (actions.cpp).
  void handle(SimTime now, const Delivery& delivery);
  void call_handler(Endpoint& endpoint, const Delivery& delivery);
  void take_cancel(SimTime now, Endpoint& server, const Delivery& delivery);
  void answer_cancel_request(SimTime now, Endpoint& server, std::uint64_t request_id, std::int8_t code);
};

}  // namespace cxlab::bus
