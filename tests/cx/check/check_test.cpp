// Defects that are seeded into an honest rule base are found where they are, and nothing else is found.

#include "cx/check/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <string>

#include "cx/check/graph.h"

namespace cxlab::check {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// An honest agent: everything is asserted, read, set and used.
constexpr const char* kHonest = R"((defglobal ?*LIMIT* = 3)
(deftemplate robot
  (slot name (type SYMBOL))
  (slot state (type SYMBOL) (allowed-values IDLE BUSY BROKEN) (default IDLE)))
(deftemplate job
  (slot id (type INTEGER))
  (slot robot (default none))
  (slot tries (type INTEGER) (default 0)))
(deffacts start (robot (name R1)) (wanted 1))
(deffunction is-last (?tries) (>= ?tries ?*LIMIT*))
(defrule begin
  ?wanted <- (wanted ?id)
  =>
  (retract ?wanted)
  (assert (job (id ?id))))
(defrule give
  ?job <- (job (robot none))
  ?robot <- (robot (name ?name) (state IDLE))
  =>
  (modify ?job (robot ?name))
  (modify ?robot (state BUSY)))
(defrule try-again
  (time ?)
  ?job <- (job (id ?id) (robot ?name&~none) (tries ?tries&:(not (is-last ?tries))))
  (robot (name ?name) (state BUSY))
  (not (done ?id))
  =>
  (modify ?job (tries (+ ?tries 1))))
(defrule fail
  ?job <- (job (id ?id) (robot ?name) (tries ?tries&:(is-last ?tries)))
  ?robot <- (robot (name ?name) (state BUSY))
  =>
  (retract ?job)
  (assert (done ?id))
  (modify ?robot (state BROKEN)))
(defrule repair
  ?robot <- (robot (state BROKEN))
  ?done <- (done ?)
  =>
  (retract ?done)
  (modify ?robot (state IDLE)))
)";

Outside outside() {
  Outside out;
  out.facts = {"time"};
  out.templates = {"ros-msgs-message"};
  return out;
}

std::vector<Finding> found_in(const std::vector<Source>& sources, Outside out = outside()) {
  auto base = RuleBase::read(sources, std::move(out));
  EXPECT_TRUE(base.ok()) << base.error().text();
  return base.ok() ? without_allowed(examine(*base), sources) : std::vector<Finding>();
}

/// The findings in a second file beside an honest agent, as "line code".
std::vector<std::string> seeded(const std::string& rules) {
  std::vector<std::string> out;
  for (const Finding& f : found_in({{"honest.clp", kHonest}, {"seeded.clp", rules}}))
    out.push_back((f.file == "seeded.clp" ? "" : f.file + ' ') + std::to_string(f.line) + ' ' + f.code);
  return out;
}

TEST(Check, FindsNothingInAnHonestAgent) {
  for (const Finding& f : found_in({{"honest.clp", kHonest}})) ADD_FAILURE() << f.text();
}

// --- Each kind of defect, where it was seeded

struct Seed {
  const char* name;
  std::string rules;
  std::string expected;  ///< "line code"
};

class Seeded : public testing::TestWithParam<Seed> {};

TEST_P(Seeded, IsFoundInItsLineAlone) { EXPECT_THAT(seeded(GetParam().rules), ElementsAre(GetParam().expected)); }

INSTANTIATE_TEST_SUITE_P(
    Defects, Seeded,
    testing::Values(
        Seed{"symbol_in_pattern", "(defrule r\n  (robot (state BUSSY))\n  => (printout t a))", "2 unknown-symbol"},
        Seed{"symbol_negated", "(defrule r\n  (job (robot ~nome))\n  => (printout t a))", "2 unknown-symbol"},
        Seed{"symbol_in_test", "(defrule r\n  (robot (state ?s))\n  (test (eq ?s WAITING))\n  => (printout t a))",
             "3 unknown-symbol"},
        Seed{"symbol_in_query",
             "(defrule r (time ?) =>\n  (do-for-fact ((?r robot))\n    (eq ?r:state STUCK)\n    (retract ?r)))",
             "3 unknown-symbol"},
        Seed{"symbol_in_switch",
             "(defrule r (robot (state ?s)) =>\n  (switch ?s (case IDLE then (printout t a))\n  (case IDEL then "
             "(printout "
             "t b))))",
             "3 unknown-symbol"},
        Seed{"symbol_through_a_function",
             "(deffunction is-free (?state)\n  (eq ?state FREE))\n(defrule r (robot (state ?s)) (test (is-free ?s)) => "
             "(printout t a))",
             "2 unknown-symbol"},
        Seed{"ordered_symbol",
             "(defrule a (time ?) => (assert (mode DRIVE)))\n(defrule b (mode DRVE) => (printout t a))",
             "2 unknown-symbol"},
        Seed{"text_in_pattern",
             "(deftemplate door (slot name (type STRING)))\n(deffacts d (door (name \"front\")))\n(defrule r\n  (door "
             "(name "
             "\"back\"))\n  => (printout t a))",
             "4 unknown-symbol"},
        Seed{"symbol_that_is_not_allowed",
             "(deftemplate door (slot is (allowed-values OPEN SHUT)))\n(deffunction state-of (?n)\n  (if (> ?n 1) then "
             "OPEN else\n"
             "   SHTU))\n(deffacts d (door (is SHUT)))\n(defrule r (time ?t) ?d <- (door (is SHUT)) => (modify ?d (is "
             "(state-of "
             "?t))))",
             "4 unknown-symbol"},
        Seed{"symbol_that_comes_from_outside",
             "(defrule a (ros-msgs-message (state CHARGING)) => (printout t a))\n(defrule b (ros-msgs-message (state "
             "CHARGING)) => "
             "(printout t b))\n(defrule c (ros-msgs-message (state CHARGNIG)) => (printout t c))",
             "3 unknown-symbol"},
        Seed{"fact_of_the_executive_misspelt", "(defrule r (tiem ?t) => (printout t ?t))", "1 never-asserted"},
        Seed{"template_never_asserted",
             "(deftemplate door (slot open))\n(defrule r (door (open ?o)) => (printout t ?o))", "1 never-asserted"},
        Seed{"facts_never_asserted", "(defrule r\n  (go-on)\n  => (printout t a))", "2 never-asserted"},
        Seed{"facts_misspelt", "(defrule r\n  (wantde ?x)\n  => (printout t ?x))", "2 never-asserted"},
        Seed{"template_never_read", "(deftemplate note (slot text))\n(defrule r (time ?) => (assert (note (text a))))",
             "1 never-read"},
        Seed{"facts_never_read", "(defrule r (time ?) =>\n  (assert (noted 1)))", "2 never-read"},
        Seed{"template_unused", "(defrule r (time ?) => (printout t a))\n(deftemplate spare (slot x))",
             "2 unused-template"},
        Seed{"slot_never_set",
             "(deftemplate door\n  (slot name)\n  (slot owner))\n(deffacts doors (door (name a)))\n(defrule r (door "
             "(name "
             "?n) (owner ?o)) => (printout t ?n ?o))",
             "3 never-set"},
        Seed{"value_never_set",
             "(deftemplate door\n  (slot state (allowed-values OPEN SHUT\n     AJAR)))\n(deffacts doors (door (state "
             "OPEN)))\n(defrule r ?d <- (door (state OPEN)) => (modify ?d (state SHUT)))",
             "3 never-set"},
        Seed{"value_never_set_beside_a_function_that_modifies",
             "(deftemplate door\n  (slot state (allowed-values OPEN SHUT\n     AJAR)))\n(deffunction put (?door ?s) "
             "(modify ?door "
             "(state ?s)))\n(deffacts doors (door (state OPEN)))\n(defrule r ?d <- (door (state OPEN)) => (put ?d "
             "SHUT))",
             "3 never-set"},
        Seed{"slot_that_a_pattern_misspells",
             "(deftemplate door (slot name))\n(deffacts d (door (name a)))\n(defrule r (door (name ?n)) (not\n  (door "
             "(nmae ?n))) => (printout t ?n))",
             "4 unknown-slot"},
        Seed{"slot_that_an_assert_misspells",
             "(deftemplate door (slot name))\n(deffacts d (door (name a)))\n(defrule r (door (name ?n)) (time ?) =>\n"
             "  (assert (door (nmae ?n))))",
             "4 unknown-slot"},
        Seed{"slot_that_a_fact_at_the_start_misspells",
             "(deftemplate door (slot name))\n(deffacts d (door (name a))\n  (door (nmae b)))\n(defrule r (door (name "
             "?n)) => (printout t ?n))",
             "3 unknown-slot"},
        Seed{"slot_that_a_modify_misspells",
             "(defrule r\n  (time ?)\n  ?r <- (robot (state BROKEN))\n  =>\n  (modify ?r\n    (stat IDLE)))",
             "6 unknown-slot"},
        Seed{"slot_that_a_duplicate_misspells",
             "(defrule r\n  (time ?)\n  ?r <- (robot (state BROKEN))\n  =>\n  (duplicate ?r (stat IDLE)))",
             "5 unknown-slot"},
        Seed{"slot_that_a_query_misspells",
             "(defrule r (time ?) =>\n  (do-for-all-facts ((?r robot))\n    (eq ?r:stat IDLE)\n    (retract ?r)))",
             "3 unknown-slot"},
        Seed{"slot_of_the_second_fact_of_a_query",
             "(defrule r (time ?)\n  (test (any-factp ((?r robot) (?j job))\n    (eq ?r:name ?j:robt))) => (printout t "
             "a))",
             "3 unknown-slot"},
        Seed{"slot_that_a_query_within_a_query_misspells",
             "(defrule r (time ?) =>\n  (do-for-fact ((?x robot)) TRUE\n    (do-for-fact ((?x job)) (eq ?x:id 1) "
             "(printout t ?x:tries))\n    (printout t ?x:tries)))",
             "4 unknown-slot"},
        Seed{"slot_that_none_of_two_templates_has",
             "(defrule r (time ?) =>\n  (do-for-fact ((?x robot job))\n    (eq ?x:state2 2)\n    (printout t ?x:id "
             "?x:name)))",
             "3 unknown-slot"},
        Seed{"slot_that_fact_slot_value_misspells",
             "(defrule r (time ?)\n  ?r <- (robot (state BROKEN)) =>\n  (printout t (fact-slot-value ?r stat)))",
             "3 unknown-slot"},
        Seed{"slot_of_a_fact_that_a_query_has_found",
             "(defrule r (time ?) =>\n  (bind ?all (find-all-facts ((?r robot)) TRUE))\n  (foreach ?one ?all\n    "
             "(printout t (fact-slot-value ?one stat)))\n  (modify (nth$ 1 ?all) (state IDLE)))",
             "4 unknown-slot"},
        Seed{
            "slot_that_a_query_of_a_module_misspells",
            "(defrule r (time ?) =>\n  (do-for-all-facts ((?r MAIN::robot))\n    (eq ?r:stat IDLE)\n    (retract ?r)))",
            "3 unknown-slot"},
        Seed{"slot_of_a_fact_of_a_list_in_a_progn",
             "(defrule r (time ?) =>\n  (bind ?all (find-all-facts ((?r robot)) TRUE))\n  (progn$ (?one ?all)\n    "
             "(printout t (fact-slot-value ?one stat))))",
             "4 unknown-slot"},
        Seed{"slot_of_a_fact_that_a_test_looks_at",
             "(defrule r\n  ?r <- (robot (state BROKEN))\n  (test (fact-existp ?r))\n  (time ?) =>\n  (modify ?r (stat "
             "IDLE)))",
             "5 unknown-slot"},
        Seed{"slot_of_a_fact_of_either_condition",
             "(defrule r (time ?)\n  (or ?r <- (robot (state IDLE))\n      ?r <- (robot (state BROKEN))) =>\n  (modify "
             "?r (stat IDLE)))",
             "4 unknown-slot"},
        Seed{"slot_of_a_fact_that_a_function_asserts",
             "(deffunction make ()\n  (bind ?job (assert (job (id 3))))\n  (bind ?job (modify ?job (tries 2)))\n  "
             "(modify ?job (tires 3)))\n(defrule r (time ?) => (make))",
             "4 unknown-slot"},
        Seed{"slot_of_no_use",
             "(deftemplate door (slot name)\n  (slot weight (default 1)))\n(deffacts d (door (name a)))\n(defrule r "
             "(door (name "
             "?n)) => (printout t ?n))",
             "2 never-set"},
        Seed{"facts_whose_name_is_compared",
             "(defrule r\n  (none ?x)\n  (job (robot ?who))\n  (test (or (eq ?who none) (neq none ?who)))\n  => "
             "(printout t ?x))",
             "2 never-asserted"},
        Seed{"function_whose_name_is_compared",
             "(deffunction none (?x) (* ?x 2))\n(defrule r (job (robot ?who)) (test (or (eq ?who none) (neq none "
             "?who))) => (printout t a))",
             "1 unused-function"},
        Seed{"rule_twice", "(defrule r (time ?) => (printout t a))\n(defrule r (time ?) => (printout t b))",
             "2 defined-twice"},
        Seed{"rule_of_another_file", "\n(defrule begin (wanted ?) => (printout t a))", "2 defined-twice"},
        Seed{"function_twice",
             "(deffunction two () 2)\n(deffunction two () 3)\n(defrule r (time ?) => (printout t (two)))",
             "2 defined-twice"},
        Seed{"deffacts_twice", "(deffacts f (wanted 2))\n(deffacts f (wanted 3))", "2 defined-twice"},
        Seed{"global_twice", "(defglobal ?*A* = 1)\n(defglobal ?*A* = 2)\n(defrule r (time ?) => (printout t ?*A*))",
             "2 defined-twice"},
        Seed{"global_of_another_file",
             "(defglobal ?*LIMIT* = 4)\n(defrule r (time ?t) (test (> ?t ?*LIMIT*)) => (printout t a))",
             "1 defined-twice"},
        Seed{"parameter_of_no_use", "(deffunction f (?a\n ?b) ?a)\n(defrule r (time ?t) => (printout t (f ?t 1)))",
             "2 used-once"},
        Seed{"two_that_should_be_one",
             "(defrule r\n  (job (robot ?robot))\n  (robot (name ?robto))\n  => (printout t a))", "3 used-once"},
        Seed{"variable_once", "(defrule r\n  (robot (name ?name)\n    (state ?state))\n  => (printout t ?name))",
             "3 used-once"},
        Seed{"variable_misspelt",
             "(defrule r\n  (robot (name ?name))\n  (not (job (robot ?nmae)))\n  => (printout t ?name))",
             "3 used-once"},
        Seed{"fact_address_once", "(defrule r\n  ?robot <- (robot (state IDLE))\n  => (printout t a))", "2 used-once"},
        Seed{"bound_in_vain", "(defrule r (time ?t) =>\n  (bind ?x (+ ?t 1))\n  (printout t ?t))", "2 used-once"},
        Seed{"bound_in_vain_in_a_function",
             "(deffunction f (?a)\n  (bind ?b (+ ?a 1))\n  ?a)\n(defrule r (time ?t) => (printout t (f ?t)))",
             "2 used-once"},
        Seed{"counts_for_ever",
             "(deffacts c (count 0))\n(defrule r ?c <- (count ?n) => (retract ?c) (assert (count (+ ?n 1))))",
             "2 loop"},
        Seed{"modifies_for_ever",
             "(deftemplate c (slot n (default 0)))\n(deffacts c (c))\n(defrule r ?c <- (c (n ?n)) => (modify ?c (n (+ "
             "?n "
             "1))))",
             "3 loop"},
        Seed{"asserts_for_ever", "(deffacts c (count 0))\n(defrule r (count ?n) => (assert (count (+ ?n 1))))",
             "2 loop"},
        Seed{"asserts_itself_again", "(deffacts c (go))\n(defrule r ?g <- (go) => (retract ?g) (assert (go)))",
             "2 loop"},
        Seed{"take_turns",
             "(deftemplate lamp (slot is (default OFF)))\n(deffacts l (lamp))\n(defrule on ?l <- (lamp (is OFF)) => "
             "(modify ?l (is ON)))\n(defrule off ?l <- (lamp (is ON)) => (modify ?l (is OFF)))",
             "4 loop"},
        Seed{
            "ping_pong",
            "(deffacts p (ping))\n(defrule a ?p <- (ping) => (retract ?p) (assert (pong)))\n(defrule b ?p <- (pong) => "
            "(retract ?p) (assert (ping)))",
            "3 loop"},
        Seed{"three_take_turns",
             "(deffacts p (one))\n(defrule a ?p <- (one) => (retract ?p) (assert (two)))\n(defrule b ?p <- (two) => "
             "(retract ?p) "
             "(assert (three)))\n(defrule c ?p <- (three) => (retract ?p) (assert (one)))",
             "4 loop"},
        Seed{"count_in_turn",
             "(deffacts c (left 1))\n(defrule a ?c <- (left ?n) => (retract ?c) (assert (right (+ ?n 1))))\n(defrule b "
             "?c <- (right ?n&:(> ?n 0)) => (retract ?c) (assert (left (+ ?n 1))))",
             "3 loop"},
        Seed{"loops_beside_a_call",
             "(deffunction note (?x) (if (> ?x 3) then (assert (noted ?x))))\n(defrule heard (noted ?x) => (printout t "
             "?x))\n(deffacts c (count 0))\n(defrule r ?c <- (count ?n) => (note ?n) (retract ?c) (assert (count (+ ?n "
             "1))))",
             "4 loop"},
        Seed{"grows_above_its_limit",
             "(deffacts c (count 1))\n(defrule r ?c <- (count ?n&:(> ?n 0)) => (retract ?c) (assert (count (+ ?n 1))))",
             "2 loop"},
        Seed{"hen_and_egg", "(defrule r (egg) => (assert (egg)))", "1 unreachable"},
        Seed{"slot_of_two_values", "(defrule r\n  (robot (state IDLE&BUSY))\n  => (printout t a))", "2 unreachable"},
        Seed{"empty_interval", "(defrule r\n  (time ?t&:(> ?t 10))\n  (test (< ?t 5))\n  => (printout t ?t))",
             "3 unreachable"},
        Seed{"excluded", "(defrule r\n  (wanted ?x)\n  (not (wanted ?x))\n  => (printout t ?x))", "3 unreachable"},
        Seed{"excluded_with_all_of_its_kind",
             "(defrule r\n  (robot (name ?n) (state IDLE))\n  (not (robot (name ?n)))\n  => (printout t ?n))",
             "3 unreachable"},
        Seed{"test_false", "(defrule r (time ?t)\n  (test FALSE)\n  => (printout t ?t))", "2 unreachable"},
        Seed{"module_without_focus",
             "(defmodule SIDE (import MAIN ?ALL))\n(defrule SIDE::r (time ?t) => (printout t ?t))", "2 unreachable"},
        Seed{"function_unused", "\n(deffunction double (?x) (* ?x 2))", "2 unused-function"},
        Seed{"function_calls_only_itself", "(deffunction down (?x) (if (> ?x 0) then (down (- ?x 1))))",
             "1 unused-function"},
        Seed{"global_unused",
             "(defglobal\n  ?*SPEED* = 1\n  ?*TURN* = 2)\n(defrule r (time ?) => (printout t ?*SPEED*))",
             "3 unused-global"},
        Seed{
            "fallback_by_salience",
            "(defrule otherwise\n  (declare (salience -10))\n  ?w <- (wanted ?id)\n  => (retract ?w) (printout t ?id))",
            "2 salience"},
        Seed{"first_by_salience", "(defrule first\n  (declare (salience 100))\n  ?w <- (wanted 7)\n  => (retract ?w))",
             "2 salience"},
        Seed{"first_by_salience_and_a_function",
             "(deffunction drop (?w) (retract ?w))\n(defrule first\n  (declare (salience 100))\n  ?w <- (wanted 7)\n  "
             "=> (drop "
             "?w))",
             "3 salience"},
        Seed{"before_all_others",
             "(defrule first (time ?t)\n  => (printout t ?t))\n(defrule boss\n  (declare (salience 9000))\n  (time "
             "?t)\n  => "
             "(printout t ?t))",
             "4 salience"}),
    [](const auto& seed) { return std::string(seed.param.name); });

// --- What looks like a defect and is none

class Sound : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(Sound, GivesNoFinding) { EXPECT_THAT(seeded(GetParam().second), IsEmpty()); }

INSTANTIATE_TEST_SUITE_P(
    Rules, Sound,
    testing::Values(
        std::pair(
            "symbols_from_outside",
            "(deftemplate seen (slot kind))\n(defrule a (ros-msgs-message (msg ?m)) => (assert (seen (kind (sym-cat "
            "(get ?m))))))\n(defrule b (seen (kind LAMP)) => (printout t a))"),
        std::pair("facts_of_texts",
                  "(defrule a (time ?t) => (assert-string (str-cat \"(ticked \" ?t \")\")))\n(defrule b "
                  "(ticked ?t) => (printout t ?t))"),
        std::pair("a_fact_for_the_journal", "(defrule a (time ?t) => (retract (assert (ticked ?t))))"),
        std::pair("a_callback", "(deffunction mute-service-callback (?service ?request ?response) (printout t a))"),
        std::pair(
            "a_declaration",
            "(deffunction odd (?n))\n(deffunction even (?n) (if (= ?n 0) then TRUE else (odd (- ?n 1))))\n(deffunction "
            "odd (?n) (if (= ?n 0) then FALSE else (even (- ?n 1))))\n(defrule a (time ?t) => (printout t (odd ?t)))"),
        std::pair(
            "a_loop_that_ends",
            "(deffacts c (count 0))\n(defrule r ?c <- (count ?n&:(< ?n 9)) => (retract ?c) (assert (count (+ ?n 1))))"),
        std::pair(
            "a_loop_that_another_condition_ends",
            "(deffacts c (count 0) (limit 9))\n(defrule r (limit ?l) ?c <- (count ?n) (test (< ?n ?l)) => (retract ?c) "
            "(assert (count (+ ?n 1))))"),
        std::pair("a_loop_that_a_function_ends",
                  "(deffunction enough (?n) (if (> ?n 3) then (halt)))\n(deffacts c (count 0))\n(defrule r ?c <- "
                  "(count ?n) => "
                  "(enough ?n) (retract ?c) (assert (count (+ ?n 1))))"),
        std::pair(
            "a_loop_that_a_value_of_another_fact_ends",
            "(deftemplate c (slot n (default 0)) (slot is (default ON)))\n(deffacts d (c) (next OFF))\n(defrule r "
            "(next ?x) ?c <- (c (n ?n) (is ~OFF)) => (modify ?c (n (+ ?n 1)) (is ?x)))"),
        std::pair(
            "a_loop_of_facts_that_a_value_of_another_fact_ends",
            "(deffacts d (c 0 ON) (next OFF))\n(defrule r (next ?x) ?c <- (c ?n ~OFF) => (retract ?c) (assert (c (+ "
            "?n 1) ?x)))"),
        std::pair(
            "a_loop_that_shrinks",
            "(deffacts c (count 9))\n(defrule r ?c <- (count ?n&:(> ?n 0)) => (retract ?c) (assert (count (- ?n 1))))"),
        std::pair("a_loop_that_a_value_set_back_ends",
                  "(deffacts c (turn 1 0))\n(defrule a ?c <- (turn 1 ?n) => (retract ?c) (assert (turn 2 (+ ?n "
                  "1))))\n(defrule b ?c <- (turn 2 ?n&:(> ?n 9)) => (retract ?c) (assert (turn 1 0)))"),
        std::pair("a_loop_that_returns_to_a_fact_that_is_there",
                  "(deffacts c (left 0))\n(defrule a (left ?n) => (assert (right (+ ?n 1))))\n(defrule b (right ?n) => "
                  "(assert (left (- ?n 1))))"),
        std::pair(
            "one_of_two_conditions",
            "(defrule r (or (egg) (wanted 7)) => (assert (egg)))\n(defrule s (forall (hen) (wanted 7)) => (assert "
            "(hen)))"),
        std::pair("a_value_that_means_none",
                  "(deftemplate door (slot is (allowed-values GONE SHUT)))\n(deffunction state-of (?n) (if (> ?n 1) "
                  "then NONE else "
                  "SHUT))\n(deffacts d (door (is GONE)))\n(defrule r (time ?t) ?d <- (door (is GONE|SHUT)) (test (neq "
                  "(state-of ?t) "
                  "NONE)) => (bind ?s (state-of ?t)) (if (neq ?s NONE) then (modify ?d (is ?s))))"),
        std::pair(
            "an_allowed_value_near_another",
            "(deftemplate door (slot is (allowed-values LOCKED LOCKER)))\n(deffunction state-of (?n) (if (> ?n 1) "
            "then LOCKER else LOCKED))\n(deffacts d (door (is LOCKED)))\n(defrule r (time ?t) ?d <- (door) "
            "=> (modify ?d (is (state-of ?t))))"),
        std::pair("a_not_of_another_one",
                  "(defrule r (robot (name ?n) (state IDLE)) (not (robot (name ~?n))) => (printout t ?n))"),
        std::pair("a_slot_of_a_fact_that_a_bind_replaces",
                  "(defrule r (time ?) ?f <- (robot (state BROKEN)) => (bind ?f (funcall other)) (modify ?f (size 1)) "
                  "(printout t (fact-slot-value ?f size)))"),
        std::pair("a_slot_of_a_fact_that_a_loop_replaces_later",
                  "(defrule r (time ?) ?f <- (robot (state BROKEN)) => (while (fact-existp ?f) (modify ?f (size 1)) "
                  "(bind ?f (funcall other))))"),
        std::pair("a_slot_of_one_of_several_templates",
                  "(defrule r (time ?) => (do-for-fact ((?f robot job)) (eq ?f:id 1) (printout t ?f:state)))"),
        std::pair("a_slot_of_one_of_two_conditions",
                  "(defrule r (or (and (time 1) ?f <- (robot)) ?f <- (job (id 2))) => (printout t (fact-slot-value ?f "
                  "id)))"),
        std::pair("a_fact_in_a_slot",
                  "(deftemplate offer (slot job) (slot by))\n(defrule r ?j <- (job (id 1)) => (assert (offer (job ?j) "
                  "(by me))))\n(defrule s (offer (job ?x) (by ?y)) => (printout t (fact-slot-value ?x size) ?y))"),
        std::pair("a_fact_in_a_slot_or_of_another_condition",
                  "(deftemplate offer (slot job) (slot by))\n(defrule r ?j <- (job (id 1)) => (assert (offer (job ?j) "
                  "(by me))))\n(defrule s (time ?t) ?f <- (robot (state BROKEN)) (offer (job ?x) (by ?y)) => (if (> ?t "
                  "9) then "
                  "(bind ?x ?f) else (printout t ?y (fact-slot-value ?x tries))))"),
        std::pair(
            "a_fact_in_a_slot_of_a_member",
            "(deftemplate offer (slot job) (slot by))\n(defrule r ?j <- (job (id 1)) => (assert (offer (job ?j) "
            "(by me))))\n(defrule s (time ?) => (do-for-all-facts ((?q offer)) (eq ?q:by me) (modify ?q:job (tries "
            "1)) (printout t (fact-slot-value ?q:job id))))"),
        std::pair(
            "facts_of_several_templates_in_one_list",
            "(defrule r (time ?) => (bind ?pair (find-fact ((?r robot) (?j job)) (eq ?r:name ?j:robot))) (foreach ?f "
            "?pair (if (eq (fact-relation ?f) job) then (printout t (fact-slot-value ?f id)))))"),
        std::pair("a_fact_that_a_function_gets",
                  "(deffunction put (?f) (modify ?f (size 1)))\n(defrule r (time ?) ?f <- (lamp ?) => (put ?f))\n"
                  "(deffacts l (lamp 1))"),
        std::pair("a_member_with_the_name_of_a_fact",
                  "(defrule r (time ?) ?f <- (robot (state BROKEN)) => (do-for-fact ((?f job)) (eq ?f:id 1) (printout "
                  "t ?f:tries)) (modify ?f (state IDLE)))"),
        std::pair("members_of_instances",
                  "(defrule r (time ?) ?f <- (robot (state BROKEN)) => (do-for-all-facts ((?q robot)) TRUE "
                  "(do-for-instance ((?q LAMP)) (eq ?q:size 1) (printout t ?q:size))) (retract ?f))"),
        std::pair("a_member_of_a_template_that_a_variable_names",
                  "(defrule r (time ?t) => (do-for-all-facts ((?q ?t)) (eq ?q:size 1) (printout t ?q:size)))"),
        std::pair("slots_of_templates_of_plugins",
                  "(defrule r ?m <- (ros-msgs-message (topic ?)) => (modify ?m (whatever 1)))"),
        std::pair("texts_from_outside",
                  "(deftemplate seen (slot kind (type STRING)))\n(defrule a (time ?t) => (assert (seen (kind (str-cat "
                  "\"lamp-\" "
                  "?t)))))\n(defrule b (seen (kind \"lamp-1\")) => (printout t a))"),
        std::pair("settings_that_replace", "(defglobal ?*LIMIT* = 4)"),
        std::pair("a_lamp_with_a_switch",
                  "(deftemplate lamp (slot is (default OFF)))\n(deffacts l (lamp))\n(defrule press (time 1) => (assert "
                  "(pressed)))\n(defrule on ?p <- (pressed) ?l <- (lamp (is OFF)) => (retract ?p) (modify ?l (is "
                  "ON)))\n(defrule off ?p <- (pressed) ?l <- (lamp (is ON)) => (retract ?p) (modify ?l (is OFF)))"),
        std::pair("a_counter_of_slots_that_are_not_read",
                  "(deftemplate c (slot n (default 0)))\n(deffacts c (c))\n(defrule r ?c <- (c) => (modify ?c (n "
                  "1)))\n(defrule s (c (n 1)) => (printout t a))"),
        std::pair("salience_of_the_same_facts_that_stay",
                  "(defrule first (declare (salience 10)) (wanted ?id) => (printout t ?id))"),
        std::pair("a_variable_in_a_text", "(defrule r (time ?t) => (printout t (eval \"(+ ?t 1)\")))"),
        std::pair("loop_variables", "(defrule r (time ?) => (loop-for-count (?i 3) (printout t a)))"),
        std::pair("a_module_in_focus",
                  "(defmodule SIDE (import MAIN ?ALL))\n(defrule SIDE::r (time ?t) => (printout t ?t))\n(defrule "
                  "MAIN::f (time "
                  "9) => (focus SIDE))"),
        std::pair(
            "a_value_of_a_global",
            "(defglobal ?*MODE* = SLOW)\n(defrule a (time 5) => (bind ?*MODE* FAST))\n(defrule b (time ?) (test (eq "
            "?*MODE* FAST)) => (printout t a))"),
        std::pair(
            "a_value_of_a_function",
            "(deftemplate door (slot is))\n(deffunction other (?x) (if (eq ?x OPEN) then SHUT else OPEN))\n(deffacts d "
            "(door (is OPEN)))\n(defrule a (time 3) ?d <- (door (is ?x)) => (modify ?d (is (other ?x))))\n(defrule b "
            "(door (is SHUT)) => (printout t a))")),
    [](const auto& rules) { return std::string(rules.param.first); });

// --- Files that are not loaded, libraries, and what plugins know

TEST(Check, OtherFilesOfThePackageShowWhatSomethingIsFor) {
  const std::string tools = "(deffunction double (?x) (* ?x 2))\n(deftemplate spare (slot x))";
  const std::string user = "(defrule u (spare (x ?x)) => (assert (spare (x (double ?x)))))";
  EXPECT_EQ(found_in({{"tools.clp", tools}}).size(), 2U);
  EXPECT_THAT(found_in({{"tools.clp", tools}, {"other.clp", user, false, false}}), IsEmpty());
}

TEST(Check, NothingIsSaidOfLibraries) {
  EXPECT_THAT(found_in({{"library.clp", "(deffunction double (?x) (* ?x 2))", false, true}}), IsEmpty());
  // Who defines again what a library has means to.
  EXPECT_THAT(found_in({{"library.clp", "(deffunction double (?x) (* ?x 2))", false, true},
                        {"mine.clp", "(deffunction double (?x) (+ ?x ?x))"}}),
              IsEmpty());
  EXPECT_THAT(found_in({{"library.clp", "(deftemplate door (slot is))", false, true},
                        {"mine.clp", "(deftemplate door (slot is (allowed-values OPEN SHUT)) (slot owner))"}}),
              IsEmpty());
}

TEST(Check, WhatUnknownPluginsAssertIsOnlyDoubtedWhereAnotherNameIsNear) {
  Outside open = outside();
  open.open = true;
  EXPECT_THAT(found_in({{"a.clp", "(defrule r (reading ?x) => (printout t ?x))"}}, open), IsEmpty());
  EXPECT_EQ(found_in({{"a.clp", "(deffacts f (reading 1))\n(defrule r (readnig ?x) => (printout t ?x))"}}, open).size(),
            1U);
}

TEST(Check, SlotsOfTemplatesOfPluginsAreKnownWhereThePluginIsLoaded) {
  const std::string rules = "(defrule r ?m <- (ros-msgs-message (topic ?)) =>\n (modify ?m (tpoic a)))\n";
  Outside out = outside();
  out.slots["ros-msgs-message"] = {"topic", "msg-ptr"};
  const auto found = found_in({{"a.clp", rules}}, out);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].text(),
            "a.clp:2: [unknown-slot] template 'ros-msgs-message' has no slot 'tpoic', did you mean 'topic'?");
}

TEST(Check, ASlotThatNoneOfSeveralTemplatesHasNamesThemAll) {
  const auto found = found_in(
      {{"honest.clp", kHonest}, {"a.clp", "(defrule r (time ?) => (do-for-fact ((?x robot job)) (eq ?x:stat 2)))\n"}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].text(),
            "a.clp:1: [unknown-slot] templates 'job', 'robot' have no slot 'stat', did you mean 'state'?");
}

TEST(Check, ASlotThatATemplateDoesNotHaveIsTheOnlyThingSaidOfItsValue) {
  EXPECT_THAT(seeded("(defrule a (time ?) => (assert (robot (stat IDLE))))\n"
                     "(defrule b (robot\n  (stat IDEL)) => (printout t a))"),
              ElementsAre("1 unknown-slot", "3 unknown-slot"));
}

TEST(Check, FunctionsThatOnlyCallEachOtherAreNotUsed) {
  EXPECT_THAT(seeded("(deffunction one (?x))\n(deffunction two (?x) (one ?x))\n(deffunction one (?x) (two ?x))"),
              ElementsAre("2 unused-function", "3 unused-function"));
}

TEST(Check, OfManyRulesThatShareAFactEachSalienceIsToldOnce) {
  std::string rules = "(defrule last (declare (salience -5)) ?w <- (wanted ?id) => (retract ?w) (printout t ?id))\n";
  for (const char* n : {"1", "2", "3", "4", "5"})
    rules += std::string("(defrule take") + n + " ?w <- (wanted " + n + ") => (retract ?w))\n";
  EXPECT_THAT(seeded(rules), ElementsAre("1 salience"));
}

TEST(Check, HostileRulesTakeNoLongTime) {
  // Comparing each with each without an end would take minutes.
  std::string rules = "(deftemplate s (slot a) (slot b))\n";
  for (int i = 0; i < 1000; ++i) {
    const std::string n = std::to_string(i), next = std::to_string((i + 1) % 7);
    rules +=
        "(defrule r" + n + " ?f <- (n" + std::to_string(i % 7) + " ?x) => (retract ?f) (assert (n" + next + " ?x)))\n";
    rules += "(defrule s" + n + " (declare (salience " + std::to_string(i % 100) + ")) ?f <- (s (a ?x) (b K" + n +
             ")) (s (a ?x)) => (modify ?f (b K" + next + ")))\n";
    rules += "(deffunction f" + n + " (?x) (f" + std::to_string((i + 1) % 1000) + " ?x))\n";
  }
  const std::clock_t begin = std::clock();
  EXPECT_GT(found_in({{"a.clp", rules}}).size(), 1U);
  EXPECT_LT(std::clock() - begin, 20 * CLOCKS_PER_SEC);
}

TEST(Check, AFactIsFollowedOverManyVariablesInNoLongTime) {
  const auto follow = [](int variables) {
    std::string rule = "(deftemplate s (slot a))\n(deffacts d (s (a 1)))\n(defrule r ?x0 <- (s (a 1)) =>\n";
    for (int i = 0; i < variables; ++i) rule += "(bind ?x" + std::to_string(i + 1) + " ?x" + std::to_string(i) + ")\n";
    for (int i = 0; i <= variables; ++i) rule += "(modify ?x" + std::to_string(i) + " (b 1))\n";
    return std::ranges::count(found_in({{"a.clp", rule + ")\n"}}), "unknown-slot", &Finding::code);
  };
  EXPECT_EQ(follow(20), 21);
  const std::clock_t begin = std::clock();
  EXPECT_LT(follow(10000), 200) << "no finding is about facts that come from far";
  EXPECT_LT(std::clock() - begin, 5 * CLOCKS_PER_SEC);
}

TEST(Check, TheIndexOfALoopAndAnOrderedFactOfATemplatesNameAreNoFindings) {
  EXPECT_THAT(seeded("(defrule r (wanted ?id) => (progn$ (?i (create$ 1 2)) (printout t ?i-index ?id)))"), IsEmpty());
  EXPECT_THAT(seeded("(defrule r (wanted ?id) => (foreach ?i (create$ 1 2) (printout t ?i-index ?id)))"), IsEmpty());
  EXPECT_THAT(seeded("(defrule r (wanted ?id) => (loop-for-count (?i 1 2) (printout t ?i-index ?id)))"),
              ElementsAre("1 used-once"));
  EXPECT_THAT(seeded("(defrule r (robot ?x&:(> ?x 9)) => (printout t ?x))"), Not(Contains(HasSubstr("unknown-slot"))));
}

TEST(Check, ConstructsWithoutTheirPartsAreRead) {
  for (const char* construct :
       {"(deffunction)", "(deffunction f)", "(deffunction f \"doc\")", "(deftemplate)", "(defrule)", "(defrule r)",
        "(defrule r =>)", "(defglobal)", "(deffacts)", "(deffacts d)", "(defmethod)", "(defmethod m)", "(defmodule)",
        "(defclass)", "(defmessage-handler A)"}) {
    SCOPED_TRACE(construct);
    (void)found_in({{"cut.clp", construct}});
    (void)found_in({{"honest.clp", kHonest}, {"cut.clp", construct}});
  }
}

TEST(Check, SaysWhatIsNear) {
  const auto found =
      found_in({{"honest.clp", kHonest}, {"b.clp", "(defrule r (robot (state BUSSY)) => (printout t a))"}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].text(), AllOf(HasSubstr("b.clp:1: [unknown-symbol]"), HasSubstr("did you mean 'BUSY'?")));
}

TEST(Check, AFileThatCannotBeReadIsAnError) {
  const auto base = RuleBase::read({{"a.clp", "(defrule r\n  (a)"}}, {});
  ASSERT_FALSE(base.ok());
  EXPECT_THAT(base.error().text(), HasSubstr("a.clp:1"));
}

// --- Comments that allow

TEST(Check, ACommentAllowsAFindingInItsLineOrTheNext) {
  EXPECT_THAT(seeded("(deffunction a () 1) ; check: allow unused-function for a friend"), IsEmpty());
  EXPECT_THAT(seeded("; check: allow unused-function\n(deffunction a () 1)"), IsEmpty());
  EXPECT_THAT(
      seeded(
          "(defrule r\n  ; check: allow never-asserted\n  ; check: allow used-once\n  (door ?x)\n  => (printout t a))"),
      IsEmpty());
  EXPECT_THAT(seeded("; check: allow unused-function\n\n(deffunction a () 1)"),
              ElementsAre("1 unused-allow", "3 unused-function"));
  EXPECT_THAT(seeded("(deffunction a () 1) ; check: allow unused-global"),
              ElementsAre("1 unused-allow", "1 unused-function"));
  EXPECT_THAT(seeded("(deffacts f (wanted \"; check: allow loop\"))"), IsEmpty());
}

TEST(Check, ACommentThatAllowsAnUnknownCodeSaysWhatIsMeant) {
  const auto found =
      found_in({{"a.clp", "; check: allow used-onec\n(deffacts f (wanted 1)) (defrule r (wanted ?) => )"}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].message, HasSubstr("did you mean 'used-once'?"));
}

// --- The graph

TEST(Check, DrawsWhoProducesAndConsumes) {
  const auto base = RuleBase::read({{"honest.clp", kHonest}}, outside());
  ASSERT_TRUE(base.ok());
  const std::string dot = graph_dot(*base, "honest");
  EXPECT_THAT(dot, HasSubstr("\"begin\" -> \"(job)\""));
  EXPECT_THAT(dot, HasSubstr("\"(job)\" -> \"give\""));
  EXPECT_THAT(dot, HasSubstr("\"(done)\" -> \"try-again\" [tooltip=\"not\", style=dashed]"));
  EXPECT_THAT(graph_svg(*base, "a\xff\x01\xc3\xa4"), HasSubstr(">a\xef\xbf\xbd\xef\xbf\xbd\xc3\xa4<"));
  const std::string svg = graph_svg(*base, "a & b");
  EXPECT_THAT(svg, AllOf(HasSubstr("a &amp; b"), HasSubstr(">deffacts start<"), HasSubstr("</svg>")));
}

}  // namespace
}  // namespace cxlab::check
