#include "cx/node/parameters.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/node/rcl_yaml.h"
#include "cx/yaml/yaml.h"

namespace cxlab::cx {

std::string_view to_string(Parameter::Type type) {
  static constexpr std::string_view kWords[] = {"nothing", "a bool", "an integer", "a double", "a string", "a list"};
  return kWords[static_cast<std::size_t>(type)];
}

namespace {

/// As ROS reads it, with C's prefixes: `0x10` is 16, `010` is 8 and `08` no integer.
bool is_integer(const std::string& text, std::int64_t& out) {
  char* end = nullptr;
  errno = 0;
  out = std::strtoll(text.c_str(), &end, 0);
  return errno == 0 && end != text.c_str() && *end == '\0';
}

/// `.inf`, `-.inf`, `.nan` are numbers as `inf` is.
std::optional<double> read_real(std::string text) {
  for (const std::string_view word : {".inf", ".Inf", ".INF", ".nan", ".NaN", ".NAN"})
    if (text.ends_with(word) && text.size() <= word.size() + 1) text.erase(text.size() - word.size(), 1);
  return read_number<double>(text);
}

Parameter scalar(Parameter::Type type, std::string text, const char* file) {
  Parameter p;
  p.type = type;
  p.text = std::move(text);
  p.file = file;
  return p;
}

constexpr const char* kDefault = "default";

/// Returns the type of a scalar that is not in quotes; `text` becomes the value as it is kept.
Parameter::Type type_of_plain(std::string& text) {
  bool truth = false;
  std::int64_t integer = 0;
  if (is_integer(text, integer)) {
    text = std::to_string(integer);
    return Parameter::Type::kInteger;
  }
  if (const auto number = read_real(text)) {
    text = shortest_text(*number);
    return Parameter::Type::kDouble;
  }
  if (!YAML::convert<bool>::decode(YAML::Node(text), truth)) return Parameter::Type::kString;
  text = truth ? "true" : "false";
  return Parameter::Type::kBool;
}

Parameter to_parameter(const YAML::Node& node, const std::string& file) {
  Parameter p;
  p.file = file;
  p.line = node.Mark().line + 1;
  if (node.IsSequence()) {
    p.type = Parameter::Type::kList;
    for (const auto& item : node) p.items.push_back(to_parameter(item, file));
    return p;
  }
  if (!node.IsScalar()) return p;
  p.text = node.Scalar();
  p.type = node.Tag() == "!" ? Parameter::Type::kString : type_of_plain(p.text);  // "!": in quotes
  return p;
}

using Values = std::map<std::string, Parameter, std::less<>>;

void flatten(const YAML::Node& node, const std::string& prefix, const std::string& file, Values& out) {
  if (!node.IsMap()) {
    out[prefix] = to_parameter(node, file);
    return;
  }
  for (const auto& item : node) {
    const std::string key = item.first.Scalar();
    flatten(item.second, prefix.empty() ? key : prefix + '.' + key, file, out);
  }
}

/// A section of the file: the path of keys above `ros__parameters`, as one name.
struct Section {
  std::string name;
  YAML::Node parameters;
  int line = 0;
};

void find_sections(const YAML::Node& node, const std::string& path, std::vector<Section>& out) {
  if (!node.IsMap()) return;
  for (const auto& item : node) {
    const std::string key = item.first.Scalar();
    if (key == "ros__parameters") {
      out.push_back({path, item.second, item.first.Mark().line + 1});
      continue;
    }
    find_sections(item.second,
                  path.empty() || path.ends_with('/') || key.starts_with('/') ? path + key : path + '/' + key, out);
  }
}

std::vector<std::string> segments(std::string_view name) {
  std::vector<std::string> out;
  while (!name.empty()) {
    const std::size_t slash = name.find('/');
    if (slash != 0) out.emplace_back(name.substr(0, slash));
    if (slash == std::string_view::npos) break;
    name.remove_prefix(slash + 1);
  }
  return out;
}

/// `**` stands for any number of segments, `*` for one, as in ROS.
bool matches(const std::vector<std::string>& pattern, std::size_t p, const std::vector<std::string>& name,
             std::size_t n) {
  if (p == pattern.size()) return n == name.size();
  if (pattern[p] == "**")
    return matches(pattern, p + 1, name, n) || (n < name.size() && matches(pattern, p, name, n + 1));
  return n < name.size() && (pattern[p] == "*" || pattern[p] == name[n]) && matches(pattern, p + 1, name, n + 1);
}

/// Reads a file as the parser of rcl does, which knows less of YAML, and keeps what that refuses.
class RclParser final : public YAML::EventHandler {
 public:
  explicit RclParser(std::string file) : file_(std::move(file)) {}
  std::vector<Error> take() { return std::move(errors_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { value(mark, Parameter::Type::kNone); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    refuse(mark, "an alias, which it does not know");
    value(mark, Parameter::Type::kNone);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& text) override {
    if (!open_.empty() && !open_.back().is_list && !open_.back().has_key) {
      open_.back().has_key = true;
      open_.back().key = text;
      return;
    }
    std::string kept = text;
    value(mark, tag == "!" ? Parameter::Type::kString : type_of_plain(kept));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    if (in_list()) refuse(mark, "a list in a list");
    open_.push_back({.is_list = true, .parameters = below_parameters()});
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    if (in_list()) refuse(mark, "a map in a list");
    open_.push_back({.is_list = false, .parameters = below_parameters()});
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    bool is_list = false, parameters = false, has_key = false, mixed = false;
    std::string key = {};
    Parameter::Type type = Parameter::Type::kNone;  // of the values of a list
  };

  bool in_list() const { return !open_.empty() && open_.back().is_list; }
  bool below_parameters() const {
    return !open_.empty() && (open_.back().parameters || open_.back().key == "ros__parameters");
  }
  void close() {
    open_.pop_back();
    if (!open_.empty()) open_.back().has_key = false;
  }
  void refuse(const YAML::Mark& mark, const std::string& what) {
    errors_.push_back(input_error("strict-cx: yaml: found " + what +
                                      ": rcl's parser refuses the file, and the node does "
                                      "not start",
                                  file_, mark.line + 1));
  }
  void value(const YAML::Mark& mark, Parameter::Type type) {
    if (open_.empty()) return;
    Open& in = open_.back();
    if (!in.is_list) {
      if (!in.parameters && type != Parameter::Type::kNone)
        refuse(mark, "a value of '" + in.key + "' outside of ros__parameters");
      in.has_key = false;
      return;
    }
    if (in.type == Parameter::Type::kNone) in.type = type;
    if (type == Parameter::Type::kNone || in.type == type || std::exchange(in.mixed, true)) return;
    refuse(mark, "a list with " + std::string(to_string(in.type)) + " and " + std::string(to_string(type)));
  }

  std::string file_;
  std::vector<Open> open_;
  std::vector<Error> errors_;
};

Error wrong_type(const Parameter& p, std::string_view name, std::string_view expected) {
  using Type = Parameter::Type;
  std::string found(to_string(p.type));
  if (!p.text.empty()) found = "'" + p.text + "' (" + found + ")";
  std::string message = "parameter '" + std::string(name) + "': " + found_expected(found, std::string(expected));
  const bool plain = p.type == Type::kBool || p.type == Type::kInteger || p.type == Type::kDouble;
  if (plain && expected.ends_with("string")) message += ": in quotes it is one";
  if (plain && expected.ends_with("strings")) message += ": in quotes it is a string";
  return input_error(std::move(message), p.file, p.line);
}

}  // namespace

Expected<Parameters> Parameters::load(const std::filesystem::path& file, const std::string& node,
                                      const std::string& name_space) {
  Parameters out;
  out.file_ = file.string();
  auto text = read_file(file);
  if (!text) return text.error();
  try {
    std::vector<Section> sections;
    find_sections(yaml::load(*text), "", sections);
    std::vector<std::string> full = segments(name_space);
    full.push_back(node);
    std::vector<const Section*> applying;
    for (const Section& s : sections) {
      auto pattern = segments(s.name);
      const bool relative = !s.name.starts_with('/');
      // A bare node name applies in whatever namespace the node is, as CX is launched with one.
      if (relative && pattern.size() == 1) pattern.insert(pattern.begin(), "**");
      if (matches(pattern, 0, full, 0)) applying.push_back(&s);
    }
    if (applying.empty()) {
      std::string message = "no parameters for the node '" + node + "': expected a section '" + node +
                            ":' or '/**:' with 'ros__parameters:' below it";
      if (!sections.empty()) message += ", found '" + sections.front().name + "'";
      return input_error(std::move(message), out.file_, sections.empty() ? 1 : sections.front().line);
    }
    std::ranges::stable_sort(applying, [](const Section* a, const Section* b) {
      return (a->name.find('*') != std::string::npos) > (b->name.find('*') != std::string::npos);
    });
    for (const Section* s : applying)
      if (s->parameters.IsMap()) flatten(s->parameters, "", out.file_, out.values_);
  } catch (const YAML::Exception& e) {
    return yaml::syntax_error(e, *text, out.file_);
  }
  return out;
}

std::vector<Error> refused_by_rcl(const std::filesystem::path& file) {
  const auto text = read_file(file);
  if (!text) return {};
  RclParser parser(file.string());
  std::istringstream in(*text);
  try {
    YAML::Parser(in).HandleNextDocument(parser);
  } catch (const YAML::Exception&) {
    return {};  // `load` has told it
  }
  return parser.take();
}

const Parameter* Parameters::find(std::string_view name) const {
  const auto found = values_.find(name);
  if (found == values_.end()) return nullptr;
  found->second.asked_for = true;
  return &found->second;
}

Status Parameters::set(const std::string& name, const std::string& yaml, const Origin& origin) {
  Values values;
  try {
    flatten(yaml::load(yaml), name, origin.source, values);
  } catch (const YAML::Exception& e) {
    return input_error("parameter '" + name + "': the value is not YAML: " + e.msg, origin);
  }
  for (auto& [key, value] : values) {
    value.line = origin.line;  // not that in the value
    for (Parameter& item : value.items) item.line = origin.line;
    value.given = true;
    values_[key] = std::move(value);
  }
  return {};
}

std::vector<Error> Parameters::in_vain() const {
  std::vector<Error> out;
  for (const auto& [name, value] : values_) {
    if (!value.given || value.asked_for) continue;
    if (value.at_run_time) {
      out.push_back(input_error("parameter '" + name +
                                "' was set during the run, but nothing has read it since. Rules that read it before go "
                                "on with the old value, "
                                "for example in a global or a fact"));
      continue;
    }
    std::vector<std::string> others = names();
    std::erase_if(others, [this, &word = name](const std::string& other) {
      if (const Parameter& it = values_.at(other); it.given && !it.asked_for) return true;  // nothing reads it, either
      // Names of the same group are compared without the group.
      std::size_t group = 0;
      for (std::size_t i = 0; i < std::min(word.size(), other.size()) && word[i] == other[i]; ++i)
        if (word[i] == '.') group = i + 1;
      return word == other || nearest_word(word.substr(group), {other.substr(group)}).empty();
    });
    out.push_back(input_error("parameter '" + name + "' was set, but nothing reads it" + did_you_mean(name, others),
                              value.file, value.line));
  }
  return out;
}

std::vector<std::string> Parameters::names() const {
  std::vector<std::string> out;
  for (const auto& [name, value] : values_) out.push_back(name);
  return out;
}

std::vector<std::string> Parameters::below(std::string_view group) const {
  std::vector<std::string> out;
  const std::string prefix = group.empty() ? std::string() : std::string(group) + '.';
  for (auto it = values_.lower_bound(prefix); it != values_.end() && it->first.starts_with(prefix); ++it) {
    std::string key = it->first.substr(prefix.size());
    key.resize(std::min(key.size(), key.find('.')));
    if (out.empty() || out.back() != key) out.push_back(std::move(key));
  }
  return out;
}

Error Parameters::error_at(std::string_view name_or_group, std::string message) const {
  const Parameter* at = nullptr;
  if (const auto found = values_.find(name_or_group); found != values_.end()) at = &found->second;
  if (at) return input_error(std::move(message), at->file, at->line);
  const std::string prefix = std::string(name_or_group) + '.';
  for (auto it = values_.lower_bound(prefix); it != values_.end() && it->first.starts_with(prefix); ++it)
    if (!at || it->second.line < at->line) at = &it->second;
  return at ? input_error(std::move(message), at->file, at->line) : input_error(std::move(message), file_);
}

Status Parameters::read(std::string_view name, bool& field) const {
  const Parameter* p = find(name);
  if (!p) return {};
  if (p->type != Parameter::Type::kBool) return wrong_type(*p, name, "a bool");
  field = p->text == "true";
  return {};
}

Status Parameters::read(std::string_view name, std::int64_t& field) const {
  const Parameter* p = find(name);
  if (!p) return {};
  if (p->type != Parameter::Type::kInteger) return wrong_type(*p, name, "an integer");
  field = read_number<std::int64_t>(p->text).value_or(field);
  return {};
}

Status Parameters::read(std::string_view name, double& field) const {
  const Parameter* p = find(name);
  if (!p) return {};
  if (p->type != Parameter::Type::kDouble && p->type != Parameter::Type::kInteger)
    return wrong_type(*p, name, "a double");
  field = read_number<double>(p->text).value_or(field);
  return {};
}

Status Parameters::read(std::string_view name, std::string& field) const {
  const Parameter* p = find(name);
  if (!p) return {};
  if (p->type != Parameter::Type::kString) return wrong_type(*p, name, "a string");
  field = p->text;
  return {};
}

Status Parameters::read(std::string_view name, std::vector<std::string>& field) const {
  const Parameter* p = find(name);
  if (!p) return {};
  if (p->type != Parameter::Type::kList) return wrong_type(*p, name, "a list of strings");
  field.clear();
  for (const Parameter& item : p->items) {
    if (item.type != Parameter::Type::kString) return wrong_type(item, name, "a list of strings");
    field.push_back(item.text);
  }
  return {};
}

Parameter Parameters::default_of(bool value) {
  return scalar(Parameter::Type::kBool, value ? "true" : "false", kDefault);
}
Parameter Parameters::default_of(std::int64_t value) {
  return scalar(Parameter::Type::kInteger, std::to_string(value), kDefault);
}
Parameter Parameters::default_of(double value) {
  return scalar(Parameter::Type::kDouble, shortest_text(value), kDefault);
}
Parameter Parameters::default_of(const std::string& value) { return scalar(Parameter::Type::kString, value, kDefault); }
Parameter Parameters::default_of(const std::vector<std::string>& value) {
  Parameter p = scalar(Parameter::Type::kList, {}, kDefault);
  for (const std::string& text : value) p.items.push_back(default_of(text));
  return p;
}

}  // namespace cxlab::cx
