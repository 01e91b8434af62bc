// Plans for a problem with every feature: what is read is judged, and means the same when written and read again.

#include "planner/pddl/parser.h"
#include "planner/validator/validator.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_plan_reader {
namespace {

using namespace cxlab::planner;
using cxlab::fuzz::promise;

constexpr const char* kDomain = R"((define (domain d) (:types place)
  (:predicates (at ?p - place) (road ?a ?b - place) (lit) (mark ?p - place) (near ?a ?b - place))
  (:functions (fuel) (used) (way ?a ?b - place))
  (:derived (near ?a ?b - place) (or (road ?a ?b) (exists (?c - place) (and (near ?a ?c) (road ?c ?b)))))
  (:durative-action go :parameters (?a ?b - place) :duration (= ?duration (way ?a ?b))
    :condition (and (at start (at ?a)) (over all (near ?a ?b)) (over all (>= (fuel) 0)))
    :effect (and (at start (not (at ?a))) (at end (at ?b)) (decrease (fuel) (* #t 0.5)) (at end (increase (used) ?duration))))
  (:durative-action look :parameters (?p - place) :duration (and (>= ?duration 1) (<= ?duration 8))
    :condition (and (over all (lit)) (at end (at ?p)))
    :effect (and (forall (?q - place) (when (and (at start (at ?q)) (over all (lit))) (at end (mark ?q)))) (increase (fuel) #t)))
  (:action refuel :parameters () :precondition (forall (?p - place) (imply (at ?p) (mark ?p))) :effect (assign (fuel) 9))))";
constexpr const char* kProblem = R"((define (problem p) (:domain d) (:objects a b c - place)
  (:init (at a) (road a b) (road b c) (= (fuel) 4) (= (used) 0) (= (way a b) 2) (= (way b c) 3) (= (way a c) 5)
    (at 1 (lit)) (at 20 (not (lit))) (at 7 (= (way b c) 4)))
  (:goal (and (at c) (mark a))) (:metric minimize (+ (total-time) (used)))))";

const Task& task() {
  static const Task parsed = [] {
    Domain domain = *parse_domain(kDomain, "d.pddl");
    Problem problem = *parse_problem(kProblem, "p.pddl", domain);
    return Task{std::move(domain), std::move(problem)};
  }();
  return parsed;
}

}  // namespace

FUZZ_TARGET(plan_reader) {
  static const Validator validator(task().domain, task().problem);
  const auto plan = parse_plan(cxlab::fuzz::text_of(data, size), "plan", task().domain, task().problem);
  if (!plan) {
    promise(plan.error().file == "plan" && plan.error().line > 0, "an error of a plan has its file and line");
    return 0;
  }
  const auto verdict = validator.check(*plan);
  promise(verdict || is(verdict.error(), Failure::kUnsupported), "a plan that was read is judged");
  if (!verdict) return 0;
  promise(verdict->valid == !verdict->violation, "a plan is valid or has a violation");
  promise(verdict->valid || !verdict->violation->message.empty(), "a violation says what is wrong");
  const std::string written = to_text(*plan, task().domain, task().problem);
  const auto again = parse_plan(written, "written", task().domain, task().problem);
  promise(again && to_text(*again, task().domain, task().problem) == written,
          "a plan that was written reads back the same:\n" + written);
  return 0;
}

}  // namespace fuzz_plan_reader
