#include "cx/testing/play.h"

#include <cstdio>
#include <fstream>

#include "cx/base/file.h"
#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "cx/plugins/builtin.h"

namespace cxlab::testing {

namespace fs = std::filesystem;

std::string seconds(SimTime t) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", to_seconds(t));
  return text;
}

Play::Play(const StorySpec& spec, const StorySetup& setup, bool each_tick)
    : spec_(spec), setup_(setup), each_tick_(each_tick), limits_(setup.limits) {
  journal_.observe(histories_);
}

Status Play::sense(SimTime now) {
  for (; next_step_ < spec_.steps.size() && spec_.steps[next_step_].at <= now; ++next_step_)
    if (Status s = do_step(spec_.steps[next_step_]); !s) return s;
  return {};
}

SimTime Play::next_due() const {
  if (each_tick_) return SimTime::zero();
  return next_step_ < spec_.steps.size() ? spec_.steps[next_step_].at : kNever;
}

void Play::line(const cx::LogLine& line) {
  if (line.level == cx::LogLevel::kWarn && line.text.find("cleaning up") != std::string_view::npos)
    left_open_.emplace_back(line.text);
}

Status Play::prepare() {
  if (Status s = registry_.add_packages_in(setup_.interfaces); !s) return s;
  cx::ManagerOptions options;
  std::map<std::string, fs::path> packages = spec_.packages;
  packages.insert(setup_.packages.begin(), setup_.packages.end());
  for (const auto& [name, folder] : packages) {
    if (!is_folder(folder)) return at(spec_.line, "package " + name + ": there is no folder " + folder.string());
    const auto own = setup_.own_packages.find(name);
    options.packages[name] = {folder, {}, own == setup_.own_packages.end() || own->second == folder ? "" : own->second};
    if (!bus::holds_definitions(folder)) continue;
    if (Status s = registry_.add_package(name, folder); !s) return s;
  }
  auto config = config_file();
  if (!config) return config.error();
  options.config = *config;
  options.params = spec_.params;
  options.plugin_types = cx::builtin_plugins();
  options.log = this;
  options.limits = &limits_;
  options.seed = spec_.seed;
  options.count_activations = setup_.coverage;
  auto manager = cx::EnvironmentManager::create(std::move(options), bus_, journal_);
  if (!manager) return manager.error();
  manager_ = *std::move(manager);
  scratch_.reset();
  for (const StandIn& stand_in : spec_.stand_ins)
    if (Status s = stand_ins_.add(stand_in); !s) return s;
  for (const Expectation& e : spec_.expect)
    if (e.kind == Expectation::Kind::kPublished)
      if (Status s = stand_ins_.listen(e.text, e.type, spec_.file, e.line); !s) return s;
  if (Status s = check_contents(); !s) return s;
  loop_.emplace(bus_, kTick, Parts{.servers = {this, &stand_ins_}, .agents = {manager_.get()}});
  return {};
}

Wall Play::wall() const {
  Wall wall;
  wall.read = {setup_.interfaces};
  manager_->add_reach(wall);
  return wall;
}

/// Before anything happens: what is sent and expected has the fields of its type.
Status Play::check_contents() const {
  std::vector<const StandIn*> served;
  for (const StandIn& stand_in : spec_.stand_ins) served.push_back(&stand_in);
  for (const Step& step : spec_.steps) {
    Status fits;
    if (step.verb == Step::Verb::kStandIn)
      fits = stand_ins_.check(*served.emplace_back(&step.stand_in));
    else if (step.verb == Step::Verb::kPublish)
      fits = stand_ins_.check_message(step.text, step.type, step.data, spec_.file, step.line);
    if (!fits) return fits;
  }
  for (const Expectation& e : spec_.expect) {
    Status fits;
    if (e.kind == Expectation::Kind::kPublished)
      fits = stand_ins_.check_message(e.text, e.type, e.fields, spec_.file, e.line);
    else if (e.kind == Expectation::Kind::kGoal)
      for (const StandIn* stand_in : served)
        if (stand_in->action && stand_in->name == e.text && fits)
          fits = stand_ins_.check_goal(*stand_in, e.fields, spec_.file, e.line);
    if (!fits) return fits;
  }
  return {};
}

/// The configuration, or one made for the rule files alone.
Expected<fs::path> Play::config_file() {
  if (!spec_.config.empty()) return spec_.config;
  std::string files;
  for (const fs::path& file : spec_.rules) {
    if (!is_file(file)) return at(spec_.line, "there is no rule file " + file.string());
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

Status Play::begin() {
  if (Status s = manager_->configure(); !s)
    return input_error(s.error().message, s.error().file, s.error().line).with_code(s.error().code);
  if (Status s = find_environment(); !s) return s;
  return manager_->activate();
}

Status Play::find_environment() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < manager_->size(); ++i) names.push_back(manager_->environment(i).name());
  if (spec_.environment.empty() && !names.empty())
    environment_ = &manager_->environment(0);
  else
    environment_ = manager_->find(spec_.environment);
  if (!environment_)
    return at(spec_.line, "environment '" + spec_.environment + "' is not in the configuration" +
                              did_you_mean(spec_.environment, names));
  history_ = &history_of(engine());
  return {};
}

Status Play::assert_fact(const std::string& text, int line) {
  engine().clear_cause();
  auto fact = engine().assert_string(text);
  if (!fact) return at(line, text + ": " + fact.error().message);
  return {};
}

Status Play::do_step(const Step& step) {
  switch (step.verb) {
    case Step::Verb::kAssert: return assert_fact(step.text, step.line);
    case Step::Verb::kPublish: return stand_ins_.publish(step.text, step.type, step.data, spec_.file, step.line);
    case Step::Verb::kStandIn: return stand_ins_.add(step.stand_in);
    case Step::Verb::kRetract: break;
  }
  auto pattern = explain::Pattern::parse_plain(step.text, spec_.file, step.line);
  if (!pattern) return pattern.error();
  if (Status s = explain::check_names(*pattern, engine()); !s)
    return at(step.line, "retract " + step.text + ": " + s.error().message);
  bool any = false;
  for (const FactCopy& fact : engine().facts(pattern->template_name()))
    if (pattern->matches(fact)) any |= engine().retract(fact.index);
  if (any) return {};
  return negative(spec_.file + ':' + std::to_string(step.line) + ": retract " + step.text + " at " +
                  seconds(bus_.now()) + ": there is no such fact");
}

}  // namespace cxlab::testing
