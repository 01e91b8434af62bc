#!/usr/bin/env python3
"""The most points that any agent could reach in a game of the Logistics League, timed tier, rules `league`.

    benchmarks/upper_bound.py GAME.yaml ...   game files as `cxlab run --set world.game=GAME.yaml` plays them
    benchmarks/upper_bound.py RUN ...         the games of runs (folders), the points of each scenario's runs, and their share
    benchmarks/upper_bound.py RUN ... rows.csv    also the rows of a `cxlab bench` with the same games: each strategy's

Runs are whole games: of 1,200 s of production, in the timed tier, one team. Rows of episodes that were not played to their end are
named and not counted.

The schedule behind the bound knows the future, and only those limits hold that are easy to prove:

- All is known at 0: orders, prices, machines. Products may be made before their order comes in. All points of
  exploration are earned at no cost, and a competitive order is delivered first.
- A robot takes a product from the base station to each ring station, the cap station and the delivery station. Each cap also takes
  a carrier to the cap station, and each payment a base to the slide. A C0 may come from the storage instead (-5).
  Pieces are picked at outputs and shelves and placed at inputs and slides.
- A robot that carries a piece needs time for four parts. It drives from the nearest place where it may have placed something (or
  started), picks, drives along the straight line, and places. They take as long as a `transport`, with handling SIGMAS
  standard deviations under its mean. The mean of the many handlings of a game is never shorter than that. Robots are never in
  each other's way.
- The work for all products that are delivered by a time takes robots no longer than that time. It takes a ring or cap station no
  longer than from its first piece on. Within that the order of work is free, and pieces wait for nothing.
- A product is delivered only when enough time has passed for all its stations.
- Rings and caps are mounted on products that are delivered. At the end each slide may have UNUSED_PAYMENTS
  more, each cap station a cap more, if robots have time for that.

Any schedule that holds to this delivers each order in time, late by so many quarters of its window, or never. The bound is the best of
all such choices within the limits. If a game has so many orders that this takes too long, the search ends early. For the part that it
has not searched, each limit then holds alone, for all the work together. That bound is higher, but still a bound.
"""
import argparse
import collections
import csv
import heapq
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

POINTS = {"C0": 20, "C1": 30, "C2": 50, "C3": 100}
RING_POINTS = (5, 10, 20)  # by price
CAP_POINTS, BUFFER_POINTS, PAYMENT_POINTS, COMPETITIVE_POINTS, STORAGE_POINTS = 10, 2, 2, 10, -5
EXPLORATION_POINTS = 14
UNUSED_PAYMENTS = 3
RINGS_OF = {"RING_ORANGE": "RS1", "RING_GREEN": "RS1", "RING_BLUE": "RS2", "RING_YELLOW": "RS2"}
CAPS_OF = {"CAP_GREY": "CS1", "CAP_BLACK": "CS2"}

# docs/reference/rcll.md, Machines; sim/traffic/trajectory.h; docs/reference/skills.md, The timed tier. SI units.
BELT_IN, BELT_OUT, WAIT_IDLE = 1.538, 2.656, 5
CAP_TIME, RING_TIME, GATE_TIME = 17.5, 17.308, 3.746
SPEED, SPEED_UP, SLOW_DOWN, TURN, TURN_UP = 0.5, 0.36, 1.0, 0.9, 1.2
HANDLING = {"physics": {"pick": 15.5, "shelf": 15.5, "place": 15.3, "slide": 15.3},
            "measured": {"pick": 20.9, "shelf": 24.2, "place": 19.2, "slide": 23.5}}
PICK_SIGMA, PLACE_SIGMA, SIGMAS = 0.4, 0.6, 1
LOOK_AHEAD, CHECK = 2.3, 2.0  # s that a transport saves: of what it drives before each handling, and of its pick
# Where robots stand, seen from the middle of a machine: x, y, and the direction that they look in.
STANDING = {"INPUT": (0.675, -0.025, math.pi), "OUTPUT": (-0.675, -0.025, 0), "SLIDE": (0.675, 0.25, math.pi),
            "SHELF-LEFT": (0.675, 0.075, math.pi), "SHELF-MIDDLE": (0.675, 0.175, math.pi), "SHELF-RIGHT": (0.675, 0.275, math.pi)}
PRODUCTION = 1200
UNIT = 0.5  # s
MOST_NODES = 50000  # of the search, some seconds


def read_game(text):
    """The game of a file as cxlab writes it: keys, lists of "- key: value" blocks, and lists of words."""
    game, blocks, table, words = {}, [], {}, []
    for line in text.splitlines():
        depth, item = len(line) - len(line.lstrip(" ")), line.strip()
        if depth == 0 and item.endswith(":"):
            game[item[:-1]] = blocks = []
            table = {}
        elif item == "[]":
            continue
        elif item.startswith("- ") and ": " not in item:
            words.append(item[2:])
        else:
            if item.startswith("- "):
                table = {}
                blocks.append(table)
            elif not table:
                blocks.append(table)
            key, _, value = item.removeprefix("- ").partition(":")
            words = [] if not value else words
            table[key] = value.strip() or words
    return game


def drive_time(a, b):
    """The time for the straight way between two poses, from rest to rest, turning meanwhile."""
    way, turn = math.dist(a[:2], b[:2]), abs(math.remainder(b[2] - a[2], 2 * math.pi))
    ramps = 1 / SPEED_UP + 1 / SLOW_DOWN
    straight = way / SPEED + SPEED / 2 * ramps if way > SPEED**2 / 2 * ramps else math.sqrt(2 * way * ramps)
    turning = turn / TURN + TURN / TURN_UP if turn > TURN**2 / TURN_UP else 2 * math.sqrt(turn / TURN_UP)
    return max(straight, turning)


class Field:
    """Where robots pick and place, and the least times for that."""

    def __init__(self, layout, robots, durations):
        self.handling = HANDLING[durations]
        self.spots = {}
        for machine in layout:
            team, name = machine["machine"].split("-")
            if team != "C":
                continue
            zone, turn = machine["zone"], math.radians(float(machine["rotation"]))
            x, y = (float(zone[3]) - 0.5) * (1 if zone[0] == "C" else -1), float(zone[4]) - 0.5
            for spot, (forward, left, looks) in STANDING.items():
                self.spots[name, spot] = (x + forward * math.cos(turn) - left * math.sin(turn),
                                          y + forward * math.sin(turn) + left * math.cos(turn), turn + looks)
        self.picked = [("BS", "INPUT"), *((machine, "OUTPUT") for machine in ("BS", "CS1", "CS2", "RS1", "RS2", "SS"))]
        self.picked += [(machine, spot) for machine in ("CS1", "CS2") for spot in STANDING if spot.startswith("SHELF")]
        placed = [("RS1", "SLIDE"), ("RS2", "SLIDE"), *((m, "INPUT") for m in ("CS1", "CS2", "RS1", "RS2", "SS", "DS"))]
        self.starts = [(4.5 + i, 0.5, math.pi / 2) for i in range(robots)]
        self.begins = self.starts + [self.spots[spot] for spot in placed]

    def handle(self, drive, kind):
        """A drive and the handling at its end."""
        sigma, check = (PLACE_SIGMA, 0) if kind in ("place", "slide") else (PICK_SIGMA, CHECK)
        return max(drive - LOOK_AHEAD, 0) + self.handling[kind] - check - SIGMAS * sigma

    def bring(self, source, machine, spot="INPUT"):
        """From the gripper's closing at the source until the piece lies at the machine."""
        drive = drive_time(self.spots[source], self.spots[machine, spot])
        return self.handle(drive, "slide" if spot == "SLIDE" else "place")

    def carry(self, sources, machine, spot="INPUT", first=False):
        """The least time to bring something from one of the sources, the drive there included; first: from a robot's start."""
        def fetch(source):
            drive = min(drive_time(pose, self.spots[source]) for pose in (self.starts if first else self.begins))
            return self.handle(drive, "shelf" if source[1].startswith("SHELF") else "pick")
        return min(fetch(source) + self.bring(source, machine, spot) for source in sources)

    def pick_at_once(self):
        """The time to pick for a robot that drives up exactly when the piece is ready."""
        return self.handle(0, "pick") - LOOK_AHEAD

    def pass_on(self, spot, machine):
        """From when something is ready at the spot until it lies at the machine's input."""
        return self.pick_at_once() + self.bring(spot, machine)

    def busy(self, work):
        """How long a station has to do with a piece, until it is idle again."""
        return BELT_IN + work + BELT_OUT + self.pick_at_once() + WAIT_IDLE


# A way to deliver an order. Jobs: (resource, until, seconds), so much work that must be done by then.
Option = collections.namedtuple("Option", "points jobs")


def options_of(order, prices, field):
    """The ways to deliver an order, best first: made, or from the storage; in time, or in a quarter after its window."""
    begin, end = float(order["delivery_begin"]), float(order["delivery_end"])
    worth = POINTS[order["complexity"]]
    rings, cap_station = order["ring_colors"], CAPS_OF[order["cap_color"]]
    way = ["BS", *(RINGS_OF[ring] for ring in rings), cap_station, "DS"]
    with_it = CAP_POINTS + sum(RING_POINTS[prices[ring]] for ring in rings)
    with_it += COMPETITIVE_POINTS if order["competitive"] == "true" else 0
    before_it = BUFFER_POINTS + PAYMENT_POINTS * sum(prices[ring] for ring in rings)

    bases = [("BS", "INPUT"), ("BS", "OUTPUT")]
    robots = field.carry(bases, way[1]) + sum(field.carry([(a, "OUTPUT")], b) for a, b in zip(way[1:], way[2:]))
    robots += field.carry(field.picked, cap_station)
    robots += sum(prices[ring] * field.carry(field.picked, RINGS_OF[ring], "SLIDE") for ring in rings)
    # When the product lies at the input of each station at the earliest.
    works = [CAP_TIME if station == cap_station else RING_TIME for station in way[1:-1]]
    lies = [field.carry(bases, way[1], first=True)]
    for station, following, work in zip(way[1:], way[2:], works):
        lies.append(lies[-1] + BELT_IN + work + BELT_OUT + field.pass_on((station, "OUTPUT"), following))
    carrying, stored = (field.carry([("SS", "OUTPUT")], "DS", first=first) for first in (False, True))

    options = []
    for quarters in range(5):
        until = min(PRODUCTION, end + quarters * (end - begin) / 4) if quarters < 4 else PRODUCTION
        slack = until - lies[-1] - BELT_IN - GATE_TIME
        points = worth - worth * quarters * 3 // 16 + with_it
        jobs = [("robots", lies[-1] + slack, robots), (cap_station, lies[-2] + slack, field.busy(CAP_TIME))]
        # A station may still be busy with the product's last stay there when the product is delivered.
        jobs += [(station, lie + slack + field.busy(work), field.busy(work)) for station, lie, work in zip(way[1:], lies, works)]
        if slack >= 0:
            options.append(Option(points + before_it, jobs))
        if order["complexity"] == "C0" and stored + BELT_IN + GATE_TIME <= until:
            options.append(Option(points + STORAGE_POINTS, [("robots", until - BELT_IN - GATE_TIME, carrying)]))
        if until == PRODUCTION:
            break
    return sorted(options, key=lambda option: -option.points)


def in_time(jobs, workers, begin):
    """Whether so many workers, from `begin` on, can do the jobs, each in time."""
    done = begin
    for until, seconds in sorted(jobs):
        done += seconds / workers
        if done > until + 1e-6:
            return False
    return True


def hopes_of(orders, resource, workers, begin, extras):
    """A function of i and of the seconds of work that a resource has already. It gives the most points from the orders from the i-th on,
    if all the work together, in whole UNITs rounded down, ends when the last job must be done.
    """
    last = max((until for options in orders for option in options for name, until, _ in option.jobs if name == resource), default=0)
    size = max(1, math.ceil(workers * (max(last, PRODUCTION) - begin) / UNIT) + 2)
    points = [[extras((left + 1) * UNIT) for left in range(size)]]
    for options in reversed(orders):
        ways = [points[-1]]
        for option in options:
            work = min(size, int(sum(seconds for name, _, seconds in option.jobs if name == resource) / UNIT))
            ways.append([-1] * work + [more + option.points for more in points[-1][:size - work]])
        points.append(list(map(max, *ways)))
    points.reverse()
    return lambda i, done: points[i][max(0, size - 1 - int(done / UNIT))]


def upper_bound(game, robots=3, durations="physics"):
    """The most points in the game."""
    field = Field(game["layout"], robots, durations)
    prices = {colour: int(price) for colour, price in game["ring_prices"][0].items()}
    orders = [options_of(order, prices, field) for order in game["orders"] for _ in range(int(order["quantity"]))]
    orders = sorted(filter(None, orders), key=lambda options: -options[0].points)
    limits = {station: (1, field.carry(field.picked, station, first=True)) for station in ("CS1", "CS2", "RS1", "RS2")}
    limits["robots"] = (robots, 0)
    most_extras = 2 * UNUSED_PAYMENTS + 2
    extra_time = min([field.carry(field.picked, station, "SLIDE") for station in ("RS1", "RS2")] +
                     [field.carry(field.picked, station) for station in ("CS1", "CS2")])
    extra_points = max(PAYMENT_POINTS, BUFFER_POINTS)

    def extras(left):
        return extra_points * min(most_extras, int(left / extra_time))

    hopes = {resource: hopes_of(orders, resource, workers, begin, extras if resource == "robots" else lambda left: extra_points * most_extras)
             for resource, (workers, begin) in limits.items()}

    def hope(i, jobs):
        return min(hopes[resource](i, sum(seconds for _, seconds in jobs[resource])) for resource in limits)

    # The best node first: its hope is a bound of all that is not searched yet. A node: orders decided, points, jobs, last choice.
    nothing = {resource: () for resource in limits}
    nodes, made = [(-hope(0, nothing), 0, 0, 0, nothing, 0)], 0
    while True:
        bound, depth, _, points, jobs, last = heapq.heappop(nodes)
        i = -depth
        if i > len(orders) or made > MOST_NODES:
            return -bound + EXPLORATION_POINTS
        if i == len(orders):
            points += extras(robots * PRODUCTION - sum(seconds for _, seconds in jobs["robots"]))
            heapq.heappush(nodes, (-points, depth - 1, made, points, jobs, 0))
            continue
        alike = i > 0 and orders[i] == orders[i - 1]  # then the earlier one is delivered in the better way
        for choice, option in enumerate([*orders[i], Option(0, [])]):
            if alike and choice < last:
                continue
            then = dict(jobs)
            for resource, *job in option.jobs:
                then[resource] = (*then[resource], tuple(job))
            if all(in_time(then[resource], *limits[resource]) for resource in {job[0] for job in option.jobs}):
                made += 1
                reach = min(-bound, points + option.points + hope(i + 1, then))
                heapq.heappush(nodes, (-reach, depth - 1, made, points + option.points, then, choice))


class BadInput(Exception):
    """What cannot be used, and why."""


def program():
    """$CXLAB, the cxlab of this tree, or the one that is installed."""
    built = pathlib.Path(__file__).resolve().parents[1] / "build/release/cxlab"
    found = os.environ.get("CXLAB") or (built if built.exists() else shutil.which("cxlab"))
    if not found:
        raise BadInput("no cxlab to read game files with: build it with ./dev run; or name the folders of runs")
    return found


def game_of_file(path):
    """The game of any file that a run plays: cxlab writes it in its own way."""
    drawn = []
    with tempfile.TemporaryDirectory(prefix="cxlab-bound-") as folder:
        for seed in "1", "2":
            out = pathlib.Path(folder) / seed
            done = subprocess.run([program(), "new", "game", out, "--seed", seed, "--set", f"world.game={json.dumps(str(path.resolve()))}"],
                                  capture_output=True, text=True, stdin=subprocess.DEVNULL)
            if done.returncode != 0:
                raise BadInput((done.stderr.strip().splitlines() or [f"{path}: cxlab cannot read it"])[0].removeprefix("error: "))
            drawn.append(read_game(out.read_text()))
    for part in "layout", "ring_prices", "orders":
        if drawn[0][part] != drawn[1][part]:
            raise BadInput(f"{path}: {part} is left out, and drawn from the seed of a run: name the folder of a run of it")
    return drawn[0]


def game_of_run(path, robots):
    """Seed, scenario and points of a run, and its game."""
    try:
        result = json.loads((path / "result.json").read_text())
        game = (path / "game.yaml").read_text()
    except FileNotFoundError as missing:
        raise BadInput(f"{path}: no run of a game: {pathlib.Path(missing.filename).name} is missing") from None
    if result["tier"] != "timed" or len(result["robots"]) != robots or result["sim_time_s"] != PRODUCTION:
        raise BadInput(f"{path}: found a run in the {result['tier']} tier of {result['sim_time_s']} s with {len(result['robots'])} robots, "
                       f"expected one in the timed tier of {PRODUCTION} s and one team with {robots} robots")
    return str(result["seed"]), result["scenario"], result["teams"]["CYAN"]["points"], read_game(game)


def read_rows(path):
    """A table of cxlab bench."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for column in "game", "seed", "strategy", "points", "status", "exit":
        if column not in (rows[0] if rows else ()):
            raise BadInput(f"{path}: no rows of cxlab bench: the column {column} is missing")
    return [{**row, "file": path} for row in rows]


def read_inputs(paths, robots):
    """Games by name; of each strategy the points in games: {strategy: {game: points}}; and rows of games that were not played to
    their end."""
    games, points, rows, broken = {}, collections.defaultdict(dict), [], []
    for path in map(pathlib.Path, paths):
        try:
            if path.suffix == ".csv":
                rows += read_rows(path)
                continue
            if path.is_dir():
                name, scenario, reached, game = game_of_run(path, robots)
                points[scenario][name] = reached
            elif path.exists():
                name, game = path.stem, game_of_file(path)
            else:
                raise BadInput(f"{path}: there is no such file or folder")
        except OSError as problem:
            raise BadInput(f"{path}: {problem.strerror}") from None
        except (KeyError, TypeError, ValueError, csv.Error) as problem:
            raise BadInput(f"{path}: not as cxlab writes it: {problem!r}") from None
        if games.setdefault(name, game) != game:
            raise BadInput(f"{path}: another game than the one before of the name {name!r}; give each a name of its own")
    for row in rows:
        name = row["game"] or row["seed"]
        if name not in games:
            raise BadInput(f"{row['file']}: no game {name} for its rows: name its file, or the folder of a run of it")
        if row["status"] == "completed" and row["exit"] == "0":
            points[row["strategy"]][name] = float(row["points"])
        else:
            broken.append(f"{row['strategy']} in game {name} ({row['status']}, exit code {row['exit']})")
    return games, points, broken


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", nargs="+", help="folder of a run, game file, or rows.csv of cxlab bench")
    parser.add_argument("--robots", type=int, choices=(1, 2, 3), default=3)
    parser.add_argument("--durations", choices=HANDLING, default="physics", help="timed.durations of the runs")
    options = parser.parse_args()
    bounds = {}
    try:
        games, points, broken = read_inputs(options.input, options.robots)
        for name, game in games.items():
            try:
                bounds[name] = upper_bound(game, options.robots, options.durations)
            except (KeyError, IndexError, TypeError, ValueError) as problem:
                raise BadInput(f"game {name}: not as cxlab writes it: {problem!r}") from None
    except BadInput as problem:
        print(f"error: {problem}", file=sys.stderr)
        sys.exit(3)

    print("| Game | Bound |" + "".join(f" {strategy} |" for strategy in points))
    print("|---|---|" + "---|" * len(points))
    shares = {strategy: {name: got / bounds[name] for name, got in of.items()} for strategy, of in points.items()}
    for name, bound in bounds.items():
        cells = (f"{of[name]:.0f} ({shares[strategy][name]:.0%})" if name in of else "" for strategy, of in points.items())
        print(f"| {name} | {bound} |" + "".join(f" {cell} |" for cell in cells))
    means = (f"{statistics.mean(of.values()):.0f} ({statistics.mean(shares[strategy].values()):.1%})" for strategy, of in points.items())
    print(f"| mean | {statistics.mean(bounds.values()):.0f} |" + "".join(f" {cell} |" for cell in means))
    if broken:
        print("not counted: " + ", ".join(broken), file=sys.stderr)
    beyond = [f"{strategy} in game {name}" for strategy, of in shares.items() for name, share in of.items() if share > 1]
    if beyond:
        sys.exit("more than the bound: " + ", ".join(beyond))


if __name__ == "__main__":
    main()
