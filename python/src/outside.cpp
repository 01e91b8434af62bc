#include "outside.h"

namespace cxlab::python {

namespace {

nb::object or_none(const std::optional<bool>& value) { return value ? nb::object(nb::bool_(*value)) : nb::none(); }

}  // namespace

Seat Outside::seat() {
  return {kName,
          [this](SeatBus& bus) -> Expected<std::unique_ptr<Agent>> {
            bus_ = &bus;
            return std::unique_ptr<Agent>(std::make_unique<QuietAgent>());
          },
          {}};
}

nb::list Outside::read(const std::string& topic, const std::string& type) {
  nb::list taken;
  const auto known = read_.find(topic);
  if (known == read_.end()) {
    Messages& messages = read_[topic];
    const Status reads = bus_->read(topic, type, [this, &messages](const bus::MessageView& message) {
      messages.emplace_back(bus_->now(), bus::Message(message));
    });
    if (!reads) read_.erase(topic);
    check(reads);
    return taken;
  }
  for (const auto& [t, message] : std::exchange(known->second, {}))
    taken.append(nb::make_tuple(to_seconds(t), to_python(message.view())));
  return taken;
}

std::size_t Outside::call(const std::string& service, const std::string& type, const std::string& yaml) {
  const std::size_t number = calls_.size();
  check(bus_->call(service, type, yaml,
                   [this, number](const bus::MessageView& response) { calls_[number].emplace(response); }));
  calls_.emplace_back();
  return number;
}

nb::object Outside::response(std::size_t call) const {
  if (finished_) return responses_.at(call);
  const auto& answer = calls_.at(call);
  return answer ? to_python(answer->view()) : nb::none();
}

std::size_t Outside::send_goal(const std::string& action, const std::string& type, const std::string& yaml) {
  const std::size_t number = goals_.size();
  GoalReaders readers;
  readers.answer = [this, number](bool accepted) { goals_[number].accepted = accepted; };
  readers.feedback = [this, number](const bus::MessageView& feedback) {
    goals_[number].feedback.emplace_back(feedback);
  };
  readers.result = [this, number](bool succeeded, const bus::MessageView& result) {
    goals_[number].succeeded = succeeded;
    if (result) goals_[number].result = bus::Message(result);
  };
  (void)value_or_raise(bus_->send_goal(action, type, yaml, std::move(readers)));
  goals_.emplace_back();
  return number;
}

nb::object Outside::goal(std::size_t number) const {
  if (finished_) return states_.at(number);
  return goals_.at(number).state();
}

nb::dict Outside::Goal::state() const {
  nb::list messages;
  for (const bus::Message& message : feedback) messages.append(to_python(message.view()));
  nb::dict all;
  all["accepted"] = or_none(accepted);
  all["feedback"] = messages;
  all["succeeded"] = or_none(succeeded);
  all["result"] = result ? to_python(result.view()) : nb::none();
  return all;
}

void Outside::finish() {
  for (std::size_t i = 0; i < calls_.size(); ++i) responses_.push_back(response(i));
  for (const Goal& one : goals_) states_.push_back(one.state());
  finished_ = true;
  read_.clear();
  for (auto& answer : calls_) answer.reset();
  for (Goal& one : goals_) one = {};
}

}  // namespace cxlab::python
