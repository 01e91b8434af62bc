"""The Python on the pages that needs no package beyond NumPy runs, and prints what the block below it shows; `...` stands for anything."""

import contextlib
import importlib.util
import io
import os
import re
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\n```\n(.*?)^```\n)?", re.MULTILINE | re.DOTALL)


def blocks(page):
    """(code, what it prints or "") of each block of Python."""
    return BLOCK.findall((SOURCE / page).read_text())


class Pages(unittest.TestCase):
    def play(self, found):
        self.addCleanup(os.chdir, os.getcwd())
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        os.chdir(folder.name)
        names = {}
        for code, shown in found:
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile(code, "page", "exec"), names)
            pattern = r"\s*".join(".*?".join(map(re.escape, line.strip().split("..."))) for line in shown.splitlines())
            self.assertRegex(printed.getvalue(), re.compile(pattern, re.DOTALL), code)

    def test_python(self):
        found = blocks("docs/reference/python.md")
        self.assertTrue(any(shown for _, shown in found))
        self.play(found)

    def test_readme_begins_as_that_page(self):
        self.assertEqual(blocks("README.md")[0][0], blocks("docs/reference/python.md")[0][0])

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "no NumPy")
    def test_learning(self):
        self.play(blocks("docs/reference/learning.md")[:1])


if __name__ == "__main__":
    unittest.main()
