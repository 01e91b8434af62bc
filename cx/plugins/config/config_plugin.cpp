#include <yaml-cpp/yaml.h>

#include <cmath>

#include "cx/base/number_text.h"
#include "cx/plugins/builtin.h"
#include "cx/yaml/yaml.h"

namespace cxlab::cx {

namespace {

constexpr const char* kTemplate = R"((deftemplate confval
  (slot path (type STRING))
  (slot type (type SYMBOL) (allowed-values FLOAT UINT INT BOOL STRING))
  (slot value)
  (slot is-list (type SYMBOL) (allowed-values TRUE FALSE) (default FALSE))
  (multislot list-value)))";

/// A number as CLIPS reads the word; words that are none for CLIPS (`0x10`, `.inf`) are symbols.
Value word(const std::string& text) {
  if (const auto integer = read_number<std::int64_t>(text)) return Value::integer(*integer);
  if (const auto number = read_number<double>(text); number && std::isfinite(*number)) return Value::number(*number);
  return Value::symbol(text);
}

/// The names between the slashes of a prefix, which begins with one; with `quotes`, a name in single quotes may hold
/// slashes of its own.
std::vector<std::string> segments_of(std::string_view prefix, bool quotes) {
  std::vector<std::string> segments;
  bool quoted = false;
  for (const char c : prefix) {
    if (quotes && c == '\'')
      quoted = !quoted;
    else if (c == '/' && !quoted)
      segments.emplace_back();
    else
      segments.back() += c;
  }
  return segments;
}

/// Asserts `confval` facts for a subtree, in document order.
class Loader {
 public:
  Loader(Environment& environment, const std::string& logger) : environment_(environment), logger_(logger) {}

  void assert_below(const std::string& path, const YAML::Node& node) {
    if (node.IsMap()) {
      for (const auto& item : node)
        assert_below(path + '/' + (item.first.IsScalar() ? item.first.Scalar() : std::string()), item.second);
    } else if (node.IsSequence()) {
      assert_sequence(path, node);
    } else if (node.IsScalar()) {
      assert_scalar(path, node);
    } else {
      environment_.log(LogLevel::kError, logger_, "NULL YAML KEY " + path);
    }
  }

 private:
  static bool all_scalars(const YAML::Node& sequence) {
    for (const auto& item : sequence)
      if (!item.IsScalar()) return false;
    return true;
  }

  void put(const std::string& path, const std::string& type, const Value& value, bool is_list = false,
           std::vector<Value> values = {}) {
    const auto fact =
        environment_.engine().assert_fact("confval", {{"path", Value::string(path)},
                                                      {"type", Value::symbol(type)},
                                                      {"value", value},
                                                      {"is-list", Value::boolean(is_list)},
                                                      {"list-value", Value::multifield(std::move(values))}});
    if (!fact) environment_.log(LogLevel::kError, logger_, fact.error().message);
  }

  void assert_scalar(const std::string& path, const YAML::Node& node) {
    const std::string type = scalar_type(node);
    const std::string& text = node.Scalar();
    if (type == "STRING") return put(path, "STRING", Value::string(text));
    const bool truth = text == "true" || text == "false";
    put(path, type, type != "BOOL" ? word(text) : truth ? Value::boolean(text == "true") : Value::symbol(text));
  }

  /// The scalars of a list are one fact, after what else the list holds.
  void assert_sequence(const std::string& path, const YAML::Node& node) {
    std::vector<Value> scalars;
    std::size_t index = 0;
    for (const auto& item : node) {
      const std::string at = path + '/' + std::to_string(index++);
      if (item.IsScalar()) {
        scalars.push_back(Value::string(item.Scalar()));
        continue;
      }
      if (!item.IsMap()) {
        assert_below(at, item);
        continue;
      }
      for (const auto& entry : item) {
        const std::string key = at + '/' + (entry.first.IsScalar() ? entry.first.Scalar() : std::string());
        if (entry.second.IsScalar())
          put(key, scalar_type(entry.second), Value::string(entry.second.Scalar()));
        else if (entry.second.IsSequence() && all_scalars(entry.second))
          assert_sequence(key, entry.second);
        else
          assert_below(path + '/' + (entry.first.IsScalar() ? entry.first.Scalar() : std::string()), entry.second);
      }
    }
    if (!scalars.empty()) put(path, "STRING", Value::symbol("nil"), true, std::move(scalars));
  }

  static std::string scalar_type(const YAML::Node& node) {
    bool truth = false;
    int integer = 0;
    double number = 0;
    if (YAML::convert<bool>::decode(node, truth)) return "BOOL";
    if (YAML::convert<int>::decode(node, integer)) return "INT";
    return YAML::convert<double>::decode(node, number) ? "FLOAT" : "STRING";
  }

  Environment& environment_;
  const std::string& logger_;
};

/// Reads YAML into facts.
class ConfigPlugin final : public Plugin {
 public:
  using Plugin::Plugin;

  Status clips_env_init(EnvironmentGuard environment) override {
    Environment& e = *environment;
    if (!e.engine().has("deftemplate", "confval"))
      if (Status s = e.engine().build(kTemplate, "cx_config_plugin/confval.clp", 1); !s) return s;
    return e.engine().add_function(
        {"config-load", "v", 2, 2, ";sy;sy", FunctionKind::kActing, name(),
         "Asserts confval facts for a file, below a prefix."},
        [this, &e](Call& call) { load(e, std::string(call.text(0)), std::string(call.text(1))); });
  }

 private:
  void load(Environment& environment, const std::string& file, std::string prefix) {
    const auto abort = [&](const std::string& what) {
      log(environment, LogLevel::kError, what);
      log(environment, LogLevel::kWarn, "Aborting config loading...");
    };
    // The content is part of the input log: rules decide by it.
    const Value content = environment.look("config-load " + file, [&] {
      auto found = environment.files().find_for_rules(file);
      if (!found) {
        abort(found.error().text());
        return Value::boolean(false);
      }
      auto text = environment.files().read(*found);
      if (!text) {
        abort(text.error().text());
        return Value::boolean(false);
      }
      return Value::string(std::move(*text));
    });
    if (!content.is(ValueType::kString)) return;

    if (!prefix.starts_with('/')) prefix.insert(0, 1, '/');
    if (prefix.ends_with('/')) prefix.pop_back();
    try {
      YAML::Node node = yaml::load(content.text());
      std::string path;
      for (const std::string& segment : segments_of(prefix, context().run.next)) {
        if (!node.IsMap() || !node[segment].IsDefined()) {
          log(environment, LogLevel::kError, "Segment '" + segment + "' not found in YAML file.");
          return;
        }
        node.reset(node[segment]);
        path += '/' + segment;
      }
      if (context().run.next && !node.IsMap() && !node.IsSequence() && !node.IsScalar()) {
        log(environment, LogLevel::kError, "Unsupported root node type after prefix traversal");
        return;
      }
      Loader(environment, name()).assert_below(path, node);
    } catch (const YAML::Exception& e) {
      abort(yaml::syntax_error(e, content.text(), file).text());
    }
  }
};

}  // namespace

PluginType config_plugin() {
  return {"cx::ConfigPlugin", {}, [](PluginContext c) { return std::make_unique<ConfigPlugin>(std::move(c)); }};
}

}  // namespace cxlab::cx
