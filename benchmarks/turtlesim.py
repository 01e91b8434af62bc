#!/usr/bin/env python3
"""How fast the turtlesim examples play: simulated time over CPU time of the whole process, start and end included.

turtlesim.py CXLAB [--rounds N]
"""

import argparse
import json
import os
import pathlib
import resource
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SCENARIOS = HERE.parent / "scenarios" / "turtlesim"
HOUR = 3600


def driven(folder):
    """The boundary checks with a turtle that is driven on and on."""
    text = (SCENARIOS / "boundary.yaml").read_text()
    head = text[: text.index("stimuli:")].replace("agents/", f"{SCENARIOS}/agents/").replace(": agents}", f": {SCENARIOS}/agents}}")
    for second in range(HOUR):
        head += "stimuli:\n" if second == 0 else ""
        twist = f"{{linear: {{x: {1.5 + second % 3}}}, angular: {{z: {0.3 * (second % 5)}}}}}"
        head += f"  - {{at: {second}, publish: /turtle1/cmd_vel, type: geometry_msgs/msg/Twist, data: {twist}}}\n"
    path = pathlib.Path(folder) / "driven.yaml"
    path.write_text(head)
    return path


def play(program, scenario, duration, out):
    command = [program, "run", str(scenario), "--set", f"duration_s={duration}", "--out", out, "--force", "--quiet", "--json"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu, json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        cases = [("boundary, driven all the time", driven(folder), HOUR), ("boundary", SCENARIOS / "boundary.yaml", HOUR),
                 ("figures", SCENARIOS / "figures.yaml", 40), ("hypotheses", SCENARIOS / "hypotheses.yaml", HOUR)]
        for name, scenario, duration in cases:
            for files, out in (("files", os.path.join(folder, "run")), ("no files", "none")):
                cpu, result = min((play(options.program, scenario, duration, out) for _ in range(options.rounds)), key=lambda r: r[0])
                print(f"{name}, {files}: {duration / cpu:.0f} x real time ({cpu:.2f} s CPU for {duration} s), "
                      f"{result['peak_rss_mb']:.0f} MB, journal {result['journal_hash']}, canvas {result['physics_hash']}")


if __name__ == "__main__":
    main()
