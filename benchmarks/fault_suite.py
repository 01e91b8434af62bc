#!/usr/bin/env python3
"""Writes a suite of `cxlab bench` that plays a scenario under each kind of fault, and under all of them together.

    benchmarks/fault_suite.py FILE SCENARIO SEEDS [OVERRIDE]...     SEEDS: "10001..10040"

Its strategies are the kinds, at the rates of tests/scenarios/rcll/fault_games.py; the overrides, as of `cxlab run --set`, are those of all of
them. So `cxlab bench compare` answers for each kind whether one agent beats another one.
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/scenarios/rcll"))
import fault_games  # noqa: E402


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    file, scenario, seeds, *overrides = sys.argv[1:]
    kinds = [*fault_games.FAULTS, "together"]
    strategies = {kind: [*overrides, "faults=" + json.dumps(fault_games.faults_of(kind))] for kind in kinds}
    suite = {"scenarios": [str(pathlib.Path(scenario).resolve())], "tier": "timed", "seeds": seeds, "strategies": strategies}
    pathlib.Path(file).write_text(json.dumps(suite, indent=1) + "\n")


if __name__ == "__main__":
    main()
