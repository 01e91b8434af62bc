#!/usr/bin/env python3
"""Plays the shipped game of two teams in the timed tier: both teams score, the same run comes again, its replay is the same.

    two_teams.py PROGRAM SCENARIO
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, SCENARIO = sys.argv[1:3]
LEAST_POINTS = 250
LEAST_SHARE_AT_WORK = 0.6


class TwoTeams(unittest.TestCase):
    def play(self, folder, *arguments):
        done = subprocess.run([PROGRAM, "run", SCENARIO, "--tier", "timed", "--quiet", "--out", folder, *arguments],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((folder / "result.json").read_text()), done.stdout

    def test_a_game(self):
        with tempfile.TemporaryDirectory(prefix="cxlab-two-teams-") as folder:
            first, said = self.play(pathlib.Path(folder) / "first")
            second, _ = self.play(pathlib.Path(folder) / "second")
            self.assertEqual(first["journal_hash"], second["journal_hash"])
            replayed = subprocess.run([PROGRAM, "replay", pathlib.Path(folder) / "first"], capture_output=True, text=True)
            self.assertEqual(replayed.returncode, 0, replayed.stderr)
        for team in ("CYAN", "MAGENTA"):
            self.assertGreaterEqual(first["teams"][team]["points"], LEAST_POINTS, team)
            orders = [order for order in first["orders"] if order["team"] == team]
            self.assertEqual([order["id"] for order in orders], list(range(1, 11)), team)
            delivered = sum(order["correct"] for order in orders)
            self.assertGreater(delivered, 3, team)
            self.assertIn(f"{team}: {delivered} of 10 orders delivered", said)
        # Each robot served its own team: whoever crossed over would have been refused.
        for robot in first["robots"]:
            self.assertEqual(robot["contacts"], 0, robot)
            self.assertGreater(robot["busy_s"], LEAST_SHARE_AT_WORK * first["sim_time_s"], robot)
        competitive = sorted(team["by_kind"]["competitive"] for team in first["teams"].values())
        self.assertIn(competitive, ([0, 0], [0, 10], [-10, 10]))

    def test_a_script_plays_for_the_other_team(self):
        with tempfile.TemporaryDirectory(prefix="cxlab-script-") as folder:
            out = pathlib.Path(folder) / "out"
            subprocess.run([PROGRAM, "run", pathlib.Path(SCENARIO).parent / "scripted_opponent.yaml", "--tier", "timed", "--quiet",
                            "--until", "600", "--out", out], check=True, capture_output=True)
            teams = json.loads((out / "result.json").read_text())["teams"]
        self.assertEqual(teams["MAGENTA"], {"points": 2, "by_kind": {**dict.fromkeys(teams["MAGENTA"]["by_kind"], 0), "payment": 2}})
        self.assertGreater(teams["CYAN"]["points"], 30)

    def test_two_planning_agents_with_a_pddl_manager_each(self):
        """The settings of docs/how-to/write-a-strategy.md, Let two strategies play against each other."""
        settings = ["servers=[{node: pddl_manager, name: pddl_manager, namespace: /cyan, anytime: true}, "
                    "{node: pddl_manager, name: pddl_manager, namespace: /magenta, anytime: true}]",
                    "agents[0].params={clips_manager.planner.node: /cyan/pddl_manager}",
                    "agents[1].config=planning_agent/params/agent.yaml",
                    "agents[1].packages={rcll_agent: agent, rcll_planning_agent: planning_agent}",
                    "agents[1].params={clips_manager.planner.node: /magenta/pddl_manager}"]
        with tempfile.TemporaryDirectory(prefix="cxlab-planners-") as folder:
            out = pathlib.Path(folder) / "out"
            subprocess.run([PROGRAM, "run", pathlib.Path(SCENARIO).parent / "plans_against_rules.yaml", "--tier", "timed", "--quiet",
                            "--out", out, *(word for setting in settings for word in ("--set", setting))],
                           check=True, capture_output=True)
            teams = json.loads((out / "result.json").read_text())["teams"]
        for team in ("CYAN", "MAGENTA"):
            self.assertGreaterEqual(teams[team]["points"], LEAST_POINTS, team)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
