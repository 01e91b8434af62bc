#include <algorithm>
#include <array>

#include "planner/pddl/parser.h"
#include "planner/pddl/resolver.h"
#include "planner/pddl/stratify.h"

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
                                   ":time"};

constexpr std::array kReserved = {"and",      "or",         "not",      "imply",     "forall", "exists",
                                  "when",     "preference", "=",        "<",         "<=",     ">",
                                  ">=",       "+",          "-",        "*",         "/",      "assign",
                                  "increase", "decrease",   "scale-up", "scale-down"};

class DomainParser {
 public:
  DomainParser(const Node& root, const std::string& file)
      : root_(root), resolver_(domain_, domain_.constants, constant_names_, domain_.file, Source::File::kDomain) {
    domain_.file = file;
  }

  Expected<Domain> parse() {
    if (!define() || !each(":requirements", &DomainParser::requirements) || !types() ||
        !each(":constants", &DomainParser::constants) || !each(":predicates", &DomainParser::predicates) ||
        !each(":functions", &DomainParser::functions) || !each(":derived", &DomainParser::derived_name) ||
        !each(":derived", &DomainParser::derived_rule) || !actions())
      return resolver_.error();
    if (const auto rule = stratify(domain_)) {
      const Predicate& predicate = domain_.predicates[domain_.derivations[*rule].predicate];
      return input_error("derived predicate '" + predicate.name +
                             "' depends on its own negation, expected rules without such a cycle" +
                             resolver_.declared(predicate.source),
                         domain_.file, domain_.derivations[*rule].source.line);
    }
    return std::move(domain_);
  }

 private:
  using Section = bool (DomainParser::*)(const Node&);

  bool fail(const Node& at, std::string message) { return resolver_.fail(at, std::move(message)); }

  bool define() {
    if (root_.head() != "define")
      return fail(root_, "found " + excerpt(root_) + ", expected (define (domain NAME) ...)");
    if (root_.items.size() < 2 || root_.items[1].head() != "domain")
      return fail(root_, root_.items.size() > 1 && root_.items[1].head() == "problem"
                             ? "found a problem, expected a domain: (define (domain NAME) ...); are the files swapped?"
                             : "expected (domain NAME) behind 'define'");
    const Node& name = root_.items[1];
    if (name.items.size() != 2 || name.items[1].is_list)
      return fail(name, "found " + excerpt(name) + ", expected (domain NAME)");
    domain_.name = name.items[1].word;
    for (std::size_t i = 2; i < root_.items.size(); ++i)
      if (!known_section(root_.items[i])) return false;
    return true;
  }

  bool known_section(const Node& section) {
    const std::string head(section.head());
    for (const char* name : {":requirements", ":types", ":constants", ":predicates", ":functions", ":derived",
                             ":action", ":durative-action"})
      if (head == name) return true;
    for (const char* name : {":constraints", ":process", ":event", ":task", ":method", ":axiom"})
      if (head == name) return resolver_.fail_unsupported(section, "found section " + head + ": not supported");
    return fail(section, "found " + excerpt(section) +
                             ", expected :requirements, :types, :constants, :predicates, :functions, :derived, :action "
                             "or :durative-action");
  }

  bool each(std::string_view head, Section read) {
    for (std::size_t i = 2; i < root_.items.size(); ++i)
      if (root_.items[i].head() == head && !(this->*read)(root_.items[i])) return false;
    return true;
  }

  bool requirements(const Node& section) {
    for (std::size_t i = 1; i < section.items.size(); ++i) {
      const Node& item = section.items[i];
      if (item.is_list || !item.word.starts_with(':'))
        return fail(item, "found " + excerpt(item) + ", expected a requirement such as :typing");
      if (std::find(kSupported.begin(), kSupported.end(), item.word) == kSupported.end())
        return resolver_.fail_unsupported(
            item, "found requirement " + std::string(item.word) + ": not supported" +
                      did_you_mean(std::string(item.word), {kSupported.begin(), kSupported.end()}));
      domain_.requirements.emplace_back(item.word);
    }
    return true;
  }

  // Types may be used before they are declared, so names come first.
  bool types() {
    domain_.types.push_back({"object", {}, {}});
    domain_.type_names["object"] = Domain::kObjectType;
    std::vector<const Node*> sections;
    for (std::size_t i = 2; i < root_.items.size(); ++i)
      if (root_.items[i].head() == ":types") sections.push_back(&root_.items[i]);
    for (const Node* section : sections)
      if (!type_names(*section)) return false;
    for (const Node* section : sections)
      if (!type_parents(*section)) return false;
    for (std::size_t i = 1; i < domain_.types.size(); ++i)
      if (domain_.types[i].parents.empty()) domain_.types[i].parents = {Domain::kObjectType};
    return closure();
  }

  bool type_names(const Node& section) {
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
        return fail(item, "found " + excerpt(item) + ", expected a type");
      if (item.is_list) {
        for (std::size_t k = 1; k < item.items.size(); ++k) parents.push_back(&item.items[k]);
      } else if (is_parent) {
        parents.push_back(&item);
      } else if (item.word != "-") {
        add(item);
      }
    }
    for (const Node* parent : parents) {
      if (parent->is_list || parent->is_word("-"))
        return fail(*parent, "found " + excerpt(*parent) + ", expected a type");
      if (parent->word.starts_with('?'))
        return fail(*parent, "found the variable " + std::string(parent->word) + ", expected a type");
      add(*parent);
    }
    return true;
  }

  bool type_parents(const Node& section) {
    std::vector<Resolver::TypedName> names;
    if (!resolver_.typed_list(section.items, 1, "a type", names)) return false;
    for (const auto& entry : names) {
      const TypeId id = find(domain_.type_names, entry.name->word);
      if (id == Domain::kObjectType) {
        if (entry.types != std::vector<TypeId>{Domain::kObjectType})
          return fail(*entry.name, "found a supertype of object, expected none: object is the root of all types");
        continue;
      }
      auto& parents = domain_.types[id].parents;
      for (const TypeId parent : entry.types)
        if (std::find(parents.begin(), parents.end(), parent) == parents.end()) parents.push_back(parent);
    }
    return true;
  }

  bool closure() {
    const std::size_t n = domain_.types.size();
    domain_.ancestors.assign(n * n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      char* row = domain_.ancestors.data() + i * n;
      std::vector<TypeId> open = {static_cast<TypeId>(i)};
      row[i] = 1;
      while (!open.empty()) {
        const TypeId type = open.back();
        open.pop_back();
        for (const TypeId parent : domain_.types[type].parents) {
          if (parent == static_cast<TypeId>(i)) {
            Node at;
            at.line = domain_.types[i].source.line;
            return fail(at,
                        "type '" + domain_.types[i].name + "' is its own supertype, expected types without a cycle");
          }
          if (row[parent] == 0) {
            row[parent] = 1;
            open.push_back(parent);
          }
        }
      }
    }
    return true;
  }

  bool constants(const Node& section) {
    std::vector<Resolver::TypedName> names;
    if (!resolver_.typed_list(section.items, 1, "a constant", names)) return false;
    for (auto& entry : names) {
      const auto [known, fresh] = constant_names_.emplace(entry.name->word, static_cast<int>(domain_.constants.size()));
      if (fresh) {
        domain_.constants.push_back(
            {std::string(entry.name->word), std::move(entry.types), resolver_.source(*entry.name)});
      } else {  // declared twice: it belongs to both types
        auto& types = domain_.constants[known->second].types;
        for (const TypeId type : entry.types)
          if (std::find(types.begin(), types.end(), type) == types.end()) types.push_back(type);
      }
    }
    return true;
  }

  /// `(name ?x - t ...)`, the head of a predicate or function.
  bool signature(const Node& node, const char* what, std::string& name, std::vector<Variable>& parameters) {
    if (node.head().empty())
      return fail(node, "found " + excerpt(node) + ", expected " + what + " such as (name ?x - TYPE)");
    name = node.head();
    if (name.starts_with('?')) return fail(node, "found the variable " + name + ", expected the name of " + what);
    if (std::find(kReserved.begin(), kReserved.end(), name) != kReserved.end())
      return fail(node, "found '" + name + "' as the name of " + what + ", which is a word of the language");
    Node list;
    list.is_list = true;
    list.line = node.line;
    list.items.assign(node.items.begin() + 1, node.items.end());
    resolver_.begin_frame(false);
    return resolver_.declare_variables(list, parameters);
  }

  bool predicates(const Node& section) {
    for (std::size_t i = 1; i < section.items.size(); ++i) {
      const Node& node = section.items[i];
      Predicate predicate;
      predicate.source = resolver_.source(node);
      if (!signature(node, "a predicate", predicate.name, predicate.parameters)) return false;
      const auto [known, fresh] =
          domain_.predicate_names.emplace(predicate.name, static_cast<int>(domain_.predicates.size()));
      if (!fresh)
        return fail(node, "found predicate '" + predicate.name + "' a second time" +
                              resolver_.declared(domain_.predicates[known->second].source));
      domain_.predicates.push_back(std::move(predicate));
    }
    return true;
  }

  bool functions(const Node& section) {
    for (std::size_t i = 1; i < section.items.size(); ++i) {
      const Node& node = section.items[i];
      if (node.is_word("-") && i + 1 < section.items.size()) {
        const Node& type = section.items[++i];
        if (!type.is_word("number"))
          return resolver_.fail_unsupported(
              type, "found a function of type " + excerpt(type) + ": object fluents are not supported, only numbers");
        continue;
      }
      Function function;
      function.source = resolver_.source(node);
      if (!signature(node, "a function", function.name, function.parameters)) return false;
      const auto [known, fresh] =
          domain_.function_names.emplace(function.name, static_cast<int>(domain_.functions.size()));
      if (!fresh)
        return fail(node, "found function '" + function.name + "' a second time" +
                              resolver_.declared(domain_.functions[known->second].source));
      domain_.functions.push_back(std::move(function));
    }
    return true;
  }

  // A rule may read predicates that later rules derive, so heads come first.
  bool derived_name(const Node& section) {
    if (section.items.size() != 3 || section.items[1].head().empty())
      return fail(section, "found " + excerpt(section) + ", expected (:derived (PREDICATE ?x - TYPE ...) CONDITION)");
    const std::string name(section.items[1].head());
    const int id = find(domain_.predicate_names, name);
    if (id < 0)
      return fail(section.items[1], "found '" + name + "', expected a predicate that is declared in :predicates");
    domain_.predicates[id].derived = true;
    return true;
  }

  bool derived_rule(const Node& section) {
    Derivation rule;
    rule.source = resolver_.source(section);
    std::string name;
    if (!signature(section.items[1], "a predicate", name, rule.parameters)) return false;
    rule.predicate = find(domain_.predicate_names, name);
    const Predicate& predicate = domain_.predicates[rule.predicate];
    if (rule.parameters.size() != predicate.parameters.size())
      return fail(section.items[1], "found " + std::to_string(rule.parameters.size()) + " parameters of '" + name +
                                        "', expected " + std::to_string(predicate.parameters.size()) +
                                        resolver_.declared(predicate.source));
    for (std::size_t i = 0; i < rule.parameters.size(); ++i)  // a rule need not repeat the types
      if (rule.parameters[i].types == std::vector<TypeId>{Domain::kObjectType})
        rule.parameters[i].types = predicate.parameters[i].types;
    if (!resolver_.condition(section.items[2], rule.condition)) return false;
    rule.slots = resolver_.slots();
    domain_.derivations.push_back(std::move(rule));
    return true;
  }

  bool actions() {
    for (std::size_t i = 2; i < root_.items.size(); ++i) {
      const std::string_view head = root_.items[i].head();
      if ((head == ":action" || head == ":durative-action") && !action(root_.items[i])) return false;
    }
    return true;
  }

  struct Parts {
    const Node* parameters = nullptr;
    const Node* duration = nullptr;
    const Node* condition = nullptr;
    const Node* effect = nullptr;
  };

  bool split(const Node& section, bool durative, Parts& parts) {
    for (std::size_t i = 2; i < section.items.size(); i += 2) {
      const Node& key = section.items[i];
      const Node** part = nullptr;
      if (key.is_word(":parameters")) part = &parts.parameters;
      if (key.is_word(":effect")) part = &parts.effect;
      if (key.is_word(durative ? ":condition" : ":precondition")) part = &parts.condition;
      if (durative && key.is_word(":duration")) part = &parts.duration;
      if (part == nullptr)
        return fail(key, "found " + excerpt(key) + ", expected :parameters, " +
                             (durative ? ":duration, :condition or :effect of a durative action"
                                       : ":precondition or :effect of an action"));
      if (*part != nullptr) return fail(key, "found " + std::string(key.word) + " a second time");
      if (i + 1 == section.items.size())
        return fail(key, "found nothing behind " + std::string(key.word) + ", expected a list");
      *part = &section.items[i + 1];
    }
    if (durative && parts.duration == nullptr)
      return fail(section, "the durative action has no :duration, expected (= ?duration NUMBER)");
    return true;
  }

  bool action(const Node& section) {
    Action action;
    action.durative = section.head() == ":durative-action";
    action.source = resolver_.source(section);
    if (section.items.size() < 2 || section.items[1].is_list)
      return fail(section, "found " + excerpt(section) + ", expected the name of the action");
    action.name = section.items[1].word;
    if (action.name.starts_with('?'))
      return fail(section.items[1], "found the variable " + action.name + ", expected the name of the action");
    const auto [known, fresh] = domain_.action_names.emplace(action.name, static_cast<int>(domain_.actions.size()));
    if (!fresh)
      return fail(section, "found action '" + action.name + "' a second time" +
                               resolver_.declared(domain_.actions[known->second].source));
    Parts parts;
    if (!split(section, action.durative, parts)) return false;
    resolver_.begin_frame(action.durative);
    if (parts.parameters != nullptr && !resolver_.declare_variables(*parts.parameters, action.parameters)) return false;
    if (parts.duration != nullptr && !resolver_.duration(*parts.duration, action.duration)) return false;
    if (parts.condition != nullptr) {
      if (action.durative ? !resolver_.timed_condition(*parts.condition, action.condition)
                          : !resolver_.condition(*parts.condition, action.condition.start))
        return false;
    }
    if (parts.effect != nullptr) {
      if (action.durative ? !resolver_.timed_effects(*parts.effect, action.effects)
                          : !resolver_.effects(*parts.effect, action.effects))
        return false;
    }
    action.slots = resolver_.slots();
    domain_.actions.push_back(std::move(action));
    return true;
  }

  const Node& root_;
  Domain domain_;
  NameTable constant_names_;
  Resolver resolver_;
};

}  // namespace

Expected<Domain> parse_domain(std::string_view text, const std::string& file) {
  auto syntax = read_syntax(text, file);
  if (!syntax) return syntax.error();
  return DomainParser(syntax->root, file).parse();
}

}  // namespace cxlab::planner
