"""The agents of docs/examples/blocksworld, as docs/reference/pddl-manager.md runs them."""

import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

CXLAB = os.environ["CXLAB"]
BLOCKS = Path(os.environ["CXLAB_SOURCE_DIR"]) / "docs/examples/blocksworld"
FRAMEWORK = Path(os.environ["CXLAB_SOURCE_DIR"]) / "tests/planner/engines/fake"  # a Unified Planning Framework of our own

CONFIG = """clips_manager:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "ament_index", "ros_msgs", "plan_temporal", "files"]}
    executive: {plugin: "cx::ExecutivePlugin"}
    ament_index: {plugin: "cx::AmentIndexPlugin"}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    plan_temporal: {plugin: "cx::CXCxPddlInterfacesPlanTemporalPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent", "cx_pddl_clips"], batch: ["clips/cx_pddl_clips/pddl.clp", "all.clp"]}
"""
# Everything that the helper rules answer, asked for at once; a plan that is canceled; at last all facts are printed.
AGENT = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-action-names (instance blocks))
  (pddl-get-predicates (instance blocks))
  (pddl-get-type-objects (instance blocks) (type block))
  (pddl-get-fluents (instance blocks))
  (pddl-get-numeric-fluents (instance blocks))
  (pddl-object-change (instance blocks) (name d) (type block))
  (pddl-fluent-change (instance blocks) (name ontable) (params d))
  (pddl-fluent-change (instance blocks) (name clear) (params b) (delete TRUE))
  (pddl-numeric-fluent-change (instance blocks) (name moves) (value 5.0))
  (pddl-clear-goals (instance blocks) (goal base))
  (pddl-create-goal-instance (instance blocks) (goal g))
  (pddl-planning-filter (instance blocks) (goal g) (type ACTIONS) (filter unstack put-down))
  (pddl-planning-filter (instance blocks) (goal g) (type OBJECTS) (filter a b c))
  (pddl-planning-filter (instance blocks) (goal g) (type FLUENTS) (filter))
  (pddl-goal-fluent (instance blocks) (goal g) (name ontable) (params c))
  (pddl-goal-numeric-fluent (instance blocks) (goal g) (name moves) (value 6.0))
  (pddl-set-goals (instance blocks) (goal g))
  (pddl-plan (instance blocks) (id p) (goal g))
  (number 0) (number 1))
(defrule check (number ?n) => (assert (pddl-action-condition (instance blocks) (action ?n))))
(defrule effects (number ?n&0) => (assert (pddl-action-get-effect (action ?n) (effect-type ALL) (apply FALSE))))
(defrule apply (pddl-action-condition (action ?n&:(eq ?n 1)) (state CONDITION-UNSAT)) (number ?first&0) =>
  (assert (pddl-action-get-effect (action ?first) (effect-type ALL) (apply TRUE))))
(defrule cancel-it (pddl-action-get-effect (apply TRUE) (state DONE)) (not (pddl-fluent-change)) (not (pddl-plan (id q))) => (assert (pddl-plan (instance blocks) (id q) (goal g))))
(defrule ask-again ?g <- (pddl-get-fluents (state DONE)) ?n <- (pddl-get-numeric-fluents (state DONE)) (time ?t&:(> ?t 12.0)) (not (again)) =>
  (assert (again) (pddl-fluent (instance blocks) (name on) (params b b)))
  (modify ?g (state PENDING)) (modify ?n (state PENDING)))
(defrule new-number (declare (salience 1)) (pddl-numeric-fluent (name moves) (value ?v)) => (println "moves are " ?v))
(defrule new-fact (declare (salience 1)) (pddl-fluent (name ontable) (params b)) => (println "b is on the table"))
(defrule cancel-it-2 ?p <- (pddl-plan (id q) (state PLANNING)) => (modify ?p (state REQUEST-CANCELING)))
(defrule look (time ?t&:(> ?t 15.0)) (not (looked)) => (assert (looked)) (facts))
"""
# Requests that are right beside requests that are wrong.
WRONG = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-instance (name other) (domain "nowhere.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-fluent-change (instance blocks) (name holding) (params a))
  (pddl-fluent-change (instance blocks) (name holdink) (params b))
  (change "holding" "c")
  (pddl-numeric-fluent-change (instance blocks) (name moves) (value 3.0))
  (pddl-numeric-fluent-change (instance blocks) (name steps) (value 4.0))
  (pddl-object-change (instance blocks) (name d) (type blok))
  (pddl-set-goals (instance blocks) (goal none))
  (pddl-goal-fluent (instance blocks) (goal none) (name holding) (params a))
  (pddl-planning-filter (instance blocks) (goal base) (type ACTIONS) (filter fly))
  (pddl-plan (instance blocks) (id x) (goal nowhere))
  (pddl-action-names (instance blocks)))
(defrule change (change ?name ?param) => (assert (pddl-fluent-change (instance blocks) (name ?name) (params ?param))))
(defrule look (time ?t&:(> ?t 5.0)) (not (looked)) => (assert (looked)) (facts))
"""
TWO_GOALS = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-create-goal-instance (instance blocks) (goal g1))
  (pddl-create-goal-instance (instance blocks) (goal g2))
  (pddl-goal-fluent (instance blocks) (goal g1) (name ontable) (params c))
  (pddl-goal-fluent (instance blocks) (goal g2) (name holding) (params c))
  (pddl-set-goals (instance blocks) (goal g1))
  (pddl-set-goals (instance blocks) (goal g2))"""
# Two goals are planned for at once; a third plan is canceled before the manager has heard of it, a fourth when it has not
# yet been accepted.
PLANS = TWO_GOALS + """
  (pddl-plan (instance blocks) (id p1) (goal g1))
  (pddl-plan (instance blocks) (id p2) (goal g2)))
(defrule both (pddl-plan (id p1) (state PLANNING)) (pddl-plan (id p2) (state PLANNING)) (time ?t) (not (both)) => (assert (both)) (println "both are planned for"))
(defrule more (pddl-plan (id p1) (state SUCCESS)) (pddl-plan (id p2) (state SUCCESS)) (not (pddl-plan (id p3))) =>
  (assert (pddl-plan (instance blocks) (id p3) (goal g1) (state REQUEST-CANCELING)) (pddl-plan (instance blocks) (id p4) (goal g1))))
(defrule cancel ?p <- (pddl-plan (id p4) (state WAITING)) => (modify ?p (state REQUEST-CANCELING)))
(defrule look (time ?t&:(> ?t 8.0)) (not (looked)) => (assert (looked)) (facts))
"""
# A step is applied by an agent that never asked for numbers.
NUMBERS = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-numeric-fluent-change (instance other) (name moves) (value 1.0))
  (pddl-goal-fluent (instance blocks) (goal base) (name holding) (params c))
  (pddl-set-goals (instance blocks) (goal base))
  (pddl-plan (instance blocks) (id p)))
(defrule apply (pddl-action (id ?n&:(eq ?n 0))) => (assert (pddl-action-get-effect (action ?n) (apply TRUE))))
(defrule look (time ?t&:(> ?t 5.0)) (not (looked)) => (assert (looked)) (facts))
"""
# Templates redefined with only the slots and values of CX, and strict types.
OVERRIDES = """
(deftemplate pddl-instance (slot name (type SYMBOL)) (slot domain (type STRING)) (slot problem (type STRING)) (slot directory (type STRING))
  (slot state (type SYMBOL) (allowed-values PENDING LOADED ERROR)) (slot busy-with (type SYMBOL) (default FALSE)) (slot error (type STRING)))
(deftemplate pddl-fluent-change (slot instance (type SYMBOL)) (slot name (type SYMBOL)) (multislot params (type SYMBOL))
  (slot delete (type SYMBOL) (allowed-values FALSE TRUE)) (slot state (type SYMBOL) (allowed-values PENDING WAITING ERROR)))
(deftemplate pddl-plan (slot instance (type SYMBOL)) (slot id (type SYMBOL)) (slot goal (type SYMBOL)) (slot goal-ptr (type EXTERNAL-ADDRESS)) (slot plan-type)
  (slot goal-handle (type EXTERNAL-ADDRESS)) (slot output-dir (type STRING)) (slot type (type SYMBOL) (allowed-values TEMPORAL))
  (slot state (type SYMBOL) (allowed-values PENDING WAITING PLANNING REQUEST-CANCELING CANCELING CANCELED)) (slot plan-start (type FLOAT)))
(deftemplate pddl-action (slot instance (type SYMBOL)) (slot id (type INTEGER)) (slot name (type SYMBOL)) (multislot params (type STRING)) (slot plan (type SYMBOL))
  (slot planned-start-time (type FLOAT)) (slot planned-duration (type FLOAT)) (slot state (type SYMBOL) (allowed-values IDLE SELECTED EXECUTING DONE)))
(deftemplate pddl-action-condition (slot instance (type SYMBOL)) (slot action (type INTEGER))
  (slot state (type SYMBOL) (allowed-values PENDING CHECK-CONDITION CONDITION-SAT CONDITION-UNSAT)) (multislot unsatisfied-conditions (type STRING)))
(deftemplate pddl-action-get-effect (slot action (type INTEGER)) (slot effect-type (type SYMBOL) (allowed-values ALL START END)) (slot apply (type SYMBOL))
  (slot state (type SYMBOL) (allowed-values PENDING START-EFFECT-APPLIED DONE)))
"""
OVERRIDING = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-get-fluents (instance blocks)) (pddl-get-numeric-fluents (instance blocks))
  (pddl-fluent-change (instance blocks) (name clear) (params b) (delete TRUE))
  (pddl-fluent-change (instance blocks) (name holdink) (params b))
  (pddl-fluent-change (instance blocks) (name ontable) (params c))
  (pddl-goal-fluent (instance blocks) (goal base) (name holding) (params c))
  (pddl-set-goals (instance blocks) (goal base))
  (pddl-plan (instance blocks) (id p) (goal base)))
(defrule check (pddl-action (id ?id)) => (assert (pddl-action-condition (instance blocks) (action ?id))))
(defrule apply (pddl-action-condition (action ?id) (state CONDITION-SAT)) => (assert (pddl-action-get-effect (action ?id) (apply TRUE))))
(defrule look (time ?t&:(> ?t 5.0)) (not (looked)) => (assert (looked)) (facts))
"""
# The agent loses interest while the manager answers.
FORGETFUL = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-get-fluents (instance blocks))
  (pddl-action-names (instance blocks)))
(defrule forget ?ask <- (pddl-get-fluents (state ?s&:(eq ?s WAITING))) => (retract ?ask))
(defrule look (time ?t&:(> ?t 5.0)) (not (looked)) => (assert (looked)) (facts))
"""
# A plan is taken back before it is accepted, another one while it is made; each makes room for the next.
TAKEN_BACK = TWO_GOALS + """
  (pddl-plan (instance blocks) (id p1) (goal g1)))
(defrule take-back-unsent ?p <- (pddl-plan (id p1) (state WAITING)) =>
  (retract ?p) (assert (pddl-plan (instance blocks) (id p2) (goal g2))))
(defrule take-back-planned (pddl-plan (id p2) (state SUCCESS)) (not (p3)) => (assert (p3) (pddl-plan (instance blocks) (id p3) (goal g1))))
(defrule take-back-sent ?p <- (pddl-plan (id p3) (state PLANNING)) =>
  (retract ?p) (assert (pddl-plan (instance blocks) (id p4) (goal g2))))
(defrule look (time ?t&:(> ?t 12.0)) (not (looked)) => (assert (looked)) (facts))
"""
# A question that is refused has the instance loaded again.
LOADS_AGAIN = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER")))
(defrule ask (time ?t&:(> ?t 5.0)) (not (pddl-get-fluents)) => (assert (pddl-get-fluents (instance blocks))))
(defrule load-again ?ask <- (pddl-get-fluents (state ERROR)) ?i <- (pddl-instance (state LOADED)) =>
  (modify ?i (state PENDING) (busy-with FALSE)) (modify ?ask (state PENDING)))
(defrule look (time ?t&:(> ?t 7.0)) (not (looked)) => (assert (looked)) (facts))
"""
# The manager is not active: it answers questions and rejects goals.
REJECTED = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name blocks) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (pddl-plan (instance blocks) (id p)))
(defrule look (time ?t&:(> ?t 5.0)) (not (looked)) => (assert (looked)) (facts))
"""

# As an agent of CX goes through a plan: check, begin with the effects at the start, after the duration those at the end, then the next
# step. In the one domain a step has effects at both; the other is a blocksworld in which to stack takes two seconds.
STEPS_DOMAIN = """(define (domain steps) (:requirements :durative-actions :typing)
  (:types thing) (:predicates (free ?x - thing) (held ?x - thing) (moved ?x - thing))
  (:durative-action move :parameters (?x - thing) :duration (= ?duration 1)
    :condition (at start (free ?x)) :effect (and (at start (not (free ?x))) (at start (held ?x)) (at end (not (held ?x))) (at end (free ?x)) (at end (moved ?x)))))
"""
SLOW_STACK_DOMAIN = """(define (domain steps) (:requirements :durative-actions :typing)
  (:types thing) (:predicates (on ?x ?y - thing) (ontable ?x - thing) (clear ?x - thing) (handempty) (holding ?x - thing))
  (:durative-action pick-up :parameters (?x - thing) :duration (= ?duration 1)
    :condition (and (at start (clear ?x)) (at start (ontable ?x)) (at start (handempty)))
    :effect (and (at end (not (ontable ?x))) (at end (not (clear ?x))) (at end (not (handempty))) (at end (holding ?x))))
  (:durative-action put-down :parameters (?x - thing) :duration (= ?duration 1)
    :condition (at start (holding ?x))
    :effect (and (at end (not (holding ?x))) (at end (clear ?x)) (at end (handempty)) (at end (ontable ?x))))
  (:durative-action stack :parameters (?x ?y - thing) :duration (= ?duration 2)
    :condition (and (at start (holding ?x)) (at start (clear ?y)))
    :effect (and (at end (not (holding ?x))) (at end (not (clear ?y))) (at end (clear ?x)) (at end (handempty)) (at end (on ?x ?y))))
  (:durative-action unstack :parameters (?x ?y - thing) :duration (= ?duration 1)
    :condition (and (at start (on ?x ?y)) (at start (clear ?x)) (at start (handempty)))
    :effect (and (at end (holding ?x)) (at end (clear ?y)) (at end (not (clear ?x))) (at end (not (handempty))) (at end (not (on ?x ?y))))))
"""
STEPS = """(deffacts wanted
  (pddl-manager)
  (pddl-instance (name steps) (domain "domain.pddl") (problem "problem.pddl") (directory "FOLDER"))
  (next 0))
(defrule aim (pddl-instance (state LOADED)) (not (aimed)) => (assert (aimed))
  (assert GOALS)
  (assert (pddl-set-goals (instance steps) (goal base)) (pddl-plan (instance steps) (id p) (goal base))))
(defrule check (pddl-action (id ?id)) (next ?id) (not (began ?id ?)) (not (pddl-action-condition)) (time ?t) =>
  (if (eq ?id 0) then (assert (zero ?t)))
  (assert (pddl-action-condition (instance steps) (action ?id))))
(defrule begin ?check <- (pddl-action-condition (action ?id) (state CONDITION-SAT)) (time ?t) (zero ?zero) =>
  (retract ?check)
  (assert (began ?id ?t) (pddl-action-get-effect (action ?id) (effect-type START) (apply TRUE)))
  (println "step begins " (format nil "%.1f" (- ?t ?zero))))
(defrule end ?began <- (began ?id ?since) (pddl-action (id ?id) (planned-duration ?lasts)) (time ?t&:(>= ?t (+ ?since ?lasts))) ?start <- (pddl-action-get-effect (action ?id) (effect-type START)) =>
  (retract ?start)
  (assert (pddl-action-get-effect (action ?id) (effect-type END) (apply TRUE))))
(defrule next ?end <- (pddl-action-get-effect (effect-type END) (state DONE)) (not (pddl-fluent-change)) ?next <- (next ?id) =>
  (retract ?end ?next)
  (assert (next (+ ?id 1))))
"""
# What the package of the CLIPS-Executive has, in the order in which an agent may load it.
FILES = """saliences deftemplates pddl-ros-comm-init pddl-instance pddl-action-condition pddl-action-get-effect pddl-action-names pddl-clear-goals
pddl-create-goal-instance pddl-fluent-change pddl-numeric-fluent-change pddl-object-change pddl-get-fluents pddl-get-numeric-fluents
pddl-get-predicates pddl-get-type-objects pddl-planning-filter pddl-plan-temporal-client pddl-set-goals""".split()
SLOTS = {
    "pddl-service-request-meta": "service request-id meta",
    "pddl-manager": "node ros-comm-init",
    "pddl-instance": "name domain problem directory state busy-with error",
    "pddl-action": "instance id name params plan planned-start-time planned-duration",
    "pddl-goal-fluent": "instance goal name params",
    "pddl-goal-numeric-fluent": "instance goal name params value",
    "pddl-effect-fluent": "instance action name params effect-type",
    "pddl-effect-numeric-fluent": "instance action name params value effect-type",
    "pddl-fluent": "instance name params",
    "pddl-numeric-fluent": "instance name params value",
    "pddl-predicate": "instance name param-types param-names",
    "pddl-type-objects": "instance type objects",
    "pddl-action-condition": "instance action condition-type state unsatisfied-conditions",
    "pddl-action-get-effect": "action effect-type state apply",
    "pddl-action-names": "instance action-names state error",
    "pddl-clear-goals": "instance goal state error",
    "pddl-create-goal-instance": "instance goal state error",
    "pddl-fluent-change": "instance name params delete request-id state error",
    "pddl-get-fluents": "instance state error",
    "pddl-get-numeric-fluents": "instance state error",
    "pddl-get-predicates": "instance state error",
    "pddl-get-type-objects": "instance type state error",
    "pddl-numeric-fluent-change": "instance name params value request-id state",
    "pddl-object-change": "instance name type delete request-id state error",
    "pddl-plan": "instance id goal goal-ptr plan-type goal-handle output-dir type state",
    "pddl-planning-filter": "id type filter instance goal",
    "pddl-set-goals": "instance goal state error",
}
VALUES = {
    ("pddl-plan", "state"): "PENDING WAITING PLANNING REQUEST-CANCELING CANCELING CANCELED SUCCESS FAILURE",
    ("pddl-fluent-change", "state"): "PENDING WAITING ERROR ON-HOLD",
    ("pddl-numeric-fluent-change", "state"): "PENDING WAITING ERROR ON-HOLD",
    ("pddl-object-change", "state"): "PENDING WAITING ERROR ON-HOLD",
    ("pddl-action-condition", "condition-type"): "ALL START OVERALL END",
    ("pddl-instance", "state"): "PENDING LOADED ERROR",
}
DEFAULTS = {("pddl-manager", "node"): '"/pddl_manager"', ("pddl-action-condition", "condition-type"): "START", ("pddl-plan", "plan-type"): "CLASSICAL",
            ("pddl-plan", "type"): "TEMPORAL", ("pddl-fluent-change", "delete"): "FALSE", ("pddl-action-get-effect", "effect-type"): "ALL"}
PRIORITIES = {"INSTANCES": -5100, "GET-ACTION-NAMES": -5300, "OBJECTS": -5400, "FLUENTS": -5500, "APPLY-EFFECT": -5600, "CLEAR-GOALS": -5700,
              "CREATE-GOAL-INSTANCE": -5800, "SET-ACTION-FILTER": -5900, "SET-FLUENT-FILTER": -6000, "SET-OBJECT-FILTER": -6100, "SET-GOALS": -6200,
              "PLAN": -6300, "CHECK-CONDITION": -6400, "GET-FLUENTS": -6500}


class Blocksworld(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.out = Path(self.folder.name) / "run"

    def cxlab(self, *arguments, expect=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder.name, timeout=60)
        self.assertEqual(done.returncode, expect, f"{arguments}\n{done.stdout}\n{done.stderr}")
        # The example replaces a template of the package on purpose.
        told = [line for line in done.stderr.splitlines() if "overrides.clp:2: deftemplate 'pddl-action' is defined already" not in line]
        self.assertNotRegex("\n".join(told), r"\[(warn|error)\]")
        return done

    def result(self, folder):
        return json.loads((folder / "result.json").read_text())

    def test_the_agent_with_helper_rules_builds_the_tower_and_replays(self):
        done = self.cxlab("run", BLOCKS / "helpers.yaml", "--out", self.out)
        self.assertIn("a is on b, b is on c: 3 moves", done.stderr)
        self.cxlab("replay", self.out, "--rules")
        again = Path(self.folder.name) / "again"
        self.cxlab("run", BLOCKS / "helpers.yaml", "--out", again)
        self.assertEqual(self.result(self.out)["journal_hash"], self.result(again)["journal_hash"])

    def test_the_agent_with_raw_services_builds_the_tower_and_replays(self):
        done = self.cxlab("run", BLOCKS / "raw.yaml", "--out", self.out)
        self.assertIn("the tower stands after 6 steps", done.stderr)
        self.cxlab("replay", self.out, "--rules")

    def test_a_configuration_runs_beside_a_manager(self):
        done = self.cxlab("env", BLOCKS / "params/raw.yaml", "--with", "pddl_manager", "--until", 30, "--out", "none")
        self.assertIn("the tower stands", done.stderr)

    def test_the_agent_plans_again_when_somebody_moves_a_block(self):
        done = self.cxlab("env", BLOCKS / "params/helpers.yaml", "--with", "pddl_manager", "--stimuli", BLOCKS / "somebody.yaml", "--until", 30, "--out", self.out)
        self.assertIn('step 2 cannot begin, plan again: "ontable(b)"', done.stderr)
        self.assertIn("a is on b, b is on c: 3 moves", done.stderr)
        self.assertEqual(self.result(self.out)["replans"], 1)
        self.cxlab("replay", self.out, "--rules")

    def test_stimuli_may_ask_under_both_names_of_the_interfaces(self):
        stimuli = Path(self.folder.name) / "both.yaml"
        stimuli.write_text("".join(f"""
- {{at: 1, call: /pddl_manager/add_pddl_instance, type: {package}/srv/AddPddlInstance, request: {{name: {package}, directory: {BLOCKS}/pddl, domain_file: domain.pddl, problem_file: problem.pddl}}}}
- {{at: 2, send_goal: /pddl_manager/temp_plan, type: {package}/action/PlanTemporal, goal: {{pddl_instance: {package}, goal_instance: base}}}}
""" for package in ("cx_pddl_interfaces", "expertino_msgs")))
        done = self.cxlab("env", BLOCKS / "params/raw.yaml", "--with", "pddl_manager", "--stimuli", stimuli, "--until", 4, "--out", "none")
        self.assertEqual(done.stderr.count("goal succeeded {success: true, actions: []}"), 2)

    def test_planning_takes_the_time_that_the_scenario_says(self):
        slow = self.cxlab("run", BLOCKS / "helpers.yaml", "--set", "planner.latency.a=5", "--out", self.out)
        self.assertRegex(slow.stderr, r"\[ +5\.[45]\d+\] \[info\] \[pddl_manager\] plan for 'tower'")

    def run_with_engine(self, engine, *more, path):
        """The agent with raw services beside a manager that has this engine plan; `path` is where Python finds packages."""
        return subprocess.run([CXLAB, "env", BLOCKS / "params/raw.yaml", "--with", "pddl_manager", "--param", f"pddl_manager.engine={engine}", *more, "--until", "30",
                               "--out", self.out], capture_output=True, text=True, timeout=60, env={**os.environ, "PYTHONPATH": str(path)})

    def test_another_planner_builds_the_tower_and_the_run_says_that_it_is_not_deterministic(self):
        done = self.run_with_engine("aries", path=FRAMEWORK)
        self.assertIn("the tower stands after 6 steps", done.stderr)
        self.assertIs(self.result(self.out)["deterministic"], False)
        own = Path(self.folder.name) / "own"
        self.cxlab("env", BLOCKS / "params/raw.yaml", "--with", "pddl_manager", "--until", 30, "--out", own)
        self.assertIs(self.result(own)["deterministic"], True)
        command = f"{CXLAB} plan {{domain}} {{problem}} --out {{plan}}"
        self.cxlab("env", BLOCKS / "params/raw.yaml", "--with", "pddl_manager", "--param", f"pddl_manager.command={command}", "--until", 30, "--force", "--out", own)
        self.assertIs(self.result(own)["deterministic"], False)

    def test_an_engine_that_is_not_there_is_reported_with_the_command_that_installs_it(self):
        done = self.run_with_engine("lpg", path=FRAMEWORK)
        self.assertRegex(done.stderr, r"ERROR, the planner ended with code 5 and wrote no plan: engine lpg: not installed: \S+ -m pip install up-lpg")
        self.assertIn("there is no plan: ABORTED", done.stderr)
        done = self.run_with_engine("lpg", "--param", "pddl_manager.command=x {plan}", path=FRAMEWORK)
        self.assertEqual(done.returncode, 3)
        self.assertIn("found beside command, expected one of the two", done.stderr)

    def facts_of(self, agent, *arguments, seconds=20, config=CONFIG, overrides=""):
        """Log of a run of an agent with the helper rules."""
        package = Path(self.folder.name) / "agent"
        (package / "params").mkdir(parents=True, exist_ok=True)
        (package / "params/agent.yaml").write_text(config)
        (package / "overrides.clp").write_text(overrides)
        (package / "all.clp").write_text(agent.replace("FOLDER", str(BLOCKS / "pddl")))
        done = subprocess.run([CXLAB, "env", package / "params/agent.yaml", "--package", f"agent={package}", "--until", str(seconds), "--out", "none",
                               *(arguments or ["--with", "pddl_manager"])], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr

    def test_a_wrong_change_does_not_hold_up_the_others(self):
        log = self.facts_of(WRONG, seconds=10)
        for fact in [
            "(pddl-fluent (instance blocks) (name holding) (params a))",
            "(pddl-fluent (instance blocks) (name holding) (params c))",
            '(name holdink) (params b) (delete FALSE) (request-id 3) (state ERROR) (error "unknown fluent \'holdink\', did you mean \'holding\'?"))',
            "(pddl-numeric-fluent (instance blocks) (name moves) (params) (value 3.0))",
            "(name steps) (params) (value 4.0) (request-id 2) (state ERROR))",
            "(pddl-object-change (instance blocks) (name d) (type blok) (delete FALSE) (request-id 1) (state ERROR)",
            "(pddl-set-goals (instance blocks) (goal none) (state ERROR)",
            "(pddl-action-names (instance blocks) (action-names pick-up put-down stack unstack) (state DONE)",
            '(pddl-instance (name other) (domain "nowhere.pddl")',
            "(pddl-plan (instance blocks) (id x) (goal nowhere) (goal-ptr nil) (plan-type CLASSICAL) (goal-handle nil) (output-dir \"\") (type TEMPORAL) (state FAILURE))",
        ]:
            self.assertIn(fact, log)
        self.assertIn("plan not found!", log)
        self.assertRegex(log, r"\[error\] \[main\] pddl-planning-filter: .*'fly'")
        self.assertNotIn("(pddl-planning-filter", log)
        self.assertIn("[error] [main] pddl-fluent-change: unknown fluent 'holdink', did you mean 'holding'?", log)

    def test_plans_are_made_side_by_side_and_canceled_at_any_time(self):
        log = self.facts_of(PLANS, "--with", "pddl_manager", "--param", "pddl_manager.planner={latency: {a: 1}}", seconds=10)
        self.assertIn("both are planned for", log)
        for plan, state in [("p1", "SUCCESS"), ("p2", "SUCCESS"), ("p3", "CANCELED"), ("p4", "CANCELED")]:
            sent = "nil" if plan != "p3" else "<Pointer-C-\\(nil\\)>"
            self.assertRegex(log, rf"\(id {plan}\) .*goal-ptr {sent}.*\(state {state}\)\)")
        self.assertIn('(pddl-action (instance blocks) (id 1) (name put-down) (params "c") (plan p1)', log)
        self.assertIn('(pddl-action (instance blocks) (id 0) (name unstack) (params "c" "a") (plan p2)', log)
        for left in ["goal-response", "wrapped-result", "cancel-goal", "(pddl-asked", "ros-msgs-response", "cleaning up ... goal"]:
            self.assertNotIn(left, log)

    def test_templates_may_be_redefined_with_only_the_slots_of_cx(self):
        batch = 'batch: ["clips/cx_pddl_clips/deftemplates.clp", "overrides.clp", "clips/cx_pddl_clips/pddl-no-deftemplates.clp", "all.clp"]'
        log = self.facts_of(OVERRIDING, seconds=10, config=CONFIG.replace('batch: ["clips/cx_pddl_clips/pddl.clp", "all.clp"]', batch), overrides=OVERRIDES)
        for fact in [
            '(pddl-action-condition (instance blocks) (action 0) (state CONDITION-SAT) (unsatisfied-conditions))',
            "(pddl-action-get-effect (action 0) (effect-type ALL) (apply TRUE) (state DONE))",
            "(pddl-fluent (instance blocks) (name holding) (params c))",
            "(pddl-fluent (instance blocks) (name ontable) (params c))",
            "(pddl-fluent-change (instance blocks) (name holdink) (params b) (delete FALSE) (state ERROR))",
            "(pddl-numeric-fluent (instance blocks) (name moves) (params) (value 1.0))",
        ]:
            self.assertIn(fact, log)
        self.assertNotIn("(name clear) (params b)", log)
        self.assertNotIn("pddl-refused", log)

    def test_files_templates_and_globals_are_those_of_cx(self):
        looks = [f'(println "slots {name} " (implode$ (deftemplate-slot-names {name})))' for name in SLOTS]
        looks += [f'(println "values {name} {slot} " (implode$ (deftemplate-slot-allowed-values {name} {slot})))' for name, slot in VALUES]
        looks += [f'(println "default {name} {slot} " (implode$ (create$ (deftemplate-slot-default-value {name} {slot}))))' for name, slot in DEFAULTS]
        looks += [f'(println "priority {name} " ?*PRIORITY-PDDL-{name}*)' for name in PRIORITIES]
        looks += ['(println "clients " (nth$ 9 ?*CX-PDDL-SERVICE-CLIENTS*) " " (nth$ 10 ?*CX-PDDL-SERVICE-CLIENTS*))']
        one_by_one = CONFIG.replace('batch: ["clips/cx_pddl_clips/pddl.clp", "all.clp"]',
                                    'load: [' + ", ".join(f'"clips/cx_pddl_clips/{name}.clp"' for name in FILES) + '], batch: ["all.clp"]')
        for config in (CONFIG, one_by_one):
            log = self.facts_of("(defrule look => " + " ".join(looks) + ")", seconds=0.1, config=config)
            for kind, table in (("slots", SLOTS), ("values", VALUES), ("default", DEFAULTS), ("priority", PRIORITIES)):
                for key, wanted in table.items():
                    self.assertIn(f"[main] {kind} {key if isinstance(key, str) else ' '.join(key)} {wanted}\n", log)
            self.assertIn("[main] clients get_predictes GetPredicates\n", log)
            answered = self.facts_of(PLANS, seconds=10, config=config)
            self.assertRegex(answered, r"\(id p2\) .*\(state SUCCESS\)\)")

    def test_old_paths_of_the_package_lead_to_the_same_files(self):
        log = self.facts_of(PLANS, seconds=10, config=CONFIG.replace("clips/cx_pddl_clips/", "clips/"))
        self.assertRegex(log, r"\(id p2\) .*\(state SUCCESS\)\)")

    def test_a_step_takes_four_tenths_of_a_second_more_than_its_duration(self):
        tower = "(on b a) (on c b) (ontable a) (clear c) (handempty)"
        for domain, objects, init, goals, begins in [
            (STEPS_DOMAIN, "a b c d e f", [f"(free {x})" for x in "abcdef"], [f"moved) (params {x}" for x in "abcdef"],
             ["0.1", "1.5", "2.9", "4.3", "5.7", "7.1"]),
            (SLOW_STACK_DOMAIN, "a b c", [tower], ["on) (params a b", "on) (params b c"], ["0.1", "1.5", "2.9", "4.3", "6.7", "8.1"]),
        ]:
            folder = Path(tempfile.mkdtemp(dir=self.folder.name))
            (folder / "domain.pddl").write_text(domain)
            (folder / "problem.pddl").write_text(f"(define (problem p) (:domain steps) (:objects {objects} - thing)\n"
                                                 f"  (:init {' '.join(init)}) (:goal (and)))")
            wanted = " ".join(f"(pddl-goal-fluent (instance steps) (goal base) (name {goal}))" for goal in goals)
            log = self.facts_of(STEPS.replace("FOLDER", str(folder)).replace("GOALS", wanted), "--with", "pddl_manager", seconds=12)
            self.assertEqual(re.findall(r"step begins (.*)", log), begins, log)

    def test_a_plan_that_somebody_else_cancels_has_failed(self):
        canceled = PLANS.replace("(defrule cancel ", "(defrule never (nothing) ").replace("(defrule more ", "(defrule none (nothing) ")
        stimuli = Path(self.folder.name) / "deactivate.yaml"
        stimuli.write_text("[{at: 1.2, call: /pddl_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {transition: {label: deactivate}}}]")
        log = self.facts_of(canceled, "--with", "pddl_manager", "--param", "pddl_manager.planner={latency: {a: 5}}", "--stimuli", stimuli, seconds=10)
        for plan in ("p1", "p2"):
            self.assertRegex(log, rf"\(id {plan}\) .*\(state FAILURE\)\)")

    def test_a_question_that_is_taken_back_does_not_block_the_instance(self):
        log = self.facts_of(FORGETFUL, seconds=6)
        self.assertIn("(pddl-action-names (instance blocks) (action-names pick-up put-down stack unstack) (state DONE)", log)
        self.assertIn("(state LOADED) (busy-with FALSE)", log)

    def test_a_plan_that_is_taken_back_gives_its_steps_to_no_other(self):
        log = self.facts_of(TAKEN_BACK, "--with", "pddl_manager", "--param", "pddl_manager.planner={latency: {a: 1}}", seconds=14)
        steps = [line.split("(pddl-action ")[1] for line in log.splitlines() if "(pddl-action " in line]
        self.assertEqual([re.sub(r" \(planned.*", "", step) for step in steps],
                         [f'(instance blocks) (id 0) (name unstack) (params "c" "a") (plan {plan})' for plan in ("p2", "p4")], log)
        for plan in ("p2", "p4"):
            self.assertRegex(log, rf"\(id {plan}\) .*goal-ptr nil.*\(state SUCCESS\)\)")
        for left in ["goal-response", "wrapped-result", "(pddl-plan-goal", "cleaning up ... goal", "[warn]", "[error]"]:
            self.assertNotIn(left, log)

    def test_a_rejected_goal_is_a_plan_that_failed(self):
        stimuli = Path(self.folder.name) / "configure.yaml"
        stimuli.write_text("[{at: 0.1, call: /pddl_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {transition: {label: configure}}}]")
        log = self.facts_of(REJECTED, "--with", "pddl_manager", "--param", "pddl_manager.autostart_node=false", "--stimuli", stimuli, seconds=6)
        self.assertIn("plan was refused!", log)
        self.assertRegex(log, r"\(id p\) .*\(goal-ptr nil\).*\(state FAILURE\)")

    def test_an_effect_on_a_number_that_was_not_asked_for_begins_with_its_value(self):
        problem = Path(self.folder.name) / "pddl"
        problem.mkdir()
        (problem / "domain.pddl").write_text((BLOCKS / "pddl/domain.pddl").read_text())
        (problem / "problem.pddl").write_text((BLOCKS / "pddl/problem.pddl").read_text().replace("(= (moves) 0)", "(= (moves) 41)"))
        log = self.facts_of(NUMBERS.replace("FOLDER", str(problem)), seconds=6)
        self.assertIn("(pddl-numeric-fluent (instance blocks) (name moves) (params) (value 42.0))", log)
        self.assertIn("(pddl-action-get-effect (action 0) (effect-type ALL) (state DONE) (apply TRUE))", log)

    def test_a_manager_that_lost_its_instances_is_reported_and_may_load_them_again(self):
        life = Path(self.folder.name) / "life.yaml"
        life.write_text("\n".join(f"- {{at: {at}, call: /pddl_manager/change_state, type: lifecycle_msgs/srv/ChangeState, request: {{transition: {{label: {label}}}}}}}"
                                  for at, label in [(2, "deactivate"), (2.1, "cleanup"), (3, "configure"), (3.1, "activate")]))
        run = ("--with", "pddl_manager", "--stimuli", life, "--until", "20", "--out", "none")
        done = subprocess.run([CXLAB, "env", BLOCKS / "params/helpers.yaml", *run], capture_output=True, text=True, timeout=60)
        self.assertIn("[error] [builder] pddl-action-get-effect: unknown pddl instance 'blocks': none is loaded, add it with the service add_pddl_instance", done.stderr)
        log = self.facts_of(LOADS_AGAIN, *run[:4], seconds=8)
        self.assertIn("(pddl-get-fluents (instance blocks) (state DONE)", log)
        self.assertIn("(name ontable) (params a)", log)

    def test_each_namespace_may_have_its_manager_and_its_agent(self):
        scenario = Path(self.folder.name) / "two.yaml"
        scenario.write_text("""schema: 1
servers: [{node: pddl_manager, namespace: /cyan}, {node: pddl_manager, namespace: /magenta, planner: {latency: {a: 2}}}]
duration_s: 10
packages: {agent: agent}
agents: [{config: agent/params/agent.yaml, namespace: /cyan}, {config: agent/params/agent.yaml, namespace: /magenta}]
""")
        self.facts_of(PLANS.replace("(pddl-manager)", '(pddl-manager (node "pddl_manager"))'), seconds=0.1)  # writes the agent
        log = self.cxlab("run", scenario, "--out", "none").stderr
        self.assertEqual(log.count("(id p2) (goal g2) (goal-ptr nil) (plan-type CLASSICAL) (goal-handle nil) (output-dir \"\") (type TEMPORAL) (state SUCCESS)"), 2)
        times = [float(line[1:10]) for line in log.splitlines() if "[pddl_manager] plan for 'g2'" in line]
        self.assertAlmostEqual(times[1] - times[0], 2, places=1)  # each has its own planning time

    def test_the_helper_rules_answer_all_that_is_asked(self):
        log = self.facts_of(AGENT, "--with", "pddl_manager", "--param", "pddl_manager.planner={latency: {a: 1}}")
        self.assertNotRegex(log, r"\[(warn|error)\]")
        for fact in [
            "(pddl-action-names (instance blocks) (action-names pick-up put-down stack unstack) (state DONE)",
            "(pddl-predicate (instance blocks) (name on) (param-types block block) (param-names x y))",
            '(pddl-type-objects (instance blocks) (type block) (objects "a" "b" "c"))',  # questions go before changes
            "(pddl-fluent (instance blocks) (name ontable) (params d))",
            "(pddl-set-goals (instance blocks) (goal g) (state DONE)",
            '(pddl-action (instance blocks) (id 0) (name unstack) (params "c" "a") (plan p) (planned-start-time 0.0) (planned-duration 3.0))',
            '(pddl-action-condition (instance blocks) (action 1) (condition-type START) (state CONDITION-UNSAT) (unsatisfied-conditions "holding(c)")',
            "(pddl-effect-fluent (instance blocks) (action 0) (name holding) (params c) (effect-type END))",
            "(pddl-effect-numeric-fluent (instance blocks) (action 0) (name moves) (params) (value 6.0) (effect-type END))",
            "(pddl-fluent (instance blocks) (name holding) (params c))",
            "(pddl-numeric-fluent (instance blocks) (name moves) (params) (value 6.0))",
            "(id q) (goal g) (goal-ptr nil) (plan-type CLASSICAL) (goal-handle nil) (output-dir \"\") (type TEMPORAL) (state CANCELED))",
        ]:
            self.assertIn(fact, log)
        self.assertEqual(log.count("b is on the table"), 1, "facts that stay true are not made anew")
        self.assertEqual([log.count(f"moves are {n}.0") for n in (0, 5, 6)], [1, 1, 1])
        for gone in ["(name on) (params b b)", "(name clear) (params b)", "pddl-planning-filter", "pddl-object-change", "(name on) (params c a)"]:
            self.assertNotIn(gone, log)


if __name__ == "__main__":
    unittest.main()
