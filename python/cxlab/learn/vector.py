"""Many games at once: `cxlab/RCLLDispatch-v0` as a vector environment of Gymnasium, whose games are played in threads."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Unpack

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from cxlab.errors import UsageError
from cxlab.learn.choices import play_on
from cxlab.learn.dispatch import RCLLDispatchEnv
from cxlab.learn.games import OPTIONS, SIZE, Settings

# What `info` has of each choice: the type of its array, and the value of a game that is over.
_OF_CHOICE: dict[str, tuple[Any, Any]] = {"kind": ("<U16", ""), "who": ("<U32", ""), "preferred": (np.int64, 0), "now": (np.float64, 0.0)}


def _begun(env: RCLLDispatchEnv, seeds: tuple[int, int]) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
    """Begins a game; what a step returns that does so."""
    seen, info = env._begin(*seeds)
    return seen, 0.0, False, False, info


class RCLLDispatchVectorEnv(gymnasium.vector.VectorEnv[NDArray[np.float32], NDArray[np.int64], NDArray[Any]]):
    """Games of `RCLLDispatchEnv` at once, played in threads of this process: `gymnasium.make_vec("cxlab/RCLLDispatch-v0", num_envs=16)`.

    Row i plays what an environment of its own would play with seed + i and the same actions. Observation: float32, shape
    (num_envs, 347). Action: int64, shape (num_envs,). An environment whose game has ended begins the next one in the next step, and
    ignores its action there (`AutoresetMode.NEXT_STEP`). `infos` has an array for each key of the single environment's `info`, and
    `_KEY`: where it holds.

    Args:
        num_envs: games at once. A step plays a choice of each of them, so with more games threads wait less for each other.
        threads: that play the games of a step; by default one for each processor, but no more than games.
        scenario, settings: as for `RCLLDispatchEnv`; `out` is for one game.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012  Gymnasium's name and type

    def __init__(
        self,
        num_envs: int = 1,
        *,
        threads: int | None = None,
        scenario: str = "rcll/external",
        render_mode: str | None = None,
        **settings: Unpack[Settings],
    ) -> None:
        if num_envs < 1:
            raise UsageError(f"found {num_envs}, expected 1 or more", "num_envs")
        if threads is not None and threads < 1:
            raise UsageError(f"found {threads}, expected 1 or more", "threads")
        if settings.get("out") is not None:
            raise UsageError("out is for one game: use RCLLDispatchEnv")
        if render_mode is not None:
            raise UsageError(f"found '{render_mode}', expected None: many games have no picture", "render_mode")
        self.num_envs = num_envs
        self.single_observation_space = gymnasium.spaces.Box(-1.0, 1.0, (SIZE,), np.float32)
        self.single_action_space = gymnasium.spaces.Discrete(OPTIONS)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._threads = min(num_envs, threads or len(os.sched_getaffinity(0)))
        self._own_pool = None if settings.get("pool") else ThreadPoolExecutor(self._threads, "cxlab-next-games")
        settings["pool"] = settings.get("pool") or self._own_pool
        self._envs = [RCLLDispatchEnv(scenario, **settings) for _ in range(num_envs)]
        self._going = np.zeros(num_envs, dtype=bool)  # whose game is not over
        self._masks = np.zeros((num_envs, OPTIONS), dtype=bool)
        self._begun = False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin a game in each row: that of `seed` + row, or of the row's own seed; without seeds, those that follow."""
        super().reset(seed=seed if isinstance(seed, int) else None)
        seeds = [seed + row for row in range(self.num_envs)] if isinstance(seed, int) else list(seed or [None] * self.num_envs)
        if len(seeds) != self.num_envs:
            raise UsageError(f"found {len(seeds)} seeds, expected one for each of the {self.num_envs} environments", "seed")
        self._going[:] = False
        seen, *_, infos = self._played(seeds, np.zeros(0, dtype=np.int64))
        return seen, infos

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        if not self._begun:
            raise UsageError("found no games; call reset() first")
        return self._played([None] * self.num_envs, actions)

    def action_masks(self) -> NDArray[np.bool_]:
        """Bool, shape (num_envs, 16): which actions may be chosen."""
        return self._masks.copy()

    def _played(
        self, seeds: Sequence[int | None], actions: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Answers the choices of games that go on, and plays these to the next ones. Begins games in the other rows."""
        if self.closed:
            raise UsageError("the environment is closed")
        self._begun = False  # what raises leaves games in the middle of a step
        good = {int(row): self._envs[row]._games.choose(int(actions[row])) for row in np.flatnonzero(self._going)}
        begun = {row: self._envs[row]._seeds(seed) for row, seed in enumerate(seeds) if row not in good}
        for row, (now, _) in begun.items():
            self._envs[row]._games.make_ready(now)
        games = (self._envs[row]._games.game for row in good)
        play_on((game for game in games if game is not None), self._threads)
        rows = [env._played_on(good[row]) if row in good else _begun(env, begun[row]) for row, env in enumerate(self._envs)]
        self._begun = True
        seen, rewards, terminated, truncated, infos = zip(*rows, strict=True)
        ends = np.array(terminated), np.array(truncated)
        self._going = ~(ends[0] | ends[1])
        return np.stack(seen), np.array(rewards), *ends, self._infos(infos)

    def _infos(self, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
        self._masks = np.stack([info.pop("action_mask") for info in rows])
        infos: dict[str, Any] = {"action_mask": self._masks.copy(), "_action_mask": np.ones(self.num_envs, dtype=bool)}
        for name, (kind, none) in _OF_CHOICE.items():
            infos[name] = np.array([info.pop(name, none) for info in rows], dtype=kind)
            infos[f"_{name}"] = self._going.copy()
        for row, info in enumerate(rows):
            if info:
                infos = self._add_info(infos, info, row)
        return infos

    def close_extras(self, **kwargs: Any) -> None:
        for env in self._envs:
            env.close()
        if self._own_pool is not None:
            self._own_pool.shutdown(wait=True)
