"""cxlab.plan, plans and validate. python3 -m unittest test_planning"""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest
from html import escape
from unittest import mock

from cxlab import planning
from cxlab.errors import MachineError, UsageError
from cxlab.planning import PddlError, Plan, plan, plans, validate

PROGRAM = sys.modules["cxlab.program"]  # the module; cxlab.program is its function

DOMAIN = """(define (domain d) (:types place)
  (:predicates (at ?p - place) (road ?a ?b - place) (seen ?p - place))
  (:durative-action go :parameters (?a ?b - place) :duration (= ?duration 5)
    :condition (and (at start (at ?a)) (over all (road ?a ?b)))
    :effect (and (at start (not (at ?a))) (at end (at ?b)) (at end (seen ?b)))))
"""
PROBLEM = "(define (problem p) (:domain d) (:objects a b c - place) (:init (at a) (road a b) (road b c)) (:goal (at c)))\n"


def tour(places):
    """A round trip through places on a line that are visited in a bad order at first: a search for it goes on for long."""
    names = [f"p{i}" for i in range(places)]
    far = " ".join(f"(= (far {a} {b}) {1 + (7 * i + 3 * j) % 11})" for i, a in enumerate(names) for j, b in enumerate(names) if a != b)
    domain = """(define (domain tour) (:types place) (:predicates (at ?p - place) (seen ?p - place)) (:functions (far ?a ?b - place))
      (:durative-action go :parameters (?a ?b - place) :duration (= ?duration (far ?a ?b)) :condition (at start (at ?a))
        :effect (and (at start (not (at ?a))) (at end (at ?b)) (at end (seen ?b)))))"""
    goal = " ".join(f"(seen {name})" for name in names)
    return domain, f"(define (problem p) (:domain tour) (:objects {' '.join(names)} - place) (:init (at p0) {far}) (:goal (and {goal})))"


def children():
    """Processes that this one began, by id."""
    found = set()
    for entry in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == os.getpid() and fields[0] != "Z":
            found.add(int(entry.parent.name))
    return found


class Planning(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.addCleanup(lambda: self.assertEqual(children(), set(), "a program is still at work"))

    def write(self, name, text):
        (self.folder / name).write_text(text)
        return self.folder / name

    def test_texts_and_files_give_the_same_plan(self):
        found = plan(DOMAIN, PROBLEM)
        files = self.write("a domain (1).pddl", DOMAIN), self.write("p.pddl", PROBLEM)
        self.assertEqual(plan(*files), found)
        self.assertEqual(plan(*map(str, files)), found)
        self.assertTrue(found)
        self.assertEqual([(step.action, step.arguments, step.duration) for step in found], [("go", ("a", "b"), 5), ("go", ("b", "c"), 5)])
        self.assertAlmostEqual(found[1].end, found.makespan)
        self.assertGreater(found[1].start, found[0].end)
        self.assertEqual(found.text.splitlines()[0], "0.000000: (go a b) [5.000000]")
        self.assertEqual((found.status, len(found), str(found)), ("plan", 2, found.text))

    def test_a_plan_is_valid_and_a_shorter_one_is_not(self):
        found = plan(DOMAIN, PROBLEM)
        verdict = validate(DOMAIN, PROBLEM, found)
        self.assertTrue(verdict)
        self.assertEqual((verdict.steps, verdict.message, verdict.violation), (2, "", None))
        self.assertAlmostEqual(verdict.makespan, found.makespan)
        verdict = validate(DOMAIN, PROBLEM, self.write("short.plan", str(found[0]) + "\n"))
        self.assertFalse(verdict)
        self.assertEqual(verdict.violation["kind"], "goal")
        self.assertIn("(at c)", verdict.message)
        verdict = validate(DOMAIN, PROBLEM, "0: (go a b) [5]\n5: (go b c) [5]\n")
        self.assertEqual((verdict.violation["step"], verdict.violation["line"]), (1, 2))
        self.assertIn("5.001", verdict.advice)

    def test_the_empty_plan_is_a_plan(self):
        problem = PROBLEM.replace("(:goal (at c))", "(:goal (at a))")
        found = plan(DOMAIN, problem)
        self.assertTrue(found)
        self.assertEqual((len(found), found.text), (0, ""))
        self.assertTrue(validate(DOMAIN, problem, found))

    def test_options_of_the_validator_reach_it(self):
        text = "0: (go a b) [5]\n5.0005: (go b c) [5]\n"
        self.assertFalse(validate(DOMAIN, PROBLEM, text))
        self.assertTrue(validate(DOMAIN, PROBLEM, text, epsilon=0.0001))
        longer = "0: (go a b) [5.01]\n6: (go b c) [5]\n"
        self.assertFalse(validate(DOMAIN, PROBLEM, longer))
        verdict = validate(DOMAIN, PROBLEM, longer, tolerance=0.02, robust=True, robust_limit=0.5)
        self.assertGreater(verdict.robust["holds_s"], 0.4)
        self.assertLessEqual(verdict.robust["holds_s"], 0.5)

    def test_no_plan_is_an_answer_with_its_reason(self):
        found = plan(DOMAIN, PROBLEM.replace("(road b c)", ""))
        self.assertFalse(found)
        self.assertEqual((found.status, len(found), found.makespan), ("unsolvable", 0, None))
        self.assertIn("only go", found.out_of_reach)
        self.assertIn(found.out_of_reach, str(found))
        with self.assertRaisesRegex(UsageError, "no plan to judge: unsolvable"):
            validate(DOMAIN, PROBLEM, found)
        for limit in {"budget": 1}, {"timeout": 1e-9}:
            self.assertEqual(plan(DOMAIN, PROBLEM, **limit).status, "budget")

    def test_a_metric_and_its_bound_are_reported(self):
        problem = PROBLEM.replace("(:goal (at c))", "(:goal (at c)) (:metric minimize (* 2 (total-time)))")
        found = plan(DOMAIN, problem)
        self.assertAlmostEqual(found.metric, 2 * found.makespan, places=5)
        self.assertLessEqual(found.metric_bound, found.metric)
        self.assertEqual(found.optimal, found.metric_bound == found.metric)
        self.assertIsNone(plan(DOMAIN, PROBLEM).metric_bound)
        single = PROBLEM.replace("(:goal (at c))", "(:goal (at b))")
        self.assertTrue(plan(DOMAIN, single, anytime=True, budget=100000).optimal)

    def test_better_plans_come_as_they_are_found(self):
        domain, problem = tour(9)
        found = list(plans(domain, problem, budget=400000))
        self.assertEqual([one.status for one in found], ["found"] * (len(found) - 1) + ["plan"])
        self.assertGreater(len(found), 2)
        makespans = [one.makespan for one in found[:-1]]
        self.assertEqual(makespans, sorted(set(makespans), reverse=True))
        self.assertEqual(found[-1].steps, found[-2].steps)
        self.assertEqual(plan(domain, problem, budget=400000, anytime=True), found[-1])
        self.assertGreater(plan(domain, problem).makespan, found[-1].makespan)
        for one in found:
            self.assertTrue(validate(domain, problem, one))
        patient = plan(domain, problem, budget=400000, anytime=True, patience=1000)
        self.assertLess(patient.units, found[-1].units)

    def test_messages_come_while_the_planner_works(self):
        lines = []
        plan(*tour(6), budget=100000, anytime=True, on_message=lines.append)
        self.assertRegex(lines[0], r"^plan: \d+ steps, makespan [\d.]+ s")

    def test_a_plan_is_drawn(self):
        file = self.folder / "plan.svg"
        plan(DOMAIN, PROBLEM, svg=file)
        self.assertIn("go a b", file.read_text())
        with self.assertRaises(MachineError):
            plan(DOMAIN, PROBLEM, svg="/proc/none/plan.svg")

    def test_closing_the_iterator_ends_the_search(self):
        search = plans(*tour(30), budget=10**12)
        self.assertEqual(next(search).status, "found")
        self.assertEqual(len(children()), 1)
        search.close()
        self.assertEqual(children(), set())

    def test_ctrl_c_ends_the_search(self):
        program = textwrap.dedent("""
            import sys
            from cxlab.planning import plans
            for found in plans(sys.argv[1], sys.argv[2], budget=10**12):
                print(found.status, flush=True)
        """)
        session = subprocess.Popen([sys.executable, "-c", program, *tour(30)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertEqual(session.stdout.readline(), "found\n")
        family = subprocess.run(["pgrep", "-P", str(session.pid)], capture_output=True, text=True).stdout.split()
        self.assertEqual(len(family), 1)
        began = time.monotonic()
        session.send_signal(signal.SIGINT)
        _, errors = session.communicate(timeout=60)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertLess(time.monotonic() - began, 10)
        self.assertFalse(pathlib.Path("/proc", family[0]).exists())

    def test_a_program_that_hangs_is_killed(self):
        program = self.write("hangs", f"#!{sys.executable}\nimport time\ntime.sleep(600)\n")
        program.chmod(0o755)
        with mock.patch.object(PROGRAM, "program", lambda: str(program)), mock.patch.object(planning, "_GRACE_S", 0.2):
            found = plan(DOMAIN, PROBLEM, timeout=0.1)
        self.assertEqual(found.status, "budget")
        self.assertIn("was killed", found.reason)

    def test_a_program_that_ends_before_its_answer_is_an_error(self):
        for body, error in (("import os\nos.abort()", MachineError), ("raise SystemExit(5)", MachineError)):
            program = self.write("ends", f"#!{sys.executable}\n{body}\n")
            program.chmod(0o755)
            with mock.patch.object(PROGRAM, "program", lambda program=program: str(program)), self.assertRaises(error):
                plan(DOMAIN, PROBLEM)
        with mock.patch.object(PROGRAM, "program", lambda: "/no/such/program"), self.assertRaisesRegex(MachineError, "cannot start /no/such/program"):
            plan(DOMAIN, PROBLEM)

    def test_memory_is_limited(self):
        domain = "(define (domain d) (:types t) (:predicates (p ?a ?b - t)) (:action x :parameters (?a ?b - t) :effect (p ?a ?b)))"
        objects = " ".join(f"o{i}" for i in range(900))
        problem = f"(define (problem p) (:domain d) (:objects {objects} - t) (:init) (:goal (forall (?a ?b - t) (p ?a ?b))))"
        self.assertEqual(plan(domain, problem, memory=100 << 20).status, "memory")

    def test_templates_take_data(self):
        problem = PROBLEM.replace("(road b c)", "{% if bridge %}(road b c){% endif %}")
        self.assertTrue(plan(DOMAIN, problem, data={"bridge": True}))
        self.assertFalse(plan(DOMAIN, problem, data={"bridge": False}))
        with self.assertRaisesRegex(PddlError, "not used"):
            plan(DOMAIN, PROBLEM, data={"bridge": True})

    def test_bad_input_is_an_exception_with_its_place(self):
        file = self.write("d.pddl", DOMAIN.replace("(at end (at ?b))", "(at end (as ?b))"))
        with self.assertRaises(PddlError) as caught:
            plan(file, PROBLEM)
        self.assertEqual((caught.exception.file, caught.exception.line, caught.exception.code), (str(file), 5, 31))
        self.assertIn("found", caught.exception.message)
        with self.assertRaises(PddlError) as caught:
            plan(DOMAIN, PROBLEM.replace("(at a)", "(at x)"))
        self.assertEqual((caught.exception.file, caught.exception.line), ("problem", 1))
        with self.assertRaises(PddlError) as caught:
            plan(DOMAIN.replace("(:types", "(:requirements :preferences) (:types"), PROBLEM)
        self.assertEqual(caught.exception.code, 34)
        with self.assertRaises(PddlError) as caught:
            validate(DOMAIN, PROBLEM, "0: (fly a b) [5]\n")
        self.assertEqual((caught.exception.file, caught.exception.line), ("plan", 1))
        with self.assertRaisesRegex(PddlError, "none.pddl"):
            plan("none.pddl", PROBLEM)

    def test_wrong_arguments_are_refused_before_the_program_begins(self):
        with mock.patch.object(PROGRAM, "program", side_effect=AssertionError):
            for wrong in ({"timeout": 0}, {"timeout": "5"}, {"timeout": float("nan")}, {"budget": 0}, {"budget": 1.5}, {"budget": True},
                          {"patience": 5}, {"memory": -1}):
                with self.subTest(wrong), self.assertRaisesRegex(UsageError, next(iter(wrong))):
                    plan(DOMAIN, PROBLEM, **wrong)
            with self.assertRaisesRegex(UsageError, "domain: found int"):
                plan(3, PROBLEM)
            with self.assertRaisesRegex(UsageError, "epsilon"):
                validate(DOMAIN, PROBLEM, "(x)", epsilon=-1)

    def test_a_plan_is_a_sequence(self):
        found = plan(DOMAIN, PROBLEM)
        self.assertEqual(found.index(found[1]), 1)
        self.assertEqual(found[-1:], (found[1],))
        self.assertEqual(Plan("ended", "why", (), 3).orderings, ())

    def test_notebooks_show_its_steps_or_why_there_are_none(self):
        self.assertIn(escape(plan(DOMAIN, PROBLEM).text.splitlines()[0]), plan(DOMAIN, PROBLEM)._repr_html_())
        self.assertIn("ended: a &lt; b", Plan("ended", "a < b", (), 3)._repr_html_())


if __name__ == "__main__":
    unittest.main()
