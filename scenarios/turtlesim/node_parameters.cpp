// TurtlesimNode: its parameters, the colour of the background.

#include <array>
#include <cstdlib>

#include "cx/node/parameter_services.h"
#include "scenarios/turtlesim/node_parts.h"

namespace cxlab::turtlesim {

namespace {

constexpr std::array<const char*, 3> kNames{"background_r", "background_g", "background_b"};

}  // namespace

Status TurtlesimNode::serve_parameters() {
  const sim::Colour now = world_.background();
  std::array<std::int64_t, 3> values{now.r, now.g, now.b};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (Status s = parameters_.declare(kNames[i], values[i]); !s) return s;
  return cx::serve_parameters(bus_, *self_, parameters_,
                              [](const std::string& name, const cx::Parameter& value) -> Status {
                                const long number = std::strtol(value.text.c_str(), nullptr, 10);
                                if (number < 0 || number > 255)
                                  return input_error(name + ": found " + value.text + ", expected 0 to 255");
                                return {};
                              });
}

/// Somebody may have set them.
void TurtlesimNode::apply_parameters() {
  std::array<std::int64_t, 3> values{};
  for (std::size_t i = 0; i < kNames.size(); ++i) (void)parameters_.read(kNames[i], values[i]);
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(values[i]); };
  const sim::Colour wanted{byte(0), byte(1), byte(2)};
  if (wanted == world_.background()) return;
  world_.set_background(wanted);
  note(RecordKind::kControl, "background", "", {{"r", wanted.r}, {"g", wanted.g}, {"b", wanted.b}}, nullptr);
}

}  // namespace cxlab::turtlesim
