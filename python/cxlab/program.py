"""Where the program `cxlab` is."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from .errors import MachineError

__all__ = ["main", "program"]


def program() -> Path:
    """The program of the wheel; else $CXLAB, that of the build which this package is part of, or one in PATH."""
    package = Path(os.path.abspath(__file__)).parent
    places = [package / "bin/cxlab", os.environ.get("CXLAB"), package.parent.parent / "cxlab", shutil.which("cxlab")]
    for place in places:
        if place and os.access(place, os.X_OK) and os.path.isfile(place):
            return Path(place)
    raise MachineError("found no program cxlab; install the wheel, or set CXLAB to the program of a build")


def main() -> None:
    """The command `cxlab` of the wheel: becomes the program."""
    path = os.fspath(program())
    os.execv(path, [path, *sys.argv[1:]])
