"""Episodes: a scenario that is played step by step."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple

from cxlab import _cxlab
from cxlab._time import Time, seconds_of
from cxlab._yaml import assignments_of, yaml_text
from cxlab.seat import Call, Goal, Message, Seat

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from cxlab.tables import Frames


class Step(NamedTuple):
    """The outcome of a step.

    Attributes:
        now: simulated time of the last tick, s; before the first tick less than 0.
        ticks: how many ticks the step played.
        over: whether another step plays none.
    """

    now: float
    ticks: int
    over: bool


class Endpoint(NamedTuple):
    """A topic, service or action of the bus.

    Attributes:
        type: of its messages, "geometry_msgs/msg/Twist".
        providers: how many publish or serve it.
        users: how many subscribe to it or call it.
    """

    type: str
    providers: int
    users: int


class Episode:
    """One episode: a world, its agents, one clock and one seed. Many live in one process.

    What a program does in an episode (`assert_`, `retract`, `eval`, `build`, `publish`, `call`, `send_goal`, seats) is an
    input from outside. It is in the log of the run, which therefore replays and answers questions as any other run;
    `result["deterministic"]` is false then.

    Args:
        scenario: a file (YAML), or the name of a scenario that comes with cxlab, such as "rcll/game".
        seed: of all chance, instead of the scenario's.
        tier: "physics" or "timed", instead of the scenario's.
        set: values of the scenario to change, by path: {"world.team": "MAGENTA"}.
        agents: for each agent of the scenario its configuration (YAML of the CLIPS-Executive), or None to leave it.
        seats: programs that play as well, after all agents.
        out: folder of the run; None writes nothing.
        force: `out` may be a folder in use.
        until: end of the run: 312.4 (s), "5:12" or "5:12.4"; None: the duration of the scenario.
        journal: what journal.jsonl holds: "none", "decisions" or "full".
        packages: prefixes below which packages of rules and interfaces lie (PREFIX/share/NAME).

    Raises:
        InputError: a file or value cannot be used; it names file and line.
        RunError: a rule failed while the agents started.
    """

    def __init__(
        self,
        scenario: str | os.PathLike[str],
        *,
        seed: int | None = None,
        tier: str | None = None,
        set: Mapping[str, Any] | None = None,
        agents: Sequence[str | os.PathLike[str] | None] = (),
        seats: Sequence[Seat] = (),
        out: str | os.PathLike[str] | None = None,
        force: bool = False,
        until: Time | None = None,
        journal: str = "decisions",
        packages: Sequence[str | os.PathLike[str]] = (),
    ) -> None:
        assignments = assignments_of(set, seed=seed, tier=tier)
        for number, agent in enumerate([agents] if isinstance(agents, (str, os.PathLike)) else agents):
            if agent is not None:
                path = os.path.abspath(agent)
                assignments.append((f"agents[{number}].config={yaml_text(path)}", f"agents {agent}"))
        self._result: dict[str, Any] | None = None
        self._core: Any = _cxlab.Episode(
            scenario=os.fspath(scenario),
            assignments=assignments,
            until=seconds_of(until, "until"),
            journal=journal,
            out="" if out is None else os.fspath(out),
            force=force,
            seats=[seats] if isinstance(seats, Seat) else list(seats),
            packages=[os.fspath(package) for package in packages],
        )

    # --- Playing

    def step(self, until: Time | None = None, *, ticks: int | None = None) -> Step:
        """Play the ticks up to a time (s, or "5:12.4"), one at it included, or a number of ticks; without either one tick.

        Other threads run meanwhile. Ctrl-C raises KeyboardInterrupt after a tick: the episode can be stepped on or closed.

        Raises:
            RunError: a rule failed, went round in a loop, or a plugin failed; the run is over.
            Exception: what a seat raised; the run is over.
        """
        if until is None and ticks is None:
            ticks = 1
        if isinstance(until, str):
            until = seconds_of(until, "until")
        return tuple.__new__(Step, self._core.step(until, ticks))  # a call of Step itself takes ten times as long

    def run(self) -> dict[str, Any]:
        """Play to the end, close, and return the result.

        Raises:
            CxlabError: what ended the run early, or (NegativeError) an expectation of the scenario that does not hold.
        """
        try:
            self._core.step(None, None)
        except BaseException:
            self.close()
            raise
        result = self.close()
        if self._core.failure is not None:
            raise self._core.failure
        return result

    def close(self) -> dict[str, Any]:
        """Deactivate the agents, complete the files of the run, and return the result, as result.json has it.

        A run that has not come to its end ends here. A second call returns the same.
        """
        if self._result is None:
            self._result = self._core.close()
        return self._result

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

    @property
    def result(self) -> dict[str, Any]:
        """What result.json has; of an open episode so far, with the status "running"."""
        return self._core.result if self._result is None else self._result

    def __enter__(self) -> Episode:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __del__(self) -> None:
        core = getattr(self, "_core", None)
        if core is None or core.closed:
            return
        try:
            warnings.warn(f"{self!r} was not closed", ResourceWarning, source=self, stacklevel=2)
        finally:
            core.close()

    def __repr__(self) -> str:
        state = "closed" if self.closed else "over" if self.over else "open"
        return f"<cxlab.Episode at {max(self.now, 0.0):.3f} s, {state}>"

    def __reduce__(self) -> str:
        raise TypeError("an episode lives in one process, once: to go on otherwise from a time of its run, use cxlab.rerun")

    # --- Rules

    @property
    def environments(self) -> list[str]:
        """Names of the environments of rules."""
        return self._core.environments

    def facts(self, pattern: str | None = None, *, env: str | None = None, frames: Frames = "pandas") -> Any:
        """The facts now, as a table: `fact` (index), `template`, and a column for each slot (`slot_fact` for one called `fact`),
        also where no fact matches the pattern.

        Args:
            pattern: a template ("order") or a pattern: "(order (state OPEN) (id ?))". None: all facts.
            env: the environment, where there are several.
            frames: "pandas", "polars" or "arrow".
        """
        from cxlab import tables

        tables.check_frames(frames)
        own = ("fact", "template")

        def column(slot: str) -> str:
            return f"slot_{slot}" if slot in own else slot

        found, slots_of_template = self._core.facts(pattern or "", env)
        rows = [
            {"fact": index, "template": template} | {column(name): value for name, value in slots.items()}
            for index, template, slots in found
        ]
        columns = (*own, *(column(slot) for slot in slots_of_template))
        return tables.frame(tables.from_rows(rows, columns), frames)

    def fact_list(self, pattern: str | None = None, *, env: str | None = None) -> list[dict[str, Any]]:
        """The same as a list of dicts of slots, without a table: for programs that look often.

        Values are int, float, str (symbols, strings) or lists; an ordered fact has the one slot "implied".
        """
        return [slots for _, _, slots in self._core.facts(pattern or "", env)[0]]

    def assert_(self, fact: str, *, env: str | None = None) -> int:
        """Assert a fact, "(order (id 3))", and return its index. Rules see it when they run next.

        Raises:
            InputError: it is no fact, or its template or a slot does not exist.
        """
        return self._core.assert_fact(fact, env)

    def retract(self, index: int, *, env: str | None = None) -> None:
        """Retract the fact of that index."""
        self._core.retract(index, env)

    def eval(self, expression: str, *, env: str | None = None) -> str:
        """Evaluate an expression of CLIPS, "(+ 1 ?*speed*)", and return its value as CLIPS prints it."""
        return self._core.eval(expression, env)

    def build(self, construct: str, *, env: str | None = None) -> None:
        """Add a construct: a rule, a function, a template."""
        self._core.build(construct, env)

    # --- The bus. Messages go out in the next tick, from the node /python.

    @property
    def topics(self) -> dict[str, Endpoint]:
        """All topics, by name."""
        return self._endpoints("topics")

    @property
    def services(self) -> dict[str, Endpoint]:
        """All services, by name."""
        return self._endpoints("services")

    @property
    def actions(self) -> dict[str, Endpoint]:
        """All actions, by name."""
        return self._endpoints("actions")

    def publish(self, topic: str, type: str | None, message: Message) -> None:
        """Publish a message: a dict of fields, of which missing ones have their defaults.

        Args:
            type: "geometry_msgs/msg/Twist"; None: that of the topic on the bus. The same holds for the methods below.
        """
        self._core.publish(topic, type or self._type_of("topics", topic), yaml_text(message))

    def read(self, topic: str, type: str | None = None) -> list[tuple[float, dict[str, Any]]]:
        """The messages of a topic that came since the last call, with their times (s). The first call begins to listen."""
        return self._core.read(topic, type or self._type_of("topics", topic))

    def call(self, service: str, type: str | None, request: Message) -> Call:
        """Call a service. The answer comes while the episode is stepped on."""
        return Call(self._core, self._core.call(service, type or self._type_of("services", service), yaml_text(request)))

    def send_goal(self, action: str, type: str | None, goal: Message) -> Goal:
        """Send a goal to an action. Its answer, feedback and result come while the episode is stepped on."""
        return Goal(self._core, self._core.send_goal(action, type or self._type_of("actions", action), yaml_text(goal)))

    def _endpoints(self, kind: str) -> dict[str, Endpoint]:
        return {name: Endpoint(*row) for name, row in self._core.endpoints(kind).items()}

    def _type_of(self, kind: str, name: str) -> str:
        known = self._core.endpoints(kind)
        found = known.get(name) or known.get("/" + name)
        if found is None:
            import difflib

            from cxlab.errors import UsageError

            near = difflib.get_close_matches(name, known, 1)
            raise UsageError(
                f"the bus has no {kind[:-1]} '{name}'" + (f", did you mean '{near[0]}'?" if near else "; give its type")
            )
        return str(found[0])

    # --- What there is to see

    def scene(self) -> dict[str, npt.NDArray[Any]]:
        """The entities that a picture shows now, as NumPy arrays of one length n, a row for each entity in order of `id`.
        The arrays are id (int64), kind, name, state (str), x, y, z (float64, m, in the world) and yaw (float64, rad, -pi to pi).
        Carried entities have carried_by (int64, id of the carrier, 0: none) and place (str, where on its carrier).
        """
        return self._core.scene()

    def render(
        self, width: int = 640, height: int = 400, *, camera: str | None = None, caption: bool = False
    ) -> npt.NDArray[np.uint8]:
        """A picture of the world now: uint8 of shape (height, width, 3), RGB, top row first.

        A canvas of turtles may choose a smaller size.

        Raises:
            MachineError: there is no OpenGL; it names the package to install.
        """
        return self._core.render(width, height, camera or "", caption)
