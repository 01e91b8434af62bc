// cxlab doc: what a function, template or plugin is.

#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/suggestions.h"
#include "lab/interfaces.h"
#include "lab/reference.h"

namespace cxlab::app {

namespace {

struct DocOptions {
  std::string name;
  lab::PackageOptions packages;
  bool json = false, markdown = false;
};

void print(const lab::PluginReference& plugin) {
  std::printf("%s", plugin.plugin.c_str());
  if (!plugin.package.empty())
    std::printf(" (package %s)%s%s", plugin.package.c_str(), plugin.description.empty() ? "" : ": ",
                plugin.description.c_str());
  std::puts("");
  if (!plugin.problem.empty()) std::printf("  cannot be loaded: %s\n", plugin.problem.c_str());
  for (const std::string& parameter : plugin.parameters) std::printf("  parameter %s\n", parameter.c_str());
  for (const FunctionSpec& f : plugin.functions) {
    std::printf("  %s -> %s, %s\n", lab::call_text(f).c_str(), lab::type_text(f.returns).c_str(),
                lab::kind_text(f).c_str());
    std::printf("      %s\n", f.doc.c_str());
  }
  for (const lab::Documented& c : plugin.constructs) std::printf("  %s %s\n", c.kind.c_str(), c.name.c_str());
}

void print_whole(const lab::PluginReference& plugin) {
  print(plugin);
  for (const lab::Documented& c : plugin.constructs) std::printf("\n%s\n", c.text.c_str());
}

/// The part of the reference that is about the name: a plugin whole, or one thing of it.
std::vector<lab::PluginReference> about(const std::vector<lab::PluginReference>& reference, const std::string& name) {
  std::vector<lab::PluginReference> out;
  for (const lab::PluginReference& plugin : reference) {
    if (plugin.plugin == name || plugin.plugin == "cx::" + name) return {plugin};
    lab::PluginReference part;
    part.plugin = plugin.plugin;
    part.package = plugin.package;
    for (const FunctionSpec& f : plugin.functions)
      if (f.name == name) part.functions.push_back(f);
    for (const lab::Documented& c : plugin.constructs)
      if (c.name == name) part.constructs.push_back(c);
    if (!part.functions.empty() || !part.constructs.empty()) out.push_back(std::move(part));
  }
  return out;
}

std::vector<std::string> plugin_names(const std::vector<lab::PluginReference>& reference) {
  std::vector<std::string> names;
  for (const lab::PluginReference& plugin : reference) {
    names.push_back(plugin.plugin);
    for (const FunctionSpec& f : plugin.functions) names.push_back(f.name);
    for (const lab::Documented& c : plugin.constructs) names.push_back(c.name);
  }
  return names;
}

/// The names of what comes with cxlab; classes come without their namespace, because shells break words at colons.
std::vector<std::string> names_that_come_along() {
  std::vector<std::string> names;
  if (const auto packages = lab::find_packages({}))
    if (const auto reference = lab::read_reference(*packages)) names = plugin_names(*reference);
  for (std::string& name : names)
    if (name.starts_with("cx::")) name.erase(0, 4);
  if (const auto interfaces = lab::Interfaces::load({}))
    for (const std::string& name : interfaces->names()) names.push_back(name);
  return names;
}

Error unknown(const std::vector<lab::PluginReference>& reference, const std::string& name) {
  const std::string near = nearest_word(name, plugin_names(reference));
  return input_error("there is no function, template or plugin '" + name + "'" +
                     (near.empty() ? "; cxlab doc lists all" : ", did you mean '" + near + "'?"));
}

int show_interface(const DocOptions& options, const std::map<std::string, std::string>& packages) {
  if (options.markdown) return fail(usage_error("--markdown: an interface is shown as text, or with --json"));
  const std::string& name = options.name;
  auto interfaces = lab::Interfaces::load(packages);
  if (!interfaces) return fail(interfaces.error());
  const auto text = interfaces->show(name);
  if (!text) return fail(text.error());
  const std::string shown = options.json ? lab::interface_json(name, *text) : *text;
  std::fputs(shown.c_str(), stdout);
  return 0;
}

int doc(const DocOptions& options) {
  // A class of a family (cx::CX<Pkg><Name>Plugin) is made from its name.
  const bool is_class = options.name.starts_with("cx::");
  auto packages = lab::find_packages(options.packages);
  if (!packages) return fail(packages.error());
  if (options.name.find('/') != std::string::npos) return show_interface(options, *packages);
  auto reference = lab::read_reference(*packages);
  if (!reference) return fail(reference.error());
  std::vector<lab::PluginReference> shown = options.name.empty() ? *reference : about(*reference, options.name);
  if (shown.empty() && is_class) {
    auto made = lab::read_reference(*packages, {options.name});
    if (!made) return fail(made.error());
    shown.push_back(std::move(made->back()));
  }
  if (shown.empty() && !is_class)
    if (const auto classes = lab::binding_classes_of(options.name, *packages); !classes.empty()) {
      auto made = lab::read_reference(*packages, classes);
      if (!made) return fail(made.error());
      shown = about(*made, options.name);
      reference = std::move(made);  // what is near is among them
    }
  if (shown.empty()) return fail(unknown(*reference, options.name));
  if (options.json) {
    std::fputs(lab::reference_json(shown).c_str(), stdout);
  } else if (options.markdown) {
    const auto page = lab::reference_page(shown);
    if (!page) return fail(page.error());
    std::fputs(page->c_str(), stdout);
  } else {
    for (std::size_t i = 0; i < shown.size(); ++i) {
      if (i > 0) std::puts("");
      options.name.empty() ? print(shown[i]) : print_whole(shown[i]);
    }
  }
  return 0;
}

}  // namespace

void add_doc(CLI::App& app, Action& action) {
  auto options = std::make_shared<DocOptions>();
  CLI::App* command = app.add_subcommand(
      "doc", "Show what rules can use: all plugins with their functions and templates, one of them, or an interface");
  command->footer(
      "Examples:\n  cxlab doc\n  cxlab doc config-load\n  cxlab doc tf2-tracked-pose\n  cxlab doc "
      "cx::ExecutivePlugin\n  cxlab doc std-msgs-string-publish\n  cxlab doc rcll_interfaces/msg/Order");
  suggest(
      command->add_option("name", options->name,
                          "A function, a template or other construct, a plugin class, or a message, service or action"),
      names_that_come_along);
  add_package_options(*command, options->packages);
  CLI::Option* json = command->add_flag("--json", options->json, "As JSON");
  command->add_flag("--markdown", options->markdown, "As docs/reference/functions.md")->excludes(json);
  command->callback([options, &action] { action = [options] { return doc(*options); }; });
}

}  // namespace cxlab::app
