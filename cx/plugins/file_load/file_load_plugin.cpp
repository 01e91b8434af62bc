#include <algorithm>
#include <array>

#include "cx/plugins/builtin.h"

namespace cxlab::cx {

namespace {

/// Loads rule files when an environment begins, and batch files when it ends.
class FileLoadPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status initialize() override {
    std::vector<std::string> packages;
    if (Status s = parameter("pkg_share_dirs", packages); !s) return s;
    if (context().run.next) skip_missing(packages);
    struct List {
      std::string_view key;
      std::vector<FoundFile>* files;
    };
    for (const List& list :
         std::array<List, 3>{{{"load", &load_}, {"batch", &batch_}, {"cleanup_batch", &cleanup_batch_}}}) {
      std::vector<std::string> names;
      if (Status s = parameter(list.key, names); !s) return s;
      for (const std::string& file : names) {
        auto found = find(list.key, file, packages);
        if (found) {
          list.files->push_back(std::move(*found));
          continue;
        }
        const Error error = context().parameters.error_at(name() + '.' + std::string(list.key), found.error().message);
        if (!context().run.keep_going) return error;
        log(LogLevel::kError, error.text());
        context().note_load_error(error);
        return {};  // the files that follow are dropped, as in CX
      }
    }
    return {};
  }

  Status clips_env_init(EnvironmentGuard environment) override {
    for (const FoundFile& file : load_)
      if (Status s = load(*environment, file, LoadMode::kConstructs); !s) return s;
    for (const FoundFile& file : batch_)
      if (Status s = load(*environment, file, LoadMode::kBatch); !s) return s;
    return {};
  }

  void clips_env_destroyed(EnvironmentGuard environment) override {
    for (const FoundFile& file : cleanup_batch_)
      if (Status s = load(*environment, file, LoadMode::kBatch); !s) {
        log(*environment, LogLevel::kError, s.error().text());
        context().note_load_error(s.error());
      }
  }

 private:
  /// As in the next CX, a package that is not there is left out where another one may have the files.
  void skip_missing(std::vector<std::string>& packages) const {
    const auto missing = [&](const std::string& package) { return !context().files.share_directory(package); };
    if (std::ranges::all_of(packages, missing)) return;
    for (const std::string& package : packages)
      if (missing(package))
        log(LogLevel::kWarn, "Share directory lookup skipped: package '" + package + "' not found in ament index");
    std::erase_if(packages, missing);
  }

  /// What rules may have set names files that rules may read.
  Expected<FoundFile> find(std::string_view key, const std::string& file, const std::vector<std::string>& packages) {
    const Parameter* list = context().parameters.find(name() + '.' + std::string(key));
    const bool set_by_rules = list && list->at_run_time;
    const Files& files = context().files;
    if (set_by_rules && std::filesystem::path(file).is_absolute()) return files.find_for_rules(file);
    auto found = files.resolve(file, packages);
    if (!found || !set_by_rules) return found;
    for (const std::string& package : packages)  // a link may lead out of it
      if (found->logical_name.starts_with(package + '/'))
        return files.find_for_rules(*files.share_directory(package) + found->logical_name.substr(package.size()));
    return found;
  }

  Status load(Environment& environment, const FoundFile& file, LoadMode mode) {
    auto text = context().files.read(file);
    if (!text) {
      log(environment, LogLevel::kError, "Failed to load file " + file.path.string());
      return text.error();
    }
    const OnLoadError on_error = context().run.keep_going ? OnLoadError::kKeepGoing : OnLoadError::kStop;
    if (context().run.next) environment.engine().use_module("MAIN");
    const LoadReport report = environment.engine().load_text(*text, file.path.string(), mode, on_error);
    (void)environment.check_errors(report.errors);  // noted; what they mean for loading is decided here
    if (!context().run.keep_going) return report.status();
    for (const RuleError& e : report.errors) context().note_load_error(e.error());
    return {};
  }

  std::vector<FoundFile> load_, batch_, cleanup_batch_;
};

}  // namespace

PluginType file_load_plugin() {
  return {"cx::FileLoadPlugin", {"pkg_share_dirs", "load", "batch", "cleanup_batch"}, [](PluginContext c) {
            return std::make_unique<FileLoadPlugin>(std::move(c));
          }};
}

}  // namespace cxlab::cx
