"""The parts of benchmarks/planner that run and read other planners. python3 -m unittest runner"""

import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(os.environ["CXLAB_SOURCE_DIR"]) / "benchmarks/planner"))

from field import makespan, read_steps  # noqa: E402: found through the line above
from processes import run  # noqa: E402


def is_alive(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class Run(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def sh(self, text, cpu=10, wall=20, sign="sign"):
        return run(["sh", "-c", text], self.folder / "log", cpu, wall, lambda: (self.folder / sign).exists(), folder=self.folder)

    def test_a_program_that_ends_tells_how(self):
        ended = self.sh("echo hello; touch sign; exit 7")
        self.assertEqual((ended.code, ended.in_time, (self.folder / "log").read_text()), (7, True, "hello\n"))
        self.assertLessEqual(ended.first_wall, ended.wall)
        self.assertEqual(self.sh("kill -SEGV $$").code, -11)
        self.assertIsNone(self.sh("true", sign="none").first_wall)

    def test_what_hangs_is_ended_with_all_that_it_started(self):
        for text, cpu, wall in [("sleep 60 & echo $! > child; sleep 60", 10, 0.3), ("sleep 60 & echo $! > child; while :; do :; done", 0.3, 60),
                                ("sleep 60 & echo $! > child", 10, 20)]:
            ended = self.sh(text, cpu, wall)
            self.assertEqual(ended.in_time, "while" not in text and "; sleep" not in text)
            child = int((self.folder / "child").read_text())
            for _ in range(1000):
                if not is_alive(child):
                    break
                os.sched_yield()
            self.assertFalse(is_alive(child), text)

    def test_the_time_of_children_counts(self):
        self.assertGreater(self.sh("(while :; do :; done) & wait", 0.3, 60).cpu, 0.2)


class Steps(unittest.TestCase):
    def test_plans_are_read_as_each_planner_prints_them(self):
        ours = read_steps("0.000: (go a b) [5.000]\n5.001001: (stop)\n")
        self.assertEqual(ours, [(0.0, "go a b", 5.0), (5.001001, "stop", None)])
        lpg = read_steps("; Version LPG-td-1.4\n; Time 0.01\n\n0.0003:   (GO A B) [5.0000])\n5.0005:   (STOP) [D:0.0000; C:1.0]\n")
        self.assertEqual([step[1:] for step in lpg], [("go a b", 5.0), ("stop", 0.0)])
        self.assertEqual((makespan(ours), makespan([])), (5.001001, 0.0))


if __name__ == "__main__":
    unittest.main()
