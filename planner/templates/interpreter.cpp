// Statements. Expressions are in evaluate.cpp.

#include "planner/templates/interpreter.h"

#include <algorithm>

#include "planner/templates/library.h"
#include "planner/templates/parser.h"

namespace cxlab::planner::templates {
namespace {

/// Nesting of what runs: statements, expressions, macros that call themselves.
constexpr int kDeepestRun = 1000;

ScopePtr scope_in(const ScopePtr& outer, const std::vector<std::string>& hidden) {
  return std::make_shared<Scope>(Scope{outer, {}, hidden});
}

}  // namespace

Value* Scope::find(std::string_view name) {
  for (auto& [known, value] : names)
    if (known == name) return &value;
  return nullptr;
}

void Scope::set(const std::string& name, Value value) {
  if (Value* known = find(name)) {
    *known = value;
  } else {
    names.emplace_back(name, value);
  }
  if (shared) shared->set(name, std::move(value));
}

Interpreter::Interpreter(const Loader& loader, const Limits& limits)
    : loader_(loader), limits_(limits), globals_(std::make_shared<Scope>()) {
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
  if (bytes_ > limits_.output)
    fail("the template makes more than " + std::to_string(limits_.output) + " bytes of text");
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

Expected<std::string> Interpreter::render(const std::string& name,
                                          const std::vector<std::pair<std::string, Value>>& variables) {
  const Template* root = load(name, false);
  std::string out;
  if (root != nullptr) out = run_whole(*root, new_rendering(std::make_shared<Scope>(Scope{globals_, variables, {}})));
  if (error_) {
    if (error_->file.empty()) error_->file = name;
    return *error_;
  }
  return out;
}

Rendering& Interpreter::new_rendering(ScopePtr outer) {
  renderings_.push_back(std::make_unique<Rendering>());
  renderings_.back()->top = std::make_shared<Scope>(Scope{std::move(outer), {}, {}});
  renderings_.back()->top->of_rendering = true;
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
    const ScopePtr scope = scope_in(rendering.top, next->hidden);
    scope->shared = rendering.top;
    for (const std::string& name : next->reads) {  // as they are now: what it extends may set them later
      if (const Value* known = find_variable(name, *scope)) {
        scope->names.emplace_back(name, *known);
      } else {
        scope->hidden.push_back(name);
      }
    }
    run(next->body, rendering, scope, out);
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
  const bool dropped = rendering.parent != nullptr && !node.captured;  // the text of a child
  switch (node.kind) {
    case Node::Kind::kText:
      if (!dropped) append(out, node.text);
      break;
    case Node::Kind::kOutput:
      if (!dropped) append(out, evaluate(*node.expression, rendering, scope).str());
      break;
    case Node::Kind::kFor: run_for(node, rendering, scope, out); break;
    case Node::Kind::kIf:
      run(evaluate(*node.expression, rendering, scope).truth() ? node.body : node.otherwise, rendering, scope, out);
      break;
    case Node::Kind::kSet:
    case Node::Kind::kSetBlock: run_set(node, rendering, scope); break;
    case Node::Kind::kBlock: run_block(node, rendering, scope, out); break;
    case Node::Kind::kExtends: run_extends(node, rendering, scope); break;
    case Node::Kind::kInclude: run_include(node, rendering, scope, out); break;
    case Node::Kind::kImport:
    case Node::Kind::kFromImport: run_import(node, rendering, scope); break;
    case Node::Kind::kMacro: define(node.text, make_macro(node, rendering, scope), false, rendering, scope); break;
    case Node::Kind::kCallBlock: run_call(node, rendering, scope, out); break;
    case Node::Kind::kFilterBlock: {
      std::string text;
      const ScopePtr inner = scope_in(scope, node.hidden);
      run(node.body, rendering, inner, text);
      line_ = node.line;
      const std::string filtered = evaluate_filters(*node.expression, Value(std::move(text)), rendering, inner).str();
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

void Interpreter::run_loop(const Node& node, const Value& over, int depth, Rendering& rendering, const ScopePtr& scope,
                           std::string& out) {
  std::vector<Value> values = items(over);
  if (node.filter) {
    std::vector<Value> kept;
    for (Value& value : values) {
      if (failed()) return;
      const ScopePtr inner = scope_in(scope, {});
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
    const ScopePtr inner = scope_in(scope, node.hidden);
    if (node.uses_loop) inner->set("loop", loop);
    assign(*node.target, values[i], rendering, inner);
    run(node.body, rendering, inner, out);
  }
  fields.call = nullptr;
  if (count == 0) run(node.otherwise, rendering, scope_in(scope, node.otherwise_hidden), out);
}

void Interpreter::run_set(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  if (node.kind == Node::Kind::kSet) {
    assign(*node.target, evaluate(*node.expression, rendering, scope), rendering, scope);
    return;
  }
  std::string text;
  const ScopePtr inner = scope_in(scope, node.hidden);
  run(node.body, rendering, inner, text);
  line_ = node.line;
  Value value(std::move(text));
  if (node.expression) value = evaluate_filters(*node.expression, value, rendering, inner);
  assign(*node.target, value, rendering, scope);
}

void Interpreter::assign(const Expression& target, const Value& value, Rendering& rendering, const ScopePtr& scope) {
  if (failed()) return;
  if (target.kind == Expression::Kind::kName) {
    define(target.name, value, false, rendering, scope);
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
      fail("found " + std::to_string(values.size()) + " values to unpack, expected " +
           std::to_string(target.operands.size()));
      return;
    }
    for (std::size_t i = 0; i < values.size(); ++i) assign(*target.operands[i], values[i], rendering, scope);
  }
}

void Interpreter::define(const std::string& name, Value value, bool imported, Rendering& rendering,
                         const ScopePtr& scope) {
  scope->set(name, std::move(value));
  if (!scope->shared) return;
  if (imported) {
    rendering.imported.insert(name);
  } else {
    rendering.imported.erase(name);
  }
}

Value Interpreter::make_macro(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  captured_.push_back(scope);
  Value macro = Value::object(node.kind == Node::Kind::kMacro ? "Macro '" + node.text + "'" : "Macro anonymous");
  ObjectData& fields = *macro.as_object();
  std::vector<Value> names;
  for (const auto& [name, value] : node.parameters) names.emplace_back(name);
  fields.set("name", node.kind == Node::Kind::kMacro ? Value(node.text) : Value::none());
  fields.set("arguments", Value::tuple(std::move(names)));
  fields.set("catch_kwargs", node.uses_kwargs);
  fields.set("catch_varargs", node.uses_varargs);
  fields.set("caller", node.uses_caller);
  Rendering* in = &rendering;
  fields.call = [&node, in, scope, owner = current_](Interpreter& self, const Call& call) {
    Restore<const Template*> place(self.current_);
    self.current_ = owner;
    return self.run_macro(node, call, *in, scope);
  };
  return macro;
}

void Interpreter::bind(const Node& node, const Call& call, Rendering& rendering, const ScopePtr& scope) {
  const std::string what = node.kind == Node::Kind::kMacro ? "the macro '" + node.text + "'" : "caller";
  std::vector<std::pair<std::string, Value>> named = call.named;
  const auto take = [&](const std::string& name, Value otherwise) {
    const auto found = std::find_if(named.begin(), named.end(), [&](const auto& each) { return each.first == name; });
    if (found == named.end()) return otherwise;
    Value value = std::move(found->second);
    named.erase(found);
    return value;
  };
  const std::size_t count = node.parameters.size(), positional = std::min(count, call.positional.size());
  bool has_caller = false;
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& name = node.parameters[i].first;
    has_caller = has_caller || name == "caller";
    const bool given =
        i < positional || std::any_of(named.begin(), named.end(), [&](const auto& each) { return each.first == name; });
    if (!given) missing.push_back(i);
    scope->set(name, i < positional ? call.positional[i] : take(name, Value::undefined(name)));
  }
  if (node.uses_caller && !has_caller)
    scope->set("caller", take("caller", Value::undefined("found no caller of " + what + ", expected {% call %}")));
  if (node.uses_kwargs) {
    Value rest = Value::dict();
    for (auto& [name, value] : named) templates::assign(*rest.as_dict(), name, std::move(value));
    scope->set("kwargs", rest);
  } else if (!named.empty()) {
    fail(named.front().first == "caller" ? "found {% call %} of " + what + ", which does not use its caller"
                                         : "found the argument '" + named.front().first + "' of " + what +
                                               ", which it does not have or has already");
  }
  if (node.uses_varargs) {
    scope->set("varargs", Value::tuple({call.positional.begin() + static_cast<std::ptrdiff_t>(positional),
                                        call.positional.end()}));
  } else if (call.positional.size() > count) {
    fail("found " + std::to_string(call.positional.size()) + " arguments of " + what + ", expected at most " +
         std::to_string(count));
  }
  for (const std::size_t i : missing)
    if (const auto& [name, value] = node.parameters[i]; value && !failed())
      scope->set(name, evaluate(*value, rendering, scope));
}

Value Interpreter::run_macro(const Node& node, const Call& call, Rendering& rendering, const ScopePtr& scope) {
  Restore<int> line(line_);
  Restore<int> depth(depth_);
  if (++depth_ > kDeepestRun)
    return fail("macro '" + node.text + "' calls itself more than " + std::to_string(kDeepestRun) + " deep");
  const ScopePtr inner = scope_in(scope, node.hidden);
  bind(node, call, rendering, inner);
  std::string text;
  run(node.body, rendering, inner, text);
  return Value(std::move(text));
}

void Interpreter::run_call(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  Call call = arguments(*node.expression, rendering, scope);
  const Value callee = evaluate(*node.expression->operands[0], rendering, scope);
  if (failed()) return;
  call.named.emplace_back("caller", make_macro(node, rendering, scope));
  append(out, this->call(callee, call).str());
}

void Interpreter::run_with(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  const ScopePtr inner = scope_in(scope, node.hidden);
  for (const auto& [name, value] : node.parameters) inner->set(name, evaluate(*value, rendering, scope));
  run(node.body, rendering, inner, out);
}

}  // namespace cxlab::planner::templates
