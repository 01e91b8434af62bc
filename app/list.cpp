// cxlab list: what there is to use.

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "app/command.h"
#include "app/share.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/journal/journal.h"
#include "cx/plugins/builtin.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

/// The first comment of a YAML file.
std::string headline(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line.starts_with("# ") ? line.substr(2) : std::string();
}

int list_scenarios() {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(find_share().scenarios, ignored)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);)
      if (line.starts_with("schema:")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) std::printf("%-40s %s\n", fs::proximate(file).c_str(), headline(file).c_str());
  return 0;
}

int list_skills() {
  bus::Registry registry;
  if (Status s = registry.add_packages_in(find_share().interfaces); !s) return fail(s.error());
  for (const char* package : {"cxlab_skills", "rcll_interfaces"})
    for (const std::string& name : registry.interfaces(package)) {
      if (name.find("/action/") == std::string::npos) continue;
      auto action = registry.action(name);
      if (!action) return fail(action.error());
      std::printf("%s\n ", name.c_str());
      for (const bus::Field& field : (*action)->goal->fields()) std::printf(" %s", field.name.c_str());
      std::printf("\n");
    }
  return 0;
}

/// An environment with every plugin that comes with cxlab, to ask what rules find in it.
Expected<std::string> all_plugins_yaml() {
  std::string names, sections;
  for (const cx::PluginType& type : cx::builtin_plugins()) {
    std::string name = type.name.substr(type.name.rfind(':') + 1);
    names += (names.empty() ? "" : ", ") + name;
    sections += "    " + name + ": {plugin: \"" + type.name + "\"}\n";
  }
  std::string file = (fs::temp_directory_path() / "cxlab-list-XXXXXX").string();
  const int descriptor = mkstemp(file.data());
  if (descriptor < 0) return Error{ErrorKind::kResource, "cannot write to " + fs::temp_directory_path().string(), {}, 0, {}};
  close(descriptor);
  std::ofstream(file) << "/**:\n  ros__parameters:\n    environments: [main]\n    main: {plugins: [" << names << "], log_clips_to_file: false}\n" << sections;
  return file;
}

int list_in_environment(bool functions) {
  auto config = all_plugins_yaml();
  if (!config) return fail(config.error());
  bus::Registry registry;
  if (Status s = registry.add_packages_in(find_share().interfaces); !s) return fail(s.error());
  Journal journal;
  bus::Bus bus(registry, journal);
  cx::ManagerOptions options;
  options.config = *config;
  options.plugin_types = cx::builtin_plugins();
  auto manager = cx::EnvironmentManager::create(std::move(options), bus, journal);
  std::error_code ignored;
  fs::remove(*config, ignored);
  if (!manager) return fail(manager.error());
  if (Status s = (*manager)->configure(); !s) return fail(s.error());
  if (Status s = (*manager)->activate(); !s) return fail(s.error());
  const RuleEngine& engine = (*manager)->environment(0).engine();
  if (functions) {
    for (const FunctionSpec& f : engine.functions())
      std::printf("%-46s %-4s %-6s %-8s %s\n", f.name.c_str(), f.returns.c_str(), f.arg_types.c_str(), f.kind == FunctionKind::kPure ? "pure" : "acting", f.owner.c_str());
  } else {
    for (const ConstructInfo& c : engine.constructs())
      if (c.kind == "deftemplate") std::printf("%s\n", c.text.c_str());
  }
  const Status ended = (*manager)->deactivate();
  return ended ? 0 : fail(ended.error());
}

}  // namespace

void add_list(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("list", "Lists what there is: scenarios, skills, functions that rules can call, templates of the plugins");
  auto what = std::make_shared<std::string>();
  command->add_option("what", *what, "scenarios, skills, functions or templates")
      ->required()
      ->check(CLI::IsMember({"scenarios", "skills", "functions", "templates"}));
  command->callback([what, &action] {
    action = [what] {
      if (*what == "scenarios") return list_scenarios();
      return *what == "skills" ? list_skills() : list_in_environment(*what == "functions");
    };
  });
}

}  // namespace cxlab::app
