"""docs/examples/ray/play_on_ray.py on a cluster of Ray: two machines, which the test starts on this one. ./dev readers"""

import json
import os
import pathlib
import signal
import shutil
import subprocess
import sys
import time
import unittest
from unittest import mock

from lab import CONFIG, CXLAB, Lab
from played_pages import Pages
from ray.cluster_utils import Cluster

SOURCE = pathlib.Path(os.environ["CXLAB_SOURCE_DIR"])
SUITE = """scenarios: [games/game.yaml]
seeds: "1..12"
strategies: {plain: []}
grid: {duration_s: [3, 4]}
"""
# The program of each machine: notes where it is called, and takes a while, so that the machine can fail in the middle.
PROGRAM = """#!/bin/bash
pwd >> {notes}
sleep 0.3
exec {cxlab} "$@"
"""


def started(start):
    """Ray gives a machine 30 s to start, which may be too few while others use the processors."""
    for _ in range(3):
        try:
            return start()
        except Exception as error:  # Ray raises nothing more special
            reason = error
    raise reason


class Guide(Pages, folder="how-to", by="readers_ray_cluster"):
    @classmethod
    def setUpClass(cls):
        changed = mock.patch.dict(os.environ, {"RAY_USAGE_STATS_ENABLED": "0", "PATH": f"{pathlib.Path(CXLAB).parent}:{os.environ['PATH']}"})  # also of the workers
        changed.start()
        cls.addClassCleanup(changed.stop)
        cluster = started(lambda: Cluster(initialize_head=True, head_node_args={"num_cpus": 2, "include_dashboard": False, "object_store_memory": 100_000_000}))
        cls.addClassCleanup(cluster.shutdown)
        os.environ["RAY_ADDRESS"] = cluster.address


class OnRay(Lab):
    @classmethod
    def setUpClass(cls):
        os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
        cls.cluster = started(lambda: Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False, "object_store_memory": 100_000_000}))
        cls.addClassCleanup(cls.cluster.shutdown)

    def setUp(self):
        super().setUp()
        self.nodes = [started(lambda: self.cluster.add_node(num_cpus=1, object_store_memory=100_000_000)) for _ in range(2)]
        self.addCleanup(lambda: [self.cluster.remove_node(node) for node in self.nodes])
        self.cluster.wait_for_nodes()
        self.agent("(defrule draw (time ?) => (assert (drawn (random))))\n")
        for name, text in (("home/agent.yaml", CONFIG), ("home/games/game.yaml", "schema: 1\nduration_s: 2\npackages: {rules: ../rules}\nagents:\n  - config: ../agent.yaml\n"),
                           ("home/suites/suite.yaml", SUITE.replace("[games", "[../games")), ("home/cxlab", PROGRAM.format(notes=self.folder / "called", cxlab=CXLAB))):
            self.write(name, text)
        (self.folder / "home/cxlab").chmod(0o755)
        shutil.copytree(self.folder / "rules", self.folder / "home/rules")
        self.bench("-j", "2", "--out", "whole")

    def bench(self, *arguments):
        done = subprocess.run([CXLAB, "bench", "home/suites/suite.yaml", "--quiet", *arguments], cwd=self.folder, text=True, timeout=120, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def start(self, *arguments):
        return subprocess.Popen([sys.executable, SOURCE / "docs/examples/ray/play_on_ray.py", "home/suites/suite.yaml", "--out", "r", "--address", self.cluster.address,
                                 "--ship", "home", "--cxlab", "cxlab", "--cells-per-task", "2", *arguments],
                                cwd=self.folder, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)

    def wait_for_rows(self, process, number):
        for _ in range(1200):
            if len(list((self.folder / "r/rows").glob("*.json"))) >= number:
                return
            self.assertIsNone(process.poll(), "the sweep has ended too early")
            time.sleep(0.05)
        self.fail("no rows within a minute")

    def rows(self, out):
        """Their bytes, without those of the last key, which are of the machine."""
        return {file.name: file.read_text().partition('"played": {')[0] for file in (self.folder / out / "rows").glob("*.json")}

    def assert_whole(self):
        self.assertEqual(len(self.rows("whole")), 36)
        self.assertEqual(self.rows("r"), self.rows("whole"))
        self.assertEqual((self.folder / "r/rows.csv").read_bytes(), (self.folder / "whole/rows.csv").read_bytes())

    def test_a_machine_that_fails_in_the_middle_changes_nothing(self):
        process = self.start()
        self.wait_for_rows(process, 6)
        self.cluster.remove_node(self.nodes.pop(), allow_graceful=False)
        out, err = process.communicate(timeout=240)
        self.assertEqual(process.returncode, 0, out + err)
        self.assertIn("36 of 36 cells have a row", err)
        self.assert_whole()
        # Both machines played from a copy of what was shipped, not from the folder of the one that asked.
        places = set((self.folder / "called").read_text().split())
        self.assertTrue(all("working_dir_files" in place for place in places if place != str(self.folder)), places)
        self.assertTrue(any("working_dir_files" in place for place in places), places)

    def test_after_a_kill_only_what_is_missing_is_played(self):
        process = self.start()
        self.wait_for_rows(process, 6)
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        kept = len(list((self.folder / "r/rows").glob("*.json")))
        self.assertLess(kept, 36)
        process = self.start()
        out, err = process.communicate(timeout=240)
        self.assertEqual(process.returncode, 0, out + err)
        self.assertIn(f"{36 - kept} of {36 - kept} games\n", err)
        self.assert_whole()


if __name__ == "__main__":
    unittest.main()
