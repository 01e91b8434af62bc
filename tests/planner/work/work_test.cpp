// The planner's answers to problems of each kind. The file answers.txt has a row for each problem: the verdict, the
// quality of the first and the best plan, and the bound. Behind the bar are the units of work for both. Then come the
// number of plans, each better than the last, and the units at which the best one came. All of it is compared exactly:
// a change of a search, of a bound or of pruning shows here first, also one that only takes longer. The commit that
// changes a row says why. Properties of every answer, whatever the list says, are tested beside it. A run writes the
// rows that it found to the file that the variable CXLAB_WRITE_ANSWERS names.

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>

#include <gtest/gtest.h>

#include "planner/pddl/parser.h"
#include "planner/planner.h"
#include "planner/validator/validator.h"
#include "tests/planner/random/random_problem.h"
#include "tests/support/files.h"

namespace cxlab::planner::work_test {
namespace {

constexpr std::int64_t kBudget = 30'000;
constexpr std::int64_t kTrivial = 15;  ///< units: drawn problems that need no more are left out

constexpr const char* kBegin =
    "(define (domain d) (:requirements :adl :durative-actions :fluents :timed-initial-literals :derived-predicates "
    ":continuous-effects :duration-inequalities)\n";

struct Drawn {
  std::string domain, problem;
};

std::string numbered(const char* name, std::int64_t i) { return name + std::to_string(i); }
std::string atom(std::initializer_list<std::string> words) {
  std::string text = " (";
  for (const std::string& word : words) text += (text.size() > 2 ? " " : "") + word;
  return text + ")";
}
std::string value(const std::string& function, std::int64_t number) {
  return " (= " + function + " " + std::to_string(number) + ")";
}
std::string problem_text(const std::string& objects, const std::string& init, const std::string& goal,
                         const std::string& metric = "") {
  return "(define (problem p) (:domain d) (:objects" + objects + ")\n(:init" + init + ")\n(:goal (and" + goal + "))" +
         metric + ")";
}

/// Trucks with room and fuel carry parcels between places, of which one opens and closes.
Drawn draw_transport(RandomStream& random) {
  constexpr const char* kDomain = R"((:types truck place parcel)
  (:predicates (at ?t - truck ?p - place) (lies ?x - parcel ?p - place) (in ?x - parcel ?t - truck) (open ?p - place))
  (:functions (way ?a ?b - place) (room ?t - truck) (fuel ?t - truck) (spent))
  (:durative-action drive :parameters (?t - truck ?a ?b - place) :duration (= ?duration (way ?a ?b))
   :condition (and (at start (at ?t ?a)) (at start (>= (fuel ?t) (way ?a ?b))))
   :effect (and (at start (not (at ?t ?a))) (at end (at ?t ?b)) (at start (decrease (fuel ?t) (way ?a ?b)))
                (at end (increase (spent) (way ?a ?b)))))
  (:durative-action load :parameters (?x - parcel ?t - truck ?p - place) :duration (= ?duration 2)
   :condition (and (at start (lies ?x ?p)) (at start (>= (room ?t) 1)) (over all (at ?t ?p)) (over all (open ?p)))
   :effect (and (at start (not (lies ?x ?p))) (at start (decrease (room ?t) 1)) (at end (in ?x ?t))))
  (:durative-action unload :parameters (?x - parcel ?t - truck ?p - place) :duration (= ?duration 1)
   :condition (and (at start (in ?x ?t)) (over all (at ?t ?p)))
   :effect (and (at start (not (in ?x ?t))) (at end (lies ?x ?p)) (at end (increase (room ?t) 1))))
  (:durative-action refuel :parameters (?t - truck ?p - place) :duration (= ?duration 5)
   :condition (and (over all (at ?t ?p)) (at start (<= (fuel ?t) 4)) (at start (open ?p)))
   :effect (at end (assign (fuel ?t) 12))))";
  const auto trucks = random.between(1, 2), places = random.between(3, 4), parcels = random.between(2, 3);
  std::string objects, init, goal;
  for (int p = 0; p < places; ++p) {
    objects += " " + numbered("p", p) + " - place";
    for (int q = 0; q < places; ++q)
      if (p != q) init += value("(way " + numbered("p", p) + " " + numbered("p", q) + ")", random.between(1, 6));
    if (p > 0) init += atom({"open", numbered("p", p)});
  }
  init += " (at " + std::to_string(random.between(1, 8)) + " (open p0)) (at " + std::to_string(random.between(20, 40)) +
          " (not (open p0))) (= (spent) 0)";
  for (int t = 0; t < trucks; ++t) {
    const std::string truck = numbered("t", t);
    objects += " " + truck + " - truck";
    init += atom({"at", truck, numbered("p", random.between(0, places - 1))}) +
            value("(room " + truck + ")", random.between(1, 2)) + value("(fuel " + truck + ")", random.between(4, 12));
  }
  for (int x = 0; x < parcels; ++x) {
    objects += " " + numbered("x", x) + " - parcel";
    init += atom({"lies", numbered("x", x), numbered("p", random.between(0, places - 1))});
    goal += atom({"lies", numbered("x", x), numbered("p", random.between(0, places - 1))});
  }
  return {kDomain, problem_text(objects, init, goal,
                                random.chance(0.5) ? "(:metric minimize (+ (total-time) (* 2 (spent))))" : "")};
}

/// Things are baked while a fire burns, and glazed while they are in it.
Drawn draw_kiln(RandomStream& random) {
  constexpr const char* kDomain =
      R"((:predicates (hot) (in ?b) (small ?b) (big ?b) (glazed ?b) (baked ?b) (hand) (wood))
  (:durative-action short-fire :parameters () :duration (= ?duration 8) :condition (at start (wood))
   :effect (and (at start (hot)) (at end (not (hot)))))
  (:durative-action long-fire :parameters () :duration (= ?duration 20) :condition (and (at start (wood)) (at start (not (hot))))
   :effect (and (at start (hot)) (at end (not (hot))) (at start (not (wood)))))
  (:durative-action chop :parameters () :duration (= ?duration 3) :condition (at start (hand))
   :effect (and (at start (not (hand))) (at end (hand)) (at end (wood))))
  (:durative-action bake :parameters (?b) :duration (= ?duration 15) :condition (and (at start (big ?b)) (over all (hot)))
   :effect (and (at start (in ?b)) (at end (not (in ?b))) (at end (baked ?b))))
  (:durative-action toast :parameters (?b) :duration (= ?duration 5) :condition (and (at start (small ?b)) (over all (hot)))
   :effect (and (at start (in ?b)) (at end (not (in ?b))) (at end (baked ?b))))
  (:durative-action glaze :parameters (?b) :duration (= ?duration 2) :condition (and (at start (hand)) (over all (in ?b)))
   :effect (and (at start (not (hand))) (at end (hand)) (at end (glazed ?b)))))";
  const auto things = random.between(2, 5);
  std::string objects, init = " (hand)", goal;
  if (random.chance(0.5)) init += " (wood)";
  for (int i = 0; i < things; ++i) {
    const std::string thing = numbered("b", i);
    objects += " " + thing;
    init += atom({random.chance(0.6) ? "small" : "big", thing});
    goal += atom({"baked", thing});
    if (random.chance(0.7)) goal += atom({"glazed", thing});
  }
  return {kDomain, problem_text(objects, init, goal)};
}

/// The same where everything lasts less than a second.
Drawn draw_quick_kiln(RandomStream& random) {
  Drawn made = draw_kiln(random);
  const std::string duration = "(= ?duration ";
  for (std::size_t at = 0; (at = made.domain.find(duration, at)) != std::string::npos;) {
    made.domain.insert(made.domain.find(')', at), " 20)");
    made.domain.insert(at += duration.size(), "(/ ");
  }
  return made;
}

/// Blocks are stacked; dipping one makes all above it red.
Drawn draw_blocks(RandomStream& random) {
  constexpr const char* kDomain = R"((:predicates (on ?a ?b) (table ?a) (red ?a) (clear ?a) (above ?a ?b) (block ?a))
  (:derived (clear ?a) (not (exists (?b) (on ?b ?a))))
  (:derived (above ?a ?b) (or (on ?a ?b) (exists (?c) (and (on ?a ?c) (above ?c ?b)))))
  (:action lay :parameters (?a ?b) :precondition (and (clear ?a) (on ?a ?b)) :effect (and (not (on ?a ?b)) (table ?a)))
  (:action stack :parameters (?a ?b) :precondition (and (table ?a) (clear ?a) (clear ?b) (not (= ?a ?b)))
   :effect (and (not (table ?a)) (on ?a ?b)))
  (:action dip :parameters (?a) :precondition (and (table ?a) (imply (red ?a) (not (clear ?a))))
   :effect (and (red ?a) (forall (?b) (when (above ?b ?a) (red ?b)))))
  (:action wash :parameters (?a) :precondition (and (clear ?a) (red ?a)) :effect (not (red ?a))))";
  const auto blocks = random.between(3, 4);
  std::string objects, init, goal;
  const auto pile = [&](std::string& into) {
    std::vector<int> order;
    for (int b = 0; b < blocks; ++b) order.push_back(b);
    random.shuffle(order);
    for (std::size_t i = 0; i < order.size(); ++i)
      into += i > 0 && random.chance(0.6) ? atom({"on", numbered("b", order[i]), numbered("b", order[i - 1])})
                                          : atom({"table", numbered("b", order[i])});
  };
  pile(init);
  pile(goal);
  for (int b = 0; b < blocks; ++b) {
    objects += " " + numbered("b", b);
    if (random.chance(0.3)) init += atom({"red", numbered("b", b)});
    if (random.chance(0.6))
      goal += random.chance(0.6) ? atom({"red", numbered("b", b)}) : " (not (red " + numbered("b", b) + "))";
  }
  return {kDomain, problem_text(objects, init, goal)};
}

/// Water is poured between tanks and doubled at a price.
Drawn draw_tanks(RandomStream& random) {
  constexpr const char* kDomain = R"((:types tank) (:predicates (joined ?a ?b - tank) (used ?t - tank))
  (:functions (level ?t - tank) (price))
  (:action pour :parameters (?a ?b - tank) :precondition (and (joined ?a ?b) (>= (level ?a) 1) (<= (level ?b) 6))
   :effect (and (decrease (level ?a) 1) (increase (level ?b) 1) (increase (price) 1)))
  (:action double :parameters (?t - tank) :precondition (and (<= (level ?t) 3) (not (used ?t)))
   :effect (and (assign (level ?t) (* 2 (level ?t))) (used ?t) (increase (price) 4)))
  (:action flush :parameters (?t - tank) :precondition (> (level ?t) 0)
   :effect (and (assign (level ?t) 0) (not (used ?t)) (increase (price) (level ?t)))))";
  const auto tanks = random.between(2, 3);
  std::string objects, init = " (= (price) 0)", goal;
  for (int t = 0; t < tanks; ++t) {
    const std::string tank = numbered("t", t), next = numbered("t", (t + 1) % tanks);
    objects += " " + tank + " - tank";
    init += value("(level " + tank + ")", random.between(0, 4)) + atom({"joined", tank, next});
    const std::string wanted = std::to_string(random.between(0, 6));
    goal += random.chance(0.6)   ? " (= (level " + tank + ") " + wanted + ")"
            : random.chance(0.5) ? " (>= (level " + tank + ") " + wanted + ")"
                                 : " (< (- (level " + tank + ") (level " + next + ")) " + wanted + ")";
  }
  return {kDomain, problem_text(objects, init, goal, random.chance(0.7) ? "(:metric minimize (price))" : "")};
}

/// Robots with batteries that fill while they stand at the dock look at places.
Drawn draw_survey(RandomStream& random) {
  constexpr const char* kDomain = R"((:types robot place) (:constants dock - place)
  (:predicates (at ?r - robot ?p - place) (seen ?p - place) (free) (ready ?r - robot))
  (:functions (way ?a ?b - place) (charge ?r - robot))
  (:durative-action go :parameters (?r - robot ?a ?b - place) :duration (= ?duration (way ?a ?b))
   :condition (and (at start (at ?r ?a)) (at start (ready ?r)) (at start (>= (charge ?r) 4)))
   :effect (and (at start (not (at ?r ?a))) (at end (at ?r ?b)) (at start (decrease (charge ?r) (way ?a ?b)))))
  (:durative-action look :parameters (?r - robot ?p - place) :duration (and (>= ?duration 2) (<= ?duration 5))
   :condition (and (over all (at ?r ?p)) (at start (ready ?r)) (at end (>= (charge ?r) 1)))
   :effect (and (at start (not (ready ?r))) (at end (ready ?r)) (at end (seen ?p)) (at end (decrease (charge ?r) ?duration))))
  (:durative-action fill :parameters (?r - robot) :duration (and (>= ?duration 1) (<= ?duration 8))
   :condition (and (at start (free)) (at start (ready ?r)) (over all (at ?r dock)) (over all (<= (charge ?r) 16)))
   :effect (and (at start (not (free))) (at start (not (ready ?r))) (at end (free)) (at end (ready ?r))
                (increase (charge ?r) (* #t 2)))))";
  const auto robots = random.between(1, 2), places = random.between(1, 3);
  std::string objects, init = " (free)", goal;
  const auto place = [](std::int64_t p) { return p == 0 ? std::string("dock") : numbered("p", p); };
  for (int p = 0; p <= places; ++p) {
    if (p > 0) objects += " " + place(p) + " - place", goal += atom({"seen", place(p)});
    for (int q = 0; q <= places; ++q)
      if (p != q) init += value("(way " + place(p) + " " + place(q) + ")", random.between(1, 4));
  }
  for (int r = 0; r < robots; ++r) {
    const std::string robot = numbered("r", r);
    objects += " " + robot + " - robot";
    init += atom({"at", robot, place(random.between(0, places))}) + atom({"ready", robot}) +
            value("(charge " + robot + ")", random.between(3, 9));
    if (random.chance(0.4)) goal += atom({"at", robot, "dock"});
  }
  return {kDomain, problem_text(objects, init, goal)};
}

template <RandomProblem (*kDraw)(RandomStream&)>
Drawn draw_random(RandomStream& random) {
  const RandomProblem made = kDraw(random);
  return {made.domain(), made.problem()};
}

struct Kind {
  const char* name;
  int count;
  Drawn (*draw)(RandomStream&);
};
constexpr Kind kKinds[]{{"transport", 4, draw_transport},
                        {"kiln", 3, draw_kiln},
                        {"quick kiln", 3, draw_quick_kiln},
                        {"blocks", 3, draw_blocks},
                        {"tanks", 4, draw_tanks},
                        {"survey", 4, draw_survey},
                        {"facts", 20, draw_random<RandomProblem::draw>},
                        {"metric", 20, draw_random<RandomProblem::draw_with_metric>},
                        {"shop", 4, draw_random<RandomProblem::draw_shop>}};

template <class... Values>
std::string line(const char* format, Values... values) {
  char text[512];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// An answer and all plans on the way to it, each better than the last.
struct Found {
  PlanAnswer answer;
  std::vector<TimedPlan> course;
  std::int64_t last_units = 0;  ///< when the last one came
};

Expected<Found> answer_to(const Task& task, PlanOptions options) {
  Found found;
  options.on_plan = [&](const TimedPlan& better, std::int64_t units) {
    found.course.push_back(better);
    found.last_units = units;
  };
  Expected<PlanAnswer> answer = find_plan(task, options);
  if (!answer) return answer.error();
  found.answer = *std::move(answer);
  return found;
}

/// How good a plan is, as in "12.005" or "12.005 metric 26.005"; else why there is none.
std::string quality(const PlanAnswer& answer) {
  if (!answer.plan) return answer.reason;
  std::string text = line("%.3f", answer.plan->makespan_s);
  if (answer.plan->metric) text += line(" metric %.3f", *answer.plan->metric);
  return text;
}

struct Row {
  std::string name, says;
  std::int64_t first_units = 0, best_units = 0, last_units = 0;
  std::size_t plans = 0;

  std::string text() const {
    return name + ": " + says +
           line(" | %lld, %lld; plans %zu, last %lld", static_cast<long long>(first_units),
                static_cast<long long>(best_units), plans, static_cast<long long>(last_units));
  }
};

Row row_of(const std::string& name, const Found& first, const Found& best) {
  Row row{name,
          "first " + quality(first.answer) + "; best " + quality(best.answer),
          first.answer.units,
          best.answer.units,
          best.last_units,
          best.course.size()};
  if (best.answer.plan && best.answer.reason != "a plan") row.says += ", " + best.answer.reason;
  if (best.answer.lower_bound_s > 0) row.says += line("; bound %.3f", best.answer.lower_bound_s);
  if (best.answer.metric_bound) row.says += line(", metric %.3f", *best.answer.metric_bound);
  if (best.answer.refused > 0) row.says += line("; the validator refused %d", best.answer.refused);
  return row;
}

double time_of(const Plan& plan, int point) {
  if (point == Ordering::kOrigin) return 0;
  const PlanStep& step = plan[static_cast<std::size_t>(point / 2)];
  return step.start + (point % 2 ? step.duration : 0);
}

/// Checks the properties of every answer. The validator accepts each plan on the way, a later one is better, none is
/// below the bound, and the times keep to the orderings. The planner calls no plan impossible that another turn finds.
void expect_right(const std::string& name, const Task& task, const Found& found, bool solvable) {
  SCOPED_TRACE(name);
  constexpr double kRounding = 2e-6;
  const Validator validator(task.domain, task.problem);
  if (solvable) {
    EXPECT_NE(found.answer.status, PlanStatus::kUnsolvable);
  }
  for (std::size_t i = 0; i < found.course.size(); ++i) {
    const TimedPlan& plan = found.course[i];
    const Expected<Verdict> verdict = validator.check(plan.steps);
    ASSERT_TRUE(verdict && verdict->valid) << to_text(plan.steps, task.domain, task.problem);
    if (!found.answer.bound_assumes_order) {
      EXPECT_GE(plan.makespan_s, found.answer.lower_bound_s - kRounding);
    }
    if (plan.metric) {
      EXPECT_NEAR(*plan.metric, verdict->metric.value_or(-1e9), 1e-4 * (1 + std::abs(*plan.metric)));
    }
    EXPECT_NEAR(plan.makespan_s, makespan(plan.steps), kRounding);
    for (const Ordering& o : plan.orderings) {
      const double distance = time_of(plan.steps, o.to) - time_of(plan.steps, o.from);
      EXPECT_GE(distance, static_cast<double>(o.least) * 1e-6 - kRounding);
      if (o.most != DurationRange::kForever) {
        EXPECT_LE(distance, static_cast<double>(o.most) * 1e-6 + kRounding);
      }
    }
    for (std::size_t point = 0; point < plan.latest.size(); ++point)
      EXPECT_GE(static_cast<double>(plan.latest[point]) * 1e-6,
                time_of(plan.steps, static_cast<int>(point)) - kRounding);
    if (i == 0) continue;
    const TimedPlan& last = found.course[i - 1];
    if (found.answer.by_metric && plan.metric != last.metric) {
      const double gain = *last.metric - *plan.metric;
      EXPECT_GT(task.problem.metric->maximize ? -gain : gain, 0);
    } else {
      EXPECT_LT(plan.makespan_s, last.makespan_s);
    }
  }
  if (!found.course.empty()) {
    ASSERT_TRUE(found.answer.plan);
    EXPECT_EQ(quality(found.answer),
              line("%.3f", found.course.back().makespan_s) +
                  (found.course.back().metric ? line(" metric %.3f", *found.course.back().metric) : ""));
  }
}

/// All problems with their names: those that are drawn here, and those of problems.pddl.
std::vector<std::pair<std::string, Drawn>> all_problems() {
  std::vector<std::pair<std::string, Drawn>> all;
  for (const Kind& kind : kKinds) {
    RandomStream random(1, kind.name);
    for (int i = 1; i <= kind.count; ++i) all.emplace_back(line("%s %d", kind.name, i), kind.draw(random));
  }
  std::ifstream in(source_dir() / "tests/planner/work/problems.pddl");
  std::string* part = nullptr;
  for (std::string text; std::getline(in, text);) {
    if (text.starts_with("; ")) all.emplace_back("listed" + text.substr(1), Drawn{});
    if (text.starts_with("(define (domain")) part = &all.back().second.domain;
    if (text.starts_with("(define (problem")) part = &all.back().second.problem;
    if (part) *part += text + '\n';
  }
  return all;
}

std::vector<Row> all_rows() {
  std::vector<Row> rows;
  for (const auto& [name, drawn] : all_problems()) {
    const std::string text = drawn.domain.starts_with("(define") ? drawn.domain : kBegin + drawn.domain + ")";
    const Expected<Domain> domain = parse_domain(text, "domain");
    if (!domain) return rows.push_back({name, domain.error().text()}), rows;
    const Expected<Problem> problem = parse_problem(drawn.problem, "problem", *domain);
    if (!problem) return rows.push_back({name, problem.error().text()}), rows;
    const Task task{*domain, *problem};
    const Expected<Found> first = answer_to(task, {.budget = kBudget});
    if (!first) return rows.push_back({name, first.error().message}), rows;
    if (first->answer.units <= kTrivial) continue;
    const Expected<Found> best = answer_to(task, {.budget = kBudget, .anytime = true});
    if (!best) return rows.push_back({name, best.error().message}), rows;
    rows.push_back(row_of(name, *first, *best));
    const bool solvable = first->answer.plan || best->answer.plan;
    expect_right(name + " first", task, *first, solvable);
    expect_right(name + " best", task, *best, solvable);
    if (!solvable) continue;
    EXPECT_EQ(first->answer.plan.has_value(), best->answer.plan.has_value()) << name;
    PlanOptions warm{.budget = kBudget / 4, .anytime = true, .warm_start = best->answer.plan->steps};
    if (!warm.warm_start.empty()) warm.warm_start.erase(warm.warm_start.begin());
    const Expected<Found> again = answer_to(task, warm);
    if (again) expect_right(name + " from most of a plan", task, *again, true);
    EXPECT_TRUE(again && again->answer.plan) << name;
  }
  return rows;
}

TEST(PlannersWork, IsThatOfTheList) {
  const std::vector<Row> found = all_rows();
  if (const char* file = std::getenv("CXLAB_WRITE_ANSWERS")) {
    std::ofstream out(file);
    for (const Row& row : found) out << row.text() << '\n';
  }
  std::ifstream in(source_dir() / "tests/planner/work/answers.txt");
  std::vector<std::string> wanted;
  for (std::string text; std::getline(in, text);) wanted.push_back(text);
  EXPECT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < std::min(found.size(), wanted.size()); ++i) EXPECT_EQ(found[i].text(), wanted[i]);
}

}  // namespace
}  // namespace cxlab::planner::work_test
