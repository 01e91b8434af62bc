#!/usr/bin/env python3
"""What it costs to look at a run in Python: data frames of a full journal, and questions about rules.

    PYTHONPATH=build/release/python CXLAB=build/release/cxlab benchmarks/python_runs.py [RUN]

Without RUN it plays a game of 1,200 s of the planning agent with a full journal. Needs pandas, polars and pyarrow.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cxlab


def best(name, call, rounds=3):
    """The least of some rounds, wall time and CPU time of this process."""
    times = []
    for _ in range(rounds):
        wall, cpu = time.perf_counter(), time.process_time()
        made = call()
        times.append((time.perf_counter() - wall, time.process_time() - cpu))
    print(f"{name:44} {min(wall for wall, _ in times):7.3f} s  {min(cpu for _, cpu in times):7.3f} s CPU")
    return made


def main(folder):
    import pandas  # noqa: F401 - not counted
    import polars  # noqa: F401
    import pyarrow  # noqa: F401

    journal = Path(folder) / "journal.jsonl"
    print(f"journal: {journal.stat().st_size / 1e6:.1f} MB")
    with cxlab.Run(folder) as run:
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        frame = best("records, pandas", run.records)
        used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        print(f"{len(frame):,} records; memory of this process grew by {used / 1024:.0f} MB")
        best("records, polars", run.polars.records)
        best("records, Arrow", run.arrow.records)
        best("records of the referee", lambda: run.records("referee"))
        best("skills with their fields", lambda: run.records("skill", fields=True))
        best("points", lambda: run.points)
        best("orders", lambda: run.orders)
        best("card of a notebook", run._repr_html_)
        end = run.result["sim_time_s"]

        def first():
            run.close()
            return run.facts(end / 2, "order")

        best("first question, facts in the middle", first)
        best("next question at that time", lambda: run.facts(end / 2, "order"), 5)
        rules = run.rules(end / 2)
        latest = rules.loc[rules["last_s"].idxmax(), "rule"]
        best("why there, of the rule that fired last", lambda: run.why(latest, end / 2))
        run.facts(end / 2, "order")
        best("first question at the end", lambda: (run.close(), run.facts(None, "order")))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(sys.argv[1])
    else:
        with tempfile.TemporaryDirectory() as scratch:
            game = Path(scratch) / "game"
            subprocess.run(
                [
                    os.fspath(cxlab.program()),
                    "run",
                    "rcll/planning",
                    "--tier",
                    "timed",
                    "--seed",
                    "1",
                    "--journal",
                    "full",
                ]
                + ["--quiet", "--out", str(game)],
                check=True,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            main(game)
