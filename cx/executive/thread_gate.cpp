#include "cx/executive/thread_gate.h"

#include "cx/bus/needed.h"
#include "cx/executive/environment.h"

namespace cxlab::cx {

namespace {

Error gone(const std::string& owner) {
  return run_error("plugin '" + owner + "' is not loaded in the environment any more");
}

}  // namespace

ThreadGate::ThreadGate(Environment& environment, std::string owner, std::string topic)
    : environment_(environment), owner_(std::move(owner)), topic_(std::move(topic)) {}

ThreadGate::~ThreadGate() { close(); }

Status ThreadGate::open() {
  bus::Bus& bus = environment_.bus();
  auto type = bus::needed_message(bus.registry(), "cxlab_msgs/msg/ThreadRequest");
  if (!type) return type.error();
  type_ = *type;
  auto in = bus.subscribe(environment_.participant(), topic_, *type_, [this](const bus::Delivery& d) { carry_out(d); });
  if (!in) return in.error();
  in_ = *in;
  bus::NodeName name = bus.name_of(environment_.participant());
  node_ = environment_.join_threads(name, owner_);
  auto out = bus.advertise(node_, topic_, *type_);
  if (!out) return out.error();
  out_ = *out;
  const std::lock_guard lock(mutex_);
  open_ = true;
  return {};
}

void ThreadGate::close() {
  std::map<std::uint64_t, std::promise<Expected<Value>>> left;
  {
    const std::lock_guard lock(mutex_);
    if (!open_) return;
    open_ = false;
    left.swap(asked_);
    waiting_.clear();
  }
  for (auto& [id, promise] : left) promise.set_value(gone(owner_));
  for (const auto& [key, publisher] : publishers_) environment_.bus().remove(publisher);
  publishers_.clear();
  environment_.bus().remove(in_);
  environment_.bus().leave(node_);
}

ThreadGate::Answer ThreadGate::ask(Request request) {
  std::promise<Expected<Value>> promise;
  Answer answer = promise.get_future();
  const std::lock_guard lock(mutex_);
  if (!open_) {
    promise.set_value(gone(owner_));
  } else if (environment_.on_its_thread()) {
    promise.set_value(
        run_error("plugin '" + owner_ + "': a thread gate is for other threads; on the episode's use the environment"));
  } else if (waiting_.size() == kMostWaiting) {
    promise.set_value(run_error("plugin '" + owner_ + "': " + std::to_string(kMostWaiting) +
                                " requests of its threads wait for a tick: wait for answers"));
  } else {
    request.id = ++last_id_;
    asked_.emplace(request.id, std::move(promise));
    waiting_.push_back(std::move(request));
  }
  return answer;
}

ThreadGate::Answer ThreadGate::assert_fact(const std::string& fact) { return ask({0, "assert", fact, {}, {}}); }
ThreadGate::Answer ThreadGate::retract(std::int64_t index) {
  return ask({0, "retract", std::to_string(index), {}, {}});
}
ThreadGate::Answer ThreadGate::call(const std::string& expression) { return ask({0, "call", expression, {}, {}}); }
ThreadGate::Answer ThreadGate::publish(const std::string& topic, const std::string& type, const std::string& yaml) {
  return ask({0, "publish", topic, type, yaml});
}

void ThreadGate::hand_over() {
  std::vector<Request> requests;
  {
    const std::lock_guard lock(mutex_);
    requests.swap(waiting_);
  }
  for (const Request& request : requests) {
    auto message = std::make_shared<bus::Message>(*type_);
    message->view()
        .set("verb", request.verb)
        .set("text", request.text)
        .set("type", request.type)
        .set("content", request.content);
    message->view().set("id", static_cast<std::int64_t>(request.id));
    environment_.bus().publish(out_, std::move(message));
  }
}

void ThreadGate::carry_out(const bus::Delivery& delivery) {
  const bus::MessageView request = delivery.message->view();
  environment_.note_input("thread", owner_, delivery);
  Expected<Value> done = do_verb(request);
  if (!done) environment_.log(LogLevel::kError, owner_, "from a thread: " + done.error().text());
  const std::lock_guard lock(mutex_);
  const auto asked = asked_.find(static_cast<std::uint64_t>(request.integer("id")));
  if (asked == asked_.end()) return;  // a replay has no thread that waits
  asked->second.set_value(std::move(done));
  asked_.erase(asked);
}

Expected<Value> ThreadGate::do_verb(const bus::MessageView& request) {
  RuleEngine& engine = environment_.engine();
  const std::string& verb = request.text("verb");
  const std::string& text = request.text("text");
  if (verb == "assert") {
    auto index = engine.assert_string(text);
    if (!index) return index.error();
    return Value::integer(*index);
  }
  if (verb == "retract") return Value::boolean(engine.retract(std::stoll(text)));
  if (verb == "call") return engine.eval(text);
  if (Status s = publish_now(text, request.text("type"), request.text("content")); !s) return s.error();
  return Value();
}

Status ThreadGate::publish_now(const std::string& topic, const std::string& type_name, const std::string& yaml) {
  bus::Bus& bus = environment_.bus();
  auto type = bus.registry().message(type_name);
  if (!type) return type.error();
  auto message = bus::Message::from_yaml(**type, yaml);
  if (!message) return message.error();
  const auto key = std::pair(topic, type_name);
  auto known = publishers_.find(key);
  if (known == publishers_.end()) {
    auto made = bus.advertise(environment_.participant(), topic, **type);
    if (!made) return made.error();
    known = publishers_.emplace(key, *made).first;
  }
  bus.publish(known->second, std::make_shared<const bus::Message>(*std::move(message)), environment_.engine().cause());
  return {};
}

}  // namespace cxlab::cx
