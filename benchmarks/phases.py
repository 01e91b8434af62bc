#!/usr/bin/env python3
"""How long each phase of each skill takes in games, beside what was measured on robots of the league.

    benchmarks/phases.py PROGRAM [SCENARIO] [--games N] [--tier physics|timed]

Plays games with seeds 101, 102, ... and prints, in seconds, the mean of each phase of the skills that ended well. A
`pick` or `place` is split by the kind of its spot. Time that a robot waits for others (`wait`) is listed, not summed.
"""
import argparse
import collections
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

# Estimates of a league team for its robots, which include alignment: see docs/reference/skills.md.
LEAGUE = {"pick at belt": 20.9, "pick at shelf": 24.2, "place at belt": 19.2, "place at slide": 23.5, "discard": 8.25, "explore": 14.7}
NOT_SUMMED = ("drive", "wait")


def name_of(skill):
    if skill["skill"] not in ("pick", "place"):
        return skill["skill"]
    spot = skill["target"]
    return skill["skill"] + " at " + ("shelf" if "SHELF" in spot else "slide" if "SLIDE" in spot else "belt")


def skills_of(journal):
    """(name, {phase: seconds}) of each skill of the journal that ended well."""
    running = {}
    for line in journal.open():
        record = json.loads(line)
        if record["kind"] != "skill":
            continue
        data, now = record["data"], record["t"] / 1e9
        robot = data["robot"]
        if data["event"] == "start":
            running[robot] = collections.defaultdict(float), None, now
        elif robot in running and data["event"] in ("phase", "end"):
            spans, phase, since = running[robot]
            if phase:
                spans[phase] += now - since
            running[robot] = spans, data.get("phase"), now
            if data["event"] == "end":
                del running[robot]
                if data["code"] == 0 and not data["cancelled"]:
                    yield name_of(data), spans


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenario", nargs="?", default=str(pathlib.Path(__file__).parent.parent / "scenarios/rcll/game.yaml"))
    parser.add_argument("--games", type=int, default=10)
    parser.add_argument("--tier", default="physics")
    options = parser.parse_args()

    times = collections.defaultdict(list)
    with tempfile.TemporaryDirectory(prefix="cxlab-phases-") as folder:
        for seed in range(101, 101 + options.games):
            out = pathlib.Path(folder) / str(seed)
            done = subprocess.run(
                [options.program, "run", options.scenario, "--seed", str(seed), "--tier", options.tier, "--quiet", "--out", str(out)],
                capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"seed {seed} ended with {done.returncode}:\n{done.stderr}")
            for name, spans in skills_of(out / "journal.jsonl"):
                times[name].append(spans)

    print("| Skill | Number | Phases | At the machine | League |")
    print("|---|---|---|---|---|")
    for name in sorted(times):
        spans = times[name]
        phases = list(dict.fromkeys(phase for one in spans for phase in one))
        mean = {phase: statistics.fmean(one.get(phase, 0.0) for one in spans) for phase in phases}
        listed = ", ".join(f"{phase} {mean[phase]:.1f}" for phase in phases)
        work = sum(mean[phase] for phase in phases if phase not in NOT_SUMMED)
        print(f"| {name} | {len(spans)} | {listed} | {f'{work:.1f}' if work else ''} | {LEAGUE.get(name, '')} |")


if __name__ == "__main__":
    main()
