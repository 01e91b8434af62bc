"""cxlab plan: answers, exit codes, files. python3 -m unittest plan"""

import json
import resource
import subprocess
import xml.etree.ElementTree

from lab import CXLAB, Lab

DOMAIN = """(define (domain d) (:types place)
  (:predicates (at ?p - place) (road ?a ?b - place) (seen ?p - place))
  (:durative-action go :parameters (?a ?b - place) :duration (= ?duration 5)
    :condition (and (at start (at ?a)) (over all (road ?a ?b)))
    :effect (and (at start (not (at ?a))) (at end (at ?b)) (at end (seen ?b)))))
"""
PROBLEM = "(define (problem p) (:domain d) (:objects a b c - place) (:init (at a) (road a b) (road b c)) (:goal (at c)))\n"


class Plan(Lab):
    def plan(self, *arguments, domain=DOMAIN, problem=PROBLEM):
        files = [self.write("d.pddl", domain), self.write("p.pddl", problem)]
        return subprocess.run([CXLAB, "plan", *map(str, files), *arguments], capture_output=True, text=True, cwd=self.folder)

    def test_a_plan_is_printed_and_valid(self):
        done = self.plan("--out", "found.plan", "--svg", "found.svg")
        self.assertEqual((done.returncode, done.stdout), (0, ""))
        judged = subprocess.run([CXLAB, "validate", "d.pddl", "p.pddl", "found.plan"], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(judged.returncode, 0, judged.stdout)
        self.assertEqual((self.folder / "found.plan").read_text(), self.plan().stdout)
        picture = xml.etree.ElementTree.parse(self.folder / "found.svg")
        texts = [text.text for text in picture.iter("{http://www.w3.org/2000/svg}text")]
        self.assertEqual(texts[-3:], ["runs", "slack: may end this late, makespan kept", "waits for"])

    def test_the_actions_of_a_plan_have_colours_of_their_own(self):
        unused = " ".join(f"(:action no{i} :parameters () :precondition (q) :effect (r))" for i in range(7))
        domain = ("(define (domain d) (:predicates (q) (r) (s)) (:durative-action first :duration (= ?duration 1) :effect (at end (r)))"
                  f" {unused} (:durative-action last :duration (= ?duration 1) :condition (at start (r)) :effect (at end (s))))")
        done = self.plan("--svg", "found.svg", domain=domain, problem="(define (problem p) (:domain d) (:init) (:goal (s)))")
        self.assertEqual(done.returncode, 0, done.stderr)
        bars = [r.get("fill") for r in xml.etree.ElementTree.parse(self.folder / "found.svg").iter("{http://www.w3.org/2000/svg}rect") if len(r) == 1]
        self.assertEqual(len(bars), 2)
        self.assertNotEqual(*bars)

    def test_a_picture_is_as_wide_as_its_bars_need(self):
        def width(places):
            names = [f"p{i}" for i in range(places)]
            roads = " ".join(f"(road {a} {b})" for a, b in zip(names, names[1:]))
            self.plan("--svg", "found.svg", problem=f"(define (problem p) (:domain d) (:objects {' '.join(names)} - place) (:init (at p0) {roads}) (:goal (at {names[-1]})))")
            return int(xml.etree.ElementTree.parse(self.folder / "found.svg").getroot().get("width"))
        self.assertLess(width(3), 620)
        self.assertAlmostEqual(width(31) - width(21), 300, delta=5)
        self.assertEqual(width(70), width(80))

    def test_a_budget_that_is_no_whole_number_is_reported_with_the_number_that_may_be_meant(self):
        for budget, message in [("1e6", "found '1e6', expected a whole number: 1000000"), ("1.5", "found '1.5', expected a whole number from 1 to 9223372036854775807")]:
            done = self.plan("--budget", budget)
            self.assertEqual((done.returncode, done.stderr.splitlines()[0]), (2, "error: --budget: " + message))

    def test_memory_that_ends_is_an_answer_of_its_own(self):
        few = lambda: resource.setrlimit(resource.RLIMIT_AS, (100 << 20, 100 << 20))
        if subprocess.run([CXLAB, "--version"], capture_output=True, preexec_fn=few).returncode != 0:
            self.skipTest("the program does not even begin, as under a sanitizer")
        domain = "(define (domain d) (:types t) (:predicates (p ?a ?b - t)) (:action x :parameters (?a ?b - t) :effect (p ?a ?b)))"
        objects = " ".join(f"o{i}" for i in range(900))
        problem = f"(define (problem p) (:domain d) (:objects {objects} - t) (:init) (:goal (forall (?a ?b - t) (p ?a ?b))))"
        files = [self.write("d.pddl", domain), self.write("p.pddl", problem)]
        done = subprocess.run([CXLAB, "plan", *map(str, files)], capture_output=True, text=True, cwd=self.folder, preexec_fn=few)
        self.assertEqual((done.returncode, done.stderr), (22, "error: out of memory\n"))

    def test_standard_output_that_takes_nothing_is_reported(self):
        self.plan()
        with open("/dev/full", "w") as full:
            done = subprocess.run([CXLAB, "plan", "d.pddl", "p.pddl"], stdout=full, stderr=subprocess.PIPE, text=True, cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr.splitlines()[-1]), (5, "error: standard output cannot be written"))

    def test_json_of_an_empty_plan_has_its_lists(self):
        answer = json.loads(self.plan("--json", problem=PROBLEM.replace("(:goal (at c))", "(:goal (at a))")).stdout)
        self.assertEqual((answer["status"], answer["steps"], answer["orderings"]), ("plan", [], []))

    def test_json_has_order_and_bound(self):
        answer = json.loads(self.plan("--json").stdout)
        self.assertEqual((answer["status"], len(answer["steps"])), ("plan", 2))
        self.assertLessEqual(answer["lower_bound_s"], answer["makespan_s"])
        self.assertEqual(answer["steps"][0]["arguments"], ["a", "b"])
        self.assertIn({"from": {"step": 0, "at": "end"}, "to": {"step": 1, "at": "start"}, "least_s": 0.001001}, answer["orderings"])

    def test_metric_is_printed_alike_by_all_commands(self):
        problem = PROBLEM.replace("(:goal (at c))", "(:goal (at c)) (:metric minimize (+ (* 0.1 (total-time)) (+ 0.1 0.2)))")
        done = self.plan("--json", "--out", "found.plan", problem=problem)
        answer = json.loads(done.stdout)
        arguments = [CXLAB, "validate", "d.pddl", "p.pddl", "found.plan"]
        judged = [subprocess.run([*arguments, *more], capture_output=True, text=True, cwd=self.folder).stdout for more in ([], ["--json"])]
        text = str(answer["metric"])
        self.assertRegex(text, r"^1\.3001\d{0,2}$")  # 0.1 * 10.001 + 0.3, in doubles with noise at the 17th digit
        self.assertRegex(judged[0], f", metric {text}\n$")
        self.assertEqual(json.loads(judged[1])["metric"], answer["metric"])
        self.assertIn(f"metric {text}", self.plan(problem=problem).stderr)

    def test_a_stream_has_each_better_plan_and_the_answer_on_lines_of_their_own(self):
        places = "abcdef"
        far = " ".join(f"(= (far {a} {b}) {1 + 7 * i % 5 + 3 * j % 7})" for i, a in enumerate(places) for j, b in enumerate(places) if a != b)
        domain = DOMAIN.replace("(:durative-action", "(:functions (far ?a ?b - place)) (:durative-action").replace("(= ?duration 5)", "(= ?duration (far ?a ?b))").replace("(over all (road ?a ?b))", "")
        goal = " ".join(f"(seen {p})" for p in places)
        problem = f"(define (problem p) (:domain d) (:objects {' '.join(places)} - place) (:init (at a) {far}) (:goal (and {goal})))"
        arguments = ("--anytime", "--budget", "200000")
        lines = [json.loads(line) for line in self.plan("--stream", *arguments, domain=domain, problem=problem).stdout.splitlines()]
        *found, last = lines
        self.assertGreater(len(found), 1)
        self.assertEqual({line["status"] for line in found}, {"found"})
        self.assertNotIn("lower_bound_s", found[0])
        makespans = [line["makespan_s"] for line in found]
        self.assertEqual(makespans, sorted(set(makespans), reverse=True))
        self.assertEqual(last, json.loads(self.plan("--json", *arguments, domain=domain, problem=problem).stdout))
        self.assertEqual(last["steps"], found[-1]["steps"])
        unsolvable = self.plan("--stream", problem=PROBLEM.replace("(road b c)", "")).stdout.splitlines()
        self.assertEqual([json.loads(line)["status"] for line in unsolvable], ["unsolvable"])

    def test_same_budget_same_answer(self):
        arguments = ("--json", "--anytime", "--budget", "50000")
        first, second = (self.plan(*arguments) for _ in range(2))
        self.assertEqual((first.stdout, first.stderr), (second.stdout, second.stderr))

    def test_every_other_answer_has_its_code(self):
        self.assertEqual(self.plan(problem=PROBLEM.replace("(road b c)", "")).returncode, 10)
        # The road is open for less time than going takes.
        closing = PROBLEM.replace("(road b c)", "(at 1 (road b c)) (at 4 (not (road b c)))")
        self.assertEqual(self.plan(problem=closing).returncode, 10)
        # Nine parts of two seconds each are wanted in nine seconds.
        making = ("(define (domain d) (:predicates (free) (open)) (:functions (made)) (:durative-action make :parameters () "
                  ":duration (= ?duration 2) :condition (and (at start (free)) (over all (open))) :effect (and (at start (not (free))) "
                  "(at end (free)) (at end (increase (made) 1)))))")
        wanted = "(define (problem p) (:domain d) (:init (free) (open) (= (made) 0) (at 9 (not (open)))) (:goal (>= (made) 9)))"
        self.assertEqual(self.plan(domain=making, problem=wanted).returncode, 10)
        # Five must work at one time: no search starts so many copies of an action.
        making = ("(define (domain d) (:predicates (done)) (:functions (workers)) (:durative-action work :parameters () "
                  ":duration (= ?duration 2) :effect (and (at start (increase (workers) 1)) (at end (decrease (workers) 1)))) "
                  "(:durative-action meet :parameters () :duration (= ?duration 1) :condition (at start (>= (workers) 5)) :effect (at end (done))))")
        wanted = "(define (problem p) (:domain d) (:init (= (workers) 0)) (:goal (done)))"
        self.assertEqual(self.plan(domain=making, problem=wanted).returncode, 12)
        for limit in ("--budget", "1"), ("--timeout", "1e-9"):
            ended = self.plan("--json", *limit)
            self.assertEqual((ended.returncode, json.loads(ended.stdout)["status"]), (23, "budget"))
        done = self.plan(domain=DOMAIN.replace("(at end (at ?b))", "(at end (as ?b))"))
        self.assertEqual(done.returncode, 31)
        self.assertIn("d.pddl:5:", done.stderr)
        self.assertEqual(self.plan(domain=DOMAIN.replace("(:types", "(:requirements :preferences) (:types")).returncode, 34)
        self.assertEqual(self.plan("--budget", "0").returncode, 2)

    def test_a_problem_that_does_not_fit_into_memory_has_a_code_of_its_own(self):
        # 12^6 ground actions, each with arguments that matter.
        names = "abcdef"
        domain = ("(define (domain d) (:predicates (x ?a) (g)) (:action a :parameters (" + " ".join(f"?{n}" for n in names) + ")\n :precondition (and "
                  + " ".join(f"(x ?{n})" for n in names) + ") :effect (and (g) " + " ".join(f"(not (x ?{n}))" for n in names) + ")))")
        objects = " ".join(f"o{i}" for i in range(12))
        problem = f"(define (problem p) (:domain d) (:objects {objects}) (:init {' '.join(f'(x o{i})' for i in range(12))}) (:goal (g)))"
        done = self.plan(domain=domain, problem=problem)
        self.assertEqual(done.returncode, 22, done.stderr)
        self.assertIn("found more than 1000000 ground actions", done.stderr)
        self.assertEqual(self.plan("--out", "/proc/none/plan").returncode, 5)
