#!/usr/bin/env python3
"""Plays games in which things go wrong, and checks that the agent recovers.

    fault_games.py PROGRAM SCENARIO TIER FIRST_SEED LAST_SEED [--until SECONDS] [KIND[+KIND]...]...

For each kind of fault that `PROGRAM list faults` names: enough deliveries, no skill that fails again and again. For each
kind, and for all of them together: no time in which nothing happens, and in the result the points that the journal has.
Under all faults at once a single game may end with few points, ten games and more must reach a mean. After each kind a
line sums up; "broken" are games without a result, with another exit code than 0, or whose points differ.
In a shorter game less is enough. Kinds that a plus joins share a game, in which each must strike.
"""
import collections
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

WHOLE_S = 1200
LEAST_DELIVERIES = 2         # in a whole game
LEAST_POINTS = 100
LEAST_MEAN_TOGETHER = 150    # of all kinds at once, some 88 strikes a game
MOST_FAILURES = 60           # of skills, in a game with a dozen strikes
MOST_FAILURES_IN_A_ROW = 8   # of one robot, the same skill at the same target, without a success (a transport picks and places)
LONGEST_PAUSE_S = 150        # without the end of any skill; a machine may be down for that long

MACHINES = ["C-BS", "C-CS1", "C-CS2", "C-DS", "C-RS1", "C-RS2"]
FAULTS = {
    "skill_fails": [{"probability": 0.15, "after_s": 10}],
    "skill_stalls": [{"probability": 0.15, "seconds": 15}],
    "goal_lost": [{"probability": 0.1}],
    "result_late": [{"probability": 0.15, "seconds": 10}],
    "grasp_slips": [{"probability": 0.15, "after_s": 5}],
    "piece_dropped": [{"mean_s": 400}],
    "piece_misplaced": [{"probability": 0.15}],
    "robot_halts": [{"mean_s": 300, "seconds": 60}],
    "robot_slow": [{"mean_s": 300, "factor": 0.4, "seconds": 60}],
    "pose_noise": [{"probability": 0.5, "sigma_m": 0.1, "sigma_deg": 8}],
    "machine_breaks": [{"mean_s": 600, "machine": machine} for machine in MACHINES],
    "machine_down": [{"mean_s": 400, "machine": machine, "seconds": 45} for machine in MACHINES],
    "piece_taken": [{"mean_s": 600, "machine": machine} for machine in MACHINES],
    "instruction_lost": [{"probability": 0.15, "machine": machine} for machine in MACHINES],
    "instruction_late": [{"probability": 0.3, "machine": machine, "seconds": 10} for machine in MACHINES],
    "robot_maintenance": [{"mean_s": 400, "seconds": 60, "times": 2}],
}
TOGETHER = {
    "skill_fails": [{"probability": 0.05, "after_s": 10}],
    "skill_stalls": [{"probability": 0.05, "seconds": 10}],
    "goal_lost": [{"probability": 0.03}],
    "result_late": [{"probability": 0.05, "seconds": 5}],
    "grasp_slips": [{"probability": 0.05, "after_s": 5}],
    "piece_dropped": [{"mean_s": 1200}],
    "piece_misplaced": [{"probability": 0.03}],
    "robot_halts": [{"mean_s": 900, "seconds": 30}],
    "robot_slow": [{"mean_s": 900, "factor": 0.5, "seconds": 30}],
    "pose_noise": [{"probability": 0.2, "sigma_m": 0.1, "sigma_deg": 8}],
    "machine_breaks": [{"mean_s": 2400, "machine": machine} for machine in MACHINES],
    "machine_down": [{"mean_s": 1200, "machine": machine, "seconds": 30} for machine in MACHINES],
    "piece_taken": [{"mean_s": 2400, "machine": machine} for machine in MACHINES],
    "instruction_lost": [{"probability": 0.03, "machine": machine} for machine in MACHINES],
    "instruction_late": [{"probability": 0.1, "machine": machine, "seconds": 5} for machine in MACHINES],
    "robot_maintenance": [{"mean_s": 1200, "seconds": 45}],
}


def faults_of(kind):
    chosen = TOGETHER if kind == "together" else {name: FAULTS[name] for name in kind.split("+")}
    return [{"kind": name, **keys} for name, list_of_keys in chosen.items() for keys in list_of_keys]


def problems(folder, kind, share):
    """The faults of a game; last, points, deliveries and a line of figures."""
    result = json.loads((folder / "result.json").read_text())
    failures = worst = 0
    strikes = collections.Counter()
    row = collections.Counter()
    points = collections.Counter()
    ends = [0.0]
    for line in (folder / "journal.jsonl").open():
        if '"kind":"bus"' in line:
            continue
        record = json.loads(line)
        data = record["data"]
        if record["kind"] == "control" and "fault" in data:
            strikes[data["fault"]] += 1
        if record["kind"] == "referee" and data["event"] == "score":
            points[data["team"]] += data["points"]
        if record["kind"] != "skill" or data["event"] != "end":
            continue
        ends.append(record["t"] / 1e9)
        key = (data["robot"], data["skill"], data["target"])
        if data["code"] == 0:
            row[key] = 0
            if data["skill"] == "transport":
                fetched, put = data["target"].split(" to ")
                row[data["robot"], "pick", fetched] = row[data["robot"], "place", put] = 0
        elif not data["cancelled"]:
            failures += 1
            row[key] += 1
            worst = max(worst, row[key])
    ends.append(result["sim_time_s"])
    pause = max(b - a for a, b in zip(ends, ends[1:]))
    accepted = sum(d["correct"] for d in result["deliveries"])
    if result["status"] != ("completed" if share == 1 else "stopped"):
        yield f"broken: status {result['status']}: {result['reason']}"
    if any(team["points"] != points[name] for name, team in result["teams"].items()):
        yield f"broken: journal and result differ in points: {dict(points)}"
    if kind != "together":
        yield from (f"no {name} struck" for name in kind.split("+") if not strikes[name])
    if kind != "together":
        if accepted < LEAST_DELIVERIES * share:
            yield f"only {accepted} deliveries"
        if (most := max(team["points"] for team in result["teams"].values())) < LEAST_POINTS * share:
            yield f"only {most} points"
        if failures > MOST_FAILURES or worst > MOST_FAILURES_IN_A_ROW:
            yield f"{failures} failures, {worst} in a row"
    if pause > LONGEST_PAUSE_S:
        yield f"nothing happens for {pause:.0f} s"
    if any(not 0 <= robot["maintenances"] <= 2 or robot["contacts"] for robot in result["robots"]):
        yield f"broken: {result['robots']}"
    yield sum(points.values()), accepted, f"{sum(points.values())} points, {accepted} delivered, {strikes.total()} faults, {failures} failures, {worst} in a row, pause {pause:.0f} s"


def main():
    if len(sys.argv) < 6:
        sys.exit(__doc__)
    program, scenario, tier, first, last, *kinds = sys.argv[1:]
    until = float(kinds[1]) if kinds[:1] == ["--until"] else WHOLE_S
    kinds = kinds[2:] if kinds[:1] == ["--until"] else kinds
    share = until / WHOLE_S
    listed = subprocess.run([program, "list", "faults"], capture_output=True, text=True, check=True).stdout
    known = {line.split()[0] for line in listed.splitlines() if line[:1].strip()}
    if known != FAULTS.keys():
        sys.exit(f"`cxlab list faults` and this script differ: {known ^ FAULTS.keys()}")
    failed = played = 0
    with tempfile.TemporaryDirectory(prefix="cxlab-faults-") as folder:
        for kind in kinds or [*FAULTS, "together"]:
            arguments = ["--set", "faults=" + json.dumps(faults_of(kind)), "--until", str(until)]
            games = []
            for seed in range(int(first), int(last) + 1):
                out = pathlib.Path(folder) / f"{kind}-{seed}"
                done = subprocess.run([program, "run", scenario, "--tier", tier, "--seed", str(seed), "--quiet", "--out",
                                       str(out), *arguments], capture_output=True, text=True)
                *bad, (points, delivered, figures) = (
                    problems(out, kind, share) if (out / "result.json").exists() else ["broken: no result", (0, 0, "")])
                if done.returncode:
                    bad.append(f"broken: exit code {done.returncode}: {done.stderr}")
                games.append((points, delivered, any(text.startswith("broken") for text in bad)))
                shutil.rmtree(out, ignore_errors=True)
                print(f"{kind}, seed {seed}: {figures}", *bad, sep="; ", flush=True)
                played += 1
                failed += bool(bad)
            points, delivered, broken = zip(*games)
            mean = sum(points) / len(games)
            print(f"{kind}: {len(games)} games, {mean:.0f} points on average, at least {min(points)}, "
                  f"{delivered.count(0)} without delivery, {sum(broken)} broken")
            if kind == "together" and len(games) >= 10 and mean < LEAST_MEAN_TOGETHER:
                print(f"together: found {mean:.0f} points on average, expected {LEAST_MEAN_TOGETHER} at least")
                failed += 1
    print(f"{played - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
