"""The examples that need torch: RLlib on the two nodes that it starts here, and MaskablePPO. ./dev readers --torch"""

import math
import os
import pathlib
import re
import subprocess
import sys
import unittest
from unittest import mock

import numpy as np
import torch
from cxlab.learn import RCLLDispatchEnv
from ray.rllib.env.single_agent_episode import SingleAgentEpisode
from played_pages import Pages
from ray.rllib.utils.metrics.metrics_logger import MetricsLogger

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "python/examples"
sys.path.insert(0, str(EXAMPLES))
import rllib_dispatch  # noqa: E402

LINE = re.compile(r"iteration (\d+): (\d+) games, (\S+) points a game; (\d+) of (\d+) choices forbidden; .* node: (.+)")


def said(name, *arguments):
    environment = os.environ | {"RAY_USAGE_STATS_ENABLED": "0"}
    command = [sys.executable, EXAMPLES / name, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False, env=environment)
    if done.returncode != 0:
        raise AssertionError(done.stdout + done.stderr)
    return done.stdout


class OnPages(Pages, folder="reference", by="readers_training_with_torch"):
    pass


class WithRLlib(unittest.TestCase):
    def trained(self, iterations, *arguments):
        """Games, points, choices, and the choices on each node, of each iteration."""
        out = said("rllib_dispatch.py", "--iterations", str(iterations), "--choices", "60", "--until", "240", *arguments)
        lines = LINE.findall(out)
        self.assertEqual([int(line[0]) for line in lines], list(range(1, iterations + 1)), out)
        for _, games, points, forbidden, choices, nodes in lines:
            nodes = [int(one) for one in nodes.split(", ")]
            self.assertEqual((len(nodes), sum(nodes)), (2, int(choices)))
            self.assertGreater(min(nodes), 0)
            self.assertGreaterEqual(int(games), 2)
            self.assertTrue(math.isfinite(float(points)))
            self.assertEqual(forbidden, "0")
        return lines

    def test_both_nodes_play_what_the_mask_allows_and_a_seed_trains_the_same_way(self):
        lines = self.trained(2)
        self.assertEqual(self.trained(2), lines)
        # Before it has learned the policy is the same one, so the robots as agents play the same games.
        self.assertEqual(self.trained(1, "--robots"), lines[:1])

    def test_the_policy_scores_options_wherever_they_stand_and_gives_forbidden_ones_no_chance(self):
        env = rllib_dispatch.WithMask(RCLLDispatchEnv(until=30.0))
        self.addCleanup(env.close)
        torch.manual_seed(1)
        policy = rllib_dispatch.MaskedPolicy(observation_space=env.observation_space, action_space=env.action_space)
        head, width = rllib_dispatch.HEAD, rllib_dispatch.WIDTH
        seen = 2 * torch.rand(1, *env.observation_space["observation"].shape) - 1
        turned = torch.cat([seen[:, :head], seen[:, head:].roll(width, dims=1)], dim=1)
        mask = (torch.arange(16) % 3 > 0).to(torch.int8)[None]

        def chances(observation, allowed):
            out = policy.forward_inference({"obs": {"observation": observation, "action_mask": allowed}})
            return torch.softmax(out["action_dist_inputs"], dim=1)[0]

        found = chances(seen, mask)
        self.assertEqual((found > 0).tolist(), (mask[0] > 0).tolist())
        self.assertGreater(found[mask[0] > 0].std().item(), 1e-3)
        torch.testing.assert_close(chances(turned, mask.roll(1, dims=1)), found.roll(1))

    def test_what_the_mask_forbids_is_counted(self):
        seen = {"observation": np.zeros(3, np.float32), "action_mask": np.array([1, 0, 1], np.int8)}
        game = SingleAgentEpisode(observations=[seen] * 4, actions=[0, 1, 2], rewards=[0.0, 3.0, 2.0], len_lookback_buffer=0)
        logger = MetricsLogger()
        with mock.patch.object(rllib_dispatch.ray, "get_runtime_context") as here:
            here().get_node_id.return_value = "node"
            rllib_dispatch.look_at([game], logger)
        told = [logger.peek(key) for key in ("points", "forbidden", ("choices", "node"))]
        self.assertEqual(told, [[5.0], 1, 3])


class WithStableBaselines(unittest.TestCase):
    def test_a_trained_policy_plays_a_whole_game_and_takes_what_the_mask_allows(self):
        self.assertRegex(said("sb3_dispatch.py", "130"), r"\nseed 30001: \d+ points, 0 choices forbidden\n$")


if __name__ == "__main__":
    unittest.main()
