// TurtlesimNode: its parameters, the colour of the background.

#include <algorithm>
#include <array>

#include "scenarios/turtlesim/node_parts.h"

namespace cxlab::turtlesim {

namespace {

constexpr std::uint8_t kInteger = 2;  // rcl_interfaces/msg/ParameterType
constexpr std::array<std::string_view, 3> kNames{"background_b", "background_g", "background_r"};

std::uint8_t* component(sim::Colour& colour, const std::string& name) {
  if (name == "background_r") return &colour.r;
  if (name == "background_g") return &colour.g;
  if (name == "background_b") return &colour.b;
  return nullptr;
}

/// Why the value cannot be taken; empty = it was.
std::string set(sim::Colour& colour, const bus::MessageView& parameter) {
  const std::string& name = parameter.text("name");
  std::uint8_t* place = component(colour, name);
  if (!place) return "parameter '" + name + "' cannot be set because it was not declared";
  const bus::MessageView value = parameter.nested("value");
  if (value.integer("type") != kInteger) return name + ": expected an integer";
  const std::int64_t number = value.integer("integer_value");
  if (number < 0 || number > 255) return name + ": found " + std::to_string(number) + ", expected 0 to 255";
  *place = static_cast<std::uint8_t>(number);
  return {};
}

}  // namespace

void TurtlesimNode::on_get_parameters(const bus::Delivery& request) {
  const bus::MessageView view = request.message->view();
  const bus::Field& names = *view.type().find("names");
  auto service = bus_.registry().service("rcl_interfaces/srv/GetParameters");
  bus::Message response(*(*service)->response);
  sim::Colour background = world_.background();
  for (std::size_t i = 0; i < view.size(names); ++i) {
    const bus::MessageView value = response.view().append("values");
    if (const std::uint8_t* place = component(background, view.text(names, i)))
      value.set("type", static_cast<int>(kInteger)).set("integer_value", static_cast<int>(*place));
  }
  bus_.respond(request.endpoint, request, shared(std::move(response)));
}

void TurtlesimNode::on_set_parameters(const bus::Delivery& request) {
  const bus::MessageView view = request.message->view();
  auto service = bus_.registry().service("rcl_interfaces/srv/SetParameters");
  bus::Message response(*(*service)->response);
  sim::Colour background = world_.background();
  for (std::size_t i = 0; i < view.size("parameters"); ++i) {
    const std::string reason = set(background, view.nested("parameters", i));
    response.view().append("results").set("successful", reason.empty()).set("reason", reason);
  }
  world_.set_background(background);
  note(RecordKind::kControl, "background", "", {{"r", background.r}, {"g", background.g}, {"b", background.b}}, &request);
  bus_.respond(request.endpoint, request, shared(std::move(response)));
}

void TurtlesimNode::on_list_parameters(const bus::Delivery& request) {
  const bus::MessageView view = request.message->view();
  const bus::Field& prefixes = *view.type().find("prefixes");
  const auto wanted = [&](std::string_view name) {
    bool found = view.size(prefixes) == 0;
    for (std::size_t i = 0; i < view.size(prefixes) && !found; ++i) found = name == view.text(prefixes, i);
    return found;
  };
  auto service = bus_.registry().service("rcl_interfaces/srv/ListParameters");
  bus::Message response(*(*service)->response);
  for (const std::string_view name : kNames)
    if (wanted(name)) response.view().nested("result").append_text("names", name);
  bus_.respond(request.endpoint, request, shared(std::move(response)));
}

}  // namespace cxlab::turtlesim
