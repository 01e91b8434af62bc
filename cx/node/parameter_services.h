#pragma once
// The parameter services that every ROS 2 node has (rcl_interfaces), over a node's `Parameters`.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/node/parameters.h"

namespace cxlab::cx {

/// Into and out of an rcl_interfaces/msg/ParameterValue.
void put_parameter(const Parameter& parameter, const bus::MessageView& value);
Expected<Parameter> take_parameter(const bus::MessageView& value);

/// The error of a value that a client wants to set, if it has one.
using ParameterCheck = std::function<Status(const std::string& name, const Parameter& value)>;

/// Sets parameters of a node at once, as `~/set_parameters_atomically` does.
using ParameterSetter = std::function<Status(std::vector<std::pair<std::string, Parameter>> values)>;

/// Offers `~/list_parameters`, `~/get_parameters`, `~/get_parameter_types`, `~/describe_parameters`,
/// `~/set_parameters`, `~/set_parameters_atomically`, and reports changes on `/parameter_events`. A parameter keeps
/// its type; one that is not there is not set, nor what `check` refuses. `parameters` outlives the node's place on the
/// bus, and what is returned.
Expected<ParameterSetter> serve_parameters(bus::Bus& bus, bus::ParticipantId node, Parameters& parameters,
                                           ParameterCheck check = {});

}  // namespace cxlab::cx
