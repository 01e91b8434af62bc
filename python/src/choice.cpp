// Episodes that stop where rules leave a choice to Python (lab/choices.h).

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "lab/choices.h"
#include "play_options.h"

namespace cxlab::python {

namespace {

using Reals = nb::ndarray<nb::numpy, double, nb::ndim<1>>;

/// A copy, which Python owns.
Reals array_of(const std::vector<double>& values) {
  auto* data = new double[values.size() + 1];
  std::copy(values.begin(), values.end(), data);
  const nb::capsule owner(data, [](void* memory) noexcept { delete[] static_cast<double*>(memory); });
  return Reals(data, {values.size()}, owner);
}

class ChoicesAtPlay {
 public:
  ChoicesAtPlay(const std::string& scenario, const Assignments& assignments, std::optional<double> until,
                const std::string& journal, const std::string& out, bool force, const std::string& topic) {
    const lab::PlayOptions options = play_options(until, journal, out, force);
    Expected<std::unique_ptr<lab::ChoiceEpisode>> episode = usage_error("");
    {
      const nb::gil_scoped_release others_may_run;
      auto loaded = scenario_of(scenario, assignments);
      if (loaded)
        episode = lab::ChoiceEpisode::load(options, *std::move(loaded), {.name = topic});
      else
        episode = loaded.error();
    }
    episode_ = value_or_raise(std::move(episode));
  }

  /// Plays on to the next choice; whether there is one.
  bool next() {
    const InUse in_use(play_);
    lab::ChoiceEpisode& episode = played();
    choice_ = nullptr;
    choice_ = in_stretches([&](const auto& pause) { return episode.next_choice(pause); });
    return choice_ != nullptr;
  }

  /// Plays each of these on to its next choice, in so many threads.
  static void play_on(const std::vector<ChoicesAtPlay*>& all, std::size_t threads) {
    std::deque<InUse> in_use;
    std::vector<lab::ChoiceEpisode*> episodes;
    for (ChoicesAtPlay* one : all) {
      in_use.emplace_back(one->play_);
      episodes.push_back(&one->played());
      one->choice_ = nullptr;
    }
    in_stretches([&](const auto& pause) -> Expected<bool> {
      if (Status s = lab::ChoiceEpisode::play_on(episodes, threads, pause); !s) return s.error();
      return true;
    });
  }

  void choose(std::int64_t option) {
    const InUse in_use(play_);
    check(played().choose(option));
    choice_ = nullptr;
  }

  const lab::Choice& choice() const {
    if (!choice_) raise(usage_error("no choice is open; call next() first"));
    return *choice_;
  }

  double now() {
    const InUse in_use(play_);
    return to_seconds(played().session().episode().now());
  }

  /// What the result has so far at that path, as JSON; empty: nothing.
  std::string result_at(const std::string& path) {
    const InUse in_use(play_);
    return played().session().episode().result_at(path);
  }

  nb::object render(int width, int height, const std::string& camera, bool caption) {
    const InUse in_use(play_);
    return renderer_.draw(played().session().episode(), width, height, camera, caption);
  }

  nb::object close() {
    const InUse in_use(play_);
    lab::Session& session = played().session();
    choice_ = nullptr;
    renderer_ = {};
    lab::Played ended;
    {
      const nb::gil_scoped_release others_may_run;
      ended = session.close();
    }
    episode_.reset();
    if (ended.failure) raise(*ended.failure);
    return from_json(ended.result.to_json());
  }

 private:
  lab::ChoiceEpisode& played() {
    if (!episode_) raise(usage_error("the episode is closed"));
    return *episode_;
  }

  Play play_;
  std::unique_ptr<lab::ChoiceEpisode> episode_;  // none: closed
  const lab::Choice* choice_ = nullptr;          // none is open
  Renderer renderer_;
};

}  // namespace

void bind_choice(nb::module_& module) {
  nb::class_<ChoicesAtPlay>(module, "ChoiceEpisode")
      .def(nb::init<const std::string&, const Assignments&, std::optional<double>, const std::string&,
                    const std::string&, bool, const std::string&>(),
           nb::kw_only(), nb::arg("scenario"), nb::arg("assignments"), nb::arg("until").none(), nb::arg("journal"),
           nb::arg("out"), nb::arg("force"), nb::arg("topic"))
      .def("next", &ChoicesAtPlay::next)
      .def_static("play_on", &ChoicesAtPlay::play_on, nb::arg("episodes"), nb::arg("threads"))
      .def("choose", &ChoicesAtPlay::choose, nb::arg("option"))
      .def("result_at", &ChoicesAtPlay::result_at, nb::arg("path"))
      .def("render", &ChoicesAtPlay::render, nb::arg("width"), nb::arg("height"), nb::arg("camera"), nb::arg("caption"))
      .def("close", &ChoicesAtPlay::close)
      .def_prop_ro("now", &ChoicesAtPlay::now)
      .def_prop_ro("kind", [](const ChoicesAtPlay& self) { return self.choice().kind; })
      .def_prop_ro("who", [](const ChoicesAtPlay& self) { return self.choice().who; })
      .def_prop_ro("options", [](const ChoicesAtPlay& self) { return self.choice().options; })
      .def_prop_ro("allowed", [](const ChoicesAtPlay& self) { return self.choice().allowed; })
      .def_prop_ro("preferred", [](const ChoicesAtPlay& self) { return self.choice().preferred; })
      .def_prop_ro(
          "situation", [](const ChoicesAtPlay& self) { return array_of(self.choice().situation); }, nb::rv_policy::move)
      .def_prop_ro(
          "features", [](const ChoicesAtPlay& self) { return array_of(self.choice().features); }, nb::rv_policy::move);
}

}  // namespace cxlab::python
