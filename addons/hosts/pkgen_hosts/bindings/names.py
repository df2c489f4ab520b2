"""The step of a motion by the methods of a description."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def step(of: Mapping[str, Any]) -> float:
    """Returns the step of a motion: 0 if adaptive; with an exact method, which allows any, that of
    rows."""
    run = of["run"]
    adaptive = any(m["name"] == run["method"] and m["adaptive"] for m in of["methods"])
    return float(run["step"] or (0 if adaptive else run["every"] or run["until"] / 1000))
