#include "planner/pddl/resolver.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

constexpr std::span<const std::string_view> kOperators = std::span(kConditionWords).subspan(3);
constexpr std::string_view kMetricWords[] = {"total-time"};
constexpr std::string_view kTrajectoryWords[] = {"always",        "sometime",       "within",
                                                 "at-most-once",  "sometime-after", "sometime-before",
                                                 "always-within", "hold-during",    "hold-after"};

std::string hint(std::string_view word, const NameTable& names, std::span<const std::string_view> words = {}) {
  std::vector<std::string> candidates(words.begin(), words.end());
  for (const auto& entry : names) candidates.push_back(entry.first);
  std::ranges::sort(candidates);
  return did_you_mean(std::string(word), candidates, "; ");
}

std::string count(std::size_t n, std::string_view noun) { return message(n, " ", noun, n == 1 ? "" : "s"); }

std::vector<ObjectId> objects_in(const std::vector<Term>& terms) {
  std::vector<ObjectId> objects;
  for (const Term& term : terms) objects.push_back(term.index);
  return objects;
}

}  // namespace

std::string Resolver::declared(const Source& source, std::string_view name) const {
  if (source.line == 0) return {};
  const std::string subject = name.empty() ? "" : message("'", name, "' is ");
  return message("; ", subject, "declared at ", source.file == Source::File::kDomain ? domain_.file : file_, ":",
                 source.line);
}

std::string Resolver::type_names(const std::vector<TypeId>& types) const {
  std::string text;
  for (const TypeId type : types) text += (text.empty() ? "" : " or ") + domain_.types[type].name;
  return text;
}

bool Resolver::may_be(const std::vector<TypeId>& types, const std::vector<TypeId>& wanted) const {
  for (TypeId below = 0; below < static_cast<TypeId>(domain_.types.size()); ++below) {
    const auto is_below = [&](TypeId type) { return domain_.is_a(below, type); };
    if (std::ranges::any_of(types, is_below) && std::ranges::any_of(wanted, is_below)) return true;
  }
  return false;
}

std::string Resolver::define(const Node& root, const FileShape& shape) const {
  const std::string form = message("(", shape.kind, " NAME)");
  if (root.head() != "define") fail(root, found_expected(message(root), "(define "), form, " ...)");
  const Node title = root.items.size() > 1 ? root.items[1] : Node();
  if (title.head() == shape.other_kind)
    fail(root, found_expected(message("a ", shape.other_kind), "a "), shape.kind, ": (define ", form,
         " ...); are the files swapped?");
  if (title.head() != shape.kind) fail(root, "expected ", form, " behind 'define'");
  if (title.items.size() != 2 || title.items[1].is_list) fail(title, found_expected(message(title), message(form)));
  std::vector<std::string_view> seen;
  for (const Node& section : root.items | std::views::drop(2)) {
    const std::string_view head = section.head();
    const auto is_in = [&](const auto& heads) { return std::ranges::find(heads, head) != heads.end(); };
    if (is_in(shape.unsupported)) fail_unsupported(section, "found section ", head, ": not supported");
    if (is_in(seen)) fail(section, found_expected(message(head, " a second time"), "one"));
    if (is_in(shape.single))
      seen.push_back(head);
    else if (!is_in(shape.many))
      fail(section, found_expected(message(section), message(shape.expected)));
  }
  return std::string(title.items[1].word);
}

void Resolver::begin_frame(bool durative) {
  in_durative_ = durative;
  scope_.clear();
  slots_ = 0;
}

std::vector<Resolver::TypedName> Resolver::typed_list(std::span<const Node> items, std::string_view what) const {
  const auto add_type = [&](const Node& node, std::vector<TypeId>& types) {
    const int id = find(domain_.type_names, node.word);
    if (node.word.starts_with('?')) fail(node, found_expected(message("the variable ", node.word), "a type"));
    if (id < 0 && node.word == "number")
      fail_unsupported(node, what, " of type number: not supported, numbers are values of functions only");
    if (id < 0)
      fail(node, found_expected(message("type '", node.word, "'"), "a type of the domain"),
           hint(node.word, domain_.type_names));
    if (std::ranges::find(types, id) == types.end()) types.push_back(id);
  };
  std::vector<TypedName> names;
  std::size_t untyped = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Node& item = items[i];
    if (item.is_list) fail(item, found_expected(message(item), message(what)));
    if (item.word != "-") {
      if (item.word.starts_with('?') && what != "a variable")
        fail(item, found_expected(message("the variable ", item.word), message(what)));
      names.push_back({&item, {}});
      continue;
    }
    if (i + 1 == items.size()) fail(item, found_expected("the end of the list behind '-'", "a type"));
    if (untyped == names.size()) fail(item, found_expected("'-'", message(what)), " before it");
    const Node& types_node = items[++i];
    std::vector<TypeId> types;
    if (!types_node.is_list) {
      add_type(types_node, types);
    } else if (types_node.head() != "either" || types_node.items.size() < 2) {
      fail(types_node, found_expected(message(types_node), "a type or (either TYPE...)"));
    }
    for (const Node& type : types_node.rest()) {
      if (type.is_list) fail(types_node, found_expected(message(type), "a type"));
      add_type(type, types);
    }
    for (; untyped < names.size(); ++untyped) names[untyped].types = types;
  }
  for (; untyped < names.size(); ++untyped) names[untyped].types = {Domain::kObjectType};
  return names;
}

std::vector<Node> Resolver::without_owners(const Node& section) {
  std::vector<Node> items;
  for (const Node& item : section.rest()) {
    if (item.head() != ":private") {
      items.push_back(item);
      continue;
    }
    std::span<const Node> inner = item.rest();
    if (section.head() == ":predicates")  // of an agent, a variable with its type
      while (!inner.empty() && !(inner.front().is_list && inner.front().head() != "either")) inner = inner.subspan(1);
    else if (!inner.empty())  // of an agent, an object
      inner = inner.subspan(1);
    items.insert(items.end(), inner.begin(), inner.end());
  }
  return items;
}

void Resolver::declare_objects(const Node& section, std::string_view what) {
  const std::vector<Node> items = without_owners(section);
  for (TypedName& entry : typed_list(items, what)) {
    const auto [known, fresh] = object_names_.emplace(entry.name->word, static_cast<int>(objects_.size()));
    if (fresh) objects_.push_back({std::string(entry.name->word), {}, source(*entry.name)});
    std::vector<TypeId>& types = objects_[known->second].types;
    for (const TypeId type : entry.types)
      if (std::ranges::find(types, type) == types.end()) types.push_back(type);
  }
}

std::vector<Variable> Resolver::variables(const Node& list) {
  if (!list.is_list) fail(list, found_text(list.word, "a list of variables: (?x ?y - TYPE ...)"));
  return variables(list.items);
}

std::vector<Variable> Resolver::signature(std::span<const Node> items) {
  std::vector<Variable> out;
  int slot = 0;
  for (TypedName& entry : typed_list(items, "a variable")) {
    const std::string name(entry.name->word);
    if (name.size() < 2 || name[0] != '?')
      fail(*entry.name, found_text(name, "a variable such as ?"), name == "?" ? "x" : name);
    out.push_back({name, std::move(entry.types), slot++});
  }
  return out;
}

std::vector<Variable> Resolver::variables(std::span<const Node> items) {
  std::vector<Variable> out = signature(items);
  for (Variable& variable : out) {
    const auto first = std::ranges::find(out, variable.name, &Variable::name);
    if (&*first != &variable) fail(items.front(), "found variable ", variable.name, " twice in one list");
  }
  declare(out);
  return out;
}

void Resolver::declare(std::vector<Variable>& variables) {
  for (Variable& variable : variables) variable.slot = slots_++;
  scope_.insert(scope_.end(), variables.begin(), variables.end());
}

Term Resolver::term(const Node& node) {
  if (node.is_list) fail(node, found_expected(message(node), "an object or a variable"));
  if (node.word.starts_with('?')) {
    for (const Variable& variable : scope_ | std::views::reverse)
      if (variable.name == node.word) return Term::variable(variable.slot);
    NameTable known;
    for (const Variable& variable : scope_) known.emplace(variable.name, 0);
    fail(node, "found variable ", node.word, ", which is not declared here", hint(node.word, known));
  }
  const int id = find(object_names_, node.word);
  if (id < 0)
    fail(node, found_text(node.word, "a variable or "),
         which_ == Source::File::kDomain ? "a constant of the domain" : "an object", hint(node.word, object_names_));
  return Term::object(id);
}

template <class Declaration>
std::vector<Term> Resolver::arguments(const Node& node, const Declaration& declaration) {
  const std::vector<Variable>& parameters = declaration.parameters;
  if (node.rest().size() != parameters.size())
    fail(node, found_expected(message(count(node.rest().size(), "argument"), " in ", node), message(parameters.size())),
         declared(declaration.source));
  std::vector<Term> terms;
  for (const Variable& parameter : parameters) {
    const Node& item = node.rest()[terms.size()];
    const Term& argument = terms.emplace_back(term(item));
    const auto reject = [&](const std::vector<TypeId>& types, const Source& its_source) {
      fail(item, found_expected(message(item.word, " of type ", type_names(types)), "type "),
           type_names(parameter.types), " for argument ", terms.size(), " of ", declaration.name,
           declared(its_source, item.word), declared(declaration.source, declaration.name));
    };
    if (argument.is_variable) {
      const Variable& variable = *std::ranges::find(scope_, argument.index, &Variable::slot);
      if (!may_be(variable.types, parameter.types)) reject(variable.types, {});
    } else if (const Object& object = objects_[argument.index]; !fits(domain_, object, parameter.types)) {
      reject(object.types, object.source);
    }
  }
  return terms;
}

Resolver::Call Resolver::atom(const Node& node, Words words) {
  const std::string_view name = node.head();
  if (name.empty()) fail(node, found_expected(message(node), "(PREDICATE ARGUMENT...)"));
  if ((name == "at" || name == "over") && node.items.size() == 3 && node.items[2].is_list)
    fail(node,
         found_expected(message(node, " where ", in_durative_ ? "the time is already given" : "no time can be given"),
                        "(PREDICATE ARGUMENT...)"));
  const PredicateId predicate = find(domain_.predicate_names, name);
  if (predicate >= 0) return {predicate, arguments(node, domain_.predicates[predicate])};
  if (name == "preference" || std::ranges::find(kTrajectoryWords, name) != std::end(kTrajectoryWords))
    fail_unsupported(node, "found (", name, " ...): preferences and trajectory constraints are not supported");
  if (name == "oneof" || name == "probabilistic" || name == "unknown")
    fail_unsupported(node, "found (", name, " ...): actions with several outcomes are not supported");
  if (const int function = find(domain_.function_names, name); function >= 0)
    fail(node, found_expected(message("the numeric fluent '", name, "'"), "a predicate"),
         declared(domain_.functions[function].source));
  fail(node, found_text(name, "a predicate of the domain"), hint(name, domain_.predicate_names, words));
}

Resolver::Call Resolver::function_term(const Node& node, Words words) {
  const std::string_view name = node.is_list ? node.head() : node.word;
  if (name.empty()) fail(node, found_expected(message(node), "a number, (FUNCTION ARGUMENT...) or (+ - * / ...)"));
  const FunctionId function = find(domain_.function_names, name);
  if (function < 0) {
    if (const int predicate = find(domain_.predicate_names, name); predicate >= 0)
      fail(node, found_expected(message("the predicate '", name, "'"), "a numeric fluent"),
           declared(domain_.predicates[predicate].source));
    fail(node, found_text(name, "a number or a function of the domain"), hint(name, domain_.function_names, words));
  }
  const Function& declaration = domain_.functions[function];
  if (!node.is_list && !declaration.parameters.empty())
    fail(node, found_expected(message("'", name, "' without arguments"), message(declaration.parameters.size())),
         declared(declaration.source));
  return {function, arguments(node, declaration)};
}

void Resolver::expect_exact(const Node& number, double value) const {
  std::string_view digits = number.word;
  if (digits.starts_with('-') || digits.starts_with('+')) digits.remove_prefix(1);
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  const bool is_whole = digits.find_first_not_of("0123456789") == digits.npos;
  if (is_whole && !digits.empty() && number_text(std::abs(value)) != digits)
    fail_unsupported(number, "found the number ", number.word, ": whole numbers beyond 9007199254740992 are read as ",
                     number_text(value), ", which is another one");
}

Expression Resolver::expression(const Node& node, Place place) {
  using Kind = Expression::Kind;
  Expression out;
  if (!node.is_list) {
    if (to_number(node.word, out.value)) {
      expect_exact(node, out.value);
      return out;
    }
    if (node.word == "?duration" && in_durative_ && (place == Place::kCondition || place == Place::kEffect)) {
      out.kind = Kind::kDuration;
      return out;
    }
    if (node.word == "#t")
      fail(node, found_expected("#t", "it only in the rate of a continuous effect: (increase (f) (* #t RATE))"));
  }
  const std::string_view head = node.is_list ? node.head() : node.word;
  if (head == "total-time" && place == Place::kMetric && find(domain_.function_names, "total-time") < 0) {
    out.kind = Kind::kTotalTime;
    return out;
  }
  if (head == "is-violated") fail_unsupported(node, "found (is-violated ...): preferences are not supported");
  const auto kind = node.is_list ? kind_of<Kind>(kExpressionWords, head) : std::nullopt;
  if (!kind) {
    out.kind = Kind::kFunction;
    std::tie(out.function, out.terms) = function_term(node, place == Place::kMetric ? Words(kMetricWords) : Words());
    return out;
  }
  const std::size_t operands = node.rest().size();
  out.kind = kind == Kind::kSubtract && operands == 1 ? Kind::kNegate : *kind;
  const bool many = kind == Kind::kAdd || kind == Kind::kMultiply;
  if (out.kind != Kind::kNegate && (many ? operands < 2 : operands != 2))
    fail(node, found_expected(message(count(operands, "operand"), " in ", node), many ? "at least 2" : "2"));
  for (const Node& operand : node.rest()) out.operands.push_back(expression(operand, place));
  return out;
}

bool Resolver::looks_numeric(const Node& node) const {
  double number = 0;
  return node.is_list || to_number(node.word, number) || node.word == "?duration" || node.word == "#t" ||
         (find(domain_.function_names, node.word) >= 0 && find(object_names_, node.word) < 0);
}

Condition Resolver::condition(const Node& node) {
  using Kind = Condition::Kind;
  Condition out;
  out.source = source(node);
  if (!node.is_list) fail(node, found_text(node.word, "a condition in parentheses"));
  if (node.items.empty()) return out;
  const std::string_view head = node.head();
  const std::span<const Node> operands = node.rest();
  const auto check_count = [&](std::size_t wanted) {
    if (operands.size() != wanted)
      fail(node, found_expected(message(count(operands.size(), "operand"), " in ", node), message(wanted)));
  };
  if (const auto comparison = kind_of<Comparison>(kComparisonWords, head)) {
    check_count(2);
    out.comparison = *comparison;
    if (comparison == Comparison::kEqual && std::ranges::none_of(operands, [&](auto& n) { return looks_numeric(n); })) {
      out.kind = Kind::kSame;
      for (const Node& operand : operands) out.terms.push_back(term(operand));
    } else {
      out.kind = Kind::kCompare;
      for (const Node& operand : operands) out.sides.push_back(expression(operand, Place::kCondition));
    }
    return out;
  }
  out.kind = kind_of<Kind>(kConditionWords, head).value_or(Kind::kAtom);
  if (out.kind == Kind::kAtom) {
    std::tie(out.predicate, out.terms) = atom(node, kOperators);
  } else if (out.kind == Kind::kForall || out.kind == Kind::kExists) {
    if (operands.size() != 2) fail(node, found_expected(message(node), "("), head, " (?x - TYPE ...) CONDITION)");
    const std::size_t outer = scope_.size();
    out.variables = variables(operands[0]);
    out.operands.push_back(condition(operands[1]));
    scope_.resize(outer);
  } else {
    if (out.kind == Kind::kNot) check_count(1);
    if (out.kind == Kind::kImply) check_count(2);
    for (const Node& operand : operands) out.operands.push_back(condition(operand));
  }
  return out;
}

TimedCondition Resolver::conditions(const Node& node) {
  TimedCondition out;
  if (in_durative_)
    timed_condition(node, out);
  else
    out.start = condition(node);
  return out;
}

void Resolver::timed_condition(const Node& node, TimedCondition& out) {
  constexpr std::string_view kForms = "(at start ...), (over all ...) or (at end ...)";
  if (!node.is_list) fail(node, found_text(node.word, kForms));
  if (node.items.empty()) return;
  const std::string_view head = node.head();
  if (head == "and") {
    for (const Node& part : node.rest()) timed_condition(part, out);
    return;
  }
  if (head == "forall") {
    if (node.items.size() != 3) fail(node, found_expected(message(node), "(forall (?x - TYPE ...) TIMED-CONDITION)"));
    const std::size_t outer = scope_.size();
    const std::vector<Variable> bound = variables(node.items[1]);
    TimedCondition inner;
    timed_condition(node.items[2], inner);
    scope_.resize(outer);
    for (Condition TimedCondition::* time : {&TimedCondition::start, &TimedCondition::over_all, &TimedCondition::end}) {
      if ((inner.*time).is_true()) continue;
      Condition all;
      all.kind = Condition::Kind::kForall;
      all.source = source(node);
      all.variables = bound;
      all.operands.push_back(std::move(inner.*time));
      conjoin(out.*time, std::move(all));
    }
    return;
  }
  if (head == "preference") fail_unsupported(node, "found (preference ...): preferences are not supported");
  const std::string_view when = node.items.size() == 3 ? node.items[1].word : std::string_view();
  Condition* into = nullptr;
  if (head == "at" && when == "start") into = &out.start;
  if (head == "at" && when == "end") into = &out.end;
  if (head == "over" && when == "all") into = &out.over_all;
  if (into == nullptr) fail(node, found_expected(message(node), kForms));
  conjoin(*into, condition(node.items[2]));
}

Fact Resolver::ground_fact(const Node& node) {
  if (!node.is_list) fail(node, found_text(node.word, "(PREDICATE OBJECT...)"));
  const auto [predicate, terms] = atom(node, {});
  return {predicate, objects_in(terms)};
}

Fact Resolver::ground_function(const Node& node) {
  const auto [function, terms] = function_term(node, {});
  return {function, objects_in(terms)};
}

void conjoin(Condition& into, Condition&& more) {
  if (more.is_true()) return;
  if (into.is_true()) {
    into = std::move(more);
    return;
  }
  if (into.kind != Condition::Kind::kAnd) {
    Condition both;
    both.source = into.source;
    both.operands.push_back(std::move(into));
    into = std::move(both);
  }
  if (more.kind == Condition::Kind::kAnd)
    std::ranges::move(more.operands, std::back_inserter(into.operands));
  else
    into.operands.push_back(std::move(more));
}

}  // namespace cxlab::planner
