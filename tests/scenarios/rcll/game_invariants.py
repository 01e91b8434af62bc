#!/usr/bin/env python3
"""Plays games and checks in the journal of each what holds in every game, whatever an agent decides.

    game_invariants.py PROGRAM [FIRST LAST] [GAME]...   # seeds, names of GAMES; by default all games with seeds of their own

The docstring of each check states its invariant. In one game some records are changed, and the checks must see each change.
"""
import collections
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

from referee_model import CAP_OF, GATE, OPERATE, RINGS_OF, STORED, WORTH
from scene_tracks import STEP, SceneTracks

SCENARIOS = pathlib.Path(__file__).resolve().parents[3] / "scenarios/rcll"
FAULTS = """faults=[{kind: machine_breaks, machine: C-RS1, at: 300}, {kind: machine_breaks, machine: C-CS2, mean_s: 300},
 {kind: machine_down, machine: C-CS1, at: 400, seconds: 40}, {kind: machine_down, machine: C-RS2, mean_s: 200, seconds: 25},
 {kind: piece_dropped, robot: robot1, at: 500}, {kind: piece_taken, machine: C-RS1, mean_s: 250}, {kind: grasp_slips, probability: 0.05},
 {kind: skill_fails, probability: 0.05}, {kind: goal_lost, probability: 0.02}, {kind: instruction_lost, machine: C-BS, probability: 0.1},
 {kind: robot_maintenance, robot: robot2, mean_s: 400, seconds: 20, times: 2}, {kind: robot_halts, mean_s: 300, seconds: 5}]"""
GAMES = {  # scenario, seed, arguments
    "game": ("game.yaml", 1),
    "game_rulebook": ("game.yaml", 2, "--set", "world.rules=rulebook"),
    "faults": ("game.yaml", 2, "--set", FAULTS),
    "faults_rulebook": ("game.yaml", 3, "--set", "world.rules=rulebook", "--set", FAULTS),
    "two_teams": ("two_teams.yaml", 3),
    "planning": ("planning.yaml", 1),
    "planning_faults": ("planning.yaml", 2, "--set", FAULTS),
}
CHANGED = "faults"  # the game whose records are changed
TICK = 0.02
MOST_LINES = 5
BUSY = ("PREPARED", "PROCESSING", "PROCESSED")
# What follows each state when nothing breaks the machine and it is not out of order.
NEXT = {"IDLE": {"PREPARED"}, "PREPARED": {"PROCESSING"}, "PROCESSING": {"PROCESSED"}, "PROCESSED": {"READY-AT-OUTPUT", "WAIT-IDLE"},
        "READY-AT-OUTPUT": {"WAIT-IDLE"}, "WAIT-IDLE": {"IDLE"}, "BROKEN": {"IDLE"}}
ENDS = {"DS": ("WAIT-IDLE",), "SS": ("WAIT-IDLE", "READY-AT-OUTPUT")}  # what follows PROCESSED; else READY-AT-OUTPUT
LASTS = {"BROKEN": 30, "WAIT-IDLE": 5}
# Where a piece may go from each place.
WAYS = {"dispenser": {"belt", "slot"}, "slot": {"gripper", "floor"}, "belt": {"gripper", "gate", "storage", "floor"},
        "gripper": {"belt", "slot", "slide", "floor", "crew"}, "storage": {"belt"}, "floor": set(), "slide": set(), "gate": set(), "crew": set()}
WITH_PIECES = ("pick", "place", "transport")
# Faults with which a robot stands, and the longest time; how near a robot in the way comes, m; how long another one makes room for it.
STANDS, STANDS_FOR = ("skill_stalls", "robot_halts", "goal_lost"), 10.1
IN_THE_WAY, MAKES_ROOM = 0.7, 22
DELIVERY_KINDS = {"delivery", "late", "competitive", "ring", "cap"}


class Game:
    """A game of the timed tier that was played."""

    def __init__(self, folder):
        self.result = json.loads((folder / "result.json").read_text())
        overrides = dict(o.split("=", 1) for o in json.loads((folder / "manifest.json").read_text())["overrides"])
        self.book = overrides.get("world.rules") == "rulebook"
        text = (folder / "game.yaml").read_text()
        self.layout = {name: (zone, int(turn)) for name, zone, turn in
                       re.findall(r"machine: (\S+)\n +zone: (\S+)\n +rotation: (\d+)", text)}
        self.prices = {ring: int(price) for ring, price in re.findall(r"  (RING_\w+): (\d)\n", text)}
        self.orders = {number: self.order(block) for number, block in
                       enumerate(re.findall(r"complexity: C\d.*?competitive: \w+", text, re.S), 1)}
        self.downs = [(machine, float(begin), float(end)) for machine, begin, end in
                      re.findall(r"machine: (\w+)\n +begin_s: (\S+)\n +end_s: (\S+)", text)]
        self.records = []
        for line in (folder / "journal.jsonl").open():
            record = json.loads(line)
            if record["kind"] in ("referee", "skill", "error") or record["stream"] == "faults":
                self.records.append((record["t"] / 1e9, record["kind"] if record["stream"] != "faults" else "fault", record["data"]))
        self.records.sort(key=lambda record: record[0])  # the referee looks back a tick
        self.robots = SceneTracks(folder, "robot")

    @staticmethod
    def order(block):
        order = {key: float(value) for key, value in re.findall(r"(\w+): ([\d.]+)\n", block)}
        order["parts"] = " ".join(word for prefix in ("BASE", "RING", "CAP") for word in re.findall(rf"{prefix}_\w+", block))
        return {**order, "complexity": block[12:14], "competitive": "competitive: true" in block}

    def of(self, event, kind="referee"):
        return [(t, d) for t, k, d in self.records if k == kind and d.get("event") == event]

    def near(self, event, t, record="referee", **values):
        """The records of that event within two ticks of t that have these values."""
        return [d for at, d in self.of(event, record) if abs(at - t) < 2.5 * TICK and all(d.get(k) == v for k, v in values.items())]

    def production(self):
        phases = {d["phase"]: t for t, d in self.of("phase")}
        return phases.get("PRODUCTION", math.inf), phases.get("POST_GAME", math.inf)

    def problems(self):
        """What does not hold, by check."""
        found = {check: list(check(self)) for check in CHECKS}
        return {check: bad for check, bad in found.items() if bad}


def team_of(name):
    """The team of a machine, spot or robot."""
    return "MAGENTA" if name[0] == "M" or name.startswith("robot") and int(name[5:]) > 3 else "CYAN"


def phases(game):
    """Set-up comes before production, and production before the end; nothing is judged outside of it."""
    order = [d["phase"] for _, d in game.of("phase")]
    if order not in (["PRODUCTION", "POST_GAME"], ["SETUP", "PRODUCTION", "POST_GAME"]):
        yield f"the phases are {order}"
    begin, end = game.production()
    for event in ("score", "delivery", "mounted", "cap_retrieved", "order"):
        yield from (f"at {t:.2f} s there is {d}" for t, d in game.of(event) if not begin - 1e-9 <= t <= end + 1e-9)


def no_errors(game):
    """No rule raises an error, no robot touches another, and the game is played to its end."""
    if game.result["status"] != "completed":
        yield f"it is {game.result['status']}"
    yield from (f"at {t:.2f} s: {d}" for t, kind, d in game.records if kind == "error")
    yield from (f"{robot['name']} did" for robot in game.result["robots"] if robot["contacts"])


def totals(game):
    """The total of a team grows by the points of each score, and ends as the result says, for each kind."""
    kinds = collections.defaultdict(collections.Counter)
    for t, d in game.of("score"):
        kinds[d["team"]][d["kind"]] += d["points"]
        if d["total"] != (total := sum(kinds[d["team"]].values())):
            yield f"at {t:.2f} s {d['team']} has {total} points and not {d['total']}"
    for team, had in game.result["teams"].items():
        if had["points"] != sum(had["by_kind"].values()) or {k: v for k, v in had["by_kind"].items() if v} != {
                k: v for k, v in kinds[team].items() if v}:
            yield f"{team} has {had} and not {dict(kinds[team])}"


def causes(game):
    """Points are given for a deed of that moment, and each deed has its points."""
    begin, end = game.production()
    want, have = collections.Counter(), collections.Counter()
    second = collections.Counter()

    def due(t, team, kind, points):
        if points and begin <= t <= end:
            want[round(t / TICK), team, kind] += points
    for t, d in game.of("score"):
        if d["kind"] not in DELIVERY_KINDS | {"exploration", "payment"}:
            have[round(t / TICK), d["team"], d["kind"]] += d["points"]
    for event, kind, points in (("cap_retrieved", "buffer", 2), ("stored", "penalty", -5), ("unstored", "penalty", -5)):
        for t, d in game.of(event):
            due(t, team_of(d["machine"]), kind, points)
    loaded = {}
    for t, kind, d in game.records:
        if d.get("event") == "cap_retrieved":
            loaded[d["machine"]] = 1
        elif d.get("event") == "mounted" and d["machine"][2] == "C":
            loaded[d["machine"]] = 0
        elif d.get("event") == "broken":
            due(t, team_of(d["machine"]), "buffer", -2 * loaded.pop(d["machine"], 0) if d["machine"][2] == "C" else 0)
            if game.book and "no workpiece" in d["reason"] and (round(t / TICK), team_of(d["machine"]), "penalty") in have:
                due(t, team_of(d["machine"]), "penalty", -1)  # a person sees whether something lay on the belt
        elif d.get("event") == "maintenance" and d["state"] == "begin":
            second[d["robot"]] += 1
            due(t, d["team"], "penalty", -5 if second[d["robot"]] == 2 else 0)
        elif d.get("event") == "piece" and d["from"] == "gripper" and game.book:
            foreign = d["to"] in ("belt", "slide", "slot") and team_of(d["to_name"]) != team_of(d["from_name"])
            due(t, team_of(d["from_name"]), "penalty", -10 if d["to"] == "floor" else -20 if foreign else 0)
    for key in sorted(want.keys() | have.keys()):
        if want[key] != have[key]:
            yield f"at {key[0] * TICK:.2f} s {key[1]} has {have[key]} of {key[2]} and not {want[key]}"


def payments(game):
    """A base on the slide of a station that is not BROKEN is 2 points; a ring uses what its colour costs when its mounting begins; a
    station that breaks gives back what was not used."""
    paid, state, due, told = collections.Counter(), {}, collections.Counter(), {}
    for t, kind, d in game.records:
        event = d.get("event")
        if event == "piece" and d["to"] == "slide":
            station = d["to_name"].removesuffix("-SLIDE")
            if state.get(station) != "BROKEN" and not (game.book and team_of(station) != team_of(d["from_name"])):
                due[station] += 1
        elif event == "instruction" and d["code"] == 0 and "ring_color" in d:
            told[d["machine"]] = game.prices[d["ring_color"]]
        elif event == "machine":
            station = d["machine"]
            if d["state"] == "PROCESSING" and state.get("worked " + station) == "PREPARED" and station in told:
                paid[station] -= told[station]
                if not 0 <= paid[station] <= 3:
                    yield f"at {t:.2f} s {paid[station]} are left on {station}"
            state[station] = d["state"]
            if d["state"] != "DOWN":
                state["worked " + station] = d["state"]
        elif event == "score" and d["kind"] == "payment":
            station = next((m for m in game.layout if m[2] == "R" and team_of(m) == d["team"] and (
                due[m] if d["points"] > 0 else game.near("broken", t, machine=m) and 2 * paid[m] == -d["points"])), None)
            if station is None:
                yield f"at {t:.2f} s {d['team']} has {d['points']} for nothing"
            elif d["points"] == 2:
                due[station] -= 1
                paid[station] += 1
            elif d["points"] > 0:
                yield f"at {t:.2f} s one is {d['points']}"
            else:
                paid[station] = 0
        elif event == "broken" and d["machine"][2] == "R":
            due[d["machine"]] = 0
            if paid[d["machine"]] and not game.near("score", t, kind="payment", points=-2 * paid[d["machine"]]):
                yield f"at {t:.2f} s {d['machine']} keeps {paid[d['machine']]}"
        elif event == "mounted" and d["machine"][2] == "R":
            ring = d["product"].split()[-1]
            if d["payments"] != game.prices[ring]:
                yield f"at {t:.2f} s {ring} cost {d['payments']} and not {game.prices[ring]}"
    yield from (f"{count} on {station} are worth nothing" for station, count in due.items() if count)


def orders(game):
    """Each order is published once, when it becomes active, as the file of the game has it."""
    begin, end = game.production()
    seen = {}
    for t, d in game.of("order"):
        order = game.orders[d["order"]]
        if d["order"] in seen:
            yield f"order {d['order']} comes again at {t:.2f} s"
        seen[d["order"]] = t
        if not -1e-6 <= t - begin - order["activate_at"] < 2 * TICK:
            yield f"order {d['order']} comes at {t:.2f} s"
        if (d["product"], d["gate"], d["complexity"], d["competitive"]) != (order["parts"], order["delivery_gate"],
                                                                           order["complexity"], order["competitive"]):
            yield f"order {d['order']} is {d}"
    yield from (f"order {number} never comes" for number, order in game.orders.items()
                if number not in seen and begin + order["activate_at"] < end - TICK)


def deliveries(game):
    """A delivery for an order counts if it is the right product, in an open window, up to the quantity; the order earns the points
    of the tables."""
    begin, _ = game.production()
    released, done, points = {d["order"]: t for t, d in game.of("order")}, collections.Counter(), collections.Counter()
    for t, d in game.of("score"):
        if d["kind"] in DELIVERY_KINDS:
            points[round(t / TICK), d["team"], d["order"]] += d["points"]
    for t, d in game.of("delivery"):
        order, key = game.orders[d["order"]], (d["team"], d["order"])
        right = (d["order"] in released and released[d["order"]] <= t and d["product"] == order["parts"]
                 and t - begin >= order["delivery_begin"] - 1e-6 and done[key] < order["quantity"])
        if d["correct"] != right:
            yield f"at {t:.2f} s {'a wrong' if d['correct'] else 'a right'} product counts otherwise: {d}"
        given = points.pop((round(t / TICK), *key), 0)
        late = max(0.0, t - begin - order["delivery_end"])
        worth = WORTH[order["complexity"]]
        steps = 5 if game.book else 4
        less = worth * min(steps, math.ceil(late / ((order["delivery_end"] - order["delivery_begin"]) / steps) - 1e-9)) * 3 // (4 * steps)
        first = order["competitive"] and not done[key]
        others = any(count for (team, number), count in done.items() if number == d["order"] and team != d["team"])
        rings = sum((5, 10, 20)[game.prices[ring]] for ring in order["parts"].split()[1:-1])
        bonus = (0 if not first else 10 if not others else -min(10, worth - less) if game.book else -10)
        earned = worth - less + 10 + rings + bonus if d["correct"] else 0
        if given != d["points"] or d["points"] != earned:
            yield f"at {t:.2f} s order {d['order']} earns {given}, is said to earn {d['points']} and should earn {earned}"
        done[key] += d["correct"]
    yield from (f"at {key[0] * TICK:.2f} s order {key[2]} has {left} points without a delivery" for key, left in points.items() if left)
    for order in game.result["orders"]:
        if order["correct"] != bool(done[order.get("team", next(iter(game.result["teams"]))), order["id"]]):
            yield f"the result has {order}"


def reports(game):
    """The first zone that a team reports of a machine is judged, and the first rotation after a right zone: 1 point right, -1 wrong."""
    said, want, have = {}, collections.Counter(), collections.Counter()
    begin, _ = game.production()
    for t, d in game.of("report"):
        machine, judged = d.get("machine"), False
        if machine in game.layout and team_of(machine) == d["team"] and begin <= t <= begin + 180:
            zone, rotation = game.layout[machine]
            if d["zone"] and machine not in said:
                said[machine], judged = d["zone"] == zone, True
                want[round(t / TICK), d["team"]] += 1 if said[machine] else -1
            if d["rotation"] >= 0 and said.get(machine) and machine + " turned" not in said:
                said[machine + " turned"], judged = d["rotation"] == rotation, True
                want[round(t / TICK), d["team"]] += 1 if d["rotation"] == rotation else -1
        if machine and d["judged"] != judged:
            yield f"at {t:.2f} s {'it is not' if judged else 'another is'}: {d}"
    for t, d in game.of("score"):
        if d["kind"] == "exploration":
            have[round(t / TICK), d["team"]] += d["points"]
    yield from (f"at {key[0] * TICK:.2f} s {key[1]} has {have[key]} and not {want[key]}"
                for key in want.keys() | have.keys() if want[key] != have[key])


def automaton(game):
    """A machine goes from state to state as its kind does. An accepted instruction makes it PREPARED. It is BROKEN for 30 s, with a
    reason. It is DOWN only in down times, which hide its former state."""
    begin, end = game.production()
    # Faults put machines out of order from their strike on.
    downs = [(f"{team}-{machine}", begin + a, begin + b) for machine, a, b in game.downs for team in "CM"]
    downs += [(d["machine"], t, t + d["seconds"]) for t, kind, d in game.records if kind == "fault" and d["fault"] == "machine_down"]
    state, since, entered, hidden = collections.defaultdict(lambda: "IDLE"), collections.defaultdict(float), {}, {}
    for t, d in game.of("machine"):
        name, old, new = d["machine"], state[d["machine"]], d["state"]
        lasted = t - since[name]
        down = any(m == name and a - TICK <= t <= b + 2 * TICK for m, a, b in downs)
        if new == "DOWN":
            if not down:
                yield f"at {t:.2f} s {name} is DOWN"
            hidden[name] = old, since[name], t
        elif new == "BROKEN" and old != "DOWN":
            if not game.near("broken", t, machine=name):
                yield f"at {t:.2f} s {name} is BROKEN for no reason"
        elif old == "DOWN":
            was, began, at = hidden[name]
            if new not in (was, "BROKEN"):
                yield f"at {t:.2f} s {name} was {was} before it was DOWN and is {new}"
            since[name] = began if was not in BUSY else began + t - at
            if new == was:
                state[name] = new
                continue
        elif new not in NEXT[old] or old == "PROCESSED" and new not in ENDS.get(name[2:4], ("READY-AT-OUTPUT",)):
            yield f"at {t:.2f} s {name} goes from {old} to {new}"
        if new == "PREPARED" and not game.near("instruction", t, machine=name, code=0):
            yield f"at {t:.2f} s nobody instructed {name}"
        if old in LASTS and new == "IDLE" and not LASTS[old] - TICK / 2 <= lasted <= LASTS[old] + 60 * down + 2 * TICK:
            yield f"at {t:.2f} s {name} was {old} for {lasted:.2f} s"
        if old in BUSY and new != "DOWN" and lasted > 20 + 2 * TICK and not (game.book and name[2] == "D"):
            yield f"at {t:.2f} s {name} was {old} for {lasted:.2f} s"
        if old == "PROCESSING" and new == "PROCESSED" and t - entered[name] < {**OPERATE, "SS": 17.5, "DS": min(GATE.values()), "BS": 1.1}[name[2:4]] - TICK:
            yield f"at {t:.2f} s {name} worked for {t - entered[name]:.2f} s only"
        state[name], since[name] = new, t
        if new != "DOWN":
            entered[name] = t


def out_of_order(game):
    """A machine that is BROKEN or DOWN takes no instruction but RESET, mounts, stores and delivers nothing."""
    state = {}
    for t, kind, d in game.records:
        event, bad = d.get("event"), state.get(d.get("machine")) in ("BROKEN", "DOWN")
        if event == "machine":
            state[d["machine"]] = d["state"]
        elif event in ("mounted", "cap_retrieved", "stored", "unstored") and bad:
            yield f"at {t:.2f} s {d['machine']} is {state[d['machine']]}: {d}"
        elif event == "instruction" and bad and d["code"] == 0 and d.get("operation") != "RESET" and not game.near(
                "machine", t, machine=d["machine"]):
            yield f"at {t:.2f} s {d['machine']} is {state[d['machine']]} and takes {d}"
        elif event in ("delivery", "discard"):
            gates = [m for m in game.layout if m.endswith("-DS") and team_of(m) == d.get("team", team_of(m))]
            if all(state.get(m) in ("BROKEN", "DOWN") for m in gates):
                yield f"at {t:.2f} s {d}"


def tracks(game):
    """A piece goes from hand to hand without a gap; a robot holds one at a time, a spot and a belt have room for as many as lie there,
    and robots work at machines of their own team."""
    where, held = {}, {}
    for t, d in game.of("piece"):
        piece, source, target = d["piece"], (d["from"], d.get("from_name")), (d["to"], d.get("to_name"))
        if piece in where and where[piece] != source and not (where[piece][0] == "storage" and source[0] == "storage"):
            yield f"at {t:.2f} s piece {piece} comes from {source} and was at {where[piece]}"
        if piece not in where and source[0] not in ("dispenser", "storage"):
            yield f"at {t:.2f} s piece {piece} comes from {source} and from nowhere before"
        if target[0] not in WAYS[source[0]]:
            yield f"at {t:.2f} s piece {piece} goes from {source} to {target}"
        if source[0] == "gripper" and held.pop(source[1], None) != piece:
            yield f"at {t:.2f} s {source[1]} gives piece {piece} and did not hold it"
        if target[0] == "gripper":
            if target[1] in held:
                yield f"at {t:.2f} s {target[1]} takes piece {piece} and holds {held[target[1]]}"
            held[target[1]] = piece
        if target[0] == "slot" and target in where.values():
            yield f"at {t:.2f} s two pieces are at {target[1]}"
        ends = {kind: name for kind, name in (source, target)}
        if "gripper" in ends and (other := next((name for kind, name in (source, target) if kind in ("belt", "slot", "slide")), None)):
            if team_of(other) != team_of(ends["gripper"]):
                yield f"at {t:.2f} s {ends['gripper']} works at {other}"
        where[piece] = target


def products(game):
    """A product is a base, then rings of the station's colours, then the cap of the station, one after the other. It is delivered as it
    was made, from under a gate."""
    parts, was_at, carriers = {}, {}, set()
    told = collections.defaultdict(str)
    for t, kind, d in game.records:
        event = d.get("event")
        if event == "instruction" and d["code"] == 0 and d.get("base_color"):
            told[d["machine"]] = d["base_color"]
        elif event == "piece":
            was_at[d["piece"]] = d["to"], d.get("to_name")
            if d["from"] == "dispenser" and d["to"] == "slot":
                parts[d["piece"]] = f"BASE_CLEAR {CAP_OF[d['from_name'][2:]]}"
            elif d["from"] == "dispenser" and d["from_name"].endswith("-BS"):
                parts[d["piece"]] = told[d["from_name"]]
        elif event in ("mounted", "cap_retrieved", "unstored", "stored"):
            piece, machine, product = d["piece"], d["machine"], d["product"]
            if event == "unstored" and piece not in parts:
                parts[piece] = product
                if product not in STORED:
                    yield f"at {t:.2f} s a {product} comes out of {machine}"
            before = parts.get(piece)
            added = product.split()[-1]
            fits = {"cap_retrieved": before == f"{product} {CAP_OF.get(machine[2:])}", "unstored": before == product, "stored": before == product,
                    "mounted": before and product == f"{before} {added}" and "CAP_" not in before
                    and (added == CAP_OF.get(machine[2:]) or added in RINGS_OF.get(machine[2:], ()) and before.count("RING_") < 3)}
            if not fits[event]:
                yield f"at {t:.2f} s {machine} makes a {product} of a {before}"
            if event != "stored" and was_at.get(piece) != ("belt", machine):
                yield f"at {t:.2f} s piece {piece} is at {was_at.get(piece)} and not on {machine}"
            parts[piece] = product
        elif event in ("delivery", "discard"):
            if parts.get(d["piece"]) != d["product"] or was_at.get(d["piece"], ("",))[0] not in ("gate", "belt"):
                yield f"at {t:.2f} s a {d['product']} is delivered that was a {parts.get(d['piece'])} at {was_at.get(d['piece'])}"


def skills(game):
    """Each robot runs one skill at a time, which ends once; it takes and gives pieces only in a skill, and robots off the field do nothing."""
    running, ended, off = {}, {}, set()
    for t, kind, d in game.records:
        event, robot = d.get("event"), d.get("robot")
        if event == "maintenance":
            (off.discard if d["state"] == "end" else off.add)(robot)
        if kind == "referee" and event == "piece":
            for end in ("from", "to"):  # the referee looks a tick later
                at = d[end + "_name"] if d[end] == "gripper" and d["to"] not in ("crew", "floor") else None
                begun, (over, last) = running.get(at, ("", "")), ended.get(at, (-1, ""))
                if at and begun[0] not in WITH_PIECES and not (t - over < 2.5 * TICK and last in WITH_PIECES):
                    yield f"at {t:.2f} s {at} does {begun}: {d}"
        if kind != "skill" or event not in ("start", "phase", "end"):
            continue
        what = d["skill"], d["target"]
        if event == "start":
            if robot in running:
                yield f"at {t:.2f} s {robot} begins {what} and still does {running[robot]}"
            if robot in off and not game.near("end", t, record="skill", robot=robot, code=210):
                yield f"at {t:.2f} s {robot} begins {what} off the field"
            running[robot] = what
        elif running.get(robot) != what:
            yield f"at {t:.2f} s {robot} does {running.get(robot)} and not {what}"
        if event == "end":
            running.pop(robot, None)
            ended[robot] = t, d["skill"]
            if (d["code"] == 0) != (not d["error"]):
                yield f"at {t:.2f} s {robot} ends with {d}"


def comes_near(robots, robot, whom, begin, until, there):
    """How near the one in the way comes: to the places of a robot until that is there, while that waits; or on its way, as much earlier."""
    own, other = robots.way(robot, begin, there), robots.way(whom, begin, there)
    waited = round((until - begin) / STEP) + 2
    return min(math.dist(p, q) for i, p in enumerate(own) for q in other[:waited] + other[max(i - waited, 0):i + 1])


def waits(game):
    """A robot that waits is held up by a fault, or another one stands on its later way or drives across it: that one is named."""
    steps, stands, thwarted = (collections.defaultdict(list) for _ in range(3))
    for t, kind, d in game.records:
        if kind == "skill" and d["event"] != "refused":
            steps[d["robot"]].append((t, d))
        if kind == "fault" and d["fault"] in STANDS:
            stands[d["robot"]].append(t)
        if kind == "fault" or kind == "skill" and d["event"] == "end" and (d["code"] or d["cancelled"]):
            thwarted[d.get("robot")].append(t)
        if kind == "skill" and d.get("phase") == "wait" and "for" not in d:
            thwarted[d["robot"]].append(t)  # it has another way from then on
    for robot, its in steps.items():
        for i, ((t, d), (until, _)) in enumerate(zip(its, its[1:]), 1):
            if d.get("phase") != "wait" or until - t < 1.5 * TICK:
                continue
            what, whom = f"at {t:.2f} s {robot} waits for {d.get('for')}", d.get("for")
            if whom is None and not any(t - STANDS_FOR <= at <= until for at in stands[robot]):
                yield what
            if whom is None:
                continue
            if whom == robot or whom not in game.robots.points:
                yield what
                continue
            there = next((at for at, step in its[i:] if step.get("phase") not in ("wait", "drive")), None)
            if there is None or any(t <= at <= there for at in thwarted[robot] + thwarted[whom]):
                continue  # one of them does not drive as it was planned
            # It also waits for one that it made room for, and that a fault then halted.
            begin = t - MAKES_ROOM if any(at <= t <= at + STANDS_FOR for at in stands[whom]) else t
            if (nearest := comes_near(game.robots, robot, whom, begin, until, there)) > IN_THE_WAY:
                yield f"{what}, which stays {nearest:.2f} m away"


CHECKS = [phases, no_errors, totals, causes, payments, orders, deliveries, reports, automaton, out_of_order, tracks, products, skills, waits]


def changes():
    """Changes of a journal that a check must see: the check, a name, and what is done to the records."""
    def edit(alter, event, late=100, **values):
        """`alter` gets the first record of that event after so many seconds with these values."""
        def change(records):
            for i, (t, kind, d) in enumerate(records):
                if t > late and d.get("event") == event and all(value(d.get(k)) if callable(value) else d.get(k) == value
                                                                for k, value in values.items()):
                    records[i:i + 1] = alter(t, kind, d)
                    return
            raise ValueError(f"no {event} of {values}")
        return change

    def gone(*record):
        return []

    def twice(*record):
        return [record, record]

    def later(seconds):
        return lambda t, kind, d: [(t + seconds, kind, d)]

    def other(**values):
        return lambda t, kind, d: [(t, kind, {**d, **{k: v(d[k]) if callable(v) else v for k, v in values.items()}})]

    def all_wait(choose):
        """Each robot that waits for one waits for another one, or for none."""
        def change(records):
            records[:] = [(t, kind, {**d, "for": choose(d["robot"], d["for"])} if "for" in d else d) for t, kind, d in records]
        return change
    right = {"correct": True}
    yield phases, "production comes twice", edit(twice, "phase", -1, phase="PRODUCTION")
    yield phases, "a score comes after the game", edit(later(2000), "score")
    yield totals, "a score is one point more", edit(other(points=lambda p: p + 1), "score")
    yield totals, "a score is missing", edit(gone, "score")
    yield causes, "a cap is worth nothing", edit(gone, "score", kind="buffer")
    yield causes, "a cap is worth 3", edit(other(points=3), "score", kind="buffer")
    yield causes, "a cap counts without being taken", edit(gone, "cap_retrieved")
    yield causes, "a penalty for nothing", edit(other(kind="penalty"), "score", kind="buffer")
    yield payments, "a payment is worth nothing", edit(gone, "score", kind="payment")
    yield payments, "a payment counts that did not come", edit(gone, "piece", to="slide")
    yield payments, "a payment counts twice", edit(twice, "score", kind="payment")
    yield payments, "a ring costs another price", edit(other(payments=lambda p: p + 1), "mounted", machine=lambda m: m[2] == "R")
    yield payments, "a payment is kept that the station lost", edit(gone, "score", kind="payment", points=lambda p: p < 0)
    yield orders, "an order is late", edit(later(1), "order")
    yield orders, "an order comes twice", edit(twice, "order")
    yield orders, "an order is missing", edit(gone, "order")
    yield orders, "an order asks for something else", edit(other(product="BASE_RED CAP_GREY"), "order")
    yield deliveries, "a delivery earns a point more", edit(other(points=lambda p: p + 1), "delivery", **right)
    yield deliveries, "a delivery does not count", edit(other(correct=False), "delivery", **right)
    yield deliveries, "a delivery has no record", edit(gone, "delivery", **right)
    yield deliveries, "another product counts", edit(other(product="BASE_RED"), "delivery", **right)
    yield deliveries, "a delivery before its window", edit(other(order=8), "delivery", **right)
    yield deliveries, "one product more than was ordered", edit(twice, "delivery", **right)
    yield reports, "a right report is not judged", edit(other(judged=False), "report", 0, judged=True)
    yield reports, "a wrong report is right", edit(other(zone="C_Z11"), "report", 0, judged=True)
    yield reports, "a rotation is another", edit(other(rotation=lambda r: (r + 45) % 360), "report", 0, judged=True)
    yield reports, "a report is judged twice", edit(twice, "report", 0, judged=True)
    yield reports, "a report counts nothing", edit(gone, "score", 0, kind="exploration")
    for state in ("PREPARED", "PROCESSING", "PROCESSED", "READY-AT-OUTPUT", "WAIT-IDLE", "BROKEN", "DOWN"):
        yield automaton, f"{state} is left out", edit(gone, "machine", state=state)
    yield automaton, "IDLE is left out", edit(gone, "machine", state="IDLE", machine="C-BS")
    yield automaton, "nobody has instructed a machine", edit(gone, "instruction", code=0)
    yield automaton, "a machine breaks for no reason", edit(gone, "broken")
    yield automaton, "a machine is down for no reason", edit(other(state="DOWN"), "machine", state="IDLE", machine="C-BS")
    yield automaton, "a wait is a second longer", edit(later(1), "machine", state="IDLE", machine="C-RS1")
    yield automaton, "a cap is taken at once", edit(later(-17), "machine", state="PROCESSED", machine="C-CS1")
    yield out_of_order, "a machine works while it is broken", edit(
        lambda t, kind, d: [(t, kind, {**d, "state": "BROKEN"}), (t + 1, kind, {"event": "mounted", "machine": d["machine"]})], "machine")
    yield out_of_order, "a machine takes an instruction while it is down", edit(
        lambda t, kind, d: [(t, kind, d), (t + 9, kind, {"event": "instruction", "machine": d["machine"], "code": 0})], "machine", state="DOWN")
    yield tracks, "a piece is not seen to leave", edit(gone, "piece", to="gripper")
    yield tracks, "a piece jumps", edit(other(to="gate"), "piece", to="gripper")
    yield tracks, "a robot holds another piece", edit(other(piece=lambda p: p + 1), "piece", to="gripper")
    yield tracks, "a robot holds two pieces", edit(
        lambda t, kind, d: [(t, kind, d), (t, kind, {**d, "piece": 999, "from": "dispenser"})], "piece", to="gripper")
    yield tracks, "two pieces lie in a slot", edit(twice, "piece", -1, to="slot")
    yield tracks, "a robot serves the other team", edit(other(from_name=lambda m: "M" + m[1:]), "piece", to="gripper")
    yield tracks, "a piece comes from nowhere", edit(other(**{"from": "floor"}), "piece", **{"from": "dispenser"})
    yield products, "a ring is of another station", edit(other(machine="C-CS1"), "mounted", machine=lambda m: m[2] == "R")
    yield products, "a ring is missing", edit(gone, "mounted", machine=lambda m: m[2] == "R")
    yield products, "a cap is of another colour", edit(other(product=lambda p: p.replace("CAP_GREY", "CAP_BLACK")), "mounted", machine="C-CS1")
    yield products, "another product is delivered", edit(other(product="BASE_RED CAP_GREY"), "delivery")
    yield products, "a base is of another colour", edit(other(base_color="BASE_CLEAR"), "instruction", 0, machine="C-BS", code=0)
    yield skills, "a skill ends twice", edit(twice, "end")
    yield skills, "a skill does not end", edit(gone, "end")
    yield skills, "a skill does not begin", edit(gone, "start")
    yield skills, "a failure has no words", edit(other(error=""), "end", code=lambda c: c not in (None, 0))
    yield skills, "a piece comes to a robot that drives", edit(other(from_name="robot9"), "piece", **{"from": "gripper", "to": "belt"})
    yield skills, "a robot works off the field", edit(
        lambda t, kind, d: [(t - 5, "referee", {"event": "maintenance", "robot": d["robot"], "state": "begin"}), (t, kind, d)], "start")
    yield waits, "robots wait for nobody", all_wait(lambda robot, whom: None)
    yield waits, "robots wait for themselves", all_wait(lambda robot, whom: robot)
    yield waits, "robots wait for a third one", all_wait(lambda *two: next(r for r in ("robot1", "robot2", "robot3") if r not in two))
    yield no_errors, "a rule raises an error", edit(lambda t, kind, d: [(t, "error", d)], "end")


def not_seen(game):
    """Changes of the game's journal that their check does not see."""
    records = game.records
    for check, name, change in changes():
        game.records = list(records)
        change(game.records)
        if not any(check(game)):
            yield f"not seen by {check.__name__}: {name}"
    game.records = records


def play(program, name, seed, folder):
    scenario, own_seed, *arguments = GAMES[name]
    out = folder / f"{name}-{seed}"
    done = subprocess.run([program, "run", str(SCENARIOS / scenario), "--tier", "timed", "--seed", str(seed or own_seed), "--quiet",
                           "--out", str(out), *arguments], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{name}: exit code {done.returncode}: {done.stderr}")
    return Game(out)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program, *rest = sys.argv[1:]
    seeds = [None]
    if rest and rest[0].isdigit():
        first, last, *rest = rest
        seeds = range(int(first), int(last) + 1)
    failed = 0
    with tempfile.TemporaryDirectory(prefix="cxlab-invariants-") as folder:
        for seed, name in ((seed, name) for seed in seeds for name in rest or GAMES):
            game = play(program, name, seed, pathlib.Path(folder))
            bad = game.problems()
            print(f"{name}, seed {seed or GAMES[name][1]}: {len(game.records)} records, {sum(map(len, bad.values())) or 'no'} problems",
                  flush=True)
            for check, what in bad.items():
                print(f"  {check.__doc__} But", *what[:MOST_LINES], sep="\n    ", flush=True)
            unseen = list(not_seen(game)) if name == CHANGED and not seed and not bad else []
            print(*(f"  {what}\n" for what in unseen), sep="", end="", flush=True)
            failed += bool(bad or unseen)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
