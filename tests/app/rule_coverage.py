"""cxlab coverage and cxlab test --coverage: what stories and runs reach of rules, conditions and functions."""

import html
import json
import os
import re
import shutil
import subprocess
import unittest
from html.parser import HTMLParser

from lab import CXLAB, SCENARIO, SOURCE, Lab, stopped_run

RULES = """(deffunction twice (?x) (* 2 ?x))
(deffunction unused () 0)
(defrule go
  (start ?x)
  (test (> (twice ?x) 2))
  => (assert (gone ?x)))
(defrule robbed (declare (salience -1)) (gone ?x) (not (tired)) => (assert (rest)))
(defrule thief"Takes what is gone." ?g <- (gone ?) => (retract ?g))
(defrule deaf
  (start ?x)
  (bell ?x) (door) => (assert (heard)))
"""


class Page(HTMLParser):
    """What a page asks for, and its texts by class."""

    def __init__(self, text):
        super().__init__()
        self.asks, self.marked, self.stack = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.asks += [values[key] for key in ("src", "href", "data", "action") if values.get(key) and not values[key].startswith("#")]
        if tag == "span":
            self.stack.append(values)

    def handle_endtag(self, tag):
        if tag == "span":
            self.stack.pop()

    def handle_data(self, data):
        if self.stack and self.stack[-1].get("title") and self.stack[-1].get("class") in ("hit", "half", "miss"):
            self.marked.append((self.stack[-1]["class"], data, self.stack[-1]["title"]))


class Coverage(Lab):
    def cxlab(self, *arguments, expect=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=200)
        self.assertEqual(done.returncode, expect, f"{arguments}\n{done.stdout[-3000:]}\n{done.stderr}")
        return done

    def story(self, given):
        self.write("r.clp", RULES)
        self.write("r.story.yaml", f"- {{story: r, rules: r.clp, given: [{given}], expect: [{{fires: go, within_s: 1}}]}}\n")

    def run_of(self, given, out):
        self.agent(RULES + f"(deffacts given {given})\n")
        done = subprocess.run([*self.command(), "--out", self.folder / out], cwd=self.folder, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_stories_say_where_conditions_fail(self):
        self.story("(start 1), (start 2), (bell 2)")
        said = self.cxlab("test", "--coverage", "c.info").stdout
        self.assertIn("r.clp:7: robbed: activated but never fired\n", said)
        self.assertIn("r.clp:9: deaf: never matched: nothing got past condition 3, (door)\n", said)
        self.assertIn("r.clp:2: unused: never called\n", said)
        self.assertIn("rules: 2 of 4 fired (50.0 %), conditions: 7 of 8 passed (87.5 %), functions: 1 of 2 called (50.0 %)\n", said)
        answer = json.loads(self.cxlab("test", "--json", "--coverage", "c.info").stdout)
        deaf = next(r for r in answer["rules"] if r["rule"] == "deaf")
        self.assertEqual([(c["line"], c["passed"]) for c in deaf["conditions"]], [(10, 2), (11, 1), (11, 0)])
        self.assertEqual(deaf["failed_at"], 2)
        go = next(r for r in answer["rules"] if r["rule"] == "go")
        self.assertEqual([c["passed"] for c in go["conditions"]], [2, 1])
        self.assertEqual({f["function"]: f["calls"] for f in answer["functions"]}, {"twice": 2, "unused": 0})
        text = (self.folder / "c.info").read_text()
        for line in ("DA:4,2", "DA:5,1", "DA:10,2", "DA:11,0", "DA:1,2", "DA:2,0", "FNDA:2,twice", "FNDA:0,unused"):
            self.assertIn(line + "\n", text)

    def test_one_way_of_an_or_is_enough_to_activate_a_rule(self):
        self.write("r.clp", "(defrule thief ?g <- (gone ?) => (retract ?g))\n(defrule either (declare (salience -1)) (or (bell ?x) (gone ?x)) => (assert (rest)))\n")
        self.write("r.story.yaml", "- {story: r, rules: r.clp, given: [(gone 1)], expect: [{fires: thief, within_s: 1}]}\n")
        self.assertIn("r.clp:2: either: activated but never fired\n", self.cxlab("test", "--coverage", "c.info").stdout)

    def test_too_few_rules_are_a_no(self):
        self.story("(start 2)")
        self.cxlab("test", "--fail-under", "50")
        done = self.cxlab("test", "--fail-under", "50.1", expect=1)
        self.assertIn("2 of 4 rules fired, 50.0 %; --fail-under expects at least 50.1 %", done.stderr)
        for command in (["test"], ["coverage", "."], ["mutate", "."]):
            for wrong in ("101", "-1", "nan", "abc", ""):
                self.assertIn(f"--fail-under: found {wrong!r}, expected a number from 0 to 100" if wrong else "--fail-under",
                              self.cxlab(*command, "--fail-under", wrong, expect=2).stderr)

    def test_a_page_shows_the_source(self):
        self.story("(start 1), (start 2)")
        self.cxlab("test", "--coverage-page", "c.html")
        text = (self.folder / "c.html").read_text()
        page = Page(text)
        self.assertEqual(page.asks, [], "it asks for nothing")
        self.assertNotRegex(text, r"https?:|@import|url\(")
        self.assertIn(("hit", "(test (> (twice ?x) 2))", "condition 2 of go: passed once"), page.marked)
        self.assertIn(("miss", "(bell ?x)", "condition 2 of deaf: passed 0 times"), page.marked)
        self.assertIn(("half", "robbed", "robbed: activated once, fired 0 times"), page.marked)
        self.assertIn(("miss", "unused", "unused: called 0 times"), page.marked)
        self.assertEqual([data for _, data, title in page.marked if title.startswith("condition ")],
                         ["(start ?x)", "(test (> (twice ?x) 2))", "(gone ?x)", "(not (tired))", "?g <- (gone ?)", "(start ?x)", "(bell ?x)", "(door)"])
        self.assertEqual([data for _, data, title in page.marked if re.search(r": (called|activated) ", title)],
                         ["twice", "unused", "go", "robbed", "thief", "deaf"])
        self.assertNotIn("0 of 0", text)
        (self.folder / "more.clp").write_text("(deffunction alone () 1)\n")
        story = next(self.folder.glob("*.story.yaml"))
        story.write_text(story.read_text().replace("rules: r.clp", "rules: [r.clp, more.clp]"))
        self.cxlab("test", "--coverage-page", "c.html")
        more = (self.folder / "c.html").read_text()
        self.assertIn("alone", more)
        self.assertNotIn("0 of 0", more, "a file without rules has no share of them")
        source = re.sub("<[^>]*>", "", text.split("<pre>")[1].split("</pre>")[0])
        for line in RULES.splitlines():
            self.assertIn(html.escape(line, quote=True), source)

    def test_runs_are_summed_up_and_agree_with_their_rules(self):
        self.run_of("(start 1) (start 2) (bell 2)", "runs/a")
        self.run_of("(start 2) (bell 2) (door)", "runs/deeper/b")
        one = json.loads(self.cxlab("coverage", "runs/a", "--json").stdout)
        used = json.loads(self.cxlab("rules", "runs/a", "--json").stdout)["environments"][0]["rules"]
        self.assertEqual({r["rule"]: (r["fired"], r["activated"]) for r in one["rules"]},
                         {r["rule"]: (r["fired"], r["activated"]) for r in used if r["place"] and "rules.clp" in r["place"]})
        (self.folder / "rules/rules.clp").unlink()
        both = self.cxlab("coverage", "runs", "--json", "--html", "c.html", "--lcov", "c.info", "-j", "2").stdout
        answer = json.loads(both)
        self.assertEqual(answer["runs"], 2)
        self.assertEqual({r["rule"]: r["fired"] for r in answer["rules"]}, {"go": 2, "robbed": 0, "thief": 2, "deaf": 1})
        self.assertEqual(both, self.cxlab("coverage", "runs/a", "runs/deeper/b", "--json").stdout, "in any way, and each time")
        source = re.sub("<[^>]*>", "", (self.folder / "c.html").read_text().split("<pre>")[1])
        self.assertIn("(bell ?x) (door) =&gt; (assert (heard)))", source, "the copy that the run keeps")
        self.assertEqual(both, self.cxlab("coverage", "runs", "--json").stdout, "it reads only the folders of the runs")

    def test_lcov_names_the_files_where_they_are(self):
        self.run_of("(start 2)", "runs/a")
        rules = (self.folder / "rules/rules.clp").resolve()

        def named(run):
            said = self.cxlab("coverage", run, "--lcov", "c.info").stderr
            return re.findall("^SF:(.*)$", (self.folder / "c.info").read_text(), re.M), said

        self.assertEqual(named("runs/a"), ([str(rules)], ""))
        if shutil.which("genhtml"):
            made = subprocess.run(["genhtml", "c.info", "-o", "html"], cwd=self.folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(made.returncode, 0, made.stdout)
        text = rules.read_text()
        rules.write_text("; new\n" + text)
        names, said = named("runs/a")
        self.assertEqual(names, [str(rules)])
        self.assertIn(f"note: the lcov counts are of lines as the run read them, but 1 file has changed since then: {rules}; --html", said)
        rules.write_text(text)
        moved = self.folder / "moved"
        moved.mkdir()
        for name in ("runs", "rules", "scenario.yaml"):
            (self.folder / name).rename(moved / name)
        self.assertEqual(named("moved/runs/a"), ([str(moved.resolve() / "rules/rules.clp")], ""), "a checkout may be moved with its runs")
        (moved / "rules/rules.clp").unlink()
        names, said = named("moved/runs/a")
        self.assertEqual(names, ["rules/rules.clp"])
        self.assertIn("note: the lcov counts name 1 file that genhtml will not find: rules/rules.clp; bring the package back", said)
        self.assertEqual(self.cxlab("coverage", "moved/runs/a", "--html", "c.html").stderr, "", "the page has the run's copies")

    def test_golden_runs_count(self):
        self.run_of("(start 2)", "runs/a")
        self.write("g.story.yaml", "- {story: as it went, golden: runs/a}\n- {story: its beginning, golden: runs/a, end: 1}\n")
        told = json.loads(self.cxlab("test", "g.story.yaml", "--json", "--fail-under", "50", "--coverage", "c.info").stdout)
        rules = json.loads(self.cxlab("coverage", "runs/a", "--json").stdout)["rules"]
        counts = {r["rule"]: 2 * r["fired"] for r in rules}
        self.assertEqual({r["rule"]: r["fired"] for r in told["rules"]}, counts)
        self.assertEqual({r["file"] for r in told["rules"]}, {str((self.folder / "rules/rules.clp").resolve())}, "as stories name it")
        self.assertEqual(counts["go"], 2)
        self.cxlab("test", "g.story.yaml", "--fail-under", "51", expect=1)
        self.write("s.story.yaml", "- {story: s, config: agent.yaml, packages: {rules: rules}, expect: [{fires: go, within_s: 1}]}\n")
        told = json.loads(self.cxlab("test", ".", "--json", "--fail-under", "50").stdout)
        self.assertEqual({r["rule"]: r["fired"] for r in told["rules"]}, {**counts, "go": 3, "thief": 3}, "each rule once")

    def test_nothing_is_no_percentage(self):
        self.write("t.clp", "(deftemplate t (slot a))\n")
        self.write("t.story.yaml", "- {story: t, rules: t.clp, end: 1, expect: [{no_fact: (t)}]}\n")
        done = self.cxlab("test", "--fail-under", "10", expect=1)
        self.assertIn("rules: 0 of 0 fired (-), conditions: 0 of 0 passed (-), functions: 0 of 0 called (-)\n", done.stdout)
        self.assertIn("error: --fail-under: no rule was read", done.stderr)
        told = json.loads(self.cxlab("test", "--coverage-page", "c.html", "--json").stdout)
        self.assertEqual(told["totals"]["rules"], {"covered": 0, "all": 0, "percent": None})

    def test_games_of_a_sweep_count_as_their_runs(self):
        for given, out in (("(start 2)", "runs/a"), ("(start 2)", "runs/b")):
            self.run_of(given, out)
        runs = json.loads(self.cxlab("coverage", "runs", "--json").stdout)
        self.write("suite.yaml", "scenarios: [scenario.yaml]\nseeds: [1, 2]\nstrategies: {one: []}\n")
        self.cxlab("bench", "suite.yaml", "--out", "sweep", "--quiet")
        before = sorted(str(path) for path in (self.folder / "sweep").rglob("*"))
        self.assertIn("if you trust them, add --trust-programs", self.cxlab("coverage", "sweep", expect=2).stderr)
        for more in ((), ("-j", "2")):
            games = json.loads(self.cxlab("coverage", "--trust-programs", "sweep", "--json", *more).stdout)
            self.assertEqual(games.pop("runs"), 2)
            self.assertEqual(games, {key: value for key, value in runs.items() if key != "runs"})
        self.assertEqual(json.loads(self.cxlab("coverage", "--trust-programs", "sweep", "runs/a", "--json").stdout)["runs"], 3)
        self.assertEqual(sorted(str(path) for path in (self.folder / "sweep").rglob("*")), before, "no run stays")
        self.cxlab("coverage", "--trust-programs", "sweep", "--html", "c.html")
        self.assertIn("Coverage of 2 runs", (self.folder / "c.html").read_text())
        rules = (self.folder / "rules/rules.clp")
        text = rules.read_text()
        rules.write_text(text.replace("(start 2)", "(start 3)"))
        self.assertEqual(self.cxlab("coverage", "--trust-programs", "sweep").stderr.count("the game goes otherwise now"), 2)

    def test_a_run_that_failed_counts_up_to_there_and_has_one_note(self):
        self.agent(RULES + "(deffacts given (start 2))\n(defrule wrong (start ?) => (+ 1 (nth$ 1 (create$ one))))\n")
        done = subprocess.run([*self.command(), "--out", self.folder / "runs/a"], cwd=self.folder, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 4, done.stderr)
        covered = self.cxlab("coverage", "runs", "--json")
        self.assertRegex(covered.stderr, r"\Anote: the run failed at 0\.000 s: [^\n]*\n\Z")
        self.assertEqual(next(rule["fired"] for rule in json.loads(covered.stdout)["rules"] if rule["rule"] == "wrong"), 1)

    def test_a_run_that_is_played_or_was_killed_counts_up_to_the_end_of_its_log(self):
        self.agent(RULES + "(defrule tick (time ?) => (twice 1))\n(defrule end (executive-finalize) => (twice 1))\n(deffacts given (start 2))\n",
                   SCENARIO.replace("duration_s: 2", "duration_s: 60"))
        run = stopped_run(self, "scenario.yaml", out="runs/a", cwd=self.folder)
        self.cxlab("attach", "runs/a", "-c", "until 5", "-c", "where")
        for ends in (lambda: None, run.kill, run.wait):
            ends()
            covered = self.cxlab("coverage", "runs", "--json", "--lcov", "c.info")
            rules = json.loads(covered.stdout)["rules"]
            used = json.loads(self.cxlab("rules", "runs/a", "--json").stdout)
            self.assertEqual({r["rule"]: (r["fired"], r["activated"]) for r in rules},
                             {r["rule"]: (r["fired"], r["activated"]) for r in used["environments"][0]["rules"] if "rules.clp" in (r["place"] or "")})
            counts = {r["rule"]: r["fired"] for r in rules}
            self.assertGreater(counts["tick"], 10)
            self.assertEqual((counts["go"], counts["end"]), (1, 0), "its agent was not deactivated")
            self.assertIn(f"FNDA:{counts['tick']},tick\n", (self.folder / "c.info").read_text())
            self.assertEqual(covered.stderr.replace("note: the run has not ended", ""), f"note: runs/a: its log ends at {used['at_s']:g} s\n")
        self.cxlab("coverage", "runs", "--fail-under", "50")

    def test_a_run_without_a_tick_is_left_out_with_a_note(self):
        self.run_of("(start 2)", "runs/a")
        alone = self.cxlab("coverage", "runs", "--json").stdout
        shutil.copytree(self.folder / "runs/a", self.folder / "runs/b")
        (self.folder / "runs/b/inputs.bin").write_bytes((self.folder / "runs/a/inputs.bin").read_bytes()[:8])
        covered = self.cxlab("coverage", "runs", "--json")
        self.assertEqual(covered.stdout, alone)
        self.assertRegex(covered.stderr, r"note: left out: runs/b: [^\n]*the log of its inputs")
        self.assertIn("the log of its inputs", self.cxlab("coverage", "runs/b", expect=3).stderr)
        shutil.copytree(self.folder / "runs/b", self.folder / "runs/a", dirs_exist_ok=True)
        self.assertIn("no run can be played; left out: runs/a", self.cxlab("coverage", "runs", expect=3).stderr)

    def test_what_is_no_run_is_an_error(self):
        self.folder.joinpath("empty").mkdir()
        self.assertIn("expected the folder of a run", self.cxlab("coverage", "empty", expect=3).stderr)
        self.assertIn("there is no such folder", self.cxlab("coverage", "nowhere", expect=3).stderr)
        self.run_of("(start 2)", "runs/a")
        self.cxlab("coverage", "runs", "--html", "pages/new/c.html")
        self.assertTrue((self.folder / "pages/new/c.html").exists())
        self.assertIn("/proc/none: the folder cannot be made", self.cxlab("coverage", "runs", "--html", "/proc/none/c.html", expect=5).stderr)


if __name__ == "__main__":
    unittest.main()
