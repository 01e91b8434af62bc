"""The same game as several agents: one for each robot, and `orders`, which chooses what is begun."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from pettingzoo import AECEnv, ParallelEnv

from cxlab.learn.games import OPTIONS, SEEDS, SIZE, Games, Settings, mask_of, observation_of

ORDERS = "orders"


class _Team:
    """What both forms share. Observation: {"observation": float32 (347,), "action_mask": int8 (16,)}; who does not choose now sees
    zeros, and its mask allows action 0 alone, which changes nothing. All agents get the team's points as reward. `settings` are those of
    `cxlab.learn.games.Settings`."""

    def __init__(
        self,
        scenario: str = "rcll/external",
        *,
        robots: int = 3,
        render_mode: str | None = None,
        **settings: Unpack[Settings],
    ) -> None:
        self.possible_agents = [ORDERS, *(f"robot{number + 1}" for number in range(robots))]
        self.render_mode = render_mode
        see = spaces.Dict(
            {
                "observation": spaces.Box(-1.0, 1.0, (SIZE,), np.float32),
                "action_mask": spaces.Box(0, 1, (OPTIONS,), np.int8),
            }
        )
        self.observation_spaces = dict.fromkeys(self.possible_agents, see)
        self.action_spaces = {agent: spaces.Discrete(OPTIONS) for agent in self.possible_agents}
        settings["set"] = {"world.robots": robots, **settings.get("set", {})}
        self._games = Games(scenario, **settings)
        self._random: np.random.Generator | None = None
        self._following: int | None = None

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        return self.action_spaces[agent]

    def _begin(self, seed: int | None) -> None:
        if seed is not None or self._random is None or self._following is None:
            self._random, _ = seeding.np_random(seed)
            self._following = seed if seed is not None else int(self._random.integers(SEEDS))
        now, self._following = self._following, int(self._random.integers(SEEDS))
        self._games.begin(now, self._following)
        self.agents = list(self.possible_agents)

    def _chooser(self) -> str | None:
        """Who chooses now; None: the game is over."""
        choice = self._games.choice
        return None if choice is None else choice.who or ORDERS

    def _see(self, agent: str) -> dict[str, Any]:
        choice = self._games.choice if agent == self._chooser() else None
        return {"observation": observation_of(choice), "action_mask": mask_of(choice).astype(np.int8)}

    def _ended(self) -> tuple[bool, bool]:
        """Whether the game is over, and whether it was cut off before its end."""
        if self._games.choice is not None:
            return False, False
        completed = self._games.result()["status"] == "completed"
        return completed, not completed

    def render(self) -> None:
        return None

    def close(self) -> None:
        self._games.close()


class RCLLRobotsEnv(_Team, AECEnv[str, dict[str, Any], int]):
    """In turn (PettingZoo AEC): the agent that chooses now is `agent_selection`."""

    metadata = {"name": "cxlab_rcll_robots_v0", "render_modes": [], "is_parallelizable": False}  # noqa: RUF012

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        self._begin(seed)
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos: dict[str, dict[str, Any]] = {agent: {} for agent in self.agents}
        self.agent_selection = self._chooser() or ORDERS

    def observe(self, agent: str) -> dict[str, Any]:
        return self._see(agent)

    def step(self, action: int | None) -> None:
        if self.terminations[self.agent_selection] or self.truncations[self.agent_selection]:
            self._was_dead_step(action)
            return
        agent = self.agent_selection
        self._cumulative_rewards[agent] = 0.0
        self._games.answer(-1 if action is None else int(action))
        gained = float(self._games.points())
        self.rewards = dict.fromkeys(self.agents, gained)
        terminated, truncated = self._ended()
        self.terminations = dict.fromkeys(self.agents, terminated)
        self.truncations = dict.fromkeys(self.agents, truncated)
        self.agent_selection = self._chooser() or agent
        self._accumulate_rewards()


class RCLLRobotsParallelEnv(_Team, ParallelEnv[str, dict[str, Any], int]):
    """All at once (PettingZoo parallel): the action of the agent that chooses now counts."""

    metadata = {"name": "cxlab_rcll_robots_parallel_v0", "render_modes": []}  # noqa: RUF012

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, dict[str, Any]], dict[str, dict[str, Any]]]:
        self._begin(seed)
        return self._all_see(), {agent: {} for agent in self.agents}

    def _all_see(self) -> dict[str, dict[str, Any]]:
        return {agent: self._see(agent) for agent in self.agents}

    def step(
        self, actions: Mapping[str, int]
    ) -> tuple[dict[str, dict[str, Any]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        chooser = self._chooser()
        self._games.answer(int(actions.get(chooser, -1)) if chooser is not None else -1)
        gained = float(self._games.points())
        terminated, truncated = self._ended()
        every = self.agents
        seen = self._all_see()
        if terminated or truncated:
            self.agents = []
        return (
            seen,
            dict.fromkeys(every, gained),
            dict.fromkeys(every, terminated),
            dict.fromkeys(every, truncated),
            {agent: {} for agent in every},
        )
