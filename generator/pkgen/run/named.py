"""The quantities of a compiled model by name. Families, maybe of millions, are not listed."""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Iterator, Mapping

from ..compiler import Compilation
from ..equations import Declared, Quantity
from ..graph.graph import BIT, Kind
from ..indices import hidden, parted
from ..middle.quantities import moving, single_rotations
from ..system.exits import UsageError
from .settings import Shown

LISTED = 10_000  # largest family whose members are described singly
SUGGESTED = 12  # most members of a family that a hint in a message considers


class Named:
    """Maps a name to (flat index, quantity). Iterates over only a few members of each family."""

    def __init__(self, declared: list[Declared]):
        self.declared = declared
        self._by_name = {d.quantity.name: d for d in declared}

    def find(self, name: str) -> tuple[Declared, int | None] | None:
        """Returns the declaration that contains the quantity `name`, and the index if the quantity
        is a member of a family. Returns None if the name is unknown."""
        for base, index in ((name, None), parted(name)):
            found = self._by_name.get(base)
            one = found is not None and found.lo is None and index is None
            if one or (found and None not in (found.lo, index) and found.lo <= index <= found.hi):
                return found, index
        return None

    def __contains__(self, name: str) -> bool:
        return self.find(name) is not None

    def __getitem__(self, name: str) -> tuple[int, Quantity]:
        found = self.find(name)
        if found is None:
            raise KeyError(name)
        declared, index = found
        flat = declared.first + (0 if index is None else index - declared.lo)
        return flat, declared.member(index)

    def place(self, flat: int) -> tuple[int, int]:
        """Returns the index of the declaration that contains the quantity with this flat index, and
        the 0-based index of the quantity in its family."""
        k = bisect(self.declared, flat, key=lambda item: item.first) - 1
        return k, flat - self.declared[k].first

    def __iter__(self) -> Iterator[str]:
        for item in self.declared:
            yield from (quantity.name for quantity in item.members(SUGGESTED + 1))

    def names(self) -> Iterator[str]:
        """Yields all names, including those of all members of families."""
        return (quantity.name for item in self.declared for quantity in item.members())

    @property
    def count(self) -> int:
        return sum(item.count for item in self.declared)

    def columns(self, most: int) -> list[Quantity]:
        """Returns a quantity per column; a family of more than `most` members has one, q[1..N]."""
        found = []
        for item in self.declared:
            if item.count > most:
                found.append(item.member(f"{item.lo}..{item.hi}"))  # type: ignore[arg-type]
            else:
                found += item.members()
        return found


def coordinates(compilation: Compilation, rates: bool = False) -> Named:
    """Returns the coordinates of the equations, which a scene may have reduced. With `rates`,
    returns their rates followed by the states: this is the order of v in C and in every row."""
    return Named(compilation.equations.listed("v" if rates else "q"))


def declared(compilation: Compilation) -> Named:
    """Returns the coordinates and states that the model declares."""
    return Named(moving(compilation.declared, False, states=True))


def states(compilation: Compilation) -> frozenset[str]:
    """Returns the names of the states that remain after a scene's reductions."""
    return frozenset(state.name for state in compilation.equations.states)


def refuse_place(compilation: Compilation, left: str) -> None:
    """Raises UsageError if rates at the start follow from momenta and positions, since a start of a
    position alone would leave the rates as they are."""
    e = compilation.equations
    if e.model.hamiltonian and any(e.graph.depends[p] & BIT[Kind.COORDINATE] for p in e.momenta):
        why = "at the start rates follow from momenta and positions"
        raise UsageError(f"{left}: {why}: set it by 'start {left} = …' in a scene of its own")


def places(compilation: Compilation) -> dict[str, tuple[int, tuple[int, ...]]]:
    """Returns keys by which names are sorted: coordinates and rotations come first, then rates,
    each in the order of declarations. The components of a quaternion come where its rotation is
    declared, although they are states."""
    model, e = compilation.declared, compilation.equations
    order = model.source.order
    spans = {item.name: order(item.span.start) for item in model.coordinates}
    found = {}
    for q, rate in zip(e.coordinates, e.rates, strict=True):
        start = spans[parted(q.name)[0]]
        found |= {q.name: (0, start), rate.name: (1, start)}
    for rotation in single_rotations(model):
        found |= dict.fromkeys(rotation.quaternion, (0, order(rotation.span.start)))
    return found


def parameters(compilation: Compilation) -> Named:
    """Returns the parameters by name, each with its flat index. place() converts a flat index to
    an index of the declaration and, in a family kept for any length, an index of the member."""
    return Named(compilation.program.equations.listed("param"))


def bounds(compilation: Compilation, name: str) -> tuple[float, float]:
    """Returns the bounds of a parameter. A bound that is no number in the model is infinite."""
    e = compilation.equations
    slot = e.parameters[parameters(compilation)[name][0]]
    low, high = (None if x is None else e.graph.value(x) for x in (slot.lo, slot.hi))
    return -math.inf if low is None else float(low), math.inf if high is None else float(high)


def events(compilation: Compilation) -> list[str]:
    """Returns the names of the events that a run detects, by their numbers. Those of contacts
    alone begin with a digit."""
    return [q.name for q in compilation.equations.event_names]


def inputs(compilation: Compilation) -> Named:
    return Named(Declared.each(compilation.equations.inputs))


def observed(compilation: Compilation) -> list[Quantity]:
    """Returns all outputs, including each member of a family, in the order of C."""
    return [quantity for item in outputs(compilation).declared for quantity in item.members()]


def outputs(compilation: Compilation) -> Named:
    return Named(compilation.equations.listed("observed"))


def kinds(compilation: Compilation) -> dict[str, Named]:
    """Returns the columns of rows in order, keyed by the runtime's name of their kind."""
    unit = "" if compilation.model.dimensionless else "J"
    energy = [Quantity("energy", unit, "q'.dL/dq' - L")] if compilation.equations.has_energy else []
    return {
        "q": coordinates(compilation),
        "v": coordinates(compilation, rates=True),
        "observed": outputs(compilation),
        "energy": Named(Declared.each(energy)),
    }


def units(compilation: Compilation, *more: Named) -> dict[str, str]:
    """Returns the units of columns without t, of inputs and of `more` quantities, by name."""
    found = [*kinds(compilation).values(), inputs(compilation), *more]
    return {item.quantity.name: item.quantity.unit for of in found for item in of.declared}


def by_key(parameters: Named, values: Mapping[int, float]) -> dict[tuple[str, int | None], float]:
    """Converts values of parameters by flat index to values by (name, index in the family)."""
    found = {}
    for flat, x in values.items():
        k, position = parameters.place(flat)
        item = parameters.declared[k]
        index = None if item.lo is None else item.lo + position
        found[parted(item.member(index).name)] = x
    return found


def columns(
    compilation: Compilation, show: tuple[Shown, ...] = (), listed: int = LISTED
) -> list[Quantity]:
    """Returns the CSV columns in order; a family of more than `listed` members has only one."""
    time = Quantity("t", "" if compilation.model.dimensionless else "s", "time")
    by_kind = kinds(compilation)
    if show:
        rows = [by_kind[c.kind][c.name][1] for c in show]
    else:
        rows = [c for kind in by_kind.values() for c in kind.columns(listed) if not hidden(c.name)]
    return [time, *rows]
