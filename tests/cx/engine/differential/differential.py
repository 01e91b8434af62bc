"""Plays the same programs in cxlab's engine and in CLIPS of clipspy. Both must print the same firings, facts, activations and
messages of the program, and the same errors. python3 -m unittest differential

The outputs of clipspy for the generated programs are kept as digests (`differential.said.txt`), so that they are compared
everywhere. Where clipspy is installed (pip install clipspy==1.0.6), both play the programs and a difference is shown as text.
All rules that come with cxlab are then compared, too.

  differential.py update    asks clipspy again
"""

import difflib
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import programs

HERE = pathlib.Path(__file__).parent
SAID = HERE / "differential.said.txt"
try:
    import clips
except ImportError:
    clips = None


def text_of(constructs, commands):
    return "\n".join(constructs) + "\n%%\n" + "\n".join(commands) + "\n"


def played_by_clipspy(constructs, commands):
    class Listener(clips.Router):
        def __init__(self):
            super().__init__("listener", 50)
            self.printed, self.errors = [], []

        def query(self, name):
            return name in ("stdout", "stderr", "stdwrn", "t", "debug", "info", "warn", "error", "log")  # all names of CX

        def write(self, name, message):
            if name in ("stdout", "t", "stderr"):
                (self.errors if name == "stderr" else self.printed).append(message)

    environment = clips.Environment()
    listener = Listener()
    environment.add_router(listener)
    with tempfile.NamedTemporaryFile("w", suffix=".clp") as file:
        file.write("\n".join(constructs) + "\n")
        file.flush()
        try:
            environment.load(file.name)
        except clips.CLIPSError:
            pass
    for command in commands:
        try:
            if command.startswith("run "):
                environment.run(int(command[4:]))
            else:
                environment.eval(command)
        except (clips.CLIPSError, Exception):
            pass
    errors = [line for line in "".join(listener.errors).split("\n") if line.startswith("[")]
    return {"printed": "".join(listener.printed), "errors": errors}


def comparable(played):
    """Without what differs by design (docs/reference/ros2-differences.md): where an error is stands in front of it here."""
    errors = [re.sub(r"^(\[\w+\]) \S*\.clp, Line \d+: ?", r"\1 ", line).strip() for line in played["errors"]]
    printed = played["printed"].replace("rule firing limit reached\n", "")
    return printed + "\n--\n" + "\n".join(e for e in errors if not e.startswith("[PRCCODE4] WARNING"))


def digest(played):
    return hashlib.sha256(comparable(played).encode()).hexdigest()[:16]


def said():
    return dict(line.split() for line in SAID.read_text().splitlines())


class Differential(unittest.TestCase):
    maxDiff = None

    def played(self, every):
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for i, (_, constructs, commands) in enumerate(every):
                paths.append(pathlib.Path(folder) / f"{i}.clp")
                paths[-1].write_text(text_of(constructs, commands))
            done = subprocess.run([os.environ["CLIPS_PROGRAMS"], *map(str, paths)], capture_output=True, text=True, check=True)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def compare(self, every):
        """Returns how many rules fired."""
        fired = 0
        for (name, constructs, commands), ours in zip(every, self.played(every), strict=True):
            fired += ours["printed"].count("FIRE")
            with self.subTest(name):
                self.assertMultiLineEqual(comparable(played_by_clipspy(constructs, commands)), comparable(ours))
        return fired

    def test_generated(self):
        every = list(programs.generated())
        self.assertGreaterEqual(len(every), 200)
        if clips:
            self.assertGreater(self.compare(every), 800)
        known = said()
        self.assertEqual([name for name, _, _ in every], list(known), "differential.py update")
        for (name, _, _), ours in zip(every, self.played(every), strict=True):
            with self.subTest(name):
                self.assertEqual(digest(ours), known[name], "clipspy said something else; install it to see what")

    @unittest.skipIf(clips is None, "no clipspy")
    def test_shipped(self):
        self.assertGreater(self.compare(list(programs.shipped(os.environ["CXLAB"]))), 500)


def update():
    SAID.write_text("".join(f"{name} {digest(played_by_clipspy(constructs, commands))}\n" for name, constructs, commands in programs.generated()))


if __name__ == "__main__" and sys.argv[1:] == ["update"]:
    update()
