"""cxlab validate: answers, exit codes and JSON. python3 -m unittest validate"""

import json
import os
import subprocess

from lab import CXLAB, SOURCE, Lab

DOMAIN = """(define (domain d) (:types place)
  (:predicates (at ?p - place) (road ?a ?b - place))
  (:durative-action go :parameters (?a ?b - place) :duration (= ?duration 5)
    :condition (and (at start (at ?a)) (over all (road ?a ?b)))
    :effect (and (at start (not (at ?a))) (at end (at ?b)))))
"""
PROBLEM = "(define (problem p) (:domain d) (:objects a b c - place) (:init (at a) (road a b) (road b c)) (:goal (at c)))\n"


class Validate(Lab):
    def validate(self, plan, *arguments, domain=DOMAIN, problem=PROBLEM):
        files = [self.write("d.pddl", domain), self.write("p.pddl", problem), self.write("plan", plan)]
        return subprocess.run([CXLAB, "validate", *map(str, files), *arguments], capture_output=True, text=True, cwd=self.folder)

    def test_right_plan(self):
        done = self.validate("0: (go a b) [5]\n5.001: (go b c) [5]\n")
        self.assertEqual((done.returncode, done.stdout), (0, "valid: 2 steps, makespan 10.001 s\n"))

    def test_wrong_plan_names_the_first_violation(self):
        done = self.validate("0: (go a b) [5]\n")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout.splitlines()[0],
                         "invalid: the goal does not hold at the end of the plan (5.000): (at c); (at c) has been false from the beginning")
        answer = json.loads(self.validate("0: (go b c) [5]\n", "--json").stdout)
        self.assertFalse(answer["valid"])
        violation = answer["violation"]
        self.assertEqual((violation["kind"], violation["time"], violation["line"], violation["when"]), ("condition", 0, 1, "at start"))
        self.assertEqual((violation["action"], violation["condition"]), ("(go b c)", "(at b)"))

    def test_epsilon_is_an_option(self):
        plan = "0: (go a b) [5]\n5.0005: (go b c) [5]\n"
        self.assertEqual(self.validate(plan).returncode, 1)
        self.assertEqual(self.validate(plan, "--epsilon", "0.0001").returncode, 0)

    def test_robust_reports_the_slack(self):
        done = self.validate("0: (go a b) [5]\n7: (go b c) [5]\n", "--robust", "--json")
        robust = json.loads(done.stdout)["robust"]
        self.assertAlmostEqual(robust["holds_s"], 1.0, delta=0.02)  # both move by up to 1 s, 2 s apart
        self.assertEqual(robust["violation"]["kind"], "interference")

    def test_bad_files_are_31_and_unsupported_is_34(self):
        done = self.validate("0: (go a)\n")
        self.assertEqual(done.returncode, 31)
        self.assertIn("plan:1: found 1 argument of go, expected 2; declared at ", done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(self.validate("", domain=DOMAIN[:-3]).returncode, 31)
        done = self.validate("", domain=DOMAIN.replace("(:types", "(:requirements :preferences) (:types"))
        self.assertEqual(done.returncode, 34)
        self.assertIn("d.pddl:1: found requirement :preferences: not supported", done.stderr)
        self.write("d.pddl", DOMAIN)
        os.remove(self.folder / "plan")
        done = subprocess.run([CXLAB, "validate", "d.pddl", "p.pddl", "plan"], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 31)

    def test_example_of_the_docs(self):
        folder = SOURCE / "docs/examples/planning"
        page = (SOURCE / "docs/reference/validate.md").read_text()
        for plan, code in (("good.plan", 0), ("hasty.plan", 1)):
            done = subprocess.run([CXLAB, "validate", "domain.pddl", "problem.pddl", plan], capture_output=True, text=True, cwd=folder)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(done.stdout.strip(), page)

    def test_usage(self):
        self.assertEqual(subprocess.run([CXLAB, "validate", "d.pddl"], capture_output=True).returncode, 2)
