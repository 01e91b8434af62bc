#pragma once
// What rules find in an environment: functions, templates, globals and rules of the plugins, asked of the plugins
// themselves.

#include <map>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/engine/function.h"

namespace cxlab::lab {

struct Documented {
  std::string kind;  ///< "deftemplate", "defglobal", "defrule", "deffunction"
  std::string name;
  std::string text;  ///< as written
};

/// What one plugin class brings.
struct PluginReference {
  std::string plugin;                   ///< "cx::ConfigPlugin"; "environment manager" for what is always there
  std::string package;                  ///< with the plugin; empty = comes with cxlab
  std::string description;              ///< of its manifest
  std::string problem;                  ///< why it could not be loaded, so that the rest is not known
  std::vector<std::string> parameters;  ///< of its YAML
  std::vector<FunctionSpec> functions;  ///< by name
  std::vector<Documented> constructs;   ///< in order of definition
};

/// The reference of these classes, or of all that come with cxlab and of all plugins of these packages (name ->
/// folder): each is loaded alone into an environment.
Expected<std::vector<PluginReference>> read_reference(const std::map<std::string, std::string>& packages,
                                                      const std::vector<std::string>& classes = {});

/// Classes of bindings whose functions and facts begin as `name` does ("std-msgs-string-publish"), best first.
std::vector<std::string> binding_classes_of(const std::string& name,
                                            const std::map<std::string, std::string>& packages);

/// `(config-load STRING|SYMBOL STRING|SYMBOL)`.
std::string call_text(const FunctionSpec& function);
/// "STRING", "INTEGER|FLOAT", "nothing", ...
std::string type_text(const std::string& codes);
/// "pure" or "acting".
std::string kind_text(const FunctionSpec& function);

/// docs/reference/functions.md.
Expected<std::string> reference_page(const std::vector<PluginReference>& reference);
/// An interface as `doc --json` shows it.
std::string interface_json(const std::string& name, const std::string& text);
std::string reference_json(const std::vector<PluginReference>& reference);

}  // namespace cxlab::lab
