#pragma once
// The bus: topics, services and actions between the participants of one episode. Nothing is delivered at once: a post
// waits in the receiver's inbox until the receiver takes it, in the order of docs/reference/contracts.md 1.
// Single-threaded.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/time.h"
#include "cx/bus/message.h"

namespace cxlab::bus {

enum class ParticipantId : std::uint32_t {};  ///< 0, 1, ... in order of joining: the sender's index
enum class EndpointId : std::uint64_t {
};  ///< a publisher, subscription, client, ...: owner << 32 | number; never used again

/// Environments receive what other environments send one tick later; nodes (servers, world) receive at their next take.
enum class ParticipantKind : std::uint8_t { kNode, kEnvironment };

/// In the order in which a participant takes them (docs/reference/contracts.md 1). Answers to goals and cancels are
/// service responses, as in ROS.
enum class DeliveryKind : std::uint8_t {
  kServiceResponse,
  kGoalResponse,
  kCancelResponse,
  kServiceRequest,
  kGoal,
  kCancel,
  kFeedback,
  kResult,
  kTopic
};

using GoalId = std::array<std::uint8_t, 16>;
/// 32 lower-case hex digits, no dashes.
std::string to_string(const GoalId& id);

/// action_msgs/msg/GoalStatus and the client's view of it.
enum class GoalStatus : std::int8_t {
  kUnknown = 0,
  kAccepted = 1,
  kExecuting = 2,
  kCanceling = 3,
  kSucceeded = 4,
  kCanceled = 5,
  kAborted = 6
};
/// How long a server remembers a goal after its end.
inline constexpr SimTime kEndedGoalKept = std::chrono::minutes(15);
enum class GoalAnswer : std::uint8_t { kReject = 1, kAccept = 2, kDefer = 3 };

/// One thing that a participant takes. `from` orders; records name participants, never count them.
struct Delivery {
  DeliveryKind kind{};
  ParticipantId from{};
  std::uint64_t sequence = 0;  ///< of the sender
  EndpointId endpoint{};       ///< the receiver's
  SharedMessage message;       ///< topic message, request, response, goal, feedback or result; null where there is none
  std::uint64_t request_id =
      0;          ///< responses: the client's number of the call, from 1; requests and cancels: the server's, from 1
  GoalId goal{};  ///< cancels and their responses: all zero where many goals were meant
  bool accepted = false;        ///< goal responses
  GoalStatus status{};          ///< goal responses, feedback, results: the server's at the post
  std::int8_t return_code = 0;  ///< cancel responses: 0 none, 1 rejected, 2 unknown goal, 3 terminated
  SimTime stamp{};  ///< goal responses: when the goal was accepted; cancels of many: accepted not after this
  std::vector<std::pair<GoalId, SimTime>> goals_canceling;  ///< cancel responses
  RecordRef cause;                                          ///< the record of the post
};

/// Records that led to a post; the post's own record names them. Answers name what they answer without it.
using Causes = std::span<const RecordRef>;

using Handler = std::function<void(const Delivery&)>;

enum class NameKind : std::uint8_t { kTopic, kService, kAction };

/// How names of one participant map to the bus: relative names get the namespace, "~" the node name, `{node}`, `{ns}`
/// and
/// `{namespace}` what they say; then the first remap whose FROM, expanded in the same way, is that name replaces it.
/// A FROM may begin with "NODE:" (holds for nodes of that name only) and with "rostopic://" or "rosservice://" (for
/// topics or services only), as in ROS.
struct NodeName {
  std::string name;                                         ///< e.g. "clips_manager"
  std::string name_space = "/";                             ///< absolute
  std::vector<std::pair<std::string, std::string>> remaps;  ///< FROM := TO, both as written by the user
  /// The absolute name on the bus. Absolute names are only moved by remaps.
  std::string resolve(std::string_view name_as_written, NameKind kind = NameKind::kTopic) const;
  /// The same without remaps.
  std::string expand(std::string_view name_as_written) const;
  /// E.g. "/ns/clips_manager".
  std::string full_name() const;
};
/// Carries out the remaps `__node:=NAME`, `__name:=NAME` and `__ns:=/NAMESPACE` (also behind "NODE:") and takes them
/// out.
void rename_node(NodeName& node);

/// Takes part in the input log: what entered each environment, and the answers of functions that look outside.
class InputTap {
 public:
  virtual ~InputTap() = default;
  virtual void delivered(ParticipantId to, const std::vector<Delivery>& deliveries) = 0;
};

/// Where what participants take comes from: the bus, or in a replay the log of a recorded run.
class Feed {
 public:
  virtual ~Feed() = default;
  /// Calls the handlers of `to` with all that it takes now.
  virtual Status feed(ParticipantId to) = 0;
  /// The next time at which it has something for anybody; kNever: it waits for nothing but posts.
  virtual SimTime next_due() const = 0;
};

struct Endpoint;

class Bus : private Feed {
 public:
  Bus(Registry& registry, RecordSink& sink);
  ~Bus();

  Registry& registry() { return registry_; }

  // --- Participants
  /// `part`: what of the node it is, for people ("environment main"); empty = the node itself.
  ParticipantId join(ParticipantKind kind, NodeName name, StreamId stream, std::string part = {});
  const NodeName& name_of(ParticipantId p) const;
  /// False once it has left.
  bool is_there(ParticipantId p) const;
  /// Whether it is an environment, where rules act; else a node.
  bool is_environment(ParticipantId p) const;
  /// The node of that full name that is there; none after it left.
  std::optional<ParticipantId> find_node(std::string_view full_name) const;
  /// Full names of all nodes that are there, sorted.
  std::vector<std::string> nodes() const;
  StreamId stream_of(ParticipantId p) const;
  /// Removes the participant's endpoints; what it had posted is still delivered.
  void leave(ParticipantId p);

  // --- Time: set by the episode at the start of each tick, before anybody posts.
  void begin_tick(SimTime now);
  SimTime now() const { return now_; }

  // --- Endpoints. Names are as written by the participant. They are registered at once. Types must agree on the bus:
  // a second type for the same name is an error. Queues have no limit: the bus keeps every message until its receiver
  // takes it. Where several servers have one name, the first that still exists answers, and `on_rivals` is called.
  // Posts through a removed endpoint do nothing; a message of another type than the endpoint's is a bug of the caller
  // (asserts).
  Expected<EndpointId> advertise(ParticipantId p, std::string_view topic, const MessageType& type);
  Expected<EndpointId> subscribe(ParticipantId p, std::string_view topic, const MessageType& type, Handler handler);
  /// A stand-in answers only while no other server has the name, which takes over without being its rival.
  enum class Rank : std::uint8_t { kServer, kStandIn };
  Expected<EndpointId> serve(ParticipantId p, std::string_view service, const ServiceType& type, Handler on_request,
                             Rank rank = Rank::kServer);
  Expected<EndpointId> create_client(ParticipantId p, std::string_view service, const ServiceType& type,
                                     Handler on_response);
  struct ActionServerHandlers {
    Handler goal, cancel;
  };
  Expected<EndpointId> serve_action(ParticipantId p, std::string_view action, const ActionType& type,
                                    ActionServerHandlers handlers, Rank rank = Rank::kServer);
  struct ActionClientHandlers {
    Handler goal_response, feedback, result, cancel_response;
  };
  Expected<EndpointId> create_action_client(ParticipantId p, std::string_view action, const ActionType& type,
                                            ActionClientHandlers handlers);
  /// Services and actions of several types live side by side under this name from now on: servers and clients of one
  /// type do not see those of another. For servers that speak several packages of interfaces.
  void allow_types(ParticipantId p, std::string_view name);
  /// `report` is called with one sentence when a second server takes a name of a service or action. It names both
  /// servers. It is not called for two nodes with the same full name.
  void on_rivals(std::function<void(const std::string& text)> report);
  /// Removes an endpoint. Messages on their way to it are dropped; open requests and goals of a removed server stay
  /// unanswered.
  void remove(EndpointId endpoint);
  /// The endpoint's number within its participant, in order of making from 0 (removed ones count), and back: the same
  /// when the participant's program runs again. For the input log.
  std::uint32_t number_of(EndpointId endpoint) const;
  std::optional<EndpointId> endpoint_of(ParticipantId p, std::uint32_t number) const;

  // --- Topics
  void publish(EndpointId publisher, SharedMessage message, Causes causes = {});
  /// To some subscriptions of the topic only; those that are not there any more are left out.
  void publish_to(EndpointId publisher, std::span<const EndpointId> subscriptions, SharedMessage message,
                  Causes causes = {});

  // --- Services
  /// Whether a server is registered now under the client's name.
  bool service_ready(EndpointId client) const;
  /// The request's number, from 1 a client; waits in the bus until a server is there.
  std::uint64_t call(EndpointId client, SharedMessage request, Causes causes = {});
  /// The next request of the participant's clients of that service gets this number. False if it has no client of it.
  bool number_requests_from(ParticipantId p, std::string_view service_as_written, std::uint64_t number);
  /// Answers `request` that was delivered to this service, now or later. A second answer is ignored: false.
  bool respond(EndpointId service, const Delivery& request, SharedMessage response);

  // --- Actions, client side
  bool action_ready(EndpointId client) const;
  /// The new goal's id (counted per client, no chance in it); the goal waits until a server is there.
  GoalId send_goal(EndpointId client, SharedMessage goal, Causes causes = {});
  void cancel_goal(EndpointId client, const GoalId& goal, Causes causes = {});
  /// As in ROS, those of other clients too.
  void cancel_all_goals(EndpointId client, Causes causes = {});
  /// Cancels the goals that were accepted at `stamp` or before.
  void cancel_goals_before(EndpointId client, SimTime stamp, Causes causes = {});
  /// Status as far as the client has taken deliveries.
  GoalStatus goal_status(EndpointId client, const GoalId& goal) const;
  /// The client will not ask for its status again. Feedback and result are still delivered.
  void forget_goal(EndpointId client, const GoalId& goal);

  // --- Actions, server side. A call that the goal's state does not allow is ignored and returns false: a goal is
  // answered once; accepted -> executing -> (canceling ->) succeeded, aborted; canceled only from canceling.
  bool answer_goal(EndpointId server, const GoalId& goal, GoalAnswer answer);
  /// The cancel handler is called once for each goal that could be canceled; the client gets one answer for all of them
  /// when the last is answered. A server without a cancel handler rejects.
  bool answer_cancel(EndpointId server, const Delivery& cancel, bool accept);
  bool execute(EndpointId server, const GoalId& goal);  ///< of a deferred goal
  bool publish_feedback(EndpointId server, const GoalId& goal, SharedMessage feedback);
  /// Ends the goal: kSucceeded, kAborted or kCanceled. Its status is kept for `kEndedGoalKept`, as ROS 2 keeps results.
  bool finish(EndpointId server, const GoalId& goal, GoalStatus status, SharedMessage result);
  GoalStatus server_goal_status(EndpointId server, const GoalId& goal) const;

  // --- Taking
  bool has_waiting(ParticipantId p) const;  ///< something that `take` would give now
  bool any_waiting() const;                 ///< for any participant now or, between environments, next tick
  /// Takes all that `p` may take now, in order, and calls each endpoint's handler. Returns how many. Handlers may post
  /// and make or remove endpoints: what they post is for a later call, what waits for a removed endpoint is dropped.
  std::size_t deliver(ParticipantId p);
  /// The bus as a feed, for participants that a log may also feed.
  Feed& as_feed() { return *this; }
  /// Sees what each `deliver` takes, before the handlers; not called where there is nothing.
  void set_input_tap(InputTap* tap);

  // --- Replay: routing is off; posts are recorded as ever but reach nobody; `inject` hands logged deliveries to the
  // handlers, in the order given. Their endpoints are found by number, whatever the index of `to` was in the logged
  // run.
  void mute(bool on);
  void inject(ParticipantId to, const std::vector<Delivery>& deliveries);

  // --- Introspection
  /// Owners of the publishers or servers of that absolute name, in the order in which they answer; once for each.
  std::vector<ParticipantId> providers(NameKind kind, std::string_view name) const;
  /// The same for subscriptions or clients.
  std::vector<ParticipantId> users(NameKind kind, std::string_view name) const;
  /// "/clips_manager (environment main)".
  std::string described(ParticipantId p) const;

  // Sorted by name
  struct Info {
    std::string name, type;
    int providers = 0, users = 0;
  };
  std::vector<Info> topics() const;
  std::vector<Info> services() const;
  std::vector<Info> actions() const;

 private:
  Status feed(ParticipantId to) override {
    deliver(to);
    return {};
  }
  SimTime next_due() const override { return kNever; }
  struct State;
  Expected<EndpointId> add(ParticipantId p, std::string_view written, std::unique_ptr<Endpoint> made,
                           std::string_view type_name, Rank rank = Rank::kServer);
  std::vector<ParticipantId> owners(NameKind kind, std::string_view name, bool providing) const;
  void cancel(EndpointId client, const GoalId& goal, SimTime stamp, Causes causes);

  Registry& registry_;
  SimTime now_{};
  std::unique_ptr<State> state_;
};

}  // namespace cxlab::bus
