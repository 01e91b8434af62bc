#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planner/pddl/parser.h"

namespace cxlab::planner::domain_parser_test {
namespace {

Domain parsed(const std::string& sections) {
  auto domain = parse_domain("(define (domain d)\n" + sections + ")", "d.pddl");
  EXPECT_TRUE(domain) << domain.error().text();
  return domain ? std::move(*domain) : Domain{};
}

/// The error of a domain whose sections begin in line 2.
std::string error_of(const std::string& sections) {
  const auto domain = parse_domain("(define (domain d)\n" + sections + ")", "d.pddl");
  return domain ? "no error" : domain.error().text();
}

constexpr const char* kWorld =
    "(:types robot place - object depot - place)\n"                                             // line 2
    "(:constants base - depot)\n"                                                               // 3
    "(:predicates (at ?r - robot ?p - place) (open ?p - place) (done))\n"                       // 4
    "(:functions (battery ?r - robot) (limit ?r - robot) (way ?a ?b - place) (total-cost))\n";  // 5

std::string with_world(const std::string& sections) { return kWorld + sections; }

TEST(DomainParser, TypesFormATreeWithEither) {
  const Domain domain = parsed("(:types a b - object c - (either a b) d - c)");
  const auto type = [&](const char* name) { return find(domain.type_names, name); };
  EXPECT_TRUE(domain.is_a(type("d"), type("a")));
  EXPECT_TRUE(domain.is_a(type("d"), type("b")));
  EXPECT_TRUE(domain.is_a(type("d"), Domain::kObjectType));
  EXPECT_FALSE(domain.is_a(type("a"), type("c")));
}

TEST(DomainParser, ASupertypeThatIsDeclaredNowhereElseIsAType) {
  const Domain domain = parsed("(:types robot - movable)");
  EXPECT_TRUE(domain.is_a(find(domain.type_names, "robot"), find(domain.type_names, "movable")));
}

TEST(DomainParser, SectionsMayStandInAnyOrder) {
  const Domain domain = parsed(
      "(:action go :parameters (?r - robot) :effect (ready ?r)) (:predicates (ready ?r - robot)) (:types robot)");
  EXPECT_EQ(domain.actions.at(0).effects.size(), 1u);
}

TEST(DomainParser, RejectsAnEitherOfNoType) {
  for (const char* section : {"(:types a b - (either))", "(:types a) (:predicates (p ?x - (either)))",
                              "(:types a) (:constants c - (either))"})
    EXPECT_EQ(error_of(section), "d.pddl:2: found (either), expected a type or (either TYPE...)") << section;
}

TEST(DomainParser, RejectsVariablesAsNames) {
  EXPECT_EQ(error_of("(:types a ?x - b)"), "d.pddl:2: found the variable ?x, expected a type");
  EXPECT_EQ(error_of("(:types a - ?y)"), "d.pddl:2: found the variable ?y, expected a type");
  EXPECT_EQ(error_of("(:types a b - (either a ?y))"), "d.pddl:2: found the variable ?y, expected a type");
  EXPECT_EQ(error_of("(:types a)\n(:constants ?c - a)"), "d.pddl:3: found the variable ?c, expected a constant");
  EXPECT_EQ(error_of("(:predicates (?p))"), "d.pddl:2: found the variable ?p, expected the name of a predicate");
  EXPECT_EQ(error_of("(:functions (?f))"), "d.pddl:2: found the variable ?f, expected the name of a function");
  EXPECT_EQ(error_of("(:action ?go)"), "d.pddl:2: found the variable ?go, expected the name of the action");
  EXPECT_EQ(error_of("(:types a) (:predicates (p ?x - ?y - a))"), "d.pddl:2: found the variable ?y, expected a type");
  const auto problem = parse_problem("(define (problem p) (:domain d)\n(:objects ?o))", "p.pddl", parsed(""));
  EXPECT_EQ(problem.error().text(), "p.pddl:2: found the variable ?o, expected an object");
}

TEST(DomainParser, SuggestsTheRightSpellingOfKeywords) {
  EXPECT_EQ(error_of(with_world("(:action a :effect (decrese (total-cost) 1))")),
            "d.pddl:6: found 'decrese', expected a predicate of the domain; did you mean 'decrease'?");
  EXPECT_EQ(error_of(with_world("(:action a :precondition (foral (?r - robot) (done)))")),
            "d.pddl:6: found 'foral', expected a predicate of the domain; did you mean 'forall'?");
}

TEST(DomainParser, NamesAreLowerCase) {
  const Domain domain = parsed(with_world("(:action GO :parameters (?R - Robot) :effect (AT ?r BASE))"));
  EXPECT_EQ(domain.actions.at(0).name, "go");
  EXPECT_EQ(domain.actions[0].effects.at(0).terms.at(0), Term::variable(0));
  EXPECT_EQ(domain.actions[0].effects[0].terms.at(1), Term::object(0));
}

TEST(DomainParser, ConditionsOfADurativeActionAreSortedByTime) {
  const Domain domain = parsed(
      with_world("(:durative-action go :parameters (?r - robot ?a ?b - place) :duration (= ?duration (way ?a ?b))"
                 " :condition (and (at start (at ?r ?a)) (over all (open ?b)) (at start (>= (battery ?r) ?duration)) "
                 "(at end (not (done)))"
                 "   (forall (?p - place) (over all (imply (at ?r ?p) (open ?p)))))"
                 " :effect (and (at start (not (at ?r ?a))) (at end (at ?r ?b)) (decrease (battery ?r) (* #t 0.5))))"));
  const Action& go = domain.actions.at(0);
  EXPECT_TRUE(go.durative);
  EXPECT_EQ(go.slots, 4);
  ASSERT_EQ(go.condition.start.operands.size(), 2u);
  EXPECT_EQ(go.condition.start.operands[1].sides.at(1).kind, Expression::Kind::kDuration);
  ASSERT_EQ(go.condition.over_all.operands.size(), 2u);
  EXPECT_EQ(go.condition.over_all.operands[1].kind, Condition::Kind::kForall);
  EXPECT_EQ(go.condition.over_all.operands[1].variables.at(0).slot, 3);
  EXPECT_EQ(go.condition.end.kind, Condition::Kind::kNot);
  ASSERT_EQ(go.effects.size(), 3u);
  EXPECT_EQ(go.effects[2].time, Effect::Time::kContinuous);
  EXPECT_EQ(go.effects[2].value.value, 0.5);
  EXPECT_EQ(go.duration.at(0).bound.kind, Expression::Kind::kFunction);
}

TEST(DomainParser, EffectsAreFlattenedWithTheirQuantifiersAndConditions) {
  const Domain domain = parsed(with_world(
      "(:durative-action sweep :parameters (?r - robot) :duration (and (>= ?duration 1) (at end (<= 4 ?duration)))"
      " :effect (and (forall (?p - place) (when (and (at start (at ?r ?p)) (at end (done))) (at end (and (open ?p) "
      "(not (done))))))"
      "   (at start (increase (battery ?r) 2))))"));
  const Action& sweep = domain.actions.at(0);
  ASSERT_EQ(sweep.effects.size(), 3u);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(sweep.effects[i].variables.at(0).slot, 1);
    EXPECT_EQ(sweep.effects[i].condition.start.kind, Condition::Kind::kAtom);
    EXPECT_EQ(sweep.effects[i].condition.end.kind, Condition::Kind::kAtom);
    EXPECT_EQ(sweep.effects[i].time, Effect::Time::kEnd);
  }
  EXPECT_EQ(sweep.effects[1].kind, Effect::Kind::kDelete);
  EXPECT_TRUE(sweep.effects[2].condition.is_true());
  ASSERT_EQ(sweep.duration.size(), 2u);
  EXPECT_TRUE(sweep.duration[1].at_end);
  EXPECT_EQ(sweep.duration[1].comparison, Comparison::kGreaterEqual);
}

TEST(DomainParser, DistinguishesEqualityOfObjectsFromEqualityOfNumbers) {
  const Domain domain =
      parsed(with_world("(:action a :parameters (?r - robot ?p - place) :precondition (and (= ?p base) (= (battery ?r) "
                        "1) (= total-cost 3)))"));
  const auto& parts = domain.actions.at(0).condition.start.operands;
  EXPECT_EQ(parts.at(0).kind, Condition::Kind::kSame);
  EXPECT_EQ(parts.at(1).kind, Condition::Kind::kCompare);
  EXPECT_EQ(parts.at(2).kind, Condition::Kind::kCompare);
}

TEST(DomainParser, RatesMayHoldHashTAnywhereOnce) {
  const auto rate = [](const std::string& value) {
    return parsed(
               with_world("(:durative-action a :parameters (?r - robot) :duration () :effect (increase (battery ?r) " +
                          value + "))"))
        .actions.at(0)
        .effects.at(0)
        .value;
  };
  EXPECT_EQ(rate("#t").value, 1);
  EXPECT_EQ(rate("(* 2 #t)").value, 2);
  EXPECT_EQ(rate("(- (* #t 2))").kind, Expression::Kind::kNegate);
  EXPECT_EQ(rate("(/ #t (limit ?r))").kind, Expression::Kind::kDivide);
  EXPECT_EQ(rate("(+ #t (* 2 (* #t 3)))").operands.at(1).kind, Expression::Kind::kMultiply);
}

TEST(DomainParser, UnsupportedPartsAreNamed) {
  const auto unsupported = [](const std::string& sections) {
    const auto domain = parse_domain("(define (domain d)\n" + with_world(sections) + ")", "d.pddl");
    if (domain) return std::string("no error");
    EXPECT_TRUE(is(domain.error(), Failure::kUnsupported)) << domain.error().text();
    return domain.error().text();
  };
  EXPECT_EQ(unsupported("(:requirements :preferences)"), "d.pddl:6: found requirement :preferences: not supported");
  EXPECT_EQ(unsupported("(:process p)"), "d.pddl:6: found section :process: not supported");
  EXPECT_EQ(unsupported("(:functions (holds ?r - robot) - place)"),
            "d.pddl:6: found a function of type place: object fluents are not supported, only numbers");
  EXPECT_EQ(unsupported(
                "(:durative-action a :parameters (?r - robot) :duration () :effect (increase (battery ?r) (* #t #t)))"),
            "d.pddl:6: found (* #t #t): only linear change is supported, #t must occur once in a product");
}

TEST(DomainParser, ErrorsNameWhereSymbolsWereDeclared) {
  EXPECT_EQ(error_of(with_world("(:action a :parameters (?r - robot)\n :effect (at ?r))")),
            "d.pddl:7: found 1 argument in (at ?r), expected 2; declared at d.pddl:4");
  EXPECT_EQ(error_of(with_world("(:action a :parameters (?r - robot) :effect (at base base))")),
            "d.pddl:6: found base of type depot, expected type robot for argument 1 of at; 'base' is declared at "
            "d.pddl:3; 'at' is declared at d.pddl:4");
  EXPECT_EQ(error_of(with_world("(:action a :parameters (?r - robot) :effect (at ?p base))")),
            "d.pddl:6: found variable ?p, which is not declared here; did you mean '?r'?");
  EXPECT_EQ(error_of(with_world("(:action a :parameters (?r - robot) :effect (opn base))")),
            "d.pddl:6: found 'opn', expected a predicate of the domain; did you mean 'open'?");
  EXPECT_EQ(error_of(with_world("(:action a :precondition (> (batery base) 1))")),
            "d.pddl:6: found 'batery', expected a number or a function of the domain; did you mean 'battery'?");
  EXPECT_EQ(error_of(with_world("(:action a :parameters (?r - robt))")),
            "d.pddl:6: found type 'robt', expected a type of the domain; did you mean 'robot'?");
  EXPECT_THAT(error_of("(:types - robot)"), testing::HasSubstr("d.pddl:2: found '-', expected"));
  EXPECT_EQ(error_of("(:types robot - -)"), "d.pddl:2: found -, expected a type");
  EXPECT_EQ(error_of(with_world("(:action a :precondition (battery base))")),
            "d.pddl:6: found the numeric fluent 'battery', expected a predicate; declared at d.pddl:5");
  EXPECT_EQ(error_of(with_world("(:action a :effect (done))\n(:action a :effect (done))")),
            "d.pddl:7: found action 'a' a second time; declared at d.pddl:6");
  EXPECT_EQ(error_of(with_world("(:durative-action a :parameters () :duration (= ?duration 1)\n :condition (done))")),
            "d.pddl:7: found (done), expected (at start ...), (over all ...) or (at end ...)");
  for (const char* timed : {"(at end (done) (done))", "(at end)", "(over end (done))", "(at all (done))"})
    EXPECT_EQ(error_of(with_world("(:durative-action a :parameters () :duration (= ?duration 1)\n :condition " +
                                  std::string(timed) + ")")),
              "d.pddl:7: found " + std::string(timed) + ", expected (at start ...), (over all ...) or (at end ...)");
  EXPECT_EQ(error_of(with_world("(:action a :parameters () :condition (done))")),
            "d.pddl:6: found :condition, expected :parameters, :precondition or :effect of an action");
  EXPECT_EQ(error_of(with_world("(:durative-action a :parameters ())")),
            "d.pddl:6: the durative action has no :duration, expected (= ?duration NUMBER)");
  EXPECT_EQ(
      error_of(with_world(
          "(:durative-action a :parameters () :duration (= ?duration 1)\n :condition (over all (at end (done))))")),
      "d.pddl:7: found (at end (done)) where the time is already given, expected (PREDICATE ARGUMENT...)");
  EXPECT_EQ(error_of(with_world("(:action a :effect (or (done) (done)))")),
            "d.pddl:6: found (or (done) (done)), expected an effect: it cannot leave open what happens, and numbers "
            "are set by (assign F NUMBER)");
  EXPECT_EQ(error_of("(:types a - b b - c c - a)"),
            "d.pddl:2: type 'a' is its own supertype, expected types without a cycle");
}

TEST(DomainParser, ChangeThatIsNotLinearIsNotSupported) {
  const auto domain = parse_domain(
      "(define (domain d) (:functions (level) (other) (speed))\n"
      "(:durative-action fill :parameters () :duration () :effect (increase (level) (* #t (speed))))\n"
      "(:durative-action wild :parameters () :duration ()\n :effect (decrease (other) (* #t (+ 1 (level))))))",
      "d.pddl");
  ASSERT_FALSE(domain);
  EXPECT_TRUE(is(domain.error(), Failure::kUnsupported));
  EXPECT_EQ(domain.error().text(),
            "d.pddl:4: the rate of other in wild reads level, which changes continuously itself: only linear change is "
            "supported");
}

TEST(DomainParser, NamesNeedNoBlankBeforeADashOrAQuestionMark) {
  const Domain domain = parsed(
      "(:types place -object depot market -place truck)\n(:constants base -depot)\n"
      "(:predicates (at?t -truck ?p -(either depot market)) (= ?x ?y) (near ?p?q -place))\n"
      "(:functions (price ?g -truck) -number)\n"
      "(:action go :parameters (?a?b -place) :precondition (and (near ?a?b) (>= 1 -1)) :effect ())");
  EXPECT_EQ(domain.types.size(), 5u) << "object, place, depot, market, truck";
  const TypeId place = find(domain.type_names, "place"), market = find(domain.type_names, "market");
  EXPECT_TRUE(domain.is_a(market, place));
  EXPECT_EQ(domain.predicates.size(), 2u) << "= is built in";
  EXPECT_EQ(domain.predicates[0].parameters.at(1).types.size(), 2u);
  EXPECT_EQ(domain.predicates[1].parameters.size(), 2u);
  EXPECT_EQ(domain.actions.at(0).parameters.at(1).types.at(0), place);
  EXPECT_EQ(domain.actions[0].condition.start.operands.at(1).sides.at(1).value, -1);
}

TEST(DomainParser, NamesOfVariablesInDeclarationsMeanNothing) {
  const Domain domain = parsed("(:predicates (in ?obj ?obj)) (:functions (way ?a ?a))");
  EXPECT_EQ(domain.predicates.at(0).parameters.size(), 2u);
  EXPECT_EQ(domain.functions.at(0).parameters.size(), 2u);
  EXPECT_EQ(error_of("(:predicates (p)) (:action a :parameters (?x ?x) :effect (p))"),
            "d.pddl:2: found variable ?x twice in one list");
  EXPECT_EQ(error_of("(:predicates (p ?a)) (:action a :precondition (forall (?x ?x) (p ?x)) :effect (p))"),
            "d.pddl:2: found variable ?x twice in one list");
}

TEST(DomainParser, OlderDialectsAreRead) {
  const Domain domain = parsed(
      "(:requirements :strips :domain-axioms :true-negation :multi-agent :unfactored-privacy :strips)\n"
      "(:types driver place) (:constants base - place)\n"
      "(:predicates (on ?a ?b) (above ?a ?b) (free) (:private ?d - driver (licence ?d - driver) (tired ?d - driver)))\n"
      "(:timeless (on base base))\n"
      "(:axiom :vars (?a ?b ?c) :context (and (on ?a ?c) (above ?c ?b)) :implies (above ?a ?b))\n"
      "(:axiom :vars (?b ?a) :context (on ?a ?b) :implies (above ?a ?b))\n"
      "(:action drive :agent ?d - driver :parameters (?p - place) :vars (?q - place)\n"
      "  :precondition (and (licence ?d) (on ?p ?q)) :effect (not (free)))");
  ASSERT_EQ(domain.actions.at(0).parameters.size(), 3u);
  EXPECT_EQ(domain.actions[0].parameters[0].name, "?d");
  EXPECT_EQ(domain.actions[0].parameters[2].name, "?q");
  EXPECT_EQ(domain.predicates.size(), 5u);
  EXPECT_EQ(domain.timeless.size(), 1u);
  ASSERT_EQ(domain.derivations.size(), 2u);
  EXPECT_EQ(domain.derivations[0].parameters.size(), 2u);
  EXPECT_EQ(domain.derivations[0].condition.kind, Condition::Kind::kExists);
  EXPECT_EQ(domain.derivations[1].parameters[0].name, "?a") << "in the order of the head";
  EXPECT_EQ(domain.derivations[1].condition.terms[0].index, 0);
}

TEST(DomainParser, WholeNumbersThatADoubleDoesNotHoldAreRefused) {
  const auto number = [](const std::string& text) {
    return error_of("(:predicates (p)) (:functions (x)) (:action a :precondition (> (x) " + text + ") :effect (p))");
  };
  for (const char* exact : {"9007199254740991", "9007199254740992", "-9007199254740992", "18014398509481984", ".5",
                            "+3", "5.", "1e3", "1E3", "-.25", "007", "0", "12345678901234567.5"})
    EXPECT_EQ(number(exact), "no error") << exact;
  EXPECT_EQ(number("9007199254740993"),
            "d.pddl:2: found the number 9007199254740993: whole numbers beyond 9007199254740992 are read as "
            "9007199254740992, which is another one");
}

TEST(DomainParser, RejectsAProblemInPlaceOfADomain) {
  EXPECT_EQ(parse_domain("(define (problem p))", "p.pddl").error().text(),
            "p.pddl:1: found a problem, expected a domain: (define (domain NAME) ...); are the files swapped?");
}

TEST(DomainParser, DerivedPredicatesAreStratified) {
  const Domain domain = parsed(
      with_world("(:predicates (reach ?a ?b - place) (alone ?a - place) (road ?a ?b - place))"
                 "(:derived (alone ?a - place) (not (exists (?b - place) (reach ?a ?b))))"
                 "(:derived (reach ?a ?b) (or (road ?a ?b) (exists (?c - place) (and (reach ?a ?c) (road ?c ?b)))))"));
  EXPECT_EQ(domain.predicates[find(domain.predicate_names, "reach")].stratum, 0);
  EXPECT_EQ(domain.predicates[find(domain.predicate_names, "alone")].stratum, 1);
  EXPECT_EQ(domain.derivations.at(1).slots, 3);
  EXPECT_EQ(domain.derivations[1].parameters.at(0).types.at(0), find(domain.type_names, "place"))
      << "taken from the predicate";
  EXPECT_EQ(error_of(with_world("(:derived (done) (not (done)))")),
            "d.pddl:6: derived predicate 'done' depends on its own negation, expected rules without such a cycle; "
            "declared at d.pddl:4");
  EXPECT_EQ(error_of(with_world("(:derived (done) (and))\n(:action a :effect (done))")),
            "d.pddl:7: found an effect on 'done', which is derived by a rule, expected a predicate without one; "
            "declared at d.pddl:4");
}

}  // namespace
}  // namespace cxlab::planner::domain_parser_test
