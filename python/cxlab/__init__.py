"""cxlab: rule-based robot agents (the CLIPS-Executive) in simulated worlds, played and asked from Python.

    >>> import cxlab
    >>> with cxlab.Episode("rcll/game", seed=7, tier="timed", out="runs/first") as episode:
    ...     episode.run()
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cxlab._cxlab import __version__
from cxlab.episode import Episode, Step
from cxlab.errors import BugError, CxlabError, InputError, MachineError, NegativeError, RunError, UsageError
from cxlab.program import program

if TYPE_CHECKING:
    from cxlab._rerun import rerun
    from cxlab.run import Run
    from cxlab.sweep import bench, read_sweep

# Names that are imported when they are first used, and where they are.
_LATER = {
    "Run": "cxlab.run",
    "bench": "cxlab.sweep",
    "read_sweep": "cxlab.sweep",
    "rerun": "cxlab._rerun",
}

__all__ = [
    "BugError",
    "CxlabError",
    "Episode",
    "InputError",
    "MachineError",
    "NegativeError",
    "Run",
    "RunError",
    "Step",
    "UsageError",
    "__version__",
    "bench",
    "program",
    "read_sweep",
    "rerun",
]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'cxlab' has no attribute '{name}'")
    value = getattr(import_module(_LATER[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATER})
