"""Trains a dispatcher with RLlib's PPO and action masks, on the nodes of a cluster.

    python rllib_dispatch.py [--address ADDRESS] [--robots] [--iterations 10] [--choices 1000] [--seed 1] [--until SECONDS]

Needs `ray[rllib]`, torch and `cxlab[learn]` on each node. Without --address a cluster of two nodes is started on this machine.
With --robots each robot is an agent, and so is who begins orders; they share one policy. Each processor plays games.
"""

from __future__ import annotations

import argparse
from typing import Any

import gymnasium
import numpy as np
import ray
import torch
from ray.cluster_utils import Cluster
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module.apis.value_function_api import ValueFunctionAPI
from ray.rllib.core.rl_module.rl_module import RLModuleSpec
from ray.rllib.core.rl_module.torch import TorchRLModule
from ray.rllib.env.multi_agent_episode import MultiAgentEpisode
from ray.rllib.env.single_agent_episode import SingleAgentEpisode
from ray.rllib.env.wrappers.pettingzoo_env import PettingZooEnv
from ray.rllib.utils.metrics.metrics_logger import MetricsLogger
from ray.tune import register_env
from torch import nn

from cxlab.learn import RCLLDispatchEnv, RCLLRobotsEnv
from cxlab.learn.games import HEAD, WIDTH  # the head of an observation; the features of 16 options follow


class WithMask(gymnasium.ObservationWrapper):
    """Observations that carry the mask, as those of the robots do."""

    def __init__(self, env: RCLLDispatchEnv) -> None:
        super().__init__(env)
        mask = gymnasium.spaces.Box(0, 1, (env.action_space.n,), np.int8)
        self.observation_space = gymnasium.spaces.Dict({"observation": env.observation_space, "action_mask": mask})

    def observation(self, observation: np.ndarray) -> dict[str, np.ndarray]:
        return {"observation": observation, "action_mask": self.env.action_masks().astype(np.int8)}


class MaskedPolicy(TorchRLModule, ValueFunctionAPI):
    """Scores each option by its features and the situation. An option that the mask forbids has probability 0."""

    def setup(self) -> None:
        self.score = nn.Sequential(nn.Linear(HEAD + WIDTH, 32), nn.Tanh(), nn.Linear(32, 1))
        self.value = nn.Sequential(nn.Linear(HEAD, 32), nn.Tanh(), nn.Linear(32, 1))

    def _forward(self, batch: dict[str, Any], **more: Any) -> dict[str, torch.Tensor]:
        seen, mask = batch[Columns.OBS]["observation"], batch[Columns.OBS]["action_mask"]
        options = seen[:, HEAD:].unflatten(1, (-1, WIDTH))
        heads = seen[:, None, :HEAD].expand(-1, options.shape[1], -1)
        scores = self.score(torch.cat([heads, options], dim=2)).squeeze(2)
        return {Columns.ACTION_DIST_INPUTS: scores.masked_fill(mask == 0, torch.finfo(scores.dtype).min)}

    def compute_values(self, batch: dict[str, Any], embeddings: Any = None) -> torch.Tensor:
        return self.value(batch[Columns.OBS]["observation"][:, :HEAD]).squeeze(1)


def look_at(samples: list[SingleAgentEpisode | MultiAgentEpisode], metrics_logger: MetricsLogger, **more: Any) -> None:
    """Counts, where games are played, their points, their choices, and those that the mask forbids."""
    node = ray.get_runtime_context().get_node_id()
    for game in samples:
        agents = list(game.agent_episodes.values()) if isinstance(game, MultiAgentEpisode) else [game]
        steps = [(agent.get_observations(step), agent.get_actions(step)) for agent in agents for step in range(len(agent))]
        metrics_logger.log_value("points", agents[0].get_return(), reduce="item_series")  # all agents get those of the team
        metrics_logger.log_value("forbidden", sum(not seen["action_mask"][action] for seen, action in steps), reduce="sum")
        metrics_logger.log_value(("choices", node), len(steps), reduce="sum")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--address", help="of the cluster; without it one of two nodes is started on this machine")
    parser.add_argument("--robots", action="store_true", help="an agent for each robot and one for orders")
    parser.add_argument("--iterations", type=int, default=10)
    parser.add_argument("--choices", type=int, default=1000, help="that an iteration learns from, at least; a game has about 130")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--until", type=float, help="end of each game, s")
    arguments = parser.parse_args()
    if arguments.address is None:
        cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
        for _ in range(2):
            cluster.add_node(num_cpus=1)
        arguments.address = cluster.address
    ray.init(address=arguments.address, log_to_driver=False)
    settings = {"until": arguments.until, "journal": "decisions"}
    register_env("dispatch", lambda _: WithMask(RCLLDispatchEnv(**settings)))
    register_env("robots", lambda _: PettingZooEnv(RCLLRobotsEnv(**settings)))
    size = arguments.choices
    config = (
        PPOConfig()
        .environment("robots" if arguments.robots else "dispatch")
        .env_runners(num_env_runners=int(ray.cluster_resources()["CPU"]), batch_mode="complete_episodes")
        .rl_module(rl_module_spec=RLModuleSpec(module_class=MaskedPolicy))
        .training(train_batch_size=size, minibatch_size=size // 4, num_epochs=4, lr=1e-3, gamma=0.999, vf_clip_param=1e6)
        .callbacks(on_sample_end=look_at)
        .debugging(seed=arguments.seed, log_level="ERROR")
    )
    if arguments.robots:
        config.multi_agent(policies={"dispatcher"}, policy_mapping_fn=lambda *_, **__: "dispatcher")
    algorithm = config.build_algo()
    for iteration in range(1, arguments.iterations + 1):
        told = algorithm.train()["env_runners"]
        choices = sorted(int(one) for one in told["choices"].values())
        print(
            f"iteration {iteration}: {len(told['points'])} games, {np.mean(told['points']):.1f} points a game; "
            f"{told['forbidden']:.0f} of {sum(choices)} choices forbidden; choices on each node: {', '.join(map(str, choices))}",
            flush=True,
        )
    algorithm.stop()


if __name__ == "__main__":
    main()
