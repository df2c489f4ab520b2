"""Chooses the default step of integration in a binding."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def step(of: Mapping[str, Any]) -> float:
    """Returns the step of the model's run, in s. If it has none: 0 for an adaptive method, which
    chooses its steps; the time between rows for an exact method, whose steps have any length."""
    run = of["run"]
    adaptive = any(m["name"] == run["method"] and m["adaptive"] for m in of["methods"])
    return float(run["step"] or (0 if adaptive else run["every"] or run["until"] / 1000))
