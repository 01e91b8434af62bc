"""genhtml and lcov of lcov 2 read what `cxlab test --coverage` writes. ./dev readers"""

import json
import os
import re
import subprocess
import unittest
from pathlib import Path

from lab import CXLAB, SOURCE, Lab

LCOV = Path(os.environ["CXLAB_READERS"]) / "lcov/usr"
TWO_ENVIRONMENTS = """/**:
  ros__parameters:
    environments: ["left", "right"]
    left: {plugins: ["executive", "files"]}
    right: {plugins: ["executive", "files", "more"]}
    executive: {plugin: "cx::ExecutivePlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["shared.clp"]}
    more: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["more.clp"]}
"""


class CoveragePages(Lab):
    def lcov(self, program, *arguments):
        """What a program of lcov prints, which must have nothing to complain of."""
        done = subprocess.run([LCOV / "bin" / program, "--branch-coverage", *arguments], cwd=self.folder, text=True, timeout=300,
                              env={**os.environ, "PERL5LIB": str(LCOV / "lib/lcov")}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("no messages were reported", done.stdout)
        self.assertNotRegex(done.stdout, "(?i)(error|warning):")
        return done.stdout

    def totals(self, said):
        """{lines, functions, branches}: (hit, all)"""
        return {what: (int(hit), int(all)) for what, hit, all in re.findall(r"(lines|functions|branches)\.+: +[\d.]+% \((\d+) of (\d+)", said)}

    def cover(self, *paths, name="c.info", code=0):
        """The rows of all rules, {(file, line, rule): (activated, fired)}, after both programs have read the counts and agree with them."""
        done = subprocess.run([CXLAB, "test", *map(str, paths or ["."]), "--coverage", name, "--json"], cwd=self.folder, text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        answer = json.loads(done.stdout)
        rules = {(Path(r["file"]).name, r["line"], r["rule"]): (r["activated"], r["fired"]) for r in answer["rules"]}
        hits, conditions, calls = {}, {}, [f["calls"] for f in answer["functions"]]
        for one in answer["rules"] + answer["functions"]:
            place = one["file"], one["line"]
            hits[place] = hits.get(place, 0) + one.get("activated", one.get("calls"))
        for rule in answer["rules"]:
            for condition in rule["conditions"]:
                self.assertIsNotNone(condition["passed"], condition)
                place = rule["file"], condition["line"]
                conditions[place] = min(condition["passed"], conditions.get(place, condition["passed"]))
        hits = {**conditions, **hits}
        expected = {"functions": (sum(fired > 0 for _, fired in rules.values()) + sum(n > 0 for n in calls), len(rules) + len(calls)),
                    "branches": (sum((fired > 0) + (activated > 0) for activated, fired in rules.values()), 2 * len(rules)),
                    "lines": (sum(n > 0 for n in hits.values()), len(hits))}
        self.assertEqual(self.totals(self.lcov("lcov", "--summary", name)), expected)
        self.assertEqual(self.totals(self.lcov("genhtml", "--show-details", name, "-o", name + ".html")), expected)
        for (_, line, rule), (activated, fired) in rules.items():
            self.assertGreaterEqual(activated, fired, f"{rule} in line {line}")
        return rules

    def functions_page(self, name, page):
        """{function: calls} as genhtml shows them. Several of one line stand below the first one's name with their sum."""
        text = next((self.folder / (name + ".html")).rglob(page + ".func.html")).read_text()
        found = re.findall(r'<td class="coverFn(?:Alias)?"><a[^>]*>(.*?)</a></td>\s*<td class="coverFn(?:Alias)?(?:Hi|Lo)">(\d+)</td>', text)
        self.assertTrue(found, text)
        return {function: int(calls) for function, calls in found}

    def test_stories_that_come_with_cxlab(self):
        for folder, some in ((SOURCE / "docs/examples/stories", ("door.clp", "errand.clp")), (SOURCE / "scenarios/rcll/agent/stories", ("skills.clp",))):
            rules = self.cover(folder)
            self.assertLessEqual(set(some), {file for file, _, _ in rules})

    def test_rules_that_never_matched_or_never_fired(self):
        self.write("r.clp", "(deftemplate lamp (slot state))\n(deffunction twice (?x) (* 2 ?x))\n(deffunction unused (?x) ?x)\n"
                            "(defrule first (declare (salience 1)) ?s <- (start) => (retract ?s))\n(defrule late\n  (start) => (assert (late)))\n"
                            "(defrule deaf (nothing) => (assert (heard (twice 2)))) (defrule deaf-too (nothing) => (assert (heard 3)))\n"
                            "(defrule loud (or (start) (bell) (lamp)) => (assert (loud)))")
        self.write("r.story.yaml", "- story: r\n  rules: r.clp\n  given: [(start), (bell)]\n  expect: [{fires: first, within_s: 1}]\n")
        self.assertEqual(self.cover(), {("r.clp", 4, "first"): (1, 1), ("r.clp", 5, "late"): (1, 0), ("r.clp", 7, "deaf"): (0, 0),
                                        ("r.clp", 7, "deaf-too"): (0, 0), ("r.clp", 8, "loud"): (2, 1)})
        self.assertEqual(self.functions_page("c.info", "r.clp"), {"first": 1, "late": 0, "deaf": 0, "deaf-too": 0, "loud": 1, "twice": 0, "unused": 0})

    def test_nothing_fires(self):
        self.write("r.clp", "(defrule deaf (nothing) => (assert (heard)))\n")
        self.write("r.story.yaml", "- story: r\n  rules: r.clp\n  expect: [{not_fires: deaf, within_s: 1}]\n")
        self.assertEqual(self.cover(), {("r.clp", 1, "deaf"): (0, 0)})

    def test_names_of_all_kinds(self):
        names = ["on,off", "it's", "a:8", "a", "ünï-✓", "$%{}\\@#", "x/y", "FN:1,x", "end_of_record", "1st", "a:2"]
        rules = "".join(f"(defrule {name} (start) => (assert (b)))\n" for name in names)
        self.write('a,b: "c" é.clp', rules)
        self.write("sub,dir: x/a.story.yaml", "- story: 'on, \"x\": y'\n  rules: '../a,b: \"c\" é.clp'\n  given: [(start)]\n  expect: [{fires: 'on,off', within_s: 1}]\n")
        self.assertEqual(self.cover(), {('a,b: "c" é.clp', line, name): (1, 1) for line, name in enumerate(names, 1)})
        self.assertEqual(self.functions_page("c.info", 'a,b: "c" é.clp'), dict.fromkeys(names, 1))

    def test_rules_of_one_name_in_several_modules(self):
        self.write("r.clp", "(defmodule MAIN (export ?ALL))\n(defrule go (start) => (printout t \"no end of line\") (assert (gone)))\n"
                            "(defmodule NAV (import MAIN ?ALL))\n(defrule NAV::go (start) => (assert (navigated)))\n"
                            "(defmodule EYE (import MAIN ?ALL))\n(defrule EYE::go (gone) => (assert (seen)))\n(defrule MAIN::look (gone) => (focus NAV))\n")
        self.write("r.story.yaml", "- story: r\n  rules: r.clp\n  given: [(start)]\n  expect: [{fires: go, within_s: 1}]\n")
        self.assertEqual(self.cover(), {("r.clp", 2, "go"): (1, 1), ("r.clp", 4, "NAV::go"): (1, 1), ("r.clp", 6, "EYE::go"): (1, 0), ("r.clp", 7, "look"): (1, 1)})

    def test_what_rules_print_counts_nothing(self):
        self.write("r.clp", '(defrule go (start) => (printout t "==> Activation 0      deaf: f-1" crlf) (unwatch all) (assert (gone)))\n'
                            "(defrule deaf (nothing) => (assert (heard)))\n(defrule after (gone) => (assert (x)))\n")
        self.write("r.story.yaml", "- story: r\n  rules: r.clp\n  given: [(start)]\n  expect: [{fires: go, within_s: 1}]\n")
        self.assertEqual(self.cover(), {("r.clp", 1, "go"): (1, 1), ("r.clp", 2, "deaf"): (0, 0), ("r.clp", 3, "after"): (1, 1)})

    def test_stories_in_several_files_share_their_rules(self):
        self.write("r.clp", "(defrule go (start ?n) => (assert (gone ?n)))\r\n\r\n(defrule back (gone ?) => (assert (back)))")
        self.write("a.story.yaml", "- story: one\n  rules: r.clp\n  given: [(start 1)]\n  expect: [{fires: go, within_s: 1}]\n- story: none\n  rules: ././r.clp\n  expect: [{not_fires: go, within_s: 1}]\n")
        self.write("deep/er/b.story.yaml", "- story: two\n  rules: ../../r.clp\n  given: [(start 1), (start 2)]\n  expect: [{fires: go, count: 2, within_s: 1}]\n")
        self.assertEqual(self.cover(), {("r.clp", 1, "go"): (3, 3), ("r.clp", 3, "back"): (3, 3)})

    def test_two_environments(self):
        self.write("agent.yaml", TWO_ENVIRONMENTS)
        self.write("rules/shared.clp", "(defrule go (start) => (assert (gone)))\n(deffacts here (here)) (defrule begun (here) => (assert (begun)))\n(defrule deaf (nothing) => (assert (heard)))\n")
        self.write("rules/more.clp", "(defrule more (begun) => (assert (more)))\n")
        self.write("a.story.yaml", "common: {config: agent.yaml, packages: {rules: rules}}\nstories:\n"
                                   "  - story: left\n    given: [(start)]\n    expect: [{fires: go, within_s: 1}]\n"
                                   "  - story: right\n    environment: right\n    given: [(start)]\n    expect: [{fires: more, within_s: 1}]\n")
        rules = self.cover()
        self.assertEqual(rules, {("shared.clp", 1, "go"): (2, 2), ("shared.clp", 2, "begun"): (4, 4), ("shared.clp", 3, "deaf"): (0, 0), ("more.clp", 1, "more"): (2, 2)})

    def test_a_story_that_fails_is_counted(self):
        self.write("r.clp", "(defrule go (start) => (assert (gone)))\n(defrule wrong (gone) => (/ 1 0))\n")
        self.write("r.story.yaml", "- story: r\n  rules: r.clp\n  given: [(start)]\n  expect: [{fires: go, within_s: 1}]\n")
        self.assertEqual(self.cover(code=1), {("r.clp", 1, "go"): (1, 1), ("r.clp", 2, "wrong"): (1, 1)})

    def test_counts_of_two_runs_are_added(self):
        self.write("r.clp", "(defrule go (start) => (assert (gone)))\n(defrule go-on (gone) => (assert (on)))\n(defrule deaf (nothing) => (assert (heard)))\n")
        self.write("a.story.yaml", "- story: a\n  rules: r.clp\n  given: [(start)]\n  expect: [{fires: go, within_s: 1}]\n")
        self.write("b.story.yaml", "- story: b\n  rules: r.clp\n  given: [(gone)]\n  expect: [{fires: go-on, within_s: 1}]\n")
        self.cover("a.story.yaml", name="a.info")
        self.cover("b.story.yaml", name="b.info")
        self.lcov("lcov", "--add-tracefile", "a.info", "--add-tracefile", "b.info", "--output-file", "sum.info")
        self.assertEqual(self.totals(self.lcov("lcov", "--summary", "sum.info")), {"lines": (2, 3), "functions": (2, 3), "branches": (4, 6)})
        self.lcov("genhtml", "sum.info", "-o", "sum.info.html")
        self.assertEqual(self.functions_page("sum.info", "r.clp"), {"go": 1, "go-on": 2, "deaf": 0})


if __name__ == "__main__":
    unittest.main()
