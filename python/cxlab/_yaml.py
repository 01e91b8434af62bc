"""Values as texts of YAML that C++ reads."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from cxlab.errors import UsageError


def assignments_of(
    settings: Mapping[str, Any] | None, *, seed: int | None = None, tier: str | None = None
) -> list[tuple[str, str]]:
    """Overrides of a scenario as PATH=VALUE, each with the argument that errors name."""
    if not isinstance(settings, Mapping | None):
        raise UsageError(f'found a {type(settings).__name__}, expected a dict as {{"world.team": "MAGENTA"}}', "set")
    assignments = [(f"{path}={yaml_text(value, plain=True)}", f"set {path}") for path, value in (settings or {}).items()]
    if seed is not None:
        assignments.append((f"seed={seed}", "seed"))
    if tier is not None:
        assignments.append((f"tier={tier}", "tier"))
    return assignments


def yaml_text(value: Any, *, plain: bool = False) -> str:
    """The value on one line. `plain`: a text stays as it is, as on a command line."""
    if hasattr(value, "tolist"):  # arrays and numbers of NumPy
        value = value.tolist()
    if plain and isinstance(value, str):
        return value
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, (int, float, str)):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(str(key))}: {yaml_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple, bytes, bytearray)):
        return "[" + ", ".join(yaml_text(item) for item in value) + "]"
    raise UsageError(f"found a value of type {type(value).__name__}, expected numbers, texts, dicts and lists")
