#include "scenarios/episode.h"

#include <algorithm>
#include <set>

#include "cx/plugins/builtin.h"
#include "scenarios/nodes.h"
#include "scenarios/rcll/stage.h"
#include "scenarios/stimuli.h"
#include "scenarios/turtlesim/stage.h"

namespace cxlab {

namespace {

/// A world whose steps are measured.
class MeasuredWorld final : public Simulation {
 public:
  MeasuredWorld(std::unique_ptr<Simulation> world, WallMeter& meter) : world_(std::move(world)), meter_(meter) {}
  Status advance(SimTime duration) override {
    meter_.begin();
    Status moved = world_->advance(duration);
    meter_.end();
    return moved;
  }
  SimTime next_event() const override { return world_->next_event(); }

 private:
  std::unique_ptr<Simulation> world_;
  WallMeter& meter_;
};

}  // namespace

Episode::Episode(Scenario scenario, EpisodeOptions options)
    : scenario_(std::move(scenario)), options_(std::move(options)) {}

Episode::~Episode() = default;

Expected<std::unique_ptr<Episode>> Episode::load(Scenario scenario, EpisodeOptions options) {
  std::unique_ptr<Episode> episode(new Episode(std::move(scenario), std::move(options)));
  if (Status s = episode->open_files(); !s) return s.error();
  if (Status s = episode->build_bus(); !s) return s.error();
  if (Status s = episode->build_stage(); !s) return s.error();
  if (Status s = episode->build_agents(); !s) return s.error();
  episode->build_loop();
  return episode;
}

Status Episode::open_files() {
  if (options_.run_folder.empty()) return {};
  if (Status s = journal_.export_to(options_.run_folder / "journal.jsonl", options_.journal); !s) return s;
  if (options_.replay) return {};
  auto inputs = InputLogWriter::create(options_.run_folder / "inputs.bin");
  if (!inputs) return inputs.error();
  inputs_.emplace(*std::move(inputs));
  auto files = FileStore::create(options_.run_folder);
  if (!files) return files.error();
  files_.emplace(*std::move(files));
  return files_->add_content("scenario.yaml", scenario_.text);
}

Status Episode::keep(const std::string& logical_name, const std::filesystem::path& file) {
  if (options_.file_read) options_.file_read(file);
  return files_ ? files_->add(logical_name, file) : Status();
}

/// Copies have names that do not depend on where the files lay: what an agent reads has its number, because two agents
/// may call different folders by one name.
Status Episode::keep_for_agent(std::size_t agent, const std::filesystem::path& file) {
  if (!files_ && !options_.file_read) return {};
  namespace fs = std::filesystem;
  const std::string prefix = "agents/" + std::to_string(agent) + '/';
  const auto inside = [&](const fs::path& folder) {
    const fs::path relative = fs::absolute(file).lexically_normal().lexically_relative(folder);
    return relative.empty() || *relative.begin() == ".." ? std::string() : relative.generic_string();
  };
  if (!inside(fs::absolute(options_.run_folder).lexically_normal() / "written").empty())
    return {};  // rules write it again
  bool in_package = false;
  for (const auto& [name, folder] : shares_[agent]) {
    const std::string relative = inside(folder);
    if (relative.empty()) continue;
    in_package = true;
    if (Status s = keep(prefix + "packages/" + name + '/' + relative, file); !s) return s;
  }
  return in_package ? Status() : keep(prefix + "outside/" + cx::outside_name(file).generic_string(), file);
}

Status Episode::keep_interfaces() {
  if (!files_ && !options_.file_read) return {};
  std::map<std::filesystem::path, std::string> packages;
  for (const auto& [name, folder] : scenario_.shares({})) packages[folder] = name;
  for (const auto& shares : shares_)
    for (const auto& [name, folder] : shares) packages[folder] = name;
  for (const std::filesystem::path& file : registry_.files_read()) {
    std::filesystem::path folder = std::filesystem::absolute(file).parent_path().parent_path().lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();  // of a package "."
    const auto known = packages.find(folder);
    const std::string package = known != packages.end() ? known->second : folder.filename().string();
    if (Status s = keep(
            "interfaces/" + package + '/' + file.parent_path().filename().string() + '/' + file.filename().string(),
            file);
        !s)
      return s;
  }
  return files_ ? files_->write_index() : Status();
}

Status Episode::build_bus() {
  if (options_.replay) return build_replay();
  if (Status s = registry_.add_packages_in(options_.interfaces); !s) return s;
  std::map<std::string, std::string> packages = scenario_.packages;
  std::map<std::string, int> lines = scenario_.package_lines;
  for (const AgentSpec& agent : scenario_.agents) {
    packages.insert(agent.packages.begin(), agent.packages.end());
    lines.insert(agent.package_lines.begin(), agent.package_lines.end());
  }
  for (const auto& [name, folder] : packages) {
    const std::filesystem::path path = scenario_.resolve(folder);
    if (!std::filesystem::is_directory(path))
      return input_error("package " + name + ": there is no folder " + path.string(), scenario_.file.string(),
                         lines[name]);
    if (!bus::holds_definitions(path)) continue;
    if (Status s = registry_.add_package(name, path); !s) return s;
  }
  bus_ = std::make_unique<bus::Bus>(registry_, journal_);
  bus_->on_rivals([this](const std::string& text) {
    if (options_.log) options_.log->line({bus_->now(), cx::LogLevel::kWarn, "bus", text, {}});
  });
  if (inputs_) {
    tap_.emplace(*bus_, journal_, *inputs_);
    bus_->set_input_tap(&*tap_);
  }
  return {};
}

Status Episode::build_replay() {
  const std::filesystem::path interfaces = options_.replay->copies / "interfaces";
  if (std::filesystem::is_directory(interfaces))
    if (Status s = registry_.add_packages_in(interfaces); !s) return s;
  auto log = InputLogReader::open(options_.replay->inputs);
  if (!log) return log.error();
  bus_ = std::make_unique<bus::Bus>(registry_, journal_);
  bus_->mute(true);
  replayer_.emplace(*std::move(log), *bus_, journal_);
  return {};
}

Status Episode::build_stage() {
  if (options_.replay) {
    stage_ = std::make_unique<Stage>();
    return {};
  }
  auto stage = make_stage();
  if (!stage) {
    Error error = stage.error();
    if (error.file.empty()) error.file = scenario_.file.string();
    return error;
  }
  stage_ = *std::move(stage);
  for (const std::filesystem::path& file : stage_->files)
    if (Status s = keep("models/" + file.filename().string(), file); !s) return s;
  const NodeSetup setup{
      scenario_,
      *bus_,
      journal_,
      options_.log,
      options_.run_folder,
      [this](const std::string& name, const std::filesystem::path& file) { return keep("nodes/" + name, file); }};
  for (const ServerSpec& spec : scenario_.servers)
    if (Status s = find_node(spec.node)->add(spec, setup, *stage_); !s) return s;
  if (options_.physics_meter)
    for (auto& world : stage_->worlds)
      world = std::make_unique<MeasuredWorld>(std::move(world), *options_.physics_meter);
  if (scenario_.stimuli.empty()) return {};
  std::vector<std::string> managers;
  for (const AgentSpec& agent : scenario_.agents) {
    bus::NodeName name{cx::ManagerOptions().node, agent.name_space, agent.remaps};
    bus::rename_node(name);
    managers.push_back(name.full_name());
  }
  auto stimuli = StimuliServer::create(scenario_.stimuli, managers, *bus_, journal_, [this](const std::string& line) {
    if (options_.log) options_.log->line({bus_->now(), cx::LogLevel::kInfo, "stimuli", line, {}});
  });
  if (!stimuli) return stimuli.error();
  stage_->servers.insert(stage_->servers.begin(), *std::move(stimuli));
  return {};
}

Expected<std::unique_ptr<Stage>> Episode::make_stage() {
  switch (scenario_.world_kind) {
    case Scenario::WorldKind::kRcll: return rcll::make_stage(scenario_, options_.models, *bus_, journal_);
    case Scenario::WorldKind::kTurtlesim: {
      auto stage =
          turtlesim::TurtleStage::create(scenario_.turtlesim, scenario_.physics_step, *bus_, journal_, options_.log);
      if (!stage) return stage.error();
      return std::unique_ptr<Stage>(*std::move(stage));
    }
    case Scenario::WorldKind::kNone: break;
  }
  return std::make_unique<Stage>();
}

cx::RunSettings Episode::run_settings() const {
  return {.log = options_.log,
          .run_folder = options_.run_folder,
          .seed = scenario_.seed,
          .epoch = scenario_.epoch,
          .max_firings = scenario_.max_firings_per_tick,
          .stop_on_rule_error = scenario_.stop_on_rule_error,
          .keep_going = options_.keep_going,
          .strict = options_.strict,
          .trust_rules = scenario_.trust_rules};
}

Status Episode::build_agents() {
  if (options_.replay)
    shares_ = options_.replay->shares;
  else
    for (const AgentSpec& spec : scenario_.agents) shares_.push_back(scenario_.shares(spec));
  if (shares_.size() != scenario_.agents.size())
    return input_error("the recorded run has another number of agents", scenario_.file.string());
  for (const auto& shares : shares_)
    for (const auto& [package, folder] : shares) journal_.name_folder(folder, "package://" + package);
  const auto streams = std::make_shared<std::set<std::string>>();
  for (const AgentSpec& spec : scenario_.agents) {
    cx::ManagerOptions manager;
    manager.one_of_several = scenario_.agents.size() > 1;
    static_cast<cx::RunSettings&>(manager) = run_settings();
    const std::size_t index = agents_.size();
    const std::string number = std::to_string(index);
    const std::filesystem::path config = scenario_.resolve(spec.config);
    const std::filesystem::path copies =
        options_.replay ? options_.replay->copies / "agents" / number : std::filesystem::path();
    manager.config = options_.replay ? copies / "config" / config.filename() : config;
    manager.name_space = spec.name_space;
    manager.remaps = spec.remaps;
    manager.params = spec.params;
    for (const auto& [name, share] : shares_[index])
      manager.packages[name] = {options_.replay ? copies / "packages" / name : std::filesystem::path(share), share};
    if (options_.replay) manager.outside_copies = copies / "outside";
    manager.streams = streams;
    manager.plugin_types = cx::builtin_plugins();
    manager.outside = make_outside("agent/" + number);
    if (replayer_) manager.feed = &*replayer_;
    manager.on_read = [this, index, config](const std::string&, const std::filesystem::path& file) {
      return file == config ? keep("agents/" + std::to_string(index) + "/config/" + file.filename().string(), file)
                            : keep_for_agent(index, file);
    };
    manager.on_join = [this](bus::ParticipantId participant) {
      if (tap_) tap_->watch(participant);
      if (replayer_) replayer_->watch(participant);
    };
    bus::NodeName name{manager.node, manager.name_space, manager.remaps};
    bus::rename_node(name);
    if (options_.log && bus_->find_node(name.full_name()))
      options_.log->line({bus_->now(),
                          cx::LogLevel::kInfo,
                          name.name,
                          "another node is called " + name.full_name() +
                              " already: its services answer, those of this one do not; a namespace or the remap "
                              "__node:=NAME keeps them apart",
                          {}});
    auto made = cx::EnvironmentManager::create(std::move(manager), *bus_, journal_);
    if (!made) return made.error();
    agents_.push_back(*std::move(made));
  }
  return {};
}

void Episode::build_loop() {
  Parts parts{.referee = stage_->referee};
  for (auto& world : stage_->worlds) parts.worlds.push_back(world.get());
  for (auto& server : stage_->servers) parts.servers.push_back(server.get());
  for (auto& agent : agents_) parts.agents.push_back(agent.get());
  loop_.emplace(*bus_, scenario_.tick, std::move(parts));
  loop_->set_end(scenario_.duration);
}

LookOutside* Episode::make_outside(const std::string& stream) {
  if (replayer_)
    outside_.push_back(std::make_unique<ReplayingOutside>(*replayer_, stream));
  else if (inputs_)
    outside_.push_back(std::make_unique<RecordingOutside>(*bus_, *inputs_, stream));
  else
    return nullptr;
  return outside_.back().get();
}

Status Episode::start() {
  const auto starts = [&](std::size_t i) { return scenario_.agents[i].activate || agents_[i]->autostart(); };
  for (std::size_t i = 0; i < agents_.size(); ++i)
    if (starts(i))
      if (Status s = agents_[i]->configure(); !s) return s;
  for (std::size_t i = 0; i < agents_.size(); ++i)
    if (starts(i))
      if (Status s = agents_[i]->activate(); !s) return s;
  if (Status s = keep_interfaces(); !s) return s;
  return write_out();
}

Status Episode::tick() {
  if (Status s = loop_->tick(); !s) return s;
  return write_out();
}

Status Episode::check_replay() const {
  for (const auto& outside : outside_)
    if (const auto* replaying = dynamic_cast<const ReplayingOutside*>(outside.get()); replaying && replaying->error())
      return *replaying->error();
  return {};
}

Status Episode::all_replayed() const {
  if (!replayer_ || !replayer_->log_status()) return {};
  return replayer_->all_used();
}

Status Episode::write_out() {
  if (Status s = check_replay(); !s) return s;
  if (inputs_) {
    if (std::string bytes = stage_->take_inputs(); !bytes.empty())
      inputs_->add(LoggedWorld{bus_->now(), "world", bytes});
    inputs_->reach(bus_->now());
    if (Status s = inputs_->status(); !s) return s;
  }
  return journal_.status();
}

bool Episode::completed() const { return now() >= scenario_.duration || (stage_->referee && stage_->referee->over()); }

bool Episode::over() const {
  return completed() ||
         std::any_of(agents_.begin(), agents_.end(), [](const auto& agent) { return agent->shutdown_requested(); });
}

Result Episode::close(RunStatus status, std::optional<Error> failure) {
  const auto note = [&](const Status& s) {
    if (!s && !failure) failure = s.error();
  };
  for (auto& agent : agents_) note(agent->deactivate());
  note(write_out());
  for (auto& agent : agents_) {
    note(agent->flush_logs());
    if (!agent->load_errors().empty()) note(agent->load_errors().front());
  }
  note(all_replayed());
  if (inputs_) note(inputs_->close());
  note(journal_.close());
  note(keep_interfaces());
  Result out = result();
  out.status = failure ? RunStatus::kFailed : status;
  out.reason = failure;
  return out;
}

Result Episode::result() const {
  Result out;
  out.scenario = scenario_.name;
  out.seed = scenario_.seed;
  out.tier = scenario_.tier;
  out.has_world = scenario_.world_kind != Scenario::WorldKind::kNone;
  out.sim_time = std::max(now(), SimTime::zero());
  out.ticks = loop_->ticks();
  stage_->report(out);
  for (const auto& report : stage_->reports) report(out);
  for (const auto& agent : agents_) out.deterministic = out.deterministic && agent->deterministic();
  for (const auto& agent : agents_)
    for (const cx::RuleErrorEntry& entry : agent->rule_errors())
      out.rule_errors.push_back({entry.error.rule, entry.error.file, std::string(to_string(entry.error.side)),
                                 entry.error.message, entry.error.line, entry.error.t / scenario_.tick});
  out.journal_hash = journal_.journal_hash();
  for (const Journal::StreamSummary& stream : journal_.streams())
    out.stream_hashes.emplace_back(stream.name, stream.hash);
  return out;
}

}  // namespace cxlab
