#pragma once
// The configuration of an agent for a test.

#include <cctype>
#include <string>
#include <vector>

namespace cxlab {

/// An environment of an agent.
struct EnvText {
  std::string name = "main";
  std::string rules = "rules.clp";  ///< that it loads from the agent's package
  int rate = 10;                    ///< Hz of its executive
};

/// "cx::RosMsgsPlugin" of "ros_msgs".
inline std::string plugin_class(const std::string& name) {
  std::string out = "cx::";
  bool begins = true;
  for (const char c : name) {
    if (c != '_') out += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    begins = c == '_';
  }
  return out + "Plugin";
}

/// A configuration of environments that have an executive, those plugins ("ros_msgs") and their rules. `parameters` are
/// further lines, "limit: 3\n".
inline std::string agent_text(const std::string& package, const std::vector<std::string>& plugins = {},
                              const std::vector<EnvText>& envs = {EnvText()}, const std::string& parameters = {}) {
  std::string names, lines, shared;
  for (const std::string& plugin : plugins) {
    shared += '"' + plugin + "\", ";
    lines += plugin + ": {plugin: \"" + plugin_class(plugin) + "\"}\n";
  }
  for (const EnvText& env : envs) {
    const std::string of = envs.size() == 1 ? std::string() : '_' + env.name;
    names += (names.empty() ? "\"" : ", \"") + env.name + '"';
    lines += env.name + ": {plugins: [\"executive" + of + "\", " + shared + "\"files" + of + "\"]}\n";
    lines += "executive" + of + ": {plugin: \"cx::ExecutivePlugin\", refresh_rate: " + std::to_string(env.rate) + "}\n";
    lines += "files" + of + ": {plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [\"" + package + "\"], load: [\"" +
             env.rules + "\"]}\n";
  }
  std::string text = "/**:\n  ros__parameters:\n    ";
  for (const char c : "environments: [" + names + "]\n" + lines + parameters)
    text += c == '\n' ? "\n    " : std::string(1, c);
  return text + '\n';
}

}  // namespace cxlab
