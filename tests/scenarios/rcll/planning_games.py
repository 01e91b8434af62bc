#!/usr/bin/env python3
"""Plays games of the planning agent in the timed tier: what they earn, that rules raise no error and do nothing that the real CX
would do otherwise, and that a run comes again.

    planning_games.py PROGRAM SCENARIO
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SCENARIO = sys.argv[1:3]
SEEDS = (1, 2)
LEAST_POINTS = 250


def cxlab(command, *arguments):
    return subprocess.run([PROGRAM, command, *map(str, arguments)], capture_output=True, text=True)


class PlanningGames(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="cxlab-planning-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_games_are_won_without_a_word_of_strict_cx(self):
        for seed in SEEDS:
            with self.subTest(seed=seed):
                out = self.folder / str(seed)
                done = cxlab("run", SCENARIO, "--tier", "timed", "--seed", seed, "--strict-cx", "--quiet", "--out", out)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                result = json.loads((out / "result.json").read_text())
                self.assertGreaterEqual(result["teams"]["CYAN"]["points"], LEAST_POINTS)
                kinds = {json.loads(line)["kind"] for line in (out / "journal.jsonl").read_text().splitlines()}
                self.assertIn("decision", kinds)
                self.assertNotIn("error", kinds)

    def test_a_game_comes_again(self):
        first, again = self.folder / "first", self.folder / "again"
        done = cxlab("run", SCENARIO, "--tier", "timed", "--until", 400, "--quiet", "--out", first)
        self.assertEqual(done.returncode, 0, done.stderr)
        for command in (["rerun", first, "--quiet", "--out", again], ["replay", first]):
            done = cxlab(*command)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        hashes = [json.loads((folder / "result.json").read_text())["journal_hash"] for folder in (first, again)]
        self.assertEqual(hashes[0], hashes[1])

    def test_a_strategy_that_nobody_knows_is_told(self):
        for parameter, known in {"dispatch": '"groups" "lookahead" "partial-order" "stn"', "order": '"plan" "delivery" "slack"',
                                 "robot": '"nearest" "rested" "both"'}.items():
            said = self.said_with(f"clips_manager.strategy.{parameter}: other")
            self.assertIn(f"strategy.{parameter}: found 'other', expected one of: {known}", said)

    def test_numbers_out_of_range_are_told(self):
        for parameter, found, expected in (("lookahead", "-1", "a whole number of at least 0; taken: 1"),
                                           ("products", "0", "a whole number of at least 1; taken: 3"),
                                           ("alternatives", "-1", "a whole number of at least 1; taken: 3"),
                                           ("patience", "-0.5", "a number of at least 0; taken: 10.0")):
            said = self.said_with(f"clips_manager.strategy.{parameter}: {found}")
            self.assertIn(f"strategy.{parameter}: found {found}, expected {expected}", said)

    def said_with(self, parameters):
        done = cxlab("run", SCENARIO, "--tier", "timed", "--until", 1, "--quiet", "--out", "none",
                     "--set", f"agents[0].params={{{parameters}}}")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stderr


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
