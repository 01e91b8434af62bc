"""Policies that need nothing but NumPy, and games played with them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
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


def term_values(choice: Choice, terms: Sequence[str]) -> NDArray[np.float64]:
    """The terms of each option: float64, shape (options, terms).

    A term is a feature of the option ("worth"), or the product of one with another feature of the option or of the situation
    ("none*products"); of a name that both have, the option's counts.
    """
    names = OPTION[choice.kind]
    if choice.features.shape[1] != len(names):
        raise ValueError(f"found {choice.features.shape[1]} features of {choice.kind!r}, expected {len(names)}: {', '.join(names)}")
    columns = []
    for term in terms:
        factor, _, other = term.partition("*")
        column = choice.features[:, names.index(factor)]
        if other in names:
            column = column * choice.features[:, names.index(other)]
        elif other:
            column = column * choice.situation[SITUATION.index(other)]
        columns.append(column)
    values: NDArray[np.float64] = np.array(columns).reshape(len(terms), len(choice.options)).T
    return values


class LinearPolicy:
    """Takes the option with the largest weighted sum of its terms (`term_values`).

    Args:
        weights: for each kind of choice, the weight of each term; what is missing weighs 0. Of a kind without weights the rules'
            option is taken.
    """

    def __init__(self, weights: Mapping[str, Mapping[str, float]]) -> None:
        self.weights = {kind: dict(by_term) for kind, by_term in weights.items()}
        for kind, by_term in self.weights.items():
            if kind not in OPTION:
                raise ValueError(f"kind of choice {kind!r}: expected one of {', '.join(OPTION)}")
            for term in by_term:
                factor, product, other = term.partition("*")
                if factor not in OPTION[kind]:
                    raise ValueError(f"weights of {kind!r}: no feature {factor!r}; expected {', '.join(OPTION[kind])}")
                if product and other not in (*OPTION[kind], *SITUATION):
                    raise ValueError(
                        f"weights of {kind!r}: no feature {other!r} after the *; expected {', '.join((*OPTION[kind], *SITUATION))}"
                    )

    def scores(self, choice: Choice) -> NDArray[np.float64]:
        """The weighted sum of each option: shape (options,)."""
        by_term = self.weights.get(choice.kind)
        sums: NDArray[np.float64]
        if by_term is None:
            sums = np.eye(len(choice.options))[choice.preferred]
        else:
            sums = term_values(choice, list(by_term)) @ np.array(list(by_term.values()))
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
