#include <algorithm>
#include <map>
#include <set>

#include "planner/pddl/parser.h"
#include "planner/pddl/resolver.h"

namespace cxlab::planner {
namespace {

/// Files of one pair often differ in `-` and `_`.
std::string plain_name(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class ProblemParser {
 public:
  ProblemParser(const Node& root, const std::string& file, const Domain& domain, const Deadline& deadline)
      : root_(root),
        deadline_(deadline),
        domain_(domain),
        resolver_(domain, problem_.objects, problem_.object_names, problem_.file, Source::File::kProblem) {
    problem_.file = file;
    problem_.objects = domain.constants;
    for (std::size_t i = 0; i < problem_.objects.size(); ++i)
      problem_.object_names[problem_.objects[i].name] = static_cast<int>(i);
  }

  Expected<Problem> parse() {
    if (!define() || !each(":domain", &ProblemParser::domain_name) || !each(":objects", &ProblemParser::objects) ||
        !each(":init", &ProblemParser::init) || !each(":goal", &ProblemParser::goal) ||
        !each(":metric", &ProblemParser::metric))
      return late_ ? too_late(problem_.file) : resolver_.error();
    finish();
    return std::move(problem_);
  }

 private:
  using Section = bool (ProblemParser::*)(const Node&);
  using ValueKey = std::pair<FunctionId, std::vector<ObjectId>>;
  using FactKey = std::pair<PredicateId, std::vector<ObjectId>>;

  bool fail(const Node& at, std::string message) { return resolver_.fail(at, std::move(message)); }

  bool define() {
    if (root_.head() != "define")
      return fail(root_, "found " + excerpt(root_) + ", expected (define (problem NAME) ...)");
    if (root_.items.size() < 2 || root_.items[1].head() != "problem")
      return fail(root_, root_.items.size() > 1 && root_.items[1].head() == "domain"
                             ? "found a domain, expected a problem: (define (problem NAME) ...); are the files swapped?"
                             : "expected (problem NAME) behind 'define'");
    const Node& name = root_.items[1];
    if (name.items.size() != 2 || name.items[1].is_list)
      return fail(name, "found " + excerpt(name) + ", expected (problem NAME)");
    problem_.name = name.items[1].word;
    for (std::size_t i = 2; i < root_.items.size(); ++i)
      if (!known_section(root_.items[i])) return false;
    return true;
  }

  bool known_section(const Node& section) {
    const std::string head(section.head());
    for (const char* name : {":domain", ":requirements", ":objects", ":init", ":length"})
      if (head == name) return true;
    for (const char* name : {":goal", ":metric"})
      if (head == name)
        return seen_.insert(head).second || fail(section, "found " + head + " a second time, expected one");
    for (const char* name : {":constraints", ":htn"})
      if (head == name) return resolver_.fail_unsupported(section, "found section " + head + ": not supported");
    return fail(section, "found " + excerpt(section) + ", expected :domain, :objects, :init, :goal or :metric");
  }

  bool each(std::string_view head, Section read) {
    for (std::size_t i = 2; i < root_.items.size(); ++i)
      if (root_.items[i].head() == head && !(this->*read)(root_.items[i])) return false;
    return true;
  }

  bool domain_name(const Node& section) {
    if (section.items.size() != 2 || section.items[1].is_list)
      return fail(section, "found " + excerpt(section) + ", expected (:domain NAME)");
    const std::string name(section.items[1].word);
    if (plain_name(name) == plain_name(domain_.name)) return true;
    return fail(section, "found domain '" + name + "', expected '" + domain_.name + "', the name in " + domain_.file);
  }

  bool objects(const Node& section) {
    std::vector<Resolver::TypedName> names;
    if (!resolver_.typed_list(section.items, 1, "an object", names)) return false;
    for (auto& entry : names) {
      const auto [known, fresh] =
          problem_.object_names.emplace(entry.name->word, static_cast<int>(problem_.objects.size()));
      if (fresh) {
        problem_.objects.push_back(
            {std::string(entry.name->word), std::move(entry.types), resolver_.source(*entry.name)});
        continue;
      }
      auto& types = problem_.objects[known->second].types;  // declared twice: it belongs to both types
      for (const TypeId type : entry.types)
        if (std::find(types.begin(), types.end(), type) == types.end()) types.push_back(type);
    }
    return true;
  }

  bool init(const Node& section) {
    for (std::size_t i = 1; i < section.items.size(); ++i)
      if (!element(section.items[i])) return false;
    return true;
  }

  bool element(const Node& node) {
    if (facts_++ % kReadBetweenLooks == 0 && is_over(deadline_)) late_ = true;
    if (late_) return false;
    const std::string_view head = node.head();
    double time = 0;
    if (head == "=") return value(node, std::nullopt);
    if (head == "at" && node.items.size() == 3 && node.items[2].is_list && !node.items[1].is_list &&
        to_number(node.items[1].word, time)) {
      if (time < 0)
        return fail(node, "found time " + std::string(node.items[1].word) + ", expected a time that is not negative");
      const Node& happens = node.items[2];
      return happens.head() == "=" ? value(happens, time) : literal(happens, time);
    }
    if (head == "and") {
      for (std::size_t i = 1; i < node.items.size(); ++i)
        if (!element(node.items[i])) return false;
      return true;
    }
    return literal(node, std::nullopt);
  }

  bool literal(const Node& node, std::optional<double> time) {
    const bool negative = node.head() == "not";
    if (negative && node.items.size() != 2)
      return fail(node, "found " + excerpt(node) + ", expected (not (PREDICATE OBJECT...))");
    const Node& positive = negative ? node.items[1] : node;
    Fact fact;
    if (!resolver_.ground_fact(positive, fact)) return false;
    const Predicate& predicate = domain_.predicates[fact.predicate];
    if (predicate.derived)
      return fail(node, "found '" + predicate.name + "', which is derived by a rule, expected a predicate without one" +
                            resolver_.declared(predicate.source));
    const FactKey key{fact.predicate, fact.objects};
    if (time && *time > 0) {
      problem_.timed_facts.push_back({*time, std::move(fact), !negative, resolver_.source(node)});
    } else if (negative) {
      if (true_.contains(key))
        return fail(node, "found " + excerpt(node) + ", but " + excerpt(positive) + " was true before");
    } else if (true_.insert(key).second) {
      problem_.init.push_back(std::move(fact));
    }
    return true;
  }

  bool value(const Node& node, std::optional<double> time) {
    Assignment assignment;
    if (node.items.size() != 3 || node.items[2].is_list || !to_number(node.items[2].word, assignment.value))
      return fail(node, "found " + excerpt(node) + ", expected (= (FUNCTION OBJECT...) NUMBER)");
    if (!resolver_.ground_function(node.items[1], assignment)) return false;
    if (time && *time > 0) {
      problem_.timed_values.push_back({*time, std::move(assignment), resolver_.source(node)});
      return true;
    }
    const auto [known, fresh] =
        values_.emplace(ValueKey{assignment.function, assignment.objects}, problem_.values.size());
    if (fresh) {
      problem_.values.push_back(std::move(assignment));
      return true;
    }
    if (problem_.values[known->second].value == assignment.value) return true;
    return fail(node, "found a second value for " + excerpt(node.items[1]) + ", expected one");
  }

  bool goal(const Node& section) {
    if (section.items.size() != 2)
      return fail(section, "found " + std::to_string(section.items.size() - 1) +
                               " conditions in :goal, expected one; several are joined by (and ...)");
    resolver_.begin_frame(false);
    if (!resolver_.condition(section.items[1], problem_.goal)) return false;
    problem_.goal_slots = resolver_.slots();
    return true;
  }

  bool metric(const Node& section) {
    if (section.items.size() != 3 || section.items[1].is_list ||
        (section.items[1].word != "minimize" && section.items[1].word != "maximize"))
      return fail(section,
                  "found " + excerpt(section) + ", expected (:metric minimize VALUE) or (:metric maximize VALUE)");
    Metric metric;
    metric.maximize = section.items[1].word == "maximize";
    resolver_.begin_frame(false);
    if (!resolver_.metric(section.items[2], metric.value)) return false;
    problem_.metric = std::move(metric);
    return true;
  }

  void finish() {
    const auto by_time = [](const auto& a, const auto& b) { return a.time < b.time; };
    std::stable_sort(problem_.timed_facts.begin(), problem_.timed_facts.end(), by_time);
    std::stable_sort(problem_.timed_values.begin(), problem_.timed_values.end(), by_time);
    const FunctionId cost = find(domain_.function_names, "total-cost");
    if (cost >= 0 && domain_.functions[cost].parameters.empty() && !values_.contains({cost, {}}))
      problem_.values.push_back({cost, {}, 0});
  }

  const Node& root_;
  const Deadline& deadline_;
  std::size_t facts_ = 0;
  bool late_ = false;
  const Domain& domain_;
  Problem problem_;
  Resolver resolver_;
  std::set<FactKey> true_;
  std::map<ValueKey, std::size_t> values_;
  std::set<std::string> seen_;
};

}  // namespace

Expected<Problem> parse_problem(std::string_view text, const std::string& file, const Domain& domain,
                                const Deadline& deadline) {
  auto syntax = read_syntax(text, file, deadline);
  if (!syntax) return syntax.error();
  return ProblemParser(syntax->root, file, domain, deadline).parse();
}

}  // namespace cxlab::planner
