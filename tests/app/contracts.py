"""Exit codes, result.json and journal.jsonl of a run. python3 -m unittest contracts"""

import json
import os
import shutil
import signal
import subprocess
import time
import unittest

from lab import CONFIG, CXLAB, GAME, SCENARIO, SOURCE, Lab

KINDS = ["delivery", "ring", "cap", "buffer", "payment", "late", "competitive", "exploration", "penalty"]
FIELDS = ["schema", "scenario", "seed", "tier", "status", "reason", "deterministic", "sim_time_s", "wall_time_s", "physics_wall_s",
          "real_time_factor", "ticks", "steps", "peak_rss_mb", "teams", "orders", "deliveries", "robots", "plans", "replans",
          "rule_errors", "warnings", "journal_hash", "physics_hash", "stream_hashes"]


class LastTick(Lab):
    """The tick at the end is played."""

    def last_time(self, *arguments):
        self.agent('(defrule say (time ?t) => (printout t "at " ?t crlf))')
        self.assertEqual(self.run_it("--force", *arguments).returncode, 0)
        lines = (self.out / "logs/main.log").read_text().splitlines()
        return [line.split()[-1] for line in lines if " at " in line][-1]

    def test_is_at_the_end(self):
        self.assertEqual(self.last_time(), "2.0")
        self.assertEqual(self.last_time("--until", "1"), "1.0")

    def test_that_is_no_tick_is_the_first_after_it(self):
        self.assertEqual(self.last_time("--until", "0.99"), "1.0")


class Game(Lab):
    """The league's game, in the timed tier."""

    def play(self, *arguments, out="out", program=CXLAB):
        done = subprocess.run([program, "run", SOURCE / "scenarios/rcll/game.yaml", "--tier", "timed", "--quiet", "--out", self.folder / out,
                               *arguments], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def test_program_that_is_built_first_plays_the_same(self):
        for program, out in [(CXLAB, "whole"), (os.environ["CXLAB_FIRST"], "first")]:
            self.play("--journal", "full", out=out, program=program)
        for name in ("journal.jsonl", "inputs.bin", "logs/agent.log"):
            self.assertEqual((self.folder / "first" / name).read_bytes(), (self.folder / "whole" / name).read_bytes(), name)
        self.assertTrue((self.folder / "first/index.html").exists())

    def test_result_and_journal(self):
        done = self.play("--json")
        self.assertEqual(json.loads(done.stdout), self.result(), "stdout carries JSON only")
        result = self.result()
        self.assertEqual(list(result), FIELDS)
        self.assertEqual([result[f] for f in FIELDS[:8]], [1, "game", 1, "timed", "completed", None, True, 1200.0])
        for team in result["teams"].values():
            self.assertEqual(list(team["by_kind"]), KINDS)
            self.assertEqual(sum(team["by_kind"].values()), team["points"])
        for order in result["orders"]:
            self.assertEqual(list(order), ["id", "complexity", "ordered", "delivered_at", "correct", "points"])
        self.assertTrue(result["deliveries"])
        for delivery in result["deliveries"]:
            self.assertEqual(list(delivery), ["order", "team", "time", "correct", "late_s", "points"])
            order = next(o for o in result["orders"] if o["id"] == delivery["order"])
            if delivery["correct"]:
                self.assertEqual(order["delivered_at"], delivery["time"])
        self.assertEqual([r["name"] for r in result["robots"]], ["robot1", "robot2", "robot3"])
        for robot in result["robots"]:
            self.assertEqual(list(robot), ["name", "busy_s", "drive_s", "wait_s", "skills", "failures", "contacts",
                                       "state", "maintenances"])
            self.assertLessEqual(robot["busy_s"], 1200.02)
            self.assertLessEqual(robot["drive_s"] + robot["wait_s"], robot["busy_s"])

        last = {}
        for record in self.records():
            self.assertEqual(list(record), ["stream", "n", "t", "kind", "data", "cause"])
            self.assertIn(record["kind"], ["input", "skill", "referee", "decision", "control", "error"])
            self.assertGreater(record["n"], last.get(record["stream"], -1))
            last[record["stream"]] = record["n"]
        self.assertIn("referee", last)
        for name in ["journal.jsonl", "inputs.bin", "result.json", "logs/agent.log", "files/index.jsonl"]:
            content = (self.out / name).read_bytes()
            self.assertNotIn(f"{SOURCE}/".encode(), content, name)
            self.assertNotIn(str(self.folder).encode(), content, name)
        self.assertLess(sum(f.stat().st_size for f in self.out.rglob("*") if f.is_file()), 25e6)

    def test_the_place_of_a_package_does_not_count(self):
        hashes = []
        for place in ("a", "somewhere/else/on/this/disk"):
            self.write(f"{place}/agent.yaml", CONFIG.replace('"files"]', '"index", "files"]') + '    index: {plugin: "cx::AmentIndexPlugin"}\n')
            self.write(f"{place}/scenario.yaml", SCENARIO)
            self.write(f"{place}/rules/rules.clp", '(defrule go => (assert (share (str-cat (ament-index-get-package-share-directory rules) "/x"))))')
            done = subprocess.run([CXLAB, "run", self.folder / place / "scenario.yaml", "--quiet", "--out", "out", "--force", "--journal", "full"],
                                  cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, done.stderr)
            hashes.append(self.result()["journal_hash"])
            self.assertIn("package://rules/x", (self.out / "journal.jsonl").read_text())
            replay = subprocess.run([CXLAB, "replay", "out", "--rules"], cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(replay.returncode, 0, replay.stdout + replay.stderr)
        self.assertEqual(hashes[0], hashes[1])

    def test_failures_are_drawn_from_the_seed(self):
        failing = ["--set", "timed.pick_failure=0.3", "--until", "300"]
        self.play("--until", "300")
        self.assertEqual(sum(r["failures"] for r in self.result()["robots"]), 0)
        hashes = []
        for out in ("a", "b"):
            self.play(*failing, out=out)
            result = json.loads((self.folder / out / "result.json").read_text())
            self.assertGreater(sum(r["failures"] for r in result["robots"]), 0)
            hashes.append(result["journal_hash"])
        self.assertEqual(hashes[0], hashes[1])

    def test_same_seed_same_bytes(self):
        self.play("--until", "300", out="a")
        self.play("--until", "300", out="b")
        self.play("--until", "300", "--seed", "2", out="c")
        read = lambda run, name: (self.folder / run / name).read_bytes()
        for name in ["journal.jsonl", "inputs.bin", "logs/agent.log"]:
            self.assertEqual(read("a", name), read("b", name), name)
        self.assertNotEqual(read("a", "journal.jsonl"), read("c", "journal.jsonl"))
        hashes = [json.loads(read(run, "result.json"))["journal_hash"] for run in "abc"]
        self.assertEqual(hashes[0], hashes[1])
        self.assertNotEqual(hashes[0], hashes[2])


class Ends(Lab):
    def status(self):
        return self.result()["status"]

    def test_completed_stopped_and_shutdown(self):
        self.agent('(defrule t (time ?t&:(> ?t 1)) => (cx-shutdown))\n(defrule f (executive-finalize) => (println "bye"))')
        self.assertEqual(self.run_it("--until", 0.5).returncode, 0)
        self.assertEqual((self.status(), self.result()["sim_time_s"]), ("stopped", 0.5))
        self.assertIn("bye", (self.out / "logs/main.log").read_text(), "always through deactivation")
        self.assertEqual(self.run_it("--force").returncode, 0)
        self.assertEqual((self.status(), self.result()["sim_time_s"]), ("stopped", 1.1))
        self.agent("")
        self.assertEqual(self.run_it("--force").returncode, 0)
        self.assertEqual((self.status(), self.result()["sim_time_s"]), ("completed", 2))

    def test_rules_give_up(self):
        self.agent('(defrule t (time ?t&:(> ?t 1)) => (printout error "a file is missing" crlf) (cx-shutdown))')
        self.fails(4, "error: environment 'main' gives up: a file is missing")
        self.assertEqual((self.status(), self.result()["reason"]["code"], self.result()["sim_time_s"]), ("failed", "gave_up", 1.1))
        self.write("scenario.yaml", SCENARIO + "on_rule_error: continue\n")
        self.assertEqual(self.run_it("--force").returncode, 0)
        self.assertEqual(self.status(), "stopped")

    def test_expectations(self):
        self.write("scenario.yaml", GAME + "expect:\n  - {path: teams.CYAN.points, min: 0}\n  - {path: status, equals: completed}\n")
        self.assertEqual(self.run_it().returncode, 0)
        self.write("scenario.yaml", GAME + "expect:\n  - {path: teams.CYAN.points, min: 100}\n")
        self.fails(1, "scenario.yaml:5: expected teams.CYAN.points to be at least 100", arguments=["--force"])
        self.assertEqual(self.status(), "completed")

    def test_journal_levels(self):
        self.agent('(deffacts f (go)) (defrule r (go) => (assert (gone)))')
        kinds = {}
        for level in ["none", "decisions", "full"]:
            self.assertEqual(self.run_it("--force", "--journal", level).returncode, 0)
            kinds[level] = {r["kind"] for r in self.records()} if (self.out / "journal.jsonl").exists() else set()
        self.assertEqual(kinds["none"], set())
        self.assertFalse(kinds["decisions"] & {"assert", "retract", "fire", "bus"})
        self.assertGreaterEqual(kinds["full"], {"assert", "retract", "fire"})

    def test_folders_are_numbered(self):
        self.agent("")
        for name in ["scenario-1", "scenario-1-2", "scenario-1-3"]:
            self.assertEqual(self.run_it(out=False).returncode, 0)
            self.assertTrue((self.folder / "runs" / name / "result.json").exists(), name)
        self.assertEqual(self.run_it("--out", "none", out=False).returncode, 0)
        self.assertFalse((self.folder / "none").exists())

    def begin(self):
        """A run that lasts, with something in its journal."""
        self.agent('(defrule t (time ?t) => (println "time " ?t))', SCENARIO.replace(": 2", ": 100000000"))
        process = subprocess.Popen(self.command("--out", self.out, "--journal", "full"), cwd=self.folder,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(process.stderr.close)
        journal = self.out / "journal.jsonl"
        for _ in range(500):
            if journal.exists() and journal.stat().st_size > 10000:
                return process
            time.sleep(0.01)
        process.kill()
        self.fail("nothing was written")

    def test_signals(self):
        for number in [signal.SIGINT, signal.SIGTERM]:
            with self.subTest(number=number):
                process = self.begin()
                process.send_signal(number)
                self.assertEqual(process.wait(20), 128 + number)
                self.assertEqual(self.status(), "interrupted")
                self.records()
                (self.out / "result.json").unlink()
                shutil.rmtree(self.out)

    def test_killed(self):
        process = self.begin()
        self.assertEqual((self.status(), self.result()["reason"]["code"]), ("failed", "unfinished"))
        process.kill()
        self.assertEqual(process.wait(20), -signal.SIGKILL)
        self.assertEqual((self.status(), self.result()["reason"]["code"]), ("failed", "unfinished"))
        whole = (self.out / "journal.jsonl").read_text().splitlines(keepends=True)
        if not whole[-1].endswith("\n"):  # the kernel may end a write half-way
            whole.pop()
        self.assertGreater(len([json.loads(line) for line in whole]), 10)


if __name__ == "__main__":
    unittest.main()
