#include "lab/moment_exchanges.h"

#include <algorithm>

#include "cx/engine/value.h"
#include "cx/journal/input_log.h"
#include "cx/journal/journal_reader.h"

namespace cxlab::lab {

namespace {

constexpr std::size_t kIdSize = 32;  // of a goal, in hex digits

std::string whole_name(const std::string& name) { return name.starts_with('/') ? name : '/' + name; }

/// The name in the first part of a remap, which may begin with a node and a kind: agent:rosservice://NAME.
std::string written_in(const std::string& from) {
  const std::string written = from.substr(from.rfind(':') + 1);
  return written.starts_with("//") ? written.substr(2) : written;
}

}  // namespace

std::string name_in_rules(const JournalRecord& record, const bus::NodeName& node) {
  const std::string name(record.data.text("name")), below = node.expand("");
  if (record.kind != RecordKind::kBus) return whole_name(name);
  const std::string_view op = record.data.text("op");
  const bus::NameKind kind = op == "goal"   ? bus::NameKind::kAction
                             : op == "call" ? bus::NameKind::kService
                                            : bus::NameKind::kTopic;
  std::string own = name;  // before remaps
  for (const auto& [from, to] : node.remaps)
    if (const std::string written = written_in(from); node.resolve(written, kind) == name) {
      if (written.starts_with('~')) return whole_name(written);
      own = node.expand(written);
      break;
    }
  const bool is_relative = own.starts_with(below) && node.resolve(own.substr(below.size()), kind) == name;
  return is_relative ? own.substr(below.size() - 1) : own;
}

std::string message_of(const JournalRecord& record, const char* key) {
  const RecordValue* value = record.data.find(key);
  return value == nullptr ? "" : to_json(*value);
}

Expected<MomentExchanges> MomentExchanges::read(const std::filesystem::path& inputs, std::string_view stream,
                                                const bus::NodeName& node, SimTime moment) {
  auto log = InputLogReader::open(inputs);
  if (!log) return log.error();
  MomentExchanges out;
  out.node_ = node;
  out.moment_ = moment;
  while (const auto input = log->next()) {
    const auto* take = std::get_if<LoggedTake>(&*input);
    if (take == nullptr || take->to != stream) continue;
    for (const LoggedDelivery& logged : take->deliveries) {
      const bus::Delivery& delivery = logged.delivery;
      const bool is_response = delivery.kind == bus::DeliveryKind::kServiceResponse;
      if (is_response || delivery.kind == bus::DeliveryKind::kGoalResponse ||
          delivery.kind == bus::DeliveryKind::kFeedback || delivery.kind == bus::DeliveryKind::kResult)
        out.logged_[{std::string(logged.cause_stream), delivery.cause.n}] = {
            is_response ? std::to_string(delivery.request_id) : bus::to_string(delivery.goal), delivery.accepted,
            delivery.status};
    }
  }
  return out;
}

bool MomentExchanges::hear(const JournalRecord& record) {
  switch (record.kind) {
    case RecordKind::kBus: sent(record); return false;
    case RecordKind::kAssert:
    case RecordKind::kDecision: accepted(record); return false;
    case RecordKind::kInput: looked(record); return answered(record);
    default: return false;
  }
}

void MomentExchanges::sent(const JournalRecord& record) {
  const std::string_view op = record.data.text("op");
  const std::string name = name_in_rules(record, node_);
  if (op == "goal") actions_[name].push_back({std::string(record.data.text("goal_id")), record.t});
  if (op != "call") return;
  const std::int64_t id = record.data.integer("id");
  services_[name].push_back({std::to_string(id), record.t});
  if (record.t <= moment_) next_[name] = id + 1;
}

/// Answers may come in another order than what they answer.
bool MomentExchanges::answered(const JournalRecord& record) {
  const std::string_view what = record.data.text("what");
  const bool is_response = what == "response", is_result = what == "result", is_feedback = what == "feedback";
  if (!is_response && !is_result && !is_feedback && what != "goal-response") return false;
  accepted_ = nullptr;
  if (record.causes.empty()) return true;
  const auto logged = logged_.find({record.causes.front().stream, record.causes.front().n});
  if (logged == logged_.end()) return true;
  List& met = (is_response ? services_ : actions_)[name_in_rules(record, node_)];
  const auto is_open = [&](const Exchange& one) { return one.id == logged->second.id && !one.ended; };
  const auto found = std::ranges::find_if(met, is_open);
  if (found == met.end()) return true;
  if (is_feedback) {
    if (record.t > moment_) found->feedback.emplace_back(record.t, message_of(record, "message"));
    return true;
  }
  const bool ends = is_response || is_result || !logged->second.accepted;
  if (!ends) {
    accepted_ = &*found;
  } else if (record.t <= moment_) {
    met.erase(found);
  } else if (!is_response && !is_result) {
    found->outcome = "reject";
  } else if (logged->second.status != bus::GoalStatus::kCanceled) {  // a stand-in cancels by itself
    found->ended = record.t;
    found->outcome = logged->second.status == bus::GoalStatus::kAborted ? "fail" : "succeed";
    found->result = message_of(record, "message");
  }
  return true;
}

/// A plugin says in a fact of its own, with the handle of the client, that a goal was accepted.
void MomentExchanges::accepted(const JournalRecord& record) {
  const RecordValue* slots = record.data.find("slots");
  if (accepted_ == nullptr || slots == nullptr || !record.data.text("template").ends_with("goal-response")) return;
  const RecordValue* handle = slots->find("client-goal-handle-ptr");
  if (record.t <= moment_)
    accepted_->handle = Value::handle(static_cast<Handle>(handle ? handle->integer("handle") : 0)).print();
  accepted_ = nullptr;
}

/// "action-ready /robot1/pick": rules asked whether it is served.
void MomentExchanges::looked(const JournalRecord& record) {
  const std::string text(record.data.text("name"));
  const bool is_of_action = text.starts_with("action-ready ");
  if (record.data.text("what") != "look" || (!is_of_action && !text.starts_with("service-ready "))) return;
  const std::string name = whole_name(text.substr(text.find(' ') + 1));
  if (record.data.text("value") == "TRUE")
    (is_of_action ? actions_ : services_)[name];
  else if (record.t > moment_)
    without_server_.try_emplace(name, record.t);
}

bool MomentExchanges::any_under_way(const List& list) const {
  return std::ranges::any_of(list, [this](const Exchange& one) { return is_under_way(one); });
}

std::int64_t MomentExchanges::next_request(const std::string& service) const {
  const auto found = next_.find(service);
  return found == next_.end() ? 1 : found->second;
}

std::string MomentExchanges::without_ids(std::string fact) const {
  for (const auto& [post, logged] : logged_) {
    if (logged.id.size() != kIdSize) continue;
    for (const std::string& word : {'"' + logged.id + '"', logged.id})
      for (std::size_t at; (at = fact.find(word)) != std::string::npos;) fact.replace(at, word.size(), "?");
  }
  return fact;
}

}  // namespace cxlab::lab
