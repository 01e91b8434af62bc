"""`cxlab/RCLLDispatch-v0`: choose which order is begun and which job a robot takes, in a game of the Logistics League."""

from __future__ import annotations

from typing import Any, Unpack

import gymnasium
import numpy as np
from numpy.typing import NDArray

from cxlab.learn.games import OPTIONS, SEEDS, SIZE, Games, Settings, mask_of, observation_of


class RCLLDispatchEnv(gymnasium.Env[NDArray[np.float32], np.int64]):
    """The whole team is one agent: each step answers one choice of the rules.

    Observation: float32, shape (347,), between -1 and 1 (docs/reference/learning.md). Action: one of 16 options; `action_masks()` and
    `info["action_mask"]` say which may be chosen. An action that the mask forbids takes the rules' option, and `info["invalid"]`
    is True. Reward: the points that the team
    got since the last step, or since the game began; their sum is what the game ends with. The episode terminates with the game; it is truncated at
    `until` (s), if that is given.

    Args:
        scenario: one whose rules ask for orders and jobs, or for steps.
        settings: those of `cxlab.learn.games.Settings`.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1}  # noqa: RUF012  Gymnasium's name and type

    def __init__(
        self,
        scenario: str = "rcll/external",
        *,
        render_mode: str | None = None,
        **settings: Unpack[Settings],
    ) -> None:
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (SIZE,), np.float32)
        self.action_space = gymnasium.spaces.Discrete(OPTIONS)
        self.render_mode = render_mode
        self._games = Games(scenario, **settings)
        self._following: int | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin a game. With `seed` it is the game of that seed (as `cxlab run --seed` plays it); without, seeds follow from the
        last one that was given."""
        return self._begin(*self._seeds(seed))

    def _seeds(self, seed: int | None) -> tuple[int, int]:
        """The seeds of the game to begin now and of the one after it."""
        super().reset(seed=seed)
        if seed is None and self._following is not None:
            seed = self._following
        elif seed is None:
            seed = int(self.np_random.integers(SEEDS))
        self._following = int(self.np_random.integers(SEEDS))
        return seed, self._following

    def _begin(self, seed: int, following: int) -> tuple[NDArray[np.float32], dict[str, Any]]:
        self._games.begin(seed, following)
        return self._seen(seed=seed)

    def _seen(self, **info: Any) -> tuple[NDArray[np.float32], dict[str, Any]]:
        choice = self._games.choice
        info["action_mask"] = mask_of(choice)
        if choice is not None:
            info |= {"kind": choice.kind, "who": choice.who, "preferred": choice.preferred, "now": choice.now}
        return observation_of(choice), info

    def step(self, action: np.int64) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        return self._played_on(self._games.choose(int(action)))

    def _played_on(self, good: bool) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Plays on to the next choice; what a step returns. `good`: whether the mask allowed its action."""
        self._games.play_on()
        reward = float(self._games.points())
        observation, info = self._seen()
        if not good:
            info["invalid"] = True
        over = self._games.choice is None
        truncated = False
        if over:
            result = self._games.result()
            truncated = result["status"] != "completed"
            info |= {"points": int(result["teams"][self._games.team]["points"]), "journal_hash": result["journal_hash"]}
        return observation, reward, over and not truncated, truncated, info

    def action_masks(self) -> NDArray[np.bool_]:
        """For `sb3_contrib.MaskablePPO`: bool, shape (16,)."""
        return mask_of(self._games.choice)

    def render(self) -> NDArray[np.uint8] | None:
        """The field at the open choice: uint8, shape (400, 640, 3); None without `render_mode="rgb_array"`, or after the end."""
        game = self._games.game
        return game.render(camera="field") if self.render_mode == "rgb_array" and game is not None and self._games.choice is not None else None

    def close(self) -> None:
        self._games.close()
