"""The environment `CXEnv`."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

from cxlab import _cxlab
from cxlab._yaml import assignments_of, yaml_text
from cxlab.errors import CxlabError, InputError, RunError, UsageError

_GIVE_UP = -1
_NO_OP = 0
_SEEDS = 2**63
_EPISODES = 2**31 - 1  # of a training: more than anybody plays

Bits = NDArray[np.int8]


class _Decision(NamedTuple):
    """As the message cxlab_msgs/msg/RlDecision; the last is the time, s."""

    id: int
    robot: str
    observation: bytes
    mask: bytes
    reward: float
    outcome: str
    time: float


class CXEnv(gymnasium.Env[Bits, Any]):
    """An agent in rules as an environment of Gymnasium: the agent offers actions and gives rewards, Python chooses.

    Any agent that serves CX's `cx_rl_interfaces` will do, as it is. It plays in this process, faster than real time.
    One episode of the environment is one episode of the agent: `reset_env` begins it, `get_episode_end` ends it.

    Observation: `MultiBinary(n)` (int8), a bit for each name of `observables`: what the agent observes now.
    Action: `Discrete(m)`, a place of `actions`; 0 is `no-op`. `action_masks()` has those that can be chosen now. An action that
    the mask forbids leaves the robot idle as `no-op` does, and `info["invalid"]` is True.
    Reward: what the agent gave since the choice before; with several robots, to all of them.
    `info`: `robot` (for which the next action is), `outcome` ("end", "max_steps", "no action", "given up"),
    `action_mask`, `time` (s of simulated time), `decision` (counts).

    Args:
        agent: a configuration of the CLIPS-Executive (YAML), or several; or a scenario (file or name) that has the
            node `cx_rl_node` with `policy: external` among its servers.
        packages: folders of packages by name, for configurations; those around them are found.
        params: parameters of the node and of managers, by NODE.NAME, for configurations.
        set: values of the scenario to change, by path.
        seed: of the first episode's chance; `reset(seed=...)` begins anew with another.
        robots: how many may be at work at once. Of a scenario these four are in its file.
        no_op: whether the mask offers `no-op` where no other robot is at work.
        max_steps: of an episode, which then is truncated; each choice is a step.
        node: name of the trainer's node.
        until: end of the training, s of simulated time; None: no end.
        out: folder of the run; None writes nothing. `reset(seed=...)` begins another: OUT-2, OUT-3 ...
        journal: what journal.jsonl holds: "none", "decisions" or "full".

    Raises:
        InputError: a file or value cannot be used; it names file and line.
        RunError: rules failed, or the agent does not answer.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        agent: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
        *,
        packages: Mapping[str, str | os.PathLike[str]] | None = None,
        params: Mapping[str, Any] | None = None,
        set: Mapping[str, Any] | None = None,
        seed: int = 1,
        robots: int = 1,
        no_op: bool = False,
        max_steps: int = 1000,
        until: float | None = None,
        out: str | os.PathLike[str] | None = None,
        journal: str = "none",
        node: str = "/cx_rl_node",
    ) -> None:
        several = not isinstance(agent, (str, os.PathLike))
        agents = [os.fspath(one) for one in agent] if several else [os.fspath(agent)]  # type: ignore[union-attr, arg-type]
        name = node.rsplit("/", 1)[-1]
        node_params = {
            "policy": "external",
            "robots": robots,
            "no_op": no_op,
            "max_steps": max_steps,
            "max_episodes": _EPISODES,
        }
        self._configs = agents if several or _is_configuration(agents[0]) else []
        self._scenario = "" if self._configs else agents[0]
        if self._scenario and (packages or params):
            raise UsageError("packages and params are for configurations; a scenario has its own, which set changes")
        if self._configs and set:
            raise UsageError("set is for scenarios; configurations take params")
        if name != "cx_rl_node":
            node_params["name"] = name
        if namespace := node.rsplit("/", 1)[0]:
            node_params["namespace"] = namespace
        self._packages = [f"{key}={os.fspath(folder)}" for key, folder in (packages or {}).items()]
        given = {f"cx_rl_node.{key}": value for key, value in node_params.items()} | dict(params or {})
        self._params = [f"{key}={yaml_text(value, plain=True)}" for key, value in given.items()]
        self._set = dict(set or {})
        self._node = node
        self._until = until
        self._out = "" if out is None else os.fspath(out)
        self._journal = journal
        self._runs = 0
        self._shape = (0, 0)
        self._seeds = np.random.default_rng(seed)
        self._training: Any = None
        self._decision: _Decision | None = None
        self._begun = False
        self._observables: list[str] = []
        self._actions: list[str] = []
        self._begin(seed)

    @property
    def observables(self) -> list[str]:
        """Names of the bits of an observation: `on(a#b)`."""
        return self._observables

    @property
    def actions(self) -> list[str]:
        """Names of the actions; the first is `no-op`."""
        return self._actions

    def action_masks(self) -> NDArray[np.bool_]:
        """True for each action that can be chosen now, shape (m,)."""
        if self._decision is None or self._over:
            return np.zeros(len(self._actions), dtype=np.bool_)
        return np.frombuffer(self._decision.mask, dtype=np.uint8).astype(np.bool_)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Bits, dict[str, Any]]:
        """Begin an episode. With a seed a new training begins: the same seed and choices give the same bytes.

        An agent that cannot restart its world ends the run instead. Then the next run begins, with a seed that follows from
        the last one that was given.
        """
        super().reset(seed=seed)
        if seed is not None:
            self._seeds = np.random.default_rng(seed)
            self._begin(seed % _SEEDS)
        elif self._training is None:
            raise UsageError("the training has ended; reset(seed=...) begins another one")
        elif self._begun and not self._over:
            self._choose(_GIVE_UP)
            self._next()
        if self._over:
            self._choose(0)
            decision = self._played_on() or self._begin(int(self._seeds.integers(_SEEDS)))
            if self._over:  # an agent that has nothing to do at the beginning
                raise RunError(f"the episode ended before the first choice: {decision.outcome}")
        self._begun = True
        return self._observation(), self._info()

    def step(self, action: int) -> tuple[Bits, float, bool, bool, dict[str, Any]]:
        """Let the robot of `info["robot"]` act, and play on until a robot has a choice, or the episode ends."""
        if not self._begun or self._over:
            raise UsageError("found an episode that has ended; call reset() first")
        place = int(action)
        if not 0 <= place < len(self._actions):
            raise UsageError(f"found {place}, expected an action from 0 to {len(self._actions) - 1}", "action")
        allowed = bool(self.action_masks()[place])
        self._choose(place if allowed else _NO_OP)
        decision = self._next()
        truncated = decision.outcome == "max_steps"
        info = self._info() if allowed else self._info() | {"invalid": True}
        return self._observation(), decision.reward, self._over and not truncated, truncated, info

    def close(self) -> None:
        """End the training: files of the run are completed."""
        training, self._training, self._decision = self._training, None, None
        if training is not None and not training.closed:
            training.close()

    def _begin(self, seed: int) -> _Decision:
        with contextlib.suppress(CxlabError):  # the failure of the training before has been raised already
            self.close()
        self._runs += 1
        out = self._out if self._runs == 1 or not self._out else f"{self._out}-{self._runs}"
        self._training = _cxlab.Training(
            scenario=self._scenario,
            assignments=assignments_of(self._set, seed=seed if self._scenario else None),
            configs=self._configs,
            packages=self._packages,
            params=self._params,
            seed=seed,
            until=self._until,
            journal=self._journal,
            out=out,
            force=False,
            node=self._node,
        )
        self._begun = False
        decision = self._next()
        self._observables, self._actions = self._training.spaces()
        if not self._observables or len(self._actions) < 2:
            self.close()
            raise InputError(
                "the agent offers no spaces: a trainer needs answers of its services get_predefined_observables or "
                "get_observable_predicates, and "
                "get_predefined_actions or get_observable_actions, with get_observable_objects (docs/how-to/train-over-cx-rl.md)"
            )
        shape = len(self._observables), len(self._actions)
        if shape != self._shape:  # else the spaces stay, with their seeds
            self._shape = shape
            self.observation_space, self.action_space = (
                gymnasium.spaces.MultiBinary(shape[0]),
                gymnasium.spaces.Discrete(shape[1]),
            )
        return decision

    @property
    def _over(self) -> bool:
        """Whether the episode has ended."""
        return self._decision is not None and not self._decision.robot

    def _played_on(self) -> _Decision | None:
        """The next decision; None: the run is over."""
        found = self._training.next()
        self._decision = None if found is None else _Decision(*found)
        return self._decision

    def _next(self) -> _Decision:
        decision = self._played_on()
        if decision is None:
            result = self._training.close()
            self._training = None
            why = result.get("reason") or "rules asked for it, or until was reached"
            raise RunError(f"the run ended in the middle of an episode: {result['status']}; {why}")
        return decision

    def _choose(self, place: int) -> None:
        self._training.choose(place)

    def _observation(self) -> Bits:
        assert self._decision is not None
        return np.frombuffer(self._decision.observation, dtype=np.int8).copy()

    def _info(self) -> dict[str, Any]:
        assert self._decision is not None
        made = {"action_mask": self.action_masks(), "decision": self._decision.id}
        return {"robot": self._decision.robot, "outcome": self._decision.outcome, "time": self._decision.time, **made}


def _is_configuration(file: str) -> bool:
    """Whether a file is a configuration of the CLIPS-Executive: its first key is a node with `ros__parameters`."""
    if not os.path.isfile(file):
        return False
    with open(file, encoding="utf-8", errors="replace") as text:
        return "ros__parameters" in text.read()
