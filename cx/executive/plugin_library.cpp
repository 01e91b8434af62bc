#include "cx/executive/plugin_library.h"

#include <dlfcn.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "cx/base/remedy.h"
#include "cx/executive/export_plugins.h"
#include "cx/yaml/yaml.h"

namespace cxlab::cx {

namespace fs = std::filesystem;

/// One entry `library:` of a manifest.
class PluginLibrary {
 public:
  PluginLibrary(std::string name, std::string manifest, int line, fs::path share, Files& files)
      : name_(std::move(name)), manifest_(std::move(manifest)), line_(line), share_(std::move(share)), files_(files) {}

  /// An open library; closed with the last copy of the pointer.
  struct Open {
    void* handle = nullptr;
    const PluginExports* exports = nullptr;
    std::string file;
    ~Open() {
      if (handle) dlclose(handle);
    }
  };
  Expected<std::shared_ptr<Open>> open();
  /// Keeps it open until the first `open`, which reports what is wrong with it.
  void open_early() {
    if (auto opened = open()) early_ = *std::move(opened);
  }
  Expected<PluginMaker> find(const Open& open, const std::string& class_name, int line) const;
  Error error(ErrorKind kind, std::string message, int line = 0) const {
    return Error{kind, std::move(message), manifest_, line ? line : line_, {}};
  }
  const std::string& name() const { return name_; }
  std::filesystem::path file() const {
    const auto found = locate();
    return found ? found->path : std::filesystem::path();
  }
  const std::string& manifest() const { return manifest_; }

 private:
  Expected<FoundFile> locate() const;

  std::string name_, manifest_;
  int line_;
  fs::path share_;
  Files& files_;
  std::weak_ptr<Open> open_;
  std::shared_ptr<Open> early_;
};

namespace {

std::vector<std::string> split_names(std::string_view names) {
  std::vector<std::string> out;
  while (!names.empty()) {
    const std::size_t end = std::min(names.find(','), names.size());
    std::string name(names.substr(0, end));
    std::erase(name, ' ');
    out.push_back(std::move(name));
    names.remove_prefix(std::min(end + 1, names.size()));
  }
  return out;
}

const char* g_being_opened = "";

/// "plugin 'greeter' (my::Greeter of /p/lib/libgreeter.so)".
std::string who(const std::string& name, const std::string& type, const std::string& library) {
  return "plugin '" + name + "' (" + type + (library.empty() ? "" : " of " + library) + ')';
}

/// The text of the exception that is being handled.
std::string current_exception_text() {
  try {
    throw;
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "something that is no std::exception";
  }
}

Error thrown(const std::string& plugin, std::string_view hook) {
  return run_error(plugin + ": " + std::string(hook) + " threw: " + current_exception_text())
      .with_code("plugin_failed");
}

}  // namespace

const char* library_being_opened() { return g_being_opened; }

Expected<FoundFile> PluginLibrary::locate() const {
  const fs::path path(name_);
  std::vector<fs::path> places{path};
  if (!path.is_absolute()) places = {share_ / path, share_.parent_path().parent_path() / "lib" / path};
  std::string looked;
  for (const fs::path& place : places) {
    const fs::path normal = place.lexically_normal();
    if (auto found = files_.resolve(normal.string(), {})) return found;
    looked += (looked.empty() ? "" : ", ") + normal.string();
  }
  return error(ErrorKind::kResource, "library '" + name_ + "' is not there (looked for " + looked +
                                         "): build it, and install it where the manifest is");
}

Expected<std::shared_ptr<PluginLibrary::Open>> PluginLibrary::open() {
  if (auto early = std::exchange(early_, nullptr)) return early;
  if (auto open = open_.lock()) return open;
  auto file = locate();
  if (!file) return file.error();
  if (auto content = files_.read(*file); !content) return content.error();  // the run keeps a copy
  auto open = std::make_shared<Open>();
  open->file = file->path.string();
  g_being_opened = open->file.c_str();
  open->handle = dlopen(file->path.c_str(), RTLD_NOW | RTLD_LOCAL);
  g_being_opened = "";
  if (!open->handle)
    return error(ErrorKind::kResource, std::string("cannot open the library: ") + dlerror() + "; built for cxlab " +
                                           kPluginAbi + "? Build it again, and link what it names");
  const auto exports = reinterpret_cast<const PluginExports* (*)()>(dlsym(open->handle, "cxlab_plugin_exports"));
  if (!exports)
    return error(ErrorKind::kInput,
                 open->file + " exports no plugins: end one of its sources with CXLAB_PLUGINS(my::Class)");
  try {
    open->exports = exports();
  } catch (...) {
    return error(ErrorKind::kRun, open->file + ": cxlab_plugin_exports threw: " + current_exception_text())
        .with_code("plugin_failed");
  }
  if (!open->exports || !open->exports->abi)
    return error(ErrorKind::kInput, open->file + ": cxlab_plugin_exports returns nothing: CXLAB_PLUGINS makes one");
  if (std::string_view(open->exports->abi) != kPluginAbi)
    return error(ErrorKind::kInput, open->file + " was built for cxlab " + open->exports->abi + ", this is " +
                                        kPluginAbi + ": build it again");
  open_ = open;
  return open;
}

Expected<PluginMaker> PluginLibrary::find(const Open& open, const std::string& class_name, int line) const {
  const std::vector<std::string> names = split_names(open.exports->names);
  const auto found = std::find(names.begin(), names.end(), class_name);
  if (found != names.end()) return open.exports->make[found - names.begin()];
  return error(ErrorKind::kInput,
               open.file + " has no plugin class '" + class_name + "', its CXLAB_PLUGINS names " + open.exports->names,
               line);
}

static PluginType read_class(const yaml::Value& item, std::shared_ptr<PluginLibrary> library) {
  yaml::Map plugin = item.as_map();
  PluginType type;
  type.library = std::move(library);
  type.line = plugin.require("class").line();
  type.name = plugin.get("class").as_string();
  std::string base = kPluginBase;
  plugin.read("description", type.description)
      .read_word("base", base, {kPluginBase})
      .read("parameters", type.parameters);
  type.any_parameter = !plugin.has("parameters");
  plugin.finish();
  return type;
}

Expected<std::vector<PluginType>> read_plugin_manifest(const std::string& package, Files& files) {
  std::vector<PluginType> types;
  auto file = files.resolve(kPluginManifest, {package});
  if (!file) return types;
  auto text = files.read(*file);
  if (!text) return text.error();
  auto document = yaml::Document::parse(*text, file->path.string());
  if (!document) return document.error();
  const yaml::Value root = document->root();
  for (const yaml::Value& entry : root.is_list() ? root.as_list() : std::vector{root}) {
    yaml::Map map = entry.as_map();
    const yaml::Value name = map.require("library");
    auto library = std::make_shared<PluginLibrary>(name.as_string(), file->path.string(), name.line(),
                                                   fs::path(*files.share_directory(package)), files);
    for (const yaml::Value& item : map.require("plugins").as_list()) types.push_back(read_class(item, library));
    map.finish();
  }
  if (Status s = document->status(); !s) return s.error();
  return types;
}

Error manifest_error(const PluginType& type, std::string message) {
  return type.library->error(ErrorKind::kInput, std::move(message), type.line);
}

std::filesystem::path library_file(const PluginType& type) {
  return type.library ? type.library->file() : std::filesystem::path();
}

void open_early(const PluginType& type) {
  if (type.library) type.library->open_early();
}

std::string place_of(const PluginType& type) {
  return type.library ? type.library->manifest() + ':' + std::to_string(type.line) : "cxlab";
}

/// Keeps the library until the plugin's destructor has run.
struct DeletePlugin {
  std::shared_ptr<void> library;
  void operator()(Plugin* plugin) const { delete plugin; }
};

std::shared_ptr<void> library_of(const std::shared_ptr<Plugin>& plugin) {
  const auto* deleter = std::get_deleter<DeletePlugin>(plugin);
  return deleter ? deleter->library : nullptr;
}

Expected<std::shared_ptr<Plugin>> make_plugin(const PluginType& type, PluginContext context) {
  const std::string name = context.name, class_name = context.type;
  std::shared_ptr<PluginLibrary::Open> open;
  std::function<std::unique_ptr<Plugin>(PluginContext)> make = type.make;
  if (type.library && !context.run.programs)
    return usage_error(who(name, class_name, type.library->name()) +
                       " is native code: it can read, write and run anything. If it may: --trust-programs")
        .with_code(kUntrusted);
  if (type.library) {
    const fs::path& folder = context.run.run_folder.empty() ? context.run.rules_folder : context.run.run_folder;
    if (const fs::path file = type.library->file(); !file.empty() && !folder.empty() && really_below(file, folder))
      return type.library->error(ErrorKind::kInput,
                                 "library '" + type.library->name() +
                                     "' lies in the folder of this run, where rules write; expected another place");
    auto opened = type.library->open();
    if (!opened) return opened.error();
    open = *std::move(opened);
    auto maker = type.library->find(*open, type.name, type.line);
    if (!maker) return maker.error();
    make = *maker;
    context.library = open->file;
  }
  const std::string described = who(name, class_name, context.library);
  try {
    std::unique_ptr<Plugin> plugin = make(std::move(context));
    return std::shared_ptr<Plugin>(plugin.release(), DeletePlugin{open});
  } catch (...) {
    return thrown(described, "its constructor");
  }
}

Status call_plugin(const Plugin& plugin, std::string_view hook, const std::function<Status()>& call) {
  const auto described = [&] { return who(plugin.name(), plugin.type(), plugin.library()); };
  try {
    Status status = call();
    if (status || plugin.library().empty()) return status;
    Error error = status.error();
    error.message = described() + ": " + std::string(hook) + ": " + error.message;
    return error;
  } catch (...) {
    return thrown(described(), hook);
  }
}

Status call_handlers(const std::string& environment, const std::function<Status()>& call) {
  try {
    return call();
  } catch (...) {
    return thrown("environment '" + environment + "'", "a plugin's handler of a delivery");
  }
}

}  // namespace cxlab::cx
