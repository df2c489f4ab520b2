"""Names and indices of a model's scalar quantities in declaration order. Each member of a family
(an indexed name, such as q[1..N]) is a quantity; its index here is called its flat index."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from ..equations import Declared, Quantity
from ..graph.graph import VARIABLE, Graph, Kind, Node, Symbol
from ..indices import indexed, integer, made_of
from ..model import Coordinate, Input, Model, Parameter, Rotation, State
from ..record import record
from ..source import Diagnostic, ModelError, Span
from ..tree import Range


@record
class Family:
    """A declared name: a scalar (lo is None), or a family NAME[lo..hi]. Member lo has the flat
    index `first`. The flat index of each further member is larger by `step` than that of the member
    before."""

    name: str
    first: int
    lo: int | None
    hi: int | None
    span: Span
    step: int = 1

    @property
    def members(self) -> tuple[int | None, ...]:
        return (None,) if self.lo is None else tuple(range(self.lo, self.hi + 1))

    @property
    def count(self) -> int:
        return 1 if self.lo is None else self.hi - self.lo + 1

    def declared(self, quantity: Quantity) -> Declared:
        return Declared(quantity, self.first, self.lo, self.hi)

    def flat(self, index: int | None) -> int:
        return self.first if self.lo is None else self.first + self.step * (index - self.lo)

    def has(self, index: int | None) -> bool:
        if self.lo is None or index is None:
            return self.lo is None and index is None
        return self.lo <= index <= self.hi


def error(model: Model, message: str, span: Span, help: str = "") -> ModelError:
    return ModelError(model.source, [Diagnostic(message, span, help)])


def too_deep(span: Span) -> tuple[str, Span, str]:
    """Returns the arguments with which error() is called for an expression that is nested too
    deeply for Python's stack."""
    message = "this is too deep: expressions within expressions, once its vectors are written out"
    return message, span, "give parts of it a name by 'let', or use fewer factors"


def has_bodies(model: Model) -> bool:
    return any(item.name.endswith(".velocity") for item in model.definitions)


def smaller(model: Model) -> str:
    """Returns the help text for a model that is too large."""
    bodies = has_bodies(model)
    declared = (*model.coordinates, *model.states)
    if model.sizes or any(item.range is not None for item in declared):
        what = "make its families smaller"
    else:
        what = f"make it of fewer {'bodies' if bodies else 'terms'}"
    return what + ", or name the kernels that you need: --kernels acceleration" * bodies


def refuse_constant(model: Model, g: Graph, events: Iterable[Node]) -> None:
    """Raises ModelError if the expression of an event is constant."""
    for item, node in zip(model.events, events, strict=True):
        if not g.depends[node] & VARIABLE:
            message = f"the event '{item.name}' never happens: its expression is constant"
            raise error(model, message, item.value.span)


def sizes(model: Model) -> dict[str, int]:
    return {size.name: size.value for size in model.sizes}


def families(
    model: Model,
    declarations: tuple[Parameter | Coordinate | State, ...],
    side_by_side: bool = False,
) -> dict[str, Family]:
    """Returns the families by name, with flat indices assigned in order. With `side_by_side`, all
    components of one rotation get consecutive flat indices."""
    parts = [names for r in model.rotations for names in (r.turns, r.quaternion)]
    places = {n: (k, len(names)) for names in parts for k, n in enumerate(names) if side_by_side}
    result: dict[str, Family] = {}
    first = 0
    for item in declarations:
        lo, hi = ends(model, item.range)
        place, step = places.get(item.name, (0, 1))
        made = Family(item.name, first + place, lo, hi, item.span, step)
        first += made.count * step if place == step - 1 else 0
        result[item.name] = made
    return result


def single_rotations(model: Model) -> tuple[Rotation, ...]:
    """Returns all rotations; a family of rotations is split into its members, with names such as
    R[1]."""
    found = []
    for r in model.rotations:
        (family,) = families(model, (r,)).values()
        for i in family.members:
            parts = {k: tuple(indexed(n, i) for n in getattr(r, k)) for k in _NUMBERS}
            found.append(replace(r, name=indexed(r.name, i), range=None, **parts))
    return tuple(found)


_NUMBERS = ("quaternion", "rates", "turns", "momenta")  # fields of Rotation that contain names


def ends(model: Model, range_: Range | None) -> tuple[int | None, int | None]:
    if range_ is None:
        return None, None
    known = sizes(model)
    return integer(range_.lo, known), integer(range_.hi, known)


def quantities(
    declarations: tuple[Coordinate | State, ...],
    found: dict[str, Family],
    form: str,
    unit: str,
    own: str = "",
) -> tuple[Quantity, ...]:
    """Returns a Quantity for each coordinate or state, in the order of flat indices. `own` and
    `unit` are the names of the fields of a declaration that have the name and the unit of the
    Quantity. If the field `own` is empty, the name is the text `form` with the declared name
    inserted."""
    made = {
        found[c.name].flat(i): Quantity(
            indexed(getattr(c, own), i)
            if own and getattr(c, own)
            else made_of(form, indexed(c.name, i)),
            getattr(c, unit),
            c.description,
        )
        for c in declarations
        for i in found[c.name].members
    }
    return tuple(made[k] for k in sorted(made))


def moving(model: Model, rates: bool, states: bool = False) -> list[Declared]:
    """Returns the declared coordinates, with `states` also the states. With `rates`, returns the
    rates and the states instead."""
    declarations = (*model.coordinates, *model.states)
    found = families(model, declarations)
    made = []
    for c in declarations:
        is_state = isinstance(c, State)
        own = "" if is_state else c.rate
        if (is_state and not (rates or states)) or (own and not rates):
            continue
        name, unit = (own or c.name + "'", c.rate_unit) if rates else (c.name, c.unit)
        if is_state:
            name, unit = c.name, c.unit
        made.append(found[c.name].declared(Quantity(name, unit, c.description)))
    return made


def input_quantities(model: Model, orders: tuple[int, ...]) -> tuple[Quantity, ...]:
    """Returns a Quantity for each input, followed by those of its first `order` derivatives."""
    result: list[Quantity] = []
    for item, order in zip(model.inputs, orders, strict=True):
        for k in range(order + 1):
            result.append(Quantity(item.name + "'" * k, _unit(model, item, k), item.description))
    return tuple(result)


def input_index(orders: tuple[int, ...], position: int) -> int:
    """Returns the flat index of the input that is at `position` among the declared inputs."""
    return sum(o + 1 for o in orders[:position])


def _unit(model: Model, item: Input, order: int) -> str:
    if order < len(item.units):
        return item.units[order]
    if model.dimensionless:
        return ""
    return per_second(_unit(model, item, order - 1))


def per_second(unit: str) -> str:
    """Returns a unit divided by a second, as text: "kg*m/s^2" -> "kg*m/s^3"."""
    if below := re.search(r"(?<=/)s(?:\^(\d+))?(?![\w^])", unit):
        return f"{unit[: below.start()]}s^{int(below[1] or 1) + 1}{unit[below.end() :]}"
    if above := re.search(r"(\*|^)s(?:\^(-?\d+))?(?![\w^])", unit):
        left = int(above[2] or 1) - 1
        power = f"{above[1]}s^{left}".removesuffix("^1") if left else ""
        found = (unit[: above.start()] + power + unit[above.end() :]).removeprefix("*")
        return f"1{found}" if found.startswith("/") else found
    return f"{unit or '1'}/s"


def symbols(g: Graph, kind: str, count: int) -> tuple[Node, ...]:
    return tuple(g.symbol(Symbol(kind, i)) for i in range(count))


def rate_of_state(g: Graph, k: int, count: int) -> Node:
    """Returns the symbol of the time derivative of state k; `count` is the number of states."""
    return g.symbol(Symbol(Kind.STATE, count + k))


def block_of(model: Model, name: str) -> str:
    """Returns the sample block that sets an input, or ""."""
    return next((item.by for item in model.inputs if item.name == name), "")
