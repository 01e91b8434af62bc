"""The pictures of the documentation are those that their commands draw today; the table of docs/internals/commands.md has the commands.

A picture of another machine may differ a little, because floating point and Mesa do: a small share of its pixels may. `test_short` draws those that take
little time, `test_long` the animated image. The picture of `cxlab view` needs a browser: tests/readers/view_in_browser.py.
"""

import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

from gif import read_gif
from png import read_png

CXLAB = Path(os.environ["CXLAB"])
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
TABLE = re.findall(r"^\| `(docs/pictures/[\w.]+)` \| (.*?) \|$", (SOURCE / "docs/internals/commands.md").read_text(), re.MULTILINE)
MOST = 0.03  # of the pixels; a picture of a game with other decisions has 0.04 or more
SEEN = 40  # in one colour, of 255


def frames(file):
    """The pixels of each frame, three bytes each."""
    if file.suffix == ".gif":
        return [bytes(pixels) for _, pixels in read_gif(file.read_bytes())[2]]
    return [b"".join(read_png(file)[1])]


def share(left, right):
    """The share of pixels that look different in two pictures."""
    assert len(left) == len(right), "another size"
    differ = sum(max(abs(a - b) for a, b in zip(left[at:at + 3], right[at:at + 3])) > SEEN for at in range(0, len(left), 3) if left[at:at + 3] != right[at:at + 3])
    return differ * 3 / len(left)


class Pictures(unittest.TestCase):
    def test_short_each_has_its_commands_and_is_shown(self):
        self.assertEqual(sorted(picture for picture, _ in TABLE), sorted(f"docs/pictures/{file.name}" for file in (SOURCE / "docs/pictures").iterdir()))
        pages = "".join(page.read_text() for page in [SOURCE / "README.md", *(SOURCE / "docs").rglob("*.md")])
        for picture, _ in TABLE:
            self.assertRegex(pages, rf"!\[[^\]]+\]\([./\w]*pictures/{Path(picture).name}\)")

    def test_short_a_picture_that_is_old_is_noticed(self):
        same, moved = bytes(300), bytes(285) + bytes([255]) * 15
        self.assertEqual(share(same, same), 0)
        self.assertGreater(share(same, moved), MOST)

    def draw(self, picture, commands):
        """Plays the commands of a row in a folder of its own, and compares what they draw."""
        with tempfile.TemporaryDirectory(prefix="cxlab-pictures-") as name:
            folder = Path(name)
            (folder / "docs/pictures").mkdir(parents=True)
            (folder / "scenarios").symlink_to(SOURCE / "scenarios")
            environment = os.environ | {"PATH": f"{CXLAB.parent}:{os.environ['PATH']}"}
            for command in re.findall(r"`(cxlab [^`]*)`", commands):
                done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, text=True, timeout=250, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                if "OpenGL" in done.stderr:
                    self.skipTest("no OpenGL here")
                self.assertEqual(done.returncode, 0, command + "\n" + done.stderr)
            self.compare(folder / picture, SOURCE / picture)

    def compare(self, drawn, shown):
        if drawn.read_bytes() == shown.read_bytes():
            return
        drawn_frames, shown_frames = frames(drawn), frames(shown)
        self.assertEqual(len(drawn_frames), len(shown_frames))
        for number in sorted({0, len(shown_frames) // 2, len(shown_frames) - 1}):
            self.assertLess(share(drawn_frames[number], shown_frames[number]), MOST, f"{shown.name} is old: play its commands (docs/internals/commands.md) and look at it")

    def test_short_pictures(self):
        for picture, commands in TABLE:
            if picture.endswith(".png") and "`cxlab render" in commands:
                with self.subTest(picture):
                    self.draw(picture, commands)

    def test_long_films(self):
        for picture, commands in TABLE:
            if picture.endswith(".gif"):
                with self.subTest(picture):
                    self.draw(picture, commands)


if __name__ == "__main__":
    unittest.main()
