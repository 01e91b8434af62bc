"""Plans for PDDL problems: find one, follow a search while it improves, judge a plan.

    >>> plan = cxlab.plan("domain.pddl", "problem.pddl", anytime=True, timeout=1)
    >>> for step in plan: print(step)
    0.000: (go r1 base hall) [5.000]

The program `cxlab` does the work in a process of its own, so a search has limits, and ends with the call that began it.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import queue
import re
import resource
import signal
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Union

from .errors import BugError, CxlabError, InputError, MachineError, UsageError, error_of

__all__ = ["PddlError", "Plan", "PlanStep", "Verdict", "plan", "plans", "validate"]

Pddl = Union[str, "os.PathLike[str]"]
"""A file, or the text of one: a `str` that names no file and has a parenthesis is text."""

_NO_PLAN, _BAD_INPUT, _UNSUPPORTED = (10, 12, 22, 23), 31, 34
_GRACE_S = 5.0  # after its timeout the program has this long to answer, then it is killed


class PddlError(InputError):
    """A PDDL file, a plan or its data cannot be used (`code` 31), or has something that is not supported (34)."""

    code = _BAD_INPUT


@dataclasses.dataclass(frozen=True)
class PlanStep:
    """One action of a plan. Times in seconds."""

    action: str
    arguments: tuple[str, ...]
    start: float
    duration: float
    """0 for an action that takes no time."""
    latest_start: float
    """Latest start that keeps the makespan."""
    latest_end: float
    """Latest end that keeps the makespan."""

    @property
    def end(self) -> float:
        return self.start + self.duration

    def __str__(self) -> str:
        return f"{self.start:.6f}: ({' '.join((self.action, *self.arguments))}) [{self.duration:.6f}]"


@dataclasses.dataclass(frozen=True)
class Plan(Sequence[PlanStep]):
    """The answer of the planner: a sequence of steps, in the order of their starts. It is false if there is no plan."""

    status: str
    """`plan`; `found` (better ones may follow); `unsolvable`, which is proved; `ended` without plan or proof; `memory`;
    `budget`: work units or time ended."""
    reason: str
    """One sentence."""
    steps: tuple[PlanStep, ...]
    units: int
    """Work spent: one unit is about a microsecond. The same budget gives the same plan."""
    makespan: float | None = None
    """End of the last step, s; None without a plan."""
    lower_bound: float | None = None
    """No plan is shorter, s; None: not known."""
    metric: float | None = None
    """Value of the problem's metric."""
    metric_bound: float | None = None
    """No plan has a better metric; None: not known."""
    out_of_reach: str | None = None
    """Why no plan exists, where facts one by one or in pairs prove it."""
    orderings: tuple[Mapping[str, Any], ...] = ()
    """Distances that a schedule of the same steps must keep: `from` and `to` (`origin`, or `step` and `at`), `least_s`,
    `most_s`."""
    text: str = ""
    """The steps as a plan file."""

    def __len__(self) -> int:
        return len(self.steps)

    def __getitem__(self, index: Any) -> Any:
        return self.steps[index]

    def __iter__(self) -> Iterator[PlanStep]:
        return iter(self.steps)

    def __bool__(self) -> bool:
        return self.status in ("plan", "found")

    @property
    def optimal(self) -> bool:
        """Whether no plan is better: the metric reaches its bound, or without one the makespan does."""
        if not self:
            return False
        if self.metric_bound is not None:
            return self.metric == self.metric_bound
        return self.metric is None and self.lower_bound is not None and self.lower_bound >= (self.makespan or 0)

    def frame(self) -> Any:
        """The steps as a pandas DataFrame: action, arguments, start, end, duration, latest_start, latest_end (s)."""
        from cxlab import tables

        pandas = tables.library("pandas")
        columns = ["action", "arguments", "start", "end", "duration", "latest_start", "latest_end"]
        return pandas.DataFrame([[getattr(step, column) for column in columns] for step in self.steps], columns=columns)

    def __str__(self) -> str:
        return self.text if self else f"{self.status}: {self.out_of_reach or self.reason}"

    def _repr_html_(self) -> str:
        from cxlab import jupyter

        return jupyter.text_html(str(self))


@dataclasses.dataclass(frozen=True)
class Verdict:
    """The verdict of the validator. It is true if the plan is valid."""

    valid: bool
    steps: int
    makespan: float
    """s"""
    metric: float | None
    message: str
    """What is wrong first; empty for a valid plan."""
    advice: str
    """What would mend it, where that is known."""
    violation: Mapping[str, Any] | None
    """The same as fields: `kind`, `time` (s), `step` and `line` of the plan, `condition`."""
    robust: Mapping[str, Any] | None
    """With `robust=True`: `holds_s`, by how much steps may begin early or late, `breaks_s`, and `plans`, how many were
    tried."""

    def __bool__(self) -> bool:
        return self.valid


def plan(
    domain: Pddl,
    problem: Pddl,
    *,
    data: Mapping[str, Any] | None = None,
    timeout: float | None = None,
    budget: int | None = None,
    anytime: bool = False,
    patience: int | None = None,
    memory: int | None = None,
    svg: str | os.PathLike[str] | None = None,
    on_message: Callable[[str], None] | None = None,
) -> Plan:
    """Find a plan.

    Args:
        domain: file, or text of PDDL.
        problem: file, or text of PDDL.
        data: values for a domain and problem that are templates.
        timeout: wall time, s. Reading the files counts.
        budget: work units; the same budget gives the same plan. None: 60 million, about a minute.
        anytime: go on to better plans until time or budget end; `plans` shows them as they come.
        patience: with `anytime`, end when no better plan is found for so many units.
        memory: address space of the planner, bytes; None: no limit.
        svg: file for a drawing of the plan: bars, slack and what waits for what.
        on_message: called with each line of progress.

    Returns:
        The best plan, or why there is none: look at its truth value, `status` and `reason`.

    Raises:
        PddlError: a file or text cannot be used, or has something that is not supported.
        UsageError: an argument cannot be.
    """
    options = _planning_options(timeout, budget, anytime, patience)
    if svg is not None:
        options.append(f"--svg={os.path.abspath(svg)}")
    with _Files(data, domain=domain, problem=problem) as files:
        *_, last = _answers(files, options, timeout, memory, on_message)
    return last


def plans(
    domain: Pddl,
    problem: Pddl,
    *,
    data: Mapping[str, Any] | None = None,
    timeout: float | None = None,
    budget: int | None = None,
    patience: int | None = None,
    memory: int | None = None,
    on_message: Callable[[str], None] | None = None,
) -> Iterator[Plan]:
    """Yield each better plan when it is found (status `found`), then the answer. The arguments are those of `plan`.

    Closing the iterator ends the search.
    """
    options = _planning_options(timeout, budget, True, patience)

    def search() -> Iterator[Plan]:
        with _Files(data, domain=domain, problem=problem) as files:
            yield from _answers(files, options, timeout, memory, on_message)

    return search()


def validate(
    domain: Pddl,
    problem: Pddl,
    plan: Plan | Pddl,
    *,
    data: Mapping[str, Any] | None = None,
    epsilon: float = 0.001,
    tolerance: float = 0.001,
    robust: bool = False,
    robust_limit: float | None = None,
    budget: int | None = None,
) -> Verdict:
    """Judge a plan.

    Args:
        domain: file, or text of PDDL.
        problem: file, or text of PDDL.
        plan: a `Plan`, or a file or text with one step a line: `TIME: (ACTION OBJECT...) [DURATION]`.
        data: values for a domain and problem that are templates.
        epsilon: s that keeps interfering happenings apart.
        tolerance: s by which a duration may miss its bounds.
        robust: also search by how much steps may begin early or late.
        robust_limit: largest shift to try, s; None: the makespan.
        budget: work units that may be spent on quantifiers.

    Raises:
        PddlError: a file or text cannot be used, or has something that is not supported.
        UsageError: an argument cannot be, or there is no plan to judge.
    """
    if isinstance(plan, Plan):
        if not plan:
            raise UsageError(f"found no plan to judge: {plan.status}")
        plan = _Text(plan.text)
    options = [
        "--json",
        f"--epsilon={_seconds('epsilon', epsilon, 0)}",
        f"--tolerance={_seconds('tolerance', tolerance, 0)}",
    ]
    if budget is not None:
        options.append(f"--budget={_whole('budget', budget)}")
    if robust:
        options.append("--robust")
    if robust_limit is not None:
        options.append(f"--robust-limit={_seconds('robust_limit', robust_limit)}")
    with _Files(data, domain=domain, problem=problem, plan=plan) as files:
        process = _Process(["validate", *files.arguments, *options], None, None)
        with process:
            out = "".join(process.lines())
        if process.code not in (0, 1):
            raise files.error(process)
    answer = json.loads(out)
    violation = answer["violation"]
    return Verdict(
        valid=answer["valid"],
        steps=answer["steps"],
        makespan=answer["makespan"],
        metric=answer["metric"],
        message=violation["message"] if violation else "",
        advice=violation["advice"] if violation else "",
        violation=violation,
        robust=answer.get("robust"),
    )


def _planning_options(timeout: float | None, budget: int | None, anytime: bool, patience: int | None) -> list[str]:
    options = ["--stream"]
    if timeout is not None:
        options.append(f"--timeout={_seconds('timeout', timeout)}")
    if budget is not None:
        options.append(f"--budget={_whole('budget', budget)}")
    if anytime:
        options.append("--anytime")
    if patience is not None:
        if not anytime:
            raise UsageError("found patience without anytime=True; only a search that goes on needs patience")
        options.append(f"--patience={_whole('patience', patience)}")
    return options


def _seconds(name: str, value: float, least: float | None = None) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not (value > 0 or value == least):
        raise UsageError(
            f"{name}: found {value!r}, expected a number of seconds {'from 0' if least == 0 else 'above 0'}"
        )
    return repr(float(value))


def _whole(name: str, value: int) -> str:
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value < 2**63:
        raise UsageError(f"{name}: found {value!r}, expected a whole number from 1")
    return str(value)


class _Text(str):
    """Text for certain."""


class _Files:
    """Files of what a caller gave; texts go into a folder that lives as long as this."""

    def __init__(self, data: Mapping[str, Any] | None, **sources: Pddl) -> None:
        self._sources = sources
        self._data = data
        self._texts: dict[str, str] = {}  # file -> the argument whose text it has

    def __enter__(self) -> _Files:
        self._folder = tempfile.TemporaryDirectory(prefix="cxlab-plan-")
        try:
            self.arguments = [self._file(name, source) for name, source in self._sources.items()]
            if self._data is not None:
                file = Path(self._folder.name, "data.json")
                file.write_text(json.dumps(dict(self._data)), encoding="utf-8")
                self._texts[str(file)] = "data"
                self.arguments.append(f"--data={file}")
        except BaseException:
            self._folder.cleanup()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()

    def _file(self, name: str, source: Pddl) -> str:
        if not isinstance(source, (str, os.PathLike)):
            raise UsageError(f"{name}: found {type(source).__name__}, expected a path or a text")
        if isinstance(source, _Text) or (isinstance(source, str) and "(" in source and not os.path.exists(source)):
            file = Path(self._folder.name, name if name == "plan" else f"{name}.pddl")
            file.write_text(source, encoding="utf-8")
            self._texts[str(file)] = name
            return str(file)
        return os.path.abspath(source)  # no name begins with a dash

    def error(self, process: _Process) -> CxlabError:
        """Make an exception of what the program printed; files of texts are named by their arguments."""
        text = process.errors.strip()
        for file, name in self._texts.items():
            text = text.replace(file, name)
        if process.code < 0:
            return MachineError(
                f"the planner was ended by {signal.Signals(-process.code).name}: {text or 'it printed nothing'}"
            )
        if process.code not in (2, 5, _BAD_INPUT, _UNSUPPORTED):
            return BugError(f"cxlab {process.arguments[0]} ended with {process.code}: {text}")
        first = next((line for line in text.splitlines() if line.startswith("error: ")), text).removeprefix("error: ")
        place = re.match(r"([^\s:]+)(?::(\d+))?: (.*)", first, re.DOTALL)
        file, line, message = (place[1], int(place[2] or 0), place[3]) if place else ("", 0, first)
        if process.code in (_BAD_INPUT, _UNSUPPORTED):
            error: CxlabError = PddlError(message, file or None, line or None)
            error.code = process.code
            return error
        return error_of(process.code, first)


class _Process:
    """The program at work. Leaving the context ends it: after an exception, at Ctrl-C, with a closed iterator."""

    def __init__(self, arguments: list[str], limit_s: float | None, memory: int | None) -> None:
        from .program import program

        self.arguments = arguments
        self.errors = ""
        self.code = 0
        self._limit_s = limit_s
        self._memory = memory
        self._program = os.fspath(program())
        self.on_message: Callable[[str], None] | None = None

    def __enter__(self) -> _Process:
        def limit_memory() -> None:
            assert self._memory is not None
            resource.setrlimit(resource.RLIMIT_AS, (self._memory, self._memory))

        try:
            self._process = subprocess.Popen(
                [self._program, *self.arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                encoding="utf-8",
                errors="replace",
                preexec_fn=limit_memory if self._memory is not None else None,
            )
        except OSError as error:
            raise MachineError(f"cannot start {self._program}: {error.strerror}") from error
        return self

    def lines(self) -> Iterator[str]:
        """Yield lines of standard output as they come, and pass messages on. The program is killed after its limit."""
        arrived: queue.Queue[tuple[str, str | None]] = queue.Queue()

        def read(name: str, stream: IO[str]) -> None:
            with contextlib.suppress(ValueError):  # closed while it was read
                for line in stream:
                    arrived.put((name, line))
            arrived.put((name, None))

        assert self._process.stdout and self._process.stderr
        streams = {"out": self._process.stdout, "errors": self._process.stderr}
        for name, stream in streams.items():
            threading.Thread(target=read, args=(name, stream), daemon=True).start()
        killer = threading.Timer(self._limit_s, self._process.kill) if self._limit_s is not None else None
        if killer:
            killer.daemon = True
            killer.start()
        try:
            ended = 0
            while ended < len(streams):
                name, line = arrived.get()
                if line is None:
                    ended += 1
                elif name == "out":
                    yield line
                else:
                    self.errors += line
                    if self.on_message:
                        self.on_message(line.rstrip("\n"))
            self.code = self._process.wait()
        finally:
            if killer:
                killer.cancel()

    def __exit__(self, *_: object) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        for stream in (self._process.stdout, self._process.stderr):
            if stream:
                stream.close()


def _answers(
    files: _Files,
    options: list[str],
    timeout: float | None,
    memory: int | None,
    on_message: Callable[[str], None] | None,
) -> Iterator[Plan]:
    """Each better plan, then the answer."""
    limit = None if timeout is None else timeout + _GRACE_S
    process = _Process(
        ["plan", *files.arguments, *options], limit, None if memory is None else int(_whole("memory", memory))
    )
    process.on_message = on_message
    best: Plan | None = None
    answered = False
    with process:
        for line in process.lines():
            found = _plan_of(json.loads(line))
            if found.status == "found":
                best = found
            else:
                answered = True
            yield found
    if answered and process.code in (0, *_NO_PLAN):
        return
    if process.code == 22 or (memory is not None and "memory" in process.errors):
        yield _ended("memory", process.errors.strip().removeprefix("error: "), best)
    elif process.code == -signal.SIGKILL and timeout is not None:
        yield _ended("budget", f"the planner did not answer within {timeout + _GRACE_S:g} s and was killed", best)
    else:
        raise files.error(process)


def _ended(status: str, reason: str, best: Plan | None) -> Plan:
    return dataclasses.replace(best, status="plan", reason=reason) if best else Plan(status, reason, (), 0)


def _plan_of(answer: Mapping[str, Any]) -> Plan:
    steps = tuple(
        PlanStep(
            step["action"],
            tuple(step["arguments"]),
            step["start"],
            step["duration"],
            step["latest_start"],
            step["latest_end"],
        )
        for step in answer.get("steps", [])
    )
    return Plan(
        status=answer["status"],
        reason=answer.get("reason", ""),
        steps=steps,
        units=answer["units"],
        makespan=answer.get("makespan_s"),
        lower_bound=answer.get("lower_bound_s") or None,
        metric=answer.get("metric"),
        metric_bound=answer.get("metric_bound"),
        out_of_reach=answer.get("out_of_reach", {}).get("text"),
        orderings=tuple(answer.get("orderings", [])),
        text="".join(f"{step}\n" for step in steps),
    )
