#!/usr/bin/env python3
"""Plays games with pauses, and the same games without.

    paused_games.py PROGRAM SCENARIO FIRST_SEED LAST_SEED [--physics-until SECONDS]

In the timed tier the agent earns as much in both; in the physics tier robots brake and begin their drives again, without trouble.
In a pause nobody gets points and no machine changes, and a paused game replays.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

PAUSES = [(100, 20), (300, 60), (607.3, 12.34), (900, 5)]   # s of production, s
SETTLES_S = 0.06                                              # of a piece that was in the air
LEAST_SHARE = 0.97                                            # of the points


def play(program, scenario, folder, seed, tier, paused, *more):
    pauses = ", ".join(f"{{at: {at}, for: {seconds}}}" for at, seconds in PAUSES) if paused else ""
    subprocess.run([program, "run", scenario, "--seed", str(seed), "--tier", tier, "--out", folder, "--set",
                    f"world.pauses=[{pauses}]", *more], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    result = json.loads((folder / "result.json").read_text())
    records = [json.loads(line) for line in (folder / "journal.jsonl").open() if '"kind":"referee"' in line]
    return result, [(r["t"] / 1e9, r["data"]) for r in records]


def check_pauses(events, count=len(PAUSES)):
    states = [(t, data) for t, data in events if data["event"] == "state"]
    assert [data["state"] for _, data in states] == ["PAUSED", "RUNNING"] * count, states
    assert all(data["cause"] == "scenario" for _, data in states)
    for (begin, _), (end, data), (at, seconds) in zip(states[::2], states[1::2], PAUSES):
        assert abs(data["game_time"] - at) <= 0.02 and abs(end - begin - seconds) <= 0.02, (begin, end, data)
        for t, what in events:
            if begin < t < end:
                assert what["event"] == "piece" and t < begin + SETTLES_S, (t, what)


def main():
    if len(sys.argv) not in (5, 7):
        sys.exit(__doc__)
    until = float(sys.argv[6]) if len(sys.argv) == 7 else 1300
    program, scenario, first, last = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        sums = [0, 0], [0, 0]   # points and failures, without and with pauses
        for seed in range(first, last + 1):
            plain, _ = play(program, scenario, folder / f"plain-{seed}", seed, "timed", False)
            paused, events = play(program, scenario, folder / f"paused-{seed}", seed, "timed", True)
            for total, result in zip(sums, (plain, paused)):
                total[0] += result["teams"]["CYAN"]["points"]
                total[1] += sum(robot["failures"] for robot in result["robots"])
            print(f"seed {seed}, timed: points and failures without and with pauses so far {sums}")
            check_pauses(events)
            assert abs(paused["sim_time_s"] - plain["sim_time_s"] - sum(s for _, s in PAUSES)) < 0.1
        assert sums[1][0] >= LEAST_SHARE * sums[0][0] and sums[1][1] <= sums[0][1] + 1, sums

        paused, events = play(program, scenario, folder / "physics", first, "physics", True, "--until", str(until))
        print(f"seed {first}, physics: {paused['teams']['CYAN']['points']} points with pauses")
        check_pauses(events, sum(at + 2 * seconds < until for at, seconds in PAUSES))
        assert sum(robot["contacts"] for robot in paused["robots"]) == 0, paused["robots"]
        assert sum(robot["failures"] for robot in paused["robots"]) <= 1, paused["robots"]
        assert paused["teams"]["CYAN"]["points"] >= until / 5, paused["teams"]
        for run in ("physics", f"paused-{first}"):
            subprocess.run([program, "replay", folder / run], check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
