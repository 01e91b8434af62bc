#include "scenarios/rl/node.h"

#include "cx/base/file.h"
#include "cx/bus/names.h"
#include "scenarios/result.h"
#include "scenarios/rl/trainer.h"

namespace cxlab::rl {

namespace {

/// `{node: cx_rl_node, ...}` under `servers:`.
struct Config {
  TrainerOptions options;
  std::string rl_mode = "TRAINING";
  std::string policy = "q_table";
  std::string model;  ///< a table that a training has written; empty = none

  template <class Keys>
  void fields(Keys& keys) {
    keys("name", options.node.name);
    keys("namespace", options.node.name_space);
    keys("remap", options.node.remaps);
    keys.word("rl_mode", rl_mode, {"TRAINING", "EXECUTION"});
    keys.word("policy", policy, {"q_table", "random", "external"});
    keys("model", model);
    keys("max_episodes", options.max_episodes);
    keys("max_steps", options.max_steps);
    keys("robots", options.robots);
    keys("no_op", options.no_op);
    keys("learning_rate", options.rates.learning_rate);
    keys("gamma", options.rates.gamma);
    keys("exploration", options.rates.exploration);
    keys("exploration_decay", options.rates.exploration_decay);
  }
};

Status validate(const Config& config) {
  const auto share = [](const char* key, double value) -> Status {
    if (value >= 0 && value <= 1) return {};
    return input_error(std::string(key) + ": must be from 0 to 1");
  };
  if (Status s = bus::check_node(config.options.node.name_space, config.options.node.remaps); !s) return s;
  if (config.options.max_episodes < 1) return input_error("max_episodes: must be 1 or more");
  if (config.options.max_steps < 1) return input_error("max_steps: must be 1 or more");
  if (config.options.robots < 1) return input_error("robots: must be 1 or more");
  if (config.options.no_op && config.policy != "external")
    return input_error("no_op: only the policy external can leave a robot idle");
  if (config.policy == "external" && config.rl_mode != "TRAINING")
    return input_error("policy: external chooses in rl_mode TRAINING only");
  if (Status s = share("learning_rate", config.options.rates.learning_rate); !s) return s;
  if (Status s = share("gamma", config.options.rates.gamma); !s) return s;
  if (Status s = share("exploration", config.options.rates.exploration); !s) return s;
  return share("exploration_decay", config.options.rates.exploration_decay);
}

Status add_trainer(const ServerSpec& spec, const StageSetup& setup, Stage& stage) {
  const Config& config = spec.get<Config>();
  TrainerOptions options = config.options;
  options.training = config.rl_mode == "TRAINING";
  options.chance_only = config.policy == "random";
  options.external = config.policy == "external";
  options.seed = setup.scenario.seed;
  options.log = setup.log;
  if (!config.model.empty()) {
    const std::filesystem::path file = setup.scenario.resolve(config.model);
    auto text = read_file(file);
    if (!text) return input_error("model: " + text.error().message, file.string());
    if (setup.keep)
      if (Status s = setup.keep("rl/" + file.filename().string(), file); !s) return s;
    auto table = QTable::from_text(*text, options.rates, file.string());
    if (!table) return table.error();
    options.model = *std::move(table);
  }
  if (!setup.run_folder.empty())
    options.write = [folder = setup.run_folder](const std::string& file, const std::string& text) {
      return write_file(folder / file, text);
    };
  auto trainer = Trainer::create(std::move(options), setup.bus, setup.sink);
  if (!trainer) return trainer.error();
  stage.reports.push_back([&node = **trainer](Result& result) {
    const std::string text = node.unfinished();
    if (const Status hangs = node.hanging(); !hangs)
      result.reason = hangs.error();
    else if (!text.empty())
      result.warnings.push_back(text);
  });
  stage.servers.push_back(*std::move(trainer));
  return {};
}

}  // namespace

constinit const NodeKind kNode{.name = "cx_rl_node",
                               .what = "trains an agent by its rewards (docs/how-to/train-over-cx-rl.md)",
                               .settings = settings_of<Config>(),
                               .add = add_trainer};

}  // namespace cxlab::rl
