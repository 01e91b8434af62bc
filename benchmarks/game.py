#!/usr/bin/env python3
"""Figures of whole games: speed, share of bare physics, cost of the journal, two at once, memory, pictures.

    benchmarks/game.py PROGRAM [SCENARIO] [--rounds N]

Bare physics is the same model stepped with the recorded controls and writes (`replay --physics`), whose hash must be that
of the game. The runs to compare take turns as whole processes. Their CPU time counts, and medians are printed.
"""
import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time


def cpu_of(command):
    """CPU seconds of the command and what it printed."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scenario", nargs="?", default=str(pathlib.Path(__file__).parent.parent / "scenarios/rcll/game.yaml"))
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-bench-"))

    def run(name, *more):
        out = str(folder / name) if name else "none"
        return [options.program, "run", options.scenario, "--json", "--quiet", "--force", "--out", out, *more]

    times = {name: [] for name in ("physics", "bare", "timed", "timed, no files", "physics, no files")}
    results = {}
    for _ in range(options.rounds):
        for name, command in (
            ("physics", run("physics")),
            ("bare", [options.program, "replay", str(folder / "physics"), "--physics", "--json"]),
            ("physics, no files", run("")),
            ("timed", run("timed", "--tier", "timed")),
            ("timed, no files", run("", "--tier", "timed")),
        ):
            seconds, out = cpu_of(command)
            times[name].append(seconds)
            results[name] = json.loads(out)
    if not results["bare"]["physics"]["same"]:
        sys.exit("the replayed physics ended in another hash")
    median = {name: statistics.median(values) for name, values in times.items()}
    game = results["physics"]
    print(f"scenario {game['scenario']}, seed {game['seed']}, {game['sim_time_s']:.0f} s, {options.rounds} rounds")
    for tier in ("physics", "timed"):
        r = results[tier]
        points = ", ".join(f"{team} {t['points']}" for team, t in r["teams"].items())
        busy = min((robot["busy_s"] / r["sim_time_s"] for robot in r["robots"]), default=0)
        print(f"{tier:8} {median[tier]:6.2f} s CPU = {r['sim_time_s'] / median[tier]:6.0f} x real time; {points}; "
              f"robots at work >= {busy:.0%}; {r['peak_rss_mb']:.0f} MB; hash {r['journal_hash'][:16]}")
    print(f"bare physics {median['bare']:.2f} s CPU; game / bare physics = {median['physics'] / median['bare']:.2f}")
    for tier in ("physics", "timed"):
        without = median[f"{tier}, no files"]
        print(f"files of a run, {tier}: {median[tier] / without - 1:+.0%} of {without:.2f} s")

    pair = []
    for jobs in (1, 2):
        start = time.monotonic()
        children = [subprocess.Popen(run(f"pair{i}"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for i in range(jobs)]
        for child in children:
            child.wait()
        pair.append(time.monotonic() - start)
    print(f"two processes on {os.cpu_count()} cores: {2 * pair[0] / pair[1]:.2f} x one")
    with_pictures, _ = cpu_of(run("pictures", "--snapshot", "every:60"))
    snapshots = len(list((folder / "pictures/snapshots").glob("*.png")))
    memory = json.loads((folder / "pictures/result.json").read_text())["peak_rss_mb"]
    print(f"pictures: {(with_pictures - median['physics']) / snapshots * 1000:.0f} ms each of {snapshots}; {memory:.0f} MB")
    size = sum(f.stat().st_size for f in (folder / "physics").rglob("*") if f.is_file()) / 1e6
    print(f"folder of a run: {size:.1f} MB")


if __name__ == "__main__":
    main()
