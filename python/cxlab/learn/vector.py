"""Many games at once: `cxlab/RCLLDispatch-v0` as a vector environment of Gymnasium, in worker processes that share their arrays."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from collections.abc import Iterator, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import ModuleType
from typing import Any, Unpack

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from cxlab.errors import UsageError
from cxlab.learn.games import OPTIONS, SIZE, Settings

# What workers and the learner share: names, types and shapes of a row for each environment.
_SHARED: dict[str, tuple[str, tuple[int, ...]]] = {
    "observation": ("<f4", (SIZE,)),
    "action_mask": ("?", (OPTIONS,)),
    "action": ("<i8", ()),
    "reward": ("<f8", ()),
    "terminated": ("?", ()),
    "truncated": ("?", ()),
    "invalid": ("?", ()),
    "preferred": ("<i8", ()),
    "now": ("<f8", ()),
    "kind": ("<U16", ()),
    "who": ("<U32", ()),
}
_OF_CHOICE = ("kind", "who", "preferred", "now")
_STEP, _CLOSE = b"s", b"c"

Arrays = dict[str, NDArray[Any]]
Memory = dict[str, Any]


def _views(memory: Memory, count: int) -> Arrays:
    """The shared memory as arrays, a row for each environment."""
    return {name: np.frombuffer(memory[name], dtype=kind).reshape(count, *shape) for name, (kind, shape) in _SHARED.items()}


@contextlib.contextmanager
def _without_main() -> Iterator[None]:
    """Workers need nothing of the program that starts them. So they do not run it again, and it needs no `if __name__ == "__main__"`."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _work(pipe: Connection, memory: Memory, count: int, rows: range, scenario: str, settings: dict[str, Any]) -> None:
    """A worker: plays the environments of these rows, one after the other in each step."""
    from cxlab.learn.dispatch import RCLLDispatchEnv

    shared = _views(memory, count)
    games = {row: RCLLDispatchEnv(scenario, **settings) for row in rows}
    ended = dict.fromkeys(rows, False)

    def show(row: int, seen: NDArray[np.float32], info: dict[str, Any]) -> dict[str, Any]:
        """Put it into the arrays; what is not there every time is returned."""
        shared["observation"][row] = seen
        shared["action_mask"][row] = info.pop("action_mask")
        shared["invalid"][row] = info.pop("invalid", False)
        for name in _OF_CHOICE:
            shared[name][row] = info.pop(name, "" if name in ("kind", "who") else 0)
        return info

    def begin(row: int, seed: int | None) -> dict[str, Any]:
        ended[row] = False
        shared["reward"][row] = 0.0
        shared["terminated"][row] = shared["truncated"][row] = False
        return show(row, *games[row].reset(seed=seed))

    def step(row: int) -> dict[str, Any]:
        if ended[row]:
            return begin(row, None)
        seen, reward, terminated, truncated, info = games[row].step(shared["action"][row])
        shared["reward"][row] = reward
        shared["terminated"][row], shared["truncated"][row] = terminated, truncated
        ended[row] = terminated or truncated
        return show(row, seen, info)

    try:
        while (asked := pipe.recv()) != _CLOSE:
            try:
                more = {row: step(row) if asked == _STEP else begin(row, asked[row]) for row in rows}
                pipe.send({row: info for row, info in more.items() if info})
            except Exception as error:
                pipe.send(error)
    except (EOFError, OSError, KeyboardInterrupt):  # the learner is gone, or has heard the same Ctrl-C
        pass
    for game in games.values():
        game.close()


class RCLLDispatchVectorEnv(gymnasium.vector.VectorEnv[NDArray[np.float32], NDArray[np.int64], NDArray[Any]]):
    """Games of `RCLLDispatchEnv` at once, several in each worker process: `gymnasium.make_vec("cxlab/RCLLDispatch-v0", num_envs=16)`.

    Row i plays what an environment of its own would play with seed + i and the same actions. Observation: float32, shape
    (num_envs, 347). Action: int64, shape (num_envs,). An environment whose game has ended begins the next one in the next step, and
    ignores its action there (`AutoresetMode.NEXT_STEP`). `infos` has an array for each key of the single environment's `info`, and
    `_KEY`: where it holds.

    Args:
        num_envs: games at once. In a step a worker plays a choice of each of its games, so more games wait less for each other.
        processes: workers; by default one for each processor, but no more than games.
        scenario, settings: as for `RCLLDispatchEnv`; `out` is for one game.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012  Gymnasium's name and type

    def __init__(
        self,
        num_envs: int = 1,
        *,
        processes: int | None = None,
        scenario: str = "rcll/external",
        render_mode: str | None = None,
        **settings: Unpack[Settings],
    ) -> None:
        if num_envs < 1:
            raise UsageError(f"found {num_envs}, expected 1 or more", "num_envs")
        if processes is not None and processes < 1:
            raise UsageError(f"found {processes}, expected 1 or more", "processes")
        if settings.get("out") is not None:
            raise UsageError("out is for one game: use RCLLDispatchEnv")
        if render_mode is not None:
            raise UsageError(f"found '{render_mode}', expected None: many games have no picture", "render_mode")
        self.num_envs = num_envs
        self.single_observation_space = gymnasium.spaces.Box(-1.0, 1.0, (SIZE,), np.float32)
        self.single_action_space = gymnasium.spaces.Discrete(OPTIONS)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        context = get_context("forkserver")
        memory = {
            name: context.RawArray(ctypes.c_byte, num_envs * int(np.prod(shape, dtype=int)) * np.dtype(kind).itemsize)
            for name, (kind, shape) in _SHARED.items()
        }
        self._shared = _views(memory, num_envs)
        self._begun = False
        count = min(num_envs, processes or len(os.sched_getaffinity(0)))
        self._rows = [range(first * num_envs // count, (first + 1) * num_envs // count) for first in range(count)]
        self._workers = []
        self._pipes: list[Connection] = []
        for rows in self._rows:
            pipe, end = context.Pipe()
            worker = context.Process(target=_work, args=(end, memory, num_envs, rows, scenario, dict(settings)), daemon=True)
            with _without_main():
                worker.start()
            end.close()
            self._workers.append(worker)
            self._pipes.append(pipe)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin a game in each row: that of `seed` + row, or of the row's own seed; without seeds, those that follow."""
        super().reset(seed=seed if isinstance(seed, int) else None)
        seeds = [seed + row for row in range(self.num_envs)] if isinstance(seed, int) else list(seed or [None] * self.num_envs)
        if len(seeds) != self.num_envs:
            raise UsageError(f"found {len(seeds)} seeds, expected one for each of the {self.num_envs} environments", "seed")
        more = self._ask([{row: seeds[row] for row in rows} for rows in self._rows])
        self._begun = True
        return self._shared["observation"].copy(), self._infos(more)

    def step(
        self, actions: NDArray[np.int64]
    ) -> tuple[NDArray[np.float32], NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        if not self._begun:
            raise UsageError("found no games; call reset() first")
        self._shared["action"][:] = actions
        more = self._ask([_STEP] * len(self._pipes))
        seen = (self._shared[name].copy() for name in ("observation", "reward", "terminated", "truncated"))
        return (*seen, self._infos(more))  # type: ignore[return-value]

    def action_masks(self) -> NDArray[np.bool_]:
        """Bool, shape (num_envs, 16): which actions may be chosen."""
        return self._shared["action_mask"].copy()

    def _ask(self, requests: Sequence[Any]) -> dict[int, dict[str, Any]]:
        """Let all workers work at once; what they report of some rows. Raises what a worker raised."""
        if self.closed:
            raise UsageError("the environment is closed")
        try:
            for pipe, request in zip(self._pipes, requests, strict=True):
                pipe.send(request)
            answers = [pipe.recv() for pipe in self._pipes]
        except (EOFError, OSError) as error:
            self.close()
            raise RuntimeError("a worker process has ended by itself") from error
        for answer in answers:
            if isinstance(answer, Exception):
                self.close()
                raise answer
        return {row: info for answer in answers for row, info in answer.items()}

    def _infos(self, more: dict[int, dict[str, Any]]) -> dict[str, Any]:
        over = self._shared["terminated"] | self._shared["truncated"]
        everywhere = np.ones(self.num_envs, dtype=bool)
        infos: dict[str, Any] = {"action_mask": self._shared["action_mask"].copy(), "_action_mask": everywhere}
        for name in _OF_CHOICE:
            infos[name], infos[f"_{name}"] = self._shared[name].copy(), ~over
        if self._shared["invalid"].any():
            infos["invalid"] = infos["_invalid"] = self._shared["invalid"].copy()
        for row, info in more.items():
            infos = self._add_info(infos, info, row)
        return infos

    def close_extras(self, **kwargs: Any) -> None:
        for pipe in self._pipes:
            with contextlib.suppress(OSError):
                pipe.send(_CLOSE)
            pipe.close()
        for worker in self._workers:
            worker.join(10)
            if worker.is_alive():
                worker.terminate()
                worker.join()
