"""Computes the starts of a swarm, an ensemble that a scene defines by `swarm k = 1..100000`.

Values that depend on k are arrays with a number per member; other values are computed exactly.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from .. import limits
from ..front.check.scene_numbers import Values
from ..front.check.values import Evaluation, NoValue, evaluate
from ..functions import FUNCTIONS
from ..indices import integer, unrolled
from ..middle.quantities import indexed
from ..model import Model, Scene, Start
from ..run.ensemble import Column, Ensemble
from ..system.exits import UsageError
from ..tree import Expr, Name, names
from .model import of_swarm
from .scene import wrong

Array = np.ndarray | float | tuple


def _started(model: Model, item: Start, index: int | None) -> str:
    """Returns the name of the quantity whose initial value the start statement `item` sets."""
    rate = next((c.rate for c in model.coordinates if c.name == item.name), "")
    return rate if rate and item.order else indexed(item.name, index) + "'" * item.order


def members(
    model: Model, scene: Scene, values: Values, known: Mapping[str, Column], given: Collection[str]
) -> Ensemble:
    """Returns the ensemble that a scene's swarm defines. `known` has the quantities that may differ
    between members and have an effect. `given` has the names of starts that options set to the same
    value in all members."""
    swarm = scene.swarm
    first, last = (integer(end, values.sizes) for end in (swarm.lo, swarm.hi))
    count = np.arange(first, last + 1, dtype=float)
    starts: dict[str, tuple[Start, dict[str, int]]] = {}
    for item in scene.starts:  # a later statement overrides an earlier one
        for index, loop in unrolled(item, values.sizes):
            starts[_started(model, item, index)] = item, loop
    chosen = {
        name: start
        for name, start in starts.items()
        if name in known and name not in given and of_swarm(scene, start[0].value)
    }
    if not chosen:
        why = "all members of the swarm would be the same: --start sets what differs"
        raise wrong(model, scene, swarm.span, why)
    if len(count) * len(chosen) > limits.SWARM_VALUES:
        each = f"{len(count):,} members with {len(chosen):,} starts each"
        why = f"{each}; the limit is {limits.SWARM_VALUES:,} in all"
        raise wrong(model, scene, swarm.span, why)
    of_all = _Members(model, scene, values.values, count)
    rows = np.empty((len(count), len(chosen)))
    for k, start in enumerate(chosen.values()):
        rows[:, k] = of_all.column(*start)
    return Ensemble(
        path=f"{model.source.place(swarm.span)}: scene '{scene.name}'",
        columns=tuple(known[name] for name in chosen),
        lines=range(first, last + 1),
        values=rows,
        counted=swarm.variable,
    )


class Arrays(Evaluation):
    """Evaluates expressions for all values `count` of a variable at once. The value is an array,
    with an element for each, if the variable occurs in the expression, else a number."""

    def __init__(self, values: Mapping, variable: str, count: np.ndarray) -> None:
        super().__init__(values)
        self.variable, self.count = variable, count

    def value(self, expr: Expr, sizes: Mapping[str, int]) -> Array:
        if self.variable not in names(expr):
            found = evaluate(expr, self.values, sizes)
            return tuple(float(x) for x in found) if isinstance(found, tuple) else float(found)
        if not isinstance(expr, Name):
            return super().value(expr, sizes)
        if expr.index is None:
            return self.count
        at = ({**sizes, self.variable: int(k)} for k in self.count)
        return np.array([float(self.values[expr.id, integer(expr.index, x)]) for x in at])

    def added(self, values: Sequence[Array], signs: tuple[int, ...]) -> Array:
        return sum(x if sign > 0 else -x for x, sign in zip(values, signs, strict=True))

    def multiplied(self, values: Sequence[Array], exponents: tuple[int, ...]) -> Array:
        total: Array = 1.0
        for value, exponent in zip(values, exponents, strict=True):
            total = (np.multiply if exponent > 0 else np.divide)(total, value)
        return total

    raised = staticmethod(np.power)

    def called(self, function: str, arguments: list[Array]) -> Array:
        array = FUNCTIONS[function].array
        if callable(array):
            return array(np, *arguments)
        return getattr(np, array or function)(*arguments)


class _Members(Arrays):
    """Evaluates starts for all members of a swarm."""

    def __init__(self, model: Model, scene: Scene, values: Mapping, count: np.ndarray) -> None:
        super().__init__(values, scene.swarm.variable, count)
        self.model, self.scene = model, scene

    def column(self, item: Start, loop: Mapping[str, int]) -> np.ndarray:
        try:
            with np.errstate(all="ignore"):
                found = self.value(item.value, loop)
        except (NoValue, KeyError) as error:
            raise self._wrong(item, str(error)) from None
        found = np.broadcast_to(found, self.count.shape)
        bad = np.flatnonzero(~np.isfinite(found))
        if len(bad):
            k = int(self.count[bad[0]])
            raise self._wrong(item, f"no finite number for {self.variable} = {k}")
        return found

    def _wrong(self, item: Start, why: str) -> UsageError:
        why = f"start {item.name}{item.order * chr(39)}: {why}"
        return wrong(self.model, self.scene, item.value.span, why)
