"""50 real kills of a sweep at random moments: what is left in the end is the table of a sweep that nobody disturbed."""

import json
import random
import signal
import subprocess
import time
import unittest

from lab import CXLAB, GAME, Lab

SUITE = """scenarios: [easy/game.yaml, hard/game.yaml]
seeds: "1..6"
strategies: {three: [], one: ["world.robots=1"]}
"""
KILLS = 50


class SweepKills(Lab):
    def bench(self, out):
        return [CXLAB, "bench", str(self.folder / "suite.yaml"), "-j", "2", "--quiet", "--json", "--out", str(out)]

    def table(self, out):
        """The table of a sweep that is let be, without what the clock of the wall says."""
        for _ in range(100):
            done = subprocess.run(self.bench(out), capture_output=True, text=True, timeout=300)
            if done.returncode != 5:  # the last children of the killed sweep have not gone yet
                break
            time.sleep(0.1)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = sorted((out / "rows").glob("*.json"))
        return {row.name: {k: v for k, v in json.loads(row.read_text()).items() if "wall" not in k and "factor" not in k and k != "log"} for row in rows}

    def test_the_table_is_that_of_an_undisturbed_sweep(self):
        self.write("suite.yaml", SUITE)
        self.write("easy/game.yaml", GAME)
        self.write("hard/game.yaml", GAME.replace("20", "60"))
        whole = self.table(self.folder / "whole")
        self.assertEqual(len(whole), 24)
        chance = random.Random(7)
        moments = []
        for number in range(KILLS):
            out = self.folder / f"killed-{number // 10}"
            process = subprocess.Popen(self.bench(out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(chance.uniform(0.01, 0.5))
            process.send_signal(signal.SIGKILL if number % 5 else signal.SIGTERM)
            process.wait(20)
            moments.append(len(list((out / "rows").glob("*.json"))))
            if number % 10 == 9:
                self.assertEqual(self.table(out), whole)
        self.assertGreater(len(set(moments)), 5, "the kills came at the same moment")


if __name__ == "__main__":
    unittest.main()
