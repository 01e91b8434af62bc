"""cxlab check: rules examined without running them. python3 -m unittest check"""

import json
import os
import re
import shutil
import signal
import subprocess
import time
import unittest
import xml.etree.ElementTree
from pathlib import Path

from lab import CONFIG, CXLAB, SOURCE, Lab

RCLL = SOURCE / "scenarios/rcll"
EXAMPLES = SOURCE / "docs/examples"
LAMP = """(deftemplate lamp (slot state (allowed-values OFF ON)))
(deffacts lamps (lamp))
(defrule switch-on
  "It is dark."
  ?lamp <- (lamp (state OFF))
  =>
  (modify ?lamp (state ON)))
(defrule tell
  (lamp (state ON))
  =>
  (printout t "it is light" crlf))
"""


def codes(findings):
    return sorted({finding["code"] for finding in findings})


class Check(Lab):
    def check(self, *arguments, expect=0, cwd=None):
        done = subprocess.run([CXLAB, "check", *map(str, arguments)], cwd=cwd or self.folder, text=True, capture_output=True, timeout=100)
        self.assertEqual(done.returncode, expect, f"check {arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def findings(self, *arguments, expect=1):
        return json.loads(self.check(*arguments, "--json", expect=expect).stdout)["findings"]

    # --- honest agents

    def test_nothing_is_found_in_shipped_agents_and_examples(self):
        scenarios = [*RCLL.glob("*.yaml"), *(SOURCE / "scenarios/turtlesim").glob("*.yaml"), EXAMPLES / "league/game.yaml"]
        self.assertGreater(len(scenarios), 8)
        for scenario in scenarios:
            with self.subTest(scenario.name):
                done = self.check(scenario)
                self.assertRegex(done.stdout, r"^\d+ rules in \d+ files?: nothing found\n$")
                self.assertGreater(int(done.stdout.split()[0]), 3)
        configs = [EXAMPLES / "blocksworld/raw.yaml", *EXAMPLES.glob("*/example.yaml"), EXAMPLES / "hello/hello.yaml"]
        for config in configs:
            with self.subTest(str(config)):
                self.check(config, "--package", f"example={config.parent}", "--package", f"blocksworld={EXAMPLES / 'blocksworld'}")

    def test_every_strategy_of_the_planning_agent_is_clean(self):
        for dispatch in ("greedy", "groups", "lookahead:2", "partial-order", "stn"):
            with self.subTest(dispatch):
                self.check(RCLL / "planning_agent/params/agent.yaml", "--package", f"rcll_agent={RCLL / 'agent'}", "--param",
                           f"clips_manager.strategy.dispatch={dispatch}")

    # --- what a person sees

    def test_a_finding_has_its_place_and_the_remedy(self):
        self.write("lamp.clp", LAMP.replace("(lamp (state ON))\n", "(lamp (state ONN))\n"))
        done = self.check("lamp.clp", expect=1)
        self.assertEqual(done.stdout.splitlines()[-1], "2 rules in 1 file: 1 finding")
        self.assertRegex(done.stdout, r"(?m)^lamp.clp:9: \[unknown-symbol\] slot 'state' of 'lamp' is never ONN.*\bON\b")
        self.assertEqual(done.stderr, "")
        found = json.loads(self.check("lamp.clp", "--json", expect=1).stdout)
        self.assertEqual((found["files"], found["rules"]), (1, 2))
        self.assertEqual([(f["file"], f["line"], f["code"]) for f in found["findings"]], [("lamp.clp", 9, "unknown-symbol")])

    def test_several_files_are_one_rule_base(self):
        self.write("a/facts.clp", "(deftemplate lamp (slot state))\n(deffacts lamps (lamp (state ON)))\n")
        self.write("b/rules.clp", "(defrule tell (lamp (state ON)) => (printout t x))\n")
        self.check("a/facts.clp", "b/rules.clp")
        self.assertEqual(codes(self.findings("a/facts.clp")), ["never-read"])

    def test_files_beside_show_what_something_is_for(self):
        self.write("a/facts.clp", "(deftemplate lamp (slot state))\n(deffacts lamps (lamp (state ON)))\n")
        self.write("a/rules.clp", "(defrule tell (lamp (state ON)) => (printout t x))\n")
        self.check("a/facts.clp")
        self.write("a/rules.clp", "(defrule tell (lamp (state ON)) => (printout t x)\n")
        self.assertEqual(codes(self.findings("a/facts.clp")), ["never-read"])

    def test_a_configuration_is_examined_with_what_its_plugins_know(self):
        self.agent('(defrule tick (time ?now) (ros-msgs-message (topic "/a") (msg-ptr ?m)) => (printout t ?now (ros-msgs-get-field ?m "data")))\n'
                   "(defrule late (tiem ?now) => (printout t ?now))\n")
        found = self.findings("agent.yaml", "--package", "rules=rules")
        self.assertEqual([(f["file"], f["line"], f["code"]) for f in found], [("rules/rules.clp", 2, "never-asserted")])
        self.assertEqual(self.findings("scenario.yaml"), found)
        self.assertIn("did you mean 'time'?", found[0]["message"])

    def test_a_plugin_of_another_library_may_assert_and_read_anything(self):
        self.agent("(defrule seen (counted ?n) => (assert (heard ?n)))\n")
        self.assertEqual(codes(self.findings("scenario.yaml")), ["never-asserted", "never-read"])
        config = self.folder / "agent.yaml"
        config.write_text(config.read_text().replace("ros_msgs", "own").replace("cx::RosMsgsPlugin", "escape::Plugin"))
        self.write("rules/cxlab_plugins.yaml", f"library: {os.environ['ESCAPE']}\nplugins:\n  - class: escape::Plugin\n")
        self.check("scenario.yaml")

    def test_a_form_that_is_not_closed_is_an_error_with_its_line(self):
        self.write("open.clp", "\n(defrule open (x)\n")
        self.assertRegex(self.check("open.clp", expect=3).stderr, r"^error: open.clp:2: ")

    def test_what_does_not_load_is_a_finding_beside_the_others(self):
        self.agent("(defrule fine (tiem ?) => (printout t x))\n(defrule wrong (time ?) => (no-such-function))\n"
                   "(defrule late (time ?t) (robot ?r&~?q) => (printout t ?t ?r))\n(deffacts r (robot a))\n")
        found = self.findings("scenario.yaml")
        self.assertEqual([(f["line"], f["code"]) for f in found], [(1, "never-asserted"), (2, "not-loaded"), (3, "not-loaded"), (3, "used-once")])
        self.assertIn("no-such-function", found[1]["message"])

    def test_a_misspelt_slot_is_one_finding_whether_clips_refuses_it_or_not(self):
        self.agent("(deftemplate order\n  (slot id) (slot state))\n(deffacts o (order (id 1) (state OPEN)))\n"
                   "(defrule refused ?f <- (order (id 1)\n  (state OPEN))\n  =>\n  (modify ?f\n    (stat DONE)))\n"
                   "(defrule taken (time ?) => (do-for-all-facts ((?q order))\n  (eq ?q:stat OPEN) (retract ?q)))\n"
                   "(defrule of-a-plugin ?m <- (ros-msgs-message (topic \"x\")) =>\n  (printout t (fact-slot-value ?m tpoic)))\n")
        said = {8: "template 'order' has no slot 'stat', did you mean 'state'?", 10: "template 'order' has no slot 'stat', did you mean 'state'?",
                12: "template 'ros-msgs-message' has no slot 'tpoic', did you mean 'topic'?"}
        found = self.findings("scenario.yaml")
        self.assertEqual([(f["line"], f["code"], f["message"]) for f in found], [(line, "unknown-slot", what) for line, what in said.items()])
        found = self.findings("rules/rules.clp")
        self.assertEqual([f["line"] for f in found], [8, 10], "files alone do not tell the slots of plugins")

    def test_a_comment_silences_a_line(self):
        rules = "(deffunction spare (?x) ?x){}\n(defrule r (time ?t) => (printout t ?t))\n"
        self.write("a.clp", rules.format(""))
        self.assertEqual(codes(self.findings("a.clp")), ["unused-function"])
        self.write("a.clp", rules.format("  ; check: allow unused-function for people at the prompt"))
        self.check("a.clp")
        self.write("a.clp", rules.format("  ; check: allow loop"))
        self.assertEqual(codes(self.findings("a.clp")), ["unused-allow", "unused-function"])

    # --- the graph

    def test_the_graph_is_svg_and_dot(self):
        self.write("lamp.clp", LAMP)
        self.check("lamp.clp", "--graph", "rules.svg")
        root = xml.etree.ElementTree.parse(self.folder / "rules.svg").getroot()
        self.assertEqual(root.tag, "{http://www.w3.org/2000/svg}svg")
        texts = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
        for name in ("switch-on", "tell", "deffacts lamps", "lamp"):
            self.assertIn(name, texts)
        self.check("lamp.clp", "--graph", "rules.dot")
        dot = (self.folder / "rules.dot").read_text()
        for arrow in ('"deffacts lamps" -> "(lamp)"', '"(lamp)" -> "tell"', '"switch-on" -> "(lamp)"'):
            self.assertIn(arrow, dot)
        if shutil.which("dot"):
            subprocess.run(["dot", "-Tsvg", "rules.dot", "-o", "dot.svg"], cwd=self.folder, check=True)
        self.assertIn("expected a file that ends in .svg or .dot", self.check("lamp.clp", "--graph", "rules.png", expect=2).stderr)
        self.check("lamp.clp", "--graph", "/proc/none/rules.svg", expect=5)

    def test_a_graph_of_an_agent_is_well_formed(self):
        self.check(RCLL / "planning.yaml", "--graph", self.folder / "p.svg")
        root = xml.etree.ElementTree.parse(self.folder / "p.svg").getroot()
        texts = {element.text for element in root.iter("{http://www.w3.org/2000/svg}text")}
        self.assertLessEqual({"agenda-look", "step", "failure-lost"}, texts)

    # --- rules of a stranger

    def test_rules_do_not_run(self):
        self.agent('(defrule go => (open "made.txt" f "w") (printout f x crlf) (close f) (system "touch made-too"))\n'
                   '(deffunction f () (open "made.txt" g "w"))\n(defrule h (time ?) (test (f)) => (printout t x))\n')
        self.check("scenario.yaml")
        self.assertEqual(sorted(path.name for path in self.folder.rglob("made*")), [])

    def test_calls_of_batch_files_stay_behind_the_wall(self):
        self.write("secret.txt", "do not read me")
        self.agent("(defrule r (time ?t) => (printout t ?t))\n")
        config = CONFIG.replace('load: ["rules.clp"]', 'batch: ["calls.clp"]')
        self.write("agent.yaml", config)
        self.write("rules/calls.clp", '(load* "rules/rules.clp")\n(system "touch made")\n(open "../made" f "w")\n'
                   f'(remove "{self.folder}/secret.txt")\n(open "{self.folder}/secret.txt" g "r")\n')
        subprocess.run([CXLAB, "check", "scenario.yaml"], cwd=self.folder, capture_output=True, timeout=60)
        self.assertTrue((self.folder / "secret.txt").exists())
        self.assertEqual([path.name for path in self.folder.rglob("made")], [])

    def test_hostile_rules_take_no_time_and_no_memory(self):
        for name, rules in {
                "deep": "(defrule r (time ?) => " + "(+ 1 " * 900 + "1" + ")" * 900 + ")",
                "many_rules": "".join(f"(defrule r{i} ?f <- (n{i % 7} ?x) => (retract ?f) (assert (n{(i + 1) % 7} ?x)))\n" for i in range(3000)),
                "one_template": "".join(f"(defrule r{i} (declare (salience {i % 100})) ?f <- (s (a ?x) (b K{i})) (s (a ?x)) => (modify ?f (b K{i + 1})))\n"
                                        for i in range(1500)) + "(deftemplate s (slot a) (slot b))",
                "long_names": "".join(f"(deffacts f{i} ({'x' * 5000}{i}))\n" for i in range(300)),
                "functions_in_a_ring": "".join(f"(deffunction f{i} (?x) (f{(i + 1) % 2000} ?x))\n" for i in range(2000))}.items():
            with self.subTest(name):
                self.write("hostile.clp", rules)
                before = os.times()
                done = subprocess.run([CXLAB, "check", "hostile.clp"], cwd=self.folder, capture_output=True, text=True, timeout=100)
                self.assertIn(done.returncode, (0, 1, 3), done.stderr)
                after = os.times()
                cpu = after.children_user + after.children_system - before.children_user - before.children_system
                self.assertLess(cpu, 10)

    def test_a_file_that_loads_itself_ends(self):
        self.agent("(defrule r (time ?t) => (printout t ?t))\n")
        self.write("agent.yaml", CONFIG.replace('load: ["rules.clp"]', 'batch: ["again.clp"]'))
        self.write("rules/again.clp", '(bind ?folder (ament-index-get-package-share-directory "rules"))\n(batch* "rules/again.clp")\n')
        done = subprocess.run([CXLAB, "check", "scenario.yaml"], cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertIn(done.returncode, (0, 1, 3), done.stderr)

    def test_an_endless_call_of_a_batch_file_ends(self):
        self.agent("(defrule r (time ?t) => (printout t ?t))\n")
        self.write("agent.yaml", CONFIG.replace('load: ["rules.clp"]', 'batch: ["loop.clp"]'))
        self.write("rules/loop.clp", "(while TRUE do (+ 1 1))\n")
        found = self.findings("scenario.yaml")
        self.assertEqual([(f["file"], f["line"], f["code"]) for f in found], [("rules/loop.clp", 1, "not-loaded")])


if __name__ == "__main__":
    unittest.main()
