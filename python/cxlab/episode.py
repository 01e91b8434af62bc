"""Episodes: a scenario that is played step by step."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, NamedTuple

from cxlab import _cxlab


class Step(NamedTuple):
    """What a step was.

    Attributes:
        now: simulated time of the last tick, s; before the first tick less than 0.
        ticks: how many ticks it played.
        over: whether another step plays none.
    """

    now: float
    ticks: int
    over: bool


def _yaml_text(value: Any) -> str:
    """A value as --set takes it."""
    if isinstance(value, str):
        return value
    import json

    return json.dumps(value)


class Episode:
    """One episode: a world, its agents, one clock and one seed. Many live in one process.

    Args:
        scenario: a file (YAML), or the name of a scenario that comes with cxlab: "rcll/game".
        seed: of all chance, instead of the scenario's.
        tier: "physics" or "timed", instead of the scenario's.
        set: values of the scenario to change, by path: {"world.team": "MAGENTA"}.
        agents: configurations (YAML of the CLIPS-Executive), instead of the scenario's agents.
        out: folder of the run; None writes nothing.
        force: `out` may be a folder in use.
        until: end, s of simulated time; None: the duration of the scenario.
        journal: what journal.jsonl holds: "none", "decisions" or "full".

    Raises:
        InputError: a file or value cannot be used; it names file and line.
    """

    def __init__(
        self,
        scenario: str | os.PathLike[str],
        *,
        seed: int | None = None,
        tier: str | None = None,
        set: Mapping[str, Any] | None = None,
        agents: Sequence[str | os.PathLike[str]] | None = None,
        out: str | os.PathLike[str] | None = None,
        force: bool = False,
        until: float | None = None,
        journal: str = "decisions",
    ) -> None:
        assignments = [(f"{path}={_yaml_text(value)}", f"set[{path!r}]") for path, value in (set or {}).items()]
        if seed is not None:
            assignments.append((f"seed={seed}", "seed"))
        if tier is not None:
            assignments.append((f"tier={tier}", "tier"))
        if agents is not None:
            configs = [{"config": os.path.abspath(agent)} for agent in agents]
            assignments.append((f"agents={_yaml_text(configs)}", "agents"))
        self._result: dict[str, Any] | None = None
        self._core = _cxlab.Episode(
            scenario=os.fspath(scenario),
            assignments=assignments,
            until=until,
            journal=journal,
            out="" if out is None else os.fspath(out),
            force=force,
        )

    @property
    def now(self) -> float:
        """Simulated time of the last tick, s; before the first tick less than 0."""
        return self._core.now

    @property
    def over(self) -> bool:
        """Whether another step plays no tick."""
        return self._core.over

    @property
    def closed(self) -> bool:
        """Whether the episode is closed."""
        return self._core.closed

    def step(self, until: float | None = None, *, ticks: int | None = None) -> Step:
        """Play the ticks up to a time (s), or a number of ticks; one tick where neither is given.

        Other threads run meanwhile. Ctrl-C raises KeyboardInterrupt after a tick; the episode can be stepped on or closed.
        """
        if until is None and ticks is None:
            ticks = 1
        return Step(*self._core.step(until, ticks))

    def run(self) -> dict[str, Any]:
        """Play to the end and close; the result."""
        self._core.step(None, None)
        return self.close()

    def close(self) -> dict[str, Any]:
        """Deactivate the agents and complete the files of the run; the result, as result.json has it.

        An episode that has not come to its end is one that ends here.
        """
        if self._result is None:
            self._result = self._core.close()
        return self._result

    def __enter__(self) -> Episode:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
