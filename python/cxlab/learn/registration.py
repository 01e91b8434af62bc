"""Registers the environments with Gymnasium."""

from __future__ import annotations


def register() -> None:
    """Called by `cxlab.learn`; by Gymnasium itself (entry point `gymnasium.envs`) before 1.4."""
    from gymnasium.envs.registration import register as add
    from gymnasium.envs.registration import registry

    for name, entry, of_many in (
        ("RCLLDispatch-v0", "cxlab.learn.dispatch:RCLLDispatchEnv", "cxlab.learn.vector:RCLLDispatchVectorEnv"),
        ("Turtlesim-v0", "cxlab.learn.turtle:TurtlesimEnv", None),
    ):
        if f"cxlab/{name}" not in registry:
            add(id=f"cxlab/{name}", entry_point=entry, vector_entry_point=of_many)
