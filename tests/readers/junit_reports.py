"""junitparser and junit2html read what `cxlab test --junit` writes. ./dev readers"""

import json
import subprocess
import unittest

from junitparser import Error, Failure, JUnitXml
from junit2htmlreport import parser as junit2html
from lab import CXLAB, SOURCE, Lab

STORIES = r"""- story: passes
  rules: a.clp
  given: [(start)]
  expect: [{fires: go, within_s: 1}]
- story: "fails twice \"<&>' ]]> \u0001\u007f \ufffe\uffff 😀\tand\nin two lines"
  rules: a.clp
  given: [(start)]
  expect: [{fact: '(t (s "b"))', within_s: 1}, {not_fires: go}]
- story: "a rule, 'wrong', is wrong"
  rules: a.clp
  given: [(divide)]
  expect: [{fires: wrong, within_s: 1}]
- story: " no rules "
  rules: broken.clp
  expect: [{not_fires: go, within_s: 1}]
- story: passes
  rules: a.clp
  given: [(start)]
  expect: [{fact: '(x ?)', within_s: 1}]
"""
NAMES = ["passes", "fails twice \"<&>' ]]> ?\u007f ?? 😀\tand\nin two lines", "a rule, 'wrong', is wrong", " no rules ", "passes"]


class JunitReports(Lab):
    def read(self, *arguments, code=0):
        """The test cases as junitparser reads them, and the answer as JSON. Both readers count the same."""
        done = subprocess.run([CXLAB, "test", *map(str, arguments), "--junit", "j.xml", "--json"], cwd=self.folder, text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, code, done.stderr)
        answer = json.loads(done.stdout)
        [suite] = JUnitXml.fromfile(str(self.folder / "j.xml"))
        self.assertEqual(suite.name, "cxlab")
        cases = list(suite)
        failed = [any(isinstance(r, Failure) for r in c.result) for c in cases]
        wrong = [any(isinstance(r, Error) for r in c.result) for c in cases]
        self.assertEqual((suite.tests, suite.failures, suite.errors, suite.skipped), (len(cases), sum(failed), sum(wrong), 0))
        self.assertEqual([f or w for f, w in zip(failed, wrong)], [not story["passed"] for story in answer["stories"]])
        self.assertAlmostEqual(suite.time, sum(c.time for c in cases), delta=0.001 * len(cases))
        for case, story in zip(cases, answer["stories"]):
            self.assertAlmostEqual(case.time, story["wall_s"], delta=0.0006)
            self.assertEqual(case.classname, story["file"])
        before = (suite.tests, suite.failures, suite.errors)
        suite.update_statistics()
        self.assertEqual((suite.tests, suite.failures, suite.errors), before)

        report = junit2html.Junit(str(self.folder / "j.xml"))
        self.assertEqual([case.name for part in report.suites for case in part.all()], [case.name for case in cases])
        self.assertEqual(sum(len(part.failed()) for part in report.suites), sum(failed) + sum(wrong))
        self.assertIn("</html>", report.html())
        return cases, answer["stories"]

    def test_names_and_texts_of_all_kinds(self):
        self.write("a.clp", '(deftemplate t (slot s))\n(defrule go (start) => (printout t "a" (format nil "%c" 1)) (assert (t (s "a<&]]>€"))) (assert (x "two\n lines")))\n'
                            "(defrule wrong (divide) => (/ 1 0))\n")
        self.write("broken.clp", "(defrule go (start) =>\n")
        self.write("a, <b> & \"c\".story.yaml", STORIES)
        for more in [], ["-j", 3]:
            cases, stories = self.read(*more, code=3)
            self.assertEqual([case.name for case in cases], NAMES)
            self.assertEqual([[type(r) for r in case.result] for case in cases], [[], [Failure], [Failure], [Error], []])
            for case, story in zip(cases[1:4], stories[1:4]):
                result, failures = case.result[0], [text.replace("\x01", "?") for text in story["failures"]]
                self.assertEqual((result.text, result.message), ("\n".join(failures), failures[0]))
            self.assertEqual(len(stories[1]["failures"]), 2)
            self.assertIn("a.clp:4", cases[2].result[0].text)
            self.assertIn("broken.clp:1", cases[3].result[0].text)

    def test_stories_that_come_with_cxlab(self):
        cases, _ = self.read(SOURCE / "docs/examples/stories")
        self.assertTrue(all(case.is_passed for case in cases))
        self.assertIn("docs/examples/stories", cases[0].classname)


if __name__ == "__main__":
    unittest.main()
