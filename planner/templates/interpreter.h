#pragma once
// Runs templates.

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planner/templates/template.h"
#include "planner/templates/tree.h"

namespace cxlab::planner::templates {

/// Variables of one level: a template, a loop, a macro, a block. Names that are not here are looked for outside.
struct Scope {
  std::shared_ptr<Scope> outer;
  std::vector<std::pair<std::string, Value>> names;
  std::vector<std::string> hidden;  ///< undefined while they are not in `names`, for who runs here
  std::shared_ptr<Scope> shared =
      {};                     ///< of a top level: the variables of the rendering, which get all that is set here
  bool of_rendering = false;  ///< what blocks and included templates see: they look behind `hidden` outside

  Value* find(std::string_view name);
  void set(const std::string& name, Value value);
};
using ScopePtr = std::shared_ptr<Scope>;

/// One template on its way: the chain of those that it extends, and the variables that they share.
struct Rendering {
  std::map<std::string, std::vector<std::pair<const Node*, const Template*>>> blocks;  ///< by name: the child's first
  ScopePtr top;
  std::set<std::string> imported;    ///< variables of `top` that who imports the template does not get
  const Template* parent = nullptr;  ///< what it extends, from the statement on until that runs
};

/// Where the interpreter is, restored at the end of a block of ours.
template <class T>
struct Restore {
  explicit Restore(T& place) : place(place), before(place) {}
  ~Restore() { place = before; }
  Restore(const Restore&) = delete;
  Restore& operator=(const Restore&) = delete;
  T& place;
  T before;
};

/// After an error `failed()` is true and everything ends quickly; values are then meaningless.
class Interpreter {
 public:
  Interpreter(const Loader& loader, const Limits& limits);
  ~Interpreter();
  Interpreter(const Interpreter&) = delete;
  Interpreter& operator=(const Interpreter&) = delete;

  Expected<std::string> render(const std::string& name, const std::vector<std::pair<std::string, Value>>& variables);

  // For the library.

  /// Records an error at the line that runs.
  Value fail(const std::string& message);
  Value fail_unsupported(const std::string& message);
  bool failed() const { return error_.has_value(); }
  /// Counts work and text that is made; false when a limit is passed.
  bool spend(std::size_t steps, std::size_t bytes = 0);

  Value attribute(const Value& subject, const std::string& name);
  Value item(const Value& subject, const Value& index);
  /// All items of something that can be iterated.
  std::vector<Value> items(const Value& subject);
  Value call(const Value& callee, const Call& call);
  Value binary(const std::string& operation, const Value& left, const Value& right);
  bool contains(const Value& container, const Value& item);
  bool less(const Value& left, const Value& right);
  /// False, with an error, when the value is undefined.
  bool require(const Value& value);

 private:
  const Template* load(const std::string& name, bool may_miss);
  void run(const Body& body, Rendering& rendering, const ScopePtr& scope, std::string& out);
  void run_node(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out);
  void run_for(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out);
  void run_loop(const Node& node, const Value& over, int depth, Rendering& rendering, const ScopePtr& scope,
                std::string& out);
  void run_set(const Node& node, Rendering& rendering, const ScopePtr& scope);
  void run_block(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out);
  std::string block_text(const std::string& name, std::size_t level, Rendering& rendering, const ScopePtr& around);
  /// What `super`, `super.super` and `self.NAME` are: the block at that level of the chain, to be called.
  Value block_reference(const std::string& name, std::size_t level, Rendering& rendering, const ScopePtr& around);
  void run_extends(const Node& node, Rendering& rendering, const ScopePtr& scope);
  void run_include(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out);
  void run_import(const Node& node, Rendering& rendering, const ScopePtr& scope);
  Value import_module(const Node& node, Rendering& rendering, const ScopePtr& scope);
  Value make_module(const Template& from, ScopePtr outer);
  /// The module of a template that sees no variables of others; made once.
  Value module_alone(const Template& from);
  /// Sets a name; at the top level for the whole rendering, and for who imports the template unless it was imported
  /// itself.
  void define(const std::string& name, Value value, bool imported, Rendering& rendering, const ScopePtr& scope);
  Rendering& new_rendering(ScopePtr outer);
  static void add_blocks(const Template& from, Rendering& rendering);
  /// Renders all of a template, and what it extends, into a new string.
  std::string run_whole(const Template& root, Rendering& rendering);
  /// Of {% macro %} and {% call %}.
  Value make_macro(const Node& node, Rendering& rendering, const ScopePtr& scope);
  Value run_macro(const Node& node, const Call& call, Rendering& rendering, const ScopePtr& scope);
  void bind(const Node& node, const Call& call, Rendering& rendering, const ScopePtr& scope);
  void run_call(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out);
  void run_with(const Node& node, Rendering& rendering, const ScopePtr& scope, std::string& out);

  Value evaluate(const Expression& expression, Rendering& rendering, const ScopePtr& scope);
  Value evaluate_literal(const Expression& expression, Rendering& rendering, const ScopePtr& scope);
  Value evaluate_sign(const Expression& expression, Rendering& rendering, const ScopePtr& scope);
  Value evaluate_compare(const Expression& expression, Rendering& rendering, const ScopePtr& scope);
  Value evaluate_call(const Expression& expression, Rendering& rendering, const ScopePtr& scope);
  Value evaluate_filters(const Expression& expression, const Value& body, Rendering& rendering, const ScopePtr& scope);
  Value slice(const Value& subject, const Expression& bounds, Rendering& rendering, const ScopePtr& scope);
  Call arguments(const Expression& expression, Rendering& rendering, const ScopePtr& scope);
  /// The variable that is seen from a scope, or null.
  static const Value* find_variable(const std::string& name, Scope& scope);
  Value look_up(const std::string& name, Rendering& rendering, const ScopePtr& scope);
  Value self_of(Rendering& rendering, const ScopePtr& scope);
  void assign(const Expression& target, const Value& value, Rendering& rendering, const ScopePtr& scope);
  bool compare(const std::string& operation, const Value& left, const Value& right);
  void append(std::string& out, const std::string& text);

  const Loader& loader_;
  Limits limits_;
  std::map<std::string, std::unique_ptr<Template>> templates_;
  std::vector<std::unique_ptr<Rendering>> renderings_;  ///< all, for macros outlive their template
  std::vector<std::weak_ptr<Scope>> captured_;          ///< scopes that functions hold, emptied at the end
  std::map<const Template*, Value> modules_;            ///< see module_alone
  ScopePtr globals_;
  const Template* current_ = nullptr;
  int line_ = 0;
  int depth_ = 0;
  const Value* filter_body_ = nullptr;  ///< text of the {% filter %} or {% set %} block that is filtered
  std::optional<Error> error_;
  std::size_t steps_ = 0, bytes_ = 0;
};

}  // namespace cxlab::planner::templates
