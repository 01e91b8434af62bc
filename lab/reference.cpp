#include "lab/reference.h"

#include <algorithm>
#include <filesystem>
#include <functional>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/scratch_folder.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/executive/plugin_library.h"
#include "cx/journal/journal.h"
#include "cx/plugins/bindings/names.h"
#include "cx/plugins/builtin.h"
#include "lab/page.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr const char* kManager = "environment manager";

/// A configuration with an environment for each class, and one without plugins.
Status write_configuration(const fs::path& file, const std::vector<std::string>& classes) {
  std::string environments = "none", sections = "    none: {log_clips_to_file: false}\n";
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const std::string number = std::to_string(i);
    environments += ", e" + number;
    sections += "    e" + number + ": {plugins: [p" + number + "], log_clips_to_file: false}\n    p" + number +
                ": {plugin: \"" + classes[i] + "\"}\n";
  }
  return write_file(file, "/**:\n  ros__parameters:\n    environments: [" + environments + "]\n" + sections);
}

struct KnownClass {
  cx::PluginType type;
  std::string package;  // empty = built in
};

/// The classes that come with cxlab, without families that are made from names; then the classes of the packages.
Expected<std::vector<KnownClass>> all_classes(const std::map<std::string, std::string>& packages) {
  std::vector<KnownClass> out;
  for (cx::PluginType& type : cx::builtin_plugins())
    if (!type.has) out.push_back({std::move(type), {}});
  cx::Files::Options options;
  for (const auto& [name, folder] : packages) options.packages[name] = {folder, {}};
  cx::Files files(std::move(options));
  for (const auto& [name, folder] : packages) {
    auto types = cx::read_plugin_manifest(name, files);
    if (!types) return types.error();
    for (cx::PluginType& type : *types) out.push_back({std::move(type), name});
  }
  return out;
}

Status add_interfaces(bus::Registry& registry, const std::map<std::string, std::string>& packages) {
  if (Status s = registry.add_packages_in(find_share().interfaces); !s) return s;
  for (const auto& [name, folder] : packages)
    if (bus::holds_definitions(folder))
      if (Status s = registry.add_package(name, folder); !s) return s;
  return {};
}

const char* type_word(char code) {
  switch (code) {
    case 's': return "STRING";
    case 'y': return "SYMBOL";
    case 'l': return "INTEGER";
    case 'd': return "FLOAT";
    case 'b': return "BOOLEAN";
    case 'e': return "EXTERNAL-ADDRESS";
    case 'm': return "MULTIFIELD";
    case 'f': return "FACT";
    case 'i': return "INSTANCE";
    case 'n': return "INSTANCE-NAME";
    case 'v': return "nothing";
    default: return "anything";
  }
}

/// The codes of each argument; the first entry is that of arguments without their own.
std::vector<std::string> argument_codes(const FunctionSpec& function) {
  std::vector<std::string> out(1);
  for (const char c : function.arg_types) {
    if (c == ';')
      out.emplace_back();
    else
      out.back() += c;
  }
  return out;
}

}  // namespace

std::vector<std::string> binding_classes_of(const std::string& name,
                                            const std::map<std::string, std::string>& packages) {
  bus::Registry registry;
  if (!add_interfaces(registry, packages)) return {};
  std::vector<std::pair<std::string, std::string>> found;  // prefix, class
  for (const std::string& package : registry.packages())
    for (const std::string& interface : registry.interfaces(package)) {
      std::string prefix = cx::kebab_case(cx::camel_case(package) + interface.substr(interface.rfind('/') + 1));
      if (name.starts_with(prefix + '-')) found.emplace_back(std::move(prefix), cx::binding_class_name(interface));
    }
  std::ranges::stable_sort(found, std::greater<>(), [](const auto& item) { return item.first.size(); });
  std::vector<std::string> out;
  for (auto& item : found) out.push_back(std::move(item.second));
  return out;
}

std::string type_text(const std::string& codes) {
  std::string out;
  for (const char c : codes) out += (out.empty() ? "" : "|") + std::string(type_word(c));
  return out.empty() ? "anything" : out;
}

std::string kind_text(const FunctionSpec& function) { return function.kind == FunctionKind::kPure ? "pure" : "acting"; }

std::string call_text(const FunctionSpec& function) {
  const std::vector<std::string> codes = argument_codes(function);
  const bool open = function.max_args == kAnyNumberOfArguments;
  const std::size_t shown = open ? std::max<std::size_t>(function.min_args, codes.size() - 1) : function.max_args;
  std::string out = '(' + function.name;
  for (std::size_t i = 0; i < shown; ++i) {
    const std::string type = type_text(i + 1 < codes.size() && !codes[i + 1].empty() ? codes[i + 1] : codes[0]);
    out += i < function.min_args ? ' ' + type : " [" + type + ']';
  }
  return out + (open ? " ...)" : ")");
}

Expected<std::vector<PluginReference>> read_reference(const std::map<std::string, std::string>& packages,
                                                      const std::vector<std::string>& named) {
  auto known = all_classes(packages);
  if (!known) return known.error();
  std::vector<std::string> classes = named;
  if (named.empty())
    for (const KnownClass& k : *known) classes.push_back(k.type.name);
  bus::Registry registry;
  if (Status s = add_interfaces(registry, packages); !s) return s.error();
  Journal journal;
  bus::Bus bus(registry, journal);
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  cx::ManagerOptions options;
  options.config = (*scratch)->path() / "doc.yaml";
  if (Status s = write_configuration(options.config, classes); !s) return s.error();
  options.plugin_types = cx::builtin_plugins();
  for (const auto& [name, folder] : packages) options.packages[name] = {folder, {}};
  options.keep_going = named.empty();  // one that cannot be loaded does not hide the others
  auto manager = cx::EnvironmentManager::create(std::move(options), bus, journal);
  if (!manager) {
    Error error = manager.error();
    error.file.clear();  // ours, and gone
    return error;
  }
  if (Status s = (*manager)->configure(); !s) return s.error();
  if (Status s = (*manager)->activate(); !s) return s.error();

  std::vector<PluginReference> out;
  std::size_t problems = 0;
  for (std::size_t i = 0; i <= classes.size(); ++i) {
    const RuleEngine& engine = (*manager)->find(i == 0 ? "none" : 'e' + std::to_string(i - 1))->engine();
    PluginReference& plugin = out.emplace_back();
    plugin.plugin = i == 0 ? kManager : classes[i - 1];
    for (const KnownClass& k : *known) {
      if (k.type.name != plugin.plugin) continue;
      plugin.package = k.package;
      plugin.description = k.type.description;
      plugin.parameters = k.type.parameters;
    }
    if (i > 0 && (*manager)->plugin_names('e' + std::to_string(i - 1))->empty())
      plugin.problem = problems < (*manager)->load_errors().size() ? (*manager)->load_errors()[problems++].text()
                                                                   : "it cannot be loaded";
    for (FunctionSpec& f : engine.functions())
      if (i == 0 || f.owner == 'p' + std::to_string(i - 1)) plugin.functions.push_back(std::move(f));
    for (const ConstructInfo& c : engine.constructs()) plugin.constructs.push_back({c.kind, c.name, c.text});
  }
  const Status ended = (*manager)->deactivate();
  if (!ended) return ended.error();
  return out;
}

std::string interface_json(const std::string& name, const std::string& text) {
  return json_text(Json{{"interface", name}, {"text", text}}, 2) + '\n';
}

std::string reference_json(const std::vector<PluginReference>& reference) {
  Json out = Json::array();
  for (const PluginReference& plugin : reference) {
    Json functions = Json::array(), constructs = Json::array();
    for (const FunctionSpec& f : plugin.functions)
      functions.push_back({{"name", f.name},
                           {"call", call_text(f)},
                           {"gives", type_text(f.returns)},
                           {"arguments", f.arg_types},
                           {"returns", f.returns},
                           {"min_args", f.min_args},
                           {"max_args", f.max_args == kAnyNumberOfArguments ? Json() : Json(f.max_args)},
                           {"kind", kind_text(f)},
                           {"help", f.doc}});
    for (const Documented& c : plugin.constructs)
      constructs.push_back({{"kind", c.kind}, {"name", c.name}, {"text", c.text}});
    Json one{{"plugin", plugin.plugin},
             {"parameters", plugin.parameters},
             {"functions", functions},
             {"constructs", constructs}};
    if (!plugin.package.empty()) one.update({{"package", plugin.package}, {"description", plugin.description}});
    if (!plugin.problem.empty()) one["problem"] = plugin.problem;
    out.push_back(std::move(one));
  }
  return json_text(out, 2) + '\n';
}

Expected<std::string> reference_page(const std::vector<PluginReference>& reference) {
  return render_page("reference.md", "{\"plugins\": " + reference_json(reference) + '}');
}

}  // namespace cxlab::lab
