"""What if: a run played again, exactly as it was up to a time, and otherwise from there (docs/reference/what-if.md)."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from cxlab import tables
from cxlab._asking import error_said, named, run_program
from cxlab._time import Time, seconds_of
from cxlab.errors import UsageError
from cxlab.run import Run


class Rerun(Run):
    """The new run, and what became of it beside the old one.

    Attributes:
        answer: what `cxlab rerun --json` says.
        same: whether it is the old run, byte for byte; with `at` up to that time.
    """

    def __init__(self, folder: str | os.PathLike[str], answer: dict[str, Any], **options: Any) -> None:
        super().__init__(folder, **options)
        self.answer = answer
        self.same: bool = answer["same_before"] if "same_before" in answer else answer["same"]

    @property
    def what_was_done(self) -> Any:
        """The changes that were made at the time: t_s, env, what."""
        return self._frame(
            [{"t_s": one["t"], "env": one["env"], "what": one["what"]} for one in self.answer.get("changes", ())],
            ("t_s", "env", "what"),
        )

    @property
    def metrics(self) -> Any:
        """How the run ended then and now: metric, then, now; those that differ, with the status and the points."""
        then, now = self.answer.get("then", {}), self.answer.get("now", {})
        return self._frame(
            [{"metric": name, "then": then[name], "now": now.get(name)} for name in then], ("metric", "then", "now")
        )

    @property
    def first_differences(self) -> Any:
        """The first record of each stream that differs: stream, t_s, then, now."""
        rows = [
            {
                "stream": one["stream"],
                "t_s": one["t"],
                "then": tables.as_text(one["then"]),
                "now": tables.as_text(one["now"]),
            }
            if isinstance(one, dict)
            else {"then": one}
            for one in self.answer["first_differences"]
        ]
        return self._frame(rows, ("stream", "t_s", "then", "now"))


def rerun(
    run: Run | str | os.PathLike[str],
    *,
    at: Time | None = None,
    then: str | os.PathLike[str] | None = None,
    set: Mapping[str, Any] | None = None,
    assert_: str | Iterable[str] = (),
    env: str | Iterable[str] = (),
    until: Time | None = None,
    out: str | os.PathLike[str] | None = None,
    force: bool = False,
    trust_programs: bool = False,
) -> Rerun:
    """Plays a run again into a new folder; with `at` it goes on otherwise from that time.

        >>> other = cxlab.rerun(run, at="5:12.4", then="repair.clp")
        >>> other.metrics

    Args:
        at: exactly as then up to this time. Without it the whole run is played again, and `same` says whether it is.
        then: a file of rules, or rules themselves, as "(defrule ...)"; a construct replaces that of the same name.
        set: parameters of an agent's node, {"NODE.NAME": value}, or globals, {"?*NAME*": value}.
        assert_: a fact or several, as "(order (id 3))".
        env: the environment or environments that rules, globals and facts are for.
        until: another end than that of the run.
        out: the folder of the new run; without it runs/<scenario>-<seed>.
        force: `out` may be a folder in use.
    """
    folder = run.folder if isinstance(run, Run) else Path(run)
    trust_programs = trust_programs or (isinstance(run, Run) and run._trust_programs)
    frames: tables.Frames = run._frames if isinstance(run, Run) else "pandas"
    arguments = ["rerun", str(folder), "--json", "--quiet"]
    arguments += ["--force"] * force + ["--trust-programs"] * trust_programs
    for option, value in (("--at", seconds_of(at)), ("--until", seconds_of(until, "until")), ("--out", out)):
        if value is not None:
            arguments += [option, os.fspath(value) if not isinstance(value, float) else repr(value)]
    for name, value in (set or {}).items():
        arguments += ["--set", f"{name}={value}"]
    for option, texts in (("--assert", assert_), ("--env", env)):
        for text in [texts] if isinstance(texts, str) else texts:
            arguments += [option, text]
    with tempfile.TemporaryDirectory() as scratch:
        written = Path(scratch) / "then.clp"
        if then is not None:
            file = Path(os.fspath(then))
            if os.fspath(then).lstrip().startswith(("(", ";")):
                file = written
                file.write_text(os.fspath(then))
            elif not file.is_file():
                raise UsageError(f"then: '{file}' is no file, and no rules, which begin with '('")
            arguments += ["--then", str(file)]
        with named(written, "then"):
            code, said = run_program(arguments, answers=(0, 1))
    if not said.strip():
        raise error_said(code, "")
    answer = json.loads(said)
    return Rerun(answer["again"], answer, frames=frames, trust_programs=trust_programs)
