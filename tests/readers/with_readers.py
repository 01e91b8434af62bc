"""Runs tests with the Python that has the readers: CXLAB_READERS=DIR with_readers.py MODULE..."""

import os
import pathlib
import sys

folder = pathlib.Path(os.environ["CXLAB_READERS"])
python = folder / "venv/bin/python"
for part in (folder / "venv/made_from", folder / "lcov/made_from"):
    if not part.is_file():
        sys.exit(f"{part.parent} is missing or not whole: ./dev readers fetches the readers and runs these tests")
os.execv(python, [python, "-m", "unittest", *sys.argv[1:]])
