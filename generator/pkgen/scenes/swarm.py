"""`swarm k = 1..100000` in a scene: the starts of all members, computed at once.

Values that use k are arrays, one number a member; the rest is computed as everywhere, exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

import numpy as np

from .. import limits
from ..front.check.scene_numbers import Values
from ..front.check.values import NoValue, evaluate
from ..functions import FUNCTIONS
from ..indices import assignments, integer
from ..middle.quantities import indexed
from ..model import Model, Scene, Start
from ..record import record
from ..run.ensemble import Column, Ensemble
from ..system.exits import UsageError
from ..tree import Add, Call, Component, Expr, Multiply, Name, Negate, Power, Sum, Vector, names
from .model import of_swarm
from .scene import place

Array = np.ndarray | float | tuple


def _started(model: Model, item: Start, index: int | None) -> str:
    """What starts: a body rate has a name of its own."""
    rate = next((c.rate for c in model.coordinates if c.name == item.name), "")
    return rate if rate and item.order else indexed(item.name, index) + "'" * item.order


def members(
    model: Model, scene: Scene, values: Values, known: Mapping[str, Column], given: Collection[str]
) -> Ensemble:
    """The members of a scene's swarm. `known` is what a member may set: of starts that influence
    nothing there is none. `given` are starts that options set for all."""
    swarm = scene.swarm
    first, last = (integer(end, values.sizes) for end in (swarm.lo, swarm.hi))
    count = np.arange(first, last + 1, dtype=float)
    starts: dict[str, tuple[Start, dict[str, int]]] = {}
    for item in scene.starts:  # the last one counts
        for loop, index in _unrolled(item, values.sizes):
            starts[_started(model, item, index)] = item, loop
    chosen = {
        name: start
        for name, start in starts.items()
        if name in known and name not in given and of_swarm(scene, start[0].value)
    }
    if not chosen:
        raise UsageError(
            f"{place(model, swarm.span)}: scene '{scene.name}': all members of the swarm would be "
            "the same: --start sets what differs"
        )
    if len(count) * len(chosen) > limits.SWARM_VALUES:
        raise UsageError(
            f"{place(model, swarm.span)}: scene '{scene.name}': {len(count):,} members with "
            f"{len(chosen):,} starts each; the limit is {limits.SWARM_VALUES:,} in all"
        )
    rows = np.empty((len(count), len(chosen)))
    for k, (item, loop) in enumerate(chosen.values()):
        x = _Members(model, scene, values.values, loop, swarm.variable, count)
        rows[:, k] = x.column(item)
    return Ensemble(
        path=f"{place(model, swarm.span)}: scene '{scene.name}'",
        columns=tuple(known[name] for name in chosen),
        lines=range(first, last + 1),
        values=rows,
        counted=swarm.variable,
    )


def _unrolled(item: Start, sizes: Mapping[str, int]):
    if item.range is None:
        yield dict(sizes), None if item.index is None else integer(item.index, sizes)
        return
    for loop in assignments((item.range,), sizes):
        yield loop, loop[item.range.variable]


@record
class _Members:
    """Expressions for all members: a number where k does not occur, else an array."""

    model: Model
    scene: Scene
    values: Mapping[object, object]
    loop: Mapping[str, int]
    variable: str
    count: np.ndarray

    def column(self, item: Start) -> np.ndarray:
        try:
            with np.errstate(all="ignore"):
                found = self.value(item.value, self.loop)
        except (NoValue, KeyError) as error:
            raise self._wrong(item, str(error)) from None
        found = np.broadcast_to(found, self.count.shape)
        bad = np.flatnonzero(~np.isfinite(found))
        if len(bad):
            k = int(self.count[bad[0]])
            raise self._wrong(item, f"no finite number for {self.variable} = {k}")
        return found

    def _wrong(self, item: Start, why: str) -> UsageError:
        at = place(self.model, item.value.span)
        name = item.name + "'" * item.order
        return UsageError(f"{at}: scene '{self.scene.name}': start {name}: {why}")

    def value(self, expr: Expr, loop: Mapping[str, int]) -> Array:
        if self.variable not in names(expr):
            found = evaluate(expr, self.values, loop)
            return tuple(float(x) for x in found) if isinstance(found, tuple) else float(found)
        match expr:
            case Name(index=None):
                return self.count
            case Name(id=name, index=index):
                at = ({**loop, self.variable: int(k)} for k in self.count)
                return np.array([float(self.values[name, integer(index, x)]) for x in at])
            case Negate(of=of):
                return _each(lambda x: -x, self.value(of, loop))
            case Add(terms=terms, signs=signs):
                total: Array = 0.0
                for term, sign in zip(terms, signs, strict=True):
                    total = _each(
                        lambda a, b, sign=sign: a + sign * b, total, self.value(term, loop)
                    )
                return total
            case Multiply(factors=factors, exponents=exponents):
                total = 1.0
                for factor, exponent in zip(factors, exponents, strict=True):
                    by = np.multiply if exponent > 0 else np.divide
                    total = _each(by, total, self.value(factor, loop))
                return total
            case Power(base=base, exponent=exponent):
                return np.power(self.value(base, loop), self.value(exponent, loop))
            case Vector(items=items):
                return tuple(self.value(x, loop) for x in items)
            case Component(of=of, axis=axis):
                return self.value(of, loop)[axis]
            case Sum(body=body, ranges=ranges):
                terms = (self.value(body, inner) for inner in assignments(ranges, loop))
                return sum(terms, np.zeros(len(self.count)))
            case Call(function=function, arguments=arguments):
                return _called(function, [self.value(x, loop) for x in arguments])
        raise NoValue("not a number")


def _rotated(axis: tuple, angle: Array, vector: tuple) -> tuple:
    """As in middle/expand/terms.py."""
    length = _FUNCTIONS["norm"](axis)
    n = tuple(x / length for x in axis)
    c, s = np.cos(angle), np.sin(angle)
    along = (1 - c) * _FUNCTIONS["dot"](n, vector)
    turned = _FUNCTIONS["cross"](n, vector)
    return tuple(c * x + s * y + along * z for x, y, z in zip(vector, turned, n, strict=True))


_FUNCTIONS: dict[str, Callable] = {
    "dot": lambda a, b: sum(x * y for x, y in zip(a, b, strict=True)),
    "norm": lambda a: np.sqrt(sum(x * x for x in a)),
    "cross": lambda a, b: tuple(a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))),
    "rotate": _rotated,
}


def _called(function: str, arguments: list[Array]) -> Array:
    if function in _FUNCTIONS:
        return _FUNCTIONS[function](*arguments)
    array = FUNCTIONS[function].array
    if callable(array):
        return array(np, *arguments)
    return getattr(np, array or function)(*arguments)


def _each(operation: Callable, *arguments: Array) -> Array:
    """Applies an operation to each component where there are vectors."""
    if not any(isinstance(a, tuple) for a in arguments):
        return operation(*arguments)
    rows = ([a[i] if isinstance(a, tuple) else a for a in arguments] for i in range(3))
    return tuple(operation(*row) for row in rows)
