#include <deque>
#include <list>
#include <map>
#include <optional>
#include <set>

#include "cx/bag/part.h"

namespace cxlab::bag {

namespace {

using bus::GoalAnswer;
using bus::GoalStatus;

bool is_end(GoalStatus status) { return status >= GoalStatus::kSucceeded && status <= GoalStatus::kAborted; }

/// The k-th goal of this run meets what happened to the k-th goal of the recording, at the times of the recording, or
/// at once where they have passed.
class ActionPart final : public Part {
 public:
  ActionPart(Playing& playing, const std::string& name, const bus::ActionType& type, const ActionTopics& topics)
      : Part(playing, name),
        type_(type),
        send_goal_(topics.send_goal),
        get_result_(topics.get_result),
        cancel_goal_(topics.cancel_goal) {}

  const char* noun() const override { return "action"; }

  std::string why_left_out() override {
    std::string why;
    if (role_of(bus::NameKind::kAction, why) == Role::kClient && !send_goal_.has_requests)
      why = "the bag has no goals of it: service introspection of the action was off";
    return why;
  }

  Status open() override {
    auto made = playing_.bus.serve_action(
        playing_.self, name_, type_,
        {[this](const bus::Delivery& goal) { on_goal(goal); },
         [this](const bus::Delivery& cancel) { playing_.bus.answer_cancel(server_, cancel, true); }},
        bus::Bus::Rank::kStandIn);
    if (!made) return made.error();
    server_ = *made;
    return {};
  }

  Status take(const Topic& topic, std::string_view bytes) override {
    std::string why;
    const Role role = role_of(bus::NameKind::kAction, why);
    if (role == Role::kNone) {
      note_left_out(why);
      return {};
    }
    const auto is = [&](std::string_view end) { return topic.name.ends_with(end); };
    if (is(kSendGoalEvents)) return take_send_goal(bytes, role);
    if (is(kCancelGoalEvents)) return role == Role::kClient ? take_cancel(bytes) : Status();
    if (role == Role::kClient) return {};
    if (is(kStatusTopic)) return take_status(bytes);
    if (is(kFeedbackTopic)) return take_feedback(bytes);
    return take_get_result(bytes);
  }

  void open_ends(std::vector<std::string>& warnings) const override {
    const auto unanswered = static_cast<std::size_t>(
        std::ranges::count_if(goals_, [](const Recorded& g) { return g.live && !g.answered; }));
    if (const std::size_t goals = waiting_.size() + unanswered; goals > 0)
      warnings.push_back(name_ + ": " + std::to_string(goals) +
                         (goals == 1 ? " goal of this run has" : " goals of this run have") + " no answer in the bag");
    for (const std::string& text : late_warnings_) warnings.push_back(name_ + ": " + text);
  }

 private:
  /// A goal of the recording, and the goal of this run that meets the same.
  struct Recorded {
    std::string id;  ///< 16 bytes
    bus::SharedMessage goal = nullptr;
    bool accepted = false, rejected = false;
    std::vector<bus::SharedMessage> feedback = {};  ///< that has not been passed on
    std::optional<GoalStatus> ended = {};
    bus::SharedMessage result = nullptr;
    std::optional<bus::GoalId> live = {};
    bool answered = false;
  };
  /// A request of the recording that names a goal.
  struct Request {
    std::string client;
    std::int64_t number = 0;
    std::string id;  ///< of the goal
    bool answered = false;
  };

  // --- What the recording tells

  Recorded* find(const std::string& id) {
    const auto known = std::ranges::find(goals_, id, &Recorded::id);
    return known == goals_.end() ? nullptr : &*known;
  }
  /// The goal of that id, a new one if it is not known; nullptr if it is over or had begun before the bag.
  Recorded* goal_of(const std::string& id) {
    if (over_.contains(id)) return nullptr;
    if (Recorded* known = find(id)) return known;
    Recorded& added = goals_.emplace_back(Recorded{id});
    if (!waiting_.empty()) {
      bind(added, waiting_.front());
      waiting_.pop_front();
    }
    return &added;
  }

  using Requests = std::list<Request>;

  static Requests::iterator request_of(Requests& requests, const ServiceEvent& event, const EventKinds& kinds) {
    auto found = std::ranges::find_if(
        requests, [&](const Request& r) { return r.client == event.client && r.number == event.number; });
    if (found == requests.end() && kinds.of_two_sides()) found = std::ranges::find(requests, false, &Request::answered);
    return found;
  }

  Status take_send_goal(std::string_view bytes, Role role) {
    std::string id;
    bus::Message goal(*type_.goal);
    std::uint8_t accepted = 0;
    const auto event = read_service_event(
        bytes, [&](bus::CdrReader& in) { in.bytes(id, 16).message(goal.view()); },
        [&](bus::CdrReader& in) {
          in.number(accepted);
          read_stamp(in);
        });
    if (!event) return event.error();
    if (event->kind == send_goal_.request && event->has_request) {
      auto shared = std::make_shared<const bus::Message>(std::move(goal));
      if (role == Role::kClient) return send(id, std::move(shared));
      sent_.push_back({event->client, event->number, id});
      if (Recorded* recorded = goal_of(id)) {
        recorded->goal = std::move(shared);
        compare(*recorded);
      }
    } else if (event->kind == send_goal_.response && event->has_response && role == Role::kServer) {
      const auto request = request_of(sent_, *event, send_goal_);
      if (request == sent_.end()) return {};
      request->answered = true;
      Recorded* recorded = goal_of(request->id);
      if (!recorded) return {};
      (accepted ? recorded->accepted : recorded->rejected) = true;
      go_on(*recorded);
    }
    return {};
  }

  Status take_status(std::string_view bytes) {
    if (!status_type_) {
      const auto type = playing_.bus.registry().message("action_msgs/msg/GoalStatusArray");
      if (!type) return type.error();
      status_type_ = *type;
    }
    const auto message = bus::read_cdr(*status_type_, bytes);
    if (!message) return message.error();
    const bool first = std::exchange(first_status_, false);
    const bus::MessageView list = message->view();
    for (std::size_t i = 0; i < list.size("status_list"); ++i) {
      const bus::MessageView one = list.nested("status_list", i), info = one.nested("goal_info"),
                             stamp = info.nested("stamp");
      const auto status = static_cast<GoalStatus>(one.integer("status"));
      const std::string id = id_of(info.nested("goal_id"));
      const SimTime accepted = std::chrono::seconds(stamp.integer("sec")) + SimTime(stamp.integer("nanosec"));
      const bool before = first && accepted < playing_.first;
      if (!find(id) && (before || is_end(status))) over_.insert(id);
      if (status <= GoalStatus::kUnknown || status > GoalStatus::kAborted) continue;
      Recorded* recorded = goal_of(id);
      if (!recorded) continue;
      recorded->accepted = recorded->accepted || !recorded->rejected;
      if (is_end(status) && !get_result_.has_responses) recorded->ended = status;
      go_on(*recorded);
    }
    return {};
  }

  Status take_feedback(std::string_view bytes) {
    std::string id;
    bus::Message feedback(*type_.feedback);
    bus::CdrReader in(bytes);
    in.bytes(id, 16).message(feedback.view());
    if (!in.status()) return in.status();
    Recorded* recorded = goal_of(id);
    if (!recorded) return {};
    recorded->accepted = true;
    if (!recorded->live) recorded->feedback.clear();  // a late subscriber gets only the last one
    recorded->feedback.push_back(std::make_shared<const bus::Message>(std::move(feedback)));
    go_on(*recorded);
    return {};
  }

  Status take_get_result(std::string_view bytes) {
    std::string id;
    std::int8_t status = 0;
    bus::Message result(*type_.result);
    const auto event = read_service_event(
        bytes, [&](bus::CdrReader& in) { in.bytes(id, 16); },
        [&](bus::CdrReader& in) { in.number(status).message(result.view()); });
    if (!event) return event.error();
    if (event->kind == get_result_.request && event->has_request) {
      asked_.push_back({event->client, event->number, id});
    } else if (event->kind == get_result_.response && event->has_response) {
      // cxlab records no requests for results: the response has the number of the goal's.
      auto& requests = get_result_.has_requests ? asked_ : sent_;
      const auto request = request_of(requests, *event, get_result_);
      if (request == requests.end()) return {};
      Recorded* recorded = goal_of(request->id);
      requests.erase(request);
      const auto ended = static_cast<GoalStatus>(status);
      if (!recorded || !is_end(ended)) return {};
      recorded->accepted = true;
      recorded->ended = ended;
      recorded->result = std::make_shared<const bus::Message>(std::move(result));
      go_on(*recorded);
    }
    return {};
  }

  // --- Where agents are the clients

  void on_goal(const bus::Delivery& goal) {
    live_goals_[goal.goal] = goal.message;
    const auto open = std::ranges::find_if(goals_, [](const Recorded& g) { return !g.live; });
    if (open == goals_.end()) {
      waiting_.push_back(goal.goal);
      return;
    }
    bind(*open, goal.goal);
    go_on(*open);
  }

  void bind(Recorded& recorded, const bus::GoalId& live) {
    recorded.live = live;
    ++bound_;
    compare(recorded);
  }

  void compare(const Recorded& recorded) {
    if (differs_ || !recorded.live || !recorded.goal) return;
    const bus::SharedMessage& live = live_goals_[*recorded.live];
    if (recorded.goal->view().equals(live->view())) return;
    differs_ = true;
    playing_.warn(name_ + ": goal " + std::to_string(bound_) + " of this run is not that of the recording: found " +
                  live->view().to_string() + ", recorded " + recorded.goal->view().to_string() +
                  "; the bag answers it like the recorded one");
  }

  /// Passes on what has come so far.
  void go_on(Recorded& recorded) {
    if (!recorded.live || !(recorded.accepted || recorded.rejected)) return;
    const bus::GoalId live = *recorded.live;
    if (!recorded.answered) {
      recorded.answered = true;
      playing_.bus.answer_goal(server_, live, recorded.rejected ? GoalAnswer::kReject : GoalAnswer::kAccept);
    }
    for (const bus::SharedMessage& feedback : std::exchange(recorded.feedback, {}))
      playing_.bus.publish_feedback(server_, live, feedback);
    if (recorded.ended) finish(recorded, *recorded.ended);
    if (!recorded.ended && !recorded.rejected) return;
    live_goals_.erase(live);
    over_.insert(recorded.id);
    std::erase_if(goals_, [id = recorded.id](const Recorded& g) { return g.id == id; });
  }

  void finish(Recorded& recorded, GoalStatus status) {
    const bus::GoalId live = *recorded.live;
    if (status == GoalStatus::kCanceled && playing_.bus.server_goal_status(server_, live) != GoalStatus::kCanceling) {
      status = GoalStatus::kAborted;
      late_warnings_.insert("a goal that was canceled in the recording, and not in this run, is aborted");
    }
    if (!recorded.result) {
      recorded.result = std::make_shared<const bus::Message>(*type_.result);
      late_warnings_.insert(
          "the bag has no results of it, because service introspection of the action was off: those of this run have "
          "default values");
    }
    playing_.bus.finish(server_, live, status, recorded.result);
  }

  // --- Where an agent is the server

  Status send(const std::string& id, bus::SharedMessage goal) {
    if (!client_) {
      auto made = playing_.bus.create_action_client(playing_.self, name_, type_, {});
      if (!made) return made.error();
      client_ = *made;
    }
    sent_goals_[id] = playing_.bus.send_goal(*client_, std::move(goal));
    return {};
  }

  Status take_cancel(std::string_view bytes) {
    if (!client_) return {};
    std::string id;
    const auto event = read_service_event(
        bytes,
        [&](bus::CdrReader& in) {
          in.bytes(id, 16);
          read_stamp(in);
        },
        [](bus::CdrReader&) {});
    if (!event) return event.error();
    if (event->kind != cancel_goal_.request || !event->has_request) return {};
    if (id == std::string(16, '\0'))
      playing_.bus.cancel_all_goals(*client_);
    else if (const auto sent = sent_goals_.find(id); sent != sent_goals_.end())
      playing_.bus.cancel_goal(*client_, sent->second);
    return {};
  }

  static void read_stamp(bus::CdrReader& in) {
    std::int32_t seconds = 0;
    std::uint32_t nanoseconds = 0;
    in.number(seconds).number(nanoseconds);
  }
  static std::string id_of(const bus::MessageView& uuid) {
    const bus::Field& bytes = *uuid.type().find("uuid");
    std::string id;
    for (std::size_t i = 0; i < uuid.size(bytes); ++i) id += static_cast<char>(uuid.integer(bytes, i));
    return id;
  }

  const bus::ActionType& type_;
  EventKinds send_goal_, get_result_, cancel_goal_;
  const bus::MessageType* status_type_ = nullptr;
  bus::EndpointId server_{};
  std::optional<bus::EndpointId> client_;
  std::deque<Recorded> goals_;       ///< in order of their first message, without those that are over
  std::set<std::string> over_;       ///< ids of those, and of goals from before the bag
  Requests sent_, asked_;            ///< goals, and requests for their results
  std::deque<bus::GoalId> waiting_;  ///< that came before their counterpart in the recording
  std::map<bus::GoalId, bus::SharedMessage> live_goals_;
  std::map<std::string, bus::GoalId> sent_goals_;
  std::set<std::string> late_warnings_;
  std::size_t bound_ = 0;
  bool first_status_ = true, differs_ = false;
};

}  // namespace

std::unique_ptr<Part> make_action_part(Playing& playing, const std::string& name, const bus::ActionType& type,
                                       const ActionTopics& topics) {
  return std::make_unique<ActionPart>(playing, name, type, topics);
}

}  // namespace cxlab::bag
