#!/usr/bin/env python3
"""Counts how often pieces are picked and placed in games of the physics tier, and what became of them.

    grasps.py PROGRAM [FIRST_SEED LAST_SEED]     # default 101 120: machines of 20 random layouts

A handling is a pick or a place, also one within a transport. It fails when its skill ends with 202, 204, 206 or 208. It is
undetected when its skill succeeds although the referee did not see the piece pass between gripper and machine.
"""
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

GAME = pathlib.Path(__file__).parents[1] / "scenarios/rcll/game.yaml"
OF = {"pick": ["pick"], "place": ["place"], "transport": ["pick", "place"]}
counts, failures, undetected = collections.Counter(), collections.Counter(), 0

program = sys.argv[1]
first, last = map(int, sys.argv[2:4] or (101, 120))
for seed in range(first, last + 1):
    with tempfile.TemporaryDirectory() as folder:
        run = pathlib.Path(folder) / "run"
        subprocess.run([program, "run", GAME, "--seed", str(seed), "--quiet", "--out", run], check=True, capture_output=True)
        began, passed = {}, collections.defaultdict(list)
        records = [json.loads(line) for line in (run / "journal.jsonl").open()]
    for record in records:
        data, t = record["data"], record["t"]
        if record["stream"] == "referee" and data.get("event") == "piece":
            if data["to"] == "gripper":
                passed[data["to_name"]].append((t, "pick"))
            if data["from"] == "gripper" and data["to"] in ("belt", "slot", "slide"):
                passed[data["from_name"]].append((t, "place"))
    for record in records:
        data, t = record["data"], record["t"]
        if record["kind"] != "skill" or data["skill"] not in OF:
            continue
        if data["event"] == "start":
            began[data["robot"]] = t
        elif data["event"] == "end" and not data["cancelled"]:
            seen = [what for at, what in passed[data["robot"]] if began[data["robot"]] <= at <= t]
            if data["code"] == 0:
                for what in OF[data["skill"]]:
                    counts[what] += 1
                    undetected += what not in seen
            elif data["code"] in (202, 204, 206, 208):
                failures[f"{data['skill']} {data['target']} {data['code']}"] += 1
handled, failed = sum(counts.values()), sum(failures.values())
print(f"{counts['pick']} picks and {counts['place']} places, {failed} failed ({100 * handled / (handled + failed):.2f} % succeed), "
      f"{undetected} undetected")
for what, count in failures.most_common():
    print(f"  {count} x {what}")
