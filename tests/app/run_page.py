"""The page of a run has what the run had, in both tiers and of both agents; questions and page say the same."""

import json
import re
import subprocess
import unittest

from lab import CXLAB, SOURCE, Lab
from pages import RunPage

LARGEST = 3_000_000


class Pages(Lab):
    def play(self, *arguments, name="run"):
        run = self.folder / name
        done = subprocess.run([CXLAB, "run", *map(str, arguments), "--quiet", "--out", run], cwd=self.folder, text=True, timeout=120, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return run

    def ask(self, *arguments):
        done = subprocess.run([CXLAB, *map(str, arguments), "--json"], cwd=self.folder, text=True, timeout=120, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def orders_are_those_of_the_question(self, run, page, teams):
        answer = self.ask("orders", run)
        tasks = {task["id"]: task for task in page.part("Orders")["tasks"]}
        self.assertEqual(len(tasks), len(answer["orders"]))
        for order in answer["orders"]:
            task = tasks[f"{order['team']}-{order['order']}" if teams > 1 else str(order["order"])]
            begin, end = order["window_s"]
            self.assertAlmostEqual(task["end"] - task["begin"], end - begin, places=2)
            for key, column in (("state", "state"), ("reason", "outcome"), ("points", "points")):
                self.assertEqual(task[key], order[column])
            for key, column in (("begun", "begun_s"), ("done", "delivered_s")):
                self.assertEqual(task[key], order[column] if order[column] is None else round(order[column], 3))
            steps = [step for step in answer["steps"] if step["order"] == order["order"] and step.get("team") == order.get("team")]
            self.assertEqual([(step["text"], step.get("where"), step["waited_s"], step.get("reason", "")) for step in task["steps"]],
                             [(step["step"], step["machine"], round(step["waited_s"], 3), step["waited_for"]) for step in steps])
            self.assertGreater(task["look"].count("cylinder"), 1, "a base and a cap at least")

    def waits_are_those_of_the_question(self, run, page):
        waits = self.ask("waits", run)["waits"]
        for lane in page.part("Robots")["lanes"]:
            shown = {(bar["begin"], bar["end"], bar.get("remark", "")) for bar in lane["bars"]}
            for wait in waits:
                if wait["robot"] == lane["name"]:
                    self.assertIn((round(wait["from_s"], 3), round(wait["to_s"], 3), ": " + wait["why"]), shown)

    def lanes_are_whole(self, page):
        end = page.run["end"]
        kinds = {kind["name"] for kind in page.run["kinds"]}
        for lane in page.lanes():
            full = sorted((bar["begin"], bar["end"]) for bar in lane["bars"] if bar["shape"] in ("bar", "alert"))
            for (_, before), (begin, _) in zip(full, full[1:]):
                self.assertLessEqual(before, begin, lane["name"])
            for bar in lane["bars"]:
                self.assertTrue(0 <= bar["begin"] <= bar["end"] <= end, (lane["name"], bar))
                self.assertIn(bar["kind"], kinds)
        for machine in page.part("Machines")["lanes"]:
            bars = machine["bars"]
            self.assertEqual((bars[0]["begin"], bars[-1]["end"]), (0, end), "a machine is always in a state")
            for a, b in zip(bars, bars[1:]):
                self.assertEqual(a["end"], b["begin"])

    def points_are_those_of_the_result(self, run, page):
        teams = json.loads((run / "result.json").read_text())["teams"]
        lines = page.part("Points over time")["lines"]
        last = {line["text"]: line["steps"][-1][1] if line["steps"] else 0 for line in lines if not line["part"]}
        self.assertEqual(sum(last.values()), sum(team["points"] for team in teams.values()))
        parts = sum(line["steps"][-1][1] for line in lines if line["part"])
        self.assertEqual(parts, sum(last.values()), "kinds add up")

    def check(self, scenario, tier, teams=1, options=()):
        run = self.play(scenario, "--tier", tier, "--seed", 5, *options, name=f"{scenario}-{tier}".replace("/", "-"))
        page = RunPage(run)
        self.assertLess(len(page.text.encode()), LARGEST)
        self.assertEqual(page.run["end"], json.loads((run / "result.json").read_text())["sim_time_s"])
        self.assertEqual(page.scene, (run / "scene.bin").read_bytes())
        self.orders_are_those_of_the_question(run, page, teams)
        self.waits_are_those_of_the_question(run, page)
        self.lanes_are_whole(page)
        self.points_are_those_of_the_result(run, page)
        report = json.loads((run / "report.json").read_text())
        self.assertEqual([(round(one["t"], 3), one["by"], one["slots"][0]) for one in report["decisions"]],
                         [(one["t"], one["who"], one["text"]) for one in page.events("decision")])

    def test_rule_agent_in_the_timed_tier(self):
        self.check("rcll/game", "timed")

    def test_rule_agent_with_physics(self):
        self.check("rcll/game", "physics", options=("--until", 500))

    def test_planning_agent_in_the_timed_tier(self):
        self.check("rcll/planning", "timed")

    def test_two_teams(self):
        self.check("rcll/two_teams", "timed", teams=2)

    def test_same_run_gives_the_same_page(self):
        pages = [RunPage(self.play("rcll/game", "--tier", "timed", "--until", 200, name=name)).text for name in "ab"]
        speed = re.compile(r", \d+ x real time")
        self.assertEqual(*(speed.sub("", page) for page in pages))

    def test_faults_are_marks_and_events(self):
        faults = "faults=[{kind: robot_maintenance, at: 50, robot: robot2, seconds: 20}, {kind: machine_breaks, at: 60, machine: C-CS1}]"
        page = RunPage(self.play("rcll/game", "--tier", "timed", "--until", 200, "--set", faults))
        self.assertEqual([(e["t"], e["who"], e["text"]) for e in page.events("fault")], [(50, "robot2", "robot_maintenance"), (60, "C-CS1", "machine_breaks")])
        self.assertEqual([(e["t"], e["text"]) for e in page.events("maintenance")], [(50, "taken off the field"), (70, "back on the field")])
        lanes = {lane["name"]: lane for lane in page.lanes()}
        self.assertEqual([mark["t"] for mark in lanes["robot2"]["marks"]], [50])
        broken = [bar for bar in lanes["C-CS1"]["bars"] if bar["kind"] == "broken"]
        self.assertEqual(broken[0]["begin"], 60)
        self.assertEqual([e["t"] for e in page.events("broken")], [60])

    def test_a_robot_that_a_fault_holds_up_waits_for_nobody(self):
        """The halted robot is at a machine, and ends its work there first."""
        for kind, keys, seconds in (("skill_stalls", ", seconds: 12", 12), ("robot_halts", ", seconds: 12", 12), ("goal_lost", "", 10)):
            fault = f"faults=[{{kind: {kind}, at: 60, robot: robot1{keys}}}]"
            page = RunPage(self.play("rcll/game", "--tier", "timed", "--until", 200, "--set", fault, name=kind))
            lane = next(lane for lane in page.lanes() if lane["name"] == "robot1")
            (mark,) = lane["marks"]
            (bar,) = [bar for bar in lane["bars"] if bar["text"] == "held up by a fault"]
            self.assertEqual(mark["text"], kind)
            self.assertGreaterEqual(bar["begin"], mark["t"])
            self.assertAlmostEqual(bar["end"], mark["t"] + seconds, delta=0.1)
            self.assertIn(f"the fault {kind} held up its ", bar["remark"])
            others = [bar for bar in lane["bars"] if " was in the way of its " in bar.get("remark", "")]
            self.assertTrue(others, "other waits stay what they are")
            self.assertTrue({bar["text"] for bar in others} <= {"waits for robot2", "waits for robot3"}, others)

    def test_errors_of_rules_are_events(self):
        self.agent("(defrule wrong (start-up) => (/ 1 0))\n(deffacts here (start-up))")
        self.run_it()
        errors = RunPage(self.out).events("error")
        self.assertEqual(errors[0]["t"], 0)
        self.assertIn("rules.clp:1", errors[0]["reason"])

    def test_hostile_decisions_stay_texts(self):
        text = "</script><img src=x onerror=alert(1)>"
        self.agent(f'(deftemplate decision (slot what) (slot why))\n(deffacts here (decision (what "{text}") (why "<b>")))')
        self.run_it()
        page = RunPage(self.out)
        self.assertEqual([(e["text"], e["reason"]) for e in page.events("decision")], [(text, "<b>")])
        self.assertNotIn("onerror", page.text)

    def test_a_world_needs_to_declare_nothing(self):
        page = RunPage(self.play(SOURCE / "scenarios/turtlesim/figures.yaml"))
        self.assertEqual(page.scene, (self.folder / "run/scene.bin").read_bytes())
        self.agent("(defrule hello => (printout t hello crlf))")
        self.run_it()
        page = RunPage(self.out)
        self.assertEqual((page.run["parts"], page.run["events"], page.scene), ([], [], None))


if __name__ == "__main__":
    unittest.main()
