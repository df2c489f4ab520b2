"""A model as a function of its free parameter."""

from __future__ import annotations

import argparse
from functools import lru_cache

import numpy

from pkgen.analysis.linear.system import System, opened, settled
from pkgen.compiler import Compilation
from pkgen.run import named
from pkgen.run.values import Values
from pkgen.system.exits import UsageError
from pkgen.system.near import unknown

ENERGY = "energy"
PARAMETER_STEP = 2e-5  # step of differences by the parameter, in units of the range
# Kinds of statements accepted for equilibria, orbits and return maps.
RUNS = {
    "": ("samples", "noises"),
    "orbit": (),
    "section": ("resetting", "contacts", "frictions", "modes"),
}
KINDS = ("acceleration", "energy")


def asked(text: str) -> tuple[str, str, str]:
    """Returns NAME, FROM and TO of --free."""
    name, equal, ends = text.partition("=")
    low, colon, high = ends.partition(":")
    if not (equal and colon and name.strip() and low.strip() and high.strip()):
        raise UsageError(f"--free {text}: give NAME=FROM:TO, as omega=0.5:3")
    return name.strip(), low.strip(), high.strip()


class Family:
    """The systems of a model at all values of the parameter or input `name`. It is None if the
    energy is free."""

    def __init__(self, options: argparse.Namespace, compilation: Compilation):
        """Raises UsageError, ModelError, BuildError."""
        self.options, self.compilation = options, compilation
        name, *ends = asked(options.free)
        values = Values(compilation)
        known = {}
        for of in (named.parameters(compilation), named.inputs(compilation)):
            known |= {name: of[name][1].unit} if name in of else {}
        self.name: str | None = name if known else None
        units = compilation.equations
        if self.name is None:
            if name != ENERGY:
                names = [*named.parameters(compilation), *named.inputs(compilation), ENERGY]
                raise UsageError(unknown("--free", name, names, "parameter or input"))
            if not (compilation.structure.conservative and units.energy is not None):
                raise UsageError("--free energy: it is not proved that the energy is constant")
            known = {name: "" if compilation.model.dimensionless else "J"}
        self.title, self.unit = name, known[name]
        low, high = (values.value("--free", text, self.unit, name) for text in ends)
        if not low < high:
            raise UsageError(f"--free {options.free}: FROM is to be less than TO")
        self.range, self.width = (low, high), high - low
        kind = "section" if options.section else "orbit" if options.orbit else ""
        self.first = opened(self._at(low), compilation, "pkgen continue", RUNS[kind])
        self.system = lru_cache(maxsize=32)(self._system)
        if not self.first.is_steady() and compilation.structure.autonomous:
            raise UsageError("the inputs depend on time: continuation has constant ones")
        if self.name is not None and not options.section:  # there events may depend on it
            self._influences()

    def _at(self, value: float) -> argparse.Namespace:
        """Returns options with the parameter set."""
        if self.name is None:
            return self.options
        others = [x for x in self.options.set if x.partition("=")[0].strip() != self.name]
        text = [*others, f"{self.name}={float(value)!r}"]
        return argparse.Namespace(**{**vars(self.options), "set": text})

    def _system(self, value: float) -> System:
        return System(self.first.program, settled(self._at(value), self.compilation))

    def own(self) -> float:
        """Returns the value that the parameter has in the model, if it is within the range, else
        the first one."""
        own = argparse.Namespace(**{**vars(self.options), "set": self.options.own_set})
        given = settled(own, self.compilation)
        system = System(self.first.program, given)
        known = named.parameters(self.compilation), named.inputs(self.compilation)
        for of, kind in zip(known, ("parameters", "inputs"), strict=True):
            if self.name in of:
                value = system.given[kind][of[self.name][0]]
                return value if self.range[0] <= value <= self.range[1] else self.range[0]
        raise AssertionError(self.name)

    def beside(self, value: float) -> tuple[float, float]:
        """Returns two values at which differences are taken; both are in the range."""
        by, (low, high) = PARAMETER_STEP * self.width, self.range
        return max(low, value - by), min(high, value + by)

    def _influences(self) -> None:
        """Raises UsageError if the motion is the same for all values. Differences are compared
        instead of the kernel r_p, since other parameters may be formulas of this one."""
        by = numpy.arange(1, 2 * self.first.n + 1)
        at = self.first.begun + numpy.outer([0, 0.31, 0.17], numpy.sin(by)) * (
            1 + abs(self.first.begun)
        )
        low, high = self.range
        t, values = numpy.array([0.0, 0.7, 1.9]), (low, low + 0.618 * self.width, high)
        found = [[self.system(x).kernel(k, t, at) for k in KINDS] for x in values]
        starts = [self.system(x).begun for x in values]
        same = all(
            numpy.array_equal(a, b, equal_nan=True)
            for one in found[1:]
            for a, b in zip(one, found[0], strict=True)
        )
        if same and all((x == starts[0]).all() for x in starts):
            raise UsageError(self.without_influence())

    def without_influence(self) -> str:
        return f"--free {self.title}: the motion does not depend on it"

    def names(self) -> list[str]:
        """Returns the names of coordinates, then of rates and first-order variables."""
        return [x for r in (False, True) for x in named.coordinates(self.compilation, r).names()]

    def state(self, system: System, state: numpy.ndarray) -> dict[str, float]:
        return dict(zip(self.names(), map(float, state[system.used]), strict=True))

    def energy(self, system: System, state: numpy.ndarray) -> float | None:
        found = system.kernel("energy", 0.0, state)
        return float(found[0, 0]) if found.size and not system.by_norm else None
