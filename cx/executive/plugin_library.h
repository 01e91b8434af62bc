#pragma once
// Plugins of a user's own: shared libraries that a package names in its manifest, `cxlab_plugins.yaml`.
//
//   library: libgreeter.so                # beside the manifest, else in <prefix>/lib of <prefix>/share/<package>
//   plugins:
//     - class: my::Greeter                # as in CXLAB_PLUGINS and in `plugin:` of a configuration
//       base: cxlab::cx::Plugin           # may be left out
//       description: Greets who comes.
//       parameters: [greeting]            # that it reads; without this key it may read any
//
// A package with several libraries has a list of such maps. A library is opened when its first instance is made. It is
// closed when the last environment that used it is destroyed.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/executive/files.h"
#include "cx/executive/plugin.h"

namespace cxlab::cx {

inline constexpr const char* kPluginManifest = "cxlab_plugins.yaml";
inline constexpr const char* kPluginBase = "cxlab::cx::Plugin";

/// The plugin classes of the package's manifest; none where it has no manifest. Nothing is opened. Bad manifests are
/// errors with file:line.
Expected<std::vector<PluginType>> read_plugin_manifest(const std::string& package, Files& files);

/// An error where the manifest names this class of a library.
Error manifest_error(const PluginType& type, std::string message);
/// The library that the class is in; empty for a class of cxlab, and where it is not there.
std::filesystem::path library_file(const PluginType& type);
/// Opens the library before its first instance is made, as long as this process reads and runs what that needs.
void open_early(const PluginType& type);
/// "/p/share/greeter/cxlab_plugins.yaml:3", or "cxlab" for one that is built in.
std::string place_of(const PluginType& type);

/// Makes an instance. Opens the library of the class, if it is in one. Fails with kResource if this library, or a
/// library or symbol that it needs, is missing. Fails with kInput if it was built with other headers or has no such
/// class. File and line are those of the manifest. Fails with kUsage where `RunSettings::programs` does not allow it.
/// The library stays open as long as the instance lives.
Expected<std::shared_ptr<Plugin>> make_plugin(const PluginType& type, PluginContext context);

/// The library whose constructors run now, empty if none does: an exception of theirs ends the process.
const char* library_being_opened();

/// The library that the instance comes from, open as long as somebody holds this; none for one that is built in.
std::shared_ptr<void> library_of(const std::shared_ptr<Plugin>& plugin);

/// Calls a plugin. An exception becomes an error of kind run; an error that it returns is reported with its name.
Status call_plugin(const Plugin& plugin, std::string_view hook, const std::function<Status()>& call);
/// The same for handlers of plugins that the bus calls.
Status call_handlers(const std::string& environment, const std::function<Status()>& call);

}  // namespace cxlab::cx
