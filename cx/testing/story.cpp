#include "cx/testing/story.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>

#include "cx/base/scratch_folder.h"
#include "cx/executive/environment_manager.h"
#include "cx/plugins/builtin.h"
#include "cx/run/loop.h"
#include "cx/testing/step_story.h"
#include "cx/testing/watch.h"
#include "cx/yaml/yaml.h"

namespace cxlab::testing {

namespace fs = std::filesystem;

namespace {

constexpr SimTime kTick = std::chrono::milliseconds(20);

std::string seconds(SimTime t) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", to_seconds(t));
  return text;
}

/// Keeps what plugins clean up at the end: it was left open. Counts the activations that CLIPS tells of.
class Leaks final : public cx::LogSink {
 public:
  void line(const cx::LogLine& line) override {
    if (line.text.starts_with(kActivation)) return count(line.text.substr(kActivation.size()));
    if (line.level == cx::LogLevel::kWarn && line.text.find("cleaning up") != std::string_view::npos)
      found.emplace_back(line.text);
  }
  std::vector<std::string> found;
  std::map<std::string, long> activated;  ///< by rule

 private:
  static constexpr std::string_view kActivation = "==> Activation ";
  /// `0      open: f-1,f-2`
  void count(std::string_view rest) {
    const auto name = rest.find_first_not_of(' ', rest.find(' '));
    if (name != rest.npos) ++activated[std::string(rest.substr(name, rest.find(':', name) - name))];
  }
};

/// Whether all that `wanted` names is in `found`; numbers as numbers.
bool contains(const yaml::Value& found, const yaml::Value& wanted) {
  if (wanted.is_map()) {
    if (!found.is_map()) return false;
    yaml::Map map = found.as_map();
    for (const auto& [key, value] : wanted.as_map().entries())
      if (const yaml::Value there = map.get(key); !there || !contains(there, value)) return false;
    return true;
  }
  if (wanted.is_list()) {
    const auto a = found.is_list() ? found.as_list() : std::vector<yaml::Value>();
    const auto b = wanted.as_list();
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), contains);
  }
  if (found.text() == wanted.text()) return true;
  char *a_end = nullptr, *b_end = nullptr;
  const std::string a = found.text(), b = wanted.text();
  const double x = std::strtod(a.c_str(), &a_end), y = std::strtod(b.c_str(), &b_end);
  return !a.empty() && !b.empty() && !*a_end && !*b_end && x == y;
}

bool contains(const std::string& found, const std::string& wanted) {
  if (wanted.empty()) return true;
  const auto a = yaml::Document::parse(found, "message"), b = yaml::Document::parse(wanted, "fields");
  return a && b && contains(a->root(), b->root());
}

class Play {
 public:
  Play(const StorySpec& spec, const StorySetup& setup) : spec_(spec), setup_(setup) {}

  StoryResult run() {
    if (Status s = prepare(); !s) return bad(s.error());
    if (Status s = begin(); !s) return s.error().kind == ErrorKind::kInput ? bad(s.error()) : broken(s.error());
    if (Status s = check_names(); !s) return bad(s.error());
    for (const Line& fact : spec_.given)
      if (Status s = assert_fact(fact.text, fact.line); !s) return bad(s.error());
    std::optional<Error> failure;
    while (loop_->next_tick() <= end_ && !failure && !(loop_->ticks() > 0 && manager_->shutdown_requested())) {
      Status s = loop_->tick();
      if (!s && s.error().file == spec_.file) return bad(s.error());
      if (!s) failure = s.error();
      result_.sim_time_s = to_seconds(loop_->now());
    }
    if (failure) result_.failures.push_back(failure->text());
    for (const Expectation& e : spec_.expect) judge(e);
    count_rules();
    if (Status s = manager_->deactivate(); !s && !failure) result_.failures.push_back(s.error().text());
    result_.notes = std::move(leaks_.found);
    return std::move(result_);
  }

 protected:
  Status begin() {
    if (Status s = manager_->configure(); !s)
      return input_error(s.error().message, s.error().file, s.error().line).with_code(s.error().code);
    if (Status s = find_environment(); !s) return s;
    return manager_->activate();
  }
  FactText copy_of(const FactCopy& copy) const {
    FactText fact{copy.template_name, {}};
    for (const auto& [name, value] : copy.slots) {
      fact.slots.emplace_back(name, std::vector<std::string>());
      if (!value.is(ValueType::kMultifield)) fact.slots.back().second.push_back(value.print());
      for (const Value& item : value.items()) fact.slots.back().second.push_back(item.print());
    }
    return fact;
  }

  StoryResult bad(const Error& error) {
    result_.bad = error;
    return std::move(result_);
  }
  StoryResult broken(const Error& error) {
    result_.failures.push_back(error.text());
    return std::move(result_);
  }
  Error at(int line, const std::string& what) const { return input_error(what, spec_.file, line); }

  Status prepare() {
    if (Status s = registry_.add_packages_in(setup_.interfaces); !s) return s;
    cx::ManagerOptions options;
    std::map<std::string, fs::path> packages = spec_.packages;
    packages.insert(setup_.packages.begin(), setup_.packages.end());
    for (const auto& [name, folder] : packages) {
      if (!fs::is_directory(folder))
        return at(spec_.line, "package " + name + ": there is no folder " + folder.string());
      options.packages[name] = {folder, {}};
      if (!bus::holds_definitions(folder)) continue;
      if (Status s = registry_.add_package(name, folder); !s) return s;
    }
    auto config = config_file();
    if (!config) return config.error();
    options.config = *config;
    options.plugin_types = cx::builtin_plugins();
    options.log = &leaks_;
    options.seed = spec_.seed;
    auto manager = cx::EnvironmentManager::create(std::move(options), bus_, watches_);
    if (!manager) return manager.error();
    manager_ = *std::move(manager);
    end_ = spec_.end;
    for (const Step& step : spec_.steps) end_ = std::max(end_, step.at);
    for (const Expectation& e : spec_.expect)
      end_ = std::max({end_, e.after, e.until == kNever ? SimTime::zero() : e.until});
    end_ = tick_not_before(end_, kTick);
    loop_.emplace(bus_, kTick, Parts{.servers = {&script_, &stand_ins_}, .agents = {manager_.get()}});
    for (const StandIn& stand_in : spec_.stand_ins)
      if (Status s = stand_ins_.add(stand_in); !s) return s;
    for (const Expectation& e : spec_.expect)
      if (e.kind == Expectation::Kind::kPublished)
        if (Status s = stand_ins_.listen(e.text, e.type, spec_.file, e.line); !s) return s;
    return {};
  }

  /// The configuration, or one made for the rule files alone.
  Expected<fs::path> config_file() {
    if (!spec_.config.empty()) return spec_.config;
    std::string files;
    for (const fs::path& file : spec_.rules) {
      if (!fs::is_regular_file(file)) return at(spec_.line, "there is no rule file " + file.string());
      files += (files.empty() ? "'" : ", '") + fs::absolute(file).lexically_normal().string() + '\'';
    }
    auto scratch = ScratchFolder::create();
    if (!scratch) return scratch.error();
    scratch_ = std::move(*scratch);
    const fs::path made = scratch_->path() / "story.yaml";
    std::ofstream(made)
        << "/**:\n  ros__parameters:\n    environments: [main]\n    main: {plugins: [executive, ros_msgs, files]}\n"
           "    executive: {plugin: 'cx::ExecutivePlugin'}\n    ros_msgs: {plugin: 'cx::RosMsgsPlugin'}\n"
           "    files: {plugin: 'cx::FileLoadPlugin', load: ["
        << files << "]}\n";
    return made;
  }

  Status find_environment() {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < manager_->size(); ++i) names.push_back(manager_->environment(i).name());
    if (spec_.environment.empty() && !names.empty())
      environment_ = &manager_->environment(0);
    else
      environment_ = manager_->find(spec_.environment);
    if (!environment_)
      return at(spec_.line, "environment '" + spec_.environment + "' is not in the configuration" +
                                did_you_mean(spec_.environment, names));
    watches_.choose(environment_->name());
    if (setup_.coverage) environment_->engine().watch("activations");
    return {};
  }

  /// Rules, actions and patterns that can never be met are mistakes of the story.
  Status check_names() {
    std::vector<std::string> rules;
    for (const ConstructInfo& c : environment_->engine().constructs())
      if (c.kind == "defrule") rules.push_back(c.name);
    for (const Expectation& e : spec_.expect) {
      using Kind = Expectation::Kind;
      if (e.kind == Kind::kFact || e.kind == Kind::kNoFact) {
        auto pattern = FactPattern::parse(e.text, spec_.file, e.line);
        if (!pattern) return pattern.error();
      } else if (e.kind == Kind::kFires || e.kind == Kind::kNotFires) {
        if (std::find(rules.begin(), rules.end(), e.text) == rules.end())
          return at(e.line, "there is no rule '" + e.text + '\'' + did_you_mean(e.text, rules));
      } else if (e.kind == Kind::kGoal) {
        const bool later = std::any_of(spec_.steps.begin(), spec_.steps.end(),
                                       [&](const Step& s) { return s.stand_in.name == e.text; });
        if (!later && !stand_ins_.serves(e.text))
          return at(e.line,
                    "nobody serves " + e.text + did_you_mean(e.text, stand_ins_.names()) + " (skills: of the story)");
      }
    }
    return {};
  }

  Status assert_fact(const std::string& text, int line) {
    environment_->engine().clear_cause();
    auto fact = environment_->engine().assert_string(text);
    if (!fact) return at(line, text + ": " + fact.error().message);
    return {};
  }

  /// The steps of the story in their place of a tick.
  class Script final : public Server {
   public:
    explicit Script(Play& play) : play_(play) {}
    Status sense(SimTime now) override {
      for (; next_ < steps().size() && steps()[next_].at <= now; ++next_)
        if (Status s = play_.do_step(steps()[next_]); !s) return s;
      return {};
    }
    Status act(SimTime) override { return {}; }
    SimTime next_due() const override {
      if (play_.each_tick_) return SimTime::zero();
      return next_ < steps().size() ? steps()[next_].at : kNever;
    }

   private:
    const std::vector<Step>& steps() const { return play_.spec_.steps; }
    Play& play_;
    std::size_t next_ = 0;
  };

  Status do_step(const Step& step) {
    switch (step.verb) {
      case Step::Verb::kAssert: return assert_fact(step.text, step.line);
      case Step::Verb::kPublish: return stand_ins_.publish(step.text, step.type, step.data, spec_.file, step.line);
      case Step::Verb::kStandIn: return stand_ins_.add(step.stand_in);
      case Step::Verb::kRetract: break;
    }
    auto pattern = FactPattern::parse(step.text, spec_.file, step.line);
    if (!pattern) return pattern.error();
    bool any = false;
    for (const FactCopy& copy : environment_->engine().facts(pattern->template_name())) {
      if (pattern->matches(copy_of(copy))) any |= environment_->engine().retract(copy.index);
    }
    if (any) return {};
    return negative(spec_.file + ':' + std::to_string(step.line) + ": retract " + step.text + " at " +
                    seconds(bus_.now()) + ": there is no such fact");
  }

  void fail(const Expectation& e, const std::string& what) { result_.failures.push_back(at(e.line, what).text()); }
  static std::string span(const Expectation& e) {
    if (e.at) return " at " + seconds(e.until);
    std::string out = e.after > SimTime::zero() ? " after " + seconds(e.after) : "";
    if (e.until != kNever) out += " by " + seconds(e.until);
    return out;
  }
  static bool within(const Expectation& e, SimTime t) { return t >= e.after && t <= e.until; }

  void judge(const Expectation& e) {
    switch (e.kind) {
      case Expectation::Kind::kFact:
      case Expectation::Kind::kNoFact: return judge_fact(e);
      case Expectation::Kind::kFires:
      case Expectation::Kind::kNotFires: return judge_rule(e);
      case Expectation::Kind::kGoal: return judge_heard(e, Heard::Kind::kGoal, "goal");
      case Expectation::Kind::kPublished: return judge_heard(e, Heard::Kind::kTopic, "message");
    }
  }

  void judge_fact(const Expectation& e) {
    const auto pattern = FactPattern::parse(e.text, spec_.file, e.line);
    const FactVersion *found = nullptr, *near = nullptr;
    for (const FactVersion& version : watches_.facts()) {
      if (version.fact.template_name != pattern->template_name()) continue;
      const bool there = e.at ? version.from <= e.until && version.until > e.until
                              : version.from <= e.until && (version.until > e.after || version.from >= e.after);
      if (there && pattern->matches(version.fact))
        found = found ? found : &version;
      else if (!near || pattern->closeness(version.fact) >= pattern->closeness(near->fact))
        near = &version;
    }
    if (e.kind == Expectation::Kind::kNoFact) {
      if (found)
        fail(e, "expected no fact " + e.text + span(e) + "; there was " + found->fact.print() + " from " +
                    seconds(found->from));
      else if (!environment_->engine().has("deftemplate", pattern->template_name()) && !near)
        fail(e, "there is no deftemplate '" + pattern->template_name() + "', so this says nothing" +
                    did_you_mean(pattern->template_name(), templates()));
      else if (near && !slots_known(*pattern, near->fact))
        fail(e, e.text + ": " + pattern->difference(near->fact));
      return;
    }
    if (found) return;
    std::string what = "expected fact " + e.text + span(e);
    if (near) {
      const std::string difference = pattern->difference(near->fact);
      what += "; nearest: " + near->fact.print() + " at " + seconds(near->from) +
              (near->until == kNever ? "" : " until " + seconds(near->until)) +
              (difference.empty() ? ", at another time" : ": " + difference);
    } else {
      what += environment_->engine().has("deftemplate", pattern->template_name())
                  ? "; there was no fact of this template"
                  : "; there is no deftemplate '" + pattern->template_name() + '\'' +
                        did_you_mean(pattern->template_name(), templates());
    }
    fail(e, what);
  }

  static bool slots_known(const FactPattern& pattern, const FactText& fact) {
    const auto names = pattern.slot_names();
    return std::all_of(names.begin(), names.end(), [&](const std::string& name) {
      return std::any_of(fact.slots.begin(), fact.slots.end(), [&](const auto& slot) { return slot.first == name; });
    });
  }

  std::vector<std::string> templates() const {
    std::vector<std::string> out;
    for (const ConstructInfo& c : environment_->engine().constructs())
      if (c.kind == "deftemplate") out.push_back(c.name);
    return out;
  }

  void judge_rule(const Expectation& e) {
    int inside = 0;
    std::string times;
    for (const Firing& firing : watches_.firings()) {
      if (firing.rule != e.text) continue;
      inside += within(e, firing.t);
      if (times.size() < 60) times += (times.empty() ? "" : ", ") + seconds(firing.t);
    }
    if (e.kind == Expectation::Kind::kNotFires) {
      if (inside > 0) fail(e, "expected that rule " + e.text + " does not fire" + span(e) + "; it fired at " + times);
      return;
    }
    if (inside >= e.count) return;
    std::string what = "expected rule " + e.text + " to fire" +
                       (e.count > 1 ? " " + std::to_string(e.count) + " times" : "") + span(e);
    if (!times.empty()) return fail(e, what + "; it fired at " + times);
    what += "; it never fired";
    if (const auto matches = environment_->engine().matches(e.text); matches && !matches->empty())
      for (const RuleMatches::Pattern& p : matches->front().patterns)
        if (p.partial == 0) {
          what += ": at the end its condition " + std::to_string(p.condition) + " held " +
                  (p.matches == 0 ? "for no fact" : "for no combination of facts");
          break;
        }
    fail(e, what);
  }

  void judge_heard(const Expectation& e, Heard::Kind kind, const std::string& word) {
    int inside = 0;
    const Heard* last = nullptr;
    for (const Heard& heard : stand_ins_.heard()) {
      if (heard.kind != kind || heard.name != e.text) continue;
      if (within(e, heard.t) && contains(heard.content, e.fields))
        ++inside;
      else
        last = &heard;
    }
    if (inside >= e.count) return;
    std::string what = "expected " + (e.count > 1 ? std::to_string(e.count) + " times a " : std::string("a ")) + word +
                       " for " + e.text;
    if (!e.fields.empty()) what += " with " + e.fields;
    what += span(e) + "; ";
    if (e.count > 1) what += "there were " + std::to_string(inside) + "; ";
    what += last ? "nearest: " + last->content + " at " + seconds(last->t) : "there was no other";
    fail(e, what);
  }

  void count_rules() {
    for (const ConstructInfo& c : environment_->engine().constructs())
      if (c.kind == "defrule" && c.line > 0 && fs::path(c.file).is_absolute())
        result_.rules.push_back({c.file, c.name, c.line,
                                 std::count_if(watches_.firings().begin(), watches_.firings().end(),
                                               [&](const Firing& f) { return f.rule == c.name; }),
                                 leaks_.activated[c.name]});
  }

  const StorySpec& spec_;
  const StorySetup& setup_;
  std::unique_ptr<ScratchFolder> scratch_;
  Leaks leaks_;
  Watch watches_;
  bus::Registry registry_;
  bus::Bus bus_{registry_, watches_};
  StandIns stand_ins_{bus_, watches_};
  std::unique_ptr<cx::EnvironmentManager> manager_;
  cx::Environment* environment_ = nullptr;
  Script script_{*this};
  std::optional<Loop> loop_;
  bool each_tick_ = false;  // also those at which nothing is due
  SimTime end_{};
  StoryResult result_;
};

}  // namespace

StoryResult run_story(const StorySpec& spec, const StorySetup& setup) { return Play(spec, setup).run(); }

// --- Step by step

/// The story's specification, which `Play` refers to, comes first.
struct StoryOwner {
  StorySpec owned_spec;
  StorySetup owned_setup;
};

struct Story::Stage : StoryOwner, Play {
  Stage(StorySpec spec, StorySetup setup, Report told)
      : StoryOwner{std::move(spec), std::move(setup)}, Play(owned_spec, owned_setup), report(std::move(told)) {
    each_tick_ = true;
  }

  Report report;
  Where begun;
  bool usable = false;
  SimTime patience = std::chrono::seconds(10);
  std::vector<bool> met;  // goals heard, by their place

  void check(const Status& status, const Where& where) {
    if (!status) report(where, status.error().text());
  }
  void open(const Where& where) {
    begun = where;
    Status s = prepare();
    if (s) s = begin();
    usable = static_cast<bool>(s);
    check(s, where);
  }
  void step(const Where& where) {
    Status s = loop_->tick();
    usable = static_cast<bool>(s);
    check(s, where);
  }
  /// Time of the tick that comes next.
  SimTime now() const { return loop_ ? loop_->next_tick() : SimTime::zero(); }
  /// Time goes on until `done`, at most until `until`.
  template <typename Done>
  bool wait(SimTime until, const Where& where, const Done& done) {
    while (usable) {
      if (done()) return true;
      if (now() > until) return false;
      step(where);
    }
    return true;  // what is wrong has been reported
  }
  const FactCopy* find(const FactPattern& pattern) {
    found_ = environment_->engine().facts(pattern.template_name());
    const auto at = std::find_if(found_.begin(), found_.end(),
                                 [&](const FactCopy& copy) { return pattern.matches(copy_of(copy)); });
    return at == found_.end() ? nullptr : &*at;
  }
  void end_goal(const std::string& action, Outcome::Kind kind, const std::string& result, const Where& where) {
    if (!usable) return;
    Outcome outcome;
    outcome.kind = kind;
    outcome.result = result;
    const auto ended = stand_ins_.end_goal(action, outcome);
    if (!ended)
      report(where, ended.error().text());
    else if (!*ended)
      report(where, action + " has taken no goal that it could end");
  }

  std::vector<FactCopy> found_;
  using Play::assert_fact, Play::copy_of, Play::environment_, Play::stand_ins_, Play::manager_;
};

Story::Story(StorySpec spec, StorySetup setup, Report report, Where where)
    : stage_(std::make_unique<Stage>(std::move(spec), std::move(setup), std::move(report))) {
  if (stage_->owned_spec.file.empty()) stage_->owned_spec.file = where.file_name();
  stage_->open(where);
}

Story::~Story() {
  if (stage_->usable) stage_->check(stage_->manager_->deactivate(), stage_->begun);
}

void Story::skill(const std::string& action, const std::string& type, Where where) {
  StandIn stand_in{true, action, type, {Outcome{}}, where.file_name(), static_cast<int>(where.line())};
  stand_in.outcomes.front().kind = Outcome::Kind::kNever;
  if (stage_->usable) stage_->check(stage_->stand_ins_.add(stand_in), where);
}

void Story::given(const std::string& fact, Where where) {
  if (!stage_->usable) return;
  const Status s = stage_->assert_fact(fact, static_cast<int>(where.line()));
  if (!s) stage_->environment_->engine().take_errors();  // reported here, not by the next run
  stage_->check(s, where);
}

void Story::pass(double seconds, Where where) {
  stage_->wait(stage_->now() + from_seconds(seconds) - kTick, where, [] { return false; });
}

void Story::expect_command(const std::string& robot, const std::string& skill, const std::string& target, Where where) {
  const std::string action = '/' + robot + '/' + skill;
  std::string others;
  const bool came = stage_->wait(stage_->now() + stage_->patience, where, [&] {
    const std::vector<Heard>& heard = stage_->stand_ins_.heard();
    stage_->met.resize(heard.size());
    others.clear();
    for (std::size_t i = 0; i < heard.size(); ++i) {
      if (heard[i].kind != Heard::Kind::kGoal || stage_->met[i]) continue;
      if (heard[i].name == action && contains(heard[i].content, "{target: '" + target + "'}"))
        return static_cast<bool>(stage_->met[i] = true);
      others += (others.empty() ? "" : ", ") + heard[i].name + ' ' + heard[i].content + " at " + seconds(heard[i].t);
    }
    return false;
  });
  if (!came)
    stage_->report(where, "expected " + action + " for " + target + " by " + seconds(stage_->now()) + "; " +
                              (others.empty() ? "no other goal came" : "there came " + others));
}

void Story::expect_fact(const std::string& text, Where where) {
  const auto pattern = FactPattern::parse(text, where.file_name(), static_cast<int>(where.line()));
  if (!pattern) return stage_->report(where, pattern.error().text());
  if (stage_->wait(stage_->now() + stage_->patience, where, [&] { return stage_->find(*pattern) != nullptr; })) return;
  std::string what = "expected fact " + text + " by " + seconds(stage_->now());
  for (const FactCopy& copy : stage_->found_)
    what += "\n  there is " + copy.print() + ": " + pattern->difference(stage_->copy_of(copy));
  stage_->report(where, what);
}

void Story::expect_no_fact(const std::string& text, Where where) {
  const auto pattern = FactPattern::parse(text, where.file_name(), static_cast<int>(where.line()));
  if (!pattern) return stage_->report(where, pattern.error().text());
  if (!stage_->usable) return;
  if (const FactCopy* fact = stage_->find(*pattern))
    stage_->report(where, "expected no fact " + text + "; there is " + fact->print());
  else if (!stage_->environment_->engine().has("deftemplate", pattern->template_name()))
    stage_->report(where, "there is no deftemplate '" + pattern->template_name() + "', so this says nothing");
}

void Story::skill_succeeds(const std::string& robot, const std::string& skill, Where where) {
  stage_->end_goal('/' + robot + '/' + skill, Outcome::Kind::kSucceed, {}, where);
}

void Story::skill_fails(const std::string& robot, const std::string& skill, int error_code, Where where) {
  stage_->end_goal('/' + robot + '/' + skill, Outcome::Kind::kFail, "{error_code: " + std::to_string(error_code) + '}',
                   where);
}

void Story::set_patience(double seconds) { stage_->patience = from_seconds(seconds); }
double Story::now_s() const { return to_seconds(stage_->now()); }

}  // namespace cxlab::testing
