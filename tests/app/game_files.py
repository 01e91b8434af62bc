"""Games as files: cxlab new game, world.game, game.yaml of a run, suites of games."""

import csv
import json
import re
import shutil
import subprocess

from lab import CXLAB, SCENARIO, Lab

WORLD = """schema: 1
world: {kind: rcll, robots: 1, production_s: 250, game: games/g.yaml}
tier: timed
"""


class GameFiles(Lab):
    def cxlab(self, *arguments, code=0, cwd=None):
        done = subprocess.run([CXLAB, *map(str, arguments)], cwd=cwd or self.folder, capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, timeout=100)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def run_game(self, out, *arguments):
        """The hash of the journal, and the game as the run's folder has it."""
        self.cxlab("run", *arguments, "--quiet", "--out", out)
        result = json.loads((self.folder / out / "result.json").read_text())
        return result["journal_hash"], (self.folder / out / "game.yaml").read_text()

    def error(self, text, line):
        """The error about a game file, at that line of it."""
        self.write("bad.yaml", text)
        said = self.cxlab("run", "rcll/game", "--quiet", "--out", "none", "--set", "world.game=bad.yaml", code=3).stderr
        self.assertIn(f"bad.yaml:{line}: ", said)
        return said

    def test_a_saved_game_plays_like_the_random_one(self):
        game = "rcll/game", "--tier", "timed", "--set", "world.complexities=[]", "--seed", 5
        random = self.run_game("random", *game)
        self.cxlab("new", "game", "saved.yaml", "--seed", 5)
        self.assertEqual((self.folder / "saved.yaml").read_text(), random[1])
        self.assertEqual(self.run_game("saved", *game, "--set", "world.game=saved.yaml"), random)
        self.assertEqual(self.run_game("copied", *game, "--set", "world.game=random/game.yaml"), random)
        self.assertNotEqual(self.run_game("other", *game[:-1], 6)[1], random[1])
        of_other_seed = self.run_game("of_other_seed", *game[:-1], 6, "--set", "world.game=saved.yaml")
        self.assertEqual(of_other_seed[1], random[1])

    def test_a_run_keeps_the_game_that_it_read(self):
        self.write("scenario.yaml", WORLD.replace("timed", "physics").replace("250", "20"))
        self.assertIn("world.game=games/g.yaml --seed 3", self.cxlab("new", "game", "games/g.yaml", "--seed", 3).stderr)
        self.run_game("out", "scenario.yaml")
        manifest = json.loads((self.folder / "out/manifest.json").read_text())
        self.assertEqual(manifest["world_files"], {"game": "games/g.yaml"})
        self.assertIn('"world/game/g.yaml"', (self.folder / "out/files/index.jsonl").read_text())
        shutil.rmtree(self.folder / "games")
        self.cxlab("replay", "out", "--physics")
        self.assertIn("files of the scenario are missing", self.cxlab("rerun", "out").stderr)
        # A folder from elsewhere, which calls another file the game.
        index = self.folder / "out/files/index.jsonl"
        copies = {line["name"]: line["hash"] for line in map(json.loads, index.read_text().splitlines())}
        index.write_text(index.read_text().replace(copies["world/game/g.yaml"], copies["scenario.yaml"]))
        self.assertIn("g.yaml:1: unknown key 'schema'", self.cxlab("replay", "out", "--physics", code=3).stderr)

    def test_a_path_is_relative_to_the_scenario_or_to_where_the_option_was_given(self):
        self.write("scenario.yaml", WORLD)
        self.write("games/g.yaml", "down: []\n")
        self.write("elsewhere/games/g.yaml", "down: [{machine: RS1, begin_s: 10, end_s: 20}]\n")
        elsewhere = self.folder / "elsewhere"
        self.cxlab("run", "../scenario.yaml", "--quiet", "--out", "a", cwd=elsewhere)
        self.assertRegex((elsewhere / "a/game.yaml").read_text(), r"down:\s+\[\]")
        self.cxlab("run", "../scenario.yaml", "--quiet", "--out", "b", "--set", "world.game=games/g.yaml", cwd=elsewhere)
        self.assertIn("machine: RS1", (elsewhere / "b/game.yaml").read_text())
        self.cxlab("rerun", "elsewhere/b", "--out", "c")
        self.assertIn("machine: RS1", (self.folder / "c/game.yaml").read_text())

    def test_what_a_file_leaves_out_is_drawn(self):
        self.cxlab("new", "game", "whole.yaml", "--seed", 9)
        self.write("prices.yaml", "ring_prices: {RING_BLUE: 2, RING_GREEN: 2, RING_ORANGE: 2, RING_YELLOW: 1}\n")
        self.cxlab("new", "game", "part.yaml", "--seed", 9, "--set", "world.game=prices.yaml")
        prices = re.compile(r"ring_prices:\n(  .*\n)+")
        whole, part = ((self.folder / name).read_text() for name in ("whole.yaml", "part.yaml"))
        self.assertEqual(prices.sub("", whole), prices.sub("", part))
        self.assertIn("RING_GREEN: 2\n", part)
        for never in "world.down=false", "world.game=none.yaml":
            self.write("none.yaml", "down: []\n")
            self.cxlab("new", "game", "quiet.yaml", "--force", "--set", never)
            self.assertRegex((self.folder / "quiet.yaml").read_text(), r"down:\s+\[\]\n")

    def test_new_game_overwrites_nothing_unasked(self):
        self.write("g.yaml", "mine")
        self.assertIn("--force", self.cxlab("new", "game", "g.yaml", code=2).stderr)
        self.assertEqual((self.folder / "g.yaml").read_text(), "mine")
        self.cxlab("new", "game", "g.yaml", "--force")
        self.write("turtles.yaml", "schema: 1\nworld: {kind: turtlesim}\n")
        said = self.cxlab("new", "game", "h.yaml", "--scenario", "turtles.yaml", code=3).stderr
        self.assertIn("turtles.yaml:2: world.kind: found 'turtlesim', expected rcll", said)

    def test_errors_have_line_and_key(self):
        self.assertIn("did you mean 'ring_prices'", self.error("down: []\nring_price: {}\n", 2))
        self.assertIn("orders[1].cap_color: found 'CAP_GRAY', expected one of CAP_BLACK, CAP_GREY (did you mean CAP_GREY?)",
                      self.error("orders:\n  - {}\n  - cap_color: CAP_GRAY\n", 3))
        self.assertIn("down[0].machine: found 'RS3', expected one of BS, CS1",
                      self.error("down:\n  - {machine: RS3, begin_s: 1, end_s: 2}\n", 2))
        self.assertIn("down[0].end_s: found 2, expected a time after begin_s",
                      self.error("down:\n  - {machine: RS1, begin_s: 2, end_s: 2}\n", 2))
        self.assertIn("ring_prices.RING_GREEN: found 3, expected 0 to 2",
                      self.error("ring_prices:\n  RING_BLUE: 0\n  RING_GREEN: 3\n  RING_ORANGE: 0\n  RING_YELLOW: 0\n", 3))
        self.assertIn("RING_YELLOW", self.error("ring_prices: {RING_BLUE: 0, RING_GREEN: 1, RING_ORANGE: 2}\n", 1))
        self.assertIn("layout[0].zone: found 'C_Z99'", self.error("layout:\n  - machine: C-BS\n    zone: C_Z99\n", 3))
        self.assertIn("layout: C-CS1 is missing", self.error("layout:\n  - {machine: C-BS, zone: C_Z23}\n", 2))
        self.assertIn("overtime.delivery_gate: found 4, expected 1 to 3", self.error("overtime:\n  delivery_gate: 4\n", 2))
        self.assertIn("overtime.delivery_end: found 1e+30", self.error("overtime:\n  delivery_end: 1e30\n", 2))

    def test_games_that_cannot_be_are_errors_with_line_and_key(self):
        self.cxlab("new", "game", "g.yaml", "--seed", 4)
        lines = (self.folder / "g.yaml").read_text().splitlines()
        machine = next(i for i, text in enumerate(lines) if "machine: M-BS" in text)
        for key, value in ("zone", "M_Z11"), ("rotation", "45"):
            at = next(i for i in range(machine, len(lines)) if f"{key}:" in lines[i])
            text = "\n".join([*lines[:at], f"    {key}: {value}", *lines[at + 1:]]) + "\n"
            said = self.error(text, at + 1)
            self.assertIn(f"layout[7].{key}: found {value}, expected ", said)
            self.assertIn("opposite to C-BS; a field that is not mirrored has 'mirrored: false'", said)
            self.write("free.yaml", "mirrored: false\n" + text)
            self.cxlab("new", "game", "again.yaml", "--force", "--set", "world.game=free.yaml")
            again = (self.folder / "again.yaml").read_text()
            self.assertTrue(again.startswith("mirrored: false\n"))
            self.cxlab("new", "game", "again.yaml", "--force", "--set", "world.game=again.yaml")
        self.assertIn("orders: found an empty list, expected an order at least", self.error("down: []\norders: []\n", 2))
        self.assertIn("down[1].begin_s: found 30, expected a time at which RS1 is not down: down[0] is from 10 to 40",
                      self.error("down:\n  - {machine: RS1, begin_s: 10, end_s: 40}\n  - {machine: RS1, begin_s: 30, end_s: 50}\n", 3))
        self.assertIn("down[0].begin_s: found 1500, expected a time before the end of the game at 1500",
                      self.error("down:\n  - {machine: RS1, begin_s: 1500, end_s: 1540}\n", 2))
        order = "orders:\n  - {complexity: C0}\n  - {complexity: C0, %s}\n"
        self.assertIn("orders[1].delivery_begin: found 1250, expected a time before the end of the game at 1200",
                      self.error(order % "delivery_begin: 1250, delivery_end: 1300", 3))
        self.assertIn("orders[1].activate_at: found 1200, expected a time before delivery_end", self.error(order % "activate_at: 1200", 3))
        self.assertIn("orders[1].activate_at: found 1250, expected a time before the end of the game at 1200",
                      self.error(order % "activate_at: 1250, delivery_end: 1300", 3))
        self.assertIn("orders[1].delivery_end: found 200, expected a time after delivery_begin",
                      self.error(order % "delivery_begin: 300, delivery_end: 200", 3))
        self.assertIn("orders[1].ring_colors: found RING_BLUE on RING_BLUE",
                      self.error((order % "ring_colors: [RING_BLUE, RING_BLUE]").replace("  - {complexity: C0, ring", "  - {complexity: C2, ring"), 3))
        self.assertIn("overtime.delivery_begin: found 1500", self.error("overtime: {delivery_begin: 1500, delivery_end: 1600}\n", 1))

    def test_a_list_beside_the_file_is_an_error(self):
        self.write("g.yaml", "down: []\n")
        for key, value in ("orders", "[{}]"), ("layout", "[{machine: C-BS, zone: C_Z23}]"):
            self.write("scenario.yaml", f"schema: 1\nworld:\n  kind: rcll\n  game: g.yaml\n  {key}: {value}\n")
            self.fails(3, f"scenario.yaml:5: world.{key}: found a list beside world.game, expected only one of the two")
        self.write("scenario.yaml", "schema: 1\nworld:\n  kind: rcll\n  game: gone.yaml\n")
        self.fails(3, "scenario.yaml:4: world.game: there is no file gone.yaml")

    def test_a_folder_of_games_is_a_suite(self):
        self.write("scenario.yaml", WORLD.replace(", game: games/g.yaml", ""))
        (self.folder / "it's").mkdir()
        for seed in 1, 2:
            self.cxlab("new", "game", f"it's/g{seed}.yaml", "--seed", seed)
        self.write("suite.yaml", 'scenarios: [scenario.yaml]\ngames: "it\'s"\nstrategies: {one: [], none: [world.robots=0]}\n')
        for _ in range(2):
            done = self.cxlab("bench", "suite.yaml", "--out", "bench")
        self.assertIn("4 rows are current and kept", done.stderr)
        rows = list(csv.DictReader((self.folder / "bench/rows.csv").read_text().splitlines()))
        self.assertEqual([(r["strategy"], r["game"], r["seed"], r["status"]) for r in rows],
                         [(s, g, "1", "completed") for s in ("one", "none") for g in ("g1", "g2")])
        self.assertEqual(len({r["journal_hash"] for r in rows}), 4)
        self.cxlab("bench", "page", "bench", "--out", "page.html")
        shown = set(re.findall(r">([^<>]*), seed 1\b", (self.folder / "page.html").read_text()))
        self.assertEqual(shown, {"g1", "g2"})
        self.write("few.yaml", (self.folder / "suite.yaml").read_text() + "require: mean(points) >= 0\n")
        self.assertIn("scenario, one: found 2 games, expected at least 10 to answer anything; add games to the suite's folder of games\n",
                      self.cxlab("bench", "few.yaml", "--out", "bench", code=6).stdout)
        self.write("it's/g2.yaml", "down: []\n")
        self.assertIn("2 rows are current and kept", self.cxlab("bench", "suite.yaml", "--out", "bench").stderr)
        self.write("it's/g2.yaml", "up: []\n")
        self.assertIn("g2.yaml:1: ", self.cxlab("bench", "suite.yaml", "--out", "bench", code=3).stderr)
        self.write("suite.yaml", "scenarios: [scenario.yaml]\ngames: nowhere\nstrategies: {one: []}\n")
        self.assertIn("suite.yaml:2: games: found 'nowhere', expected a folder",
                      self.cxlab("bench", "suite.yaml", "--out", "bench", code=3).stderr)

    def test_a_row_of_a_crash_counts_until_the_file_of_its_game_changes(self):
        self.agent("(defrule endless (time ?) => (while TRUE do (bind ?x 1)))", WORLD.replace(", game: games/g.yaml", "") + SCENARIO.split("\n", 2)[2])
        for seed in 1, 2:
            self.cxlab("new", "game", f"games/g{seed}.yaml", "--seed", seed)
        self.write("suite.yaml", "scenarios: [scenario.yaml]\ngames: games\nstrategies: {one: []}\n")
        self.cxlab("bench", "suite.yaml", "--out", "crashed", "--quiet", "--time-limit", 0.5, code=1)
        self.cxlab("new", "game", "games/g1.yaml", "--seed", 3, "--force")
        self.assertIn("1 of 2 cells has a row; 1 row was taken", self.cxlab("bench", "suite.yaml", "--collect", "crashed", "--out", "c", code=1).stderr)
