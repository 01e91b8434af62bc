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
from cxlab.learn.features import KINDS, OPTION, SITUATION

Policy = Callable[[Choice], int]


def preferred(choice: Choice) -> int:
    """The policy of the rules themselves."""
    return choice.preferred


class Terms:
    """Terms of a kind of choice.

    A term is a feature of the option ("worth"), or the product of one with another feature of the option or of the situation
    ("none*products"); of a name that both have, the option's counts.
    """

    def __init__(self, kind: str, terms: Iterable[str]) -> None:
        if kind not in OPTION:
            raise ValueError(f"kind of choice {kind!r}: expected one of {', '.join(OPTION)}")
        self._names = OPTION[kind]
        factors = (*self._names, *SITUATION[kind], "")  # "" is 1
        pairs = []
        for term in terms:
            factor, product, other = term.partition("*")
            if factor not in self._names:
                raise ValueError(f"weights of {kind!r}: no feature {factor!r}; expected {', '.join(self._names)}")
            if product and other not in factors[:-1]:
                raise ValueError(f"weights of {kind!r}: no feature {other!r} after the *; expected {', '.join(factors[:-1])}")
            pairs.append((factors.index(factor), factors.index(other)))
        self._pairs = np.array(pairs, dtype=np.intp).reshape(-1, 2)

    def values(self, choice: Choice) -> NDArray[np.float64]:
        """The terms of each option: float64, shape (options, terms)."""
        options, width = choice.features.shape
        if width != len(self._names):
            raise ValueError(f"found {width} features of {choice.kind!r}, expected {len(self._names)}: {', '.join(self._names)}")
        rest = np.append(choice.situation, 1.0)
        factors = np.vstack([choice.features.T, np.broadcast_to(rest[:, None], (len(rest), options))])
        values: NDArray[np.float64] = (factors[self._pairs[:, 0]] * factors[self._pairs[:, 1]]).T
        return values


def term_values(choice: Choice, terms: Iterable[str]) -> NDArray[np.float64]:
    """The terms of each option, for once: float64, shape (options, terms)."""
    return Terms(choice.kind, terms).values(choice)


class LinearPolicy:
    """Takes the option with the largest weighted sum of its terms (`Terms`).

    Args:
        weights: for each kind of choice, the weight of each term; what is missing weighs 0. Of a kind without weights the rules'
            option is taken.
    """

    def __init__(self, weights: Mapping[str, Mapping[str, float]]) -> None:
        self.weights = {kind: dict(by_term) for kind, by_term in weights.items()}
        self._sums = {kind: (Terms(kind, by_term), np.array(list(by_term.values()))) for kind, by_term in self.weights.items()}

    def scores(self, choice: Choice) -> NDArray[np.float64]:
        """The weighted sum of each option: shape (options,)."""
        if choice.kind not in self._sums:
            return np.eye(len(choice.options))[choice.preferred]
        terms, weights = self._sums[choice.kind]
        sums: NDArray[np.float64] = terms.values(choice) @ weights
        return sums

    def __call__(self, choice: Choice) -> int:
        return int(np.argmax(np.where(choice.allowed, self.scores(choice), -np.inf)))

    @staticmethod
    def greedy() -> LinearPolicy:
        """What the rules choose, as weights."""
        return LinearPolicy({kind: {"preferred": 1.0} for kind in KINDS})

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
