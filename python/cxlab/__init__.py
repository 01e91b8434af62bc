"""cxlab: rule-based robot agents (the CLIPS-Executive) in simulated worlds, played and asked from Python.

    >>> import cxlab
    >>> with cxlab.Episode("rcll/game", seed=7, tier="timed", out="runs/first") as episode:
    ...     episode.run()
"""

from __future__ import annotations

from cxlab._cxlab import __version__
from cxlab.episode import Episode, Step
from cxlab.errors import BugError, CxlabError, InputError, MachineError, NegativeError, RunError, UsageError

__all__ = [
    "BugError",
    "CxlabError",
    "Episode",
    "InputError",
    "MachineError",
    "NegativeError",
    "RunError",
    "Step",
    "UsageError",
    "__version__",
]
