"""Games that stop where the rules leave a choice to Python."""

from __future__ import annotations

import contextlib
import os
import pickle
import warnings
from collections.abc import Callable, Iterable, Mapping
from types import TracebackType
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from cxlab import _cxlab
from cxlab._time import Time, seconds_of
from cxlab._yaml import assignments_of
from cxlab.errors import CxlabError, UsageError

T = TypeVar("T")


class Choice(NamedTuple):
    """A choice that is open.

    Attributes:
        kind: what is chosen: "take-job", "begin-order", "begin-step", or a kind of your own rules.
        who: for whom: a robot; empty: the team.
        options: the options, for people.
        allowed: bool, shape (options,): which may be chosen now.
        preferred: the option that the rules would choose.
        situation: float64, shape (features of the situation,), each between -1 and 1.
        features: float64, shape (options, features of an option), each between -1 and 1.
        now: simulated time, s.
    """

    kind: str
    who: str
    options: list[str]
    allowed: NDArray[np.bool_]
    preferred: int
    situation: NDArray[np.float64]
    features: NDArray[np.float64]
    now: float


class ChoiceGame:
    """One episode of a scenario whose rules ask (package cxlab_choices). The same seed and the same choices are the same run.

    Args:
        scenario: a file, or the name of a scenario that comes with cxlab.
        seed, tier, set, out, force, until, journal: as for `cxlab.Episode`; `journal="none"` is fastest.
        topic: the topic on which the rules ask.
    """

    def __init__(
        self,
        scenario: str | os.PathLike[str] = "rcll/external",
        *,
        seed: int | None = None,
        tier: str | None = None,
        set: Mapping[str, Any] | None = None,
        out: str | os.PathLike[str] | None = None,
        force: bool = False,
        until: Time | None = None,
        journal: str = "none",
        topic: str = "/choices",
    ) -> None:
        self._core = _cxlab.ChoiceEpisode(
            scenario=os.fspath(scenario),
            assignments=assignments_of(set, seed=seed, tier=tier),
            until=seconds_of(until, "until"),
            journal=journal,
            out="" if out is None else os.fspath(out),
            force=force,
            topic=topic,
        )
        self._result: dict[str, Any] | None = None
        self._writes = out is not None

    def next(self) -> Choice | None:
        """Play on until the rules ask. The choice that was asked for first, or None: the episode is over."""
        core = self._core
        if not core.next():
            return None
        allowed = np.array(core.allowed, dtype=bool)
        return Choice(
            core.kind, core.who, core.options, allowed, core.preferred, core.situation,
            core.features.reshape(len(allowed), -1), core.now,
        )  # fmt: skip

    def choose(self, option: int) -> None:
        """Answer the choice that `next` returned."""
        self._core.choose(int(option))

    def what_if(self, go_on: Callable[[], T]) -> T:
        """What `go_on` returns when it plays this game on, from the open choice, in a copy of the process (`os.fork`). This game stays
        where it is. What `go_on` returns or raises must be of a kind that pickle takes. The copy has none of the other threads, so
        `go_on` must not wait for one; the warning of Python 3.12 and newer about that is silenced.
        """
        if self._writes:
            raise UsageError("what_if: this game writes to a folder, where a second one would write as well; play it without `out`")
        reading, writing = os.pipe()
        with warnings.catch_warnings():  # NumPy's own threads are enough to be warned
            warnings.filterwarnings("ignore", "This process .* is multi-threaded", DeprecationWarning)
            child = os.fork()
        if child == 0:
            try:
                os.close(reading)
                try:
                    answer = pickle.dumps((True, go_on()))
                except BaseException as error:
                    answer = pickle.dumps((False, error))
                with os.fdopen(writing, "wb") as pipe:
                    pipe.write(answer)
            finally:
                os._exit(0)
        os.close(writing)
        with os.fdopen(reading, "rb") as pipe:
            answer = pipe.read()
        os.waitpid(child, 0)
        if not answer:
            raise RuntimeError("what_if: the copy of the process ended without an answer")
        good, value = pickle.loads(answer)
        if not good:
            raise value
        result: T = value
        return result

    @property
    def now(self) -> float:
        """Simulated time of the last tick, s."""
        now: float = self._core.now
        return now

    def result_at(self, path: str) -> Any:
        """What result.json has so far at a path: "teams.CYAN.points"; None if there is nothing."""
        import json

        text = self._core.result_at(path)
        return json.loads(text) if text else None

    def render(self, width: int = 640, height: int = 400, *, camera: str | None = None, caption: bool = False) -> NDArray[np.uint8]:
        """A picture of the world now: uint8, shape (height, width, 3), as `cxlab.Episode.render`."""
        picture: NDArray[np.uint8] = self._core.render(width, height, camera or "", caption)
        return picture

    def close(self) -> dict[str, Any]:
        """End the episode here; its result, as result.json has it."""
        if self._result is None:
            self._result = self._core.close()
        return self._result

    def __enter__(self) -> ChoiceGame:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        with contextlib.suppress(CxlabError) if error else contextlib.nullcontext():
            self.close()


def play_on(games: Iterable[ChoiceGame], threads: int) -> None:
    """Play each of the games on to its next choice, in so many threads at once. Their `next` returns it without playing then."""
    _cxlab.ChoiceEpisode.play_on([game._core for game in games], threads)
