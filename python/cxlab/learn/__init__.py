"""Learning: choices of rules, made from Python (docs/reference/learning.md).

    >>> from cxlab.learn import ChoiceGame
    >>> game = ChoiceGame("rcll/external", seed=7, tier="timed")
    >>> while choice := game.next():
    ...     game.choose(choice.preferred)
    >>> game.close()["teams"]["CYAN"]["points"]

The environments need the extra `cxlab[learn]` (Gymnasium, PettingZoo): `gymnasium.make("cxlab/RCLLDispatch-v0")`.
"""

from __future__ import annotations

from typing import Any

from cxlab.learn.choices import Choice, ChoiceGame
from cxlab.learn.policy import LinearPolicy, play, play_all, shipped_policy

__all__ = [
    "Choice",
    "ChoiceGame",
    "LinearPolicy",
    "RCLLDispatchEnv",
    "RCLLRobotsEnv",
    "RCLLRobotsParallelEnv",
    "TurtlesimEnv",
    "play",
    "play_all",
    "shipped_policy",
]

_LAZY = {
    "RCLLDispatchEnv": "dispatch",
    "RCLLRobotsEnv": "robots",
    "RCLLRobotsParallelEnv": "robots",
    "TurtlesimEnv": "turtle",
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'cxlab.learn' has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f"cxlab.learn.{_LAZY[name]}"), name)


def _register_when_gymnasium_is_there() -> None:
    """Installed, Gymnasium finds the entry point by itself; from a build folder the import of this module registers."""
    import sys

    if "gymnasium" in sys.modules:
        from cxlab.learn.registration import register

        register()


_register_when_gymnasium_is_there()
