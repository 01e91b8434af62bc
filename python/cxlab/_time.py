"""Times of a run, as people write them."""

from __future__ import annotations

import re
from numbers import Real

from cxlab.errors import UsageError

Time = float | int | str

_TIME = re.compile(r"(?:(\d+):(?=[0-5]?\d(?:\.|$)))?(\d+(?:\.\d*)?)")
_LONGEST_S = 1e9


def seconds_of(time: Time | None, name: str = "at") -> float | None:
    """A time of a run in s: 312.4, "312.4", "5:12" or "5:12.4". None stays None."""
    if time is None:
        return None
    seconds: float | None = None
    if isinstance(time, str):
        written = _TIME.fullmatch(time)
        seconds = 60 * int(written[1] or 0) + float(written[2]) if written else None
    elif isinstance(time, Real) and not isinstance(time, bool):  # numbers of NumPy as well
        seconds = float(time)
    if seconds is None or not 0 <= seconds < _LONGEST_S:
        raise UsageError(f'{name}: found {time!r}, expected a time of the run: 312.4 (s), "5:12" or "5:12.4"')
    return seconds
