// Episodes: a session of lab/session.h that Python plays.

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "lab/session.h"
#include "scenarios/share.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::python {

namespace {

/// PATH=VALUE, and the argument that errors in it name.
using Assignments = std::vector<std::pair<std::string, std::string>>;

struct Asked {
  std::string scenario;
  Assignments assignments;
  std::optional<double> until;
  std::string journal;
  std::string out;
  bool force = false;
};

/// Time of the last tick (s), ticks played, whether the run is over.
using StepTuple = std::tuple<double, std::int64_t, bool>;

class PlayedEpisode {
 public:
  explicit PlayedEpisode(const Asked& asked) {
    const auto file = value_or_raise(find_scenario(asked.scenario));
    std::vector<Override> overrides;
    for (const auto& [assignment, option] : asked.assignments) overrides.emplace_back(assignment, option);
    Scenario scenario = value_or_raise(Scenario::load(file, shipped(), overrides));
    lab::PlayOptions options;
    options.spec.until = asked.until;
    auto journal = named(options.spec.journal, kJournalLevels);
    if (!journal.set(asked.journal))
      raise(usage_error("found '" + asked.journal + "', expected none, decisions or full", "journal"));
    options.out = asked.out.empty() ? "none" : asked.out;
    options.force = asked.force;
    options.command = {"python"};
    Expected<std::unique_ptr<lab::Session>> session = usage_error("");
    {
      const nb::gil_scoped_release others_may_run;
      session = lab::Session::load(options, std::move(scenario));
    }
    session_ = value_or_raise(std::move(session));
  }

  StepTuple step(std::optional<double> until, std::optional<std::int64_t> ticks) {
    const Use use(*this);
    const SimTime end = until ? from_seconds(*until) : kNever;
    StepReport all{session_->episode().now(), 0, false};
    while (true) {
      Expected<StepReport> report = usage_error("");
      {
        const nb::gil_scoped_release others_may_run;
        report = stretch(end, ticks ? std::optional(*ticks - all.ticks) : std::nullopt);
      }
      const StepReport done = value_or_raise(std::move(report));
      all = {done.now, all.ticks + done.ticks, done.over};
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      if (!paused_) return {to_seconds(all.now), all.ticks, all.over};
    }
  }

  /// result.json of the run, which is over now.
  nb::object close() {
    const Use use(*this);
    {
      const nb::gil_scoped_release others_may_run;
      played_ = session_->close();
    }
    session_.reset();
    return from_json(played_->result.to_json());
  }

  bool closed() const { return !session_; }
  bool over() const { return !session_ || session_->over(); }
  double now() const { return to_seconds(session_ ? session_->episode().now() : played_->result.sim_time); }

 private:
  /// For the length of a call: the episode is open, and nobody else uses it.
  class Use {
   public:
    explicit Use(PlayedEpisode& episode) : episode_(episode) {
      if (episode.busy_.exchange(true))
        raise(usage_error("the episode is in use: by another thread, or by a seat that calls it from its turn"));
      if (!episode.session_) {
        episode.busy_ = false;
        raise(usage_error("the episode is closed"));
      }
    }
    ~Use() { episode_.busy_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    PlayedEpisode& episode_;
  };

  /// Plays on until the end or the number of ticks, or for so long that Python should look for signals (`paused_`).
  Expected<StepReport> stretch(SimTime end, std::optional<std::int64_t> ticks) {
    using Clock = std::chrono::steady_clock;
    const auto look = Clock::now() + std::chrono::milliseconds(50);
    std::int64_t played = 0;
    paused_ = false;
    if (ticks && *ticks <= 0) return StepReport{session_->episode().now(), 0, session_->over()};
    return session_->step(end, [&] {
      if (++played == ticks) return true;
      return paused_ = Clock::now() >= look;
    });
  }

  std::unique_ptr<lab::Session> session_;  // none: closed
  std::optional<lab::Played> played_;
  std::atomic<bool> busy_ = false;
  bool paused_ = false;
};

}  // namespace

void bind_episode(nb::module_& module) {
  nb::class_<PlayedEpisode>(module, "Episode")
      .def(
          "__init__",
          [](PlayedEpisode* self, std::string scenario, Assignments assignments, std::optional<double> until,
             std::string journal, std::string out, bool force) {
            new (self) PlayedEpisode(
                {std::move(scenario), std::move(assignments), until, std::move(journal), std::move(out), force});
          },
          nb::kw_only(), nb::arg("scenario"), nb::arg("assignments"), nb::arg("until").none(), nb::arg("journal"),
          nb::arg("out"), nb::arg("force"))
      .def("step", &PlayedEpisode::step, nb::arg("until").none(), nb::arg("ticks").none())
      .def("close", &PlayedEpisode::close)
      .def_prop_ro("closed", &PlayedEpisode::closed)
      .def_prop_ro("over", &PlayedEpisode::over)
      .def_prop_ro("now", &PlayedEpisode::now);
}

}  // namespace cxlab::python
