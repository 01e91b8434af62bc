"""Policies that need nothing but NumPy, and games played with them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from importlib import resources
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cxlab.learn.choices import Choice, ChoiceGame
from cxlab.learn.features import KINDS, OPTION

Policy = Callable[[Choice], int]


def preferred(choice: Choice) -> int:
    """The policy of the rules themselves."""
    return choice.preferred


class LinearPolicy:
    """Takes the option with the largest weighted sum of its features.

    Args:
        weights: for each kind of choice, the weight of each feature by name; what is missing weighs 0. Of a kind without
            weights the rules' option is taken.
    """

    def __init__(self, weights: Mapping[str, Mapping[str, float]]) -> None:
        self.weights = {kind: dict(by_name) for kind, by_name in weights.items()}
        self._vectors = {}
        for kind, by_name in self.weights.items():
            if kind not in OPTION:
                raise ValueError(f"kind of choice {kind!r}: expected one of {', '.join(OPTION)}")
            unknown = set(by_name) - set(OPTION[kind])
            if unknown:
                raise ValueError(f"weights of {kind!r}: no feature {min(unknown)!r}; expected {', '.join(OPTION[kind])}")
            self._vectors[kind] = np.array([by_name.get(name, 0.0) for name in OPTION[kind]])

    def __call__(self, choice: Choice) -> int:
        weights = self._vectors.get(choice.kind)
        if weights is None:
            return choice.preferred
        return int(np.argmax(np.where(choice.allowed, choice.features @ weights, -np.inf)))

    @staticmethod
    def greedy() -> LinearPolicy:
        """What the rules choose, as weights: the place where training begins."""
        return LinearPolicy({kind: {"preferred": 1.0} for kind in KINDS})

    def vector(self) -> NDArray[np.float64]:
        """All weights, one kind after the other."""
        return np.concatenate([self._vectors.get(kind, np.zeros(len(OPTION[kind]))) for kind in KINDS])

    @staticmethod
    def of_vector(vector: NDArray[np.float64]) -> LinearPolicy:
        """The inverse of `vector`."""
        values = iter(np.asarray(vector, dtype=float).tolist())
        return LinearPolicy({kind: {name: next(values) for name in OPTION[kind]} for kind in KINDS})

    def to_json(self) -> str:
        return json.dumps(self.weights, indent=2) + "\n"

    @staticmethod
    def load(file: str | os.PathLike[str]) -> LinearPolicy:
        with open(file, encoding="utf-8") as text:
            return LinearPolicy(json.load(text))


def shipped_policy() -> LinearPolicy:
    """The policy that comes with cxlab, trained by python/examples/train_dispatcher.py."""
    return LinearPolicy(json.loads(resources.files("cxlab.learn").joinpath("dispatcher.json").read_text(encoding="utf-8")))


def play(policy: Policy, seed: int, *, scenario: str | os.PathLike[str] = "rcll/external", tier: str = "timed", **more: Any) -> dict[str, Any]:
    """Play a whole game with a policy; its result."""
    with ChoiceGame(scenario, seed=seed, tier=tier, **more) as game:
        while (choice := game.next()) is not None:
            game.choose(policy(choice))
        return game.close()


def _points(task: tuple[Policy, int, str, dict[str, Any]]) -> int:
    policy, seed, team, more = task
    return int(play(policy, seed, **more)["teams"][team]["points"])


def play_all(policies: Iterable[Policy], seeds: Iterable[int], *, processes: int = 1, team: str = "CYAN", **more: Any) -> NDArray[np.int64]:
    """Points of each policy with each seed, shape (policies, seeds). The answer is the same with any number of processes."""
    policies, seeds = list(policies), list(seeds)
    tasks = [(policy, seed, team, more) for policy in policies for seed in seeds]
    if processes <= 1:
        points = [_points(task) for task in tasks]
    else:
        with ProcessPoolExecutor(processes, mp_context=get_context("forkserver")) as pool:
            points = list(pool.map(_points, tasks, chunksize=1))
    return np.array(points, dtype=np.int64).reshape(len(policies), len(seeds))
