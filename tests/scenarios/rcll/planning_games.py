#!/usr/bin/env python3
"""Plays games of the planning agent in the timed tier. Checks what they earn, that rules raise no error and do nothing that the real
CX would do otherwise, and that a run can be repeated.

    planning_games.py PROGRAM SCENARIO
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

if len(sys.argv) < 3:
    sys.exit(__doc__)
PROGRAM, SCENARIO = sys.argv[1:3]
SEEDS = (1,)  # planning_failures.py and game_invariants.py play others
LEAST_POINTS = 250


def cxlab(command, *arguments):
    return subprocess.run([PROGRAM, command, *map(str, arguments)], capture_output=True, text=True)


class PlanningGames(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="cxlab-planning-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def test_games_are_won_without_a_warning_of_strict_cx(self):
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

    def test_a_strategy_that_nobody_knows_ends_the_run(self):
        for parameter, known in {"dispatch": '"external" "greedy" "groups" "lookahead:N, N >= 0" "lookahead:unlimited" "partial-order" "stn"', "order": '"plan" "delivery" "slack"',
                                 "robot": '"nearest" "rested" "both"'}.items():
            said = self.said_with(f"clips_manager.strategy.{parameter}: other", 4)
            self.assertIn(f"gives up: strategy.{parameter}: found 'other', expected one of: {known}", said)

    def test_lookahead_takes_a_number_of_groups(self):
        for found in ("lookahead", "lookahead:-1", "lookahead:1.5", '"lookahead:"', '"lookahead:1 2"', "lookahead:all", "lookahead:N"):
            said = self.said_with(f"clips_manager.strategy.dispatch: {found}", 4)
            self.assertIn("strategy.dispatch: found '" + found.strip('"') + "', expected one of: ", said)
        for right in ("lookahead:0", "lookahead:12", "lookahead:unlimited"):
            self.assertEqual(self.said_with(f"clips_manager.strategy.dispatch: {right}"), "")

    def test_greedy_plays_as_the_rule_agent(self):
        of_rules = self.result_of(pathlib.Path(SCENARIO).parent / "game.yaml", {})
        of_setting = self.result_of(SCENARIO, {"dispatch": "greedy"})
        self.assertGreaterEqual(of_rules["teams"]["CYAN"]["points"], LEAST_POINTS)
        for part in ("teams", "orders", "deliveries", "robots"):
            self.assertEqual(of_setting[part], of_rules[part])

    def test_greedy_loads_all_files_of_the_rule_agent(self):
        rcll = pathlib.Path(SCENARIO).parent
        of_rules = re.findall(r'"clips/(.*)\.clp"', (rcll / "agent/params/agent.yaml").read_text())
        loaded = re.search(r'greedy\)\s+then\s+\(load-files "rcll_agent"(.*?)\)', (rcll / "planning_agent/clips/strategy.clp").read_text(), re.DOTALL)
        self.assertEqual(loaded.group(1).split(), of_rules)

    def test_greedy_has_the_settings_of_robots(self):
        greedy = self.result_of(SCENARIO, {"dispatch": "greedy"})
        for parameter, value in {"robot": "rested", "transport": "false", "patience": "30.0"}.items():
            other = self.result_of(SCENARIO, {"dispatch": "greedy", parameter: value})
            self.assertEqual(other["warnings"], [])
            self.assertNotEqual(other["robots"], greedy["robots"], parameter)

    def result_of(self, scenario, settings):
        out = self.folder / "-".join([pathlib.Path(scenario).stem, *settings])
        parameters = ", ".join(f"clips_manager.strategy.{name}: {value}" for name, value in settings.items())
        done = cxlab("run", scenario, "--tier", "timed", "--strict-cx", "--quiet", "--out", out,
                     "--set", f"agents[0].params={{{parameters}}}")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads((out / "result.json").read_text())

    def test_an_agent_that_cannot_plan_gives_up(self):
        self.assertIn("error: environment 'agent' gives up: nothing can be planned: no PDDL manager answers at '/pddl_manager' (",
                      self.given_up(SCENARIO, "--set", "servers=[]"))
        rcll = pathlib.Path(SCENARIO).parent
        shutil.copytree(rcll, self.folder / "rcll")
        mine = self.folder / "rcll" / "planning.yaml"
        domain = self.folder / "rcll" / "planning_agent" / "pddl" / "coarse.pddl"
        domain.write_text(domain.read_text().replace(":parameters", ":paramters", 1))
        self.assertRegex(self.given_up(mine), rf"gives up: nothing can be planned: the PDDL manager cannot load \w+: {domain.parent}/.*:\d+: found :paramters")
        domain.unlink()
        self.assertIn("gives up: nothing can be planned: the PDDL manager cannot load", self.given_up(mine))

    def given_up(self, scenario, *arguments):
        done = cxlab("run", scenario, "--tier", "timed", "--quiet", "--out", "none", *arguments)
        self.assertEqual(done.returncode, 4, done.stderr)
        return done.stderr

    def test_games_without_a_plan_have_a_warning(self):
        out = self.folder / "out"
        done = cxlab("run", SCENARIO, "--tier", "timed", "--until", 300, "--set", "planner.budget=10", "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        warnings = json.loads((out / "result.json").read_text())["warnings"]
        self.assertRegex("\n".join(warnings), r"^/pddl_manager: no plan was found in \d+ requests \(TIMEOUT \d+\); a larger planner.budget than 10 gives more time$")
        self.assertIn("warning: " + warnings[0], done.stderr)

    def test_numbers_out_of_range_are_told(self):
        for parameter, found, expected in (("products", "0", "a whole number of at least 1; taken: 3"),
                                           ("alternatives", "-1", "a whole number of at least 1; taken: 3"),
                                           ("patience", "-0.5", "a number of at least 0; taken: 10.0"),
                                           ("patience", ".nan", "a number of at least 0; taken: 10.0")):
            said = self.said_with(f"clips_manager.strategy.{parameter}: {found}")
            self.assertIn(f"strategy.{parameter}: found {found.replace('.nan', 'nan.0')}, expected {expected}", said)

    def test_patience_may_be_without_end(self):
        self.assertEqual(self.said_with("clips_manager.strategy.patience: .inf"), "")

    def test_a_parameter_of_the_wrong_type_ends_the_run(self):
        for parameter, found, code in (("products", "abc", 4), ("alternatives", "2.5", 4), ("patience", "soon", 4),
                                       ("sub_actions", "3", 4), ("dispatch", "5", 3)):
            said = self.said_with(f"clips_manager.strategy.{parameter}: {found}", code)
            self.assertIn(f"parameter 'strategy.{parameter}': found ", said)
            self.assertIn(f" (--set agents[0].params={{clips_manager.strategy.{parameter}: {found}}})", said)

    def test_a_parameter_that_a_strategy_does_not_have_is_told_without_a_hint(self):
        said = self.result_of(SCENARIO, {"dispatch": "greedy", "products": 2})["warnings"]
        self.assertRegex(said[0], "parameter 'strategy.products' was set, but nothing reads it$")

    def said_with(self, parameters, code=0):
        done = cxlab("run", SCENARIO, "--tier", "timed", "--until", 1, "--quiet", "--out", "none",
                     "--set", f"agents[0].params={{{parameters}}}")
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
