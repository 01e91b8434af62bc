"""Learning: choices of rules, made from Python (docs/reference/learning.md).

    >>> from cxlab.learn import ChoiceGame
    >>> game = ChoiceGame("rcll/external", seed=7, tier="timed")
    >>> while choice := game.next():
    ...     game.choose(choice.preferred)
    >>> game.close()["teams"]["CYAN"]["points"]

The environments need the extra `cxlab[learn]` (Gymnasium, PettingZoo): `gymnasium.make("cxlab/RCLLDispatch-v0")`.
"""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from cxlab.learn.choices import Choice, ChoiceGame
from cxlab.learn.policy import LinearPolicy, play, play_all, shipped_policy

if TYPE_CHECKING:
    from cxlab.learn.dispatch import RCLLDispatchEnv
    from cxlab.learn.robots import RCLLRobotsEnv, RCLLRobotsParallelEnv
    from cxlab.learn.turtle import TurtlesimEnv
    from cxlab.learn.vector import RCLLDispatchVectorEnv

__all__ = [
    "Choice",
    "ChoiceGame",
    "LinearPolicy",
    "RCLLDispatchEnv",
    "RCLLDispatchVectorEnv",
    "RCLLRobotsEnv",
    "RCLLRobotsParallelEnv",
    "TurtlesimEnv",
    "play",
    "play_all",
    "shipped_policy",
]

_LAZY = {
    "RCLLDispatchEnv": "dispatch",
    "RCLLDispatchVectorEnv": "vector",
    "RCLLRobotsEnv": "robots",
    "RCLLRobotsParallelEnv": "robots",
    "TurtlesimEnv": "turtle",
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'cxlab.learn' has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f"cxlab.learn.{_LAZY[name]}"), name)


def __dir__() -> list[str]:
    return __all__


def _register_where_gymnasium_is() -> None:
    """Gymnasium 1.4 looks for no entry points any more, so whoever imports this module finds the environments, before or after
    Gymnasium."""
    with contextlib.suppress(ImportError):
        from cxlab.learn.registration import register

        register()


_register_where_gymnasium_is()
