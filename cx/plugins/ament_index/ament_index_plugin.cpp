#include <algorithm>

#include "cx/plugins/builtin.h"

namespace cxlab::cx {

namespace {

using Look = std::function<Expected<Value>(const Files&, Call&)>;

/// Answers through the input log; an error is FALSE and one ERROR line, as in CX.
Function looking(Plugin& plugin, Environment& environment, Look look) {
  return [&plugin, &environment, look = std::move(look)](Call& call) {
    call.give(environment.look(call.spec().name, [&]() -> Value {
      auto value = look(environment.files(), call);
      if (value) return *value;
      environment.log(LogLevel::kError, plugin.name(), call.spec().name + ": " + value.error().message);
      return Value::boolean(false);
    }));
  };
}

std::filesystem::path marker(const Files& files, const std::string& package, std::string_view type,
                             std::string_view name) {
  auto prefix = files.prefix(package);
  return std::filesystem::path(*prefix) / "share" / "ament_index" / "resource_index" / type / name;
}

/// Prefixes of the packages, each once, in order of the packages.
std::vector<std::string> prefixes(const Files& files) {
  std::vector<std::string> out;
  for (const std::string& package : files.packages()) {
    const std::string prefix = *files.prefix(package);
    if (std::find(out.begin(), out.end(), prefix) == out.end()) out.push_back(prefix);
  }
  return out;
}

/// Types and names of resources are words: with a path in them rules would look anywhere on the disk.
Status check_word(std::string_view function, const char* what, std::string_view word) {
  const std::string begin = "ament_index_cpp::" + std::string(function) + "() resource " + what;
  if (word.empty()) return input_error(begin + " must not be empty");
  if (word.find('/') != std::string_view::npos || word == "." || word == "..")
    return input_error(begin + " must be a word, found '" + std::string(word) + "'");
  return {};
}

Status check_words(std::string_view function, const Call& call) {
  if (Status s = check_word(function, "type", call.text(0)); !s) return s;
  return call.size() < 2 ? Status() : check_word(function, "name", call.text(1));
}

/// A resource of the index: of type `packages` for every package, else what the prefixes' index folders hold.
bool find_resource(const Files& files, std::string_view type, std::string_view name, std::string& content,
                   std::string& prefix) {
  for (const std::string& package : files.packages()) {
    prefix = *files.prefix(package);
    if (type == "packages" && package == name) {
      content.clear();
      return true;
    }
    const auto text =
        files.read({marker(files, package, type, name), "ament_index/" + std::string(type) + '/' + std::string(name)});
    if (text) {
      content = *text;
      return true;
    }
  }
  return false;
}

Value list(const std::vector<std::string>& texts) {
  std::vector<Value> items;
  for (const std::string& t : texts) items.push_back(Value::string(t));
  return Value::multifield(std::move(items));
}

/// Where packages are, as rules ask for it.
class AmentIndexPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status clips_env_init(EnvironmentGuard environment) override {
    struct Entry {
      FunctionSpec spec;
      Look look;
    };
    const auto text = [](Expected<std::string> value) -> Expected<Value> {
      if (!value) return value.error();
      return Value::string(*value);
    };
    const std::vector<Entry> entries{
        {{"ament-index-get-package-prefix", "sb", 1, 1, ";sy", FunctionKind::kPure, name(), "Prefix of a package."},
         [text](const Files& files, Call& call) { return text(files.prefix(call.text(0))); }},
        {{"ament-index-get-package-share-directory", "sb", 1, 1, ";sy", FunctionKind::kPure, name(),
          "Share directory of a package."},
         [text](const Files& files, Call& call) { return text(files.share_directory(call.text(0))); }},
        {{"ament-index-get-packages-with-prefixes", "mb", 0, 0, "", FunctionKind::kPure, name(),
          "Packages and their prefixes, in turn."},
         [](const Files& files, Call&) -> Expected<Value> {
           std::vector<std::string> out;
           for (const std::string& package : files.packages()) {
             out.push_back(package);
             out.push_back(*files.prefix(package));
           }
           return list(out);
         }},
        {{"ament-index-get-resource", "bm", 2, 2, ";sy;sy", FunctionKind::kPure, name(),
          "Content and path of a resource, or FALSE."},
         [](const Files& files, Call& call) -> Expected<Value> {
           if (Status s = check_words("get_resource", call); !s) return s.error();
           std::string content, prefix;
           if (!find_resource(files, call.text(0), call.text(1), content, prefix)) return Value::boolean(false);
           return list({content, prefix});
         }},
        {{"ament-index-get-resources", "mb", 1, 1, ";sy", FunctionKind::kPure, name(),
          "Resources of a type and their prefixes, in turn."},
         [](const Files& files, Call& call) -> Expected<Value> {
           if (Status s = check_words("get_resources", call); !s) return s.error();
           return list(resources(files, call.text(0)));
         }},
        {{"ament-index-get-search-paths", "m", 0, 0, "", FunctionKind::kPure, name(), "All prefixes."},
         [](const Files& files, Call&) -> Expected<Value> { return list(prefixes(files)); }},
        {{"ament-index-has-resource", "bs", 2, 2, ";sy;sy", FunctionKind::kPure, name(),
          "Whether there is such a resource; with compat: next its prefix, or FALSE."},
         [next = context().run.next](const Files& files, Call& call) -> Expected<Value> {
           if (Status s = check_words("has_resource", call); !s) return s.error();
           std::string content, prefix;
           const bool found = find_resource(files, call.text(0), call.text(1), content, prefix);
           return found && next ? Value::string(prefix) : Value::boolean(found);
         }},
    };
    for (const Entry& e : entries)
      if (Status s = environment.engine().add_function(e.spec, looking(*this, *environment, e.look)); !s) return s;
    return {};
  }

 private:
  static std::vector<std::string> resources(const Files& files, std::string_view type) {
    std::vector<std::pair<std::string, std::string>> found;  // name, prefix
    if (type == "packages")
      for (const std::string& package : files.packages()) found.emplace_back(package, *files.prefix(package));
    else
      for (const std::string& prefix : prefixes(files)) {
        std::error_code ignored;
        const auto folder = std::filesystem::path(prefix) / "share" / "ament_index" / "resource_index" / type;
        for (const auto& file : std::filesystem::directory_iterator(folder, ignored))
          found.emplace_back(file.path().filename().string(), prefix);
      }
    std::sort(found.begin(), found.end());
    std::vector<std::string> out;
    for (auto& [resource, prefix] : found) {
      out.push_back(std::move(resource));
      out.push_back(std::move(prefix));
    }
    return out;
  }
};

}  // namespace

PluginType ament_index_plugin() {
  return {"cx::AmentIndexPlugin", {}, [](PluginContext c) { return std::make_unique<AmentIndexPlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
