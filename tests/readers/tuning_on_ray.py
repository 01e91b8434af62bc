"""python/examples/tune_dispatcher.py on a cluster of Ray: two machines, which the test starts on this one. ./dev readers"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from ray.cluster_utils import Cluster
from ray_cluster import started

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "python/examples/tune_dispatcher.py"


class OnTwoMachines(unittest.TestCase):
    def test_both_play_trials_and_the_best_weights_are_told(self):
        os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
        head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": 100_000_000}
        cluster = started(lambda: Cluster(initialize_head=True, head_node_args=head))
        self.addCleanup(cluster.shutdown)
        for _ in range(2):
            started(lambda: cluster.add_node(num_cpus=1, object_store_memory=100_000_000))
        cluster.wait_for_nodes()
        with tempfile.TemporaryDirectory() as out:
            done = subprocess.run(
                [sys.executable, EXAMPLE, "--address", cluster.address, "--out", out, "--trials", "4", "--seeds", "1..2", "--until", "100"],
                capture_output=True, text=True, timeout=300, check=False,
            )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"4 trials on 2 node\(s\); best gain [+-]\d")
        self.assertTrue(re.search(r'"way": -?0\.\d+', done.stdout), done.stdout)


if __name__ == "__main__":
    unittest.main()
