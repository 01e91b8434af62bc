#include "planner/templates/scopes.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <string_view>

namespace cxlab::planner::templates {
namespace {

/// Calls `read` with all names of an expression, which may be null.
template <class Read>
void each_read(const Expression* expression, const Read& read) {
  if (expression == nullptr) return;
  if (expression->kind == Expression::Kind::kName) read(std::string_view(expression->name));
  for (const auto& operand : expression->operands) each_read(operand.get(), read);
  for (const auto& argument : expression->arguments) each_read(argument.get(), read);
  for (const auto& [name, argument] : expression->named_arguments) each_read(argument.get(), read);
  each_read(expression->star.get(), read);
  each_read(expression->double_star.get(), read);
}

/// Calls `write` with the names that a target assigns to, and `read` with those of which it sets an attribute.
template <class Write, class Read>
void each_target(const Expression& target, const Write& write, const Read& read) {
  if (target.kind == Expression::Kind::kName) {
    write(std::string_view(target.name));
  } else if (target.kind == Expression::Kind::kAttribute) {
    each_read(&target, read);
  } else {
    for (const auto& operand : target.operands) each_target(*operand, write, read);
  }
}

/// Which of some names a body reads, also inside what it holds but blocks, and before it makes them names of its own.
class Mentions {
 public:
  Mentions(const Body& body, std::initializer_list<std::string_view> names) : wanted_(names) { visit(body); }
  bool operator()(std::string_view name) const { return std::find(found_.begin(), found_.end(), name) != found_.end(); }

 private:
  void read(const Expression* expression) {
    each_read(expression, [this](std::string_view name) {
      if (std::find(wanted_.begin(), wanted_.end(), name) != wanted_.end()) found_.push_back(name);
    });
  }
  void write(std::string_view name) { std::erase(wanted_, name); }
  void target(const Node& node) {
    if (node.target) each_target(*node.target, [this](std::string_view name) { write(name); }, [](std::string_view) {});
  }
  void visit(const Body& body) {
    for (const auto& node : body)
      if (!wanted_.empty() && node->kind != Node::Kind::kBlock) visit(*node);
  }
  void visit(const Node& node) {
    target(node);
    if (node.kind != Node::Kind::kFilterBlock) read(node.expression.get());
    for (const auto& [name, value] : node.parameters) write(name);
    for (const auto& [name, value] : node.parameters) read(value.get());
    visit(node.body);
    visit(node.otherwise);
    if (node.kind == Node::Kind::kFilterBlock) read(node.expression.get());
    read(node.filter.get());
  }

  std::vector<std::string_view> wanted_, found_;
};

bool has_scoped_block(const Body& body) {
  return std::any_of(body.begin(), body.end(), [](const auto& node) {
    return (node->kind == Node::Kind::kBlock && node->scoped) || has_scoped_block(node->body) ||
           has_scoped_block(node->otherwise);
  });
}

/// The names of one scope, by what happens to them first.
struct Frame {
  enum class First { kGiven, kRead, kWritten };
  const Frame* parent = nullptr;
  std::map<std::string_view, First> names;

  bool knows(std::string_view name) const { return names.contains(name) || (parent != nullptr && parent->knows(name)); }
  void give(std::string_view name) { names[name] = First::kGiven; }
  void read(std::string_view name) {
    if (!knows(name)) names.emplace(name, First::kRead);
  }
  /// What a branch assigns to is looked for outside where the branch is not taken.
  void write(std::string_view name, bool in_branch) {
    const bool outside = in_branch || (parent != nullptr && parent->knows(name));
    names.emplace(name, outside ? First::kRead : First::kWritten);
  }
  std::vector<std::string> all(First first) const {
    std::vector<std::string> out;
    for (const auto& [name, how] : names)
      if (how == first) out.emplace_back(name);
    return out;
  }
};

/// Where a body stands.
struct Place {
  bool top_level = false;
  bool captured = false;
  bool in_loop = false;
};

class Resolver {
 public:
  explicit Resolver(const std::string& file) : file_(file) {}

  Status run(Template& parsed) {
    Frame frame;
    if (Mentions(parsed.body, {"self"})("self")) frame.give("self");
    collect(parsed.body, frame, false);
    parsed.hidden = frame.all(Frame::First::kWritten);
    parsed.reads = frame.all(Frame::First::kRead);
    descend(parsed.body, frame, {true, false, false});
    return status_;
  }

 private:
  void fail(const Node& node, std::string message) {
    if (status_) status_ = input_error(std::move(message), file_, node.line);
  }

  /// What the statements of a scope do to its names, without those of scopes inside.
  static void collect(const Body& body, Frame& frame, bool in_branch) {
    const auto read = [&](std::string_view name) { frame.read(name); };
    const auto write = [&](std::string_view name) { frame.write(name, in_branch); };
    for (const auto& node : body) {
      switch (node->kind) {
        case Node::Kind::kText:
        case Node::Kind::kBlock: break;
        case Node::Kind::kIf:
          each_read(node->expression.get(), read);
          collect(node->body, frame, true);
          collect(node->otherwise, frame, true);
          break;
        case Node::Kind::kSet:
          each_read(node->expression.get(), read);
          each_target(*node->target, write, read);
          break;
        case Node::Kind::kSetBlock: each_target(*node->target, write, read); break;
        case Node::Kind::kMacro: write(node->text); break;
        case Node::Kind::kWith:
          for (const auto& [name, value] : node->parameters) each_read(value.get(), read);
          break;
        case Node::Kind::kImport:
          each_read(node->expression.get(), read);
          write(node->text);
          break;
        case Node::Kind::kFromImport:
          each_read(node->expression.get(), read);
          for (const auto& [name, alias] : node->names) write(alias);
          break;
        default: each_read(node->expression.get(), read);
      }
    }
  }

  void descend(Body& body, const Frame& frame, Place place) {
    for (const auto& node : body) descend(*node, frame, place);
  }

  void descend(Node& node, const Frame& frame, Place place) {
    Frame inner{&frame, {}};
    const Place inside{false, place.captured, place.in_loop}, captured{false, true, place.in_loop};
    switch (node.kind) {
      case Node::Kind::kText:
      case Node::Kind::kOutput: node.captured = place.captured; break;
      case Node::Kind::kIf:
        descend(node.body, frame, place);
        descend(node.otherwise, frame, place);
        break;
      case Node::Kind::kExtends:
        if (!place.top_level)
          fail(node, "found 'extends' inside another statement, expected it at the top level (or in an if there)");
        break;
      case Node::Kind::kFor: loop(node, frame, place); break;
      case Node::Kind::kSet: check_target(node, place); break;
      case Node::Kind::kSetBlock:
        check_target(node, place);
        node.hidden = scope(node.body, inner, captured);
        break;
      case Node::Kind::kBlock: {
        node.top_level = place.top_level;
        const Mentions mentions(node.body, {"self", "super"});
        node.uses_super = mentions("super");
        inner.parent = nullptr;
        if (mentions("self")) inner.give("self");
        if (mentions("super")) inner.give("super");
        node.hidden = scope(node.body, inner, captured);
        break;
      }
      case Node::Kind::kMacro:
      case Node::Kind::kCallBlock: macro(node, frame, captured); break;
      case Node::Kind::kFilterBlock: node.hidden = scope(node.body, inner, inside); break;
      case Node::Kind::kWith:
        for (const auto& [name, value] : node.parameters) inner.give(name);
        node.hidden = scope(node.body, inner, inside);
        break;
      default: break;
    }
  }

  /// Goes through a body with a scope of its own; what it hides.
  std::vector<std::string> scope(Body& body, Frame& frame, Place place) {
    collect(body, frame, false);
    descend(body, frame, place);
    return frame.all(Frame::First::kWritten);
  }

  void loop(Node& node, const Frame& frame, Place place) {
    place = {false, place.captured, true};
    check_target(node, place);
    node.uses_loop = node.recursive || Mentions(node.body, {"loop"})("loop") || has_scoped_block(node.body) ||
                     has_scoped_block(node.otherwise);
    Frame body{&frame, {}}, otherwise{&frame, {}};
    each_target(*node.target, [&](std::string_view name) { body.give(name); }, [](std::string_view) {});
    if (node.uses_loop) body.give("loop");
    node.hidden = scope(node.body, body, place);
    node.otherwise_hidden = scope(node.otherwise, otherwise, place);
  }

  void check_target(const Node& node, Place place) {
    each_target(
        *node.target,
        [&](std::string_view name) {
          if (place.in_loop && name == "loop")
            fail(node, "found an assignment to 'loop' inside a loop, which has that name already");
        },
        [](std::string_view) {});
  }

  void macro(Node& node, const Frame& frame, Place place) {
    const Mentions mentions(node.body, {"caller", "kwargs", "varargs"});
    Frame inner{&frame, {}};
    const auto given = [&](std::string_view name) {
      return std::find_if(node.parameters.begin(), node.parameters.end(),
                          [&](const auto& each) { return each.first == name; });
    };
    const auto none = node.parameters.end();
    node.uses_caller = mentions("caller");
    if (node.uses_caller && given("caller") != none && !given("caller")->second)
      fail(node, "found the parameter 'caller' without default, expected one");
    node.uses_kwargs = mentions("kwargs") && given("kwargs") == none;
    node.uses_varargs = mentions("varargs") && given("varargs") == none;
    for (const auto& [name, value] : node.parameters) inner.give(name);
    if (node.uses_caller) inner.give("caller");
    if (node.uses_kwargs) inner.give("kwargs");
    if (node.uses_varargs) inner.give("varargs");
    for (const auto& [name, value] : node.parameters)
      each_read(value.get(), [&](std::string_view read) { inner.read(read); });
    node.hidden = scope(node.body, inner, place);
  }

  const std::string& file_;
  Status status_;
};

}  // namespace

Status resolve_scopes(Template& parsed) { return Resolver(parsed.name).run(parsed); }

}  // namespace cxlab::planner::templates
