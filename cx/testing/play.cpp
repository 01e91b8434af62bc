#include "cx/testing/play.h"

#include <cstdio>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/plugins/builtin.h"

namespace cxlab::testing {

namespace fs = std::filesystem;

std::string seconds(SimTime t) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", to_seconds(t));
  return text;
}

Play::Play(const StorySpec& spec, const StorySetup& setup, bool each_tick)
    : spec_(&spec), setup_(setup), each_tick_(each_tick), limits_(setup.limits) {
  journal_.observe(histories_);
}

void Play::line(const cx::LogLine& line) {
  if (line.level == cx::LogLevel::kWarn && line.text.find("cleaning up") != std::string_view::npos)
    left_open_.emplace_back(line.text);
  if (line.level == cx::LogLevel::kDebug) return;
  std::string text = '[' + fixed_text(to_seconds(line.t), 3) + "] [" + std::string(line.logger) + "] ";
  if (line.level != cx::LogLevel::kInfo) text += '[' + std::string(to_string(line.level)) + "] ";
  printed_.push_back(text.append(line.text));
  if (printed_.size() > kMostLines) printed_.pop_front();
}

void Play::note_file(const fs::path& file) { files_.insert(fs::absolute(file).lexically_normal().string()); }

Status Play::prepare() {
  if (!spec_->config.empty()) note_file(spec_->config);
  for (const fs::path& file : spec_->rules) note_file(file);
  if (Status s = registry_.add_packages_in(setup_.interfaces); !s) return s;
  cx::ManagerOptions options;
  std::map<std::string, fs::path> packages = spec_->packages;
  packages.insert(setup_.packages.begin(), setup_.packages.end());
  for (const auto& [name, folder] : packages) {
    if (!is_folder(folder)) return at(spec_->line, "package " + name + ": there is no folder " + folder.string());
    const auto own = setup_.own_packages.find(name);
    options.packages[name] = {folder, {}, own == setup_.own_packages.end() || own->second == folder ? "" : own->second};
    if (!bus::holds_definitions(folder)) continue;
    if (Status s = registry_.add_package(name, folder); !s) return s;
  }
  auto config = config_file();
  if (!config) return config.error();
  options.config = *config;
  options.params = spec_->params;
  options.plugin_types = cx::builtin_plugins();
  options.control = &facts_;
  options.log = this;
  options.on_read = [this, made = spec_->config.empty() ? *config : fs::path()](const std::string&,
                                                                                const fs::path& file) -> Status {
    if (file != made) note_file(file);
    return {};
  };
  options.limits = &limits_;
  options.instead = setup_.instead;
  options.seed = spec_->seed;
  if (setup_.coverage) {
    options.counting = Counting::kUse;
    options.on_environment_end = [this](const cx::Environment& environment) {
      coverage_.add(explain::coverage_of(environment.engine().counts(), [](const std::string& file) { return file; }));
    };
  }
  auto manager = cx::EnvironmentManager::create(std::move(options), bus_, journal_);
  if (!manager) return manager.error();
  manager_ = *std::move(manager);
  scratch_.reset();
  mistakes_in_messages_ = set_up(stand_ins_, *spec_);
  loop_.emplace(bus_, spec_->tick, Parts{.servers = {this, &steps_, &stand_ins_}, .agents = {manager_.get()}});
  loop_->set_begin(spec_->begins);
  return {};
}

Status Play::end() {
  const Status ended = manager_->deactivate();
  for (const Error& parameter : manager_->unread_parameters()) unread_.push_back(parameter.text());
  leave();
  return ended;
}

void Play::leave() {
  loop_.reset();
  environment_ = nullptr;
  manager_.reset();
}

void Play::go_on_as(const StorySpec& spec) {
  spec_ = &spec;
  steps_.play(spec);
  facts_.play(spec);
  stand_ins_.expect(spec.faults);
  mistakes_in_messages_ = set_up(stand_ins_, spec);
}

Wall Play::wall() const {
  Wall wall;
  wall.read = {setup_.interfaces};
  manager_->add_reach(wall);
  return wall;
}

/// The configuration, or one made for the rule files alone.
Expected<fs::path> Play::config_file() {
  if (!spec_->config.empty()) return spec_->config;
  const auto text = config_for_rules(*spec_);
  if (!text) return text.error();
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  scratch_ = std::move(*scratch);
  const fs::path made = scratch_->path() / "story.yaml";
  if (Status s = write_file(made, *text); !s) return s.error();
  return made;
}

Status Play::begin() {
  if (spec_->begins > SimTime::zero()) bus_.begin_tick(spec_->begins);
  if (Status s = manager_->configure(); !s)
    return limits_.exceeded ? s.error()
                            : input_error(s.error().message, s.error().file, s.error().line).with_code(s.error().code);
  if (Status s = find_environment(); !s) return s;
  return manager_->activate();
}

Status Play::find_environment() {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < manager_->size(); ++i) names.push_back(manager_->environment(i).name());
  if (spec_->environment.empty() && !names.empty())
    environment_ = &manager_->environment(0);
  else
    environment_ = manager_->find(spec_->environment);
  if (!environment_)
    return at(spec_->line, "environment '" + spec_->environment + "' is not in the configuration" +
                               did_you_mean(spec_->environment, names));
  history_ = &history_of(engine());
  return {};
}

Status Play::assert_fact(const std::string& text, int line) {
  engine().clear_cause();
  auto fact = engine().assert_string(text);
  if (!fact) return at(line, text + ": " + fact.error().message);
  return {};
}

}  // namespace cxlab::testing
