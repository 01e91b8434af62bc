"""Which stories cxlab test plays, what it says of them, and what one that fails leaves."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import xml.etree.ElementTree

from lab import CONFIG, CXLAB, SCENARIO, SOURCE, stopped_run

DOOR = """(defrule open (bell) => (printout t "it opens" crlf) (assert (door OPEN)))
(defrule slam (wind) => (assert (door SHUT)))
"""


class Stories(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment = {**os.environ, "HOME": str(self.folder / "home")}
        self.environment.pop("XDG_STATE_HOME", None)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def story(self, name, given, expect, more=""):
        return f"- story: {name}\n  rules: door.clp\n  given: [{given}]\n{more}  expect: [{{{expect}}}]\n"

    def doors(self):
        """Two files with four stories; two stories pass."""
        self.write("door.clp", DOOR)
        self.write("bell.story.yaml", self.story("a bell opens", "(bell)", "fires: open, within_s: 1")
                   + self.story("a bell shuts", "(bell)", "fact: (door SHUT), within_s: 1"))
        self.write("sub/wind.story.yaml", self.story("a wind shuts", "(wind)", "fires: slam, within_s: 1").replace("door.clp", "../door.clp")
                   + self.story("a wind opens it's \"door\"", "(wind)", "fact: (door OPEN), within_s: 1").replace("door.clp", "../door.clp"))

    def cxlab(self, *arguments, **more):
        return subprocess.run([CXLAB, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=100, env=self.environment, **more)

    def played(self, *arguments, code=1):
        """Names of the stories, and whether they passed."""
        done = self.cxlab("test", "--json", *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        return {story["story"]: story["passed"] for story in json.loads(done.stdout)["stories"]}


class Choosing(Stories):
    def setUp(self):
        super().setUp()
        self.doors()
        self.odd = "a wind opens it's \"door\""

    def test_words_choose_stories(self):
        for words, chosen in (("bell", ["a bell opens", "a bell shuts"]), ("bell.story and not shuts", ["a bell opens"]),
                              ("'wind opens' or 'BELL opens'", ["a bell opens", self.odd]), ("not (bell or shuts)", [self.odd])):
            self.assertEqual(list(self.played("-k", words, code=0 if chosen == ["a bell opens"] else 1)), chosen, words)
        for words, said in (("horn", "-k 'horn': it holds for none of 4 stories"), ("bell shuts", "found shuts at column 6, expected `and` or `or`")):
            done = self.cxlab("test", "-k", words)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertIn(said, done.stderr)

    def test_the_folder_is_no_part_of_the_name(self):
        self.assertEqual(self.cxlab("test", "-k", self.folder.name).returncode, 2)

    def test_one_story_is_named_with_its_file(self):
        self.assertEqual(self.played("bell.story.yaml::a bell opens", code=0), {"a bell opens": True})
        self.assertEqual(self.played("bell.story.yaml::a bell shuts", "sub"), {"a bell shuts": False, "a wind shuts": True, self.odd: False})
        done = self.cxlab("test", "bell.story.yaml::a bel opens")
        self.assertEqual(done.returncode, 2)
        self.assertIn("there is no story 'a bel opens', did you mean 'a bell opens'?", done.stderr)

    def test_the_first_failure_ends_it(self):
        for jobs in (1, 3):
            done = self.cxlab("test", "-x", "-j", jobs)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(done.stdout.splitlines()[-1], "1 passed, 1 failed, 2 not played")
            self.assertNotIn("wind", done.stdout)
        report = json.loads(self.cxlab("test", "-x", "--json", "--junit", "new/reports/j.xml").stdout)
        self.assertEqual((len(report["stories"]), report["not_played"]), (2, 2))
        self.assertEqual(xml.etree.ElementTree.parse(self.folder / "new/reports/j.xml").getroot().get("tests"), "2")

    def test_those_that_failed_are_played_again(self):
        both = {"a bell shuts": False, self.odd: False}
        done = self.cxlab("test", "--last-failed")
        self.assertIn("nothing of this failed the last time: all is played\n", done.stderr)
        self.assertEqual(self.played("--last-failed"), both)
        self.assertEqual(self.played("--lf", "-k", "bell"), {"a bell shuts": False})
        self.assertEqual(self.played("--lf"), both, "what was not played stays")
        self.write("door.clp", DOOR.replace("=> (assert (door SHUT))", "=> (assert (door OPEN))"))
        self.assertEqual(self.played("--lf"), {"a bell shuts": False, self.odd: True})
        self.assertEqual(self.played("--lf", self.folder), {"a bell shuts": False})
        memory = self.folder / "home/.local/state/cxlab/failed_stories.json"
        self.assertEqual(json.loads(memory.read_text()), {"failed": [{"file": str((self.folder / "bell.story.yaml").resolve()), "story": "a bell shuts"}]})
        memory.write_text("[")
        self.assertEqual(len(self.played("--lf")), 4, "a memory that cannot be read is none")
        self.environment["XDG_STATE_HOME"] = str(self.folder / "state")
        self.played()
        self.assertTrue((self.folder / "state/cxlab/failed_stories.json").is_file())
        self.assertEqual({path.name for path in self.folder.iterdir()}, {"door.clp", "bell.story.yaml", "sub", "home", "state"}, "nothing beside the stories")

    def test_what_the_agent_printed(self):
        done = self.cxlab("test", "-k", "bell", "-v", "--junit", "j.xml")
        self.assertEqual(done.stdout.count("    [0.000] [main] it opens\n"), 2, done.stdout)
        cases = xml.etree.ElementTree.parse(self.folder / "j.xml").getroot().findall("testcase")
        self.assertEqual(["[0.000] [main] it opens" in case.find("system-out").text for case in cases], [True, True])
        self.assertNotIn("it opens", self.cxlab("test", "-k", "bell").stdout)
        self.assertIn("[0.000] [main] it opens", json.loads(self.cxlab("test", "-k", "bell", "-v", "--json").stdout)["stories"][0]["printed"])
        quiet = self.cxlab("test", "-q").stdout
        self.assertNotIn("ok", quiet)
        self.assertEqual(quiet.count("FAILED"), 2)
        self.assertEqual(self.cxlab("test", "-q", "-v").returncode, 2)

    def test_the_command_that_repeats_a_failure_plays_it_alone(self):
        for story in json.loads(self.cxlab("test", "--json").stdout)["stories"]:
            done = subprocess.run(story["again"].replace("cxlab", CXLAB, 1), shell=True, cwd=self.folder, capture_output=True, text=True, env=self.environment)
            self.assertEqual(done.returncode, 0 if story["passed"] else 1, done.stderr)
            self.assertIn(f'{story["file"]}: {story["story"]} (', done.stdout)
            self.assertEqual(done.stdout.count("simulated"), 1)
            self.assertEqual(f'  seed 1; again: {story["again"]}\n' in done.stdout, not story["passed"])

    def test_the_command_has_what_changed_the_result(self):
        self.write("many.clp", "(defrule count ?n <- (n ?x&:(< ?x 900)) => (retract ?n) (assert (n (+ ?x 1))))\n")
        self.write("many.story.yaml", self.story("many", "(n 0)", "fact: (n 900), within_s: 1").replace("door.clp", "many.clp"))
        self.assertEqual(self.played("many.story.yaml", code=0), {"many": True})
        done = self.cxlab("test", "many.story.yaml", "--memory", "1MB")
        self.assertEqual(done.returncode, 1, "a limit that the story exceeds is no mistake of its file")
        self.assertRegex(done.stdout, "rules hold more than 1 MB of memory.*\n  seed 1; again: ")
        done = self.cxlab("test", "many.story.yaml", "--steps", "100", "--memory", "500MB", "--disk", "0", "--patience", "30", "-j", "2", "-q")
        self.assertEqual(done.returncode, 1, done.stdout)
        again = re.search("again: (.*)", done.stdout)[1]
        self.assertEqual(again, "cxlab test many.story.yaml::many --memory 500000000 --disk 0 --steps 100 --patience 30")
        self.assertEqual(self.cxlab(*again.split()[1:]).returncode, 1)


class Failing(Stories):
    """What a story that fails leaves, and that the others do not notice."""

    def ask(self, *arguments, code=0):
        done = self.cxlab(*arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout

    def test_its_run_can_be_asked(self):
        self.doors()
        done = self.cxlab("test", "--keep-runs", "runs")
        self.assertIn("  run runs/bell-a-bell-shuts; ask it: cxlab attach runs/bell-a-bell-shuts, cxlab why-not runs/bell-a-bell-shuts RULE\n", done.stdout)
        self.assertEqual(sorted(p.name for p in (self.folder / "runs").iterdir()), ["bell-a-bell-shuts", "wind-a-wind-opens-it-s-door"])
        run = "runs/bell-a-bell-shuts"
        self.assertIn("(door OPEN)", self.ask("facts", run))
        self.assertIn("condition 1 does not hold: (wind)", self.ask("why-not", run, "slam"))
        self.assertIn("bell", self.ask("why", run, "open"))
        self.assertIn("open", self.ask("attach", run, "-c", "back-until open"))
        self.assertIn("the same up to", self.ask("replay", run))
        self.assertIn("the story, at 0.000 s: (bell)", self.ask("why", run, "(bell)"))
        self.assertIn("asserted at 0.000 s by the story: (bell)", self.ask("facts", run, "bell"))
        self.assertIn("the same:", self.ask("rerun", run, "--out", "again"))
        self.assertIn("is the same", self.ask("diff", run, "again"))
        rows = json.loads(self.cxlab("test", "--keep-runs", "runs", "--json").stdout)["stories"]
        self.assertEqual([row.get("run") for row in rows], [None, run, None, "runs/wind-a-wind-opens-it-s-door"], "that of before is replaced")

    def test_the_run_of_each_story_has_its_folder(self):
        """Whatever other stories have its name, and whichever of them are played."""
        self.write("door.clp", DOOR)
        for folder in ("d1", "d2"):
            self.write(f"{folder}/a.story.yaml", self.story("x y", "(bell)", "fires: slam, within_s: 1").replace("door.clp", "../door.clp")
                       + self.story("門", "(bell)", "fires: slam, within_s: 1").replace("door.clp", "../door.clp"))

        def kept(*arguments):
            rows = json.loads(self.cxlab("test", "--keep-runs", "k", "--json", *arguments).stdout)["stories"]
            for row in rows:
                world = (self.folder / row["run"] / "story/scenario.yaml").read_text()
                self.assertIn(row["file"], world)
                self.assertIn(row["story"], world)
            return [row["run"] for row in rows], sorted(path.name for path in (self.folder / "k").iterdir())

        runs, folders = kept()
        self.assertEqual(sorted(f"k/{name}" for name in folders), sorted(runs))
        self.assertEqual(len(set(runs)), 4)
        for run, name in zip(runs, ("a-x-y", "a", "a-x-y", "a")):
            self.assertRegex(run, f"^k/{name}-[0-9a-f]{{8}}$")
        self.assertEqual(kept("-j", "3"), (runs, folders), "each replaces its own")
        self.assertEqual(kept("d2", "-k", "x")[0], ["k/a-x-y"], "alone with its name")
        self.assertEqual(kept("d1", "-k", "x")[0], [runs[0]], "the name is taken")
        self.assertEqual(len(kept("d1", "-k", "x")[1]), 4, "no story has two")
        self.assertEqual(kept(), (runs, folders))

    def test_the_run_of_a_golden_run_has_one_folder(self):
        self.write("agent.yaml", CONFIG)
        self.write("rules/rules.clp", DOOR + "(deffacts start (bell))\n")
        self.write("scenario.yaml", SCENARIO)
        self.ask("run", "scenario.yaml", "--out", "golden", "--quiet")
        self.write("golden.story.yaml", "- {story: as it went, golden: golden}\n")
        self.write("rules/rules.clp", DOOR)
        for _ in range(2):
            self.assertEqual(self.cxlab("test", "--keep-runs", "k").returncode, 1)
            self.assertEqual([path.name for path in (self.folder / "k").iterdir()], ["golden-as-it-went"])

    def test_the_run_is_the_story(self):
        """The same lines at the same times, with messages, skills and facts at several times."""
        self.write("errand.clp", """(deftemplate errand (slot to) (slot state (default NEW)))
(defrule begin (declare (salience 10)) (start) => (ros-msgs-create-action-client "/go" "cxlab_skills/action/DriveTo") (ros-msgs-create-subscription "/bell" "std_msgs/msg/String"))
(defrule send ?e <- (errand (state NEW) (to ?to)) (time ?) =>
  (bind ?goal (ros-msgs-create-goal-request "cxlab_skills/action/DriveTo"))
  (ros-msgs-set-field ?goal "target" ?to) (ros-msgs-async-send-goal ?goal "/go") (modify ?e (state SENT)) (printout t "send " ?to " " (random 1 1000) crlf))
(defrule done ?e <- (errand (state SENT)) ?r <- (ros-msgs-wrapped-result (code ?code)) => (retract ?r) (modify ?e (state ?code)) (printout t ?code crlf))
(defrule heard ?m <- (ros-msgs-message (msg-ptr ?ptr)) => (printout t (ros-msgs-get-field ?ptr "data") crlf) (ros-msgs-destroy-message ?ptr) (retract ?m) (assert (errand (to BELL))))
(defrule nothing (never) =>)
""")
        self.write("errand.story.yaml", """- story: errands
  rules: errand.clp
  seeds: "1..4"
  given: [(start), (errand (to A))]
  skills: [{action: /go, type: cxlab_skills/action/DriveTo, outcome: fail, takes_s: [1, 3], then: [{outcome: succeed, takes_s: 0.5}]}]
  faults: [{outcome: fail, probability: 0.5, takes_s: 0.3}]
  steps: [{at: 2, publish: /bell, type: std_msgs/msg/String, data: {data: ring}}, {at: 3, assert: (errand (to B))}, {at: 3.5, retract: (errand (to B))}]
  end: 8
  expect: [{fires: nothing, within_s: 8}]
""")
        for seed in (2, 3):
            row = json.loads(self.cxlab("test", "--keep-runs", "runs", "--seed", seed, "--json", "-v").stdout)["stories"][0]
            lines = [(t, text) for t, logger, text in (line.split("] ", 2) for line in row["printed"]) if logger == "[main" and not text.startswith("[warn]")]
            log = (self.folder / row["run"] / "logs/main.log").read_text().splitlines()
            kept = [line.split("] ", 3) for line in log]
            self.assertEqual(lines, [(t, text) for t, _, level, text in kept if level == "[info"], seed)
            self.assertGreater(len(lines), 4)

    def test_properties_are_told_by_their_smallest_seed(self):
        self.write("dice.clp", "(defrule roll (start) => (assert (rolled (random 1 6))))\n")
        self.write("dice.story.yaml", '- {story: dice, rules: dice.clp, seeds: "1..30", given: [(start)], expect: [{no_fact: (rolled 6), within_s: 1}]}\n')
        found = {}
        for jobs in (1, 3):
            done = self.cxlab("test", "--json", "-j", jobs, "--keep-runs", "runs")
            self.assertEqual(done.returncode, 1, done.stderr)
            found[jobs] = json.loads(done.stdout)["stories"][0]
            self.assertEqual(found[jobs]["seeds_played"], 30)
        row = found[1]
        self.assertEqual(row["failed_seeds"], found[3]["failed_seeds"])
        self.assertTrue(0 < len(row["failed_seeds"]) < 30)
        self.assertEqual(row["seed"], min(row["failed_seeds"]))
        self.assertEqual(row["failures"], found[3]["failures"])
        self.assertIn(f'seed {row["seed"]} is the smallest of {len(row["failed_seeds"])} that fail, of 30', row["failures"])
        self.assertTrue(row["again"].endswith(f' --seed {row["seed"]}'), row["again"])
        self.assertIn("(rolled 6)", self.ask("facts", row["run"]))
        for seed in range(1, 11):
            self.assertEqual(self.cxlab("test", "--seed", seed).returncode, 1 if seed in row["failed_seeds"] else 0, seed)

    def test_a_parameter_that_nothing_reads_is_a_note(self):
        self.write("door.clp", DOOR)
        self.write("agent.yaml", CONFIG.replace('"files"]', '"params", "files"]') + '    params: {plugin: "cx::RosParamPlugin"}\n    gain: 1\n')
        self.write("rules/rules.clp", DOOR + '(defrule read (bell) => (assert (gain (ros-param-get-value "gain" 0))))\n')
        self.write("a.story.yaml", "- {story: one, config: agent.yaml, packages: {rules: rules}, given: [(bell)], params: {clips_manager.gain: 5,\n"
                                   "    clips_manager.gian: 2}, expect: [{fact: (gain 5), within_s: 1}]}\n")
        note = "a.story.yaml:2: parameter 'gian' was set, but nothing reads it, did you mean 'gain'?"
        for more in ((), ("--load-once",)):
            self.assertIn(f"  note: {note}\n", self.ask("test", "a.story.yaml", *more))
            self.assertEqual(json.loads(self.ask("test", "a.story.yaml", "--json", *more))["stories"][0]["notes"], [note])

    def test_goals_that_were_not_sent_are_none(self):
        self.write("a.clp", '(defrule send (go ?n) => (ros-msgs-create-action-client "/w" "cxlab_skills/action/Pick") (bind ?g (ros-msgs-create-goal-request "cxlab_skills/action/Pick"))'
                            ' (ros-msgs-async-send-goal ?g "/w") (ros-msgs-destroy-message ?g))\n')
        for given, count, said in (("(stay)", 1, "a goal for /w by 1 s; there was none"), ("(stay)", 2, "2 times a goal for /w by 1 s; there was none"),
                                   ("(go 1)", 2, "2 times a goal for /w by 1 s; there was 1; there was no other")):
            self.write("a.story.yaml", f"- {{story: a, rules: a.clp, given: [{given}], skills: [{{action: /w, type: cxlab_skills/action/Pick}}],\n"
                                       f"   expect: [{{goal: /w, count: {count}, within_s: 1}}]}}\n")
            self.assertIn(f"a.story.yaml:2: expected {said}\n", self.cxlab("test", "a.story.yaml").stdout)

    def test_nothing_takes_the_others_down(self):
        """A loop of rules, one that takes long, a skill that never ends."""
        self.write("loop.clp", "(defrule loop (start) => (assert (go 0)))\n(defrule on (go ?n) => (assert (go (+ ?n 1))))\n")
        self.write("long.clp", "(defrule long (start) => (while TRUE (explode$ \"a b c d e f g h i j k l m n o p q r s t\")))\n")
        self.write("door.clp", DOOR)
        for name in ("loop", "long"):
            self.write(f"{name}.story.yaml", self.story(name, "(start)", "no_fact: (start), within_s: 1").replace("door.clp", f"{name}.clp"))
        self.write("zdoor.story.yaml", self.story("door", "(bell)", "fires: open, within_s: 1")
                   + self.story("skill", "(bell)", "fires: open, within_s: 1", "  skills: [{action: /go, type: cxlab_skills/action/DriveTo, outcome: never}]\n"))
        done = self.cxlab("test", "--steps", 0, "--patience", 2, "-j", 2, "--coverage", "c.info")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("2 passed, 2 failed", done.stdout)
        self.assertIn("note: long.story.yaml: long: what its rules did is not counted, because it took longer than --patience\n", done.stderr)
        self.assertNotIn("note: zdoor", done.stderr)
        self.assertNotIn("long.clp", (self.folder / "c.info").read_text())
        self.assertIn("the story has not ended after 2 s of wall time (--patience); the other stories were played", done.stdout)
        self.assertRegex(done.stdout, r"(?m)^FAILED  long.story.yaml: long \(\d+ ms\)$", "nobody knows how far it came")
        done = self.cxlab("test", "loop.story.yaml", "zdoor.story.yaml", "--keep-runs", "runs")
        self.assertIn("2 passed, 1 failed", done.stdout)
        self.assertRegex(done.stdout, "loop.clp:2: environment 'main': rules still fire after 100000 firings.* a story allows no more\n")
        self.assertIn("(start)", self.ask("facts", "runs/loop-loop", "start"))

    def test_a_story_that_took_longer_than_the_patience_fails_however_short(self):
        self.write("door.clp", DOOR)
        self.write("door.story.yaml", self.story("door", "(bell)", "fires: open, within_s: 1"))
        for more in ((), ("--load-once",)):
            self.ask("test", *more)
            done = self.cxlab("test", "--patience", "0.0001", *more)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertIn("the story has not ended after 0.0001 s of wall time (--patience); the other stories were played", done.stdout)

    def test_a_golden_run_says_what_goes_otherwise(self):
        self.write("agent.yaml", CONFIG)
        self.write("rules/rules.clp", DOOR + "(deffacts start (bell))\n")
        self.write("scenario.yaml", SCENARIO)
        self.ask("run", "scenario.yaml", "--out", "golden", "--quiet")
        self.write("golden.story.yaml", "- {story: as it went, golden: golden}\n- {story: its beginning, golden: golden, end: 1}\n")
        self.assertIn("2 passed", self.ask("test"))
        for missing, code in (("agent.yaml", 3), ("rules", 3), ("rules/rules.clp", 1), ("scenario.yaml", 0)):
            (self.folder / missing).rename(self.folder / "away")
            for more in ((), ("--accept",)):
                done = self.cxlab("test", "golden.story.yaml::as it went", *more)
                self.assertEqual(done.returncode, code, done.stdout + done.stderr)
                self.assertRegex(done.stdout, f" missing: .*/{missing};" if code != 1 else "golden.story.yaml:1: the run fails now: .*rules.clp")
            (self.folder / "away").rename(self.folder / missing)
        self.assertNotIn("missing", self.ask("test", "golden.story.yaml"))
        self.write("rules/rules.clp", DOOR.replace("(bell)", "(bell) (key)") + "(deffacts start (bell))\n")
        done = self.cxlab("test", "--keep-runs", "runs")
        self.assertEqual(done.returncode, 1, done.stderr)
        for part in ("golden.story.yaml:1: the run goes otherwise than golden from 0 s on", "defrule open is written differently",
                     "rule open did not fire: condition 2 does not hold", "0 passed, 2 failed"):
            self.assertIn(part, done.stdout)
        self.assertEqual(self.cxlab("diff", "golden", "runs/golden-as-it-went").returncode, 1)
        self.assertEqual(self.cxlab("test").returncode, 1)
        before = (self.folder / "golden/inputs.bin").read_bytes()
        changed = (self.folder / "rules/rules.clp").read_text()
        self.write("rules/rules.clp", changed + "(defrule slow (bell) => (loop-for-count (?i 1 2000000000) (* ?i 2)))\n")
        for limit in (("--patience", "0.5", "--steps", "0"), ("--steps", "10")):
            done = self.cxlab("test", "golden.story.yaml::as it went", "--accept", *limit)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertNotIn("accepted", done.stdout)
            self.assertEqual((self.folder / "golden/inputs.bin").read_bytes(), before)
        self.write("rules/rules.clp", changed)
        done = self.cxlab("test", "--accept")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("accepted  ", done.stdout)
        self.assertIn("2 passed, 0 failed", done.stdout)
        self.assertEqual(self.cxlab("diff", "golden", "runs/golden-as-it-went").returncode, 0)
        self.assertIn("2 passed", self.ask("test"))
        self.assertEqual(sorted(entry.name for entry in self.folder.iterdir() if entry.name.startswith("golden")), ["golden", "golden.story.yaml"])
        self.assertIn("--load-once: the story 'as it went' of golden.story.yaml is a golden run", self.cxlab("test", "golden.story.yaml", "--load-once").stderr)
        self.write("rules/rules.clp", DOOR + "(defrule broken")
        for arguments in ([], ["--accept"]):
            done = self.cxlab("test", "golden.story.yaml", *arguments)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertIn("0 passed, 2 failed", done.stdout)
            self.assertEqual(done.stdout.count("this golden run stays, because the run fails now"), 2 if arguments else 0)
            self.assertRegex(done.stdout, r"\n  golden.story.yaml:1: the run fails now: .*rules.clp:\d+: found no closing parenthesis.*\n  seed 1")
        self.assertEqual(json.loads((self.folder / "golden/result.json").read_text())["status"], "completed")
        self.write("rules/rules.clp", DOOR + "(deffacts start (bell))\n")
        for limit in ("--steps 10", "--memory 1MB"):
            done = self.cxlab("test", "golden.story.yaml::as it went", *limit.split(), "--keep-runs", "limited")
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertRegex(done.stdout, rf"golden.story.yaml:1: the run fails now: .*{limit.split()[0]}\n  seed 1; again: cxlab test .*{limit.split()[0]}")
            self.assertNotIn("/tmp/cxlab-scratch", done.stdout)
            self.assertTrue((self.folder / "limited/golden-as-it-went/manifest.json").is_file())
        self.write("late.story.yaml", "- {story: late, golden: golden, end: 3000}\n")
        done = self.cxlab("test", "late.story.yaml")
        self.assertEqual(done.returncode, 3)
        self.assertRegex(done.stdout, r"late.story.yaml:1: end: 3000 s is after the end of the golden run, \d+ s\n")
        self.write("zero.story.yaml", "- {story: zero, golden: golden, end: 0}\n")
        self.assertIn("found 0, expected a time after 0", self.cxlab("test", "zero.story.yaml").stdout)
        self.write("bad.story.yaml", "- {story: none, golden: nowhere}\n")
        done = self.cxlab("test", "bad.story.yaml")
        self.assertEqual(done.returncode, 3)
        self.assertIn("there is no folder of a run", done.stdout)


class Unreadable(Stories):
    """A story file that cannot be read fails, and the others are played."""

    def setUp(self):
        super().setUp()
        self.doors()
        for name, text in (("a.story.yaml", "stories: ["), ("z.story.yaml", self.story("z", "(bell)", "fires: open, within_s: 1") + "  colour: red\n")):
            self.write(name, text)

    def test_the_others_are_played(self):
        for more in ([], ["-j", 3], ["--load-once"]):
            done = self.cxlab("test", "--junit", "j.xml", *more)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("2 passed, 4 failed\n", done.stdout)
            lines = done.stdout.splitlines()
            self.assertEqual(lines[0], "FAILED  a.story.yaml: cannot be read, so none of its stories was played")
            self.assertTrue(lines[1].startswith("  a.story.yaml:1: "), lines[1])
            self.assertIn("z.story.yaml:5: unknown key 'colour' in '[0]'", done.stdout)
            suite = xml.etree.ElementTree.parse(self.folder / "j.xml").getroot()
            self.assertEqual([suite.get(key) for key in ("tests", "failures", "errors")], ["6", "2", "2"])
            bad = [case for case in suite if case.find("error") is not None]
            self.assertEqual([case.get("classname") for case in bad], ["a.story.yaml", "z.story.yaml"])
            self.assertIn("a.story.yaml:1: ", bad[0].find("error").get("message"))
        rows = json.loads(self.cxlab("test", "--json").stdout)["stories"]
        self.assertEqual([(row["file"], row["story"], row["passed"], row["again"]) for row in rows if row["file"] in ("a.story.yaml", "z.story.yaml")],
                         [(name, None, False, f"cxlab test {name}") for name in ("a.story.yaml", "z.story.yaml")], "no story is told of")

    def test_all_that_is_wrong_with_it_is_told_at_once(self):
        self.write("two.story.yaml", self.story("one", "(bell)", "fires: open, within: 1") + self.story("two", "(bell)", "fires: open", "  sead: 1\n"))
        said = self.cxlab("test", "two.story.yaml").stdout
        for line, part in ((4, "unknown key 'within' in '[0].expect[0]', did you mean 'within_s'?"), (9, "'[1].expect[0]: key 'within_s' is missing"), (8, "unknown key 'sead'")):
            self.assertIn(f"two.story.yaml:{line}: {part}".replace("'[1]", "[1]"), said)
        self.assertEqual(said.count("two.story.yaml:"), 1 + 3, said)
        self.write("two.story.yaml", "common: {stepss: []}\nstories:\n" + self.story("one", "(bell)", "fires: open, within: 1"))
        said = self.cxlab("test", "two.story.yaml").stdout
        self.assertIn("unknown key 'stepss'", said)
        self.assertIn("unknown key 'within'", said)

    def names(self, *arguments):
        done = self.cxlab("test", "--json", *arguments)
        self.assertEqual(done.returncode, 3, done.stderr)
        return [row["story"] or row["file"] for row in json.loads(done.stdout)["stories"]]

    def test_it_may_have_any_stories(self):
        self.assertEqual(self.names("-k", "'bell opens'"), ["a.story.yaml", "a bell opens", "z.story.yaml"])
        self.names()
        self.assertEqual(self.names("--lf"), ["a.story.yaml", "a bell shuts", "a wind opens it's \"door\"", "z.story.yaml"])
        done = self.cxlab("test", "-x")
        self.assertEqual((done.returncode, done.stdout.splitlines()[-1]), (3, "0 passed, 1 failed, 5 not played"))

    def test_a_file_with_another_ending_is_named(self):
        said = self.cxlab("test", "door.clp").stdout
        self.assertRegex(said, r"door\.clp:\d+: this is no story file, whose name ends with \.story\.yaml: ")
        self.assertNotIn("this is no story file", self.cxlab("test").stdout)

    def test_two_stories_of_one_name(self):
        self.write("a.story.yaml", self.story("one", "(bell)", "fires: open, within_s: 1") * 2)
        self.assertIn("a.story.yaml:5: [1].story: the story on line 1 has the name 'one', too", self.cxlab("test", "a.story.yaml").stdout)


class FromAMoment(Stories):
    """cxlab new story."""

    def test_what_rules_close_within_the_story_still_comes(self):
        self.write("a.clp", """(deffacts start (begin))
(defrule open ?s <- (begin) => (retract ?s) (ros-msgs-create-subscription "/bell" "std_msgs/msg/String")
  (ros-msgs-create-publisher "/door" "std_msgs/msg/String"))
(defrule hear ?f <- (ros-msgs-message (topic "/bell") (msg-ptr ?m)) => (retract ?f) (assert (bell)) (ros-msgs-destroy-message ?m)
  (bind ?out (ros-msgs-create-message "std_msgs/msg/String")) (ros-msgs-publish ?out "/door") (ros-msgs-destroy-message ?out))
(defrule close (bell) (time ?) => (ros-msgs-destroy-subscription "/bell") (ros-msgs-destroy-publisher "/door"))
""")
        self.write("w.story.yaml", """- story: w
  rules: a.clp
  steps: [{at: 2, publish: /bell, type: std_msgs/msg/String, data: {data: ring}}]
  end: 5
  expect: [{fires: open, count: 99, within_s: 4}]
""")
        self.assertEqual(self.cxlab("test", "w.story.yaml", "--keep-runs", "k").returncode, 1)
        done = self.cxlab("new", "story", "k/w-w", "--at", 1, "--for", 3, "--out", "m.story.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "m.story.yaml").read_text()
        for part in ("publish: '/bell', type: std_msgs/msg/String", "published: '/door'", "fires: 'hear'"):
            self.assertIn(part, text)
        self.assertNotIn("do not happen", done.stderr)

    def test_each_goal_gets_its_own_answer(self):
        """Goals of one action that run at once and end in another order than they began: the property of any moment."""
        self.write("a.clp", """(deffacts start (begin))
(defrule open ?s <- (begin) => (retract ?s) (ros-msgs-create-action-client "/work" "cxlab_skills/action/Pick"))
(defrule send ?o <- (want ?x) => (retract ?o) (bind ?g (ros-msgs-create-goal-request "cxlab_skills/action/Pick"))
  (ros-msgs-set-field ?g "target" ?x) (ros-msgs-async-send-goal ?g "/work") (ros-msgs-destroy-message ?g))
(defrule answered ?r <- (ros-msgs-goal-response (server "/work") (client-goal-handle-ptr ?h)) => (retract ?r) (assert (running (ros-msgs-client-goal-handle-get-goal-id ?h) ?h)))
(defrule result ?r <- (ros-msgs-wrapped-result (server "/work") (goal-id ?id) (code ?code) (result-ptr ?p)) ?f <- (running ?id ?h) =>
  (retract ?r ?f) (assert (done ?id ?code (ros-msgs-get-field ?p "target"))))
""")
        for number, goals in enumerate(([(1, 10), (2, 2)], [(1, 9), (1.5, 1), (2, 6), (4, 1), (4.2, 3), (6, 2)])):
            letters = "ABCDEF"[:len(goals)]
            outcomes = [f"{{outcome: {'fail' if letter == 'C' else 'succeed'}, takes_s: {takes}, result: {{target: {letter}}}}}" for letter, (_, takes) in zip(letters, goals)]
            steps = [f'{{at: {at}, assert: (want "{letter}")}}' for letter, (at, _) in zip(letters, goals)]
            name = f"w{number}"
            self.write(f"{name}.story.yaml", f"""- story: {name}
  rules: a.clp
  skills: [{{action: /work, type: cxlab_skills/action/Pick, {outcomes[0][1:-1]}, then: [{', '.join(outcomes[1:])}]}}]
  steps: [{', '.join(steps)}]
  end: 15
  expect: [{{fires: send, count: 99, within_s: 14}}]
""")
            self.assertEqual(self.cxlab("test", f"{name}.story.yaml", "--keep-runs", "k").returncode, 1)
            for moment in (1, 3, 5) if number == 0 else (1.7, 3, 4.5, 7):
                with self.subTest(run=name, at=moment):
                    done = self.cxlab("new", "story", f"k/{name}-{name}", "--at", moment, "--for", 12 - moment, "--out", "m.story.yaml", "--force")
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertNotIn("do not happen", done.stderr)
                    self.assertEqual(self.cxlab("test", "m.story.yaml").returncode, 0)
                    text = (self.folder / "m.story.yaml").read_text()
                    given_at = float(re.search(r"given_at_s: (\S+)", text)[1])
                    running = re.findall(r"id: '\w+', outcome: (\w+), takes_s: ([\d.]+), result: \{.*?\"target\":\"(\w)\"", text)
                    ends = {letter: given_at + float(takes) for _, takes, letter in running}
                    expected = {letter: at + takes for letter, (at, takes) in zip(letters, goals) if at <= given_at < at + takes}
                    self.assertEqual(list(ends), list(expected))
                    for letter, end in expected.items():
                        self.assertAlmostEqual(ends[letter], end, delta=0.15)
                    self.assertEqual({letter: outcome for outcome, _, letter in running}, {letter: "fail" if letter == "C" else "succeed" for letter in expected})
                    self.assertNotIn("packages:", text, "those of cxlab are there without a word")

    def test_the_last_change_of_facts_decides_between_equal_activations(self):
        self.write("a.clp", """(deftemplate box (slot name) (slot n (default 0)))
(deffacts start (box (name A)) (box (name B)) (go))
(defrule change (time ?t&:(>= ?t 2)) ?b <- (box (name A) (n 0)) => (modify ?b (n 1)))
(defrule choose (time ?t&:(>= ?t 5)) ?g <- (go) (box (name ?x)) => (retract ?g) (assert (chosen ?x)))
""")
        self.write("w.story.yaml", "- {story: w, rules: a.clp, end: 8, expect: [{fires: choose, count: 9, within_s: 7}]}\n")
        self.assertEqual(self.cxlab("test", "w.story.yaml", "--keep-runs", "k").returncode, 1)
        done = self.cxlab("new", "story", "k/w-w", "--at", 3, "--for", 4, "--out", "m.story.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("do not happen", done.stderr)
        self.assertIn("(chosen ", (self.folder / "m.story.yaml").read_text())

    def test_a_story_passes_and_bites(self):
        made = self.cxlab("new", "agent", "mine")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.write("mine/clips/agent.clp", (self.folder / "mine/clips/agent.clp").read_text() + """(deffacts sign (sign "Ada's") (bow 1) (bow 2))
(defglobal ?*bows* = (create$))
(defrule count-bows (time ?now&:(> ?now 0.5)) (not (counted $?)) => (assert (counted ?*bows* (gensym))) (bind ?*bows* one "two" (create$ 3)))
(defrule take-a-bow (time ?now&:(> ?now 2)) ?bow <- (bow ?) => (retract ?bow))
""")
        self.assertEqual(self.cxlab("run", "mine/scenario.yaml", "--out", "run", "--quiet").returncode, 0)
        done = self.cxlab("new", "story", "run", "--at", "1.05", "--for", "2", "--out", "mine/stories/ada.story.yaml")
        self.assertEqual((done.returncode, done.stdout), (0, "mine/stories/ada.story.yaml\n"), done.stderr)
        text = (self.folder / "mine/stories/ada.story.yaml").read_text()
        for part in ("begins_s: 1\n", "- '(door (state CLOSED))'", "publish: '/bell'", "published: '/door'", "fires: 'open-door'", "'(visitor \"Ada\")'", "'(sign \"Ada''s\")'", "'(bind ?*bows* (create$ one \"two\" 3))'", "'(setgen 2)'", "{fires: 'take-a-bow', count: 2, "):
            self.assertIn(part, text)
        self.assertNotIn("rules and facts only", done.stderr)
        self.assertEqual(self.cxlab("test", "mine/stories/ada.story.yaml").returncode, 0)
        rules = (self.folder / "mine/clips/agent.clp").read_text()
        for old, new in (("(door (state CLOSED))\n  =>", "(door (state OPEN))\n  =>"), ('"open for "', '"closed for "'), ('(topic "/bell")', '(topic "/bel")')):
            self.assertIn(old, rules)
            self.write("mine/clips/agent.clp", rules.replace(old, new))
            self.assertEqual(self.cxlab("test", "mine/stories/ada.story.yaml").returncode, 1, new)
        self.assertEqual(self.cxlab("new", "story", "run", "--at", "1", "--out", "mine/stories/ada.story.yaml").returncode, 2)
        done = self.cxlab("new", "story", "run", "--at", "1", "--out", "mine/stories/bob.yaml")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--out: found 'mine/stories/bob.yaml', expected a name that ends with .story.yaml, by which `cxlab test FOLDER` finds it", done.stderr)
        self.assertFalse((self.folder / "mine/stories/bob.yaml").exists())
        quiet = self.cxlab("new", "story", "run", "--at", "4", "--for", "1")
        self.assertEqual(quiet.returncode, 1)
        self.assertRegex(quiet.stderr, r"nothing that a story could expect happened within 1 s after 4 s; a story begins after the tick of its moment: the last thing before happened at [\d.]+ s, which a story with --at ([\d.]+) has")
        before = re.search(r"with --at ([\d.]+) has", quiet.stderr)[1]
        self.assertEqual(self.cxlab("new", "story", "run", "--at", before, "--for", "1", "--out", "before.story.yaml").returncode, 0)
        (self.folder / "before.story.yaml").unlink()
        late = self.cxlab("new", "story", "run", "--at", "99")
        self.assertEqual(late.returncode, 2)
        self.assertIn("--at: the run ends at 10 s", late.stderr)
        self.assertEqual([p.name for p in self.folder.glob("*.story.yaml")], [], "nothing is left of a story that was not written")

    def test_answers_of_skills_are_in_it(self):
        self.assertEqual(self.cxlab("new", "agent", "carrier", "--rcll").returncode, 0)
        self.assertEqual(self.cxlab("run", "carrier/scenario.yaml", "--tier", "timed", "--until", "60", "--out", "run", "--quiet").returncode, 0)
        done = self.cxlab("new", "story", "run", "--at", "0.5", "--for", "40", "--out", "carrier/stories/early.story.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "carrier/stories/early.story.yaml").read_text()
        self.assertRegex(text, r"- \{action: '/robot1/[a-z_]*', type: cxlab_skills/action/\w+, outcome: succeed, takes_s: ")
        self.assertRegex(text, "goal: '/robot1/")
        self.assertEqual(self.cxlab("test", "carrier/stories/early.story.yaml").returncode, 0)
        self.assertRegex(text, r"takes_s: [\d.]+, result: \{.*\}, feedback: \[\{after_s: [\d.]+, data: \{")
        self.assertRegex(text, r"fires: 'ignore-feedback', count: \d")
        self.assertNotIn("do not happen", done.stderr)
        short = self.cxlab("new", "story", "run", "--at", "9", "--for", "1", "--out", "short.story.yaml")
        self.assertIn("note: it expects rules and facts only, for the agent asked for no skill", short.stderr)

    def test_running_goals_end_as_they_did(self):
        self.assertEqual(self.cxlab("new", "agent", "carrier", "--rcll").returncode, 0)
        self.assertEqual(self.cxlab("run", "carrier/scenario.yaml", "--tier", "timed", "--until", "60", "--out", "run", "--quiet").returncode, 0)
        under_way = 0
        for at in range(3, 40, 6):
            story = f"carrier/stories/at{at}.story.yaml"
            done = self.cxlab("new", "story", "run", "--at", str(at), "--for", "20", "--out", story)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("left out", done.stderr)
            self.assertNotIn("do not happen", done.stderr)
            self.assertEqual(self.cxlab("test", story).returncode, 0)
            text = (self.folder / story).read_text()
            if "under_way" not in text:
                continue
            under_way += 1
            self.assertIn(f"given_at_s: {at}\n", text)
            self.assertRegex(text, r"under_way: \[\{(handle: '<Pointer-C-0x[0-9a-f]+>', )?id: '[0-9a-f]{32}', outcome: succeed, takes_s: ")
            self.write("later.story.yaml", re.sub(r"(under_way: \[\{[^}]*takes_s: )", r"\g<1>50", text).replace("'../", "'carrier/"))
            self.assertEqual(self.cxlab("test", "later.story.yaml").returncode, 1, "the goal of before ends too late")
        self.assertGreater(under_way, 2)

    def test_a_value_that_no_rule_may_write_is_given(self):
        """CLIPS does not check the values that rules compute against the template."""
        self.write("a.clp", """(deftemplate lamp (slot state (allowed-values ON OFF)) (slot by (type EXTERNAL-ADDRESS)) (multislot at (type INTEGER)))
(deftemplate sign (slot text (type STRING)))
(defrule dim (time ?) (not (lamp)) => (bind ?s (sym-cat DIM)) (bind ?at (create$ 1 roof)) (assert (lamp (state ?s) (at ?at)) (sign (text ?s))))
(defrule off (time ?t) (test (> ?t 3)) ?l <- (lamp (state ~OFF) (at $?at)) ?s <- (sign) => (retract ?s) (modify ?l (state OFF)) (assert (was ?at)))
""")
        self.write("w.story.yaml", "- story: w\n  rules: a.clp\n  end: 6\n  expect: [{not_fires: off}]\n")
        self.assertEqual(self.cxlab("test", "w.story.yaml", "--keep-runs", "k").returncode, 1)
        done = self.cxlab("new", "story", "k/w-w", "--at", 1, "--for", 4, "--out", "m.story.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotRegex(done.stderr, "do not happen|left out")
        self.assertIn("note: not expected, because their templates do not allow their values: 1 of the facts that are new or went\n", done.stderr)
        text = (self.folder / "m.story.yaml").read_text()
        self.assertIn("{fact: '(sign (text (nth$ 1 (create$ DIM))))', as: '<Fact-", text)
        self.assertIn("{fact: '(lamp (state (nth$ 1 (create$ DIM))) (at (create$ 1 roof)))', as: '<Fact-", text)
        self.assertIn("{fact: '(was 1 roof)', at: 5}", text)
        self.assertEqual(self.cxlab("test", "m.story.yaml").returncode, 0)

    def test_notes_name_what_a_story_lacks(self):
        self.write("a.clp", """(deftemplate link (slot to (default nil)))
(deftemplate pair (slot name) (slot to (default nil)))
(deffacts start (start) (link) (other) (pair (name a)) (pair (name b)))
(defrule tie ?p <- (pair (name a) (to nil)) ?q <- (pair (name b)) => (modify ?p (to ?q)))
(defrule tie-back ?q <- (pair (name b) (to nil)) ?p <- (pair (name a) (to ~nil)) => (modify ?q (to ?p)))
(defglobal ?*first* = nil)
(defrule keep (start) => (bind ?endless (ros-msgs-create-message "std_msgs/msg/Float64")) (ros-msgs-set-field ?endless "data" (* 1e300 1e300))
  (bind ?long (ros-msgs-create-message "std_msgs/msg/UInt8MultiArray")) (bind ?all (create$)) (loop-for-count 10000 (bind ?all ?all 1)) (ros-msgs-set-field ?long "data" (create$ ?all 1))
  (bind ?most (ros-msgs-create-message "std_msgs/msg/UInt8MultiArray")) (ros-msgs-set-field ?most "data" ?all)
  (assert (array ?endless) (long ?long) (most ?most) (flat (ros-msgs-create-message "std_msgs/msg/String"))))
(defrule note (time ?t) (test (> ?t 0.4)) ?o <- (other) => (bind ?*first* ?o))
(defrule point ?p <- (link (to nil)) ?o <- (other) => (modify ?p (to ?o)))
(defrule compute (logical (start)) => (bind ?x 1) (assert (computed ?x) (follows)))
(defrule end (time ?t) (test (> ?t 3)) ?s <- (start) (flat ?m) => (retract ?s) (assert (said (ros-msgs-get-field ?m "data"))))
""")
        self.write("w.story.yaml", "- story: w\n  rules: a.clp\n  end: 6\n  expect: [{not_fires: end}]\n")
        self.assertEqual(self.cxlab("test", "w.story.yaml", "--keep-runs", "k").returncode, 1)
        done = self.cxlab("new", "story", "k/w-w", "--at", 1, "--for", 4, "--out", "m.story.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        notes = re.findall(r"^note: (.*?)(?: of \d+ things.*)?$", done.stderr, re.MULTILINE)
        self.assertRegex(notes[0], r"^left out, because the fact to which it points is not given before it: \(pair \(name .\) \(to <Fact-\d+>\)\)$")
        for note, fact in zip(notes[2:4], ("array", "long")):
            self.assertRegex(note, rf"^left out, because a story cannot make the message or goal to which it points: \({fact} <Pointer-C-\w+>\)$")
        self.assertEqual(notes[4], "stays when the facts go from which it follows, because its rule computes it: (computed 1)")
        self.assertEqual(notes[5], "not set, because a story cannot make the message, goal or fact to which it points: ?*first*")
        self.assertEqual(notes[6:8], ["1", "  {no_fact: '(computed 1)', at: 5}"])
        text = (self.folder / "m.story.yaml").read_text()
        for fact in ("flat", "most"):
            self.assertRegex(text, rf"'\({fact} \?\*of-story-message-\d+\*\)'")
        self.assertIn("{no_fact: '(follows)', at: 5}", text)
        self.assertRegex(text, r"{fact: '\(other\)', as: '(<Fact-\d+>)'}\n.*'\(link \(to \1\)\)'")
        self.assertIn("""{fact: '(said "")', at: 5}""", text)

    def test_messages_and_globals_are_as_they_were(self):
        """Messages with messages and arrays inside, texts with line ends, and globals that rules define or that point to messages."""
        self.write("a.clp", """(deffacts start (start))
(defglobal ?*kept* = nil ?*third* = (create$))
(defrule keep ?s <- (start) (time ?t) (test (> ?t 0.4)) => (retract ?s)
  (bind ?m (ros-msgs-create-message "std_msgs/msg/Float32MultiArray")) (ros-msgs-set-field ?m "data" (create$ 1.5 -2.0 1e20))
  (bind ?a (ros-msgs-create-message "std_msgs/msg/MultiArrayDimension")) (ros-msgs-set-field ?a "label" (str-cat "Ada's \\"" (format nil "%n") "  x"))
  (bind ?b (ros-msgs-create-message "std_msgs/msg/MultiArrayDimension")) (ros-msgs-set-field ?b "size" 7)
  (bind ?l (ros-msgs-get-field ?m "layout")) (ros-msgs-set-field ?l "dim" (create$ ?a ?b)) (ros-msgs-set-field ?l "data_offset" 3)
  (bind ?n (ros-msgs-create-message "std_msgs/msg/Float64")) (ros-msgs-set-field ?n "data" (/ 1.0 3.0)) (bind ?*kept* ?n)
  (build "(defglobal ?*new* = 4)") (bind ?*third* ?*third* (/ 1 3)) (assert (array ?m) (sixth (/ 1 6)) (long 12345678901234567.0) (text (ros-msgs-get-field ?a "label"))))
(defrule say (time ?t) (test (> ?t 3)) ?f <- (array ?m) (sixth ?s) (long ?g) => (retract ?f) (bind ?l (ros-msgs-get-field ?m "layout")) (bind ?d (ros-msgs-get-field ?l "dim"))
  (bind ?third (ros-msgs-get-field ?*kept* "data"))
  (assert (said (ros-msgs-get-field ?m "data") (str-length (ros-msgs-get-field (nth$ 1 ?d) "label")) (ros-msgs-get-field (nth$ 1 ?d) "size") (ros-msgs-get-field (nth$ 2 ?d) "size")
    (length$ ?d) (ros-msgs-get-field ?l "data_offset") (= ?third (/ 1.0 3.0) (nth$ 1 ?*third*)) (= ?s (/ 1 6)) (floatp ?g) (eval "?*new*"))))
""")
        self.write("w.story.yaml", "- story: w\n  rules: a.clp\n  end: 6\n  expect: [{not_fires: say}]\n")
        self.assertEqual(self.cxlab("test", "w.story.yaml", "--keep-runs", "k").returncode, 1)
        done = self.cxlab("new", "story", "k/w-w", "--at", 1, "--for", 4, "--out", "m.story.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotRegex(done.stderr, "do not happen|left out|not set")
        text = (self.folder / "m.story.yaml").read_text()
        self.assertIn("{fact: '(said 1.5 -2.0 1.00000002004088e+20 11 0 7 2 3 TRUE TRUE TRUE 4)', at: 5}", text)
        self.assertIn('"(text \\"Ada\'s \\\\\\"\\n  x\\")"', text)
        self.assertIn("- '(defglobal ?*new* = 4)'", text)
        self.assertIn("- '(sixth 0.16666666666666666)'\n", text)
        self.assertIn("- '(long 12345678901234568.0)'\n", text)
        self.assertIn("expects", done.stderr)
        self.assertEqual(self.cxlab("test", "m.story.yaml").returncode, 0)

    def test_the_run_of_such_a_story_gives_another(self):
        self.assertEqual(self.cxlab("new", "agent", "carrier", "--rcll").returncode, 0)
        self.assertEqual(self.cxlab("run", "carrier/scenario.yaml", "--tier", "timed", "--until", "60", "--out", "run", "--quiet").returncode, 0)
        self.assertEqual(self.cxlab("new", "story", "run", "--at", "21", "--for", "20", "--out", "one.story.yaml").returncode, 0)
        text = (self.folder / "one.story.yaml").read_text()
        self.assertIn("under_way: [{handle: ", text)
        self.write("one.story.yaml", text.replace("  expect:\n", "  expect:\n    - {fact: (never), within_s: 41}\n"))
        failed = self.cxlab("test", "one.story.yaml", "--keep-runs", "kept")
        self.assertEqual(failed.returncode, 1)
        self.assertIn(" ms, 20.1 s simulated)", failed.stdout, "not the seconds before the moment")
        for at in (21, 25):
            done = self.cxlab("new", "story", next((self.folder / "kept").iterdir()), "--at", at, "--for", 15, "--out", f"at{at}.story.yaml")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotRegex(done.stderr, "do not happen|left out")
            self.assertNotIn("of-story-goal", (self.folder / f"at{at}.story.yaml").read_text())

    def test_the_folder_of_an_agent_may_have_moved(self):
        self.assertEqual(self.cxlab("new", "agent", "sub/mine").returncode, 0)
        self.assertEqual(self.cxlab("run", "sub/mine/scenario.yaml", "--out", "run", "--quiet").returncode, 0)
        (self.folder / "sub/mine").rename(self.folder / "moved")
        lost = self.cxlab("new", "story", "run", "--at", "1")
        self.assertEqual(lost.returncode, 3)
        self.assertIn("sub/mine/agent.yaml: the configuration of the agent is not there: if its package was moved, name its folder with --package NAME=DIR", lost.stderr)
        unknown = self.cxlab("new", "story", "run", "--at", "1", "--out", "m.story.yaml", "--package", "mien=moved")
        self.assertEqual(unknown.returncode, 2)
        self.assertRegex(unknown.stderr, "the run has no package 'mien'; it has .*mine")
        done = self.cxlab("new", "story", "run", "--at", "1", "--out", "m.story.yaml", "--package", "mine=moved")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "m.story.yaml").read_text()
        self.assertIn("  config: 'moved/agent.yaml'\n  packages: {mine: 'moved'}\n", text)
        self.assertEqual(self.cxlab("test", "m.story.yaml").returncode, 0)

    def test_agents_with_a_namespace_or_remaps_have_one_with_the_names_of_their_rules(self):
        self.assertEqual(self.cxlab("new", "agent", "mine").returncode, 0)
        rules = self.folder / "mine/clips/agent.clp"
        rules.write_text(rules.read_text().replace('"/bell"', '"bell"'))
        scenario = (self.folder / "mine/scenario.yaml").read_text()
        begin, end = scenario.index("agents:\n"), scenario.index("stimuli:")
        agent = "  - {config: agent.yaml, packages: {mine: .}, namespace: /a, remap: {/door: gate}}\n"
        for agents, bell, env in ((agent, "/a/bell", ()), (agent.replace("gate}", "gate, bell: /chime}"), "/chime", ()),
                                  (agent + agent.replace("namespace: /a, ", ""), "/a/bell", ("--env", "a/main"))):
            self.write("mine/named.yaml", scenario[:begin] + "agents:\n" + agents + scenario[end:].replace("/bell", bell))
            self.assertEqual(self.cxlab("run", "mine/named.yaml", "--out", "run", "--quiet", "--force").returncode, 0)
            if env:
                self.assertIn("the run has several environments: choose one with --env", self.cxlab("new", "story", "run", "--at", "1").stderr)
            done = self.cxlab("new", "story", "run", "--at", "0.5", "--for", "3", "--out", "m.story.yaml", "--force", *env)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("do not happen", done.stderr)
            text = (self.folder / "m.story.yaml").read_text()
            for part in ("publish: '/bell', type: std_msgs/msg/String", "published: '/door', type: std_msgs/msg/String", "fires: 'open-door'"):
                self.assertIn(part, text)
            self.assertEqual(self.cxlab("test", "m.story.yaml").returncode, 0)

    def test_stand_ins_of_an_agent_with_a_namespace_and_remaps(self):
        self.write("client.yaml", CONFIG.replace("rules.clp", "client.clp"))
        self.write("server.yaml", CONFIG.replace("rules.clp", "server.clp"))
        self.write("rules/client.clp", """(deffacts start (begin))
(defrule open ?b <- (begin) => (retract ?b) (ros-msgs-create-client "may_i" "std_srvs/srv/SetBool")
  (ros-msgs-create-action-client "pick" "cxlab_skills/action/Pick"))
(defrule ask (time 2.0) => (bind ?m (ros-msgs-create-request "std_srvs/srv/SetBool")) (ros-msgs-async-send-request ?m "may_i") (ros-msgs-destroy-message ?m)
  (bind ?g (ros-msgs-create-goal-request "cxlab_skills/action/Pick")) (ros-msgs-async-send-goal ?g "pick") (ros-msgs-destroy-message ?g))
(defrule answered ?r <- (ros-msgs-response (service "may_i") (msg-ptr ?m)) => (retract ?r) (assert (may (ros-msgs-get-field ?m "success"))) (ros-msgs-destroy-message ?m))
""")
        server = """(deffacts start (begin))
(deffunction /you-service-callback (?service ?request ?response) (ros-msgs-set-field ?response "success" TRUE))
(defrule serve ?b <- (begin) => (retract ?b) (ros-msgs-create-service "/you" "std_srvs/srv/SetBool"))
"""
        for remap in ("", "may_i: /you", "rosservice://may_i: /you", "rosservice:///a/may_i: /you", "clips_manager:may_i: /you"):
            with self.subTest(remap=remap):
                self.write("rules/server.clp", server if remap else server.replace("/you", "/a/may_i"))
                agents = f"  - {{config: client.yaml, namespace: /a, remap: {{{remap}}}}}\n  - config: server.yaml"
                self.write("scenario.yaml", SCENARIO.replace("duration_s: 2", "duration_s: 8").replace("  - config: agent.yaml", agents))
                self.assertEqual(self.cxlab("run", "scenario.yaml", "--out", "run", "--quiet", "--force").returncode, 0)
                done = self.cxlab("new", "story", "run", "--at", 1, "--for", 4, "--env", "a/main", "--out", "m.story.yaml", "--force")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("do not happen", done.stderr)
                text = (self.folder / "m.story.yaml").read_text()
                for part in ("service: 'may_i', type: std_srvs/srv/SetBool, outcome: succeed, takes_s: 0.04", "fact: '(may TRUE)'", "action: 'pick'", "goal: 'pick'"):
                    self.assertIn(part, text)

    def test_a_story_has_the_ticks_of_its_run(self):
        """Turtles have ticks of 16 ms, which rules that run ten times a second meet unevenly."""
        self.assertEqual(self.cxlab("run", "turtlesim/hypotheses", "--until", 13, "--out", "run", "--quiet").returncode, 0)
        for at in (10, 5):
            done = self.cxlab("new", "story", "run", "--at", at, "--for", 3, "--env", "straight", "--out", "m.story.yaml", "--force")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("do not happen", done.stderr)
        text = (self.folder / "m.story.yaml").read_text()
        self.assertIn("  tick_s: 0.016\n  begins_s: 4.9\n", text)
        self.write("m.story.yaml", text.replace("  expect:\n", "  expect:\n    - {fact: (never), within_s: 8}\n"))
        self.assertEqual(self.cxlab("test", "m.story.yaml", "--keep-runs", "kept").returncode, 1)
        done = self.cxlab("new", "story", next((self.folder / "kept").iterdir()), "--at", 6, "--for", 1.5, "--env", "straight", "--out", "again.story.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("do not happen", done.stderr)
        self.assertIn("  tick_s: 0.016\n  begins_s: 6\n", (self.folder / "again.story.yaml").read_text())

    def test_a_service_that_comes_after_the_moment_is_a_loss(self):
        self.write("client.yaml", CONFIG.replace("rules.clp", "client.clp"))
        self.write("server.yaml", CONFIG.replace("rules.clp", "server.clp"))
        self.write("rules/client.clp", """(deffacts start (begin) (next 1.0))
(defrule open ?b <- (begin) => (retract ?b) (ros-msgs-create-client "/may_i" "std_srvs/srv/SetBool") (ros-msgs-create-client "/nobody" "std_srvs/srv/SetBool"))
(defrule ask ?n <- (next ?at) (time ?t&:(>= ?t ?at)) => (retract ?n) (assert (next (+ ?at 1.0))) (bind ?m (ros-msgs-create-request "std_srvs/srv/SetBool"))
  (ros-msgs-async-send-request ?m "/nobody") (assert (asked ?at (if (ros-msgs-async-send-request ?m "/may_i") then YES else NO))) (ros-msgs-destroy-message ?m))
(defrule answered ?r <- (ros-msgs-response (msg-ptr ?m)) => (retract ?r) (ros-msgs-destroy-message ?m))
""")
        self.write("rules/server.clp", """(deffacts start (begin))
(deffunction /may_i-service-callback (?service ?request ?response) (ros-msgs-set-field ?response "success" TRUE))
(defrule serve ?b <- (begin) (time ?t&:(>= ?t 3.5)) => (retract ?b) (ros-msgs-create-service "/may_i" "std_srvs/srv/SetBool"))
""")
        self.write("scenario.yaml", SCENARIO.replace("duration_s: 2", "duration_s: 8").replace("  - config: agent.yaml", "  - config: client.yaml\n  - {config: server.yaml, namespace: /server}"))
        self.assertEqual(self.cxlab("run", "scenario.yaml", "--out", "run", "--quiet").returncode, 0)
        lost = "note: /may_i is served from the start of the story, and nobody served it in the run at 3 s\n"
        for at, notes in ((2.2, 1), (4.2, 0)):
            done = self.cxlab("new", "story", "run", "--at", at, "--for", 4, "--env", "main", "--out", "m.story.yaml", "--force")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual((done.stderr.count(lost), done.stderr.count(" is served from the start")), (notes, notes), done.stderr)
        # A story has no server of a name below that of the node.
        client = self.folder / "rules/client.clp"
        client.write_text(client.read_text().replace("/may_i", "~/may_i"))
        scenario = self.folder / "scenario.yaml"
        scenario.write_text(scenario.read_text().replace("- config: client.yaml", "- {config: client.yaml, remap: {~/may_i: /may_i}}"))
        self.assertEqual(self.cxlab("run", "scenario.yaml", "--out", "run", "--quiet", "--force").returncode, 0)
        done = self.cxlab("new", "story", "run", "--at", 2.2, "--for", 4, "--env", "main", "--out", "m.story.yaml", "--force")
        self.assertEqual((done.returncode, done.stderr.count(" is served from the start")), (0, 0), done.stderr)
        self.assertNotIn("may_i', type", (self.folder / "m.story.yaml").read_text())

    def test_a_log_that_ends_before_the_moment_says_where(self):
        self.assertEqual(self.cxlab("new", "agent", "mine").returncode, 0)
        run = stopped_run(self, "mine/scenario.yaml", out="run", cwd=self.folder)
        self.cxlab("attach", "run", "-c", "until 5", "-c", "where")
        run.kill()
        run.wait()
        done = self.cxlab("new", "story", "run", "--at", "8")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, r"--at: the run ends at [\d.]+ s, where the log of the run is cut off \(it is still being played, or was killed\)")
        self.assertEqual(self.cxlab("new", "story", "run", "--at", "1").returncode, 0)
        for more in ("", ", end: 1"):
            self.write("golden.story.yaml", f"- {{story: cut off, golden: run{more}}}\n")
            for accept in ((), ("--accept",)):
                done = self.cxlab("test", "golden.story.yaml", *accept)
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertIn("the golden run is not finished: it is still being played, or it was killed", done.stdout)

    def new_story(self, run, at, name):
        done = self.cxlab("new", "story", run, "--at", at, "--for", 20, "--out", f"{name}.story.yaml", "--force")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotRegex(done.stderr, "do not happen|left out|stays when|sent through a binding")
        self.assertGreater(int(re.search(r"it expects (\d+) things", done.stderr)[1]), 40)
        return (self.folder / f"{name}.story.yaml").read_text()

    def test_moments_of_games_are_whole(self):
        """Feedback, goals and requests in progress, facts that point to facts, and support by `logical`: nothing is lost."""
        for part in ("agent", "planning_agent"):
            shutil.copytree(SOURCE / "scenarios/rcll" / part, self.folder / "rcll" / part)
        for game in ("game", "planning"):
            shutil.copy(SOURCE / f"scenarios/rcll/{game}.yaml", self.folder / "rcll")
            self.assertEqual(self.cxlab("run", f"rcll/{game}.yaml", "--tier", "timed", "--until", 210, "--out", game, "--quiet").returncode, 0)

        def first(run, look):
            records = map(json.loads, (self.folder / run / "journal.jsonl").read_text().splitlines())
            return next(r["t"] / 1e9 for r in records if r["data"].get("name", "").endswith(look) and r["t"] > 100e9)
        driving = first("game", "/drive_to")  # this goal is sent in the tick of the moment, and its message has a message
        planned, asked = first("planning", "action-ready /pddl_manager/temp_plan"), first("planning", "service-ready /pddl_manager/check_action_condition")
        for run, at in (("game", 60), ("game", 180), ("game", driving), ("planning", 60), ("planning", planned + 0.1), ("planning", asked)):
            with self.subTest(run=run, at=at):
                text = self.new_story(run, at, "story")
                if at > planned:  # its goal was sent through a binding, and a fact keeps the message
                    self.assertRegex(text, r"temp_plan', type: \S+,\n +under_way: \[\{handle: '<Pointer-C-\w+>', id: ")
                    self.assertRegex(text, r"- \{fact: '\(pddl-plan-goal \?\*of-story-message-\d+\* <Pointer-C-\w+>\)', as: ")
                self.assertEqual(text, self.new_story(run, at, "again"))
                self.assertEqual(self.cxlab("test", "story.story.yaml").returncode, 0)
                without = re.sub(r", feedback: \[(\{after_s: [\d.]+, data: \{[^}]*\}\}(, )?)+\]", "", text)
                self.assertNotEqual(without, text)
                self.write("story.story.yaml", without)
                self.assertEqual(self.cxlab("test", "story.story.yaml").returncode, 1, "the rules wait for feedback")
        # The last one has a request in progress, and facts about it.
        number = re.search(r"'\(pddl-asked \"/pddl_manager/check_action_condition\" (\d+) <Fact-\d+> condition <Fact-\d+>\)'", text)[1]
        self.assertRegex(text, r"- \{fact: '\(pddl-instance .*\)', as: '<Fact-\d+>'\}")
        self.assertRegex(text, rf"check_action_condition', type: \S+, next_id: {int(number) + 1},", "requests are numbered on")
        sent = f"under_way: [{{id: '{number}', outcome: succeed, takes_s: "
        self.assertIn(sent, text)
        self.write("story.story.yaml", text.replace(sent, sent + "9"))
        self.assertEqual(self.cxlab("test", "story.story.yaml").returncode, 1, "the answer comes too late")
        rules = self.folder / "rcll/planning_agent/clips/agenda.clp"
        old = rules.read_text()
        rules.write_text(old.replace("(logical\n    (step (id ?id) (state OPEN|BLOCKED|APPROACHING))", "(and\n    (step (id ?id) (state OPEN|BLOCKED|APPROACHING))"))
        self.assertNotEqual(rules.read_text(), old)
        failed = self.cxlab("test", "again.story.yaml")
        self.assertEqual(failed.returncode, 1, "a step remains a candidate after it has begun")
        self.assertIn("rule agenda-candidate to fire", failed.stdout)

    def test_an_impossible_running_goal_is_refused(self):
        goal = "{action: /a, type: cxlab_skills/action/Pick, under_way: [{handle: '<P>', takes_s: 1}]}"
        for keys, skills, said in (("", f"skills: [{goal}]", "/a: `under_way` needs a story with `moment: true` and a `given_at_s` after `begins_s`"),
                                   ("given_at_s: 1", "skills: []", "given_at_s is for stories with `moment: true`"),
                                   ("begins_s: 2, given_at_s: 1, moment: true", "skills: []", "given_at_s: found 1, expected no time before begins_s"),
                                   ("", "steps: [{at: 1, skill: /a, type: cxlab_skills/action/Pick, under_way: []}]", "found `under_way` in a step, expected it only in `skills` and `serve`")):
            self.write("bad.story.yaml", f"- {{story: bad, rules: [door.clp], {keys + ', ' if keys else ''}{skills}, expect: [{{fires: open, within_s: 3}}]}}\n")
            done = self.cxlab("test", "bad.story.yaml")
            self.assertEqual(done.returncode, 3, done.stdout)
            self.assertIn(said, done.stdout)


class Watching(Stories):
    """Plays again what a change affects."""

    def test_one_file_is_one(self):
        self.write("a.story.yaml", "- {story: a\n")
        process = self.watch()
        self.assertIn("0 passed, 1 failed; watching 1 file, Ctrl-C ends\n", self.turn(process))
        process.terminate()
        self.assertEqual(process.wait(10), 143)

    def watch(self, *arguments):
        process = subprocess.Popen([CXLAB, "test", "--watch", *arguments], cwd=self.folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=self.environment)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        end = threading.Timer(60, process.kill)  # a change that is not noticed would never be answered
        end.start()
        self.addCleanup(end.cancel)
        return process

    def turn(self, process):
        """What it says until it watches; an empty text at its end."""
        lines = []
        for line in process.stdout:
            lines.append(line)
            if "watching " in line:
                break
        return "".join(lines)

    def test_only_what_is_affected_is_played_again(self):
        self.write("door.clp", DOOR)
        self.write("lamp.clp", "(defrule on (dark) => (assert (lamp ON)))\n")
        self.write("door.story.yaml", self.story("door", "(bell)", "fires: open, within_s: 1"))
        self.write("lamp.story.yaml", self.story("lamp", "(dark)", "fact: (lamp ON), within_s: 1").replace("door.clp", "lamp.clp"))
        process = self.watch()
        self.assertIn("2 passed, 0 failed; watching 4 files, Ctrl-C ends\n", self.turn(process))

        def replaced(name, text):  # as editors save a file
            self.write(name + "~", text)
            os.replace(self.folder / (name + "~"), self.folder / name)

        changes = [
            ("lamp.clp", "(defrule on (dark) => (assert (lamp OFF)))\n", ["lamp.clp has changed", "FAILED  lamp.story.yaml: lamp", "0 passed, 1 failed;"]),
            ("lamp.clp", "(defrule on (dark) => (assert (lamp ON\n", ["lamp.clp has changed", "lamp.clp:1:", "0 passed, 1 failed;"]),
            ("lamp.clp", "(defrule on (dark) => (assert (lamp ON)))\n", ["ok      lamp.story.yaml: lamp", "1 passed, 0 failed;"]),
            ("door.story.yaml", self.story("door", "(wind)", "fires: open, within_s: 1"), ["FAILED  door.story.yaml: door", "0 passed, 1 failed;"]),
            ("door.story.yaml", "- story: [", ["FAILED  door.story.yaml: cannot be read", "  door.story.yaml:1:", "0 passed, 1 failed;"]),
            ("door.story.yaml", self.story("door", "(bell)", "fires: open, within_s: 1"), ["ok      door.story.yaml: door", "1 passed, 0 failed;"]),
            ("new.story.yaml", self.story("new", "(bell)", "fires: open, within_s: 1"), ["ok      new.story.yaml: new", "1 passed, 0 failed;"]),
        ]
        for i, (name, text, said) in enumerate(changes):
            with self.subTest(change=i):
                (replaced if i % 2 else self.write)(name, text)
                begun = time.monotonic()
                out = self.turn(process)
                self.assertLess(time.monotonic() - begun, 5, "a second, on an idle machine")
                for part in said:
                    self.assertIn(part, out)
                self.assertNotIn("door" if name.startswith("lamp") else "lamp", out)
        (self.folder / "lamp.story.yaml").unlink()
        self.assertEqual(self.turn(process), "\nlamp.story.yaml was removed\nwatching 3 files, Ctrl-C ends\n")
        time.sleep(4)  # it reports what it does after 3 s of silence, and now it does nothing
        process.send_signal(signal.SIGINT)
        rest = process.stdout.read()
        self.assertNotIn("working:", rest)
        self.assertEqual(process.wait(10), 130)

    def test_a_golden_run_is_played_again_when_a_package_of_its_agent_changes(self):
        self.write("agent.yaml", CONFIG)
        self.write("rules/rules.clp", DOOR)
        self.write("scenario.yaml", SCENARIO.replace("packages: {rules: rules}\n", "") + "    packages: {rules: rules}\n")
        self.cxlab("run", "scenario.yaml", "--out", "golden", "--quiet")
        self.write("g.story.yaml", "- {story: g, golden: golden}\n")
        process = self.watch()
        self.assertIn("1 passed, 0 failed; watching ", self.turn(process))
        self.write("rules/rules.clp", DOOR + "(deffacts start (bell))\n")
        self.assertIn("rules/rules.clp has changed\nFAILED  g.story.yaml: g", self.turn(process))


if __name__ == "__main__":
    unittest.main()
