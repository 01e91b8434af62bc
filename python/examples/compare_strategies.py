#!/usr/bin/env python3
"""Compares two robots with three in the same games of a scenario, and says whether the answer is sure.

python/examples/compare_strategies.py scenarios/rcll/game.yaml runs/robots
"""

import sys

import cxlab


def main(scenario: str, out: str) -> None:
    suite = {
        "scenarios": [scenario],
        "tier": "timed",
        "seeds": "1..12",
        "strategies": {"three robots": ["duration_s=300"], "two robots": ["duration_s=300", "world.robots=2"]},
    }
    sweep = cxlab.bench(suite, out=out, jobs=2)
    print(sweep.scores[["strategy", "games", "mean", "mean_95_low", "mean_95_high"]].to_string(index=False))
    for row in sweep.differences.itertuples():
        print(
            f"{row.strategy} against {row.against}: {row.difference:+.1f} points "
            f"({row.difference_95_low:.1f} to {row.difference_95_high:.1f}), "
            f"better in {row.improvement:.0%} of games: {row.answer}"
        )


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except cxlab.CxlabError as error:
        sys.exit(f"error: {error}")
