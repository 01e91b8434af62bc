"""up_engine.py with a framework that behaves in known ways. python3 -m unittest engines"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
SCRIPT = pathlib.Path(os.environ["CXLAB_SOURCE_DIR"]) / "planner/engines/up_engine.py"
KNOWN = ("it knows aries, enhsp, enhsp-any, enhsp-opt, fast-downward, fast-downward-opt, fmap, lpg, lpg-anytime, nextflap, pyperplan, symk, symk-opt, "
         "tamer")


class UpEngine(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def plan(self, engine, *arguments, domain="(define (domain d))", path=HERE / "fake", **variables):
        (self.folder / "d.pddl").write_text(domain)
        (self.folder / "p.pddl").write_text("(define (problem p))")
        environment = {**os.environ, "PYTHONPATH": str(path), "PYTHONDONTWRITEBYTECODE": "1", **variables}
        return subprocess.run([sys.executable, SCRIPT, engine, "d.pddl", "p.pddl", "plan", *arguments], cwd=self.folder, env=environment,
                              capture_output=True, text=True, timeout=60)

    def ends(self, code, message, engine, **options):
        done = self.plan(engine, **options)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(done.stderr.splitlines()[-1].replace(sys.executable, "PYTHON"), message)
        self.assertFalse((self.folder / "plan").exists())

    def test_a_plan_is_written_as_pddl_writes_plans(self):
        self.assertEqual(self.plan("aries").returncode, 0)
        self.assertEqual((self.folder / "plan").read_text().splitlines()[:2], ["0.000000: (unstack c a) [3.000000]", "3.010000: (put-down c) [2.000000]"])

    def test_sequences_and_partial_orders_get_times(self):
        self.assertEqual(self.plan("unified_planning.engines:Classical").returncode, 0)
        self.assertEqual((self.folder / "plan").read_text(), "0.000000: (go a b)\n0.010000: (stop)\n")
        self.assertEqual(self.plan("unified_planning.engines:Ordered").returncode, 0)
        self.assertEqual((self.folder / "plan").read_text(), "0.000000: (go a b)\n0.010000: (go b c)\n")

    def test_each_better_plan_has_a_file(self):
        self.assertEqual(self.plan("aries", "--anytime").returncode, 0)
        self.assertEqual((self.folder / "plan.2").read_text(), "0.000000: (go a b) [0.500000]\n")

    def test_functions_are_whole_numbers_for_an_engine_that_asks_for_them(self):
        self.assertEqual(self.plan("aries", domain="(define (domain d) (:functions (f)))").returncode, 0)

    def test_other_answers_have_the_codes_of_cxlab_plan(self):
        for status, code, message in [("UNSOLVABLE_PROVEN", 10, "unsolvable"), ("UNSOLVABLE_INCOMPLETELY", 12, "ended without a plan"), ("MEMOUT", 22, "out of memory"),
                                   ("TIMEOUT", 23, "time ended"), ("UNSUPPORTED_PROBLEM", 34, "does not support the problem"), ("INTERNAL_ERROR", 4, "failed: the reason")]:
            self.ends(code, f"engine unified_planning.engines:Status: {message}", "unified_planning.engines:Status", STATUS=status)

    def test_a_failure_is_told_in_one_line(self):
        self.ends(4, "engine unified_planning.engines:Broken failed: RuntimeError: something broke", "unified_planning.engines:Broken")

    def test_no_answer_counts_on_a_problem_that_the_engine_does_not_support(self):
        self.ends(34, "engine tamer does not support the problem: durative", "tamer")

    def test_what_the_framework_cannot_read_is_told(self):
        self.ends(34, "the Unified Planning Framework cannot read the problem: SyntaxError: Not able to handle: derived Line: 3", "aries", domain="(:derived)")

    def test_what_is_missing_is_told_with_the_command_that_installs_it(self):
        self.ends(5, "engine lpg: not installed: PYTHON -m pip install up-lpg 'setuptools<81'", "lpg")
        self.ends(2, f"engine ariess: unknown to the Unified Planning Framework; did you mean aries? {KNOWN}", "ariess")
        self.ends(5, "engine no_such_module:Engine: No module named 'no_such_module'; is it installed for PYTHON?", "no_such_module:Engine")
        (self.folder / "unified_planning.py").write_text("raise ImportError(\"No module named 'unified_planning'\")")
        self.ends(5, "engine tamer: No module named 'unified_planning': PYTHON -m pip install unified-planning up-tamer", "tamer", path=self.folder)
        self.ends(2, f"engine tamr: unknown to the Unified Planning Framework; did you mean tamer? {KNOWN}", "tamr", path=self.folder)
        self.ends(2, f"engine nosuch: unknown to the Unified Planning Framework; {KNOWN}", "nosuch", path=self.folder)
        self.ends(5, "engine lpgg:Engine: No module named 'unified_planning': PYTHON -m pip install unified-planning", "lpgg:Engine", path=self.folder)


if __name__ == "__main__":
    unittest.main()
