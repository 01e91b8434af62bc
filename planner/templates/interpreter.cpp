// Statements. Expressions are in evaluate.cpp.

#include "planner/templates/interpreter.h"

#include <algorithm>

#include "planner/templates/library.h"
#include "planner/templates/parser.h"

namespace cxlab::planner::templates {
namespace {

/// Nesting of what runs: statements, expressions, macros that call themselves.
constexpr int kDeepestRun = 1000;

/// Where the interpreter is, restored at the end of a block of ours.
template <class T>
struct Restore {
  explicit Restore(T& place) : place(place), before(place) {}
  ~Restore() { place = before; }
  T& place;
  T before;
};

}  // namespace

Value* Scope::find(std::string_view name) {
  for (auto& [known, value] : names)
    if (known == name) return &value;
  return nullptr;
}

void Scope::set(const std::string& name, Value value) {
  if (Value* known = find(name)) {
    *known = std::move(value);
  } else {
    names.emplace_back(name, std::move(value));
  }
}

Interpreter::Interpreter(const Loader& loader, const Limits& limits) : loader_(loader), limits_(limits), globals_(std::make_shared<Scope>()) {
  globals_->names = global_functions();
}

Interpreter::~Interpreter() {
  // Scopes hold macros, and macros hold scopes.
  for (const auto& weak : captured_)
    if (const ScopePtr scope = weak.lock()) scope->names.clear();
  for (const auto& rendering : renderings_) rendering->top->names.clear();
}

Value Interpreter::fail(const std::string& message) {
  if (!error_) error_ = input_error(message, current_ == nullptr ? std::string{} : current_->name, line_);
  return {};
}

Value Interpreter::fail_unsupported(const std::string& message) {
  if (!error_) {
    fail(message);
    error_->code = "unsupported";
  }
  return {};
}

bool Interpreter::spend(std::size_t steps, std::size_t bytes) {
  steps_ += steps;
  bytes_ += bytes;
  if (steps_ > limits_.steps) fail("the template takes more than " + std::to_string(limits_.steps) + " steps");
  if (bytes_ > limits_.output) fail("the template makes more than " + std::to_string(limits_.output) + " bytes of text");
  return !failed();
}

void Interpreter::append(std::string& out, const std::string& text) {
  if (spend(1, text.size())) out += text;
}

const Template* Interpreter::load(const std::string& name, bool may_miss) {
  const auto known = templates_.find(name);
  if (known != templates_.end()) return known->second.get();
  const auto text = loader_(name);
  if (!text) {
    if (!may_miss) fail("found no template '" + name + "'");
    return nullptr;
  }
  auto parsed = parse_template(*text, name);
  if (!parsed) {
    if (!error_) error_ = parsed.error();
    return nullptr;
  }
  return templates_.emplace(name, std::move(*parsed)).first->second.get();
}

Expected<std::string> Interpreter::render(const std::string& name, const std::vector<std::pair<std::string, Value>>& variables) {
  for (const auto& [variable, value] : variables) globals_->set(variable, value);
  const Template* root = load(name, false);
  std::string out;
  if (root != nullptr) out = run_whole(*root, new_rendering(globals_));
  if (error_) {
    if (error_->file.empty()) error_->file = name;
    return *error_;
  }
  return out;
}

Rendering& Interpreter::new_rendering(ScopePtr outer) {
  renderings_.push_back(std::make_unique<Rendering>());
  renderings_.back()->top = std::make_shared<Scope>(Scope{std::move(outer), {}});
  return *renderings_.back();
}

void Interpreter::add_blocks(const Template& from, Rendering& rendering) {
  for (const auto& [name, block] : from.blocks) rendering.blocks[name].emplace_back(block, &from);
}

std::string Interpreter::run_whole(const Template& root, Rendering& rendering) {
  Restore<const Template*> place(current_);
  Restore<int> line(line_);
  Restore<int> depth(depth_);
  if (++depth_ > kDeepestRun) {
    fail("templates, macros and expressions are nested more than " + std::to_string(kDeepestRun) + " deep");
    return {};
  }
  std::string out;
  const Template* next = &root;
  add_blocks(root, rendering);
  for (int generations = 0; next != nullptr && !failed(); ++generations) {
    if (generations > 100) fail("found more than 100 templates that extend each other");
    current_ = next;
    rendering.parent = nullptr;
    rendering.out = &out;
    run(next->body, rendering, rendering.top, out);
    next = rendering.parent;
  }
  rendering.parent = nullptr;
  return out;
}

void Interpreter::run(const Body& body, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  for (const auto& node : body) {
    if (failed()) return;
    run_node(*node, rendering, scope, out);
  }
}

void Interpreter::run_node(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  line_ = node.line;
  Restore<int> depth(depth_);
  if (++depth_ > kDeepestRun) {
    fail("templates, macros and expressions are nested more than " + std::to_string(kDeepestRun) + " deep");
    return;
  }
  if (!spend(1)) return;
  const bool dropped = rendering.parent != nullptr && &out == rendering.out;  // only blocks of a child are shown
  switch (node.kind) {
    case Node::Kind::kText:
      if (!dropped) append(out, node.text);
      break;
    case Node::Kind::kOutput:
      if (!dropped) append(out, evaluate(*node.expression, rendering, scope).str());
      break;
    case Node::Kind::kFor: run_for(node, rendering, scope, out); break;
    case Node::Kind::kIf: run(evaluate(*node.expression, rendering, scope).truth() ? node.body : node.otherwise, rendering, scope, out); break;
    case Node::Kind::kSet:
    case Node::Kind::kSetBlock: run_set(node, rendering, scope); break;
    case Node::Kind::kBlock:
      if (!dropped) run_block(node, rendering, scope, out);
      break;
    case Node::Kind::kExtends: run_extends(node, rendering, scope); break;
    case Node::Kind::kInclude:
      if (!dropped) run_include(node, rendering, scope, out);
      break;
    case Node::Kind::kImport:
    case Node::Kind::kFromImport: run_import(node, rendering, scope); break;
    case Node::Kind::kMacro: scope->set(node.text, make_macro(node, rendering, scope)); break;
    case Node::Kind::kCallBlock: run_call(node, rendering, scope, out); break;
    case Node::Kind::kFilterBlock: {
      if (dropped) break;
      std::string text;
      run(node.body, rendering, std::make_shared<Scope>(Scope{scope, {}}), text);
      line_ = node.line;
      const std::string filtered = evaluate_filters(*node.expression, Value(std::move(text)), rendering, scope).str();
      append(out, filtered);
      break;
    }
    case Node::Kind::kWith: run_with(node, rendering, scope, out); break;
    case Node::Kind::kDo: evaluate(*node.expression, rendering, scope); break;
  }
}

void Interpreter::run_for(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  const Value over = evaluate(*node.expression, rendering, scope);
  if (!failed()) run_loop(node, over, 0, rendering, scope, out);
}

void Interpreter::run_loop(const Node& node, const Value& over, int depth, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  std::vector<Value> values = items(over);
  if (node.filter) {
    std::vector<Value> kept;
    for (Value& value : values) {
      if (failed()) return;
      const ScopePtr inner = std::make_shared<Scope>(Scope{scope, {}});
      assign(*node.target, value, rendering, inner);
      if (evaluate(*node.filter, rendering, inner).truth()) kept.push_back(std::move(value));
    }
    values = std::move(kept);
  }
  const std::size_t count = values.size();
  const Value loop = Value::object("LoopContext");
  ObjectData& fields = *loop.as_object();
  fields.set("length", static_cast<std::int64_t>(count));
  fields.set("depth", depth + 1);
  fields.set("depth0", depth);
  auto index_now = std::make_shared<std::size_t>(0);
  fields.set("cycle", Value::function("cycle", [index_now](Interpreter& self, const Call& call) {
               if (call.positional.empty()) return self.fail("loop.cycle takes at least one argument");
               return call.positional[*index_now % call.positional.size()];
             }));
  auto last_seen = std::make_shared<std::optional<std::vector<Value>>>();
  fields.set("changed", Value::function("changed", [last_seen](Interpreter&, const Call& call) {
               const bool same = *last_seen && Value::list(**last_seen).equals(Value::list(call.positional));
               if (!same) *last_seen = call.positional;
               return Value(!same);
             }));
  if (node.recursive) {
    Rendering* in = &rendering;
    fields.call = [&node, in, scope, depth](Interpreter& self, const Call& call) {
      if (call.positional.size() != 1) return self.fail("loop(...) takes one argument");
      std::string text;
      self.run_loop(node, call.positional[0], depth + 1, *in, scope, text);
      return Value(std::move(text));
    };
    captured_.push_back(scope);
  }
  for (std::size_t i = 0; i < count && !failed(); ++i) {
    *index_now = i;
    const auto number = [](std::size_t n) { return Value(static_cast<std::int64_t>(n)); };
    fields.set("index", number(i + 1));
    fields.set("index0", number(i));
    fields.set("revindex", number(count - i));
    fields.set("revindex0", number(count - i - 1));
    fields.set("first", i == 0);
    fields.set("last", i + 1 == count);
    fields.set("previtem", i == 0 ? Value::undefined("there is no previous item") : values[i - 1]);
    fields.set("nextitem", i + 1 == count ? Value::undefined("there is no next item") : values[i + 1]);
    const ScopePtr inner = std::make_shared<Scope>(Scope{scope, {}});
    inner->set("loop", loop);
    assign(*node.target, values[i], rendering, inner);
    run(node.body, rendering, inner, out);
  }
  fields.call = nullptr;
  if (count == 0) run(node.otherwise, rendering, std::make_shared<Scope>(Scope{scope, {}}), out);
}

void Interpreter::run_set(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  if (node.kind == Node::Kind::kSet) {
    assign(*node.target, evaluate(*node.expression, rendering, scope), rendering, scope);
    return;
  }
  std::string text;
  run(node.body, rendering, std::make_shared<Scope>(Scope{scope, {}}), text);
  line_ = node.line;
  Value value(std::move(text));
  if (node.expression) value = evaluate_filters(*node.expression, value, rendering, scope);
  assign(*node.target, value, rendering, scope);
}

void Interpreter::assign(const Expression& target, const Value& value, Rendering& rendering, const ScopePtr& scope) {
  if (failed()) return;
  if (target.kind == Expression::Kind::kName) {
    scope->set(target.name, value);
  } else if (target.kind == Expression::Kind::kAttribute) {
    const Value space = evaluate(*target.operands[0], rendering, scope);
    if (failed()) return;
    if (space.as_object() == nullptr || space.as_object()->kind != "Namespace") {
      fail("found an assignment to an attribute of " + std::string(space.type_name()) + ", expected a namespace(...)");
      return;
    }
    if (reaches(value, space.as_object())) {
      fail("a namespace cannot hold itself");
      return;
    }
    space.as_object()->set(target.name, value);
  } else {
    const std::vector<Value> values = items(value);
    if (failed()) return;
    if (values.size() != target.operands.size()) {
      fail("found " + std::to_string(values.size()) + " values to unpack, expected " + std::to_string(target.operands.size()));
      return;
    }
    for (std::size_t i = 0; i < values.size(); ++i) assign(*target.operands[i], values[i], rendering, scope);
  }
}

void Interpreter::run_block(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  append(out, block_text(node.text, 0, rendering, node.scoped ? scope : rendering.top));
}

std::string Interpreter::block_text(const std::string& name, std::size_t level, Rendering& rendering, const ScopePtr& scope) {
  const auto found = rendering.blocks.find(name);
  if (found == rendering.blocks.end() || level >= found->second.size()) {
    fail("there is no parent block called '" + name + "'");
    return {};
  }
  const auto [block, owner] = found->second[level];
  Restore<const Template*> place(current_);
  Restore<int> line(line_);
  current_ = owner;
  if (block->required) {
    fail("block '" + name + "' is required, expected a template that fills it");
    return {};
  }
  const ScopePtr inner = std::make_shared<Scope>(Scope{scope, {}});
  Rendering* in = &rendering;
  inner->set("super", Value::function("super", [name, level, in, scope](Interpreter& self, const Call&) {
               return Value(self.block_text(name, level + 1, *in, scope));
             }));
  std::string text;
  run(block->body, rendering, inner, text);
  return text;
}

void Interpreter::run_extends(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  if (rendering.parent != nullptr) {
    fail("found a second 'extends', expected one");
    return;
  }
  const Value name = evaluate(*node.expression, rendering, scope);
  if (failed()) return;
  if (!name.is_string()) {
    fail("found " + name.repr() + " to extend, expected the name of a template");
    return;
  }
  rendering.parent = load(name.as_string(), false);
  if (rendering.parent != nullptr) add_blocks(*rendering.parent, rendering);
}

void Interpreter::run_include(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  const Value name = evaluate(*node.expression, rendering, scope);
  if (failed()) return;
  const std::vector<Value> names = name.is_string() ? std::vector<Value>{name} : items(name);
  const Template* found = nullptr;
  for (const Value& each : names) {
    if (found != nullptr || failed()) break;
    found = load(each.str(), true);
  }
  if (failed()) return;
  if (found == nullptr) {
    if (!node.ignore_missing) fail("found no template " + name.repr() + " to include");
    return;
  }
  append(out, run_whole(*found, new_rendering(node.with_context ? scope : globals_)));
}

Value Interpreter::import_module(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  const Value name = evaluate(*node.expression, rendering, scope);
  if (failed()) return {};
  if (!name.is_string()) return fail("found " + name.repr() + " to import, expected the name of a template");
  const Template* found = load(name.as_string(), false);
  if (found == nullptr) return {};
  Rendering& inner = new_rendering(node.with_context ? scope : globals_);
  run_whole(*found, inner);
  Value module = Value::object("TemplateModule");
  for (const auto& [each, value] : inner.top->names)
    if (!each.starts_with('_')) module.as_object()->set(each, value);
  return module;
}

void Interpreter::run_import(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  const Value module = import_module(node, rendering, scope);
  if (failed()) return;
  if (node.kind == Node::Kind::kImport) {
    scope->set(node.text, module);
    return;
  }
  for (const auto& [name, alias] : node.names) {
    const Value* value = module.as_object()->find(name);
    scope->set(alias, value != nullptr ? *value : Value::undefined(name));
  }
}

Value Interpreter::make_macro(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  captured_.push_back(scope);
  Rendering* in = &rendering;
  const Template* owner = current_;
  return Value::function(node.text, [&node, in, scope, owner](Interpreter& self, const Call& call) {
    Restore<const Template*> place(self.current_);
    self.current_ = owner;
    return self.run_macro(node, call, *in, scope);
  });
}

void Interpreter::bind(const Node& node, const Call& call, Rendering& rendering, const ScopePtr& scope) {
  std::vector<bool> used(call.named.size(), false);
  for (std::size_t i = 0; i < node.parameters.size() && !failed(); ++i) {
    const std::string& name = node.parameters[i].first;
    const ExpressionPtr& value = node.parameters[i].second;
    if (i < call.positional.size()) {
      scope->set(name, call.positional[i]);
      continue;
    }
    const auto named = std::find_if(call.named.begin(), call.named.end(), [&](const auto& each) { return each.first == name; });
    if (named != call.named.end()) {
      used[static_cast<std::size_t>(named - call.named.begin())] = true;
      scope->set(name, named->second);
    } else {
      scope->set(name, Value::undefined(name));  // a default sees itself undefined
      if (value) scope->set(name, evaluate(*value, rendering, scope));
    }
  }
  std::vector<Value> rest;
  for (std::size_t i = node.parameters.size(); i < call.positional.size(); ++i) rest.push_back(call.positional[i]);
  scope->set("varargs", Value::tuple(std::move(rest)));
  Value named = Value::dict();
  for (std::size_t i = 0; i < call.named.size(); ++i) {
    if (call.named[i].first == "caller") {
      scope->set("caller", call.named[i].second);
    } else if (!used[i]) {
      templates::assign(*named.as_dict(), call.named[i].first, call.named[i].second);
    }
  }
  scope->set("kwargs", named);
}

Value Interpreter::run_macro(const Node& node, const Call& call, Rendering& rendering, const ScopePtr& scope) {
  Restore<int> line(line_);
  Restore<int> depth(depth_);
  if (++depth_ > kDeepestRun) return fail("macro '" + node.text + "' calls itself more than " + std::to_string(kDeepestRun) + " deep");
  const ScopePtr inner = std::make_shared<Scope>(Scope{scope, {}});
  bind(node, call, rendering, inner);
  std::string text;
  run(node.body, rendering, inner, text);
  return Value(std::move(text));
}

void Interpreter::run_call(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  Call call = arguments(*node.expression, rendering, scope);
  const Value callee = evaluate(*node.expression->operands[0], rendering, scope);
  if (failed()) return;
  Rendering* in = &rendering;
  const Template* owner = current_;
  captured_.push_back(scope);
  call.named.emplace_back("caller", Value::function("caller", [&node, in, scope, owner](Interpreter& self, const Call& inner) {
                            Restore<const Template*> place(self.current_);
                            self.current_ = owner;
                            return self.run_macro(node, inner, *in, scope);
                          }));
  const std::string text = this->call(callee, call).str();
  if (rendering.parent == nullptr || &out != rendering.out) append(out, text);
}

void Interpreter::run_with(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  const ScopePtr inner = std::make_shared<Scope>(Scope{scope, {}});
  for (const auto& [name, value] : node.parameters) inner->set(name, evaluate(*value, rendering, scope));
  run(node.body, rendering, inner, out);
}

}  // namespace cxlab::planner::templates
