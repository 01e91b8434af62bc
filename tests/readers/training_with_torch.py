"""python/examples/rllib_dispatch.py on the two nodes that it starts on this machine. ./dev readers --torch"""

import math
import os
import pathlib
import re
import subprocess
import sys
import unittest

import numpy as np
from ray.rllib.env.single_agent_episode import SingleAgentEpisode
from ray.rllib.utils.metrics.metrics_logger import MetricsLogger

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "python/examples/rllib_dispatch.py"
LINE = re.compile(r"iteration (\d+): (\d+) games, ([-+.\w]+) points a game; (\d+) of (\d+) choices forbidden; choices on each node: (.+)")


class OnTwoNodes(unittest.TestCase):
    def trained(self, *arguments):
        """The lines of two iterations: numbers, and the choices on each node."""
        done = subprocess.run(
            [sys.executable, EXAMPLE, "--iterations", "2", "--choices", "60", "--until", "240", *arguments],
            capture_output=True, text=True, timeout=900, check=False, env=os.environ | {"RAY_USAGE_STATS_ENABLED": "0"},
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [match.groups() for match in LINE.finditer(done.stdout)]
        self.assertEqual([line[0] for line in lines], ["1", "2"], done.stdout)
        return [(int(games), float(points), int(forbidden), int(choices), [int(one) for one in nodes.split(", ")])
                for _, games, points, forbidden, choices, nodes in lines]  # fmt: skip

    def check(self, lines):
        for games, points, forbidden, choices, nodes in lines:
            self.assertGreaterEqual(games, 2)
            self.assertTrue(math.isfinite(points))
            self.assertEqual(forbidden, 0)
            self.assertEqual(len(nodes), 2)
            self.assertEqual(sum(nodes), choices)
            self.assertGreater(min(nodes), 0)

    def test_both_play_what_the_mask_allows_and_a_seed_says_what(self):
        lines = self.trained()
        self.check(lines)
        self.assertEqual(self.trained(), lines)
        self.assertNotEqual(self.trained("--seed", "2"), lines)

    def test_so_do_the_robots_as_agents(self):
        self.check(self.trained("--robots"))


class Counting(unittest.TestCase):
    def test_what_the_mask_forbids_is_counted(self):
        sys.path.insert(0, str(EXAMPLE.parent))
        self.addCleanup(sys.path.remove, str(EXAMPLE.parent))
        from rllib_dispatch import look_at

        seen = {"observation": np.zeros(3, np.float32), "action_mask": np.array([1, 0, 1], np.int8)}
        game = SingleAgentEpisode(observations=[seen] * 4, actions=[0, 1, 2], rewards=[0.0, 3.0, 2.0], infos=[{}] * 4, terminated=True)
        logger = MetricsLogger(root=True)
        look_at([game], logger)
        told = logger.reduce()
        print(told)


if __name__ == "__main__":
    unittest.main()
