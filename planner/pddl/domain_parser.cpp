#include <algorithm>
#include <array>
#include <map>

#include "planner/pddl/parser.h"
#include "planner/pddl/resolver.h"

namespace cxlab::planner {
namespace {

constexpr std::array kSupported = {":strips",
                                   ":typing",
                                   ":negative-preconditions",
                                   ":disjunctive-preconditions",
                                   ":equality",
                                   ":existential-preconditions",
                                   ":universal-preconditions",
                                   ":quantified-preconditions",
                                   ":conditional-effects",
                                   ":fluents",
                                   ":numeric-fluents",
                                   ":adl",
                                   ":durative-actions",
                                   ":duration-inequalities",
                                   ":continuous-effects",
                                   ":derived-predicates",
                                   ":timed-initial-literals",
                                   ":timed-initial-fluents",
                                   ":timed-effects",
                                   ":action-costs",
                                   ":time",
                                   ":timed-initial-effects",  // as the Unified Planning Framework writes it
                                   ":true-negation",          // of PDDL 1.2
                                   ":domain-axioms",
                                   ":expression-evaluation",
                                   ":multi-agent",  // of planning for several agents, where agents are objects
                                   ":unfactored-privacy"};

constexpr std::array kReserved = {"and",      "or",         "not",      "imply",     "forall", "exists",
                                  "when",     "preference", "=",        "<",         "<=",     ">",
                                  ">=",       "+",          "-",        "*",         "/",      "assign",
                                  "increase", "decrease",   "scale-up", "scale-down"};

/// The lowest stratum in which a rule with this condition can stand.
int needed_stratum(const Domain& domain, const Condition& condition) {
  int stratum = 0;
  for_each_part(condition, [&](const Condition& part, bool negated) {
    if (part.kind != Condition::Kind::kAtom || !domain.predicates[part.predicate].derived) return;
    stratum = std::max(stratum, domain.predicates[part.predicate].stratum + (negated ? 1 : 0));
  });
  return stratum;
}

class DomainParser {
 public:
  DomainParser(const Node& root, const std::string& file)
      : root_(root), resolver_(domain_, domain_.constants, constant_names_, domain_.file, Source::File::kDomain) {
    domain_.file = file;
  }

  Domain parse() {
    domain_.name = resolver_.define(
        root_, {"domain",
                "problem",
                {":requirements", ":types", ":constants", ":predicates", ":functions", ":timeless", ":derived",
                 ":axiom", ":action", ":durative-action"},
                {},
                {":constraints", ":process", ":event", ":task", ":method", ":extends", ":domain-variables", ":safety"},
                ":requirements, :types, :constants, :predicates, :functions, :derived, :action or :durative-action"});
    for (const Node& section : sections(root_, ":requirements")) requirements(section);
    types();
    for (const Node& section : sections(root_, ":constants")) resolver_.declare_objects(section, "a constant");
    for (const Node& section : sections(root_, ":predicates")) predicates(section);
    for (const Node& section : sections(root_, ":functions")) functions(section);
    // A rule may read predicates that later rules derive, so heads come first.
    for (const Node& section : sections(root_, ":derived")) derived_name(section);
    for (const Node& section : sections(root_, ":axiom")) axiom_name(section);
    for (const Node& section : sections(root_, ":derived")) derived_rule(section);
    for (const Node& section : sections(root_, ":axiom")) axiom(section);
    for (const Node& section : sections(root_, ":timeless"))
      for (const Node& fact : section.rest()) timeless(fact);
    for (const Node& section : root_.items)
      if (section.head() == ":action" || section.head() == ":durative-action") action(section);
    stratify();
    reject_change_that_is_not_linear();
    return std::move(domain_);
  }

 private:
  void requirements(const Node& section) {
    for (const Node& item : section.rest()) {
      if (item.is_list || !item.word.starts_with(':'))
        resolver_.fail(item, found_expected(message(item), "a requirement such as :typing"));
      if (std::ranges::find(kSupported, item.word) == kSupported.end())
        resolver_.fail_unsupported(item, "found requirement ", item.word, ": not supported",
                                   did_you_mean(std::string(item.word), {kSupported.begin(), kSupported.end()}));
      domain_.requirements.emplace_back(item.word);
    }
  }

  // Types may be used before they are declared, so names come first.
  void types() {
    domain_.types.push_back({"object", {}, {}});
    domain_.type_names["object"] = Domain::kObjectType;
    for (const Node& section : sections(root_, ":types")) type_names(section);
    for (const Node& section : sections(root_, ":types")) type_parents(section);
    for (Type& type : domain_.types | std::views::drop(1))
      if (type.parents.empty()) type.parents = {Domain::kObjectType};
    const std::size_t n = domain_.types.size();
    domain_.ancestors.assign(n * n, 0);
    for (std::size_t i = 0; i < n; ++i) find_ancestors(static_cast<TypeId>(i), domain_.ancestors.data() + i * n);
  }

  void type_names(const Node& section) {
    const auto add = [&](const Node& node) {
      const int fresh = static_cast<int>(domain_.types.size());
      if (domain_.type_names.emplace(node.word, fresh).second)
        domain_.types.push_back({std::string(node.word), {}, resolver_.source(node)});
    };
    std::vector<const Node*> parents;  // which may stand nowhere else
    for (std::size_t i = 1; i < section.items.size(); ++i) {
      const Node& item = section.items[i];
      const bool is_parent = section.items[i - 1].is_word("-");
      if (item.is_list && (!is_parent || item.head() != "either"))
        resolver_.fail(item, found_expected(message(item), "a type"));
      for (const Node& parent : item.rest()) parents.push_back(&parent);
      if (item.is_list) continue;
      if (is_parent)
        parents.push_back(&item);
      else if (item.word != "-")
        add(item);
    }
    for (const Node* parent : parents) {
      if (parent->is_list || parent->is_word("-")) resolver_.fail(*parent, found_expected(message(*parent), "a type"));
      if (parent->word.starts_with('?'))
        resolver_.fail(*parent, found_expected(message("the variable ", parent->word), "a type"));
      add(*parent);
    }
  }

  void type_parents(const Node& section) {
    for (const Resolver::TypedName& entry : resolver_.typed_list(section.rest(), "a type")) {
      const TypeId id = find(domain_.type_names, entry.name->word);
      if (id == Domain::kObjectType) {
        if (entry.types != std::vector<TypeId>{Domain::kObjectType})
          resolver_.fail(*entry.name, found_expected("a supertype of object", "none: object is the root of all types"));
        continue;
      }
      auto& parents = domain_.types[id].parents;
      for (const TypeId parent : entry.types)
        if (std::ranges::find(parents, parent) == parents.end()) parents.push_back(parent);
    }
  }

  /// `row` is that of the type in Domain::ancestors.
  void find_ancestors(TypeId type, char* row) {
    std::vector<TypeId> open = {type};
    row[type] = 1;
    while (!open.empty()) {
      const TypeId next = open.back();
      open.pop_back();
      for (const TypeId parent : domain_.types[next].parents) {
        if (parent == type) {
          Node at;
          at.line = domain_.types[type].source.line;
          resolver_.fail(at, "type '", domain_.types[type].name,
                         "' is its own supertype, expected types without a cycle");
        }
        if (std::exchange(row[parent], 1) == 0) open.push_back(parent);
      }
    }
  }

  /// A new predicate, function or action.
  template <class Item>
  Item& declare(const Node& node, const char* kind, std::string_view name, ById<Item>& items, NameTable& names) {
    const auto [known, fresh] = names.emplace(name, static_cast<int>(items.size()));
    if (!fresh)
      resolver_.fail(node, "found ", kind, " '", name, "' a second time",
                     resolver_.declared(items[known->second].source));
    Item& item = items.emplace_back();
    item.name = name;
    item.source = resolver_.source(node);
    return item;
  }

  /// The parameters of `(name ?x - t ...)`, the head of a predicate or function.
  std::vector<Variable> signature(const Node& node, const char* what) {
    const std::string_view name = node.head();
    if (name.empty()) resolver_.fail(node, found_expected(message(node), message(what)), " such as (name ?x - TYPE)");
    if (name.starts_with('?'))
      resolver_.fail(node, found_expected(message("the variable ", name), "the name of "), what);
    if (std::ranges::find(kReserved, name) != kReserved.end())
      resolver_.fail(node, "found '", name, "' as the name of ", what, ", which is a word of the language");
    return resolver_.signature(node.rest());
  }

  void predicates(const Node& section) {
    for (const Node& node : Resolver::without_owners(section)) {
      if (node.head() == "=") continue;  // some files declare what is built in
      std::vector<Variable> parameters = signature(node, "a predicate");
      declare(node, "predicate", node.head(), domain_.predicates, domain_.predicate_names).parameters =
          std::move(parameters);
    }
  }

  void functions(const Node& section) {
    for (std::size_t i = 1; i < section.items.size(); ++i) {
      const Node& node = section.items[i];
      if (node.is_word("-") && i + 1 < section.items.size()) {
        const Node& type = section.items[++i];
        if (!type.is_word("number"))
          resolver_.fail_unsupported(type, "found a function of type ", type,
                                     ": object fluents are not supported, only numbers");
        continue;
      }
      std::vector<Variable> parameters = signature(node, "a function");
      declare(node, "function", node.head(), domain_.functions, domain_.function_names).parameters =
          std::move(parameters);
    }
  }

  void timeless(const Node& node) {
    resolver_.begin_frame(false);
    Fact fact = resolver_.ground_fact(node);
    if (domain_.predicates[fact.predicate].derived)
      resolver_.fail(node, found_expected(message(node, ", which is derived by a rule"), "a predicate without one"));
    domain_.timeless.push_back(std::move(fact));
  }

  /// (:axiom :vars (?x ...) :context CONDITION :implies (PREDICATE ?x ...)), the rule of PDDL 1.2.
  struct Axiom {
    const Node* variables = nullptr;
    const Node* context = nullptr;
    const Node* implies = nullptr;
  };
  Axiom axiom_parts(const Node& section) {
    Axiom found;
    for (std::size_t i = 1; i + 1 < section.items.size(); i += 2) {
      const Node& key = section.items[i];
      if (key.is_word(":vars"))
        found.variables = &section.items[i + 1];
      else if (key.is_word(":context"))
        found.context = &section.items[i + 1];
      else if (key.is_word(":implies"))
        found.implies = &section.items[i + 1];
    }
    if (!found.implies || found.implies->head().empty())
      resolver_.fail(section,
                     found_expected(message(section),
                                    "(:axiom :vars (?x - TYPE ...) :context CONDITION :implies (PREDICATE ?x ...))"));
    return found;
  }

  void axiom_name(const Node& section) { mark_derived(*axiom_parts(section).implies); }

  /// Every parameter of the predicate is the argument of the head, and all variables of the rule that are no parameters
  /// exist.
  void axiom(const Node& section) {
    const Axiom from = axiom_parts(section);
    const Node& head = *from.implies;
    Derivation rule;
    rule.source = resolver_.source(section);
    rule.predicate = find(domain_.predicate_names, head.head());
    const Predicate& predicate = domain_.predicates[rule.predicate];
    resolver_.begin_frame(false);
    std::vector<Variable> declared;
    if (from.variables) declared = resolver_.variables(*from.variables);
    if (head.rest().size() != predicate.parameters.size())
      resolver_.fail(head,
                     found_expected(message(head.rest().size(), " arguments of '", predicate.name, "'"),
                                    message(predicate.parameters.size())),
                     resolver_.declared(predicate.source));
    std::vector<std::string_view> arguments;
    for (const Node& argument : head.rest()) {
      const auto variable = std::ranges::find(declared, argument.word, &Variable::name);
      if (variable == declared.end() || std::ranges::find(arguments, argument.word) != arguments.end())
        resolver_.fail_unsupported(head, "found ", argument,
                                   " in :implies: only different variables of :vars are supported");
      arguments.push_back(argument.word);
    }
    resolver_.begin_frame(false);
    Condition exists;
    exists.kind = Condition::Kind::kExists;
    exists.source = rule.source;
    for (const bool in_head : {true, false})
      for (const Variable& variable : declared)
        if ((std::ranges::find(arguments, variable.name) != arguments.end()) == in_head)
          (in_head ? rule.parameters : exists.variables).push_back(variable);
    std::ranges::sort(rule.parameters, {}, [&](const Variable& variable) {
      return std::ranges::find(arguments, variable.name) - arguments.begin();
    });
    resolver_.declare(rule.parameters);
    resolver_.declare(exists.variables);
    Condition context = from.context ? resolver_.condition(*from.context) : Condition();
    if (exists.variables.empty()) {
      rule.condition = std::move(context);
    } else {
      exists.operands.push_back(std::move(context));
      rule.condition = std::move(exists);
    }
    rule.slots = resolver_.slots();
    domain_.derivations.push_back(std::move(rule));
  }

  void mark_derived(const Node& head) {
    const int id = find(domain_.predicate_names, head.head());
    if (id < 0) resolver_.fail(head, found_text(head.head(), "a predicate that is declared in :predicates"));
    domain_.predicates[id].derived = true;
  }

  void derived_name(const Node& section) {
    if (section.items.size() != 3 || section.items[1].head().empty())
      resolver_.fail(section, found_expected(message(section), "(:derived (PREDICATE ?x - TYPE ...) CONDITION)"));
    mark_derived(section.items[1]);
  }

  void derived_rule(const Node& section) {
    const Node& head = section.items[1];
    Derivation rule;
    rule.source = resolver_.source(section);
    resolver_.begin_frame(false);
    rule.parameters = resolver_.variables(head.rest());
    rule.predicate = find(domain_.predicate_names, head.head());
    const Predicate& predicate = domain_.predicates[rule.predicate];
    if (rule.parameters.size() != predicate.parameters.size())
      resolver_.fail(head,
                     found_expected(message(rule.parameters.size(), " parameters of '", predicate.name, "'"),
                                    message(predicate.parameters.size())),
                     resolver_.declared(predicate.source));
    for (std::size_t i = 0; i < rule.parameters.size(); ++i)  // a rule need not repeat the types
      if (rule.parameters[i].types == std::vector<TypeId>{Domain::kObjectType})
        rule.parameters[i].types = predicate.parameters[i].types;
    rule.condition = resolver_.condition(section.items[2]);
    rule.slots = resolver_.slots();
    domain_.derivations.push_back(std::move(rule));
  }

  void action(const Node& section) {
    const bool durative = section.head() == ":durative-action";
    if (section.items.size() < 2 || section.items[1].is_list)
      resolver_.fail(section, found_expected(message(section), "the name of the action"));
    const std::string_view name = section.items[1].word;
    if (name.starts_with('?'))
      resolver_.fail(section.items[1], found_expected(message("the variable ", name), "the name of the action"));
    Action& action = declare(section, "action", name, domain_.actions, domain_.action_names);
    action.durative = durative;
    const std::string_view condition = durative ? ":condition" : ":precondition";
    std::map<std::string_view, const Node*> parts = {
        {":parameters", nullptr}, {":vars", nullptr}, {condition, nullptr}, {":effect", nullptr}};
    std::span<const Node> agent;
    if (durative) parts[":duration"] = nullptr;
    for (std::size_t i = 2; i < section.items.size(); i += 2) {
      const Node& key = section.items[i];
      if (key.is_word(":agent")) {  // `?a - TYPE` without parentheses
        std::size_t end = i + 1;
        while (end < section.items.size() && !section.items[end].word.starts_with(':')) ++end;
        agent = std::span(section.items).subspan(i + 1, end - i - 1);
        i = end - 2;
        continue;
      }
      if (key.is_word(":only-in-expansions") || key.is_word(":expansion") || key.is_word(":maintain"))
        resolver_.fail_unsupported(key, "found ", key, ": not supported");
      const auto part = parts.find(key.word);
      if (part == parts.end())
        resolver_.fail(key, found_expected(message(key), ":parameters, "),
                       durative ? ":duration, :condition or :effect of a durative action"
                                : ":precondition or :effect of an action");
      if (part->second) resolver_.fail(key, "found ", key.word, " a second time");
      if (i + 1 == section.items.size())
        resolver_.fail(key, found_expected(message("nothing behind ", key.word), "a list"));
      part->second = &section.items[i + 1];
    }
    if (durative && !parts[":duration"])
      resolver_.fail(section, "the durative action has no :duration, expected (= ?duration NUMBER)");
    resolver_.begin_frame(durative);
    // The agent comes before the parameters, and what PDDL 1.2 declares by :vars comes behind them.
    std::vector<Node> parameters(agent.begin(), agent.end());
    for (const Node* part : {parts[":parameters"], parts[":vars"]}) {
      if (!part) continue;
      if (!part->is_list) resolver_.fail(*part, found_text(part->word, "a list of variables: (?x ?y - TYPE ...)"));
      parameters.insert(parameters.end(), part->items.begin(), part->items.end());
    }
    action.parameters = resolver_.variables(parameters);
    if (const Node* part = parts[":duration"]) action.duration = resolver_.duration(*part);
    if (const Node* part = parts[condition]) action.condition = resolver_.conditions(*part);
    if (const Node* part = parts[":effect"]) action.effects = resolver_.effects(*part);
    action.slots = resolver_.slots();
  }

  /// A rate that reads what changes continuously bends the change. Judged by functions, so that planner, validator and
  /// manager refuse the same domains.
  void reject_change_that_is_not_linear() const {
    ById<char> changes(domain_.functions.size(), 0);
    const auto each_rate = [this](const auto& visit) {
      for (const Action& action : domain_.actions)
        for (const Effect& effect : action.effects)
          if (effect.time == Effect::Time::kContinuous) visit(action, effect);
    };
    each_rate([&](const Action&, const Effect& effect) { changes[effect.function] = 1; });
    each_rate([&](const Action& action, const Effect& effect) {
      for_each_part(effect.value, [&](const Expression& part) {
        if (part.kind != Expression::Kind::kFunction || !changes[part.function]) return;
        Node at;
        at.line = effect.source.line;
        resolver_.fail_unsupported(at, "the rate of ", domain_.functions[effect.function].name, " in ", action.name,
                                   " reads ", domain_.functions[part.function].name,
                                   ", which changes continuously itself: only linear change is supported");
      });
    });
  }

  /// Sets the strata of derived predicates.
  void stratify() {
    const int highest = static_cast<int>(domain_.derivations.size());
    for (bool changed = true; std::exchange(changed, false);)
      for (const Derivation& rule : domain_.derivations) {
        Predicate& predicate = domain_.predicates[rule.predicate];
        const int needed = needed_stratum(domain_, rule.condition);
        if (needed <= predicate.stratum) continue;
        if (needed > highest) {
          Node at;
          at.line = rule.source.line;
          resolver_.fail(at, "derived predicate '", predicate.name,
                         "' depends on its own negation, expected rules without such a cycle",
                         resolver_.declared(predicate.source));
        }
        predicate.stratum = needed;
        changed = true;
      }
  }

  const Node& root_;
  Domain domain_;
  NameTable constant_names_;
  Resolver resolver_;
};

}  // namespace

Expected<Domain> parse_domain(std::string_view text, const std::string& file) {
  const auto syntax = read_syntax(text, file);
  if (!syntax) return syntax.error();
  return accepted([&] { return DomainParser(syntax->root, file).parse(); });
}

}  // namespace cxlab::planner
