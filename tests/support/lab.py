"""A folder with a scenario of its own, and the program run on it."""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

CXLAB = os.environ["CXLAB"]
SOURCE = pathlib.Path(os.environ["CXLAB_SOURCE_DIR"])
# For tests that draw few pictures: Mesa compiles its shaders at each start, which takes as long as thirty pictures. This driver
# of Mesa compiles nothing.
FEW_PICTURES = {"GALLIUM_DRIVER": "softpipe"}

CONFIG = """/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "ros_msgs", "files"]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 10}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["rules"], load: ["rules.clp"]}
"""
SCENARIO = """schema: 1
duration_s: 2
packages: {rules: rules}
agents:
  - config: agent.yaml
"""
GAME = """schema: 1
world: {kind: rcll, production_s: 20, overtime_s: 0}
tier: timed
"""


def stopped_run(test, *arguments, out, cwd="."):
    """A run in the background, played with these arguments, that waits for commands before its first tick. It is killed when the test ends."""
    run = subprocess.Popen([CXLAB, "run", *map(str, arguments), "--break", "--out", out, "--quiet"], cwd=cwd, env=getattr(test, "environment", None),
                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    test.addCleanup(run.wait)
    test.addCleanup(run.kill)
    while not (pathlib.Path(cwd) / out / "control.sock").exists():
        test.assertIsNone(run.poll())
        time.sleep(0.02)
    return run


class Lab(unittest.TestCase):
    """Each test has a fresh folder; runs go to `out` in it."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-app-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.out = self.folder / "out"

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def agent(self, rules, scenario=SCENARIO, **files):
        """A scenario whose agent has these rules; `files` are further ones in the package of rules."""
        self.write("agent.yaml", CONFIG)
        self.write("rules/rules.clp", rules)
        for name, text in files.items():
            self.write(f"rules/{name}.clp", text)
        return self.write("scenario.yaml", scenario)

    def command(self, *arguments):
        return [CXLAB, "run", "scenario.yaml", "--quiet", *map(str, arguments)]

    def run_it(self, *arguments, out=True, **options):
        where = ["--out", self.out] if out else []
        return subprocess.run(self.command(*where, *arguments), cwd=self.folder, text=True, timeout=60,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)

    def result(self):
        return json.loads((self.out / "result.json").read_text())

    def records(self):
        """The records of journal.jsonl, each line of which must be whole."""
        text = (self.out / "journal.jsonl").read_text()
        self.assertTrue(text == "" or text.endswith("\n"), "the last line is whole")
        return [json.loads(line) for line in text.splitlines()]

    def fails(self, code, *texts, arguments=(), **options):
        """The program ends with this exit code and says all of these texts on stderr."""
        done = self.run_it(*arguments, **options)
        self.assertEqual(done.returncode, code, done.stderr)
        for text in texts:
            self.assertIn(text, done.stderr)
        return done
