"""cxlab profile: the slowest rule comes first, counts agree with cxlab rules, and it says what it costs."""

import json
import os
import signal
import subprocess
import time
import unittest

from rule_coverage import Page
from lab import CXLAB, SOURCE, Lab

SLOW = """(deffunction waste (?n) (loop-for-count (?i 1 ?n) (+ ?i 1)) TRUE)
(defrule quick (time ?) => (assert (tick)))
(defrule slow-actions (time ?) => (waste 3000))
(defrule slow-condition (time ?t) (tick) (test (waste 9000)) => )
(defrule idle (nothing) => )
"""


class Profile(Lab):
    def cxlab(self, *arguments, expect=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=200)
        self.assertEqual(done.returncode, expect, f"{arguments}\n{done.stdout[-3000:]}\n{done.stderr}")
        return done

    def setUp(self):
        super().setUp()
        self.agent(SLOW)
        self.run_it()

    def test_the_slowest_rules_come_first(self):
        answer = json.loads(self.cxlab("profile", self.out, "--json").stdout)
        self.assertEqual([r["rule"] for r in answer["rules"][:2]], ["slow-condition", "slow-actions"])
        slow, second = answer["rules"][:2]
        self.assertGreater(slow["matching_s"], 0.8 * slow["s"])
        self.assertGreater(second["acting_s"], 0.8 * second["s"])
        self.assertEqual(max(slow["joins"], key=lambda join: join["s"])["text"], "(tick) (test (waste 9000))")
        self.assertEqual(answer["functions"][0]["function"], "waste")
        self.assertEqual(answer["functions"][0]["calls"], second["fired"] + slow["joins"][1]["passed"])
        in_rules = sum(r["s"] for r in answer["rules"])
        self.assertGreater(in_rules, 0.3 * answer["plain_s"])
        self.assertAlmostEqual(answer["elsewhere_s"], max(0, answer["plain_s"] - in_rules))
        self.assertGreater(answer["clock_reads"], 100)

    def test_counts_agree_with_rules(self):
        for more in [], ["--at", "1.2"]:
            profiled = json.loads(self.cxlab("profile", self.out, "--json", *more).stdout)
            used = json.loads(self.cxlab("rules", self.out, "--json", *more).stdout)
            self.assertEqual(profiled["at_s"], used["at_s"])
            self.assertEqual({r["rule"]: (r["fired"], r["activated"]) for r in profiled["rules"]},
                             {r["rule"]: (r["fired"], r["activated"]) for r in used["environments"][0]["rules"]})

    def test_text_page_and_trace(self):
        said = self.cxlab("profile", self.out, "--html", "p.html", "--trace", "t.json", "--most", "1").stdout
        self.assertRegex(said.splitlines()[0], r"^[\d.]+ s of CPU without profiling, [\d.]+ s with it: \d+ readings of the clock, (\d+ ns each|which take too little time)")
        self.assertIn("slow-condition", said)
        self.assertNotIn("quick", said)
        page = Page((self.folder / "p.html").read_text())
        self.assertEqual(page.asks, [])
        trace = json.loads((self.folder / "t.json").read_text())["traceEvents"]
        fired = json.loads(self.cxlab("profile", self.out, "--json").stdout)["rules"]
        self.assertEqual(sum(e.get("cat") == "firing" for e in trace), sum(r["fired"] for r in fired))
        for event in trace:
            if event["ph"] == "X":
                self.assertGreaterEqual(event["dur"], 0)
        slow = [e for e in trace if e.get("cat") == "matching" and e["dur"] > 100]
        self.assertGreater(len(slow), 3)
        for event in slow:
            self.assertEqual((event["name"], event["args"]["condition"]), ("matching slow-condition, condition 2", "(tick) (test (waste 9000))"))

    def test_time_of_other_processes_does_not_count(self):
        """The process stands still for half of the time."""
        def slowest():
            return json.loads(self.cxlab("profile", self.out, "--json").stdout)
        alone = slowest()["rules"][0]["s"]
        process = subprocess.Popen([CXLAB, "profile", self.out, "--json"], stdout=subprocess.PIPE, text=True, cwd=self.folder, start_new_session=True)
        while process.poll() is None:
            time.sleep(0.003)
            os.killpg(process.pid, signal.SIGSTOP)
            time.sleep(0.03)
            os.killpg(process.pid, signal.SIGCONT)
        answer = json.loads(process.communicate()[0])
        self.assertEqual([r["rule"] for r in answer["rules"][:2]], ["slow-condition", "slow-actions"])
        self.assertLess(answer["rules"][0]["s"], 3 * alone)

    def test_a_cost_too_small_to_measure_is_no_zero(self):
        for _ in range(5):
            self.assertNotIn(" 0 ns each", self.cxlab("profile", self.out, "--at", "0.1").stdout)

    def test_wrong_questions(self):
        self.assertIn("--at", self.cxlab("profile", self.out, "--at", "100", expect=2).stderr)
        self.assertIn("has no environment 'mian'", self.cxlab("profile", self.out, "--env", "mian", expect=3).stderr)
        self.cxlab("profile", "nowhere", expect=3)


if __name__ == "__main__":
    unittest.main()
