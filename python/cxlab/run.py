"""Recorded runs: what happened as data frames, and what the rules know at any time."""

from __future__ import annotations

import difflib
import json
import os
import re
import subprocess
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from cxlab import tables
from cxlab._asking import Asking, error_said, run_program
from cxlab._cxlab import RecordedRun
from cxlab._time import Time, seconds_of
from cxlab.errors import CxlabError, InputError, UsageError

_AFTER_EACH_END_S = 1e8


class Answer(Mapping[str, Any]):
    """The tables of a question that the world of a run answers, by name; the first one is `table`.

    Attributes:
        at_s, from_s: the stretch of the run that it is about, in s.
        cut_off: whether the journal ends before the time that was asked for.
        notes: sentences about the tables.
    """

    def __init__(self, name: str, given: Mapping[str, Any], frames: tables.Frames) -> None:
        self.name = name
        self.at_s: float = given["at_s"]
        self.from_s: float = given["from_s"]
        self.cut_off: bool = given["cut_off"]
        self.notes: list[str] = given["notes"]
        self._tables = {key: tables.frame(tables.read(source), frames) for key, source in given["tables"].items()}

    @property
    def table(self) -> Any:
        return next(iter(self._tables.values()))

    def __getitem__(self, key: str) -> Any:
        return self._tables[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._tables)

    def __len__(self) -> int:
        return len(self._tables)

    def __repr__(self) -> str:
        return "\n".join([f"{key}:\n{table}" for key, table in self._tables.items()] + self.notes)

    def _repr_html_(self) -> str:
        from cxlab import jupyter

        return jupyter.answer_html(self)


class Explanation:
    """Why something happened, or did not.

    `text` is for people, `table` has its parts as a data frame, and `json` is what the program says with `--json`.
    """

    def __init__(self, parts: list[dict[str, Any]], lines: list[str], make_table: Callable[[], Any]) -> None:
        self.json = parts
        self._lines = lines
        self._make_table = make_table

    @property
    def table(self) -> Any:
        return self._make_table()

    @property
    def text(self) -> str:
        return "\n".join(self._lines)

    def __str__(self) -> str:
        return self.text

    __repr__ = __str__

    def _repr_html_(self) -> str:
        from cxlab import jupyter

        return jupyter.text_html(self.text)


class View:
    """`cxlab view` at work: open `url` in a browser of this machine. It ends with `close`, or with this object."""

    def __init__(self, process: subprocess.Popen[str], url: str) -> None:
        self.url = url
        self.pid = process.pid
        self.close = weakref.finalize(self, _end_view, process)

    def __enter__(self) -> View:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"View({self.url!r})"

    def _repr_html_(self) -> str:
        from cxlab import jupyter

        return jupyter.link_html(self.url)


def _end_view(process: subprocess.Popen[str]) -> None:
    process.terminate()
    process.wait()
    if process.stdout:
        process.stdout.close()


class Run:
    """The folder of a run: one that is over, was stopped, failed or was killed, or that is played with --control.

        >>> run = cxlab.Run("runs/game-1")
        >>> run.orders                                    # what the world answers: orders, waits, machines, pieces
        >>> run.facts("5:12", "(order (state OPEN))")
        >>> print(run.why_not("order-begin", at=312.4))

    Data frames are those of pandas; `run.polars` and `run.arrow` are the same run with frames of these packages.
    A time is 312.4 (s), "5:12" or "5:12.4", and means the last tick at or before it, when its rules have fired; None is
    the end of the run. Columns that end in `_s` are seconds of the run.

    Records and tables of the world are read in this process, which runs no rules for them. Questions about facts and
    rules play the rules again, in a process of its own that can read the run and nothing else. It begins with the
    first such question, stays where the last one was, and ends with `close`, or with this object.
    """

    def __init__(
        self, folder: str | os.PathLike[str], *, frames: tables.Frames = "pandas", trust_programs: bool = False
    ) -> None:
        self._frames = tables.check_frames(frames)
        self.folder = Path(folder).absolute()
        self._trust_programs = trust_programs
        self._known: dict[str, tuple[str, str]] | None = None
        self._open()

    def _open(self) -> None:
        self._recorded = RecordedRun(str(self.folder))
        self._asking = Asking(self.folder, self._trust_programs)

    def __getstate__(self) -> dict[str, Any]:
        """A copy, also in another process, opens the folder again."""
        return {name: value for name, value in self.__dict__.items() if name not in ("_recorded", "_asking")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._open()

    # --- The same run, with other frames

    @property
    def pandas(self) -> Run:
        return self._with("pandas")

    @property
    def polars(self) -> Run:
        return self._with("polars")

    @property
    def arrow(self) -> Run:
        return self._with("arrow")

    def _with(self, frames: tables.Frames) -> Run:
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__, _frames=frames)
        return other

    def close(self) -> None:
        """Ends the process that plays the run again, if there is one; the next question begins another one."""
        self._asking.close()

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- What it was

    @property
    def result(self) -> dict[str, Any]:
        """result.json: how it ended, points, errors, hashes."""
        result: dict[str, Any] = self._recorded.result
        return result

    @property
    def manifest(self) -> dict[str, Any]:
        """manifest.json: what was played, so that it can be played again."""
        manifest: dict[str, Any] = json.loads((self.folder / "manifest.json").read_text())
        return manifest

    # --- What happened

    def records(
        self,
        kind: str | Sequence[str] | None = None,
        *,
        stream: str | None = None,
        start: Time | None = None,
        end: Time | None = None,
        fields: bool = False,
    ) -> Any:
        """The records of the journal: stream, n, t_ns, t_s, kind, data (JSON) and cause ("stream:n stream:n").

        Args:
            kind: input, assert, retract, modify, fire, bus, skill, referee, decision, control or error; or several of
                them. Without it all that the run exported: of journal="full" all, by default those of the world.
            stream: only this one, as "env/agent" or "referee".
            start, end: what is at either time belongs to it.
            fields: columns for the fields of `data` instead of JSON. A field that is called as a column of the record
                is `data_NAME`.
        """
        table = tables.read(self._records(kind, stream, start, end))
        if not fields:
            return tables.frame(table, self._frames)
        own = [name for name in table.column_names if name != "data"]
        data = tables.from_rows(
            {f"data_{key}" if key in own else key: value for key, value in json.loads(text.as_py()).items()}
            for text in table.column("data")
        )
        table = table.select(own)
        for name in data.column_names:
            table = table.append_column(name, data.column(name))
        return tables.frame(table, self._frames)

    def record_batches(
        self,
        kind: str | Sequence[str] | None = None,
        *,
        stream: str | None = None,
        start: Time | None = None,
        end: Time | None = None,
    ) -> Any:
        """The same as a `pyarrow.RecordBatchReader`, which reads some MB at a time: for journals larger than memory."""
        reader = tables.library("pyarrow").RecordBatchReader
        return reader.from_stream(self._records(kind, stream, start, end))

    def _records(
        self, kind: str | Sequence[str] | None, stream: str | None, start: Time | None, end: Time | None
    ) -> Any:
        kinds = [kind] if isinstance(kind, str) else list(kind or [])
        return self._recorded.records(kinds, stream or "", seconds_of(start, "start"), seconds_of(end, "end"))

    @property
    def skills(self) -> Any:
        """A row for each skill: robot, skill, target, begin_s, end_s, state, code, reason."""
        return self._story()[0]

    @property
    def points(self) -> Any:
        """A row for each time that points were given: t_s, team, kind, points, total, order."""
        return self._story()[1]

    def _story(self, start: Time | None = None, end: Time | None = None) -> tuple[Any, Any]:
        skills, points = self._recorded.story(seconds_of(start, "start"), seconds_of(end, "end"))
        return tables.frame(tables.read(skills), self._frames), tables.frame(tables.read(points), self._frames)

    def scene(self, at: Time | None = None, what: str = "") -> Any:
        """The entities at a time: id, kind, name, state, x, y, z (m), yaw (rad), carried_by, place; a row an entity.

        `what` is the name of an entity or a kind of entities; without it all.
        """
        seen = self._recorded.scene(seconds_of(at), what)["entities"]
        columns = ("id", "kind", "name", "state", "x", "y", "z", "yaw", "carried_by", "place")
        return self._frame([{name: entity[name] for name in columns} for entity in seen], columns)

    # --- What its world answers

    @property
    def questions(self) -> dict[str, str]:
        """The questions that the world of this run answers, and what each is about."""
        return {name: what for name, (what, _) in self._of_world().items()}

    def ask(
        self,
        question: str,
        about: str | int = "",
        *,
        at: Time | None = None,
        start: Time | None = None,
        end: Time | None = None,
    ) -> Answer:
        """Asks the world one of `questions`, as `cxlab QUESTION RUN` does: `run.ask("orders", 3)["steps"]`.

        Args:
            about: a part, such as the number of an order or the name of a robot; without it everything.
            at: as it was then. Or start and end: the stretch.
        """
        if at is not None and (start is not None or end is not None):
            raise UsageError("at: found start or end as well, expected one of both")
        given = self._recorded.ask(
            question, str(about), seconds_of(at), seconds_of(start, "start"), seconds_of(end, "end")
        )
        return Answer(question, given, self._frames)

    def _of_world(self) -> dict[str, tuple[str, str]]:
        if self._known is None:
            self._known = {name: (what, argument) for name, what, argument in self._recorded.questions()}
        return self._known

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        question = name.replace("_", "-")
        if question in self._of_world():
            return self.ask(question).table
        near = difflib.get_close_matches(name, dir(self), 1)
        raise AttributeError(
            f"a run has no '{name}'"
            + (f", did you mean '{near[0]}'?" if near else "")
            + (f" Its world answers {', '.join(self._of_world())}." if self._of_world() else "")
        )

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *(name.replace("-", "_") for name in self._of_world())})

    # --- What its rules know

    @property
    def environments(self) -> list[str]:
        """The names of the environments in which rules ran, at the end of the run."""
        return self._environments_at(None)

    def _environments_at(self, t: float | None) -> list[str]:
        return [one["environment"] for one in self._asked("envs", t)["environments"]]

    def facts(self, at: Time | None = None, what: str = "", *, env: str | None = None) -> Any:
        """The facts at a time: env, fact, template, asserted_s, asserted_by, changed_s, changed_by, and their slots.

        `what` is a template (`order`), a pattern (`(order (state OPEN))`) or a fact (`f-12`): then each slot is a
        column, in which strings have no quotes. Without `what` the column `text` has each fact as rules write it.
        """
        rows: list[dict[str, Any]] = []
        slots: dict[str, Any] = {}
        for name, answer in self._of_each("facts", at, env, what=what, brief=True):
            slots |= dict.fromkeys(answer["slots"])
            for fact in answer["facts"]:
                first, last = fact["changes"][0], fact["changes"][-1]
                changed = last is not first
                row = {
                    "env": name,
                    "fact": fact["fact"],
                    "template": fact["template"],
                    "asserted_s": first["t_s"],
                    "asserted_by": _by(first["by"]),
                    "changed_s": last["t_s"] if changed else None,
                    "changed_by": _by(last["by"]) if changed else None,
                }
                rows.append({**row, **_slots(fact["slots"], row)} if what else {**row, "text": last["text"]})
        columns = ("env", "fact", "template", "asserted_s", "asserted_by", "changed_s", "changed_by")
        of_facts = _slots(slots, dict.fromkeys(columns)) if what else ("text",)
        return self._frame(rows, (*columns, *of_facts))

    def changes(self, what: str, start: Time | None = None, end: Time | None = None, *, env: str | None = None) -> Any:
        """The changes in a stretch of the facts that match: t_s, env, fact, template, what, by, text."""
        begin, stop = seconds_of(start, "start") or 0.0, seconds_of(end, "end")
        stretch = {"from": begin} if stop is None else {"from": begin, "to": stop}
        rows = [
            {
                "t_s": change["t_s"],
                "env": name,
                "fact": fact["fact"],
                "template": fact["template"],
                "what": change["what"],
                "by": _by(change["by"]),
                "text": change.get("text"),
            }
            for name, answer in self._of_each("changes", end, env, what=what, **stretch)
            for fact in answer["facts"]
            for change in fact["changes"]
            if begin <= change["t_s"] and (stop is None or change["t_s"] <= stop)
        ]
        rows.sort(key=lambda row: row["t_s"])
        return self._frame(rows, ("t_s", "env", "fact", "template", "what", "by", "text"))

    def agenda(self, at: Time | None = None, *, env: str | None = None) -> Any:
        """The rules that wait to fire at a time, in the order in which they would."""
        return self._frame(
            [
                {"env": name, **activation}
                for name, answer in self._of_each("agenda", at, env)
                for activation in answer["agenda"]
            ],
            ("env", "rule"),
        )

    def globals(self, at: Time | None = None, *, env: str | None = None) -> dict[str, Any]:
        """The global variables at a time, by name; with several environments by environment first."""
        all_of = {name: answer["globals"] for name, answer in self._of_each("globals", at, env)}
        return next(iter(all_of.values())) if len(all_of) == 1 else all_of

    def firings(
        self,
        rule: str = "",
        *,
        start: Time | None = None,
        end: Time | None = None,
        env: str | None = None,
    ) -> Any:
        """The firings of rules: env, n, t_s, rule, place, values (JSON), facts.

        With `rule` each of its variables is a column.
        """
        begin, stop = seconds_of(start, "start"), seconds_of(end, "end")
        stretch = {key: value for key, value in (("from", begin), ("to", stop)) if value is not None}
        rows = []
        for name, answer in self._of_each("firings", end, env, rule=rule, **stretch):
            for firing in answer["firings"]:
                row = {"env": name, **{key: firing.get(key) for key in ("n", "t_s", "rule", "place")}}
                values = firing.get("values") or {}
                if rule:
                    rows.append({**row, **_slots(values, {**row, "facts": None}), "facts": firing.get("facts")})
                else:
                    rows.append({**row, "values": json.dumps(values), "facts": firing.get("facts")})
        return self._frame(rows, ("env", "n", "t_s", "rule", "place") + (() if rule else ("values", "facts")))

    def rules(self, at: Time | None = None, *, env: str | None = None) -> Any:
        """The rules that fired up to a time, waited in vain, or never matched, and what these lack."""
        rows = []
        for name, answer in self._of_each("rules", at, env):
            for rule in answer["rules"]:
                unmet = rule.pop("unmet", None)
                rows.append({"env": name, **rule, "lacks": _lacks(unmet) if unmet else None})
        return self._frame(rows, ("env", "rule", "place", "fired", "activated", "first_s", "last_s", "lacks"))

    def why(self, what: str, at: Time | None = None, *, env: str | None = None) -> Explanation:
        """How a fact came about, or why a rule fired: `run.why("order-begin", at="5:12")`.

        `table` has the steps, each with the numbers of the steps that led to it (`because`).
        """
        parts, lines, rows = [], [], []
        for name, answer in self._of_each("why", at, env, what=what):
            tree = answer.pop("tree")
            parts.append(answer)
            lines += _tree_lines(tree)
            rows += [
                {
                    "env": name,
                    "step": number,
                    **step,
                    "values": json.dumps(step["values"]) if "values" in step else None,
                }
                for number, step in enumerate(answer["steps"])
            ]
        columns = ("env", "step", "n", "t_s", "kind", "text", "place", "values", "because")
        return Explanation(parts, lines, partial(self._frame, rows, columns))

    def why_not(
        self, what: str, at: Time | None = None, *, where: Mapping[str, Any] | None = None, env: str | None = None
    ) -> Explanation:
        """What a rule lacks to fire; or which rules wait for a fact or pattern, and which ones could make it.

        `where` fixes variables of the rule: `run.why_not("order-begin", at=312, where={"id": 5})`.
        """
        extra = {"where": {key: str(value) for key, value in where.items()}} if where else {}
        parts = [answer for _, answer in self._of_each("why_not", at, env, what=what, **extra)]
        lines: list[str] = []
        rows: list[dict[str, Any]] = []
        for part in parts:
            explained = part.get("explanations")
            if explained is None:
                lines += _future_lines(part)
                rows += [{"env": part["environment"], **_flat(waiting)} for waiting in part.get("waiting", ())]
            for rule in explained or ():
                lines += _why_not_lines(rule)
                unmet = rule.get("first_unmet") or {}
                rows.append(
                    {
                        "env": rule["environment"],
                        "rule": rule["rule"],
                        "place": f"{rule['file']}:{rule['line']}",
                        "fired": rule["fired"],
                        "last_fired_s": rule.get("last_fired_s"),
                        "verdict": rule["verdict"],
                        "condition": unmet.get("condition"),
                        "pattern": unmet.get("pattern"),
                        "because": unmet.get("because"),
                    }
                )
        return Explanation(parts, lines, partial(self._frame, rows, ("env", "rule", "place")))

    def source(self, rule: str, *, env: str | None = None) -> str:
        """The text of a rule as it was played."""
        return str(self._of_each("source", None, env, rule=rule)[0][1]["text"])

    def _of_each(self, name: str, at: Time | None, env: str | None, **fields: Any) -> list[tuple[str, dict[str, Any]]]:
        """The answers of all environments that know the subject of the question, or of one."""
        t = seconds_of(at)
        found, refused = [], None
        for environment in [env] if env is not None else self._environments_at(t):
            try:
                found.append((environment, self._asked(name, t, env=environment, **fields)))
            except InputError as error:
                refused = refused or error
        if refused and not found:
            raise refused
        return found

    def _asked(self, name: str, t: float | None, **fields: Any) -> dict[str, Any]:
        question = {"ask": name, **fields}
        if self._recorded.finished:
            end = self._recorded.end_s
            if t is not None and t > end:
                raise UsageError(f"the run ends at {end:g} s", "at")
            t = end if t is None else t
        if t is None and not (self.folder / "control.sock").exists():  # else it is being played: now
            t = _AFTER_EACH_END_S
        if t is not None:
            question["t"] = t
        answer: dict[str, Any] = self._asking.ask(question)["answer"]
        return answer

    def _frame(self, rows: list[dict[str, Any]], columns: Sequence[str]) -> Any:
        return tables.frame(tables.from_rows(rows, columns), self._frames)

    # --- What else is made of it

    def view(self, *, open: bool = False) -> View:
        """Serves the page of the run, where a browser of this machine asks all of this: `run.view().url`."""
        from cxlab.program import program

        process = subprocess.Popen(
            [os.fspath(program()), "view", str(self.folder)]
            + ["--open"] * open
            + ["--trust-programs"] * self._trust_programs,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**os.environ, "NO_COLOR": "1"},
            text=True,
            start_new_session=True,  # Ctrl-C ends a question, not the server
        )
        assert process.stdout and process.stderr
        url = process.stdout.readline().strip()
        if not url:
            code, said = process.wait(), process.stderr.read()
            process.stdout.close()
            process.stderr.close()
            raise error_said(code, said)
        process.stderr.close()
        return View(process, url)

    def export(
        self,
        *formats: str,
        out: str | os.PathLike[str] | None = None,
        start: Time | None = None,
        end: Time | None = None,
        pictures: float | None = None,
        camera: str | None = None,
        size: str | None = None,
    ) -> list[Path]:
        """Writes the run in the formats of other tools and names the files: `run.export("mcap", "parquet")`.

        Formats are mcap, trace, csv and parquet (docs/reference/export.md). `pictures` is the time between two pictures in s.
        """
        arguments = ["export", str(self.folder), "--json", *(f"--{name}" for name in formats)]
        for option, value in (
            ("--out", out),
            ("--from", seconds_of(start, "start")),
            ("--to", seconds_of(end, "end")),
            ("--pictures", pictures),
            ("--camera", camera),
            ("--size", size),
        ):
            if value is not None:
                arguments += [option, str(value)]
        return [Path(file["path"]) for file in json.loads(run_program(arguments)[1])["files"]]

    def __repr__(self) -> str:
        result = self.result
        return f"Run({str(self.folder)!r}): {result['scenario']}, seed {result['seed']}, {result['status']}"

    def _repr_html_(self) -> str:
        from cxlab import jupyter

        return jupyter.run_html(self)


def _by(cause: Mapping[str, Any]) -> str:
    """Who changed a fact: "rule order-begin", "topic /game_state"."""
    return " ".join(str(cause[key]) for key in ("kind", "name") if cause.get(key))


def _plain(value: Any) -> Any:
    """A value of CLIPS: strings without their quotes."""
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, str) and len(value) > 1 and value[0] == value[-1] == '"':
        return re.sub(r"\\(.)", r"\1", value[1:-1], flags=re.DOTALL)
    return value


def _slots(values: Mapping[str, Any], taken: Mapping[str, Any]) -> dict[str, Any]:
    return {f"slot_{name}" if name in taken else name: _plain(value) for name, value in values.items()}


def _flat(row: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value if not isinstance(value, dict) else json.dumps(value) for key, value in row.items()}


def _lacks(unmet: Mapping[str, Any]) -> str:
    text = f"condition {unmet['condition']}: {unmet.get('pattern', unmet.get('text', ''))}"
    return text + (f": {unmet['because']}" if unmet.get("because") else "")


def _tree_lines(tree: Mapping[str, Any], first: str = "", rest: str = "") -> list[str]:
    lines = [first + tree["text"]]
    branches = tree["branches"]
    for number, branch in enumerate(branches):
        last = number == len(branches) - 1
        lines += _tree_lines(branch, rest + ("└─ " if last else "├─ "), rest + ("   " if last else "│  "))
    return lines


def _maker_lines(part: Mapping[str, Any]) -> list[str]:
    """The rules that could make what is missing, with what each lacks."""
    lines = []
    for maker in (part.get("makers") or {}).get("rules", ()):
        lines.append(f"  rule {maker['rule']} ({maker['place']}) {maker['how']} it")
        if maker.get("lacks"):
            lines.append(f"    lacks {maker['lacks']}")
    return lines


def _why_not_lines(rule: Mapping[str, Any]) -> list[str]:
    fired = rule["fired"]
    last = f", last at {rule['last_fired_s']} s" if rule.get("last_fired_s") is not None else ""
    times = "once" if fired == 1 else f"{fired} times"
    lines = [
        f"rule {rule['rule']} ({rule['file']}:{rule['line']}) has " + (f"fired {times}{last}" if fired else "not fired")
    ]
    unmet = rule.get("first_unmet")
    if not unmet:
        return [*lines, f"  {rule['verdict']}"]
    lines.append(f"  lacks condition {unmet['condition']}: {unmet.get('pattern', '')}")
    if unmet.get("because"):
        lines.append(f"    {unmet['because']}")
    return lines + _maker_lines(rule)


def _future_lines(part: Mapping[str, Any]) -> list[str]:
    lines = [f"{part['fact']}  {part['text']}"] if part.get("fact") else []
    for waiting in part.get("waiting", ()):
        lines.append(f"  rule {waiting['rule']} ({waiting['place']}) needs such a fact")
        if waiting.get("lacks"):
            lines.append(f"    lacks {waiting['lacks']}")
    return lines + _maker_lines(part)


__all__ = ["Answer", "CxlabError", "Explanation", "Run", "View", "seconds_of"]
