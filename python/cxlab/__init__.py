"""cxlab: rule-based robot agents (the CLIPS-Executive) in simulated worlds, played and asked from Python.

    >>> import cxlab
    >>> cxlab.Episode("rcll/game", seed=7, tier="timed", out="runs/first").run()["teams"]["CYAN"]["points"]
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from cxlab import _libraries_of_python as _libraries_of_python
from cxlab._cxlab import __version__
from cxlab.episode import Endpoint, Episode, Step
from cxlab.errors import BugError, CxlabError, InputError, MachineError, NegativeError, RunError, UsageError
from cxlab.program import program
from cxlab.seat import Bus, Call, Goal, Seat

if TYPE_CHECKING:
    from cxlab._rerun import rerun
    from cxlab.planning import PddlError, Plan, plan, plans, validate
    from cxlab.run import Run
    from cxlab.sweep import bench, read_sweep

# Parts that are imported when they are first asked for: they may need packages that are not always there.
_LATER = {
    "PddlError": "cxlab.planning",
    "Plan": "cxlab.planning",
    "Run": "cxlab.run",
    "bench": "cxlab.sweep",
    "plan": "cxlab.planning",
    "plans": "cxlab.planning",
    "read_sweep": "cxlab.sweep",
    "rerun": "cxlab._rerun",
    "validate": "cxlab.planning",
}

__all__ = [
    "BugError",
    "Bus",
    "Call",
    "CxlabError",
    "Endpoint",
    "Episode",
    "Goal",
    "InputError",
    "MachineError",
    "NegativeError",
    "PddlError",
    "Plan",
    "Run",
    "RunError",
    "Seat",
    "Step",
    "UsageError",
    "__version__",
    "bench",
    "plan",
    "plans",
    "program",
    "read_sweep",
    "rerun",
    "validate",
]


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'cxlab' has no attribute '{name}'")
    return getattr(import_module(_LATER[name]), name)


def __dir__() -> list[str]:
    return __all__
