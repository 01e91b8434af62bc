"""Sweeps: strategies compared in the same games, with the statistics of the laboratory (docs/reference/sweeps.md)."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cxlab import tables
from cxlab._asking import error_said, named, run_program
from cxlab._yaml import yaml_text
from cxlab.errors import InputError, UsageError

TABLES = ("scores", "differences", "profile", "overview", "parts", "shares")


class Comparison:
    """Two sweeps, judged in the same games.

    Attributes:
        answer: "better" (every strategy is), "worse" (at least one is) or "undecided".
        differences: a row a strategy: difference, difference_95_low and _high, effect, improvement (the probability
            that a random game is better), won, drawn, lost, p, p_holm, answer, more_games.
        notes: what the comparison leaves out, and why.
    """

    def __init__(self, answer: str, differences: Any, notes: list[str]) -> None:
        self.answer = answer
        self.differences = differences
        self.notes = notes

    def __repr__(self) -> str:
        return "\n".join([f"{self.answer}:", str(self.differences), *self.notes])

    def _repr_html_(self) -> str:
        from cxlab import jupyter

        return jupyter.comparison_html(self)


class Plot:
    """A drawing as SVG: notebooks show it, `svg` is its text."""

    def __init__(self, svg: str) -> None:
        self.svg = svg

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, file: str | os.PathLike[str]) -> None:
        Path(file).write_text(self.svg, encoding="utf-8")


class Sweep:
    """The folder of a sweep, or a file like its rows.csv.

    >>> sweep = cxlab.read_sweep("runs/strategies")
    >>> sweep.scores                                 # mean, median, middle half, with 95 % intervals
    >>> sweep.differences                            # from the first strategy, in the same games
    >>> sweep.compare("runs/before").answer          # 'better'
    """

    def __init__(self, folder: str | os.PathLike[str], *, frames: tables.Frames = "pandas", code: int = 0) -> None:
        self.folder = Path(folder)
        self.code = code
        self._frames = tables.check_frames(frames)
        self._rows_file()

    @property
    def polars(self) -> Sweep:
        return Sweep(self.folder, frames="polars", code=self.code)

    @property
    def arrow(self) -> Sweep:
        return Sweep(self.folder, frames="arrow", code=self.code)

    @property
    def rows(self) -> Any:
        """A row for each game: scenario, strategy, game, seed, status, a column for each metric, journal_hash."""
        arrow, csv = tables.library("pyarrow"), tables.library("pyarrow.csv")
        names = ("scenario", "strategy", "game", "status", "journal_hash")
        table = csv.read_csv(
            self._rows_file(),
            convert_options=csv.ConvertOptions(
                column_types={name: arrow.string() for name in names}, null_values=[""], strings_can_be_null=False
            ),
        )
        return tables.frame(table, self._frames)

    def table(self, name: str = "scores", *, metric: str | None = None, against: str | None = None) -> Any:
        """One of the tables of `cxlab bench show`: scores, differences, profile, overview or shares.

        Args:
            metric: the figure; without it the one that the world compares.
            against: the strategy from which differences are taken; without it the first of each scenario.
        """
        if name not in TABLES:
            raise UsageError(f"table: found '{name}', expected one of {', '.join(TABLES)}")
        arguments = ["bench", "show", str(self.folder), "--json", "--table", name, *_options(metric, against)]
        return self._frame(json.loads(run_program(arguments)[1])[name])

    @property
    def scores(self) -> Any:
        """Mean, median and middle half of each strategy, with their 95 % intervals."""
        return self.table("scores")

    @property
    def differences(self) -> Any:
        """Each strategy against the first one, in the same games."""
        return self.table("differences")

    def compare(self, before: Sweep | str | os.PathLike[str], *, metric: str | None = None) -> Comparison:
        """Judges this sweep against an earlier one."""
        other = before.folder if isinstance(before, Sweep) else Path(before)
        arguments = ["bench", "compare", str(other), str(self.folder), "--json", *_options(metric, None)]
        code, said = run_program(arguments, answers=(0, 1, 6))
        if not said.strip():
            raise error_said(code, "")
        answer = json.loads(said)
        return Comparison(answer["answer"], self._frame(answer["differences"]), answer["notes"])

    @property
    def requirements(self) -> Any:
        """The requirements of the suite and their answers; no rows where it has none."""
        file = self.folder / "requirements.json"
        if not file.exists():
            return self._frame([])
        return self._frame(json.loads(file.read_text())["requirements"])

    def plot(self, kind: str = "scores", *, metric: str | None = None, against: str | None = None) -> Plot:
        """Draws scores, differences, profile or parts (docs/reference/sweeps.md)."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "plot.svg"
            run_program(["bench", "plot", str(self.folder), str(file), "--kind", kind, *_options(metric, against)])
            return Plot(file.read_text(encoding="utf-8"))

    def _rows_file(self) -> Path:
        file = self.folder / "rows.csv" if self.folder.is_dir() else self.folder
        if not file.is_file():
            raise InputError("there is no sweep: expected rows.csv, which cxlab bench writes", str(file))
        return file

    def _frame(self, rows: list[dict[str, Any]]) -> Any:
        return tables.frame(tables.from_rows([_with_bounds(row) for row in rows]), self._frames)

    def __repr__(self) -> str:
        return f"Sweep({str(self.folder)!r})"

    def _repr_html_(self) -> str:
        from cxlab import jupyter

        return jupyter.sweep_html(self)


def _options(metric: str | None, against: str | None) -> list[str]:
    return [
        word
        for option, value in (("--metric", metric), ("--against", against))
        if value is not None
        for word in (option, value)
    ]


def _with_bounds(row: Mapping[str, Any]) -> dict[str, Any]:
    """An interval as two columns, KEY_low and KEY_high."""
    out: dict[str, Any] = {}
    for key, value in row.items():
        if key.endswith("_95"):
            out[f"{key}_low"], out[f"{key}_high"] = value if value is not None else (None, None)
        else:
            out[key] = value
    return out


def read_sweep(folder: str | os.PathLike[str], *, frames: tables.Frames = "pandas") -> Sweep:
    """Opens the folder of a sweep, or a file like its rows.csv."""
    return Sweep(folder, frames=frames)


def bench(
    suite: str | os.PathLike[str] | Mapping[str, Any],
    *,
    out: str | os.PathLike[str] | None = None,
    jobs: int = 1,
    time_limit: float | None = None,
    all: bool = False,
    frames: tables.Frames = "pandas",
) -> Sweep:
    """Plays the games of a suite, each in a process of its own, and opens the sweep.

        >>> suite = {"scenarios": ["game.yaml"], "seeds": "1..30",
        ...          "strategies": {"three": [], "two": ["world.robots=2"]}}
        >>> cxlab.bench(suite, out="runs/robots", jobs=2)

    Games that are there already and would come out the same are kept.

    Args:
        suite: a file (docs/reference/sweeps.md), or what it holds, with files relative to the current folder and names of
            shipped scenarios.
        out: the folder; without it runs/bench-<suite>. A suite that is no file needs one.
        jobs: games that are played at once.
        time_limit: ends a game after so many seconds of wall time.
        all: plays all games, also when the requirements of the suite are answered.

    Returns:
        The sweep. Its `code` is 0, 1 (a game was not completed, or a requirement does not hold) or 6 (a requirement is
        undecided).
    """
    if isinstance(suite, Mapping):
        if out is None:
            raise UsageError("out: a suite that is no file needs a folder: bench({...}, out='runs/mine')")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "suite.yaml"
            file.write_text(yaml_text(_with_absolute_files(suite)))
            with named(file, "suite"):
                return bench(file, out=out, jobs=jobs, time_limit=time_limit, all=all, frames=frames)
    target = Path(out) if out is not None else Path("runs") / f"bench-{Path(suite).stem}"
    arguments = ["bench", os.fspath(suite), "--out", str(target), "-j", str(jobs), "--json", "--quiet"]
    if time_limit is not None:
        arguments += ["--time-limit", str(time_limit)]
    code, said = run_program(arguments + ["--all"] * all, answers=(0, 1, 6))
    if not said.strip():
        raise error_said(code, "")
    return Sweep(target, frames=frames, code=code)


def _absolute(scenario: str | os.PathLike[str]) -> str:
    """The path of a file; the name of a scenario that comes with cxlab stays."""
    name = os.fspath(scenario)
    return os.path.abspath(name) if Path(name).suffix or Path(name).exists() else name


def _with_absolute_files(suite: Mapping[str, Any]) -> dict[str, Any]:
    out = dict(suite)
    if "scenarios" in out:
        out["scenarios"] = [_absolute(name) for name in out["scenarios"]]
    if "games" in out:
        out["games"] = os.path.abspath(out["games"])
    if "earlier" in out:
        out["earlier"] = {name: os.path.abspath(place) for name, place in out["earlier"].items()}
    return out
