"""Equilibria as data and as text, with the names of the model."""

from __future__ import annotations

import math
import re
from collections import Counter

from ...compiler import Compilation
from ...run import named
from .rest import Equilibrium, Mode, Rest

FIXED = ("state", "stable", "verdict", "energy", "frequencies", "continuum", "modes")
AXES = "xyz"
# The word for a motion along a symmetry that no coordinate names: (of several, of a single one).
TURNS = {"plane": ("turn", "rotation"), "space": ("turn", "precession"), "body": ("spin", "spin")}


def _words(compilation: Compilation) -> list[str]:
    """Returns for each angle the word that its author has for it, or "". In `coord phi, theta [rad]
    # precession, nutation` the comment has such words, one for each coordinate."""
    items = compilation.equations.coordinates
    count, seen, words = Counter(x.description for x in items), Counter[str](), []
    for item in items:
        said = item.description
        parts = re.fullmatch(r"[a-z]+(, [a-z]+)*", said) and said.split(", ")
        one = parts and len(parts) == count[said] and item.unit == "rad"
        words.append(parts[seen[said]] if one else "")
        seen[said] += 1
    return words


def _steady(compilation: Compilation, rest: Rest, at: Equilibrium) -> dict[str, float]:
    """Returns the constant rates by name."""
    words, names = _words(compilation), compilation.equations.coordinates
    found = {words[i] or f"{names[i].name}'": at.v[i] for i in rest.cyclic}
    bodies = bool(compilation.equations.attitudes)
    kinds = Counter("space" if s.name == "plane" and bodies else s.name for s in rest.moving)
    for symmetry, speed in zip(rest.moving, at.speeds, strict=True):
        name, i = symmetry.name, symmetry.index
        if name == "q":
            found[words[i] or f"{names[i].name}'"] = speed
            continue
        name = "space" if name == "plane" and bodies else name
        several, single = TURNS[name]
        key = single if kinds[name] == 1 else several if name == "plane" else f"{several}.{AXES[i]}"
        while key in found:
            key += "'"
        found[key] = speed
    return found


def _small(compilation: Compilation, at: Equilibrium, steady: dict[str, float]) -> dict[str, float]:
    """Returns the frequencies of modes that have a name: that of the coordinate that moves most."""
    words, found = _words(compilation), {}
    modes = [m for m in at.modes if m.frequency > 0]
    for mode in modes:
        sizes = [math.hypot(a, b) for a, b in zip(mode.re, mode.im, strict=True)][: len(words)]
        word = words[sizes.index(max(sizes))] if sizes and max(sizes) else ""
        if word and word not in steady:
            found.setdefault(word, mode.frequency)
    if not found and len(modes) == 1 and "precession" in steady:
        found["nutation"] = modes[0].frequency
    return found


def _mode(mode: Mode, names: list[str]) -> dict[str, object]:
    shape = {name: [a, b] if b else a for name, a, b in zip(names, mode.re, mode.im, strict=False)}
    return {"growth": mode.growth, "frequency": mode.frequency, "shape": shape}


def record(compilation: Compilation, rest: Rest) -> dict[str, object]:
    """Returns the equilibria as data for JSON: `equilibria` and the region that was searched."""
    q = list(named.coordinates(compilation).names())
    v = list(named.coordinates(compilation, rates=True).names())
    unknowns = [*q, *v[len(q) :]]
    found = []
    for at in rest.equilibria:
        steady = _steady(compilation, rest, at)
        fixed = {
            "state": dict(zip((*q, *v), (*at.q[: len(q)], *at.v), strict=True)),
            "stable": at.stable,
            "verdict": at.verdict,
            "energy": at.energy,
            "frequencies": [m.frequency for m in at.modes if m.frequency > 0],
            "continuum": at.nullity,
            "modes": [_mode(mode, unknowns) for mode in at.modes],
        }
        words = {**steady, **_small(compilation, at, steady)}
        found.append(fixed | {k: x for k, x in words.items() if k not in FIXED})
    region = {
        name: {"from": m - b, "to": m + b}
        for name, m, b in zip(unknowns, rest.middle, rest.box, strict=False)
    }
    return {
        "model": compilation.model.name,
        "status": rest.status,
        "equilibria": found,
        "more": rest.more,
        "region": region,
    }


def text(found: dict[str, object]) -> str:
    """Returns the equilibria in words, an equilibrium a paragraph."""
    listed: list[dict] = found["equilibria"]  # type: ignore[assignment]
    if not listed:
        return "no equilibrium was found"
    lines = []
    for k, at in enumerate(listed, 1):
        lines.append(f"{k}: {at['verdict']}, energy {at['energy']:.10g}")
        lines.append("   " + ", ".join(f"{name} = {x:.10g}" for name, x in at["state"].items()))
        steady = [f"{name} {x:.10g}" for name, x in at.items() if name not in FIXED]
        lines += ["   " + ", ".join(steady)] if steady else []
        for mode in at["modes"]:
            growth, frequency = mode["growth"], mode["frequency"]
            said = [f"frequency {frequency:.10g}"] if frequency else []
            way = "grows" if growth > 0 else "decays"
            said += [f"{way} at {abs(growth):.10g}"] if growth else []
            lines.append("   mode: " + (", ".join(said) or "neutral"))
    return "\n".join(lines)
