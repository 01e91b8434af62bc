"""Searches a few weights of a dispatcher with Ray Tune, on one machine or on the nodes of a cluster.

    python tune_dispatcher.py [--address ADDRESS] [--out tuning] [--trials 16] [--seeds 1..8] [--until SECONDS]

Needs `ray[tune]`, and cxlab on each node. A trial plays all seeds with its weights and with what the rules prefer; `gain` is the mean
difference of their points. The best weights are printed as JSON, for `cxlab.learn.LinearPolicy.load`.
"""

from __future__ import annotations

import argparse
import os
from typing import Any

import numpy as np
import ray
from ray import tune

from cxlab.learn import LinearPolicy, play_all
from cxlab.learn.policy import preferred


def policy_of(config: dict[str, float]) -> LinearPolicy:
    return LinearPolicy(
        {
            "begin-order": {"preferred": 1.0, "worth": config["worth"], "none": config["none"], "to_end": config["to_end"]},
            "take-job": {"preferred": 1.0, "way": config["way"]},
        }
    )


def trial(config: dict[str, Any]) -> None:
    points = play_all([preferred, policy_of(config)], config["seeds"], until=config["until"])
    tune.report({"gain": float(np.mean(points[1] - points[0])), "node": ray.get_runtime_context().get_node_id()})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--address", help="of the cluster; without it one is started on this machine")
    parser.add_argument("--out", default="tuning", help="folder of the results (tuning)")
    parser.add_argument("--trials", type=int, default=16)
    parser.add_argument("--seeds", default="1..8", help="FIRST..LAST")
    parser.add_argument("--until", type=float, help="end of each game, s")
    arguments = parser.parse_args()
    first, last = (int(part) for part in arguments.seeds.split(".."))
    ray.init(address=arguments.address, include_dashboard=False if arguments.address is None else None)
    space = {
        **{name: tune.uniform(-1.0, 1.0) for name in ("worth", "none", "to_end", "way")},
        "seeds": list(range(first, last + 1)),
        "until": arguments.until,
    }
    tuner = tune.Tuner(
        tune.with_resources(trial, {"cpu": 1}),
        param_space=space,
        tune_config=tune.TuneConfig(
            metric="gain",
            mode="max",
            num_samples=arguments.trials,
            search_alg=tune.search.BasicVariantGenerator(random_state=1),
        ),
        run_config=tune.RunConfig(name="dispatcher", storage_path=os.path.abspath(arguments.out), verbose=0),
    )
    results = tuner.fit()
    if results.errors:
        raise SystemExit(f"{len(results.errors)} trials failed, the first: {results.errors[0]}")
    best = results.get_best_result()
    nodes = {result.metrics["node"] for result in results}
    print(f"{len(results)} trials on {len(nodes)} node(s); best gain {best.metrics['gain']:+.1f} points")
    print(policy_of(best.config).to_json())


if __name__ == "__main__":
    main()
