"""The branches that were found, as objects, as data and as text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from pathlib import Path as FilePath
from typing import Any

from .problem import Path


@dataclass(frozen=True)
class Point:
    """A point of a branch. `values` are eigenvalues of an equilibrium, multipliers of an orbit."""

    value: float
    state: dict[str, float]
    stable: bool
    values: tuple[complex, ...]
    energy: float | None
    period: float | None  # of an orbit
    extents: dict[str, tuple[float, float]]  # of an orbit, by name
    kind: str = ""  # the kind of a special point, or ""
    set: dict[str, float] = field(default_factory=dict)  # parameters and inputs

    @property
    def start(self) -> dict[str, dict[str, float]]:
        """The values of --set and --start with which a run begins here."""
        begins = {name: x for name, x in self.state.items() if name not in self.set}
        return {"set": self.set, "start": begins}

    @property
    def options(self) -> str:
        """The start as text, options of `pkgen run` and `pkgen show`."""
        parts = [f'--{kind} "{k}={x!r}"' for kind, of in self.start.items() for k, x in of.items()]
        return " ".join(parts)

    def record(self, values: str) -> dict[str, Any]:
        found: dict[str, Any] = {"value": self.value, "stable": self.stable}
        found |= {"kind": self.kind} if self.kind else {}
        found |= {"energy": self.energy} if self.energy is not None else {}
        found |= {"period": self.period} if self.period is not None else {}
        found |= {"extents": self.extents} if self.extents else {}
        return {**found, values: [[z.real, z.imag] for z in self.values], **self.start}


@dataclass(frozen=True)
class Branch:
    """A branch of `kind` "equilibria", "orbits" or "returns", whose ends have a reason each."""

    kind: str
    points: tuple[Point, ...]
    ended: tuple[str, str]
    begins: str = ""  # kind of the special point at which it begins, or that it passes through

    @property
    def special(self) -> list[Point]:
        return [point for point in self.points if point.kind]

    @property
    def word(self) -> str:
        return "eigenvalues" if self.kind == "equilibria" else "multipliers"

    def start(self, k: int) -> dict[str, dict[str, float]]:
        """Returns the values of --set and --start of point k."""
        return self.points[k].start


@dataclass(frozen=True)
class Branches:
    """All branches of a model over the parameter `name`."""

    model: str
    name: str
    unit: str
    branches: tuple[Branch, ...]

    @property
    def special(self) -> list[Point]:
        return [point for branch in self.branches for point in branch.special]

    def record(self) -> dict[str, Any]:
        listed = [
            {
                "kind": b.kind,
                "begins": b.begins,
                "ended": list(b.ended),
                "points": [point.record(b.word) for point in b.points],
            }
            for b in self.branches
        ]
        return {"model": self.model, "free": self.name, "unit": self.unit, "branches": listed}

    def text(self) -> str:
        lines = []
        for k, b in enumerate(self.branches, 1):
            values = [point.value for point in b.points]
            begins = f", from a {b.begins}" if b.begins else ""
            lines.append(
                f"{k}: {b.kind}{begins}: {len(values)} points, "
                f"{self.name} from {values[0]:.10g} to {values[-1]:.10g}; {_ranges(b.points)}"
            )
            ended = [why for why in dict.fromkeys(b.ended) if why not in ("the range ends", "")]
            lines += [f"   ends: {why}" for why in ended]
            for point in b.special:
                period = "" if point.period is None else f", period {point.period:.10g}"
                lines.append(f"   {point.kind} at {self.name} = {point.value:.10g}{period}")
                lines.append(f"      {point.options}")
        return "\n".join(lines)

    def plot(self, path: str | FilePath | None = None, show: str | None = None):
        """Draws the branches over the parameter: state `show`, by default the first. Writes a file
        .svg, .png or .pdf, or returns the figure."""
        from .draw import figure, written

        return figure(self, show) if path is None else written(self, FilePath(path), show)


def parts(points: Sequence[Point]) -> list[tuple[bool, int, int]]:
    """Returns the parts of a branch that are stable, or are not, with their first and last points.
    A special point is the end of both parts beside it."""
    of = [(b if a.kind else a).stable for a, b in pairwise(points)] or [points[0].stable]
    found, first = [], 0
    for stable, some in groupby(of):
        last = first + len([*some])
        found.append((stable, first, min(last, len(points) - 1)))
        first = last
    return found


def _ranges(points: Sequence[Point]) -> str:
    found = parts(points)
    if len(found) == 1:
        return "stable" if found[0][0] else "unstable"
    ends = [(points[i].value, points[k].value) for is_stable, i, k in found if is_stable]
    return "stable " + ", ".join(f"from {a:.6g} to {b:.6g}" for a, b in ends)


def made(kind: str, paths: Sequence[Path], sets: tuple[str, ...]) -> list[Branch]:
    """Returns paths as branches."""
    found = []
    for path in paths:
        points = [
            Point(
                value=float(n.value),
                state=n.about["state"],
                stable=path.problem.count_unstable(n.values) == 0,
                values=tuple(complex(z) for z in sorted(n.values, key=abs, reverse=True)),
                energy=n.about.get("energy"),
                period=n.about.get("period"),
                extents=n.about.get("extents", {}),
                kind="" if n is path.origin else n.kind,
                set={**dict.fromkeys(sets, float(n.value)), **n.about.get("set", {})},
            )
            for n in path.nodes
        ]
        begins = path.origin.kind if path.origin else ""
        found.append(Branch(kind, tuple(points), tuple(path.ended), begins))
    return found
