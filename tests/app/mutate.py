"""cxlab mutate on a small agent of which a person can say which mutants live."""

import hashlib
import json
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])

RULES = """(deftemplate door (slot name) (slot state (default CLOSED) (allowed-symbols CLOSED LOCKED OPEN)))
(defglobal ?*PATIENCE* = 5)
(defrule open "A bell rings at a closed door: open it."
  ?b <- (bell ?name)
  ?d <- (door (name ?name) (state CLOSED))
  =>
  (retract ?b)
  (modify ?d (state OPEN)))
(defrule never "No story has a storm."
  (storm)
  =>
  (assert (alarm)))
"""
STORIES = """common:
  rules: [../door.clp]
  given: ['(door (name A))']
stories:
  - story: a bell opens the door
    steps: [{at: 1, assert: (bell A)}]
    expect: [{fact: '(door (name A) (state OPEN))', within_s: 2}, {no_fact: '(bell ?)', after: 1.5}]
  - story: the door of another bell stays closed
    steps: [{at: 1, assert: (bell B)}]
    expect: [{fact: '(door (name A) (state CLOSED))', at: 3}]
"""


def cxlab(*arguments, cwd, timeout=100):
    return subprocess.run([CXLAB, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=timeout)


class Mutate(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "agent/stories").mkdir(parents=True)
        self.write(RULES, STORIES)

    def write(self, rules, stories=STORIES):
        (self.folder / "agent/door.clp").write_text(rules)
        (self.folder / "agent/stories/door.story.yaml").write_text(stories)
        (self.folder / "agent/package.xml").write_text("<package><name>doors</name></package>")

    def mutate(self, *arguments):
        return cxlab("mutate", "agent", *arguments, cwd=self.folder)

    def report(self, *arguments, code=0):
        done = self.mutate("--json", *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        return json.loads(done.stdout)

    def fates(self, report):
        return {(row["before"], row["after"]): row["verdict"] for row in report["results"]}

    def test_the_mutants_that_live_are_those_that_no_story_asks_for(self):
        report = self.report("--all")
        living = {change for change, fate in self.fates(report).items() if fate == "survived"}
        self.assertEqual(living, {
            ("?*PATIENCE* = 5", "?*PATIENCE* = 6"),                          # nothing reads it
            ("(storm)", "(not (storm))"), ("(storm)", ""), ("(assert (alarm))", ""),  # no story has a storm
            ("(door (name ?name) (state CLOSED))", "(door (name ?name))"),   # no door is locked or open
        })
        self.assertEqual(report["killed"] + report["survived"], report["mutants"])
        self.assertEqual(report["score"], report["killed"] / report["mutants"])
        self.assertNotIn("interval_95", report)
        rows = {(row["before"], row["after"]): row for row in report["results"]}
        row = rows[("(door (name ?name) (state CLOSED))", "(door (name ?name))")]
        self.assertEqual((row["file"], row["line"], row["construct"], row["change"]), ("agent/door.clp", 5, "defrule open", "constraint"))
        self.assertEqual(row["reached_by"], ["agent/stories/door.story.yaml::a bell opens the door"])
        self.assertEqual(rows[("(assert (alarm))", "")]["reached_by"], [])
        row = rows[("(modify ?d (state OPEN))", "")]
        self.assertEqual((row["verdict"], row["killed_by"]), ("killed", "agent/stories/door.story.yaml::a bell opens the door"))
        self.assertIn("expected fact", row["failure"])

    def test_verdicts_are_those_of_stories_that_are_played_alone(self):
        """Each mutant as a file of its own, played by `cxlab test`: agents that are loaded once for all stories play as such."""
        original = (self.folder / "agent/door.clp").read_text()
        rows = self.report("--all")["results"]
        for row, diff in [(row, self.mutate("--show", row["id"]).stdout.splitlines()) for row in rows]:
            first, count = map(int, re.match(r"@@ -(\d+),(\d+) ", diff[2]).groups())
            lines = original.splitlines()
            lines[first - 1:first - 1 + count] = [line[1:] for line in diff[3:] if line[0] in " +"]
            (self.folder / "agent/door.clp").write_text("\n".join(lines) + "\n")
            done = cxlab("test", "agent", "-q", cwd=self.folder)
            self.assertEqual(done.returncode, 0 if row["verdict"] == "survived" else 1, (row, done.stdout))

    def test_what_does_not_load_is_no_mutant(self):
        """Without its first condition, ?b and ?name of `open` are not bound."""
        report = self.report("--all")
        self.assertNotIn(("?b <- (bell ?name)", ""), self.fates(report))
        self.assertGreater(report["not_loaded"], 0)
        self.assertEqual(report["mutants"] + report["not_loaded"], report["possible"])

    def test_one_change_does_not_count(self):
        """Without its one condition, ?b is not bound."""
        self.write("(defrule ring ?b <- (bell 1) => (retract ?b) (assert (rung 1)))\n", "- {story: s, rules: ../door.clp, given: [(bell 1)], expect: [{fact: (rung 1), within_s: 1}]}\n")
        self.assertIn("; 1 change did not load and does not count\n", self.mutate("--all").stdout)

    def test_a_sample_is_that_of_its_seed_whatever_the_number_of_processes_is(self):
        one, two = (self.report("--mutants", 6, "--seed", 3, "-j", jobs) for jobs in (1, 3))
        self.assertEqual(one, two)
        self.assertEqual(one["mutants"], 6)
        low, high = one["interval_95"]
        self.assertTrue(low < one["score"] < high)
        others = [self.report("--mutants", 6, "--seed", seed)["results"] for seed in (4, 5)]
        self.assertTrue(any(rows != one["results"] for rows in others))
        everything = self.fates(self.report("--all"))
        for change, fate in self.fates(one).items():
            self.assertEqual(everything[change], fate)

    def test_what_is_listed_and_shown_plays_no_story(self):
        self.write(RULES, STORIES.replace("within_s: 2", "within_s: 0.5"))
        self.assertIn("fails without any change", self.mutate("--mutants", 1).stderr)
        rows = self.report("--list")
        self.assertEqual(self.mutate("--show", rows[0]["id"]).returncode, 0)
        self.write(RULES)
        self.assertEqual(self.report("--list"), rows, "the same as with stories that pass")
        self.assertEqual(len(rows), self.report("--mutants", 1)["possible"])

    def test_quiet_says_nothing(self):
        done = self.mutate("--mutants", 1, "-q", "-k", "'opens the door'")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("1 story passes in ", self.mutate("--mutants", 1, "-k", "'opens the door'").stderr)

    def test_no_file_is_changed(self):
        def state():
            return {file: (hashlib.sha256(file.read_bytes()).hexdigest(), file.stat().st_mtime_ns)
                    for file in sorted(self.folder.rglob("*")) if file.is_file()}
        before = state()
        self.mutate("--all", "-j", 2)
        self.assertEqual(state(), before)

    def test_a_person_reads_survivors_and_the_score(self):
        done = self.mutate("--all")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"SURVIVED  [0-9a-f]{8}  agent/door.clp:10: never: without \(storm\)\n  no story fires it\n")
        self.assertRegex(done.stdout, r"\nscore \d+\.\d %\n$")
        self.assertIn("2 stories pass in ", done.stderr)
        self.assertNotIn("killed    ", done.stdout)
        self.assertRegex(self.mutate("--all", "-v").stdout, r"killed    [0-9a-f]{8}  agent/door.clp:8: open: without \(modify \?d \(state OPEN\)\)\n  agent/stories/door.story.yaml:7: expected fact")

    def test_one_mutant_is_shown_and_played_again(self):
        rows = {(row["before"], row["after"]): row["id"] for row in self.report("--list")}
        killed, living = rows[("(retract ?b)", "")], rows[("(assert (alarm))", "")]
        self.assertEqual(self.mutate("--show", killed).stdout.splitlines()[:2], ["--- door.clp", "+++ door.clp"])
        self.assertIn("\n-  (retract ?b)\n+  \n", self.mutate("--show", killed).stdout)
        done = self.mutate("--mutant", killed)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("FAILED  agent/stories/door.story.yaml: a bell opens the door\n", done.stdout)
        self.assertTrue(done.stdout.endswith("killed by 1 of 1 stories\n"), done.stdout)
        done = self.mutate("--mutant", living)
        self.assertEqual((done.returncode, done.stdout.splitlines()[-1]), (1, "survived: the only story that can notice it passes; no story fires it"))
        self.assertIn("there is no mutant 'abc'", self.mutate("--show", "abc").stderr)
        (not_loaded,) = [rows[change] for change in rows if change == ("?b <- (bell ?name)", "")]
        done = self.mutate("--mutant", not_loaded)
        self.assertEqual(done.returncode, 3)
        self.assertIn("door.clp", done.stderr)

    def test_an_id_is_the_same_whatever_agent_names(self):
        """Also without a package: for the folder, for a folder or file of stories, and for one story."""
        for package in (True, False):
            if not package:
                (self.folder / "agent/package.xml").unlink()
            ids = [{(row["line"], row["before"], row["after"]): row["id"] for row in json.loads(cxlab("mutate", agent, "--list", "--json", cwd=self.folder).stdout)}
                   for agent in ("agent", "agent/stories", "agent/stories/door.story.yaml", "agent/stories/door.story.yaml::a bell opens the door")]
            for other in ids[1:]:
                self.assertEqual(other, ids[0])
            one = ids[0][(7, "(retract ?b)", "")]
            shown = [cxlab("mutate", agent, "--show", one, cwd=self.folder) for agent in ("agent", "agent/stories")]
            self.assertEqual([done.stdout.splitlines()[0] for done in shown], ["--- door.clp"] * 2)
        self.assertEqual(cxlab("mutate", "door.story.yaml", "--show", one, cwd=self.folder / "agent/stories").stdout, shown[0].stdout)

    def test_fail_under(self):
        score = 100 * self.report("--all")["score"]
        self.assertEqual(self.report("--all", "--fail-under", score - 1)["score"], score / 100)
        done = self.mutate("--all", "--fail-under", score + 1)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"error: the score is .* %, expected at least .* % \(--fail-under\)")

    def test_skipped_lines_are_not_changed(self):
        self.write(RULES.replace("(defrule never", "; mutate: skip - a fault that no test makes\n(defrule never"))
        self.assertFalse([row for row in self.report("--list") if row["construct"] == "defrule never"])

    def test_k_and_file_choose(self):
        (self.folder / "agent/other.clp").write_text("(defrule other (bell ?) => (assert (rung)))\n")
        self.write(RULES, STORIES.replace("[../door.clp]", "[../door.clp, ../other.clp]"))
        files = {row["file"] for row in self.report("--list", "--file", "agent/other.clp")}
        self.assertEqual(files, {"agent/other.clp"})
        report = self.report("--all", "-k", "another")
        self.assertEqual(report["stories"], 1)
        self.assertEqual(self.fates(report)[("(modify ?d (state OPEN))", "")], "survived")

    def test_rules_that_hang_time_out(self):
        rules = RULES + "(deffunction wait (?n) (bind ?i 0) (while (< ?i ?n) do (explode$ \"a b c d e f g h i j k l m n o p q r s t\") (bind ?i (+ ?i 1))) ?i)\n(defrule w (bell ?) => (wait 3))\n"
        self.write(rules)
        done = cxlab("mutate", "agent", "--all", "--json", "--steps", 0, "--patience", 1, "-j", 2, cwd=self.folder)
        report = json.loads(done.stdout)
        late = {change for change, fate in self.fates(report).items() if fate == "timed out"}
        self.assertIn(("(bind ?i (+ ?i 1))", ""), late)
        self.assertEqual(report["timed_out"], len(late))
        self.assertEqual(report["killed"] + report["timed_out"] + report["survived"], report["mutants"])

    def test_files_that_rules_load_themselves_are_changed_too(self):
        """A batch file that loads the others, found in a package."""
        (self.folder / "agent/all.clp").write_text('(load* (str-cat (ament-index-get-package-share-directory "doors") "/door.clp"))\n')
        (self.folder / "agent/agent.yaml").write_text("""/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["ament", "executive", "files"]}
    ament: {plugin: "cx::AmentIndexPlugin"}
    executive: {plugin: "cx::ExecutivePlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["doors"], batch: ["all.clp"]}
""")
        self.write(RULES, STORIES.replace("rules: [../door.clp]", "config: ../agent.yaml\n  packages: {doors: ..}"))
        for agent in ("agent", "agent/agent.yaml"):
            done = cxlab("mutate", agent, "--all", "--json", cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(self.fates(json.loads(done.stdout))[("(modify ?d (state OPEN))", "")], "killed")

    def test_wrong_inputs(self):
        self.write(RULES, STORIES.replace("state OPEN", "state LOCKED"))
        done = self.mutate()
        self.assertEqual(done.returncode, 1)
        self.assertIn("the story 'a bell opens the door' fails without any change", done.stderr)
        self.write("(defrule broken (a) =>", STORIES)
        self.assertEqual(self.mutate().returncode, 3)
        self.write("(deffacts f (a))\n(deftemplate door (slot name) (slot state (default CLOSED)))\n(defrule r (declare (salience 0)) => (printout t 1 crlf))\n",
                   "- {story: s, rules: ../door.clp, expect: [{fires: r, within_s: 1}]}")
        done = self.mutate()
        self.assertEqual(done.returncode, 3)
        self.assertIn("have nothing to change", done.stderr)
        for arguments, code, text in ((["nowhere"], 3, "nowhere"), (["agent", "-k", "window"], 2, "-k 'window'"),
                                      (["agent", "--mutants", "0"], 2, "--mutants"), (["agent", "--fail-under", "101"], 2, "--fail-under"),
                                      (["agent", "--all", "--mutants", "3"], 2, "--mutants"), (["agent", "--file", "x.clp"], 2, "--file"), ([], 2, "agent")):
            self.write(RULES)
            done = cxlab("mutate", *arguments, cwd=self.folder)
            self.assertEqual(done.returncode, code, (arguments, done.stderr))
            self.assertIn(text, done.stderr)

    def test_ctrl_c_keeps_what_was_finished(self):
        stories = STORIES + "".join(f"  - story: again {i}\n    steps: [{{at: 1, assert: (bell A)}}]\n    expect: [{{fact: '(door (name A))', within_s: 2}}]\n" for i in range(400))
        self.write(RULES, stories)
        process = subprocess.Popen([CXLAB, "mutate", "agent", "--all", "--json"], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while "possible changes" not in (line := process.stderr.readline()):
            self.assertTrue(line, "it ended before mutants were played")
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, err)
        self.assertRegex(err, r"interrupted: by SIGINT; \d+ of \d+ mutants? (was|were) played")
        report = json.loads(out)
        self.assertEqual(len(report["results"]), report["mutants"])
        self.assertLess(report["mutants"], report["wanted"])

    def test_the_time_limit_ends_the_draw(self):
        done = self.mutate("--all", "--json", "--time-limit", "0.01")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads(done.stdout)
        self.assertLess(report["mutants"], report["possible"])
        self.assertRegex(done.stderr, r"note: \d+ of \d+ mutants? (was|were) played before the time limit")


if __name__ == "__main__":
    unittest.main()
