"""Turtlesim and the league beside a configuration of the CX, and pictures of turtles, as a user calls them."""

import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from png import read_png

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
TURTLES = SOURCE / "scenarios/turtlesim"
BOUNDARY = TURTLES / "agents/params/boundary.yaml"
HELLO = SOURCE / "docs/examples/hello/hello.yaml"


class Turtlesim(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="cxlab-turtles-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def cxlab(self, *arguments, expect=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=60)
        self.assertEqual(done.returncode, expect, f"cxlab {arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def test_a_configuration_runs_with_turtlesim(self):
        stimuli = self.folder / "stimuli.yaml"
        stimuli.write_text("- {at: 1, publish: /turtle1/cmd_vel, type: geometry_msgs/msg/Twist, data: {linear: {x: 5.0}}}\n")
        done = self.cxlab("env", BOUNDARY, "--with", "turtlesim", "--param", "turtlesim.background_r=1", "--stimuli", stimuli, "--until", 5, "--out", "run")
        self.assertIn("turtle1 is home again", done.stderr)
        self.assertNotRegex(done.stderr, r"\[(warn|error)\]")
        result = json.loads((self.folder / "run/result.json").read_text())
        self.assertEqual(result["turtles"][0]["teleports"], 1)
        self.assertEqual(result["ticks"], 314)  # of 16 ms, one at 0
        self.assertIn("physics: the same", self.cxlab("replay", "run").stdout)
        self.cxlab("render", "run", "--at", 3, "--out", "canvas.png", "--size", "500x500")
        width, rows = read_png(self.folder / "canvas.png")
        self.assertEqual(width, 500)
        self.assertEqual(tuple(rows[10][30:33]), (1, 86, 255))
        middle = rows[249][3 * 350:3 * 350 + 3]
        self.assertEqual(tuple(middle), (179, 184, 255), "ink where the turtle went")

    def test_the_league_stands_beside_a_configuration(self):
        result = json.loads(self.cxlab("env", HELLO, "--with", "rcll", "--with", "turtlesim", "--param", "rcll.robots=1", "--until", 2,
                                       "--out", "run", "--quiet", "--json").stdout)
        self.assertEqual([robot["name"] for robot in result["robots"]], ["robot1"])
        self.assertIn("node/turtlesim", result["stream_hashes"])
        self.assertIn("node/factory", result["stream_hashes"])

    def test_unknown_nodes_and_settings_are_reported(self):
        done = self.cxlab("env", HELLO, "--with", "turtle", expect=2)
        for known in ("turtle'", "rcll", "turtlesim"):
            self.assertIn(known, done.stderr)
        self.cxlab("env", HELLO, "--with", "turtlesim", "--with", "turtlesim", expect=2)
        done = self.cxlab("env", HELLO, "--with", "turtlesim", "--param", "turtlesim.backgruond_r=1", expect=3)
        self.assertIn("did you mean 'background_r'", done.stderr)
        done = self.cxlab("render", TURTLES / "boundary.yaml", "--at", 1, "--out", "x.png", "--camera", "field", expect=3)
        self.assertIn("expected: canvas", done.stderr)

    def test_snapshots_are_in_the_page(self):
        self.cxlab("run", TURTLES / "figures.yaml", "--snapshot", "10,20", "--out", "run", "--quiet")
        self.assertEqual(sorted(p.name for p in (self.folder / "run/snapshots").iterdir()), ["0010.00-canvas.png", "0020.00-canvas.png"])
        page = (self.folder / "run/index.html").read_text()
        self.assertEqual(page.count("data:image/png;base64,"), 2)
        self.assertIn("<td>turtle1 (killed)<td>", page)

    def test_transforms_are_posted_where_they_are_asked_for(self):
        folder = SOURCE / "docs/examples/tf2_pose_tracker"
        command = ["env", folder / "turtle.yaml", "--package", f"example={folder}", "--with", "turtlesim", "--stimuli", folder / "stimuli.yaml", "--until", 4, "--out"]
        said = self.cxlab(*command, "run", "--param", "turtlesim.transforms=true").stderr
        self.assertEqual(re.findall(r"\[watcher\] (.*)", said),
                         ["turtle1 is at (5.54 5.54), turned by 0.00, at 1.0 s"] + [f"turtle1 is at (7.21 6.46), turned by 0.99, at {t}.0 s" for t in (2, 3, 4)])
        self.assertIn("rules: the same", self.cxlab("replay", "run").stdout)
        self.assertIn('TF lookup failed: "world" passed to lookupTransform argument target_frame does not exist', self.cxlab(*command, "none").stderr)

    def test_the_league_posts_its_transforms_too(self):
        (self.folder / "agent.yaml").write_text((SOURCE / "docs/examples/tf2_pose_tracker/turtle.yaml").read_text())
        (self.folder / "turtle.clp").write_text("""(defrule track => (tf2-start-periodic-lookup "C-BS" "robot1" 1.0) (tf2-start-periodic-lookup "map" "robot1" 1.0)
  (tf2-start-periodic-lookup "map" "C-BS" 1.0))
(defrule stop (executive-finalize) (tf2-tracked-pose (timer ?timer)) => (tf2-stop-periodic-lookup ?timer))
(defrule compare (tf2-tracked-pose (parent "map") (child "robot1") (translation ?rx ?ry ?)) (tf2-tracked-pose (parent "map") (child "C-BS") (translation ?sx ?sy ?))
  (tf2-tracked-pose (parent "C-BS") (translation ?x ?y ?))
  => (format t "robot %.2f %.2f, far %.4f %.4f%n" ?rx ?ry (sqrt (+ (** ?x 2) (** ?y 2))) (sqrt (+ (** (- ?rx ?sx) 2) (** (- ?ry ?sy) 2)))))
""")
        for tier in ("timed", "physics"):
            scenario = self.folder / "game.yaml"
            scenario.write_text(f"schema: 1\nworld: {{kind: rcll, transforms: true}}\ntier: {tier}\nagents: [{{config: agent.yaml, packages: {{example: .}}}}]\n")
            done = self.cxlab("run", scenario, "--until", 1.5, "--out", "none")
            self.assertNotRegex(done.stderr, r"\[(warn|error)\]")
            x, y, far, apart = re.search(r"robot (\S+) (\S+), far (\S+) (\S+)", done.stderr).groups()
            self.assertEqual((x, y, far), ("4.50", "0.50", apart))

    def test_a_canvas_beside_another_world_is_drawn(self):
        scenario = self.folder / "both.yaml"
        scenario.write_text("schema: 1\nworld: {kind: rcll, production_s: 20, overtime_s: 0}\ntier: timed\nservers:\n  - {node: turtlesim, background_r: 2}\n"
                            "  - {node: turtlesim, namespace: /second, background_r: 3}\n")
        self.cxlab("run", scenario, "--snapshot", "1", "--until", 2, "--out", "run", "--quiet")
        self.assertEqual(sorted(p.name for p in (self.folder / "run/snapshots").iterdir()), ["0001.00-canvas.png", "0001.00-canvas2.png", "0001.00-field.png", "0001.00-top.png"])
        self.cxlab("render", scenario, "--at", 1, "--camera", "canvas2", "--out", "second.png", "--size", "200x200")
        width, rows = read_png(self.folder / "second.png")
        self.assertEqual((width, tuple(rows[10][300:303])), (200, (3, 86, 255)))


if __name__ == "__main__":
    unittest.main()
