#include "lab/export/bus_channels.h"

#include "cx/base/number_text.h"
#include "cx/journal/file_store.h"
#include "lab/export/recorded_message.h"

namespace cxlab::lab {

namespace {

// Of action_msgs/msg/GoalStatus.
constexpr std::int64_t kExecuting = 2, kCanceling = 3;

/// The bytes that hex digits name; `size` of them, zeros where digits are missing.
std::string bytes_of_hex(std::string_view hex, std::size_t size) {
  std::string out(size, '\0');
  for (std::size_t i = 0; i < size && 2 * i + 1 < hex.size(); ++i) {
    int byte = 0;
    std::from_chars(hex.data() + 2 * i, hex.data() + 2 * i + 2, byte, 16);
    out[i] = static_cast<char>(byte);
  }
  return out;
}
std::string uuid_of(std::string_view goal_id) { return bytes_of_hex(goal_id, 16); }

/// Sets a field of the type unique_identifier_msgs/UUID.
void set_uuid(const bus::MessageView& uuid, std::string_view goal_id) {
  const std::string id = uuid_of(goal_id);
  const bus::Field& bytes = *uuid.type().find("uuid");
  for (std::size_t i = 0; i < id.size(); ++i)
    static_cast<void>(uuid.set_integer(bytes, static_cast<unsigned char>(id[i]), i));
}

}  // namespace

Expected<bus::Message> BusChannels::message_of(const bus::MessageType& type, const RecordValue& data,
                                               std::string_view key) const {
  bus::Message message(type);
  const RecordValue* recorded = data.find(key);
  if (!recorded) return input_error("the record has no '" + std::string(key) + "'");
  if (Status s = set_message(message.view(), *recorded); !s) return s.error();
  return message;
}

Status BusChannels::hear(const JournalRecord& record) {
  const std::string op(record.data.text("op")), name(record.data.text("name"));
  Status status = take(record, op, name);
  if (status) return {};
  Error error = status.error();
  error.message =
      "record " + record.stream + ':' + std::to_string(record.n) + " (" + op + ' ' + name + "): " + error.message;
  return error;
}

Expected<bus::Message> BusChannels::published(const std::vector<std::string>& types, const RecordValue& data) {
  Error error = input_error("the journal does not tell the type of the topic");
  for (const std::string& name : types) {
    const auto type = types_.message(name);
    auto message = type ? message_of(**type, data, "msg") : Expected<bus::Message>(type.error());
    if (message) return message;
    error = message.error();
  }
  return error;
}

Status BusChannels::take(const JournalRecord& record, const std::string& op, const std::string& name) {
  const RecordValue& data = record.data;
  const std::pair declared(record.stream, name);
  if (op == "advertise") topics_[declared].emplace_back(data.text("type"));
  if (op == "client") services_[declared].assign(1, std::string(data.text("type")));
  if (op == "action_client") actions_[declared].assign(1, std::string(data.text("type")));
  if (op == "publish" && stretch_.has(record.t)) {
    const auto message = published(topics_[declared], data);
    if (!message) return message.error();
    bag_.put(name, record.t, *message);
  } else if ((op == "call" || op == "respond") && stretch_.has(record.t)) {
    // A server may offer the service in several types: that of the client counts.
    const bool call = op == "call";
    const std::string& client = call || record.causes.empty() ? record.stream : record.causes.front().stream;
    const auto& types = services_[{client, name}];
    if (types.empty()) return input_error("the journal does not tell the type that " + client + " uses");
    const auto type = types_.service(types.front());
    if (!type) return type.error();
    const auto message = message_of(call ? *(*type)->request : *(*type)->response, data, call ? "request" : "response");
    if (!message) return message.error();
    put_service(name, **type, record.t, call ? EventType::kRequestSent : EventType::kResponseSent,
                {client, data.integer("id")}, *message);
  } else if (data.find("goal_id") || op == "cancel_response") {
    return take_action(record, op, name);
  }
  return {};
}

void BusChannels::put_event(const std::string& service, const std::string& type, SimTime t, EventType event,
                            const Caller& caller, Part request, Part response) {
  const bus::MessageType& info = bag_.own("service_msgs/msg/ServiceEventInfo");
  bag_.put(service + "/_service_event", t,
           {type + "_Event",
            [&] {
              std::vector<const bus::MessageType*> uses{&info};
              for (const Part* part : {&request, &response})
                uses.insert(uses.end(), part->uses.begin(), part->uses.end());
              std::string text = "service_msgs/ServiceEventInfo info\n" + request.name + "[<=1] request\n" +
                                 response.name + "[<=1] response\n";
              std::string parts;
              for (const Part* part : {&request, &response})
                if (!part->text.empty()) parts += std::string(80, '=') + "\nMSG: " + part->name + '\n' + part->text;
              return bus::ros2msg_schema(text + parts, uses);
            },
            [&](bus::CdrWriter& out) {
              out.number(static_cast<std::uint8_t>(event));
              write_stamp(out, t);
              out.bytes(bytes_of_hex(content_hash(caller.stream), 16)).number(caller.number);
              for (const Part* part : {&request, &response}) {
                out.size(part->write ? 1 : 0);
                if (part->write) part->write(out);
              }
            }});
}

void BusChannels::put_service(const std::string& service, const bus::ServiceType& type, SimTime t, EventType event,
                              const Caller& caller, const bus::Message& message) {
  const auto write = [&](bus::CdrWriter& out) { out.message(message); };
  Part request{bus::ros2msg_name(type.request->name()), "", {type.request}, {}};
  Part response{bus::ros2msg_name(type.response->name()), "", {type.response}, {}};
  (event == EventType::kRequestSent ? request : response).write = write;
  put_event(service, type.name, t, event, caller, std::move(request), std::move(response));
}

Status BusChannels::take_action(const JournalRecord& record, const std::string& op, const std::string& name) {
  const RecordValue& data = record.data;
  const bus::MessageType& uuid = bag_.own("unique_identifier_msgs/msg/UUID");
  const bus::MessageType& time = bag_.own("builtin_interfaces/msg/Time");
  const std::string goal_id(data.text("goal_id")), id = uuid_of(goal_id);
  const SimTime t = record.t;
  auto& goals = goals_[name];
  const Caller caller{record.stream, data.integer("seq")};
  if (op == "cancel" || op == "cancel_response") return take_cancel(record, op, name);
  if (op == "goal") {
    const auto& types = actions_[{record.stream, name}];
    goals[goal_id] = {caller, types.empty() ? "" : types.front()};
  }
  const auto goal = goals.find(goal_id);
  if (goal == goals.end()) return input_error("the journal does not tell who sent the goal");
  const auto found = types_.action(goal->second.type);
  if (!found) return found.error();
  const bus::ActionType& type = **found;

  const auto event = [&](const std::string& part, const std::string& request_text, const std::string& response_text,
                         const bus::MessageType& payload, EventType kind, std::function<void(bus::CdrWriter&)> write) {
    const std::string base = type.name + '_' + (part == "send_goal" ? "SendGoal" : "GetResult");
    Part request{bus::ros2msg_name(base + "_Request"), request_text, {&uuid, &time, &payload}, {}};
    Part response{bus::ros2msg_name(base + "_Response"), response_text, {}, {}};
    (kind == EventType::kRequestSent ? request : response).write = std::move(write);
    if (stretch_.has(t))
      put_event(name + "/_action/" + part, base, t, kind, goal->second.caller, std::move(request), std::move(response));
  };
  const std::string id_text = "unique_identifier_msgs/UUID goal_id\n";
  const auto send_goal = [&](EventType kind, std::function<void(bus::CdrWriter&)> write) {
    event("send_goal", id_text + bus::ros2msg_name(type.goal->name()) + " goal\n",
          "bool accepted\nbuiltin_interfaces/Time stamp\n", *type.goal, kind, std::move(write));
  };

  if (op == "goal") {
    const auto message = message_of(*type.goal, data, "goal");
    if (!message) return message.error();
    send_goal(EventType::kRequestSent, [&](bus::CdrWriter& out) { out.bytes(id).message(*message); });
  } else if (op == "accept" || op == "reject") {
    send_goal(EventType::kResponseSent, [&](bus::CdrWriter& out) {
      out.number(static_cast<std::uint8_t>(op == "accept" ? 1 : 0));
      write_stamp(out, t);
    });
    if (op == "reject") {
      goals.erase(goal);
    } else {
      goal->second.accepted = t;
      goal->second.status = kExecuting;
      put_status(name, t);
    }
  } else if (op == "feedback") {
    const auto feedback = message_of(*type.feedback, data, "feedback");
    if (!feedback) return feedback.error();
    if (stretch_.has(t))
      bag_.put(name + "/_action/feedback", t,
               {type.name + "_FeedbackMessage",
                [&] {
                  const bus::MessageType* const uses[]{&uuid, type.feedback};
                  return bus::ros2msg_schema(id_text + bus::ros2msg_name(type.feedback->name()) + " feedback\n", uses);
                },
                [&](bus::CdrWriter& out) { out.bytes(id).message(*feedback); }});
  } else if (op == "result") {
    const auto result = message_of(*type.result, data, "result");
    if (!result) return result.error();
    goal->second.status = static_cast<std::int8_t>(data.integer("status"));
    event("get_result", id_text, "int8 status\n" + bus::ros2msg_name(type.result->name()) + " result\n", *type.result,
          EventType::kResponseSent,
          [&](bus::CdrWriter& out) { out.number(static_cast<std::int8_t>(goal->second.status)).message(*result); });
    put_status(name, t);
    goals.erase(goal);
  }
  return {};
}

Status BusChannels::take_cancel(const JournalRecord& record, const std::string& op, const std::string& name) {
  const RecordValue& data = record.data;
  const bool request = op == "cancel";
  const auto cancel = types_.service("action_msgs/srv/CancelGoal");
  if (!cancel) return cancel.error();
  bus::Message message(request ? *(*cancel)->request : *(*cancel)->response);
  const auto set_id = [&](const bus::MessageView& info, std::string_view goal_id) {
    set_uuid(info.nested("goal_id"), goal_id);
  };
  if (request) {
    set_id(message->nested("goal_info"), data.text("goal_id"));
    auto& goals = goals_[name];
    if (const auto known = goals.find(std::string(data.text("goal_id"))); known != goals.end())
      known->second.status = kCanceling;
  } else {
    message->set("return_code", std::int64_t{static_cast<std::int8_t>(data.integer("code"))});
    if (const RecordValue* ids = data.find("canceling"))
      if (const auto* list = std::get_if<RecordValue::List>(&ids->value))
        for (const RecordValue& one : *list)
          if (const auto* text = std::get_if<std::string>(&one.value))
            set_id(message->append("goals_canceling"), *text);
  }
  const std::string& client = request || record.causes.empty() ? record.stream : record.causes.front().stream;
  if (stretch_.has(record.t))
    put_service(name + "/_action/cancel_goal", **cancel, record.t,
                request ? EventType::kRequestSent : EventType::kResponseSent, {client, data.integer("seq")}, message);
  return {};
}

void BusChannels::put_status(const std::string& action, SimTime t) {
  if (!stretch_.has(t)) return;
  bus::Message message = bag_.make("action_msgs/msg/GoalStatusArray");
  for (const auto& [goal_id, goal] : goals_[action]) {
    if (goal.status == 0) continue;
    const bus::MessageView one = message->append("status_list");
    one.set("status", goal.status);
    const bus::MessageView info = one.nested("goal_info");
    set_stamp(info.nested("stamp"), goal.accepted);
    set_uuid(info.nested("goal_id"), goal_id);
  }
  bag_.put(action + "/_action/status", t, message);
}

}  // namespace cxlab::lab
