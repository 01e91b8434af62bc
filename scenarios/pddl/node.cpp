#include "scenarios/pddl/node.h"

#include "cx/base/append_file.h"
#include "cx/executive/files.h"
#include "planner/manager/manager.h"
#include "scenarios/pddl/config.h"
#include "scenarios/result.h"
#include "scenarios/share.h"

namespace cxlab::pddl {

namespace {

class ManagerServer final : public Server {
 public:
  explicit ManagerServer(std::unique_ptr<planner::PddlManager> manager) : manager_(std::move(manager)) {}
  Status sense(SimTime now) override { return manager_->answer_due(now); }
  Status act(SimTime) override { return manager_->act(); }
  SimTime next_due() const override { return manager_->next_due(); }
  const planner::PddlManager& manager() const { return *manager_; }

 private:
  std::unique_ptr<planner::PddlManager> manager_;
};

/// Below the run's folder, whatever path an agent named.
Status write_below(const std::filesystem::path& run_folder, const std::filesystem::path& file,
                   const std::string& text) {
  const std::filesystem::path path = run_folder / "written" / cx::outside_name(file);
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  auto out = AppendFile::create(path);
  if (!out) return out.error();
  (void)out->append(text);
  return out->close();
}

Status add_manager(const ServerSpec& spec, const StageSetup& setup, Stage& stage) {
  const Config& config = spec.get<Config>();
  planner::PddlManagerOptions options;
  options.node = config.name;
  options.name_space = config.name_space;
  options.remaps = config.remaps;
  options.autostart = config.autostart;
  options.bond_period = config.bond_period;
  options.original = config.compat == "original";
  options.anytime = config.anytime;
  options.warm_start = config.warm_start;
  options.other = config.engine.empty()
                      ? planner::ExternalPlanner{config.command, false}
                      : planner::up_engine(find_share().engines / "up_engine.py", config.python, config.engine);
  options.cost = config.cost.value_or(setup.scenario.planner);
  options.log = setup.log;
  options.on_read = setup.keep;
  options.resolve = [&scenario = setup.scenario](const std::string& directory) { return scenario.resolve(directory); };
  if (!setup.run_folder.empty())
    options.write = [folder = setup.run_folder](const std::filesystem::path& file, const std::string& text) {
      return write_below(folder, file, text);
    };
  auto manager = planner::PddlManager::create(std::move(options), setup.bus, setup.sink);
  if (!manager) return manager.error();
  auto server = std::make_unique<ManagerServer>(*std::move(manager));
  stage.reports.push_back(
      [&node = server->manager(), outside = !config.command.empty() || !config.engine.empty()](Result& result) {
        if (outside) result.deterministic = false;
        result.plans += node.plans();
        result.replans += node.replans();
      });
  stage.servers.push_back(std::move(server));
  return {};
}

}  // namespace

constinit const NodeKind kNode{.name = "pddl_manager",
                               .what = "keeps PDDL instances and plans (docs/pddl-manager.md)",
                               .settings = settings_of<Config>(),
                               .add = add_manager};

}  // namespace cxlab::pddl
