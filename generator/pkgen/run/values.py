"""Parses values, names and assignments in a model's command line options. Every error is a
UsageError."""

from __future__ import annotations

import argparse
import math
import re
import sys
from fractions import Fraction

from ..compiler import Compilation
from ..defaults import wrong_rtol
from ..front.check import options_text
from ..front.check.options_text import OptionError
from ..front.check.scene_numbers import within_bounds
from ..indices import hidden, indexed, parted
from ..middle.quantities import block_of, single_rotations
from ..model import Model, Parameter
from ..plan import DEFAULTS, RunNumbers
from ..system.exits import UsageError
from ..system.near import unknown
from . import named
from .named import columns
from .settings import Shown

_NEXT = re.compile(r",\s*(?=[A-Za-z_]\w*(?:\[[^\]]*\])?'*\s*=)")


class Numbers:
    """Parser of option values for one model, with its units and sizes."""

    def __init__(self, model: Model):
        self.model = model
        self.sizes = {size.name: size.value for size in model.sizes}
        self.time = "" if model.dimensionless else "s"

    def value(self, option: str, text: str, unit: str, name: str) -> float:
        try:
            found = options_text.quantity(
                text, unit, dimensionless=self.model.dimensionless, values=self.sizes, name=name
            )
        except OptionError as error:
            given = text if option == f"--{name}" else f"{name}={text}"
            raise UsageError(f"{option} {given}: {error.text()}") from None
        if not math.isfinite(found):
            raise UsageError(f"{option} {text}: {name} must be finite")
        return self.kept(found)

    def kept(self, found: Fraction | float) -> float:
        """Converts the value of an option to a float. A subclass may return the exact value."""
        return float(found)

    def positive(self, option: str, text: str | None, unit: str) -> float | None:
        if text is None:
            return None
        name = option.removeprefix("--")
        found = self.value(option, text, unit, name)
        if not found > 0:
            raise UsageError(f"{option} {text}: {name} must be positive")
        return found

    def of_run(self, options: argparse.Namespace) -> RunNumbers:
        """Parses the options of a run that are numbers, such as --until. Raises UsageError."""
        given = {}
        for name in vars(DEFAULTS):
            unit = "" if name in ("rtol", "atol") else self.time
            option = f"--{name.replace('_', '-')}"
            given[name] = self.positive(option, getattr(options, name), unit)
        found = RunNumbers(**given)
        if found.rtol is not None and found.atol is None and (wrong := wrong_rtol(found.rtol)):
            raise UsageError(f"--rtol {options.rtol}: {wrong}")
        return found

    def left(self, option: str, text: str) -> options_text.LeftSide:
        try:
            return options_text.left_side(text, self.sizes)
        except OptionError as error:
            raise UsageError(f"{option} {text}: {error.text()}") from None

    def flat_name(self, option: str, text: str) -> str:
        return self.left(option, text).text()


class Values(Numbers):
    """Parser of option values for one compiled model, including its names."""

    def __init__(self, compilation: Compilation):
        super().__init__(compilation.model)
        self.compilation = compilation
        self.coordinates = named.coordinates(compilation)
        self.rates = named.coordinates(compilation, rates=True)

    def unread(self, name: str) -> Parameter | None:
        """Returns the parameter `name` if the scene removed it from the model, else None."""
        if name not in self.compilation.report.unused:
            return None
        parameters = self.compilation.declared.parameters
        return next((p for p in parameters if p.name == parted(name)[0]), None)

    def assigned(self, sets: list[tuple[str, str]]) -> tuple[dict[int, float], dict[int, float]]:
        """Returns the values that `--set` gives to parameters and to inputs, by flat index, without
        parameters that the scene removed; checks the values of those."""
        kinds = named.parameters(self.compilation), named.inputs(self.compilation)
        found: tuple[dict[int, float], dict[int, float]] = {}, {}
        for left, text in sets:
            name = self.flat_name("--set", left)
            if (gone := self.unread(name)) is not None:
                value = self.value("--set", text, gone.unit, name)
                if not within_bounds(self.compilation.declared, gone, parted(name)[1], value):
                    raise UsageError(f"--set {name}={text}: outside its bounds: {name}")
                continue
            k = next((k for k, known in enumerate(kinds) if name in known), None)
            if k is None:
                known = [*kinds[0], *kinds[1]]
                raise UsageError(unknown("--set", name, known, "parameter or input"))
            if by := block_of(self.compilation.model, name):
                raise UsageError(f"--set {name}: the sample block '{by}' sets it")
            index, quantity = kinds[k][name]
            found[k][index] = self.value("--set", text, quantity.unit, name)
        return found

    def starts(
        self, given: list[str]
    ) -> tuple[dict[int, float], dict[int, float], dict[int, float]]:
        """Returns the values that `--start` gives, by flat index: to coordinates, to rates, and to
        starts that became parameters."""
        report = self.compilation.report
        parameters = named.parameters(self.compilation)
        declared = named.declared(self.compilation)
        found, of_parameters = ({}, {}), {}
        for text in given:
            left, value = assignment("--start", text)
            side = self.left("--start", left)
            name = indexed(side.name, side.index)
            if side.order > 1:
                raise UsageError(f"--start {left}: a start is a coordinate or its rate")
            if (name, side.order) in report.starts:
                index, quantity = parameters[report.starts[name, side.order]]
                of_parameters[index] = self.value("--start", value, quantity.unit, left)
            elif side.order and name in named.states(self.compilation):
                raise UsageError(
                    f"--start {left}: {name} is a state, and its rate follows: --start {name}=…"
                )
            elif name in self.coordinates or name in self.rates:  # states are in `rates`
                order = side.order or int(name not in self.coordinates)
                among = self.rates if order else self.coordinates
                if not order:
                    named.refuse_place(self.compilation, name)
                index, quantity = among[name + "'" * side.order]
                found[order][index] = self.value("--start", value, quantity.unit, left)
            elif name in (numbers := self._numbers_of_rotations()):
                each = ", ".join(numbers[name])
                raise UsageError(f"--start {left}: one number an option, of {each}")
            elif name not in declared:
                raise UsageError(unknown("--start", name, list(declared), "coordinate"))
            elif name not in report.unused:
                raise UsageError(
                    f"--start {left}: the scene holds {name}; change what it is held at"
                )
        return *found, of_parameters

    def _numbers_of_rotations(self) -> dict[str, tuple[str, ...]]:
        """Returns, for each rotation and for its body rates omega(...), the names of the single
        numbers by which --start sets their initial value."""
        rotations = single_rotations(self.compilation.declared)
        found = {r.name: r.quaternion for r in rotations}
        return found | {f"omega({r.name})": r.rates for r in rotations}

    def shown(self, name: str, option: str = "--record") -> Shown:
        """Returns the column with the name `name` as the runtime identifies it: by kind and index.
        Raises UsageError."""
        kinds = named.kinds(self.compilation)
        for kind, known in kinds.items():
            if name in known:
                return Shown(kind, known[name][0], name)
        columns = [c for known in kinds.values() for c in known if not hidden(c)]
        raise UsageError(unknown(option, name, columns, "column"))

    def standard(self) -> list[Shown]:
        """Returns the default columns of a model with rotations, in the order of declarations."""
        names = [column.name for column in columns(self.compilation, listed=sys.maxsize)[1:]]
        places = named.places(self.compilation)
        return [self.shown(name) for name in sorted(names, key=lambda n: places.get(n, (2, 0)))]


def assignment(option: str, text: str) -> tuple[str, str]:
    left, equal, right = text.partition("=")
    if not (equal and left.strip()):
        raise UsageError(f"{option} {text}: give a name and a value, e.g. {option} g=9.81")
    parts = _NEXT.split(text)
    if len(parts) > 1:
        each = " ".join(f"{option} {part}" for part in parts)
        raise UsageError(f"{option} {text}: one value an option: {each}")
    return left.strip(), right.strip()
