#pragma once
// The agent at a seat, with its connection to the bus; and seats that send again what the log of a run has.

#include <filesystem>
#include <memory>
#include <vector>

#include "cx/bus/bus.h"
#include "scenarios/inputs.h"
#include "scenarios/seat.h"

namespace cxlab {

/// Joins the bus as the node of the seat and makes its agent, which is called through this one. What the agent sends
/// goes to the log of inputs and to the bus. All given outlive it.
Expected<std::unique_ptr<Agent>> seated_agent(const Seat& seat, bus::Bus& bus, RecordSink& sink, Inputs& inputs);

/// The seats of a recorded run. Each sends what it sent then, when it sent it then, and reads nothing; none if the run
/// had none.
Expected<std::vector<Seat>> recorded_seats(const std::filesystem::path& inputs);

}  // namespace cxlab
