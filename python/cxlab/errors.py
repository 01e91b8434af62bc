"""Exceptions: one class for each exit code of the program (docs/reference/contracts.md)."""

from __future__ import annotations

import re


class CxlabError(Exception):
    """What went wrong, with the place and the remedy where there is one.

    Attributes:
        message: what was found, what was expected, what to do.
        file: the file or option that has the mistake; None where there is none.
        line: its line, from 1; None where there is none.
        code: the exit code that the program ends with.
        word: a short word for programs, such as "rule_loop"; "" where there is none.
    """

    code = 70

    def __init__(self, message: str, file: str | None = None, line: int | None = None, word: str = "") -> None:
        super().__init__(message, file, line, word)
        self.message = message
        self.file = file
        self.line = line
        self.word = word

    def __str__(self) -> str:
        if not self.file:
            return self.message
        line = f":{self.line}" if self.line else ""
        return f"{self.file}{line}: {self.message}"


class NegativeError(CxlabError):
    """The answer is no: an expectation of the scenario does not hold, a difference was found."""

    code = 1


class UsageError(CxlabError, ValueError):
    """An argument cannot be used: it is unknown, missing, or in conflict with another one."""

    code = 2


class InputError(CxlabError, ValueError):
    """A file or value that cannot be used."""

    code = 3


class RunError(CxlabError):
    """The run failed: an error in a rule, a loop of rules, a world that diverged, a plugin."""

    code = 4


class MachineError(CxlabError):
    """Disk, memory or a library of the machine is missing."""

    code = 5


class BugError(CxlabError):
    """cxlab has a bug."""

    code = 70


class ClosedError(UsageError):
    """The episode is closed."""


_BY_CODE: dict[int, type[CxlabError]] = {
    kind.code: kind for kind in (NegativeError, UsageError, InputError, RunError, MachineError, BugError)
}


_OPTION = re.compile(r"(?<![\w/-])--([a-z]+(?:-[a-z]+)*)")
_COMMAND = re.compile(r"\bcxlab [a-z]")


def error_of(code: int, message: str, file: str = "", line: int = 0, word: str = "") -> CxlabError:
    """The exception of an exit code. Options of the program, `--trust-programs`, are arguments here: `trust_programs`.
    The argument that has the mistake (`tier`, `set world.team`) is named once."""
    if not _COMMAND.search(message):
        message = _OPTION.sub(lambda option: option[1].replace("-", "_"), message)
    message = message.removeprefix(f"{file.rpartition(' ')[2]}: " if file else "")
    kind = _BY_CODE.get(code, CxlabError)
    error = kind(message, file or None, line or None, word)
    error.code = code
    return error
