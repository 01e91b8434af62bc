"""Every example of the documentation and every shipped scenario loads, runs and ends without a warning or an error."""

import json
import os
import re
import shlex
import subprocess
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])

# Commands that no page shows.
MORE = (
    "cxlab run scenarios/rcll/game.yaml --tier timed",
    "cxlab env scenarios/rcll/agent/params/agent.yaml --with rcll --param rcll.production_s=60 --until 200",
    "cxlab env scenarios/rcll/planning_agent/params/agent.yaml --with rcll --with pddl_manager --param rcll.production_s=60 --until 200",
    "cxlab run scenarios/rcll/external.yaml --tier timed",
    "cxlab env scenarios/rcll/agent/params/external.yaml --with rcll --param rcll.production_s=60 --until 200",
    "cxlab run scenarios/rcll/rl.yaml --tier timed",
    "cxlab env scenarios/rcll/agent/params/trainer.yaml --with rcll --param rcll.production_s=60 --until 200",
    "cxlab run scenarios/turtlesim/goal.yaml",
    "cxlab run scenarios/turtlesim/hypotheses.yaml",
    "cxlab env scenarios/turtlesim/agents/params/figures.yaml --with turtlesim",
    "cxlab env scenarios/turtlesim/agents/params/hypotheses.yaml --with turtlesim",
    "cxlab env docs/examples/bag/greeter.yaml --with turtlesim --stimuli docs/examples/bag/visitors.yaml --until 10",
    "cxlab env docs/examples/blocksworld/params/helpers.yaml --with pddl_manager",
    "cxlab env docs/templates/agent/agent.yaml --package my_agent=docs/templates/agent --until 5",
    "cxlab run docs/templates/agent/scenario.yaml",
    "cxlab env docs/templates/agent_rcll/agent.yaml --package my_agent=docs/templates/agent_rcll --with rcll --until 60",
    "cxlab run docs/templates/agent_rcll/scenario.yaml --tier timed",
)
# An example may be there to show a warning: its file, and what it warns of.
OVERRIDES = "overrides.clp:2: deftemplate 'pddl-action' is defined already in "
UNANSWERED = "on the topic choices/made: the rules choose by themselves"
SHOWN = {"scenarios/rcll/external.yaml": UNANSWERED, "scenarios/rcll/agent/params/external.yaml": UNANSWERED,
         "scenarios/rcll/rl.yaml": "nobody answer", "scenarios/rcll/agent/params/trainer.yaml": UNANSWERED + "|cx_rl_node/get_status not available",
         "scenarios/turtlesim/boundary_late.yaml": "service turtle1/teleport_absolute not available, abort request.",
         "docs/examples/blocksworld/params/helpers.yaml": OVERRIDES, "docs/examples/blocksworld/helpers.yaml": OVERRIDES}
# Another planner's program has to be installed.
NEEDS_MORE = r"pddl_manager\.(command|engine|python)"
# Needs a library or a program that is built first: tests/app/own_plugins.py, tests of the template.
BUILT_FIRST = ("docs/examples/own_plugins/", "docs/examples/own_seat/", "docs/examples/own_world/", "docs/templates/plugin/")


def on_pages():
    """The commands in the pages that run a file of the project."""
    commands = set()
    for page in [SOURCE / "README.md", *sorted((SOURCE / "docs").rglob("*.md"))]:
        text = page.read_text().replace("\\\n", " ")
        for found in re.findall(r"(?:^(?:\$ )?|`|\./dev )(cxlab (?:env|run) [^`\n#]*)", text, re.MULTILINE):
            if re.search(r"--out|--video|[|&]", found):
                continue
            words = [word for word in shlex.split(found) if word != "--quiet"]
            if len(words) > 2 and not words[2].startswith("/") and (SOURCE / words[2]).is_file() and not re.search(NEEDS_MORE, found):
                commands.add(shlex.join(words))
    return commands


def examples():
    """All shipped configurations and scenarios."""
    files = set()
    for folder in ("docs/examples", "docs/templates", "scenarios"):
        for file in (SOURCE / folder).rglob("*.yaml"):
            if re.search(r"^schema: |^ +environments: ", file.read_text(), re.MULTILINE):
                files.add(str(file.relative_to(SOURCE)))
    return {file for file in files if not file.startswith(BUILT_FIRST)}


def run(command):
    words = command.split()
    strict = ["--strict-cx"] if words[1] == "env" else []
    done = subprocess.run([CXLAB, *shlex.split(command)[1:], *strict, "--out", "none", "--json"], cwd=SOURCE, text=True, timeout=100,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    return command, done


class Examples(unittest.TestCase):
    def test_each_ends_without_a_complaint(self):
        commands = [c for c in sorted(on_pages() | set(MORE)) if not re.search("--snapshot|--set|game.yaml$", c)]
        with ThreadPoolExecutor(max_workers=2) as pool:
            for command, done in pool.map(run, commands):
                with self.subTest(command):
                    complaints = [line for line in done.stderr.splitlines() if re.search(r"\[(warn|error)\]|^(warning|error):", line)]
                    shown = SHOWN.get(shlex.split(command)[2])
                    if shown:
                        self.assertTrue(complaints, "it is there to show one")
                        complaints = [line for line in complaints if not re.search(shown, line)]
                    self.assertEqual((done.returncode, complaints), (0, []))
                    result = json.loads(done.stdout)
                    self.assertEqual(result["rule_errors"], [])
                    self.assertIn(result["status"], ("completed", "stopped"))

    def test_none_is_left_out(self):
        self.assertEqual(examples() - {shlex.split(command)[2] for command in on_pages() | set(MORE)}, set())
        self.assertGreater(len(on_pages()), 15, "the pages are read")


if __name__ == "__main__":
    unittest.main()
