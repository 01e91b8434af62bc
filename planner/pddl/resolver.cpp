#include "planner/pddl/resolver.h"

#include <algorithm>

#include "planner/pddl/parser.h"

namespace cxlab::planner {
namespace {

constexpr const char* kConditionWords[] = {"and", "or", "not", "imply", "forall", "exists"};
constexpr const char* kMetricWords[] = {"total-time"};

std::string hint(const std::string& word, const NameTable& names, std::span<const char* const> words = {}) {
  std::vector<std::string> candidates(words.begin(), words.end());
  for (const auto& entry : names) candidates.push_back(entry.first);
  std::sort(candidates.begin(), candidates.end());
  return did_you_mean(word, candidates, "; ");
}

std::string count(std::size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

std::optional<Comparison> to_comparison(std::string_view word) {
  if (word == "<") return Comparison::kLess;
  if (word == "<=") return Comparison::kLessEqual;
  if (word == "=") return Comparison::kEqual;
  if (word == ">=") return Comparison::kGreaterEqual;
  if (word == ">") return Comparison::kGreater;
  return std::nullopt;
}

bool is_trajectory_operator(std::string_view word) {
  for (const char* name : {"always", "sometime", "within", "at-most-once", "sometime-after", "sometime-before",
                           "always-within", "hold-during", "hold-after"})
    if (word == name) return true;
  return false;
}

}  // namespace

Resolver::Resolver(const Domain& domain, const ById<Object>& objects, const NameTable& object_names,
                   const std::string& file, Source::File which)
    : domain_(domain), objects_(objects), object_names_(object_names), file_(file), which_(which) {}

bool Resolver::fail(const Node& at, std::string message) {
  if (!error_) error_ = input_error(std::move(message), file_, at.line);
  return false;
}

bool Resolver::fail_unsupported(const Node& at, std::string message) {
  if (!error_) error_ = input_error(std::move(message), file_, at.line).with_code(word_of(Failure::kUnsupported));
  return false;
}

std::string Resolver::declared(const Source& source) const {
  if (source.line == 0) return {};
  return "; declared at " + (source.file == Source::File::kDomain ? domain_.file : file_) + ":" +
         std::to_string(source.line);
}

std::string Resolver::type_names(const std::vector<TypeId>& types) const {
  std::string text;
  for (const TypeId type : types) text += (text.empty() ? "" : " or ") + domain_.types[type].name;
  return text;
}

bool Resolver::may_be(const std::vector<TypeId>& types, const std::vector<TypeId>& wanted) const {
  for (TypeId below = 0; below < static_cast<TypeId>(domain_.types.size()); ++below) {
    const auto is_below = [&](TypeId type) { return domain_.is_a(below, type); };
    if (std::any_of(types.begin(), types.end(), is_below) && std::any_of(wanted.begin(), wanted.end(), is_below))
      return true;
  }
  return false;
}

void Resolver::begin_frame(bool durative) {
  in_durative_ = durative;
  scope_.clear();
  slots_ = 0;
}

bool Resolver::typed_list(const std::vector<Node>& items, std::size_t first, const char* what,
                          std::vector<TypedName>& out) {
  const auto type = [&](const Node& node, std::vector<TypeId>& types) {
    const int id = find(domain_.type_names, node.word);
    if (id < 0) {
      const std::string name(node.word);
      if (name.starts_with('?')) return fail(node, "found the variable " + name + ", expected a type");
      if (name == "number")
        return fail_unsupported(
            node, std::string(what) + " of type number: not supported, numbers are values of functions only");
      return fail(node, "found type '" + name + "', expected a type of the domain" + hint(name, domain_.type_names));
    }
    if (std::find(types.begin(), types.end(), id) == types.end()) types.push_back(id);
    return true;
  };
  std::size_t untyped = out.size();
  for (std::size_t i = first; i < items.size(); ++i) {
    const Node& item = items[i];
    if (item.is_list) return fail(item, "found " + excerpt(item) + ", expected " + what);
    if (item.word != "-") {
      if (item.word.starts_with('?') && std::string_view(what) != "a variable")
        return fail(item, "found the variable " + std::string(item.word) + ", expected " + what);
      out.push_back({&item, {}});
      continue;
    }
    if (i + 1 == items.size()) return fail(item, "found the end of the list behind '-', expected a type");
    if (untyped == out.size()) return fail(item, std::string("found '-', expected ") + what + " before it");
    const Node& types_node = items[++i];
    std::vector<TypeId> types;
    if (types_node.is_list) {
      if (types_node.head() != "either" || types_node.items.size() < 2)
        return fail(types_node, "found " + excerpt(types_node) + ", expected a type or (either TYPE...)");
      for (std::size_t k = 1; k < types_node.items.size(); ++k) {
        if (types_node.items[k].is_list)
          return fail(types_node, "found " + excerpt(types_node.items[k]) + ", expected a type");
        if (!type(types_node.items[k], types)) return false;
      }
    } else if (!type(types_node, types)) {
      return false;
    }
    for (; untyped < out.size(); ++untyped) out[untyped].types = types;
  }
  for (; untyped < out.size(); ++untyped) out[untyped].types = {Domain::kObjectType};
  return true;
}

bool Resolver::declare_variables(const Node& list, std::vector<Variable>& out) {
  if (!list.is_list)
    return fail(list, "found '" + std::string(list.word) + "', expected a list of variables: (?x ?y - TYPE ...)");
  std::vector<TypedName> names;
  if (!typed_list(list.items, 0, "a variable", names)) return false;
  const std::size_t first = out.size();
  for (TypedName& entry : names) {
    const std::string name(entry.name->word);
    if (name.size() < 2 || name[0] != '?')
      return fail(*entry.name, "found '" + name + "', expected a variable such as ?" + name);
    for (std::size_t i = first; i < out.size(); ++i)
      if (out[i].name == name) return fail(*entry.name, "found variable " + name + " twice in one list");
    out.push_back({name, std::move(entry.types), slots_++});
    scope_.push_back(out.back());
  }
  return true;
}

bool Resolver::term(const Node& node, Term& out) {
  if (node.is_list) return fail(node, "found " + excerpt(node) + ", expected an object or a variable");
  const std::string name(node.word);
  if (name.starts_with('?')) {
    for (auto variable = scope_.rbegin(); variable != scope_.rend(); ++variable)
      if (variable->name == name) {
        out = Term::variable(variable->slot);
        return true;
      }
    NameTable known;
    for (const Variable& variable : scope_) known.emplace(variable.name, 0);
    return fail(node, "found variable " + name + ", which is not declared here" + hint(name, known));
  }
  const int id = find(object_names_, name);
  if (id < 0)
    return fail(node, "found '" + name + "', expected a variable or " +
                          (which_ == Source::File::kDomain ? "a constant of the domain" : "an object") +
                          hint(name, object_names_));
  out = Term::object(id);
  return true;
}

bool Resolver::arguments(const Node& node, const std::string& name, const std::vector<Variable>& parameters,
                         const Source& declared_at, std::vector<Term>& terms) {
  if (node.items.size() - 1 != parameters.size())
    return fail(node, "found " + count(node.items.size() - 1, "argument") + " in " + excerpt(node) + ", expected " +
                          std::to_string(parameters.size()) + declared(declared_at));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Node& item = node.items[i + 1];
    Term argument;
    if (!term(item, argument)) return false;
    std::vector<TypeId> types;
    Source own_source;
    bool right = false;
    if (argument.is_variable) {
      for (const Variable& variable : scope_)
        if (variable.slot == argument.index) types = variable.types;
      right = may_be(types, parameters[i].types);
    } else {
      const Object& object = objects_[argument.index];
      types = object.types;
      own_source = object.source;
      right = fits(domain_, object, parameters[i].types);
    }
    if (!right)
      return fail(item, "found " + std::string(item.word) + " of type " + type_names(types) +
                            (argument.is_variable ? std::string{} : declared(own_source)) + "; expected type " +
                            type_names(parameters[i].types) + " for argument " + std::to_string(i + 1) + " of " + name +
                            declared(declared_at));
    terms.push_back(argument);
  }
  return true;
}

bool Resolver::atom(const Node& node, Words words, PredicateId& predicate, std::vector<Term>& terms) {
  const std::string name(node.head());
  if (name.empty()) return fail(node, "found " + excerpt(node) + ", expected (PREDICATE ARGUMENT...)");
  if ((name == "at" || name == "over") && node.items.size() == 3 && node.items[2].is_list)
    return fail(node, "found " + excerpt(node) + " where " +
                          (in_durative_ ? "the time is already given" : "no time can be given") +
                          ", expected (PREDICATE ARGUMENT...)");
  predicate = find(domain_.predicate_names, name);
  if (predicate < 0) {
    if (is_trajectory_operator(name) || name == "preference")
      return fail_unsupported(node,
                              "found (" + name + " ...): preferences and trajectory constraints are not supported");
    const int function = find(domain_.function_names, name);
    if (function >= 0)
      return fail(node, "found the numeric fluent '" + name + "', expected a predicate" +
                            declared(domain_.functions[function].source));
    return fail(
        node, "found '" + name + "', expected a predicate of the domain" + hint(name, domain_.predicate_names, words));
  }
  const Predicate& declaration = domain_.predicates[predicate];
  return arguments(node, name, declaration.parameters, declaration.source, terms);
}

bool Resolver::function_term(const Node& node, Words words, FunctionId& function, std::vector<Term>& terms) {
  const std::string name(node.is_list ? node.head() : node.word);
  if (name.empty())
    return fail(node, "found " + excerpt(node) + ", expected a number, (FUNCTION ARGUMENT...) or (+ - * / ...)");
  function = find(domain_.function_names, name);
  if (function < 0) {
    const int predicate = find(domain_.predicate_names, name);
    if (predicate >= 0)
      return fail(node, "found the predicate '" + name + "', expected a numeric fluent" +
                            declared(domain_.predicates[predicate].source));
    return fail(node, "found '" + name + "', expected a number or a function of the domain" +
                          hint(name, domain_.function_names, words));
  }
  const Function& declaration = domain_.functions[function];
  if (!node.is_list) {
    if (declaration.parameters.empty()) return true;
    return fail(node, "found '" + name + "' without arguments, expected " +
                          std::to_string(declaration.parameters.size()) + declared(declaration.source));
  }
  return arguments(node, name, declaration.parameters, declaration.source, terms);
}

bool Resolver::expression(const Node& node, Place place, Expression& out) {
  if (!node.is_list) {
    if (to_number(node.word, out.value)) return true;
    if (node.word == "?duration" && in_durative_ && (place == Place::kCondition || place == Place::kEffect)) {
      out.kind = Expression::Kind::kDuration;
      return true;
    }
    if (node.word == "#t")
      return fail(node, "found #t, expected it only in the rate of a continuous effect: (increase (f) (* #t RATE))");
  }
  const std::string_view head = node.is_list ? node.head() : node.word;
  if (head == "total-time" && place == Place::kMetric && find(domain_.function_names, "total-time") < 0) {
    out.kind = Expression::Kind::kTotalTime;
    return true;
  }
  if (head == "is-violated") return fail_unsupported(node, "found (is-violated ...): preferences are not supported");
  using Kind = Expression::Kind;
  std::optional<Kind> kind;
  if (node.is_list) {
    if (head == "+") kind = Kind::kAdd;
    if (head == "-") kind = Kind::kSubtract;
    if (head == "*") kind = Kind::kMultiply;
    if (head == "/") kind = Kind::kDivide;
  }
  if (!kind) {
    out.kind = Kind::kFunction;
    return function_term(node, place == Place::kMetric ? Words(kMetricWords) : Words{}, out.function, out.terms);
  }
  const std::size_t operands = node.items.size() - 1;
  if (*kind == Kind::kSubtract && operands == 1) kind = Kind::kNegate;
  const bool many = *kind == Kind::kAdd || *kind == Kind::kMultiply;
  const std::size_t wanted = *kind == Kind::kNegate ? 1 : 2;
  if (many ? operands < wanted : operands != wanted)
    return fail(node, "found " + count(operands, "operand") + " in " + excerpt(node) + ", expected " +
                          (many ? "at least 2" : "2"));
  out.kind = *kind;
  out.operands.resize(operands);
  for (std::size_t i = 0; i < operands; ++i)
    if (!expression(node.items[i + 1], place, out.operands[i])) return false;
  return true;
}

bool Resolver::looks_numeric(const Node& node) const {
  if (node.is_list) return true;
  double number = 0;
  return to_number(node.word, number) || node.word == "?duration" || node.word == "#t" ||
         (find(domain_.function_names, node.word) >= 0 && find(object_names_, node.word) < 0);
}

bool Resolver::equality_or_comparison(const Node& node, Condition& out) {
  if (node.items.size() != 3)
    return fail(node, "found " + count(node.items.size() - 1, "operand") + " in " + excerpt(node) + ", expected 2");
  out.comparison = *to_comparison(node.head());
  if (out.comparison == Comparison::kEqual && !looks_numeric(node.items[1]) && !looks_numeric(node.items[2])) {
    out.kind = Condition::Kind::kSame;
    out.terms.resize(2);
    return term(node.items[1], out.terms[0]) && term(node.items[2], out.terms[1]);
  }
  out.kind = Condition::Kind::kCompare;
  out.sides.resize(2);
  return expression(node.items[1], Place::kCondition, out.sides[0]) &&
         expression(node.items[2], Place::kCondition, out.sides[1]);
}

bool Resolver::quantified(const Node& node, Condition& out) {
  if (node.items.size() != 3)
    return fail(node,
                "found " + excerpt(node) + ", expected (" + std::string(node.head()) + " (?x - TYPE ...) CONDITION)");
  out.kind = node.head() == "forall" ? Condition::Kind::kForall : Condition::Kind::kExists;
  const std::size_t outer = scope_.size();
  out.operands.resize(1);
  if (!declare_variables(node.items[1], out.variables) || !condition(node.items[2], out.operands[0])) return false;
  scope_.resize(outer);
  return true;
}

bool Resolver::condition(const Node& node, Condition& out) {
  out.source = source(node);
  if (!node.is_list) return fail(node, "found '" + std::string(node.word) + "', expected a condition in parentheses");
  if (node.items.empty()) return true;
  const std::string_view head = node.head();
  if (head == "forall" || head == "exists") return quantified(node, out);
  if (to_comparison(head)) return equality_or_comparison(node, out);
  std::optional<std::size_t> wanted;
  if (head == "and") {
    out.kind = Condition::Kind::kAnd;
  } else if (head == "or") {
    out.kind = Condition::Kind::kOr;
  } else if (head == "not") {
    out.kind = Condition::Kind::kNot;
    wanted = 1;
  } else if (head == "imply") {
    out.kind = Condition::Kind::kImply;
    wanted = 2;
  } else {
    out.kind = Condition::Kind::kAtom;
    return atom(node, kConditionWords, out.predicate, out.terms);
  }
  if (wanted && node.items.size() - 1 != *wanted)
    return fail(node, "found " + count(node.items.size() - 1, "operand") + " in " + excerpt(node) + ", expected " +
                          std::to_string(*wanted));
  out.operands.resize(node.items.size() - 1);
  for (std::size_t i = 1; i < node.items.size(); ++i)
    if (!condition(node.items[i], out.operands[i - 1])) return false;
  return true;
}

bool Resolver::quantified_timed(const Node& node, TimedCondition& out) {
  if (node.items.size() != 3)
    return fail(node, "found " + excerpt(node) + ", expected (forall (?x - TYPE ...) TIMED-CONDITION)");
  const std::size_t outer = scope_.size();
  std::vector<Variable> variables;
  TimedCondition inner;
  if (!declare_variables(node.items[1], variables) || !timed_condition(node.items[2], inner)) return false;
  scope_.resize(outer);
  const auto wrap = [&](Condition&& body, Condition& into) {
    if (body.is_true()) return;
    Condition all;
    all.kind = Condition::Kind::kForall;
    all.source = source(node);
    all.variables = variables;
    all.operands.push_back(std::move(body));
    conjoin(into, std::move(all));
  };
  wrap(std::move(inner.start), out.start);
  wrap(std::move(inner.over_all), out.over_all);
  wrap(std::move(inner.end), out.end);
  return true;
}

bool Resolver::timed_condition(const Node& node, TimedCondition& out) {
  if (!node.is_list)
    return fail(node,
                "found '" + std::string(node.word) + "', expected (at start ...), (over all ...) or (at end ...)");
  if (node.items.empty()) return true;
  const std::string_view head = node.head();
  if (head == "and") {
    for (std::size_t i = 1; i < node.items.size(); ++i)
      if (!timed_condition(node.items[i], out)) return false;
    return true;
  }
  if (head == "forall") return quantified_timed(node, out);
  const std::string_view when =
      node.items.size() == 3 && !node.items[1].is_list ? node.items[1].word : std::string_view{};
  Condition* into = nullptr;
  if (head == "at" && when == "start") into = &out.start;
  if (head == "at" && when == "end") into = &out.end;
  if (head == "over" && when == "all") into = &out.over_all;
  if (head == "preference") return fail_unsupported(node, "found (preference ...): preferences are not supported");
  if (into == nullptr)
    return fail(node, "found " + excerpt(node) + ", expected (at start ...), (over all ...) or (at end ...)");
  Condition parsed;
  if (!condition(node.items[2], parsed)) return false;
  conjoin(*into, std::move(parsed));
  return true;
}

bool Resolver::metric(const Node& node, Expression& out) { return expression(node, Place::kMetric, out); }

bool Resolver::ground(const std::vector<Term>& terms, const Node& node, std::vector<ObjectId>& out) {
  for (const Term& term : terms) {
    if (term.is_variable) return fail(node, "found a variable in " + excerpt(node) + ", expected objects");
    out.push_back(term.index);
  }
  return true;
}

bool Resolver::ground_fact(const Node& node, Fact& out) {
  if (!node.is_list) return fail(node, "found '" + std::string(node.word) + "', expected (PREDICATE OBJECT...)");
  std::vector<Term> terms;
  return atom(node, {}, out.predicate, terms) && ground(terms, node, out.objects);
}

bool Resolver::ground_function(const Node& node, Assignment& out) {
  std::vector<Term> terms;
  return function_term(node, {}, out.function, terms) && ground(terms, node, out.objects);
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
  if (more.kind == Condition::Kind::kAnd) {
    for (Condition& operand : more.operands) into.operands.push_back(std::move(operand));
  } else {
    into.operands.push_back(std::move(more));
  }
}

}  // namespace cxlab::planner
