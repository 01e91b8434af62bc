"""cxlab test, bench and new, as people call them."""

import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree
from pathlib import Path

from lab import CONFIG

CXLAB = os.environ["CXLAB"]
EXAMPLES = Path(os.environ["CXLAB_SOURCE_DIR"]) / "docs/examples/stories"


def cxlab(*arguments, cwd):
    return subprocess.run([CXLAB, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=100)


class Testing(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def story(self, expectation):
        (self.folder / "a.clp").write_text("(defrule go (start) => (assert (gone)))\n")
        (self.folder / "a.story.yaml").write_text(f"- story: one <&\n  rules: a.clp\n  given: [(start)]\n  expect: [{{{expectation}}}]\n")

    def test_stories_pass(self):
        self.story("fact: (gone), within_s: 1")
        done = cxlab("test", "--junit", "j.xml", "--coverage", "c.info", cwd=self.folder)
        self.assertEqual((done.returncode, done.stdout.splitlines()[-1]), (0, "1 passed, 0 failed"))
        suite = xml.etree.ElementTree.parse(self.folder / "j.xml").getroot()
        self.assertEqual(suite.find("testcase").get("name"), "one <&")
        self.assertIn("FNDA:1,go\n", (self.folder / "c.info").read_text())

    def test_folders_with_a_dot_are_left_out_unless_they_are_named(self):
        for name in (".tools", "more"):
            (self.folder / name).mkdir()
            (self.folder / name / "a.story.yaml").write_text("- {story: fails, given: [(gone)], rules: ../a.clp, expect: [{fires: go, within_s: 1}]}\n")
        self.story("fact: (gone), within_s: 1")
        self.assertEqual(cxlab("test", cwd=self.folder).stdout.splitlines()[-1], "1 passed, 1 failed")
        self.assertEqual(cxlab("test", ".tools", cwd=self.folder).stdout.splitlines()[-1], "0 passed, 1 failed")
        self.assertEqual(cxlab("test", ".", ".tools", cwd=self.folder).stdout.splitlines()[-1], "1 passed, 2 failed")

    def test_coverage_has_a_state_for_each_rule(self):
        (self.folder / "b.clp").write_text("(defrule first (declare (salience 1)) ?s <- (start) => (retract ?s))\n"
                                           "(defrule late (start) => (assert (late)))\n(defrule deaf (nothing) => (assert (heard)))\n")
        (self.folder / "b.story.yaml").write_text("- story: b\n  rules: b.clp\n  given: [(start)]\n  expect: [{fires: first, within_s: 1}]\n")
        for more in [], ["-j", "2"]:
            done = cxlab("test", "--coverage", "c.info", *more, cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("b.clp:2: late: activated but never fired\n", done.stdout)
            self.assertIn("b.clp:3: deaf: never matched: nothing got past condition 1, (nothing)\n", done.stdout)
            self.assertIn("rules: 1 fired, 1 activated but never fired, 1 never matched\n", done.stdout)
            self.assertIn("BRDA:2,0,0,1\nBRDA:2,0,1,0\n", (self.folder / "c.info").read_text())
        rules = json.loads(cxlab("test", "--json", "--coverage", "c.info", cwd=self.folder).stdout)["rules"]
        self.assertEqual([(r["rule"], r["state"]) for r in rules],
                         [("first", "fired"), ("late", "activated but never fired"), ("deaf", "never matched")])

    def test_agents_that_are_loaded_once_answer_as_those_of_each_story(self):
        (self.folder / "b.clp").write_text("(defglobal ?*n* = 0)\n(defrule go ?f <- (start ?x) => (retract ?f) (bind ?*n* (+ ?*n* ?x)) (assert (sum ?*n*)))\n")
        (self.folder / "b.story.yaml").write_text("".join(
            f"- {{story: {name}, rules: {rules}, given: [(start {given})], seeds: {seeds}, expect: [{{fact: (sum {sum}), within_s: 1}}]}}\n"
            for name, rules, given, seeds, sum in (("one", "b.clp", 1, [1, 2], 1), ("two", "b.clp", 2, [1], 2), ("wrong", "b.clp", 1, [1], 4), ("none", "c.clp", 1, [1], 1))))

        def told(*more):
            done = cxlab("test", "--json", "--coverage", "c.info", *more, cwd=self.folder)
            answer = json.loads(done.stdout)
            for story in answer["stories"]:
                del story["wall_s"]
            return done.returncode, answer

        code, answer = told()
        self.assertEqual((code, [story["passed"] for story in answer["stories"]]), (3, [True, True, False, False]))
        self.assertEqual(told("--load-once"), (code, answer))
        self.assertIn("--keep-runs excludes --load-once", cxlab("test", "--load-once", "--keep-runs", "runs", cwd=self.folder).stderr)

    def counts(self, *files, story):
        """{rule: (activated, fired)} of one story, whose rules begin with (start)."""
        (self.folder / "a.story.yaml").write_text(f"- {{story: a, given: [(start)], {story}, expect: [{{fires: go, within_s: 1}}]}}\n")
        for name, text in files:
            (self.folder / name).write_text(text)
        done = cxlab("test", "--json", "--coverage", "c.info", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stdout)
        return {r["rule"]: (r["activated"], r["fired"]) for r in json.loads(done.stdout)["rules"]}

    def test_rules_of_one_name_are_counted_each(self):
        rules = ("(defmodule MAIN (export ?ALL))\n(defrule go (start) => (assert (gone)))\n(defmodule NAV (import MAIN ?ALL))\n"
                 "(defrule NAV::go (start) => (assert (navigated)))\n(defrule MAIN::go:2 (gone) => (assert (done)))\n")
        self.assertEqual(self.counts(("r.clp", rules), story="rules: r.clp"), {"go": (1, 1), "NAV::go": (1, 0), "go:2": (1, 1)})

    def test_coverage_does_not_depend_on_what_rules_print(self):
        rules = ('(defrule go (start) => (printout t "==> Activation 0      deaf: f-1" crlf "no end") (unwatch all) (assert (gone)))\n'
                 "(defrule deaf (nothing) => (assert (heard)))\n(defrule after (gone) => (assert (x)))\n")
        self.assertEqual(self.counts(("r.clp", rules), story="rules: r.clp"), {"go": (1, 1), "deaf": (0, 0), "after": (1, 1)})

    def test_coverage_has_the_rules_of_all_environments(self):
        config = """/**:
  ros__parameters:
    environments: ["left", "right"]
    left: {plugins: ["executive", "shared"]}
    right: {plugins: ["executive", "shared", "more"]}
    executive: {plugin: "cx::ExecutivePlugin"}
    shared: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["here"], load: ["shared.clp"]}
    more: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["here"], load: ["more.clp"]}
"""
        files = [("agent.yaml", config), ("shared.clp", "(deffacts h (here))\n(defrule both (here) => (assert (b)))\n(defrule go (start) => (assert (gone)))\n"),
                 ("more.clp", "(defrule more (b) => (assert (more)))\n")]
        self.assertEqual(self.counts(*files, story="config: agent.yaml, packages: {here: .}"), {"both": (2, 2), "go": (1, 1), "more": (1, 1)})

    def test_readers_accept_the_coverage(self):
        """The consistency rules of lcov's man page, which genhtml of lcov 2 enforces (./dev readers asks it), and genhtml of lcov 1 if it is there."""
        (self.folder / "c.clp").write_text("(deftemplate lamp (slot state))\n"
                                           "(defrule on ?l <- (lamp (state OFF)) (bell) => (modify ?l (state ON))) (defrule deaf (nothing) => (halt))\n"
                                           "(defrule blocked (declare (salience -5))\n  (bell) (lamp (state OFF)) => (assert (b)))\n"
                                           "(defrule never (never) => (assert (c))) (defrule twin (bell) => (assert (d)))\n")
        (self.folder / "c.story.yaml").write_text("common: {rules: [c.clp], given: ['(lamp (state OFF))']}\nstories:\n"
                                                  "  - story: on\n    steps: [{at: 1, assert: (bell)}]\n    expect: [{fires: on, within_s: 2}]\n  - story: nothing\n    expect: [{not_fires: on, within_s: 2}]\n")
        done = cxlab("test", "--coverage", "c.info", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "c.info").read_text()
        lines, functions, counts, branches, totals = {}, {}, {}, {}, {}
        for line in text.splitlines():
            tag, _, rest = line.partition(":")
            if tag == "DA":
                number, hits = map(int, rest.split(","))
                self.assertNotIn(number, lines, "a line is told once")
                lines[number] = hits
            elif tag == "FN":
                number, name = rest.split(",", 1)
                self.assertNotIn(name, functions, "a function is told once")
                functions[name] = int(number)
            elif tag == "FNDA":
                counts[rest.split(",", 1)[1]] = int(rest.split(",")[0])
            elif tag == "BRDA":
                number, block, branch, taken = rest.split(",")
                key = (int(number), int(block), int(branch))
                self.assertNotIn(key, branches, "a branch is told once")
                branches[key] = taken
            elif tag in ("LF", "LH", "FNF", "FNH", "BRF", "BRH"):
                totals[tag] = int(rest)
        self.assertEqual(set(functions), set(counts))
        self.assertEqual(set(lines) - set(functions.values()), {4}, "conditions have lines of their own")
        self.assertEqual(lines[4], 1, "what got past the conditions of that line")
        for number, hits in lines.items():
            blocks = sorted({block for n, block, _ in branches if n == number})
            self.assertEqual(blocks, list(range(len(blocks))), "blocks of a line are numbered")
            of_line = [taken for (n, _, _), taken in branches.items() if n == number]
            if not of_line:
                continue
            self.assertEqual(hits > 0, any(taken != "-" for taken in of_line), f"line {number} is hit where a branch of it was evaluated")
            for block in blocks:
                unknown = {branches[number, block, branch] == "-" for branch in (0, 1)}
                self.assertEqual(len(unknown), 1, "a block was reached or not")
        for name, number in functions.items():
            if counts[name] > 0:
                self.assertGreater(lines[number], 0, "a function that was called is on a line that was hit")
        self.assertEqual(totals, {"LF": len(lines), "LH": sum(h > 0 for h in lines.values()), "FNF": len(functions), "FNH": sum(c > 0 for c in counts.values()),
                                  "BRF": len(branches), "BRH": sum(t not in "-0" for t in branches.values())})
        self.assertIn("BRDA:3,0,0,1\nBRDA:3,0,1,0\n", text)
        self.assertIn("BRDA:2,0,0,-\nBRDA:2,0,1,-\nBRDA:2,1,0,1\nBRDA:2,1,1,1\n", text)
        if shutil.which("genhtml"):
            made = subprocess.run(["genhtml", "--branch-coverage", "c.info", "-o", "html"], cwd=self.folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(made.returncode, 0, made.stdout)
            self.assertNotRegex(made.stdout.lower(), "error|warning")
            self.assertRegex(made.stdout, r"functions\.*: .*2 of 5")

    def test_readers_accept_the_junit_file(self):
        """As Jenkins, GitLab and junitparser read it: counts agree, and any text is XML."""
        (self.folder / "a.clp").write_text('(deftemplate t (slot s))\n(defrule go (start) => (printout t "a" (format nil "%c" 1)) (assert (t (s "a<&]]>\u20ac"))))\n')
        (self.folder / "a.story.yaml").write_text("""- story: passes
  rules: a.clp
  given: [(start)]
  expect: [{fires: go, within_s: 1}]
- story: "fails twice \\"<&>' \\u0001\\uffff\\n\\tin two lines"
  rules: a.clp
  given: [(start)]
  expect: [{fact: '(t (s "b"))', within_s: 1}, {not_fires: go, within_s: 1}]
""")
        done = cxlab("test", "--junit", "j.xml", cwd=self.folder)
        self.assertEqual(done.returncode, 1, done.stderr)
        suite = xml.etree.ElementTree.parse(self.folder / "j.xml").getroot()
        self.assertEqual(suite.tag, "testsuite")
        cases = suite.findall("testcase")
        self.assertEqual([len(c.findall("failure")) + len(c.findall("error")) > 0 for c in cases], [False, True])
        self.assertEqual((int(suite.get("tests")), int(suite.get("failures")), int(suite.get("errors"))),
                         (len(cases), sum(c.find("failure") is not None for c in cases), sum(c.find("error") is not None for c in cases)))
        self.assertEqual(cases[1].get("name"), "fails twice \"<&>' ??\n\tin two lines")
        self.assertEqual(len(cases[1]), 1, "readers show the first failure only")
        self.assertRegex(cases[1][0].text, r"expected fact \(t \(s \"b\"\)\)[^\n]*\n.*does not fire")
        self.assertTrue(cases[1][0].text.startswith(cases[1][0].get("message") + "\n"))
        for case in cases:
            self.assertTrue(case.get("name") and case.get("classname"))
            self.assertGreaterEqual(float(case.get("time")), 0)
            for outcome in case:
                self.assertIn(outcome.tag, ("failure", "error", "skipped", "system-out", "system-err", "properties"))
                self.assertTrue(outcome.get("message"))
        self.assertGreaterEqual(float(suite.get("time")), sum(float(c.get("time")) for c in cases) - 0.01)

    def test_a_failure_is_exit_1_with_line_also_in_processes(self):
        self.story("not_fires: go, within_s: 1")
        for more in [], ["-j", "3"]:
            done = cxlab("test", *more, "--junit", "j.xml", cwd=self.folder)
            self.assertEqual(done.returncode, 1)
            self.assertIn("a.story.yaml:4: expected that rule go does not fire", done.stdout)
            self.assertEqual(xml.etree.ElementTree.parse(self.folder / "j.xml").getroot().get("failures"), "1")

    def test_json_is_json_whatever_a_name_has(self):
        name = "".join(map(chr, [*range(1, 0xa1), 0xad, 0x200b, 0x202e, 0x2028, 0xfeff, 0xfffe, 0xffff, 0x10ffff, 0xe0041]))
        (self.folder / "a.clp").write_text("(defrule go (start) => (assert (gone)))\n")
        written = "".join(f"\\U{ord(c):08x}" for c in name)
        (self.folder / "a.story.yaml").write_text(f'- {{story: "{written}", rules: a.clp, expect: [{{not_fires: go, within_s: 1}}]}}\n')
        done = cxlab("test", "--json", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["stories"][0]["story"], name)
        self.assertNotRegex(done.stdout, "[^\n -~\u00a0\ufffe\uffff\U0010ffff]", "nothing that moves the cursor or is not seen")

    def test_a_bad_story_is_exit_3(self):
        self.story("not_fire: go")
        done = cxlab("test", cwd=self.folder)
        self.assertEqual(done.returncode, 3)
        self.assertIn("did you mean 'not_fires'?", done.stdout)

    def test_bench_compares_and_goes_on(self):
        (self.folder / "empty.yaml").write_text("schema: 1\nduration_s: 1\n")
        (self.folder / "suite.yaml").write_text('scenarios: [empty.yaml]\nseeds: "1..2"\nstrategies: {plain: [], long: [duration_s=2], broken: ["packages={rules: rules}", "agents=[{config: agent.yaml}]"]}\n')
        (self.folder / "agent.yaml").write_text(CONFIG)
        (self.folder / "rules").mkdir()
        (self.folder / "rules/rules.clp").write_text("(defrule wrong (time ?) => (+ 1 (nth$ 1 (create$ one))))\n")
        first = cxlab("bench", "suite.yaml", "-j", 2, "--out", "o", cwd=self.folder)
        self.assertEqual(first.returncode, 1, first.stderr)
        with open(self.folder / "o/rows.csv") as rows:
            self.assertEqual([(r["strategy"], r["seed"], r["exit"]) for r in csv.DictReader(rows)],
                             [("plain", "1", "0"), ("plain", "2", "0"), ("long", "1", "0"), ("long", "2", "0"), ("broken", "1", "4"), ("broken", "2", "4")])
        next((self.folder / "o/rows").glob("empty-long-2-*.json")).unlink()
        again = cxlab("bench", "suite.yaml", "--out", "o", "--json", cwd=self.folder)
        kept, *failed = again.stderr.splitlines()
        self.assertEqual(kept, "5 rows are current and kept")
        self.assertEqual([line.split(":")[:2] for line in failed], [["kept", f" empty broken seed {seed}"] for seed in (1, 2)])
        next((self.folder / "o/rows").glob("empty-long-2-*.json")).unlink()
        played = cxlab("bench", "suite.yaml", "--out", "o", "-v", cwd=self.folder).stderr.splitlines()[-1]
        self.assertTrue(played.startswith("[6/6] empty long seed 2: completed, exit 0"), "a line of a game that is not remarkable comes with -v only")
        self.assertEqual([s["completed"] for s in json.loads(again.stdout)], [2, 2, 0])
        # As pandas reads them: one header, as many fields in each row, numbers where there are some, JSON without NaN.
        with open(self.folder / "o/rows.csv", newline="") as rows:
            header, *body = list(csv.reader(rows, strict=True))
        self.assertEqual(len(header), len(set(header)))
        self.assertTrue(all(len(row) == len(header) for row in body), header)
        for name in ("seed", "exit"):
            self.assertTrue(all(row[header.index(name)].lstrip("-").isdigit() for row in body), name)
        json.loads(again.stdout, parse_constant=self.fail)

    def test_bench_looks_for_all_files_first(self):
        (self.folder / "empty.yaml").write_text("schema: 1\nduration_s: 1\nagents: [{config: none.yaml}]\n")
        (self.folder / "suite.yaml").write_text("scenarios: [empty.yaml]\nseeds: [1]\nstrategies: {plain: []}\n")
        done = cxlab("bench", "suite.yaml", "--out", "o", cwd=self.folder)
        self.assertEqual(done.returncode, 3)
        self.assertIn("none.yaml", done.stderr)
        self.assertFalse((self.folder / "o").exists())

    def test_bench_reads_all_overrides_first(self):
        (self.folder / "empty.yaml").write_text("schema: 1\nduration_s: 1\n")
        (self.folder / "suite.yaml").write_text("scenarios: [empty.yaml]\nseeds: [1]\nstrategies: {plain: [], broken: [duration=3]}\n")
        done = cxlab("bench", "suite.yaml", "--out", "o", cwd=self.folder)
        self.assertEqual(done.returncode, 3)
        self.assertIn("strategy 'broken': duration=3: unknown key 'duration', did you mean 'duration_s'?", done.stderr)
        self.assertFalse((self.folder / "o").exists())

    def test_a_new_agent_for_the_league_delivers(self):
        self.assertEqual(cxlab("new", "agent", "carrier", "--rcll", cwd=self.folder).returncode, 0)
        here = self.folder / "carrier"
        self.assertEqual(cxlab("test", cwd=here).returncode, 0)
        done = cxlab("run", "scenario.yaml", "--tier", "timed", "--out", "none", "--json", cwd=here)
        result = json.loads(done.stdout)
        self.assertEqual(result["status"], "completed")
        self.assertGreaterEqual(sum(d["correct"] for d in result["deliveries"]), 3)

    def test_a_new_agent_runs_at_once(self):
        self.assertEqual(cxlab("new", "agent", "mine", cwd=self.folder).returncode, 0)
        mine = self.folder / "mine"
        self.assertEqual(cxlab("test", cwd=mine).returncode, 0)
        run = cxlab("run", "scenario.yaml", "--out", "none", cwd=mine)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("the door is open for Ada", run.stderr)
        env = cxlab("env", "agent.yaml", "--package", "mine=.", "--until", 5, cwd=mine)
        self.assertEqual(env.returncode, 0, env.stderr)
        self.assertEqual(cxlab("new", "agent", "mine", cwd=self.folder).returncode, 2)

    def test_a_new_project_is_named_by_the_last_part_of_its_path(self):
        for kind, path in (("agent", "deep/er/door_2/"), ("plugin", "arm")):
            made = cxlab("new", kind, path, cwd=self.folder)
            self.assertEqual(made.returncode, 0, made.stderr)
            files = [file for file in (self.folder / path).rglob("*") if file.is_file()]
            self.assertGreater(len(files), 4)
            name = path.strip("/").split("/")[-1]
            texts = "".join(file.read_text() for file in files)
            self.assertIn(name, texts)
            if kind == "agent":
                shipped = re.search("comes with cxlab:\\s`(.*)`", (self.folder / path / "README.md").read_text())[1]
                self.assertTrue((pathlib.Path(shipped) / "params").is_dir(), shipped)
            self.assertNotRegex(texts, f"(?i)my_?{kind}")
        here = self.folder / "here"
        here.mkdir()
        self.assertEqual(cxlab("new", "agent", ".", cwd=here).returncode, 0)
        self.assertIn('pkg_share_dirs: ["here"]', (here / "agent.yaml").read_text())

    def test_a_name_that_no_package_can_have_makes_nothing(self):
        for name, near in (("odd name", "'odd_name'"), ("My-Robot", "'my_robot'"), ("2nd", "'nd'"), ("_x", "'x'"), ("x_", "'x'"), ("a__b", "'a_b'"),
                           ("naïve", "'na_ve'"), ("%", "a letter first"), ("null", "no name in YAML"), ("std_msgs", "comes with cxlab"),
                           ("cx_pddl_clips", "comes with cxlab")):
            for kind in ("agent", "plugin"):
                made = cxlab("new", kind, name, cwd=self.folder)
                self.assertEqual(made.returncode, 2, name)
                self.assertIn(f"{name}: its last part names the package: ", made.stderr)
                self.assertIn(near, made.stderr)
                self.assertFalse((self.folder / name).exists())


if __name__ == "__main__":
    unittest.main()
