"""cxlab test, bench and new, as people call them."""

import csv
import json
import os
import pathlib
import re
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

    def test_coverage_has_a_state_for_each_rule(self):
        (self.folder / "b.clp").write_text("(defrule first (declare (salience 1)) ?s <- (start) => (retract ?s))\n"
                                           "(defrule late (start) => (assert (late)))\n(defrule deaf (nothing) => (assert (heard)))\n")
        (self.folder / "b.story.yaml").write_text("- story: b\n  rules: b.clp\n  given: [(start)]\n  expect: [{fires: first, within_s: 1}]\n")
        for more in [], ["-j", "2"]:
            done = cxlab("test", "--coverage", "c.info", *more, cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("b.clp:2: late: activated but never fired\n", done.stdout)
            self.assertIn("b.clp:3: deaf: never matched\n", done.stdout)
            self.assertIn("rules: 1 fired, 1 activated but never fired, 1 never matched\n", done.stdout)
            self.assertIn("BRDA:2,0,0,1\nBRDA:2,0,1,0\n", (self.folder / "c.info").read_text())
        rules = json.loads(cxlab("test", "--json", "--coverage", "c.info", cwd=self.folder).stdout)["rules"]
        self.assertEqual([(r["rule"], r["state"]) for r in rules],
                         [("first", "fired"), ("late", "activated but never fired"), ("deaf", "never matched")])

    def test_a_failure_is_exit_1_with_line_also_in_processes(self):
        self.story("not_fires: go")
        for more in [], ["-j", "3"]:
            done = cxlab("test", *more, "--junit", "j.xml", cwd=self.folder)
            self.assertEqual(done.returncode, 1)
            self.assertIn("a.story.yaml:4: expected that rule go does not fire", done.stdout)
            self.assertEqual(xml.etree.ElementTree.parse(self.folder / "j.xml").getroot().get("failures"), "1")

    def test_a_bad_story_is_exit_3(self):
        self.story("not_fire: go")
        done = cxlab("test", cwd=self.folder)
        self.assertEqual(done.returncode, 3)
        self.assertIn("did you mean 'not_fires'?", done.stderr)

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
        kept, *failed, played = again.stderr.splitlines()
        self.assertEqual(kept, "5 rows are current and kept")
        self.assertEqual([line.split(":")[:2] for line in failed], [["kept", f" empty broken seed {seed}"] for seed in (1, 2)])
        self.assertTrue(played.startswith("[6/6] empty long seed 2: completed, exit 0"), played)
        self.assertEqual([s["points"]["n"] for s in json.loads(again.stdout)], [2, 2, 0])

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
