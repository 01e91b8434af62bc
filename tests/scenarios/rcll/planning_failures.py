#!/usr/bin/env python3
"""Plays games of the planning agent in the timed tier in which a fifth of all picks, places and drives fail.

    planning_failures.py PROGRAM SCENARIO FIRST_SEED LAST_SEED

Each must end with a delivery and without a warning of the agent's watchdogs. Nothing is booked twice: no robot gets a skill while it
has one, and no machine is instructed while it works.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

FAILURE = 0.2
LEAST_MEAN = 380  # 60 % of the mean without failures


def play(program, scenario, seed, out):
    failures = [f"timed.{skill}_failure={FAILURE}" for skill in ("pick", "place", "drive")]
    command = [program, "run", scenario, "--tier", "timed", "--seed", str(seed), "--quiet", "--out", out]
    return subprocess.run([*command, *(word for one in failures for word in ("--set", one))], capture_output=True, text=True)


def booked_twice(journal):
    at_work = {}
    for line in journal.splitlines():
        record = json.loads(line)
        kind, at, data = record["kind"], record["t"] / 1e9, record["data"]
        if kind == "skill" and data["event"] in ("start", "refused"):
            if data["robot"] in at_work:
                yield f"{at:.2f} {data['robot']}: {data['skill']} beside {at_work[data['robot']]}"
            at_work[data["robot"]] = data["skill"]
        elif kind == "skill" and data["event"] == "end":
            at_work.pop(data["robot"], None)
        elif kind == "referee" and data.get("event") == "broken" and data["reason"].startswith("instructed while"):
            yield f"{at:.2f} {data['machine']}: {data['reason']}"


def problems(done, out):
    if done.returncode:
        return [f"code {done.returncode}: {done.stderr.strip()}"]
    result = json.loads((out / "result.json").read_text())
    log = (out / "logs" / "agent.log").read_text()
    bad = [] if any(order["correct"] for order in result["orders"]) else ["no delivery"]
    bad += [line for line in log.splitlines() if "no step is running" in line or "nothing has ended" in line]
    return bad + list(booked_twice((out / "journal.jsonl").read_text()))


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    program, scenario, first, last = sys.argv[1:]
    points, failed = [], 0
    with tempfile.TemporaryDirectory(prefix="cxlab-failures-") as folder:
        for seed in range(int(first), int(last) + 1):
            out = pathlib.Path(folder) / str(seed)
            bad = problems(play(program, scenario, seed, out), out)
            points.append(json.loads((out / "result.json").read_text())["teams"]["CYAN"]["points"] if not bad else 0)
            print(f"seed {seed}: {points[-1]} points", *bad, sep="\n  ", flush=True)
            failed += bool(bad)
    mean = sum(points) / len(points)
    print(f"{len(points) - failed} good, {failed} bad; mean {mean:.0f} points, least {min(points)}")
    sys.exit(1 if failed or mean < LEAST_MEAN else 0)


if __name__ == "__main__":
    main()
