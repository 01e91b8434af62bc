"""`cxlab/Turtlesim-v0`: drive the turtle to a goal."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from cxlab.episode import Episode

SIDE = 11.0889  # m
AREA = (2.4, 8.6)  # m: starts and goals; rules bring the turtle home beyond 2 and 9
NEAR = 0.3  # m from the goal
PERIOD = 0.1  # s of a step


class TurtlesimEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A turtle that is to come within 0.3 m of a goal on the canvas; rules may play beside it, as the scenario says.

    Observation: float32, shape (6,), between -1 and 1. Four numbers are the way to the goal in sides of the canvas. They go along its x and y,
    and ahead and to the left of the turtle. Two are the sine and cosine of its heading. Action: float32, shape (2,), between -1
    and 1, for 0.1 s. It gives the speed ahead (1 is 2 m/s), and how fast the turtle turns left (1 is 2 rad/s). Reward: the metres by which
    it came nearer. The episode terminates at the goal; it is truncated after 200 steps, or when the scenario ends.

    Args:
        scenario: a world of kind turtlesim.
        steps: after which the episode is truncated.
        set, out, journal, agents: as for `cxlab.Episode`; `out` is replaced by each episode.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012  Gymnasium's name and type

    def __init__(
        self, scenario: str = "turtlesim/goal", *, steps: int = 200, render_mode: str | None = None, journal: str = "none", **more: Any
    ) -> None:
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (6,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.render_mode = render_mode
        self._scenario, self._steps, self._journal, self._more = scenario, steps, journal, more
        self._episode: Episode | None = None
        self._goal = np.zeros(2)
        self._step = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode; start, heading and goal follow from the seed."""
        super().reset(seed=seed)
        x, y, goal_x, goal_y = self.np_random.uniform(*AREA, 4).tolist()
        theta = float(self.np_random.uniform(-np.pi, np.pi))
        self.close()
        self._goal = np.array([goal_x, goal_y])
        self._step = 0
        settings = dict(self._more)
        settings["set"] = {"world.turtles": [{"name": "turtle1", "x": x, "y": y, "theta": theta}], **settings.get("set", {})}
        if settings.get("out") is not None:
            settings["force"] = True
        self._episode = Episode(
            self._scenario, seed=int(self.np_random.integers(2**31 - 1)), journal=self._journal, **settings
        )
        self._episode.read("/turtle1/pose", "turtlesim/msg/Pose")
        self._pose = {"x": x, "y": y, "theta": theta}
        self._episode.step(until=0.05)
        self._look()
        self._away = self._distance()
        return self._observation(), {}

    def _look(self) -> None:
        episode = self._episode
        assert episode is not None
        for _, pose in episode.read("/turtle1/pose", "turtlesim/msg/Pose"):
            self._pose = pose

    def _distance(self) -> float:
        return float(np.hypot(self._goal[0] - self._pose["x"], self._goal[1] - self._pose["y"]))

    def _observation(self) -> NDArray[np.float32]:
        x, y = (self._goal - (self._pose["x"], self._pose["y"])) / SIDE
        sine, cosine = np.sin(self._pose["theta"]), np.cos(self._pose["theta"])
        ahead, left = x * cosine + y * sine, y * cosine - x * sine
        return np.clip(np.array([x, y, ahead, left, sine, cosine], dtype=np.float32), -1.0, 1.0)

    def step(self, action: NDArray[np.float32]) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        episode = self._episode
        if episode is None or episode.closed:
            raise RuntimeError("the episode is over; call reset()")
        ahead, turn = (float(value) for value in np.clip(action, -1.0, 1.0))
        episode.publish("/turtle1/cmd_vel", "geometry_msgs/msg/Twist", {"linear": {"x": 2.0 * ahead}, "angular": {"z": 2.0 * turn}})
        self._step += 1
        episode.step(until=0.05 + PERIOD * self._step)
        self._look()
        before, self._away = self._away, self._distance()
        terminated = self._away < NEAR
        truncated = not terminated and (self._step >= self._steps or episode.over)
        info: dict[str, Any] = {}
        if terminated or truncated:
            info["journal_hash"] = episode.close()["journal_hash"]
        return self._observation(), before - self._away, terminated, truncated, info

    def render(self) -> NDArray[np.uint8] | None:
        """The canvas: uint8, shape (500, 500, 3); None without `render_mode="rgb_array"`, or after the end."""
        episode = self._episode
        if self.render_mode != "rgb_array" or episode is None or episode.closed:
            return None
        return episode.render(500, 500)

    def close(self) -> None:
        if self._episode is not None:
            self._episode.close()
            self._episode = None
