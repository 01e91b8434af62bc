// Episodes: a session of lab/session.h that Python plays.

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings.h"
#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "lab/report.h"
#include "lab/session.h"
#include "outside.h"
#include "play_options.h"
#include "scenarios/share.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::python {

using namespace nb::literals;

namespace {

/// Time of the last tick (s), ticks played, whether the run is over.
using StepTuple = std::tuple<double, std::int64_t, bool>;

/// Lines of the log wait here until Python can take them, in its logging.
class LinesForPython final : public cx::LogSink, public lab::ProgressSink {
 public:
  void line(const cx::LogLine& line) override {
    constexpr int kLevels[] = {10, 20, 30, 40};
    char time[32];
    std::snprintf(time, sizeof time, "%.3f ", to_seconds(line.t));
    lines_.emplace_back(kLevels[static_cast<std::size_t>(line.level)],
                        time + std::string(line.logger) + ": " + std::string(line.text));
  }
  void progress(double, double) override {}
  void note(std::string_view text) override { lines_.emplace_back(20, text); }
  /// Those of the levels that Python's logging wants now. Asking for them takes longer than many a step.
  void hand_over() {
    if (lines_.empty()) return;
    const auto lines = std::exchange(lines_, {});
    const int least = nb::cast<int>(logger_.attr("getEffectiveLevel")());
    const nb::object log = logger_.attr("log");
    for (const auto& [level, line] : lines)
      if (level >= least) log(level, "%s", text(line));
  }

 private:
  nb::object logger_ = nb::module_::import_("logging").attr("getLogger")("cxlab");
  std::vector<std::pair<int, std::string>> lines_;
};

class PlayedEpisode {
 public:
  struct Asked {
    std::string scenario;
    Assignments assignments;
    std::optional<double> until;
    std::string journal;
    std::string out;
    bool force = false;
    nb::list seats;
    std::vector<std::string> packages;
  };

  explicit PlayedEpisode(const Asked& asked) {
    lab::PlayOptions options = play_options(asked.until, asked.journal, asked.out, asked.force);
    options.spec.prefixes = asked.packages;
    for (const nb::handle seat : asked.seats) options.seats.push_back(seat_of_object(nb::borrow(seat), play_));
    Expected<std::unique_ptr<lab::Session>> session = usage_error("");
    (void)play_->begin();
    {
      const nb::gil_scoped_release others_may_run;
      auto scenario = scenario_of(asked.scenario, asked.assignments);
      if (scenario)
        session = lab::Session::load(options, *std::move(scenario), {.log = &lines_, .progress = &lines_});
      else
        session = scenario.error();
    }
    play_->end();
    lines_.hand_over();
    play_->raise_again();
    session_ = value_or_raise(std::move(session));
    note_state();
  }

  ~PlayedEpisode() { let_go(); }
  PlayedEpisode(const PlayedEpisode&) = delete;
  PlayedEpisode& operator=(const PlayedEpisode&) = delete;

  StepTuple step(std::optional<double> until, std::optional<std::int64_t> ticks) {
    const Use use(*this);
    if (until && std::isnan(*until)) raise(usage_error(found_expected("nan", "a time, s"), "until"));
    const SimTime end = until && *until < 1e9 ? from_seconds(*until) : kNever;
    std::int64_t played = 0;
    if (ticks && *ticks <= 0) return {now_, played, over_};
    in_stretches(
        [&](const auto& pause) {
          const auto stop = [&] { return ++played == ticks || play_->has_raised() || pause(); };
          return session_->step(end, std::cref(stop));  // a reference fits into std::function without memory of its own
        },
        [&] {
          note_state();
          lines_.hand_over();
          play_->raise_again();
        });
    return {now_, played, over_};
  }

  /// result.json of the run, which is over now.
  nb::object close() {
    const Use use(*this);
    {
      const nb::gil_scoped_release others_may_run;
      lab::Played played = session_->close();
      now_ = to_seconds(played.result.sim_time);
      result_ = played.result.to_json();
      folder_ = played.folder.string();
      page_ = lab::write_report(played);
      failure_ = played.failure;
    }
    let_go();
    over_ = true;
    lines_.hand_over();
    play_->raise_again();
    check(page_);
    return from_json(result_);
  }

  bool closed() const { return !session_; }
  bool over() const { return over_; }
  double now() const { return now_; }
  const std::string& folder() const { return folder_; }
  /// What ended the run early; None if nothing did.
  nb::object failure() const {
    if (!failure_) return nb::none();
    try {
      raise(*failure_);
    } catch (nb::python_error& error) {
      return nb::borrow(error.value());
    }
  }

  nb::object result() {
    if (!session_) return from_json(result_);
    const Use use(*this);
    nb::object result = from_json(episode().result().to_json());
    result["status"] = "running";
    return result;
  }

  // --- Environments

  std::vector<std::string> environments() {
    const Use use(*this);
    std::vector<std::string> names;
    for (const cx::Environment* one : episode().environments()) names.push_back(one->unique_name());
    return names;
  }

  /// [(index, template, {slot: value})] of the facts that match, and the names of the slots of the pattern's template.
  nb::tuple facts(const std::string& pattern, const std::optional<std::string>& env) {
    const Use use(*this);
    const cx::Environment& environment = environment_of(env);
    std::optional<explain::Pattern> wanted;
    std::string name;
    if (!pattern.empty()) {
      const bool is_name = !pattern.starts_with('(');
      auto parsed = explain::Pattern::parse_plain(is_name ? '(' + pattern + ')' : pattern, "pattern", 0);
      if (!parsed) raise(parsed.error());
      check_pattern(*parsed, environment);
      name = parsed->template_name();
      if (!is_name) wanted = *std::move(parsed);
    }
    nb::list found;
    for (const FactCopy& fact : environment.engine().facts(name)) {
      if (wanted && !wanted->matches(fact)) continue;
      nb::dict slots;
      for (const auto& [slot, value] : fact.slots) slots[text(slot)] = to_python(value);
      found.append(nb::make_tuple(fact.index, text(fact.template_name), slots));
    }
    nb::list names;
    if (!name.empty())
      for (const std::string& slot : environment.engine().slot_names(name)) names.append(text(slot));
    return nb::make_tuple(found, names);
  }

  std::int64_t assert_fact(const std::string& fact, const std::optional<std::string>& env) {
    const Use use(*this);
    const std::string index = act(env, cx::ControlAct::Verb::kAssert, fact);
    return std::stoll(index.substr(2));
  }
  void retract(std::int64_t index, const std::optional<std::string>& env) {
    const Use use(*this);
    (void)act(env, cx::ControlAct::Verb::kRetract, std::to_string(index));
  }
  nb::str eval(const std::string& expression, const std::optional<std::string>& env) {
    const Use use(*this);
    return text(act(env, cx::ControlAct::Verb::kEval, expression));
  }
  void build(const std::string& construct, const std::optional<std::string>& env) {
    const Use use(*this);
    (void)act(env, cx::ControlAct::Verb::kBuild, construct);
  }

  // --- The bus

  /// {name: (type, providers, users)} of topics, services or actions.
  nb::dict endpoints(const std::string& kind) {
    const Use use(*this);
    const bus::Bus& bus = episode().bus();
    nb::dict all;
    for (const bus::Bus::Info& info : kind == "topics"     ? bus.topics()
                                      : kind == "services" ? bus.services()
                                                           : bus.actions())
      all[text(info.name)] = nb::make_tuple(text(info.type), info.providers, info.users);
    return all;
  }
  void publish(const std::string& topic, const std::string& type, const std::string& yaml) {
    const Use use(*this);
    outside().publish(topic, type, yaml);
  }
  nb::list read(const std::string& topic, const std::string& type) {
    const Use use(*this);
    return outside().read(topic, type);
  }
  std::size_t call(const std::string& service, const std::string& type, const std::string& yaml) {
    const Use use(*this);
    return outside().call(service, type, yaml);
  }
  nb::object response(std::size_t number) { return heard().response(number); }
  std::size_t send_goal(const std::string& action, const std::string& type, const std::string& yaml) {
    const Use use(*this);
    return outside().send_goal(action, type, yaml);
  }
  void cancel(std::size_t goal) {
    const Use use(*this);
    outside().cancel(goal);
  }
  nb::object goal(std::size_t number) { return heard().goal(number); }

  // --- What there is to see

  nb::dict scene() {
    const Use use(*this);
    return to_python(episode().scene());
  }
  nb::object render(int width, int height, const std::string& camera, bool caption) {
    const Use use(*this);
    return renderer_.draw(episode(), width, height, camera, caption);
  }

 private:
  /// For the length of a call: the episode is open, and nobody else uses it.
  class Use {
   public:
    explicit Use(const PlayedEpisode& episode) : in_use_(*episode.play_) {
      if (!episode.session_) raise(usage_error("the episode is closed").with_code("closed"));
    }

   private:
    InUse in_use_;
  };

  Episode& episode() { return session_->episode(); }
  /// What refers to the session goes before it.
  void let_go() {
    renderer_ = {};
    if (session_ && outside_) outside_->finish();
    session_.reset();
  }
  void note_state() {
    now_ = to_seconds(episode().now());
    over_ = session_->over();
  }

  cx::Environment& environment_of(const std::optional<std::string>& name) {
    const std::vector<cx::Environment*> all = episode().environments();
    std::vector<std::string> names, meant;
    cx::Environment* found = nullptr;
    for (cx::Environment* one : all) {
      names.push_back(one->unique_name());
      if (!name) continue;
      if (one->unique_name() == *name) return *one;
      if (one->name() != *name) continue;
      meant.push_back(one->unique_name());
      found = one;
    }
    if (meant.size() == 1) return *found;
    if (meant.size() > 1)
      raise(usage_error(found_text(*name, "one of " + some_of(meant) + ", which share that name"), "env"));
    if (!name && all.size() == 1) return *all.front();
    if (names.empty()) raise(usage_error("the episode has no environment of rules", "env"));
    if (!name) raise(usage_error(found_expected("none", "one of " + some_of(names)), "env"));
    raise(usage_error(found_text(*name, "one of " + some_of_and_nearest(*name, names)), "env"));
  }

  static void check_pattern(const explain::Pattern& pattern, const cx::Environment& environment) {
    if (const Status s = explain::check_names(pattern, environment.engine()); !s) {
      Error error = s.error();
      error.file = "pattern";
      error.line = 0;
      raise(error);
    }
  }

  std::string act(const std::optional<std::string>& env, cx::ControlAct::Verb verb, const std::string& text) {
    if (text.find('\0') != text.npos) raise(usage_error("found a text with the character U+0000"));
    cx::Environment& environment = environment_of(env);
    Expected<std::string> done = usage_error("");
    {
      const nb::gil_scoped_release others_may_run;
      done = episode().act(environment, verb, text);
    }
    lines_.hand_over();
    return value_or_raise(std::move(done));
  }

  Outside& outside() {
    if (outside_) return *outside_;
    auto made = std::make_unique<Outside>();
    check(session_->join(made->seat()));
    outside_ = std::move(made);
    return *outside_;
  }

  /// Everything received so far, also by a closed episode.
  const Outside& heard() const {
    if (!outside_) raise(usage_error("nothing was sent"));
    if (play_->is_elsewhere()) raise(usage_error("the episode is in use by another thread"));
    return *outside_;
  }

  std::shared_ptr<Play> play_ = std::make_shared<Play>();
  LinesForPython lines_;
  std::unique_ptr<Outside> outside_;       // outlives the session, as do the others above
  std::unique_ptr<lab::Session> session_;  // none: closed
  Renderer renderer_;
  double now_ = -1;
  bool over_ = false;
  // What a closed episode keeps
  std::string result_, folder_;
  Status page_;
  std::optional<Error> failure_;
};

}  // namespace

void bind_episode(nb::module_& module) {
  nb::class_<PlayedEpisode>(module, "Episode")
      .def(
          "__init__",
          [](PlayedEpisode* self, std::string scenario, Assignments assignments, std::optional<double> until,
             std::string journal, std::string out, bool force, nb::list seats, std::vector<std::string> packages) {
            new (self) PlayedEpisode({std::move(scenario), std::move(assignments), until, std::move(journal),
                                      std::move(out), force, std::move(seats), std::move(packages)});
          },
          nb::kw_only(), "scenario"_a, "assignments"_a, "until"_a.none(), "journal"_a, "out"_a, "force"_a, "seats"_a,
          "packages"_a)
      .def("step", &PlayedEpisode::step, "until"_a.none(), "ticks"_a.none())
      .def("close", &PlayedEpisode::close)
      .def_prop_ro("closed", &PlayedEpisode::closed)
      .def_prop_ro("over", &PlayedEpisode::over)
      .def_prop_ro("now", &PlayedEpisode::now)
      .def_prop_ro("folder", &PlayedEpisode::folder)
      .def_prop_ro("failure", &PlayedEpisode::failure)
      .def_prop_ro("result", &PlayedEpisode::result)
      .def_prop_ro("environments", &PlayedEpisode::environments)
      .def("facts", &PlayedEpisode::facts, "pattern"_a, "env"_a.none())
      .def("assert_fact", &PlayedEpisode::assert_fact, "fact"_a, "env"_a.none())
      .def("retract", &PlayedEpisode::retract, "index"_a, "env"_a.none())
      .def("eval", &PlayedEpisode::eval, "expression"_a, "env"_a.none())
      .def("build", &PlayedEpisode::build, "construct"_a, "env"_a.none())
      .def("endpoints", &PlayedEpisode::endpoints, "kind"_a)
      .def("publish", &PlayedEpisode::publish, "topic"_a, "type"_a, "yaml"_a)
      .def("read", &PlayedEpisode::read, "topic"_a, "type"_a)
      .def("call", &PlayedEpisode::call, "service"_a, "type"_a, "yaml"_a)
      .def("response", &PlayedEpisode::response, "call"_a)
      .def("send_goal", &PlayedEpisode::send_goal, "action"_a, "type"_a, "yaml"_a)
      .def("cancel", &PlayedEpisode::cancel, "goal"_a)
      .def("goal", &PlayedEpisode::goal, "goal"_a)
      .def("scene", &PlayedEpisode::scene)
      .def("render", &PlayedEpisode::render, "width"_a, "height"_a, "camera"_a, "caption"_a);
}

}  // namespace cxlab::python
