// Episodes whose trainer cx_rl_node leaves its choices to Python (scenarios/rl/trainer.h, policy `external`).

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "lab/env_scenario.h"
#include "lab/session.h"
#include "play_options.h"
#include "scenarios/seat.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::python {

namespace {

/// As the message cxlab_msgs/msg/RlDecision.
struct RlDecision {
  std::int64_t id = 0;
  std::string robot, outcome;
  std::string observation, mask;  ///< a byte for each bit
  double reward = 0;
};

std::string bytes_of(const bus::MessageView& message, std::string_view name) {
  const bus::Field& field = *message.type().find(name);
  std::string bytes(message.size(field), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(message.integer(field, i));
  return bytes;
}

std::vector<std::string> texts_in(const bus::MessageView& message, std::string_view name) {
  const bus::Field& field = *message.type().find(name);
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < message.size(field); ++i) texts.push_back(message.text(field, i));
  return texts;
}

/// Keeps the decisions that are open, and sends the answers.
class TrainerSeat final : public QuietAgent {
 public:
  TrainerSeat(SeatBus& bus, const std::string& node) : bus_(bus), made_(node + "/decisions/made") {
    reads_ = bus_.read(node + "/spaces", "cxlab_msgs/msg/RlSpaces", [this](const bus::MessageView& message) {
      spaces_ = {texts_in(message, "observables"), texts_in(message, "actions")};
    });
    if (!reads_) return;
    reads_ = bus_.read(node + "/decisions", "cxlab_msgs/msg/RlDecision", [this](const bus::MessageView& message) {
      open_.push_back({message.integer("id"), message.text("robot"), message.text("outcome"),
                       bytes_of(message, "observation"), bytes_of(message, "mask"), message.real("reward")});
    });
  }

  Status perceive() override { return reads_; }

  const RlDecision* last() const { return open_.empty() ? nullptr : &open_.back(); }
  const std::pair<std::vector<std::string>, std::vector<std::string>>& spaces() const { return spaces_; }

  /// Also of those that another one has overtaken.
  Status answer(std::int64_t action) {
    auto made = bus_.make("cxlab_msgs/msg/RlDecisionMade");
    if (!made) return made.error();
    made->view().set("id", open_.back().id).set("action", action);
    open_.clear();
    return bus_.publish(made_, "cxlab_msgs/msg/RlDecisionMade", *std::move(made));
  }

 private:
  SeatBus& bus_;
  std::string made_;
  Status reads_;
  std::deque<RlDecision> open_;
  std::pair<std::vector<std::string>, std::vector<std::string>> spaces_;
};

/// id, robot, observation, mask, reward, outcome, time (s)
using DecisionTuple = std::tuple<std::int64_t, std::string, nb::bytes, nb::bytes, double, std::string, double>;

class TrainingAtPlay {
 public:
  /// Either a scenario with assignments, or configurations with packages and parameters as `cxlab env` takes them.
  TrainingAtPlay(const std::string& scenario, const std::vector<std::pair<std::string, std::string>>& assignments,
                 const std::vector<std::string>& configs, const std::vector<std::string>& packages,
                 const std::vector<std::string>& params, std::optional<std::uint64_t> seed, std::optional<double> until,
                 const std::string& journal, const std::string& out, bool force, const std::string& node) {
    lab::PlayOptions options = play_options(until, journal, out, force);
    options.seats.push_back({"trainer", [this, node](SeatBus& bus) -> Expected<std::unique_ptr<Agent>> {
                               auto seat = std::make_unique<TrainerSeat>(bus, node);
                               seat_ = seat.get();
                               return std::unique_ptr<Agent>(std::move(seat));
                             }});
    Expected<std::unique_ptr<lab::Session>> session = usage_error("");
    {
      const nb::gil_scoped_release others_may_run;
      lab::EnvOptions env;
      env.configs = configs;
      env.with = {"cx_rl_node"};
      env.packages = packages;
      env.params = params;
      env.stop_on_rule_error = true;
      env.seed = seed;
      env.until = until.value_or(kLong);
      auto loaded = configs.empty() ? scenario_of(scenario, assignments) : lab::env_scenario(env, shipped());
      if (loaded)
        session = lab::Session::load(options, *std::move(loaded));
      else
        session = loaded.error();
    }
    session_ = value_or_raise(std::move(session));
  }

  /// Plays on to the next decision; none: the run is over.
  std::optional<DecisionTuple> next() {
    const InUse in_use(play_);
    if (!seat().last())
      in_stretches([&](const auto& pause) { return session_->step(kNever, [&] { return seat_->last() || pause(); }); });
    const RlDecision* open = seat().last();
    if (!open) return std::nullopt;
    const auto bytes = [](const std::string& text) { return nb::bytes(text.data(), text.size()); };
    return DecisionTuple{open->id,
                         open->robot,
                         bytes(open->observation),
                         bytes(open->mask),
                         open->reward,
                         open->outcome,
                         to_seconds(session_->episode().now())};
  }

  void choose(std::int64_t action) {
    const InUse in_use(play_);
    if (!seat().last()) raise(usage_error("found no open decision; call next() first"));
    check(seat_->answer(action));
  }

  /// Names of what can be observed, and of what can be done.
  std::pair<std::vector<std::string>, std::vector<std::string>> spaces() {
    const InUse in_use(play_);
    return seat().spaces();
  }

  nb::object close() {
    const InUse in_use(play_);
    seat();
    lab::Played ended;
    {
      const nb::gil_scoped_release others_may_run;
      ended = session_->close();
    }
    session_.reset();
    if (ended.failure) raise(*ended.failure);
    return from_json(ended.result.to_json());
  }

  bool closed() const { return !session_; }

 private:
  static constexpr double kLong = 1e8;  ///< s: a training ends with its episodes

  TrainerSeat& seat() {
    if (!session_) raise(usage_error("the training is closed"));
    return *seat_;
  }

  Play play_;
  std::unique_ptr<lab::Session> session_;  // none: closed
  TrainerSeat* seat_ = nullptr;            // owned by the session
};

}  // namespace

void bind_training(nb::module_& module) {
  nb::class_<TrainingAtPlay>(module, "Training")
      .def(nb::init<const std::string&, const std::vector<std::pair<std::string, std::string>>&,
                    const std::vector<std::string>&, const std::vector<std::string>&, const std::vector<std::string>&,
                    std::optional<std::uint64_t>, std::optional<double>, const std::string&, const std::string&, bool,
                    const std::string&>(),
           nb::kw_only(), nb::arg("scenario"), nb::arg("assignments"), nb::arg("configs"), nb::arg("packages"),
           nb::arg("params"), nb::arg("seed").none(), nb::arg("until").none(), nb::arg("journal"), nb::arg("out"),
           nb::arg("force"), nb::arg("node"))
      .def("next", &TrainingAtPlay::next)
      .def("choose", &TrainingAtPlay::choose, nb::arg("action"))
      .def("spaces", &TrainingAtPlay::spaces)
      .def("close", &TrainingAtPlay::close)
      .def_prop_ro("closed", &TrainingAtPlay::closed);
}

}  // namespace cxlab::python
