"""The parts of a description that hosts of other languages read: names, units, by index."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pkgen.system.exits import UsageError

TABLES = ("parameters", "inputs", "coordinates", "rates", "outputs", "events")


def whole(description: Mapping[str, Any]) -> None:
    if not description["whole"]:
        raise UsageError("the families are too long to be named one by one: take a smaller --size")


def tables(of: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Returns names, units and descriptions, in the order of indices."""
    rates = {
        c["index"]: {**c, "name": c["rate"], "unit": c["rate_unit"]} for c in of["coordinates"]
    }
    rates |= {s["index"]: s for s in of["states"]}
    for r in of["rotations"]:
        rates |= {
            k: {"name": n, "unit": r["rate_unit"], "description": r["description"]}
            for k, n in zip(r["rate_indices"], r["rates"], strict=True)
        }
    found = {kind: [q for q in of[kind] if not q.get("hidden")] for kind in TABLES if kind in of}
    found["rates"] = [rates[k] for k in sorted(rates)]
    return {kind: found[kind] for kind in TABLES}


def step(of: Mapping[str, Any]) -> float:
    """Returns the step of a motion: 0 if adaptive; with an exact method, which allows any, that of
    rows."""
    run = of["run"]
    adaptive = any(m["name"] == run["method"] and m["adaptive"] for m in of["methods"])
    return float(run["step"] or (0 if adaptive else run["every"] or run["until"] / 1000))
