#!/usr/bin/env python3
"""Asks a game of the Logistics League: which orders were late, what robots waited for, and why.

python/examples/ask_a_run.py runs/game-1
"""

import sys

import cxlab


def main(folder: str) -> None:
    with cxlab.Run(folder) as run:
        print(run)
        print(run.orders[["order", "complexity", "points", "state", "outcome"]].to_string(index=False))

        waits = run.waits
        print("\nwhat robots waited for, in s:")
        print(waits.groupby(["robot", "for"])["length_s"].sum().sort_values(ascending=False).head(5).to_string())

        skills = run.skills
        print("\nmean time of each skill, in s:")
        print((skills.end_s - skills.begin_s).groupby(skills.skill).mean().round(1).to_string())

        half = run.result["sim_time_s"] / 2
        print(f"\nwhat each rule that never fired lacks at {half:g} s:")
        rules = run.rules(half)
        for rule in rules[rules.fired == 0].head(5).itertuples():
            print(f"  {rule.rule}: {rule.lacks or 'was on the agenda'}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        main(sys.argv[1])
    except cxlab.CxlabError as error:
        sys.exit(f"error: {error}")
