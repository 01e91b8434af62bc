#!/usr/bin/env python3
"""Tells how products fare in recorded games of the Logistics League: how often one is lost, where it lies, and what robots wait for.

    benchmarks/product_risks.py PROGRAM RUN...     RUN: folders of `cxlab run` with a journal

Games with the same name before the first dot of their folder (together.7, together.8) make one line of means:

    games      number of games
    delivered  products delivered in a game
    loss       share of products that are lost at a machine or on the way to the next one, of all that leave a machine or are lost
    ring, cap  s that a product lies on a ring station or cap station, from its arrival until a robot has it
    idle       s of robots without a skill in a game
    planning   of these, s while a plan is being made
    plans      plans in a game
"""
import collections
import json
import pathlib
import subprocess
import sys

STATIONS = {"RS": "ring", "CS": "cap"}
LOST = ("dropped", "taken")


def records(run):
    with (run / "journal.jsonl").open() as journal:
        for line in journal:
            record = json.loads(line)
            yield record["t"] / 1e9, record["kind"], record["data"]


def count_products(program, run, counts):
    """Counts deliveries, transports from machine to machine, and losses; returns the pieces that are products."""
    answer = json.loads(subprocess.run([program, "orders", str(run), "--json"], check=True, capture_output=True, text=True).stdout)
    steps = collections.defaultdict(list)
    for step in answer["steps"]:
        steps[step["piece"]].append(step)
    for of_piece in steps.values():
        on_machines = [s for s in of_piece if s["machine"] and s["arrived_s"] is not None and not s["step"].startswith("BASE_")
                       and s["step"] not in (*LOST, "in play")]
        last = of_piece[-1]
        counts["delivered"] += last["step"] == "delivery" and last["done_s"] is not None
        counts["transports"] += max(0, len(on_machines) - 1)
        counts["lost"] += bool(on_machines) and last["step"] in LOST
    return set(steps)


def count_stays(run, products, counts):
    """Adds up how long products lie on ring and cap stations."""
    came = {}
    for t, kind, data in records(run):
        if kind != "referee" or data["event"] != "piece" or data["piece"] not in products:
            continue
        since, station = came.pop(data["piece"], (t, None))
        if station:
            counts[station] += t - since
            counts[station + " stays"] += 1
        for name, column in STATIONS.items():
            if data["to"] == "belt" and f"-{name}" in data.get("to_name", ""):
                came[data["piece"]] = t, column


def count_rest(run, counts):
    """Adds up how long robots have no skill, and how much of it falls into the making of a plan.

    A wish for a plan that ends without one, because there is no order yet, does not count.
    """
    idle, since, planning, waited = set(), 0.0, False, 0.0
    for t, kind, data in records(run):
        counts["idle"] += (t - since) * len(idle)
        waited += (t - since) * len(idle) * planning
        since = t
        if kind == "skill" and data["event"] in ("start", "end"):
            (idle.discard if data["event"] == "start" else idle.add)(data["robot"])
        elif kind == "decision" and "slots" in data:
            what = data["slots"].get("what", "").strip('"')
            counts["plans"] += what == "plan"
            if what == "plan":
                planning, waited = True, 0.0
            elif what.startswith(("work for the orders", "go on as before")):
                counts["planning"] += waited
                planning, waited = False, 0.0


def line_of(name, counts):
    games = counts["games"]
    loss = counts["lost"] / max(1, counts["lost"] + counts["transports"])
    stays = [counts[column] / max(1, counts[column + " stays"]) for column in STATIONS.values()]
    each = [counts[column] / games for column in ("idle", "planning", "plans")]
    return [name, games, f"{counts['delivered'] / games:.1f}", f"{loss:.2f}", *(f"{value:.0f}" for value in (*stays, *each))]


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program, *folders = sys.argv[1:]
    kinds = collections.defaultdict(collections.Counter)
    for run in map(pathlib.Path, folders):
        counts = kinds[run.parent.name + "/" + run.name.split(".")[0]]
        counts["games"] += 1
        products = count_products(program, run, counts)
        count_stays(run, products, counts)
        count_rest(run, counts)
    rows = [["", "games", "delivered", "loss", "ring", "cap", "idle", "planning", "plans"]]
    rows += [line_of(name, counts) for name, counts in sorted(kinds.items())]
    for row in rows:
        print(f"{row[0]:28}" + "".join(f"{cell!s:>10}" for cell in row[1:]))


if __name__ == "__main__":
    main()
