"""The program `cxlab` at work for this process: commands that end, and `cxlab ask`, which stays.

A separate process plays the rules of a run, because it gives up its rights for good before the first rule of a stranger
runs (docs/reference/contracts.md, The second wall).
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import subprocess
import tempfile
import threading
import weakref
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import IO, Any

from cxlab.errors import CxlabError, error_of
from cxlab.program import program

_PLACE = re.compile(r"(?P<file>[^\s:]+):(?:(?P<line>\d+):)? (?P<message>.*)", re.DOTALL)
_LONGEST_END_S = 5.0


def error_said(code: int, said: str) -> CxlabError:
    """The exception for a command that ended with an exit code, with the reason from its standard error."""
    lines = [line for line in said.strip().splitlines() if not line.endswith("--help says more")]
    errors = [number for number, line in enumerate(lines) if line.startswith("error: ")]
    text = "\n".join(lines[errors[0] :]).removeprefix("error: ") if errors else "\n".join(lines[-10:])
    if code < 0:
        text = f"the program was ended by signal {-code}" + (f": {text}" if text else "")
        code = 70
    place = _PLACE.fullmatch(text)
    if place and ("/" in place["file"] or place["line"]):
        return error_of(code, place["message"], place["file"], int(place["line"] or 0))
    return error_of(code, text or f"the program ended with exit code {code}")


@contextlib.contextmanager
def named(file: Path, name: str) -> Iterator[None]:
    """Errors in a file that was written for the call name the argument that it was written from."""
    try:
        yield
    except CxlabError as error:
        if error.file == str(file):
            error.file = name
        raise


def run_program(arguments: Sequence[str], answers: Collection[int] = (0,)) -> tuple[int, str]:
    """Runs a command to its end: its exit code and what it wrote. A code that is no answer is an exception."""
    done = subprocess.run(
        [os.fspath(program()), *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        env={**os.environ, "NO_COLOR": "1"},
        check=False,
        encoding="utf-8",
        errors="replace",
    )
    if done.returncode not in answers:
        raise error_said(done.returncode, done.stderr)
    return done.returncode, done.stdout


def _end(process: subprocess.Popen[bytes], said: IO[bytes]) -> None:
    """Ends it by the end of its input, after a while at once. A copy of the owner only lets go of it: it cannot wait."""
    for file in (process.stdin, process.stdout, said):
        if file:
            with contextlib.suppress(BrokenPipeError):  # a question is still in the pipe to a process that died
                file.close()
    try:
        process.wait(_LONGEST_END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class Asking:
    """Asks `cxlab ask RUN`: it begins with the first question and ends with `close`, this object, or this process."""

    def __init__(self, folder: Path, trust_programs: bool) -> None:
        self._arguments = [str(folder)] + (["--trust-programs"] if trust_programs else [])
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0
        self._said: IO[bytes] | None = None
        self._finalizer: weakref.finalize[Any, Any] | None = None

    def ask(self, question: dict[str, Any]) -> dict[str, Any]:
        """The answer, with `place`: where the run is then."""
        with self._lock:
            process = self._started()
            assert process.stdin and process.stdout
            try:
                process.stdin.write(json.dumps(question).encode() + b"\n")
                process.stdin.flush()
                line = process.stdout.readline()
            except BrokenPipeError:
                line = b""
            except BaseException:  # Ctrl-C: the answer would be taken for that of the next question
                process.kill()
                self._close()
                raise
            if not line:
                code = process.wait()
                said = self._words()
                self._close()
                raise error_said(code or 70, said)
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise error_said(4 if answer.get("status") == 500 else 3, "error: " + str(answer["error"]))
        return answer

    def close(self) -> None:
        """Ends the process; the next question begins another one."""
        with self._lock:
            self._close()

    @property
    def pid(self) -> int | None:
        """The process that answers, if there is one."""
        return self._process.pid if self._process else None

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process and self._owner != os.getpid():  # this is a copy of who started it
            self._close()
        if not self._process:
            self._owner = os.getpid()
            self._said = tempfile.TemporaryFile()  # noqa: SIM115 - `_end` closes it
            self._process = subprocess.Popen(
                [os.fspath(program()), "ask", *self._arguments],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._said,
                env={**os.environ, "NO_COLOR": "1"},
                start_new_session=True,  # Ctrl-C ends the question, not the process
            )
            self._finalizer = weakref.finalize(self, _end, self._process, self._said)
        return self._process

    def _words(self) -> str:
        assert self._said
        self._said.seek(0)
        return self._said.read()[-10_000:].decode(errors="replace")

    def _close(self) -> None:
        if self._finalizer:
            self._finalizer()
        self._process, self._finalizer, self._said = None, None, None
