"""Values, names and assignments in options of the command line, for a given model. Every error is a
UsageError."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable

from . import named
from .compiler import Compilation
from .exits import UsageError
from .front import options_text
from .front.options_text import OptionError
from .middle.quantities import indexed
from .scene_model import hidden
from .simulate import Shown

# What pkgen has, and no model.
_OF_PKGEN = frozenset(("method", "kernel", "diagnostic"))
_NEXT = re.compile(r",\s*(?=[A-Za-z_]\w*(?:\[[^\]]*\])?'*\s*=)")


class Values:
    """Values of options for one model: its units, its sizes, its names."""

    def __init__(self, compilation: Compilation):
        self.compilation = compilation
        self.model = compilation.model
        self.coordinates = named.coordinates(compilation)
        self.rates = named.coordinates(compilation, rates=True)
        self.sizes = {size.name: size.value for size in self.model.sizes}
        self.time = "" if self.model.dimensionless else "s"

    def value(self, option: str, text: str, unit: str, name: str) -> float:
        try:
            found = options_text.quantity(
                text,
                unit,
                dimensionless=self.model.dimensionless,
                values=self.sizes,
                name=name,
            )
        except OptionError as error:
            given = text if option == f"--{name}" else f"{name}={text}"
            raise UsageError(f"{option} {given}: {error.text()}") from None
        if not math.isfinite(found):
            raise UsageError(f"{option} {text}: {name} must be finite")
        return float(found)

    def positive(self, option: str, text: str | None, unit: str) -> float | None:
        if text is None:
            return None
        name = option.removeprefix("--")
        found = self.value(option, text, unit, name)
        if not found > 0:
            raise UsageError(f"{option} {text}: {name} must be positive")
        return found

    def assigned(
        self,
        option: str,
        assignments: list[tuple[str, str]],
        known: named.Named,
        others: named.Named,
    ) -> tuple[tuple[int, float], ...]:
        """Those of the assignments whose left side is in `known`, as (index, value)."""
        found = []
        for left, text in assignments:
            name = self.flat_name(option, left)
            if name in known:
                index, quantity = known[name]
                found.append((index, self.value(option, text, quantity.unit, name)))
            elif name not in others:
                raise UsageError(unknown(option, name, [*known, *others], "parameter or input"))
        return tuple(found)

    def started(
        self, assignments: list[tuple[str, str]], order: int
    ) -> tuple[tuple[int, float], ...]:
        """The starts of coordinates (order 0) or of their rates (order 1)."""
        found = []
        for left, text in assignments:
            side = self.left("--start", left)
            name = indexed(side.name, side.index)
            if name not in self.coordinates:
                raise UsageError(unknown("--start", name, list(self.coordinates), "coordinate"))
            if side.order > 1:
                raise UsageError(f"--start {left}: a start is a coordinate or its rate")
            if side.order == order:
                known = self.rates if order else self.coordinates
                index, quantity = known[name + "'" * order]
                found.append((index, self.value("--start", text, quantity.unit, left)))
        return tuple(found)

    def by_key(
        self, parameters: named.Named, values: dict[int, float]
    ) -> dict[tuple[str, int | None], float]:
        """Values of parameters under their names and indices."""
        found = {}
        for item in parameters.declared:
            for flat, x in values.items():
                if item.first <= flat < item.first + item.count:
                    index = None if item.lo is None else item.lo + flat - item.first
                    found[item.quantity.name, index] = x
        return found

    def shown(self, kind: str, name: str) -> Shown:
        """A column, by the index that the driver counts."""
        observed = [q.name for q in named.observed(self.compilation)]
        if kind == "energy":
            return Shown(kind, 0, name)
        if kind == "observed":
            return Shown(kind, observed.index(name), name)
        return Shown(kind, (self.rates if kind == "v" else self.coordinates)[name][0], name)

    def shown_as(self, text: str) -> Shown:
        """`--record`: one of the columns that rows have without it."""
        name = self.flat_name("--record", text.strip())
        observed = [q.name for q in named.observed(self.compilation) if not hidden(q.name)]
        for kind, known in (("q", self.coordinates), ("v", self.rates), ("observed", observed)):
            if name in known:
                return self.shown(kind, name)
        if name == "energy":
            return self.shown(name, name)
        known = [*self.coordinates, *self.rates, *observed, "energy"]
        raise UsageError(unknown("--record", name, known, "column"))

    def left(self, option: str, text: str) -> options_text.LeftSide:
        try:
            return options_text.left_side(text, self.sizes)
        except OptionError as error:
            raise UsageError(f"{option} {text}: {error.text()}") from None

    def flat_name(self, option: str, text: str) -> str:
        side = self.left(option, text)
        return indexed(side.name, side.index) + "'" * side.order


def assignment(option: str, text: str) -> tuple[str, str]:
    left, equal, right = text.partition("=")
    if not (equal and left.strip()):
        raise UsageError(f"{option} {text}: give a name and a value, e.g. {option} g=9.81")
    parts = _NEXT.split(text)
    if len(parts) > 1:
        each = " ".join(f"{option} {part}" for part in parts)
        raise UsageError(f"{option} {text}: one value an option: {each}")
    return left.strip(), right.strip()


def unknown(option: str, name: str, known: Iterable[str], kind: str) -> str:
    """What is said of a name that is not there."""
    who = "there is" if kind in _OF_PKGEN else "the model has"
    return f"{option} {name}: {who} no such {kind}; {near(name, list(known), kind)}"


def near(name: str, known: list[str], kind: str) -> str:
    """Those that may be meant by a wrong name, or else those that there are."""
    they = "there are" if kind in _OF_PKGEN else "it has"
    meant = difflib.get_close_matches(name, known, n=3)
    if meant:
        *most, last = (f"'{one}'" for one in meant)
        return f"did you mean {', '.join(most)}{' or ' if most else ''}{last}?"
    if not known:
        return f"{they} none"
    return f"{they}: {', '.join(known[:12])}{', ...' if len(known) > 12 else ''}"
