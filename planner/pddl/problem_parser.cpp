#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "planner/pddl/parser.h"
#include "planner/pddl/resolver.h"
#include "planner/pddl/text.h"

namespace cxlab::planner {
namespace {

/// Files of one pair often differ in `-` and `_`.
std::string plain_name(std::string name) {
  std::ranges::replace(name, '-', '_');
  return name;
}

/// Validators tell nanoseconds apart.
std::int64_t in_nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

class ProblemParser {
 public:
  ProblemParser(const Node& root, const std::string& file, const Domain& domain, const Deadline& deadline)
      : root_(root),
        deadline_(deadline),
        domain_(domain),
        resolver_(domain, problem_.objects, problem_.object_names, problem_.file, Source::File::kProblem) {
    problem_.file = file;
    problem_.objects = domain.constants;
    for (const Fact& fact : domain.timeless)
      if (true_.emplace(fact.predicate, fact.objects).second) problem_.init.push_back(fact);
    for (std::size_t i = 0; i < problem_.objects.size(); ++i)
      problem_.object_names[problem_.objects[i].name] = static_cast<int>(i);
  }

  Problem parse() {
    problem_.name = resolver_.define(root_, {"problem",
                                             "domain",
                                             {":domain", ":requirements", ":objects", ":init", ":length"},
                                             {":goal", ":metric"},
                                             {":constraints", ":htn", ":situation"},
                                             ":domain, :objects, :init, :goal or :metric"});
    for (const Node& section : sections(root_, ":domain")) domain_name(section);
    for (const Node& section : sections(root_, ":objects")) resolver_.declare_objects(section, "an object");
    for (const Node& section : sections(root_, ":init"))
      for (const Node& node : section.rest()) element(node);
    for (const Node& section : sections(root_, ":goal")) goal(section);
    for (const Node& section : sections(root_, ":metric")) metric(section);
    finish();
    return std::move(problem_);
  }

 private:
  void domain_name(const Node& section) {
    if (section.items.size() != 2 || section.items[1].is_list)
      resolver_.fail(section, found_expected(message(section), "(:domain NAME)"));
    const std::string_view name = section.items[1].word;
    if (plain_name(std::string(name)) != plain_name(domain_.name))
      resolver_.fail(section, found_expected(message("domain '", name, "'"), "'"), domain_.name, "', the name in ",
                     domain_.file);
  }

  void element(const Node& node) {
    if (facts_++ % kReadBetweenLooks == 0 && is_over(deadline_)) throw Rejected{too_late(problem_.file)};
    const std::string_view head = node.head();
    double time = 0;
    if (head == "and") {
      for (const Node& part : node.rest()) element(part);
    } else if (head == "at" && node.items.size() == 3 && node.items[2].is_list && to_number(node.items[1].word, time)) {
      if (time < 0)
        resolver_.fail(node, found_expected(message("time ", node.items[1].word), "a time that is not negative"));
      if (time >= kLatestTime)
        resolver_.fail_unsupported(node, "found time ", node.items[1].word, ": only times below ",
                                   number_text(kLatestTime), " s are supported");
      fact_or_value(node.items[2], time);
    } else {
      fact_or_value(node, {});
    }
  }

  /// `time`: of what happens from outside.
  void fact_or_value(const Node& node, std::optional<double> time) {
    if (node.head() == "=" || (time && node.head() == "assign"))
      value(node, time);
    else if (time &&
             (kind_of<Effect::Kind>(kEffectWords, node.head()) || node.head() == "forall" || node.head() == "when"))
      resolver_.fail_unsupported(node, "found the timed effect (", node.head(),
                                 " ...): only literals and (= (FUNCTION OBJECT...) NUMBER) are supported");
    else
      literal(node, time);
  }

  void literal(const Node& node, std::optional<double> time) {
    const bool negative = node.head() == "not";
    if (negative && node.items.size() != 2)
      resolver_.fail(node, found_expected(message(node), "(not (PREDICATE OBJECT...))"));
    const Node& positive = negative ? node.items[1] : node;
    Fact fact = resolver_.ground_fact(positive);
    if (const Predicate& predicate = domain_.predicates[fact.predicate]; predicate.derived)
      resolver_.fail(
          node,
          found_expected(message("'", predicate.name, "', which is derived by a rule"), "a predicate without one"),
          resolver_.declared(predicate.source));
    if (time) {
      const auto [known, fresh] = timed_facts_.try_emplace({in_nanoseconds(*time), fact.predicate, fact.objects},
                                                           !negative, resolver_.source(node));
      if (known->second.first != !negative)
        resolver_.fail(node, found_expected(message(node, " and its opposite at one time"), "one of them"),
                       resolver_.declared(known->second.second));
      if (fresh) problem_.timed_facts.push_back({*time, std::move(fact), !negative, resolver_.source(node)});
    } else if (negative) {
      if (true_.contains({fact.predicate, fact.objects}))
        resolver_.fail(node, "found ", node, ", but ", positive, " was true before");
    } else if (true_.emplace(fact.predicate, fact.objects).second) {
      problem_.init.push_back(std::move(fact));
    }
  }

  void value(const Node& node, std::optional<double> time) {
    double number = 0;
    if (node.items.size() != 3 || !to_number(node.items[2].word, number))
      resolver_.fail(node, found_expected(message(node), "(= (FUNCTION OBJECT...) NUMBER)"));
    resolver_.expect_exact(node.items[2], number);
    const Fact fluent = resolver_.ground_function(node.items[1]);
    if (time) {
      const auto [known, fresh] =
          timed_values_.try_emplace({in_nanoseconds(*time), fluent.predicate, fluent.objects}, number);
      if (known->second != number)
        resolver_.fail(node, found_expected(message("a second value for ", node.items[1], " at one time"), "one"));
      if (fresh)
        problem_.timed_values.push_back({*time, {fluent.predicate, fluent.objects, number}, resolver_.source(node)});
      return;
    }
    const auto [known, fresh] = values_.emplace(Key{fluent.predicate, fluent.objects}, number);
    if (fresh)
      problem_.values.push_back({fluent.predicate, fluent.objects, number});
    else if (known->second != number)
      resolver_.fail(node, found_expected(message("a second value for ", node.items[1]), "one"));
  }

  void goal(const Node& section) {
    problem_.has_goal = true;
    if (section.items.size() != 2)
      resolver_.fail(section, found_expected(message(section.rest().size(), " conditions in :goal"),
                                             "one; several are joined by (and ...)"));
    resolver_.begin_frame(false);
    problem_.goal = resolver_.condition(section.items[1]);
    problem_.goal_slots = resolver_.slots();
  }

  void metric(const Node& section) {
    const std::string_view word = section.items.size() == 3 ? section.items[1].word : std::string_view();
    if (word != "minimize" && word != "maximize")
      resolver_.fail(section, found_expected(message(section), "(:metric minimize VALUE) or (:metric maximize VALUE)"));
    resolver_.begin_frame(false);
    problem_.metric = Metric{word == "maximize", resolver_.metric(section.items[2])};
  }

  void finish() {
    const auto by_time = [](const auto& a, const auto& b) { return a.time < b.time; };
    std::ranges::stable_sort(problem_.timed_facts, by_time);
    std::ranges::stable_sort(problem_.timed_values, by_time);
    const FunctionId cost = find(domain_.function_names, "total-cost");
    if (cost >= 0 && domain_.functions[cost].parameters.empty() && !values_.contains({cost, {}}))
      problem_.values.push_back({cost, {}, 0});
  }

  const Node& root_;
  const Deadline& deadline_;
  std::size_t facts_ = 0;
  const Domain& domain_;
  Problem problem_;
  Resolver resolver_;
  using Key = std::pair<int, std::vector<ObjectId>>;
  std::set<Key> true_;
  std::map<Key, double> values_;
  using TimedKey = std::tuple<std::int64_t, int, std::vector<ObjectId>>;
  std::map<TimedKey, std::pair<bool, Source>> timed_facts_;
  std::map<TimedKey, double> timed_values_;
};

}  // namespace

Expected<Problem> parse_problem(std::string_view text, const std::string& file, const Domain& domain,
                                const Deadline& deadline) {
  const auto syntax = read_syntax(text, file, deadline);
  if (!syntax) return syntax.error();
  return accepted([&] { return ProblemParser(syntax->root, file, domain, deadline).parse(); });
}

}  // namespace cxlab::planner
