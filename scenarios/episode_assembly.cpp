// Makes an episode's parts from its scenario.

#include <algorithm>
#include <set>

#include "cx/bag/bag_server.h"
#include "cx/base/file.h"
#include "cx/bus/needed.h"
#include "cx/network/socket_gateway.h"
#include "cx/plugins/builtin.h"
#include "cx/yaml/yaml.h"
#include "scenarios/acting_stage.h"
#include "scenarios/begin.h"
#include "scenarios/catalogue.h"
#include "scenarios/episode.h"
#include "scenarios/seated_agent.h"
#include "scenarios/share.h"
#include "scenarios/stimuli.h"

namespace cxlab {

namespace fs = std::filesystem;

namespace {

template <class Call>
Status measured(WallMeter& meter, Call call) {
  meter.begin();
  Status done = call();
  meter.end();
  return done;
}

class MeasuredWorld final : public Simulation {
 public:
  MeasuredWorld(std::unique_ptr<Simulation> world, WallMeter& meter) : world_(std::move(world)), meter_(meter) {}
  Status advance(SimTime duration) override {
    return measured(meter_, [&] { return world_->advance(duration); });
  }
  SimTime next_event() const override { return world_->next_event(); }

 private:
  std::unique_ptr<Simulation> world_;
  WallMeter& meter_;
};

class MeasuredServer final : public Server {
 public:
  MeasuredServer(std::unique_ptr<Server> server, WallMeter& meter) : server_(std::move(server)), meter_(meter) {}
  Status sense(SimTime now) override {
    return measured(meter_, [&] { return server_->sense(now); });
  }
  Status act(SimTime now) override {
    return measured(meter_, [&] { return server_->act(now); });
  }
  SimTime next_due() const override { return server_->next_due(); }

 private:
  std::unique_ptr<Server> server_;
  WallMeter& meter_;
};

class MeasuredAgent final : public Agent {
 public:
  MeasuredAgent(Agent& agent, WallMeter& meter) : agent_(agent), meter_(meter) {}
  Status perceive() override {
    return measured(meter_, [&] { return agent_.perceive(); });
  }
  Status decide(SimTime now) override {
    return measured(meter_, [&] { return agent_.decide(now); });
  }
  Status act() override { return agent_.act(); }  // of the node, not of rules
  SimTime next_due() const override { return agent_.next_due(); }

 private:
  Agent& agent_;
  WallMeter& meter_;
};

}  // namespace

Expected<std::unique_ptr<Episode>> Episode::load(Scenario scenario, EpisodeOptions options) {
  std::unique_ptr<Episode> episode(new Episode(std::move(scenario), std::move(options)));
  for (const auto build : {&Episode::open_files, &Episode::build_bus, &Episode::build_stage, &Episode::build_agents,
                           &Episode::build_seats, &Episode::check_stimuli})
    if (Status s = ((*episode).*build)(); !s) return s.error();
  episode->build_loop();
  return episode;
}

Status Episode::open_files() {
  if (options_.replay)
    shares_ = options_.replay->shares;
  else
    for (const AgentSpec& spec : scenario_.agents) {
      shares_.push_back(scenario_.shares(spec));
      if (std::string warning = scenario_.strange_config(spec); !warning.empty())
        strange_configs_.push_back(std::move(warning));
    }
  if (shares_.size() != scenario_.agents.size())
    return input_error("the recorded run has another number of agents", scenario_.file.string());
  auto files = KeptFiles::create(options_.replay ? fs::path() : options_.run_folder, shares_, scenario_.shares({}),
                                 options_.file_read);
  if (!files) return files.error();
  files_.emplace(*std::move(files));
  if (!options_.run_folder.empty())
    if (Status s = journal_.export_to(options_.run_folder / "journal.jsonl", options_.spec.journal); !s) return s;
  for (const WhatIf& change : options_.spec.what_if)
    if (!change.file.empty())
      if (Status s = files_->keep_text(change.copy, change.text); !s) return s;
  return files_->keep_text("scenario.yaml", scenario_.text.empty() ? scenario_.to_yaml() : scenario_.text);
}

Status Episode::build_bus() {
  if (is_folder(options_.interfaces)) bus::set_own_definitions(options_.interfaces);
  const bool replays = options_.replay.has_value();
  const fs::path interfaces = replays ? interfaces_below(options_.replay->copies) : options_.interfaces;
  if (!replays || is_folder(interfaces))
    if (Status s = registry_.add_packages_in(interfaces); !s) return s;
  std::map<std::string, PackageSpec> packages = scenario_.packages;
  for (const AgentSpec& agent : scenario_.agents) packages.insert(agent.packages.begin(), agent.packages.end());
  if (!replays)
    for (const auto& [name, package] : packages) {
      const fs::path folder = scenario_.resolve(package.folder);
      if (!is_folder(folder))
        return input_error("package " + name + ": there is no folder " + folder.string(), package.origin);
      if (!bus::holds_definitions(folder)) continue;
      if (Status s = registry_.add_package(name, folder); !s) return s;
    }
  bus_ = std::make_unique<bus::Bus>(registry_, journal_);
  bus_->mute(replays);
  network_ = std::make_unique<net::Network>(*bus_, journal_);
  bus_->on_rivals([this, replays](const std::string& text) {
    if (options_.log && !replays) options_.log->line({bus_->now(), cx::LogLevel::kWarn, "bus", text, {}});
  });
  inputs_ = std::make_unique<Inputs>();
  if (!replays && options_.run_folder.empty()) return {};
  auto inputs = replays ? replay_inputs(options_.replay->inputs, *bus_, journal_)
                        : record_inputs(options_.run_folder / "inputs.bin", *bus_, journal_);
  if (!inputs) return inputs.error();
  inputs_ = *std::move(inputs);
  return {};
}

Status Episode::build_stage() {
  stage_ = std::make_unique<Stage>();
  if (options_.replay) return {};
  const StageSetup setup{
      .scenario = scenario_,
      .bus = *bus_,
      .sink = journal_,
      .network = network_.get(),
      .log = options_.log,
      .models = options_.models,
      .run_folder = options_.run_folder,
      .programs = options_.spec.programs,
      .keep = [this](const std::string& name, const fs::path& file) { return files_->keep("nodes/" + name, file); }};
  for (const auto& [key, file] : scenario_.world_files) {
    if (!path_exists(file.path))
      return input_error("world." + key + ": there is no file " + file.path.string(), file.origin);
    if (Status s = files_->keep(kept_name(key, file), file.path); !s) return s;
  }
  const WorldKind& world = *scenario_.world.kind;
  if (world.make_stage) {
    auto stage = world.make_stage(setup);
    if (!stage)
      return at(scenario_.world.origin ? scenario_.world.origin : Origin{scenario_.file.string()}, stage.error());
    stage_ = *std::move(stage);
  }
  for (const fs::path& file : stage_->files)
    if (Status s = files_->keep("models/" + file.filename().string(), file); !s) return s;
  const std::size_t of_the_world = stage_->servers.size();
  for (const ServerSpec& server : scenario_.servers) {
    if (Status s = server.kind->add(server, setup, *stage_); !s) return at(server.origin, s.error());
    const std::vector<std::string> names = bus_->nodes();
    if (const auto twice = std::ranges::adjacent_find(names); twice != names.end())
      return input_error(found_expected("a second node '" + *twice + "'", "another `name` or `namespace`"),
                         server.origin);
  }
  if (WallMeter* meter = options_.meters.physics)
    for (auto& moving : stage_->worlds) moving = std::make_unique<MeasuredWorld>(std::move(moving), *meter);
  if (WallMeter* meter = options_.meters.nodes)
    for (std::size_t i = of_the_world; i < stage_->servers.size(); ++i)
      stage_->servers[i] = std::make_unique<MeasuredServer>(std::move(stage_->servers[i]), *meter);
  if (!options_.run_folder.empty() && options_.spec.journal != JournalLevel::kNone && !stage_->scenes.empty()) {
    auto log = SceneWriter::create(options_.run_folder / "scene.bin");
    if (!log) return log.error();
    scene_log_ = *std::move(log);
  }
  for (const auto build : {&Episode::build_stimuli, &Episode::build_bag})
    if (Status s = (this->*build)(); !s) return s;
  return options_.spec.sockets ? open_sockets() : Status();
}

Status Episode::open_sockets() {
  auto gateway = net::SocketGateway::create(*network_, journal_, [this](const std::string& line) {
    if (options_.log) options_.log->line({bus_->now(), cx::LogLevel::kError, "sockets", line, {}});
  });
  if (!gateway) return gateway.error();
  stage_->servers.push_back(*std::move(gateway));
  return {};
}

std::vector<std::string> Episode::manager_names() const {
  std::vector<std::string> names;
  for (const AgentSpec& agent : scenario_.agents) names.push_back(manager_node(agent).full_name());
  return names;
}

Status Episode::build_stimuli() {
  if (scenario_.stimuli.empty()) return {};
  auto stimuli =
      StimuliServer::create(scenario_.stimuli, manager_names(), *bus_, journal_, [this](const std::string& line) {
        if (options_.log) options_.log->line({bus_->now(), cx::LogLevel::kInfo, "stimuli", line, {}});
      });
  if (!stimuli) return stimuli.error();
  stage_->servers.insert(stage_->servers.begin(), *std::move(stimuli));
  return {};
}

Status Episode::build_bag() {
  const bag::BagSpec& spec = scenario_.bag;
  if (!spec) return {};
  auto recording = bag::Recording::open(scenario_.resolve(spec.file));
  if (!recording) return at(spec.origin, recording.error());
  bag::BagSetup setup{
      .spec = spec, .recording = *std::move(recording), .managers = manager_names(), .beside = {}, .log = {}};
  if (!scenario_.stimuli.empty()) setup.beside.push_back(*bus_->find_node("/stimuli"));
  setup.log = [this](bool warning, const std::string& line) {
    if (options_.log)
      options_.log->line({bus_->now(), warning ? cx::LogLevel::kWarn : cx::LogLevel::kInfo, "bag", line, {}});
  };
  auto server = bag::BagServer::create(std::move(setup), *bus_, journal_);
  if (!server) return at(spec.origin, server.error());
  stage_->reports.push_back([bag = server->get()](Result& result) {
    for (std::string& warning : bag->warnings()) result.warnings.push_back("bag: " + std::move(warning));
  });
  stage_->servers.insert(stage_->servers.begin(), *std::move(server));
  return {};
}

cx::ManagerOptions Episode::manager_options(std::size_t agent) {
  const AgentSpec& spec = scenario_.agents[agent];
  cx::ManagerOptions manager;
  manager.one_of_several = scenario_.agents.size() > 1;
  manager.log = options_.log;
  manager.run_folder = options_.run_folder;
  if (rules_folder_) manager.rules_folder = rules_folder_->path();
  manager.network = network_.get();
  manager.seed = scenario_.seed;
  manager.epoch = scenario_.epoch;
  manager.max_firings = scenario_.max_firings_per_tick;
  manager.stop_on_rule_error = scenario_.stop_on_rule_error;
  manager.limits = &limits_;
  static_cast<cx::Conduct&>(manager) = options_.spec;
  manager.counting = options_.counting;
  manager.on_environment_end = options_.on_environment_end;
  manager.trust_rules = scenario_.trust_rules;
  for (const Stimulus& stimulus : scenario_.stimuli)
    if (stimulus.verb == Stimulus::Verb::kSetParam && stimulus.target.ends_with(".plugin"))
      if (const auto value = yaml::Document::parse(stimulus.content, "stimuli"))
        manager.native_classes.push_back(value->root().as_string());
  manager.config = scenario_.resolve(spec.config);
  manager.name_space = spec.name_space;
  manager.remaps = spec.remaps;
  manager.params = spec.params;
  const auto own = own_packages();
  for (const auto& [name, share] : shares_[agent]) {
    cx::Package& package = manager.packages[name] = {share, share};
    if (const auto found = own.find(name); found != own.end() && found->second != share) package.rest = found->second;
  }
  manager.plugin_types = cx::builtin_plugins();
  manager.outside = inputs_->outside("agent/" + std::to_string(agent));
  manager.feed = inputs_->feed();
  manager.control = control_;
  manager.control_log = inputs_->control_log();
  manager.on_read = [this, agent, config = manager.config](const std::string&, const fs::path& file) {
    return files_->keep_for_agent(agent, config, file);
  };
  manager.on_join = [this](bus::ParticipantId participant) { inputs_->watch(participant); };
  if (options_.replay) {
    read_from_copies(options_.replay->copies, agent, manager);
    manager.recorded_folder = options_.replay->folder;
  }
  return manager;
}

Status Episode::build_agents() {
  const auto* acting = dynamic_cast<const ActingStage*>(stage_.get());
  control_ = acting ? acting->control.get() : options_.control;
  if (acting && options_.control) control_ = &both_.emplace(*acting->control, *options_.control);
  if (options_.run_folder.empty()) {
    auto folder = ScratchFolder::create(RemovedBy::kServant);
    if (!folder) return folder.error();
    rules_folder_ = *std::move(folder);
  }
  const fs::path run = rules_folder_ ? rules_folder_->path() : fs::absolute(options_.run_folder).lexically_normal();
  journal_.name_folder(run.string(), "run");
  for (const Shares& shares : shares_)
    for (const auto& [package, folder] : shares) journal_.name_folder(folder, "package://" + package);
  const auto streams = std::make_shared<std::set<std::string>>();
  for (std::size_t i = 0; i < scenario_.agents.size(); ++i) {
    cx::ManagerOptions manager = manager_options(i);
    manager.streams = streams;
    const bus::NodeName name = manager_node(scenario_.agents[i]);
    if (options_.log && bus_->find_node(name.full_name()))
      options_.log->line({bus_->now(),
                          cx::LogLevel::kInfo,
                          name.name,
                          "another node is called " + name.full_name() +
                              " already: its services answer, those of this one do not; a namespace or the remap "
                              "__node:=NAME keeps them apart",
                          {}});
    const std::string config = manager.config.string();
    auto made = cx::EnvironmentManager::create(std::move(manager), *bus_, journal_);
    if (!made) {
      const Origin& named = scenario_.agents[i].config_origin;
      if (made.error().file != config || made.error().line > 0 || named.source.empty()) return made.error();
      return input_error("agents[" + std::to_string(i) + "].config: " + made.error().text(), named);
    }
    agents_.push_back(*std::move(made));
  }
  return {};
}

Status Episode::build_seats() {
  for (const Seat& seat : options_.seats)
    if (!seat.joins_after)
      if (Status s = seat_agent(seat); !s) return s;
  return {};
}

Status Episode::seat_agent(const Seat& seat) {
  auto agent = seated_agent(seat, *bus_, journal_, *inputs_);
  if (!agent) return agent.error();
  seats_.push_back(*std::move(agent));
  return {};
}

Status Episode::check_stimuli() {
  if (options_.replay) return {};
  for (const Stimulus& stimulus : scenario_.stimuli) {
    if (!stimulus.to_a_node_there) continue;
    const std::size_t slash = stimulus.target.rfind('/');
    const std::string service = stimulus.target.substr(slash);  // "/change_state"
    const std::string node = bus::NodeName().expand(stimulus.target.substr(0, slash));
    std::vector<std::string> known;
    for (const auto& offered : bus_->services())
      if (offered.providers > 0 && offered.name.ends_with(service))
        known.push_back(offered.name.substr(0, offered.name.size() - service.size()));
    if (std::ranges::find(known, node) == known.end())
      return usage_error(found_expected("the node '" + node + "'", "one of: " + some_of_and_nearest(node, known)),
                         stimulus.origin.source, stimulus.origin.line);
  }
  return {};
}

bus::NodeName manager_node(const AgentSpec& agent) {
  bus::NodeName name{cx::ManagerOptions().node, agent.name_space, agent.remaps};
  bus::rename_node(name);
  return name;
}

void Episode::build_loop() {
  Parts parts{.referee = stage_->referee};
  for (auto& world : stage_->worlds) parts.worlds.push_back(world.get());
  for (auto& server : stage_->servers) parts.servers.push_back(server.get());
  for (auto& agent : agents_) {
    parts.agents.push_back(agent.get());
    if (!options_.meters.rules) continue;
    measured_.push_back(std::make_unique<MeasuredAgent>(*agent, *options_.meters.rules));
    parts.agents.back() = measured_.back().get();
  }
  for (auto& seat : seats_) parts.agents.push_back(seat.get());
  loop_.emplace(*bus_, scenario_.tick, std::move(parts));
  loop_->set_begin(scenario_.section<Begin>(kBegin).at);
  loop_->set_end(scenario_.duration);
}

}  // namespace cxlab
