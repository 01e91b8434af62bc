#include "cx/bus/needed.h"
#include "cx/plugins/builtin.h"
#include "cx/plugins/ros_msgs/connection.h"

namespace cxlab::cx {

namespace {

/// The functions, facts and templates of cx::RosMsgsPlugin in one environment: the bus with any type.
class RosInterface final : public BusConnection {
 public:
  RosInterface(Environment& environment, std::string logger)
      : BusConnection(environment, std::move(logger), "ros-msgs", /*bound=*/false) {}

 private:
  void add_all() override;
  void get_field(Call& call);
  void set_field(Call& call);
  void on_cancel_response(const std::string& server, const bus::Delivery& response) override;
};

void RosInterface::add_all() {
  using F = FunctionKind;
  add("create-message", "e", ";sy", F::kActing, "A new message of a type, for example std_msgs/msg/String.",
      [this](Call& call) {
        if (const auto* type = message_type(call, call.arg(0))) call.give_handle(store_.create(*type, owner_));
      });
  add("destroy-message", "v", ";e", F::kActing, "Drops a message and what is nested in it.",
      [this](Call& call) { store_.destroy(call.handle(0)); });
  add("get-field", "*", ";e;sy", F::kPure, "A field of a message.", [this](Call& call) { get_field(call); });
  add("set-field", "v", ";e;sy;*", F::kActing, "Sets a field of a message.", [this](Call& call) { set_field(call); });
  add_topics(nullptr);
  add_services(nullptr);
  add("create-request", "e", ";sy", F::kActing, "A new request of a service type.", [this](Call& call) {
    if (const auto* type = known(call, bus_.registry().service(std::string(call.text(0)))))
      call.give_handle(store_.create(*type->request, owner_));
  });
  add_action_clients(nullptr);
  define("cancel-response",
         "(slot server (type STRING)) (slot client-goal-handle-ptr (type EXTERNAL-ADDRESS)) "
         "(slot cancel-response-ptr (type EXTERNAL-ADDRESS))");
  add("create-goal-request", "e", ";sy", F::kActing, "A new goal of an action type.", [this](Call& call) {
    if (const auto* type = known(call, bus_.registry().action(std::string(call.text(0)))))
      call.give_handle(store_.create(*type->goal, owner_));
  });
  add("goal-uuid-to-string", "y", ";m", F::kPure, "16 integers as 32 hex digits.", [](Call& call) {
    const ValueRef& bytes = call.arg(0);
    bus::GoalId id{};
    bool fits = bytes.size() == id.size();
    for (std::size_t i = 0; fits && i < id.size(); ++i) {
      fits = bytes[i].is(ValueType::kInteger) && bytes[i].as_integer() >= 0 && bytes[i].as_integer() <= 255;
      if (fits) id[i] = static_cast<std::uint8_t>(bytes[i].as_integer());
    }
    if (fits) return call.give_symbol(bus::to_string(id));
    call.complain(found_expected(bytes.copy().print(), "16 integers from 0 to 255"));
    call.give_boolean(false);
  });
}

// CX logs an unknown field and goes on with a result that is not defined; here it is FALSE.

void RosInterface::get_field(Call& call) {
  const auto fault = fields_.give(call, call.handle(0), call.arg(1));
  if (!fault) return;
  const std::string failed = "Failed to retrieve field " + std::string(call.text(1));
  if (fault->kind != FieldFault::Kind::kNoField) return call.fail(failed + ": " + fault->text);
  log(LogLevel::kError, failed);
  call.complain(fault->text);
  call.give_boolean(false);
}

void RosInterface::set_field(Call& call) {
  const auto fault = fields_.set(call.handle(0), call.arg(1), call.arg(2));
  if (!fault) return;
  const std::string failed = "Failed to set field " + std::string(call.text(1));
  switch (fault->kind) {
    case FieldFault::Kind::kNoMessage:
    case FieldFault::Kind::kValue: return call.fail(failed + ": " + fault->text);
    case FieldFault::Kind::kNoField: log(LogLevel::kError, failed); break;
    case FieldFault::Kind::kNotMultifield: log(LogLevel::kError, "expected multifield value!"); break;
    case FieldFault::Kind::kUnknownMessage: log(LogLevel::kError, "Failed to set unknown message"); break;
  }
  call.complain(fault->text);
}

void RosInterface::on_cancel_response(const std::string& server, const bus::Delivery& delivery) {
  const Handle response =
      store_.create(**bus::needed_message(bus_.registry(), "action_msgs/srv/CancelGoal_Response"), owner_);
  const bus::MessageView view = store_.writable(response);
  view.set("return_code", static_cast<std::int64_t>(delivery.return_code));
  for (const auto& [id, stamp] : delivery.goals_canceling) {
    const bus::MessageView info = view.append("goals_canceling");
    const bus::MessageView uuid = info.nested("goal_id");
    const bus::Field& bytes = *uuid.type().find("uuid");
    for (std::size_t i = 0; i < id.size(); ++i) (void)uuid.set_integer(bytes, id[i], i);
    const std::int64_t ns = stamp.count();
    info.nested("stamp").set("sec", ns / 1'000'000'000).set("nanosec", ns % 1'000'000'000);
  }
  put(named("cancel-response"), {{"server", Value::string(server)},
                                 {"client-goal-handle-ptr", Value::handle(handle_of(server, delivery.goal))},
                                 {"cancel-response-ptr", Value::handle(response)}});
}

class RosMsgsPlugin final : public ConnectionPlugin {
 public:
  using ConnectionPlugin::ConnectionPlugin;

 private:
  std::unique_ptr<BusConnection> connect(Environment& environment) override {
    return std::make_unique<RosInterface>(environment, name());
  }
};

}  // namespace

PluginType ros_msgs_plugin() {
  return {"cx::RosMsgsPlugin", {}, [](PluginContext c) { return std::make_unique<RosMsgsPlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
