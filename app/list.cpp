// cxlab list: what there is to use.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "app/arguments.h"
#include "app/command.h"
#include "lab/interfaces.h"
#include "lab/reference.h"
#include "scenarios/metric.h"
#include "scenarios/share.h"
#include "sim/faults/fault.h"

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
  for (const auto& [name, file] : own_scenarios()) std::printf("%-28s %s\n", name.c_str(), headline(file).c_str());
  return 0;
}

/// Rows of the catalogue.
template <class Kind>
int list_kinds(const std::vector<const Kind*>& kinds) {
  for (const Kind* kind : kinds)
    std::printf("%-15s %s\n", std::string(kind->name).c_str(), std::string(kind->what).c_str());
  return 0;
}

/// What `bench` compares in each world; the first of a world before all others.
int list_metrics() {
  const auto print = [](std::string_view world, std::span<const Metric> metrics) {
    for (const Metric& metric : metrics)
      std::printf("%-10s %-18s %-5s %-7s %s: %s\n", std::string(world).c_str(), std::string(metric.name).c_str(),
                  std::string(metric.unit).c_str(), metric.more_is_better ? "more" : "less",
                  std::string(metric.what).c_str(), formula_of(metric).c_str());
  };
  for (const WorldKind* world : catalogue().worlds) print(world->name, world->metrics);
  print("all", common_metrics());
  return 0;
}

int list_interfaces(const lab::PackageOptions& options) {
  auto packages = lab::find_packages(options);
  if (!packages) return fail(packages.error());
  auto interfaces = lab::Interfaces::load(*packages);
  if (!interfaces) return fail(interfaces.error());
  for (const std::string& name : interfaces->names()) std::printf("%s\n", name.c_str());
  return 0;
}

int list_skills() {
  auto interfaces = lab::Interfaces::load({});
  if (!interfaces) return fail(interfaces.error());
  bus::Registry& registry = interfaces->registry();
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

/// A plugin class, where it comes from and what it is or reads.
void print_plugin(const lab::PluginReference& plugin) {
  if (plugin.plugin.find("::") == std::string::npos) return;  // the manager
  std::string text = plugin.problem.empty() ? plugin.description : "cannot be loaded: " + plugin.problem;
  if (text.empty())
    for (const std::string& parameter : plugin.parameters) text += (text.empty() ? "parameters " : ", ") + parameter;
  std::printf("%-32s %-20s %s\n", plugin.plugin.c_str(), plugin.package.empty() ? "cxlab" : plugin.package.c_str(),
              text.c_str());
}

int list_reference(const std::string& what, const lab::PackageOptions& options) {
  auto packages = lab::find_packages(options);
  if (!packages) return fail(packages.error());
  auto reference = lab::read_reference(*packages);
  if (!reference) return fail(reference.error());
  if (what == "plugins") {
    for (const lab::PluginReference& plugin : *reference) print_plugin(plugin);
    std::printf("%-32s %-20s one for each message, service and action, for example cx::CXStdMsgsStringPlugin\n",
                "cx::CX<Pkg><Name>Plugin", "cxlab");
    std::printf("%-32s %-20s as cx::ProtobufPlugin, with the .proto files of a package\n", "cx::<Name>ProtobufPlugin",
                "cxlab");
    return 0;
  }
  for (const lab::PluginReference& plugin : *reference) {
    for (const FunctionSpec& f : plugin.functions)
      if (what == "functions")
        std::printf("%-80s %-28s %-7s %s\n", lab::call_text(f).c_str(), lab::type_text(f.returns).c_str(),
                    lab::kind_text(f).c_str(), plugin.plugin.c_str());
    for (const lab::Documented& c : plugin.constructs)
      if (what == "templates" && c.kind == "deftemplate")
        std::printf("; %s\n%s\n", plugin.plugin.c_str(), c.text.c_str());
  }
  return 0;
}

int list_faults() {
  for (const sim::FaultWord& word : sim::fault_words()) {
    const std::string when =
        word.by_occasion ? "at | probability, from, until, times" : "at | mean_s, from, until, times";
    std::printf("%-15s %s\n%-15s %s; %s\n", std::string(word.name).c_str(), std::string(word.what).c_str(), "",
                std::string(word.arguments).c_str(), when.c_str());
  }
  return 0;
}

}  // namespace

void add_list(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("list",
                                         "List scenarios, worlds, nodes beside a world, skills, interfaces, plugin "
                                         "classes, functions and templates for rules, faults, or metrics");
  auto what = std::make_shared<std::string>();
  command->add_option("what", *what, "What to list")
      ->required()
      ->check(one_of({"scenarios", "worlds", "nodes", "skills", "interfaces", "plugins", "functions", "templates",
                      "faults", "metrics"}));
  auto packages = std::make_shared<lab::PackageOptions>();
  add_package_options(*command, *packages);
  command->callback([what, packages, &action] {
    action = [what, packages] {
      if (*what == "scenarios") return list_scenarios();
      if (*what == "worlds") return list_kinds(catalogue().worlds);
      if (*what == "nodes") return list_kinds(catalogue().nodes);
      if (*what == "faults") return list_faults();
      if (*what == "metrics") return list_metrics();
      if (*what == "interfaces") return list_interfaces(*packages);
      return *what == "skills" ? list_skills() : list_reference(*what, *packages);
    };
  });
}

}  // namespace cxlab::app
