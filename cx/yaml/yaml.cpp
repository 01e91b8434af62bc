#include "cx/yaml/yaml.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <tuple>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/yaml/writer.h"

namespace cxlab::yaml {

struct Value::Shared {
  /// Something given by `Document::set`.
  struct Override {
    std::string path, option;
  };
  std::string file;
  std::vector<Error> errors;
  std::vector<Override> overrides;

  /// Where the value at that path comes from: the last option that set it or something around it, or that made it for
  /// something below it; else the file.
  Origin origin(const std::string& path, int line) const {
    const auto is_around = [](const std::string& whole, const std::string& part) {
      return part.starts_with(whole) && (part[whole.size()] == '.' || part[whole.size()] == '[');
    };
    for (auto o = overrides.rbegin(); o != overrides.rend(); ++o)
      if (path == o->path || is_around(o->path, path) || (line <= 0 && is_around(path, o->path))) return {o->option, 0};
    return {file, line};
  }
  void add(const std::string& path, std::string what, int line) {
    errors.push_back(input_error(std::move(what), origin(path, line)));
  }
};

namespace {

/// Counts the values of a tree, each alias as often as it stands there, and throws where it has no end.
class Walk {
 public:
  explicit Walk(std::size_t most) : most_(most) {}

  void through(const YAML::Node& node) {
    if (++count_ > most_) throw YAML::RepresentationException(node.Mark(), "aliases give too many values");
    if (!node.IsMap() && !node.IsSequence()) return;
    for (const YAML::Node& outer : open_)
      if (outer.is(node)) throw YAML::RepresentationException(node.Mark(), "found an alias within what it stands for");
    open_.push_back(node);
    for (const auto& item : node) {
      if (node.IsMap()) through(item.first);
      through(node.IsMap() ? item.second : YAML::Node(item));
    }
    open_.pop_back();
  }

 private:
  std::size_t most_, count_ = 0;
  std::vector<YAML::Node> open_;
};

/// Notes where a document starts.
struct DocumentStart final : YAML::EventHandler {
  YAML::Mark at;
  void OnDocumentStart(const YAML::Mark& mark) override { at = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

/// A text without aliases has no more values than characters.
void check_end(const YAML::Node& root, const std::string& text) {
  constexpr std::size_t kMostValues = 1'000'000;
  Walk(std::max(kMostValues, text.size())).through(root);
}

const char* kind_of(const YAML::Node& node) {
  static constexpr const char* kWords[] = {"nothing", "nothing", "a scalar", "a list",
                                           "a map"};  // undefined, null, ...
  return kWords[node.Type()];
}

/// `a.b[0].c` as steps: keys and indices.
struct Step {
  std::string key;
  int index = -1;
};

bool split_path(const std::string& path, std::vector<Step>& steps) {
  std::size_t i = 0;
  while (i < path.size()) {
    if (path[i] == '[') {
      const std::size_t end = path.find(']', i);
      if (end == std::string::npos) return false;
      const auto index = read_number<int>(std::string_view(path).substr(i + 1, end - i - 1));
      if (!index || *index < 0) return false;
      steps.push_back({{}, *index});
      i = end + 1;
      if (i < path.size() && path[i] == '.') ++i;
      continue;
    }
    const std::size_t end = std::min(path.find('.', i), path.find('[', i));
    const std::string key = path.substr(i, end == std::string::npos ? end : end - i);
    if (key.empty()) return false;
    steps.push_back({key, -1});
    if (end == std::string::npos) break;
    i = path[end] == '.' ? end + 1 : end;
    if (i == path.size()) return false;
  }
  return !steps.empty();
}

/// The path as values have it: `a[0].b`, also where it was written `a[0]b`.
std::string path_of(const std::vector<Step>& steps) {
  std::string path;
  for (const Step& step : steps)
    if (step.index >= 0)
      path += '[' + std::to_string(step.index) + ']';
    else
      path += (path.empty() ? "" : ".") + step.key;
  return path;
}

}  // namespace

Value::operator bool() const { return node_ && node_->IsDefined() && !node_->IsNull(); }
int Value::line() const { return node_ && node_->IsDefined() ? node_->Mark().line + 1 : 0; }
const std::string& Value::file() const { return shared_->file; }
Origin Value::origin() const { return shared_->origin(path_, line()); }
bool Value::is_map() const { return node_ && node_->IsMap(); }
bool Value::is_list() const { return node_ && node_->IsSequence(); }
bool Value::is_scalar() const { return node_ && node_->IsScalar(); }
std::string Value::text() const { return is_scalar() ? node_->Scalar() : std::string(); }

std::string Value::found() const { return is_scalar() ? "'" + text() + "'" : kind_of(*node_); }

std::string Value::dump() const { return node_ && node_->IsDefined() ? to_text(*node_) : std::string(); }

void Value::fail(std::string what) const {
  if (is_told_) return;
  if (!path_.empty()) what = path_ + ": " + what;
  shared_->add(path_, std::move(what), line());
}

std::string Value::as_string(std::string fallback) const {
  if (is_scalar()) return node_->Scalar();
  fail(found_expected(kind_of(*node_), "a text"));
  return fallback;
}

double Value::as_number(double fallback) const {
  const auto number = read_number<double>(text());
  if (number && std::isfinite(*number)) return *number;
  fail(found_expected(found(), "a number"));
  return fallback;
}

std::int64_t Value::as_integer(std::int64_t fallback) const {
  if (const auto number = read_number<std::int64_t>(text())) return *number;
  fail(found_expected(found(), "an integer"));
  return fallback;
}

bool Value::as_bool(bool fallback) const {
  bool value = fallback;
  if (is_scalar() && YAML::convert<bool>::decode(*node_, value)) return value;
  fail(found_expected(found(), "true or false"));
  return fallback;
}

std::vector<std::string> Value::as_strings() const {
  if (is_scalar()) return {text()};
  std::vector<std::string> out;
  for (const auto& item : as_list()) out.push_back(item.as_string());
  return out;
}

std::vector<Value> Value::as_list() const {
  std::vector<Value> out;
  if (!is_list()) {
    fail(found_expected(kind_of(*node_), "a list"));
    return out;
  }
  for (const auto& item : *node_) {
    Value value;
    value.shared_ = shared_;
    value.node_ = std::make_shared<YAML::Node>(item);
    value.path_ = path_ + '[' + std::to_string(out.size()) + ']';
    out.push_back(std::move(value));
  }
  return out;
}

Map Value::as_map() const {
  Map map;
  map.value_ = *this;
  if (*this && !is_map()) fail(found_expected(kind_of(*node_), "a map"));
  return map;
}

Value Map::get(std::string_view key) {
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.emplace_back(key);
  Value value;
  value.shared_ = value_.shared_;
  value.path_ = value_.path_.empty() ? std::string(key) : value_.path_ + '.' + std::string(key);
  const YAML::Node& node = *value_.node_;
  const YAML::Node found = node.IsMap() ? node[std::string(key)] : YAML::Node();
  // A key that is not there gives a node that throws whatever it is asked.
  const bool there = node.IsMap() && found.IsDefined();
  value.node_ = std::make_shared<YAML::Node>(there ? found : YAML::Node(YAML::NodeType::Undefined));
  return value;
}

bool Map::has(std::string_view key) { return static_cast<bool>(get(key)); }

Value Map::require(std::string_view key) {
  Value value = get(key);
  if (!value) {
    missing_.emplace_back(key, value_.shared_->errors.size());
    value_.fail("key '" + std::string(key) + "' is missing");
    value.is_told_ = true;
  }
  return value;
}

Map& Map::read(std::string_view key, std::string& field) {
  if (const Value v = get(key)) field = v.as_string(field);
  return *this;
}
Map& Map::read(std::string_view key, double& field) {
  if (const Value v = get(key)) field = v.as_number(field);
  return *this;
}
Map& Map::read(std::string_view key, std::int64_t& field) {
  if (const Value v = get(key)) field = v.as_integer(field);
  return *this;
}
Map& Map::read(std::string_view key, int& field) {
  if (const Value v = get(key)) {
    const std::int64_t number = v.as_integer(field);
    if (number < INT32_MIN || number > INT32_MAX)
      v.fail("found " + v.text() + ", which is out of range");
    else
      field = static_cast<int>(number);
  }
  return *this;
}
Map& Map::read(std::string_view key, std::uint64_t& field) {
  if (const Value v = get(key)) {
    if (const auto number = read_number<std::uint64_t>(v.text()))
      field = *number;
    else
      v.fail(found_expected(v.found(), "an integer from 0 to " + std::to_string(UINT64_MAX)));
  }
  return *this;
}
Map& Map::read(std::string_view key, bool& field) {
  if (const Value v = get(key)) field = v.as_bool(field);
  return *this;
}
Map& Map::read(std::string_view key, std::vector<std::string>& field) {
  if (const Value v = get(key)) field = v.as_strings();
  return *this;
}
Map& Map::read_seconds(std::string_view key, SimTime& field) {
  if (const Value v = get(key)) {
    const double seconds = v.as_number();
    if (seconds < 0 || seconds > 1e9)
      v.fail(found_expected(v.text(), "seconds from 0 to 1e9"));
    else
      field = from_seconds(seconds);
  }
  return *this;
}
Map& Map::read_word(std::string_view key, std::string& field, const std::vector<std::string>& words) {
  if (const Value v = get(key)) {
    const std::string word = v.as_string(field);
    if (std::find(words.begin(), words.end(), word) != words.end()) {
      field = word;
      return *this;
    }
    if (!v.is_scalar()) return *this;  // reported already
    v.fail(found_text(word, "one of: " + some_of_and_nearest(word, words)));
  }
  return *this;
}

Map& Map::read(std::string_view key, std::vector<std::pair<std::string, std::string>>& field) {
  if (const Value v = get(key)) {
    field.clear();
    for (const auto& [name, text] : v.as_map().entries()) field.emplace_back(name, text.as_string());
  }
  return *this;
}

void Map::fail(const Error& error) {
  std::string what = error.message;
  if (what.starts_with(value_.path_ + '.')) what.erase(0, value_.path_.size() + 1);
  std::vector<Step> steps;
  const std::size_t end = what.find(": ");
  if (end == std::string::npos || !split_path(what.substr(0, end), steps) ||
      std::find(asked_.begin(), asked_.end(), steps.front().key) == asked_.end())
    return fail(std::move(what));
  Value at = value_;
  int line = value_.line();  // of the innermost value that is there
  for (const Step& step : steps) {
    const std::vector<Value> items = step.index >= 0 && at.is_list() ? at.as_list() : std::vector<Value>();
    if (step.index >= 0 && static_cast<std::size_t>(step.index) >= items.size()) break;
    at = step.index >= 0 ? items[static_cast<std::size_t>(step.index)] : at.as_map().get(step.key);
    if (!at) break;
    line = at.line();
  }
  const std::string path = (value_.path_.empty() ? "" : value_.path_ + '.') + what.substr(0, end);
  value_.shared_->add(path, path + what.substr(end), line);
}

std::vector<std::pair<std::string, Value>> Map::entries() {
  std::vector<std::pair<std::string, Value>> out;
  if (!value_.is_map()) return out;
  for (const auto& item : *value_.node_) {
    const std::string key = item.first.Scalar();
    out.emplace_back(key, get(key));
  }
  return out;
}

bool Map::finish() {
  if (!value_.is_map()) return true;
  const std::size_t before = value_.shared_->errors.size();
  std::set<std::string> seen;
  std::vector<std::tuple<std::string, std::string, int>> close_by, far_off;  // path, what, line
  for (const auto& item : *value_.node_) {
    if (item.first.IsScalar() && !seen.insert(item.first.Scalar()).second)
      value_.shared_->errors.push_back(input_error("key '" + item.first.Scalar() + "' stands here a second time",
                                                   value_.shared_->file, item.first.Mark().line + 1));
    const std::string key = item.first.IsScalar() ? item.first.Scalar() : "(a key that is not a text)";
    if (std::find(asked_.begin(), asked_.end(), key) != asked_.end()) continue;
    std::string what = "unknown key '" + key + "'";
    if (!value_.path_.empty()) what += " in '" + value_.path_ + "'";
    const std::string near = nearest_word(key, asked_);
    const auto missing = std::find_if(missing_.begin(), missing_.end(), [&](const auto& m) { return m.first == near; });
    if (missing != missing_.end()) {
      Error& error = value_.shared_->errors[missing->second];
      error.message += ", did you mean it by '" + key + "'?";
      if (error.line > 0) error.line = item.first.Mark().line + 1;
      missing_.erase(missing);
      continue;
    }
    what += near.empty() ? "; known are: " + some_of(asked_) : ", did you mean '" + near + "'?";
    (near.empty() ? far_off : close_by)
        .emplace_back(value_.path_.empty() ? key : value_.path_ + '.' + key, std::move(what),
                      item.first.Mark().line + 1);
  }
  for (auto* unknown : {&close_by, &far_off})
    for (auto& [path, what, line] : *unknown) value_.shared_->add(path, std::move(what), line);
  return value_.shared_->errors.size() == before;
}

Expected<Document> Document::load(const std::filesystem::path& file) {
  auto text = read_file(file);
  if (!text) return text.error();
  return parse(*text, file.string());
}

YAML::Node load(const std::string& text) {
  // YAML::LoadAll does not return from a text like ",a{]": each document is empty and ends where it began.
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentStart start;
  if (!parser.HandleNextDocument(start)) return {};
  if (parser.HandleNextDocument(start))
    throw YAML::RepresentationException(start.at, found_expected("a second document", "one"));
  const YAML::Node root = YAML::Load(text);
  check_end(root, text);
  return root;
}

Error syntax_error(const YAML::Exception& thrown, const std::string& text, const std::string& file) {
  // yaml-cpp names the line of the tab, or one of those after it.
  std::istringstream lines(text);
  std::string line;
  for (int i = 0; i <= thrown.mark.line && std::getline(lines, line); ++i)
    if (const std::size_t tab = line.find('\t'); i + 1 >= thrown.mark.line && tab < line.find_first_not_of(" \t"))
      return input_error(found_expected("a tab in the indentation", "spaces"), file, i + 1);
  if (thrown.msg == YAML::ErrorMsg::UNKNOWN_TOKEN && thrown.mark.column >= 0 &&
      static_cast<std::size_t>(thrown.mark.column) < line.size())
    return input_error(std::string("not YAML: found '") + line[static_cast<std::size_t>(thrown.mark.column)] +
                           "', with which no text of YAML begins; write the text in quotes",
                       file, thrown.mark.line + 1);
  const bool is_yaml = dynamic_cast<const YAML::RepresentationException*>(&thrown) != nullptr;
  std::string what = thrown.msg;
  what.resize(what.find_last_not_of(std::string_view(": \n\0", 4)) +
              1);  // yaml-cpp may end with a character that is not seen
  return input_error((is_yaml ? "" : "not YAML: ") + what, file, thrown.mark.line + 1);
}

Expected<Document> Document::parse(const std::string& text, const std::string& name) {
  Document document;
  document.root_.shared_ = std::make_shared<Value::Shared>();
  document.root_.shared_->file = name;
  try {
    document.root_.node_ = std::make_shared<YAML::Node>(yaml::load(text));
  } catch (const YAML::Exception& e) {
    return syntax_error(e, text, name);
  }
  if (document.root_.node_->IsNull()) *document.root_.node_ = YAML::Node(YAML::NodeType::Map);
  return document;
}

Status Document::set(const std::string& assignment, std::string option) {
  const std::size_t equals = assignment.find('=');
  if (option.empty()) option = "--set " + assignment;
  if (equals == std::string::npos) return usage_error(option + ": expected PATH=VALUE");
  return set(assignment.substr(0, equals), assignment.substr(equals + 1), option);
}

Status Document::set(const std::string& path, const std::string& yaml, const std::string& option) {
  const auto fail = [&](std::string what) { return Status(input_error(std::move(what), option)); };
  std::vector<Step> steps;
  if (!split_path(path, steps)) return fail("expected a path like a.b[0].c");
  YAML::Node value;
  try {
    value = cxlab::yaml::load(yaml);
  } catch (const YAML::Exception& e) {
    return fail("the value is not YAML: " + e.msg);
  }
  YAML::Node at = *root_.node_;
  if (at.IsDefined() && !at.IsMap()) return {};  // reported when it is read
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    const bool last = i + 1 == steps.size();
    if (step.index >= 0) {
      if (!at.IsSequence()) return fail("there is no list before [" + std::to_string(step.index) + "]");
      if (static_cast<std::size_t>(step.index) >= at.size())
        return fail("index " + std::to_string(step.index) + " is beyond the list's " + std::to_string(at.size()) +
                    " items");
      if (last)
        at[step.index] = value;
      else
        at.reset(at[step.index]);
      continue;
    }
    if (at.IsDefined() && !at.IsNull() && !at.IsMap())
      return fail("'" + step.key + "' is below " + kind_of(at) + ", expected a map");
    if (last) {
      at[step.key] = value;
      break;
    }
    if (!at[step.key].IsDefined() || at[step.key].IsNull())
      at[step.key] = YAML::Node(steps[i + 1].index >= 0 ? YAML::NodeType::Sequence : YAML::NodeType::Map);
    at.reset(at[step.key]);
  }
  root_.shared_->overrides.push_back({path_of(steps), option});
  return {};
}

Value Document::root() const { return root_; }
const std::vector<Error>& Document::errors() const { return root_.shared_->errors; }
Status Document::status() const { return errors().empty() ? Status() : errors().front(); }

}  // namespace cxlab::yaml
