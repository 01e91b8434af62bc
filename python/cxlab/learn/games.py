"""What the environments share: games one after the other, the next one made ready while one is played, and observations."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from cxlab.errors import InputError, UsageError
from cxlab.learn.choices import Choice, ChoiceGame
from cxlab.learn.features import KINDS, OPTION, SITUATION

OPTIONS = 16
WIDTH = max(len(names) for names in OPTION.values())
HEAD = len(KINDS) + max(len(names) for names in SITUATION.values())
SIZE = HEAD + OPTIONS * WIDTH

SEEDS = 2**31 - 1


def shown_options(choice: Choice) -> NDArray[np.int64]:
    """Which options the actions 0, 1, ... stand for: all, or the first ones with the preferred one and the last one."""
    count = len(choice.options)
    if count <= OPTIONS:
        return np.arange(count)
    shown = [*range(OPTIONS - 1), count - 1]
    if choice.preferred not in shown:
        shown[-2] = choice.preferred
    return np.array(sorted(shown))


def mask_of(choice: Choice | None) -> NDArray[np.bool_]:
    """Shape (16,): which actions may be chosen. After the end only action 0, which changes nothing."""
    mask = np.zeros(OPTIONS, dtype=bool)
    if choice is None:
        mask[0] = True
    else:
        allowed = choice.allowed[shown_options(choice)]
        mask[: len(allowed)] = allowed
    return mask


def observation_of(choice: Choice | None) -> NDArray[np.float32]:
    """Shape (347,), each between -1 and 1: the kind of choice (3), the situation (8), then 16 options with 21 features each."""
    out = np.zeros(SIZE, dtype=np.float32)
    if choice is None:
        return out
    if choice.kind not in KINDS:
        raise ValueError(f"found a choice of kind {choice.kind!r}, expected one of {', '.join(KINDS)}")
    out[KINDS.index(choice.kind)] = 1.0
    out[len(KINDS) : len(KINDS) + len(choice.situation)] = choice.situation
    features = choice.features[shown_options(choice)]
    options = out[HEAD:].reshape(OPTIONS, WIDTH)
    options[: features.shape[0], : features.shape[1]] = features
    return out


def at_interval(seconds: float, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What to set so that the rule agent asks for an order at a fixed interval, also where none can begin; `given` is set as well."""
    if not seconds > 0:
        raise UsageError(f"found {seconds}, expected more than 0 s", "interval")
    given = dict(given or {})
    return given | {"agents[0].params": {"clips_manager.choices.interval": float(seconds)} | dict(given.get("agents[0].params", {}))}


class Settings(TypedDict, total=False):
    """What each environment of games takes, by keyword.

    Attributes:
        tier: "timed" (the default) or "physics".
        team: whose points count ("CYAN").
        ahead: a thread makes the next game ready while one is played (True).
        pool: the threads that make games ready; None: each environment has one of its own.
        until: end of an episode, s; None: the game's.
        interval: s between two choices of an order, also where none can begin; None: only where one can. Of the rule agent.
        set, out, journal: as for `cxlab.Episode`; `out` is replaced by each game.
    """

    tier: str
    team: str
    ahead: bool
    pool: ThreadPoolExecutor | None
    until: float | None
    interval: float | None
    set: Mapping[str, Any]
    out: str | os.PathLike[str] | None
    journal: str


class Games:
    """Games one after the other. While one is played, a thread makes the next one ready up to its first choice, if its seed is
    known; which game is played never depends on that. The thread is one of `pool`, or one of its own."""

    def __init__(
        self,
        scenario: str,
        *,
        tier: str = "timed",
        team: str = "CYAN",
        ahead: bool = True,
        interval: float | None = None,
        pool: ThreadPoolExecutor | None = None,
        **more: Any,
    ) -> None:
        self.team = team
        more["tier"] = tier
        if interval is not None:
            more["set"] = at_interval(interval, more.get("set"))
        if more.get("out") is not None:  # one folder, for one game at a time
            more["force"], ahead = True, False
        self._scenario, self._more = scenario, more
        self._own_pool = ThreadPoolExecutor(1, "cxlab-next-game") if ahead and pool is None else None
        self._pool = pool or self._own_pool
        self._ahead = ahead
        self._next: tuple[int, Future[tuple[ChoiceGame, Choice | None]]] | None = None
        self.game: ChoiceGame | None = None
        self.choice: Choice | None = None
        self._points = 0

    def _load(self, seed: int) -> tuple[ChoiceGame, Choice | None]:
        game = ChoiceGame(self._scenario, seed=seed, **self._more)
        return game, game.next()

    def make_ready(self, seed: int) -> None:
        """Let a thread make the game of a seed ready, for `begin`."""
        if self._pool is not None and (self._next is None or self._next[0] != seed):
            self._drop_next()
            self._next = (seed, self._pool.submit(self._load, seed))

    def begin(self, seed: int, following: int | None) -> None:
        """Begin the game of a seed; `following` is the seed of the next one."""
        self._end_game()
        if self._next is not None and self._next[0] == seed:
            ready, self._next = self._next[1], None
            self.game, self.choice = ready.result()
        else:
            self._drop_next()
            self.game, self.choice = self._load(seed)
        self._check()
        self._points = 0
        if self._ahead and following is not None:
            self.make_ready(following)

    def _check(self) -> None:
        """Rules that ask nothing leave nothing to learn, and a team that does not play never gets a point."""
        assert self.game is not None
        if self.choice is None:
            raise InputError("the game ended before its rules asked for a choice, expected rules that ask, as those of rcll/external", "scenario")
        teams = self.game.result_at("teams") or {}
        if self.team not in teams:
            raise UsageError(f"found '{self.team}', expected one of {', '.join(teams) or 'a world with teams'}", "team")

    def choose(self, action: int) -> bool:
        """Answer the choice. False: the mask forbids the action, and the rules' option was taken."""
        game, choice = self.game, self.choice
        if game is None or choice is None:
            raise RuntimeError("the game is over; call reset()")
        good = 0 <= action < OPTIONS and bool(mask_of(choice)[action])
        game.choose(int(shown_options(choice)[action]) if good else choice.preferred)
        return good

    def play_on(self) -> None:
        """Play on to the next choice."""
        assert self.game is not None
        self.choice = self.game.next()

    def answer(self, action: int) -> bool:
        """Answer the choice, and play on to the next one."""
        good = self.choose(action)
        self.play_on()
        return good

    def points(self) -> int:
        """Points since the last call, or since the game began."""
        total = int(self.game.result_at(f"teams.{self.team}.points") or 0) if self.game is not None else 0
        gained, self._points = total - self._points, total
        return gained

    def result(self) -> Mapping[str, Any]:
        """Ends the game; its result."""
        return self.game.close() if self.game is not None else {}

    def _end_game(self) -> None:
        if self.game is not None:
            self.game.close()
        self.game = self.choice = None

    def _drop_next(self) -> None:
        if self._next is not None:
            self._next[1].add_done_callback(_drop)
            self._next = None

    def close(self) -> None:
        self._end_game()
        self._drop_next()
        self._ahead = False
        if self._own_pool is not None:
            self._own_pool.shutdown(wait=True)
            self._pool = self._own_pool = None


def _drop(ready: Future[tuple[ChoiceGame, Choice | None]]) -> None:
    if not ready.cancelled() and ready.exception() is None:
        ready.result()[0].close()
