"""Rules that do not come to an end are named soon; programs that take long and end are left alone."""

import os
import re
import shutil
import subprocess
import unittest

from lab import CXLAB, SCENARIO, SOURCE, Lab

AGENT = SOURCE / "scenarios/rcll/agent"
MOST_CPU_S = 2 * float(os.environ.get("CXLAB_SLOWER", "2"))  # the machine that runs the tests may be busy

ORDERS = "(deftemplate order (slot id) (slot state))\n(deffacts start (order (id 1) (state OPEN)) (next 2))\n"
# Rules, what the message names; each rule in a line of its own.
LOOPS = {
    "a rule that feeds itself":
        ("(deffacts start (n 0))\n(defrule again ?f <- (n ?n) => (retract ?f) (assert (n (+ ?n 1))))\n", ["again", "n (", "rules.clp:2"]),
    "facts that grow, each turn dearer than the last":
        (ORDERS + """(defrule innocent (order (id ?a)) (order (id ?b&:(> ?b ?a))) (never ?a ?b) =>)
(defrule more (order (id ?i) (state OPEN)) ?n <- (next ?k) => (retract ?n) (assert (order (id ?k) (state OPEN)) (next (+ ?k 1))))
""", ["more (", "rules.clp:4"]),
    "two rules that take turns, each dear":
        (ORDERS + """(defrule innocent (order (id ?a)) (order (id ?b&:(> ?b ?a))) (never ?a ?b) =>)
(defrule plan (next ?k) => (assert (planned ?k)))
(defrule carry-out ?p <- (planned ?k) ?n <- (next ?k) => (retract ?p ?n) (assert (order (id ?k) (state OPEN)) (next (+ ?k 1))))
""", ["plan (", "rules.clp:4", "carry-out (", "rules.clp:5"]),
    "a condition that is true again because a fact is taken back":
        ("(deffacts start (a))\n(defrule one (a) (not (b)) => (assert (b)))\n(defrule two ?f <- (b) => (retract ?f))\n",
         ["one (", "rules.clp:2", "two (", "rules.clp:3", "b ("]),
    "texts that grow":
        ("(deffacts start (n a))\n(defrule longer (n ?n) => (assert (n (sym-cat ?n b))))\n", ["longer", "rules.clp:2"]),
    "more and more firings, no chain":
        ("(deffacts start (n 1))\n(defrule split (n ?n) => (assert (n (* 2 ?n)) (n (+ 1 (* 2 ?n)))))\n", ["split", "rules.clp:2"]),
    "a loop in an action":
        ("(deffacts start (go))\n(defrule innocent (go) =>)\n(defrule spin (go) => (while TRUE (bind ?x 1)))\n", ["spin", "rules.clp:3"]),
    "a loop in an action that works":
        ("(deffacts start (go))\n(defrule innocent (go) =>)\n(defrule spin (go) => (bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (bind ?s (str-cat a ?i))))\n",
         ["spin", "rules.clp:3"]),
    "a loop in an action that asserts":
        ("(deffacts start (go))\n(defrule spin (go) => (bind ?i 0) (while TRUE (bind ?i (+ ?i 1)) (assert (n ?i))))\n", ["spin", "rules.clp:2"]),
    "a recursion":
        ("(deffunction f (?x) (f (+ ?x 1)))\n(deffacts start (go))\n(defrule deep (go) => (f 1))\n", ["deep", "rules.clp:3", "'f'"]),
    "a recursion that branches":
        ("(deffunction fib (?x) (if (< ?x 2) then 1 else (+ (fib (- ?x 1)) (fib (- ?x 2)))))\n(deffacts start (go))\n(defrule deep (go) => (fib 60))\n",
         ["deep", "rules.clp:3"]),
    "a condition with too many combinations":
        ("(deffacts start (go))\n(defrule few (x ?) =>)\n(defrule fill (go) => (loop-for-count (?i 1 2000) (assert (x ?i))))\n"
         "(defrule many (x ?a) (x ?b&:(< ?b ?a)) (x ?c&:(< (+ ?a ?b ?c) 0)) =>)\n", ["many", "rules.clp:4"]),
    "a condition that holds in too many combinations":
        ("(deffacts start " + " ".join(f"(x {i})" for i in range(600)) + ")\n(defrule many (x ?a) (x ?b) (x ?c) =>)\n", ["many", "rules.clp:2"]),
}

# Programs that end, and what they print.
FINE = {
    "a count by rules":
        ("(deffacts start (n 0))\n(defrule again ?f <- (n ?n&:(< ?n 90000)) => (retract ?f) (assert (n (+ ?n 1))))\n"
         "(defrule done (n 90000) => (printout t done crlf))\n", "done"),
    "primes in one action":
        ("(deffacts start (go))\n(defrule primes (go) => (bind ?c 0) (loop-for-count (?i 2 50000) (bind ?p TRUE) (bind ?j 2)"
         " (while (and ?p (<= (* ?j ?j) ?i)) (if (= 0 (mod ?i ?j)) then (bind ?p FALSE)) (bind ?j (+ ?j 1))) (if ?p then (bind ?c (+ ?c 1))))"
         " (printout t ?c \" primes\" crlf))\n", "5133 primes"),
    "many facts and a join":
        ("(deftemplate p (slot id) (slot x) (slot y))\n(deffacts start (go))\n"
         "(defrule fill (go) => (loop-for-count (?i 1 100000) (assert (p (id ?i) (x (mod ?i 317)) (y (mod ?i 211))))))\n"
         "(defrule pair (p (id ?i) (x 5) (y ?y)) (p (id ?j&:(> ?j ?i)) (x 7) (y ?y)) => (assert (pair ?i ?j)))\n"
         "(defrule done (declare (salience -10)) (go) => (printout t done crlf))\n", "done"),
    "an agenda of many": ("(deffacts start " + " ".join(f"(x {i})" for i in range(20000)) + ")\n(defrule each (x ?i) => (assert (y ?i)))\n"
                          "(defrule done (declare (salience -10)) (y 19999) => (printout t done crlf))\n", "done"),
    "phases that come again and again":
        ("(deffacts start (phase a) (n 0))\n(defrule a ?p <- (phase a) => (retract ?p) (assert (phase b)))\n"
         "(defrule b ?p <- (phase b) ?f <- (n ?n&:(< ?n 20000)) => (retract ?p ?f) (assert (phase a) (n (+ ?n 1))))\n"
         "(defrule done (n 20000) => (printout t done crlf))\n", "done"),
}

# A condition of the rule agent that is left out, and the rules that then have no end.
LEFT_OUT = {
    "station-clear-base": ("cap-stations.clp", "  (not (job (purpose CLEAR) (station ?name) (step ~PUT&~DONE)))\n"),
    "repair-over": ("repairs.clp", "  (not (command (goal-id ?goal)))\n"),
}


class Loops(Lab):
    def timed(self, *command, cwd=None):
        """The process and the time of the processor that it took, s."""
        before = os.times()
        done = subprocess.run([CXLAB, *map(str, command)], cwd=cwd or self.folder, text=True, capture_output=True, timeout=120)
        after = os.times()
        return done, after.children_user + after.children_system - before.children_user - before.children_system

    def test_are_named_by_run(self):
        for name, (rules, named) in LOOPS.items():
            with self.subTest(name):
                self.agent(rules)
                done, cpu_s = self.timed("run", "scenario.yaml", "--out", "out", "--force")
                self.assertIn(done.returncode, (4, 5), done.stderr)
                error = [line for line in done.stderr.splitlines() if line.startswith("error: ")][-1]
                for part in named:
                    self.assertIn(part, error)
                self.assertNotIn("innocent", error)
                self.assertLess(cpu_s, MOST_CPU_S)

    def test_programs_that_end_are_left_alone(self):
        for name, (rules, printed) in FINE.items():
            with self.subTest(name):
                self.agent(rules)
                done, _ = self.timed("run", "scenario.yaml", "--out", "none")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(printed, done.stderr)

    def test_the_story_is_named_and_the_others_are_played(self):
        rules, named = LOOPS["two rules that take turns, each dear"]
        self.write("loop.clp", rules)
        self.write("fine.clp", "(defrule go (start) => (assert (gone)))\n")
        self.write("a.story.yaml", "- story: endless\n  rules: loop.clp\n  expect: [{fires: innocent, within_s: 1}]\n"
                                   "- story: fine\n  rules: fine.clp\n  given: [(start)]\n  expect: [{fact: (gone), within_s: 1}]\n")
        for jobs in ["-j", 1], ["-j", 2]:
            done, cpu_s = self.timed("test", *jobs)
            self.assertNotEqual(done.returncode, 0)
            self.assertRegex(done.stdout, r"FAILED  .*: endless")
            self.assertRegex(done.stdout, r"ok .*: fine")
            for part in named:
                self.assertIn(part.replace("rules.clp", "loop.clp"), done.stdout)
            self.assertLess(cpu_s, MOST_CPU_S)

    def test_why_not_answers_inside_the_loop(self):
        rules, _ = LOOPS["two rules that take turns, each dear"]
        self.agent(rules)
        self.timed("run", "scenario.yaml", "--out", "out")
        done, _ = self.timed("why-not", "out", "carry-out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"fired \d\d+ times so far")

    def test_steps_end_with_the_same_explanation(self):
        rules, named = LOOPS["two rules that take turns, each dear"]
        self.agent(rules)
        done, _ = self.timed("run", "scenario.yaml", "--out", "out", "--steps", 300000)
        self.assertEqual(done.returncode, 4)
        self.assertIn("more than 300000 steps", done.stderr)
        for part in named:
            self.assertIn(part, done.stderr)

    def test_the_rule_without_its_condition_is_named(self):
        for rule, (file, condition) in LEFT_OUT.items():
            with self.subTest(rule):
                shutil.rmtree(self.folder / "agent", ignore_errors=True)
                shutil.copytree(AGENT, self.folder / "agent")
                path = self.folder / "agent/clips" / file
                text = path.read_text()
                begin = text.index(f"(defrule {rule}\n")
                at = text.index(condition, begin)
                self.assertLess(at, text.index("\n(defrule ", begin + 1) if "\n(defrule " in text[begin + 1:] else len(text))
                path.write_text(text[:at] + text[at + len(condition):])
                self.write("game.yaml", "schema: 1\nworld: {kind: rcll, information: league, exploration: true}\ntier: timed\nseed: 1\n"
                                        "agents:\n  - config: agent/params/agent.yaml\n    packages: {rcll_agent: agent}\n")
                done, _ = self.timed("run", "game.yaml", "--until", 400, "--out", "none")
                self.assertEqual(done.returncode, 4, done.stderr)
                line = 1 + text[:begin].count("\n")
                self.assertIn(f"{file}:{line}", done.stderr)
                self.assertRegex(done.stderr, rf"{rule} \(\d+ x")


if __name__ == "__main__":
    unittest.main()
