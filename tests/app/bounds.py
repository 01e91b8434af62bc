"""benchmarks/upper_bound.py: bounds that can be reckoned by hand, and the shipped agents below theirs."""

import importlib.util
import os
import pathlib
import subprocess
import sys

from lab import CXLAB, Lab

SCRIPT = pathlib.Path(os.environ["CXLAB_SOURCE_DIR"]) / "benchmarks/upper_bound.py"
ROTATIONS = {"C": 0, "M": 180}  # the halves mirror each other
# BS, RS1, CS1 and DS in a row, from each output to the next input 0.65 m and half a turn: pi / 0.9 + 0.9 / 1.2 = 4.241 s.
LAYOUT = {"BS": "C_Z74", "RS1": "C_Z54", "CS1": "C_Z34", "DS": "C_Z14", "SS": "C_Z17", "RS2": "C_Z37", "CS2": "C_Z57"}
# Handling less one sigma: pick 15.5 - 2 - 0.4, place 15.3 - 0.6, and of a drive what is more than 2.3 s:
#   from a station to the next: 13.1 + 1.941 + 14.7 + 1.941 = 31.681; a carrier, at 0.1 m from the input: 13.1 + 14.7 = 27.8.
# A C1 with a free ring takes 3 * 31.681 + 27.8 = 122.84 s of a robot. From ready to the next input: 10.8 + 16.641 = 27.441 s.
# The first base is at RS1 after 34.370 s (2.993 m from the robot's start to the base station: 6.930 s). The product is delivered
# (21.502 + 27.441) + (21.694 + 27.441) + 5.284 s later, at 137.73 s.
C1 = 30 + 10 + 5 + 2
EXPLORATION, EXTRAS = 14, 16


def order(complexity, *rings, begin=0, end=1200, competitive="false"):
    ring_lines = [f"      - {ring}" for ring in rings] or ["      []"]
    return [f"  - complexity: {complexity}", "    base_color: BASE_RED", "    ring_colors:", *ring_lines, "    cap_color: CAP_GREY",
            "    activate_at: 0", f"    delivery_begin: {begin}", f"    delivery_end: {end}", "    delivery_gate: 1",
            "    quantity: 1", f"    competitive: {competitive}"]


def game(orders, orange=0):
    lines = ["layout:"]
    for name, zone in LAYOUT.items():
        for team, half in (("C", zone), ("M", "M" + zone[1:])):
            lines += [f"  - machine: {team}-{name}", f"    zone: {half}", f"    rotation: {ROTATIONS[team]}"]
    prices = {"BLUE": 0, "GREEN": 1, "ORANGE": orange, "YELLOW": 2}
    lines += ["ring_prices:", *(f"  RING_{colour}: {price}" for colour, price in prices.items()), "orders:"]
    return "\n".join([*lines, *(line for order in orders for line in order), "down:", "  []", ""])


class Bounds(Lab):
    def script(self, *arguments, code=0):
        done = subprocess.run([sys.executable, SCRIPT, *map(str, arguments)], capture_output=True, text=True, timeout=60,
                              stdin=subprocess.DEVNULL, cwd=self.folder)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout if code == 0 else done.stderr

    def bound(self, orders, *arguments, orange=0):
        (self.folder / "g.yaml").write_text(game(orders, orange))
        return int(self.script("g.yaml", *arguments).splitlines()[2].split("|")[2])

    def test_all_points_of_a_game_with_room(self):
        bound = self.bound
        self.assertEqual(bound([order("C1", "RING_ORANGE")]), C1 + EXTRAS + EXPLORATION)
        self.assertEqual(bound([order("C1", "RING_ORANGE")], orange=2), C1 + 15 + 4 + EXTRAS + EXPLORATION)
        self.assertEqual(bound([order("C1", "RING_ORANGE", competitive="true")]), C1 + 10 + EXTRAS + EXPLORATION)
        c3 = order("C3", "RING_BLUE", "RING_GREEN", "RING_YELLOW")
        self.assertEqual(bound([c3]), 100 + 10 + 5 + (10 + 2) + (20 + 4) + 2 + EXTRAS + EXPLORATION)

    def test_late_by_the_shortest_way_through_the_stations(self):
        rest = EXTRAS + EXPLORATION
        self.assertEqual(self.bound([order("C1", "RING_ORANGE", end=138)]), C1 + rest)
        self.assertEqual(self.bound([order("C1", "RING_ORANGE", end=137)]), C1 - 5 + rest)
        self.assertEqual(self.bound([order("C1", "RING_ORANGE", begin=4, end=84)]), C1 - 16 + rest)  # 53.7 of 80 s
        # A C0 waits for its cap: 33.141 for the carrier, 37.494 until CS1 is idle, 21.694 + 27.441 + 5.284 from there, so 125.05 s;
        # from the storage it comes in 26.918 + 19.924 + 5.284 = 52.13 s.
        self.assertEqual(self.bound([order("C0", begin=50, end=126)]), 20 + 10 + 2 + rest)
        self.assertEqual(self.bound([order("C0", begin=50, end=125)]), 20 - 3 + 10 + 2 + rest)
        self.assertEqual(self.bound([order("C0", begin=50, end=60)]), 20 + 10 - 5 + rest)
        self.assertEqual(self.bound([order("C0", begin=48, end=52)]), 20 - 3 + 10 - 5 + rest)

    def test_robots_that_have_no_more_time(self):
        # (1200 - 5.284) / 122.84 = 9.7 products, and 1200 - 9 * 122.84 = 94.4 s for three carriers more.
        orders = [order("C1", "RING_ORANGE")] * 10
        self.assertEqual(self.bound(orders, "--robots", 1), 9 * C1 + 3 * 2 + EXPLORATION)
        self.assertEqual(self.bound(orders, "--robots", 2), 10 * C1 + EXTRAS + EXPLORATION)
        # Measured handling: 3 * (31.681 + 5.4 + 3.9) + 27.8 + 8.7 + 3.9 = 163.3 s; 7 products, and 56.6 s for one carrier of 40.4 s.
        self.assertEqual(self.bound(orders, "--robots", 1, "--durations", "measured"), 7 * C1 + 2 + EXPLORATION)
        # By 376 s three of them, 3 * 122.84 + 5.284 = 373.8; by 373 s two, and one that is late.
        three = [order("C1", "RING_ORANGE", begin=276, end=376)] * 3
        self.assertEqual(self.bound(three, "--robots", 1), 3 * C1 + EXTRAS + EXPLORATION)
        three = [order("C1", "RING_ORANGE", begin=273, end=373)] * 3
        self.assertEqual(self.bound(three, "--robots", 1), 3 * C1 - 5 + EXTRAS + EXPLORATION)

    def test_a_station_that_has_no_more_time(self):
        # CS1 has until 1183.1 s, with the product that is delivered last gone: 33.1 + 15 * 2 * 37.494 = 1157.9.
        orders = [order("C1", "RING_ORANGE")] * 16
        self.assertEqual(self.bound(orders), 15 * C1 + EXTRAS + EXPLORATION)

    def test_many_orders(self):
        self.assertEqual(self.bound([order("C1", "RING_ORANGE")] * 40, "--robots", 1), 9 * C1 + 3 * 2 + EXPLORATION)
        orders = [order(f"C{i % 4}", *["RING_BLUE", "RING_GREEN", "RING_YELLOW"][:i % 4], begin=20 * i, end=20 * i + 150 + 7 * i % 40)
                  for i in range(40)]
        bound = self.bound(orders)
        self.assertGreater(bound, self.bound(orders[:30]))
        self.assertLess(bound, 20 * 100)

    def test_a_search_that_ends_early_gives_a_higher_bound(self):
        specification = importlib.util.spec_from_file_location("upper_bound", SCRIPT)
        tool = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(tool)
        of_game = tool.read_game(game([order("C1", "RING_ORANGE", begin=276, end=376)] * 4))
        exact = tool.upper_bound(of_game, robots=1)
        tool.MOST_NODES = 0
        early = tool.upper_bound(of_game, robots=1)
        self.assertEqual((exact, early), (4 * C1 - 22 + EXTRAS + EXPLORATION, 4 * C1 + EXTRAS + EXPLORATION))

    def test_runs_and_rows_beside_their_bounds(self):
        for scenario in ("rcll/game", "rcll/planning"):
            subprocess.run([CXLAB, "run", scenario, "--tier", "timed", "--seed", "101", "--quiet", "--out", self.folder / scenario],
                           check=True, capture_output=True, stdin=subprocess.DEVNULL, timeout=100)
        columns = "scenario,strategy,game,seed,status,exit,points\n"
        (self.folder / "rows.csv").write_text(columns + "game,lazy,,101,completed,0,0.0\ngame,crashed,,101,crashed,70,\ngame,broken,,101,failed,4,0.0\n")
        done = subprocess.run([sys.executable, SCRIPT, "rcll/game", "rcll/planning", "rows.csv"], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr),
                         (0, "not counted: crashed in game 101 (crashed, exit code 70), broken in game 101 (failed, exit code 4)\n"))
        lines = done.stdout.splitlines()
        self.assertRegex(lines[0], r"^\| Game \| Bound \| game \| planning \| lazy \|$")
        self.assertRegex(lines[2], r"^\| 101 \| 823 \| \d+ \(\d+%\) \| \d+ \(\d+%\) \| 0 \(0%\) \|$")
        (self.folder / "rows.csv").write_text(columns + "game,lucky,,101,completed,0,824\n")
        self.assertIn("more than the bound: lucky in game 101", self.script("rcll/game", "rows.csv", code=1))
        self.assertIn("no game 101", self.script("rows.csv", code=3))
        subprocess.run([CXLAB, "run", "rcll/game", "--tier", "timed", "--set", "world.production_s=300", "--set", "world.overtime_s=0", "--quiet", "--out",
                        self.folder / "short"], check=True, capture_output=True, stdin=subprocess.DEVNULL, timeout=100)
        self.assertIn("short: found a run in the timed tier of 300.0 s with 3 robots, expected one in the timed tier of 1200 s",
                      self.script("short", code=3))
        self.assertIn("one team with 2 robots", self.script("rcll/game", "--robots", 2, code=3))

    def test_games_as_people_write_them(self):
        bound = self.bound([order("C1", "RING_ORANGE")])
        layout = ",\n  ".join(f"{{machine: {team}-{name}, zone: {zone if team == 'C' else 'M' + zone[1:]}, rotation: {ROTATIONS[team]}}}"
                              for name, zone in LAYOUT.items() for team in "CM")
        (self.folder / "flow, [1].yaml").write_text(
            f"layout: [{layout}]  # in a row\n"
            "ring_prices: {RING_BLUE: 0, RING_GREEN: 1, RING_ORANGE: 0, RING_YELLOW: 2}\n"
            "orders:\n- {complexity: C1, base_color: 'BASE_RED', ring_colors: [RING_ORANGE], cap_color: CAP_GREY, activate_at: 0,\n"
            "   delivery_begin: 0, delivery_end: 1200, delivery_gate: 1, quantity: 1, competitive: no}\n")
        self.assertIn(f"| flow, [1] | {bound} |", self.script("flow, [1].yaml"))

    def test_an_unusable_file_is_reported_in_one_line(self):
        (self.folder / "run").mkdir()
        (self.folder / "part.yaml").write_text("ring_prices: {RING_BLUE: 0, RING_GREEN: 1, RING_ORANGE: 0, RING_YELLOW: 2}\n")
        (self.folder / "wrong.yaml").write_text("orders:\n  - {complexity: C7}\n")
        (self.folder / "rows.csv").write_text("seed,points\n1,2\n")
        for said, *arguments in (
                ("none.yaml: there is no such file or folder", "none.yaml"),
                ("none.csv: No such file or directory", "none.csv"),
                ("run: no run of a game: result.json is missing", "run"),
                ("part.yaml: layout is left out, and drawn from the seed of a run: name the folder of a run of it", "part.yaml"),
                ("rows.csv: no rows of cxlab bench: the column game is missing", "rows.csv")):
            self.assertEqual(self.script(*arguments, code=3), f"error: {said}\n")
        self.assertRegex(self.script("wrong.yaml", code=3), r"^error: .*wrong.yaml:2: .*'C7'.*\n$")
        (self.folder / "run/result.json").write_text("{}")
        self.assertEqual(self.script("run", code=3), "error: run: no run of a game: game.yaml is missing\n")
        (self.folder / "run/game.yaml").write_text("layout:\n")
        self.assertEqual(self.script("run", code=3), "error: run: not as cxlab writes it: KeyError('tier')\n")
        self.assertIn("the following arguments are required", self.script(code=2))
