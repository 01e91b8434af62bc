"""Loads libraries that this Python and the wheel both have.

The wheel brings libcrypto and SQLite of Debian 12. Where this Python has newer ones of the same names, they must be loaded first
and serve both: the other way round its own modules would miss symbols. The modules in C load them; the
packages around them would take twice as long.
"""

from __future__ import annotations

import contextlib
from importlib import import_module

for _module in ("_ssl", "_sqlite3"):
    with contextlib.suppress(ImportError):
        import_module(_module)
