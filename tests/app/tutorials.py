"""The commands of the tutorials, played one after the other: each prints what the page shows. tests/app/guides.py plays those of the guides."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from importlib.util import find_spec
from pathlib import Path

CXLAB = Path(os.environ["CXLAB"])
PACKAGE = CXLAB.parent / "python/cxlab"
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])


def steps(page):
    """The commands of a page, each with the lines below it. One that ends with <<END includes the lines up to END."""
    for block in re.findall(r"^```\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL):
        for command in re.split(r"^\$ ", block.replace("\\\n", ""), flags=re.MULTILINE)[1:]:
            line, _, output = command.partition("\n")
            if line.endswith(" <<END"):
                document, _, output = output.partition("END\n")
                line += f"\n{document}END\n"
            yield line, output.splitlines()


def pattern_of(lines):
    """What an output must match: `...` stands for anything, and blanks for any blanks."""
    return r"\s*".join(".*?".join(r"\s+".join(map(re.escape, part.split())) for part in line.split("...")) for line in lines)


class Pages(unittest.TestCase):
    def play(self, name, folder_on_page, **variables):
        """Plays a page in a folder of its own, which stands for the one that the page names. Returns it."""
        folder = Path(tempfile.mkdtemp(prefix="cxlab-tutorial-"))
        self.addCleanup(shutil.rmtree, folder)
        environment = {**os.environ, "PATH": f"{CXLAB.parent}:{os.environ['PATH']}", **variables}
        played = list(steps(SOURCE / "docs" / name))
        self.assertTrue(any(shown for _, shown in played), "the page shows what its commands print")
        for command, shown in played:
            done = subprocess.run(["bash", "-c", command.replace(folder_on_page, str(folder))], cwd=SOURCE, env=environment, text=True,
                                  timeout=120, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, command + "\n" + done.stderr)
            if shown:
                self.assertRegex(done.stdout.replace(str(folder), folder_on_page), re.compile(pattern_of(shown), re.DOTALL), command)
        return folder


class Tutorials(Pages):
    def test_first_game(self):
        self.play("tutorials/first-game.md", "/tmp/first")

    def test_your_first_agent(self):
        self.play("tutorials/your-first-agent.md", "/tmp/my")

    def test_find_a_bug(self):
        self.play("tutorials/find-a-bug.md", "/tmp/bugs")

    def test_compare_two_strategies(self):
        folder = self.play("tutorials/compare-two-strategies.md", "/tmp/compare")
        self.assertEqual((folder / "strategies.svg").read_text(), (SOURCE / "docs/pictures/strategies.svg").read_text(), "the picture is old")

    def test_bag_to_story(self):
        self.play("tutorials/bag-to-story.md", "/tmp/floor")

    @unittest.skipUnless(PACKAGE.is_dir() and find_spec("numpy"), "needs the package of Python, and NumPy")
    def test_train_a_policy(self):
        self.play("tutorials/train-a-policy.md", "/tmp/learn", PYTHONPATH=str(PACKAGE.parent),
                  PATH=f"{CXLAB.parent}:{Path(sys.executable).parent}:{os.environ['PATH']}")


if __name__ == "__main__":
    unittest.main()
