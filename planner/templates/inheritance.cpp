// Blocks, and templates that other templates name: extends, include, import.

#include <set>
#include <string_view>

#include "planner/templates/interpreter.h"
#include "planner/templates/parser.h"

namespace cxlab::planner::templates {
namespace {

/// The variables that blocks and included templates see from `scope`.
ScopePtr around(ScopePtr scope) {
  while (!scope->of_rendering) scope = scope->outer;
  return scope;
}

/// The same with the variables of loops, macros and blocks: of a scoped block, or an included template.
ScopePtr with_locals(const ScopePtr& scope) {
  auto made = std::make_shared<Scope>(Scope{scope, {}, {}});
  made->of_rendering = true;
  return made;
}

/// All that is seen from `scope`, as it is now.
ScopePtr copy_of(const ScopePtr& scope, const ScopePtr& globals) {
  auto copy = std::make_shared<Scope>(Scope{globals, {}, {}});
  std::set<std::string_view> seen;
  for (const Scope* level = scope.get(); level != globals.get(); level = level->outer.get())
    for (const auto& [name, value] : level->names)
      if (seen.insert(name).second) copy->names.emplace_back(name, value);
  return copy;
}

}  // namespace

void Interpreter::run_block(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out) {
  if (rendering.parent != nullptr && node.top_level) return;  // what is extended shows it
  if (node.required && rendering.blocks[node.text].size() < 2) {
    fail("block '" + node.text + "' is required, expected a template that fills it");
    return;
  }
  append(out, block_text(node.text, 0, rendering, node.scoped ? with_locals(scope) : around(scope)));
}

std::string Interpreter::block_text(const std::string& name, std::size_t level, Rendering& rendering,
                                    const ScopePtr& around) {
  const auto [block, owner] = rendering.blocks.at(name).at(level);
  Restore<const Template*> place(current_);
  Restore<int> line(line_);
  current_ = owner;
  const ScopePtr inner = std::make_shared<Scope>(Scope{around, {}, block->hidden});
  if (block->uses_super) inner->set("super", block_reference(name, level + 1, rendering, around));
  std::string text;
  run(block->body, rendering, inner, text);
  return text;
}

Value Interpreter::block_reference(const std::string& name, std::size_t level, Rendering& rendering,
                                   const ScopePtr& around) {
  const auto found = rendering.blocks.find(name);
  if (found == rendering.blocks.end() || level >= found->second.size())
    return Value::undefined("there is no parent block called '" + name + "'");
  captured_.push_back(around);
  Value reference = Value::object("BlockReference");
  Rendering* in = &rendering;
  reference.as_object()->call = [name, level, in, around](Interpreter& self, const Call&) {
    return Value(self.block_text(name, level, *in, around));
  };
  reference.as_object()->set("super", block_reference(name, level + 1, rendering, around));
  return reference;
}

Value Interpreter::self_of(Rendering& rendering, const ScopePtr& scope) {
  Value self = Value::object("TemplateReference");
  for (const auto& [name, levels] : rendering.blocks)
    self.as_object()->set(name, block_reference(name, 0, rendering, around(scope)));
  return self;
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
  if (!require(name)) return;
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
  append(out, node.with_context ? run_whole(*found, new_rendering(scope)) : module_alone(*found).str());
}

Value Interpreter::make_module(const Template& from, ScopePtr outer) {
  Rendering& inner = new_rendering(std::move(outer));
  Value module = Value::object("TemplateModule");
  module.as_object()->text = run_whole(from, inner);
  for (const auto& [name, value] : inner.top->names)
    if (!name.starts_with('_') && !inner.imported.contains(name)) module.as_object()->set(name, value);
  return module;
}

Value Interpreter::module_alone(const Template& from) {
  const auto known = modules_.find(&from);
  if (known != modules_.end()) return known->second;
  return modules_.emplace(&from, make_module(from, globals_)).first->second;
}

Value Interpreter::import_module(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  const Value name = evaluate(*node.expression, rendering, scope);
  if (failed()) return {};
  if (!name.is_string()) return fail("found " + name.repr() + " to import, expected the name of a template");
  const Template* found = load(name.as_string(), false);
  if (found == nullptr) return {};
  if (!node.with_context) return module_alone(*found);
  const ScopePtr seen = copy_of(scope, globals_);
  return spend(seen->names.size()) ? make_module(*found, seen) : Value{};
}

void Interpreter::run_import(const Node& node, Rendering& rendering, const ScopePtr& scope) {
  const Value module = import_module(node, rendering, scope);
  if (failed()) return;
  if (node.kind == Node::Kind::kImport) {
    define(node.text, module, true, rendering, scope);
    return;
  }
  for (const auto& [name, alias] : node.names) {
    const Value* value = module.as_object()->find(name);
    define(alias, value != nullptr ? *value : Value::undefined(name), true, rendering, scope);
  }
}

}  // namespace cxlab::planner::templates
