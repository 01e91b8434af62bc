"""Runs tests with the Python that has the readers, or torch: CXLAB_READERS=DIR with_readers.py [--torch] MODULE..."""

import os
import pathlib
import sys

folder = pathlib.Path(os.environ["CXLAB_READERS"])
torch = sys.argv[1] == "--torch"
command, parts = ("./dev readers --torch", ["torch"]) if torch else ("./dev readers", ["venv", "lcov"])
for part in parts:
    if not (folder / part / "made_from").is_file():
        sys.exit(f"{folder / part} is missing or not whole: {command} fetches the readers and runs these tests")
python = folder / parts[0] / "bin/python"
os.execv(python, [python, "-m", "unittest", *sys.argv[1 + torch :]])
