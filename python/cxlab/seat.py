"""Seats: agents of an episode that are programs in Python, and what they do on the bus."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from cxlab import _cxlab
from cxlab._yaml import yaml_text

Message = Mapping[str, Any]


class Call:
    """A call of a service by an episode's program."""

    def __init__(self, core: _cxlab.Episode, number: int) -> None:
        self._core = core
        self._number = number

    @property
    def response(self) -> dict[str, Any] | None:
        """The answer; None before it has come."""
        return self._core.response(self._number)

    @property
    def done(self) -> bool:
        """Whether the answer has come."""
        return self.response is not None

    def __repr__(self) -> str:
        return f"<cxlab.Call, {'answered' if self.done else 'waiting'}>"


class Goal:
    """A goal that an episode's program sent."""

    def __init__(self, core: _cxlab.Episode, number: int) -> None:
        self._core = core
        self._number = number

    @property
    def accepted(self) -> bool | None:
        """Whether the server took it; None before it has answered."""
        return self._core.goal(self._number)["accepted"]

    @property
    def feedback(self) -> list[dict[str, Any]]:
        """All feedback so far."""
        return self._core.goal(self._number)["feedback"]

    @property
    def done(self) -> bool:
        """Whether the goal has ended, or was refused."""
        goal = self._core.goal(self._number)
        return goal["succeeded"] is not None or goal["accepted"] is False

    @property
    def succeeded(self) -> bool | None:
        """Whether it succeeded; None before it has ended."""
        return self._core.goal(self._number)["succeeded"]

    @property
    def result(self) -> dict[str, Any] | None:
        """Its result; None before it has ended."""
        return self._core.goal(self._number)["result"]

    def cancel(self) -> None:
        """Ask the server to end it."""
        self._core.cancel(self._number)

    def __repr__(self) -> str:
        goal = self._core.goal(self._number)
        states = {None: "waiting", False: "refused", True: "accepted"}, {False: "failed", True: "succeeded"}
        return f"<cxlab.Goal, {states[1].get(goal['succeeded'], states[0][goal['accepted']])}>"


class Bus:
    """The bus, as a seat has it.

    Names are those of ROS: relative ones get the namespace "/", "~" is the seat. Types are those of packages that the run
    knows, "turtlesim/msg/Pose". Messages are dicts of fields; missing ones have their defaults. Messages go out when
    the turn of the seat to decide comes.
    """

    def __init__(self, core: _cxlab.Bus) -> None:
        self._core = core

    @property
    def now(self) -> float:
        """Simulated time of the tick, s."""
        return self._core.now

    def read(self, topic: str, type: str, reader: Callable[[dict[str, Any]], object]) -> None:
        """Call `reader` with each message of the topic from now on, before the seat perceives."""
        self._core.read(topic, type, reader)

    def publish(self, topic: str, type: str, message: Message) -> None:
        """Publish a message."""
        self._core.publish(topic, type, yaml_text(message))

    def call(
        self,
        service: str,
        type: str,
        request: Message,
        on_response: Callable[[dict[str, Any]], object] | None = None,
    ) -> None:
        """Call a service; the call waits until somebody serves it."""
        self._core.call(service, type, yaml_text(request), on_response)

    def send_goal(
        self,
        action: str,
        type: str,
        goal: Message,
        *,
        on_answer: Callable[[bool], object] | None = None,
        on_feedback: Callable[[dict[str, Any]], object] | None = None,
        on_result: Callable[[bool, dict[str, Any]], object] | None = None,
    ) -> int:
        """Send a goal, which waits until somebody serves the action; returns its number.

        `on_answer` gets whether it was accepted, `on_result` whether it succeeded, and the result.
        """
        return self._core.send_goal(action, type, yaml_text(goal), on_answer, on_feedback, on_result)

    def cancel(self, goal: int) -> None:
        """Ask the server of a goal to end it."""
        self._core.cancel(goal)


class Seat:
    """An agent that is a program: beside the rules of an episode, or instead of them.

        class Pilot(cxlab.Seat):
            def begin(self):
                self.bus.read("/turtle1/pose", "turtlesim/msg/Pose", self.see)

            def see(self, pose):
                self.pose = pose

            def decide(self, now):
                self.bus.publish("/turtle1/cmd_vel", "geometry_msgs/msg/Twist", {"linear": {"x": 1.0}})

        cxlab.Episode("turtlesim/square", seats=[Pilot("pilot")]).run()

    In each tick the seat perceives, decides and acts once, after all environments. A tick comes when anything in the episode
    is due; `next_due` says when this seat wants one. An exception ends the run, and `Episode.step` raises it.

    Args:
        name: of its node on the bus: letters, digits and '_', a letter first.
    """

    bus: Bus

    def __init__(self, name: str) -> None:
        self.name = name

    def _sit_down(self, core: _cxlab.Bus) -> None:
        self.bus = Bus(core)
        self.begin()

    def begin(self) -> None:
        """Called once when the episode is loaded. `bus` is there from here on."""

    def perceive(self) -> None:
        """Called in each tick, after the readers have got what came."""

    def decide(self, now: float) -> None:
        """Called in each tick, at that simulated time (s), when all rules have decided."""

    def act(self) -> None:
        """Called in each tick, after all have decided."""

    def next_due(self) -> float:
        """Simulated time (s) at which the seat wants a tick at the latest; math.inf: when something comes."""
        return math.inf
